//! Keys of a calibration as a head file writes them: today's names, or those from before version
//! 0.2.

use std::ops::RangeInclusive;

use recording::toml_file::{FileError, TomlSource};

/// Today's key and the old one.
const RENAMED: [(&str, &str); 4] =
    [("surfaces", "parts"), ("self_heating", "own"), ("cross_heating", "cross"), ("quiescent_w_k", "windless_w_k")];

/// Refusals by key and line; keys are given as today's, and reported as the file has them.
#[derive(Clone, Copy)]
pub struct CalibrationKeys<'a>(pub &'a TomlSource);

impl CalibrationKeys<'_> {
    /// As [`TomlSource::refuse`].
    pub fn refuse(&self, key: &str, sentence: impl AsRef<str>) -> FileError {
        self.0.refuse(&self.written(key), sentence)
    }

    /// As [`TomlSource::within`].
    pub fn within(&self, key: &str, value: f64, range: RangeInclusive<f64>, unit: &str) -> Result<f64, FileError> {
        if range.contains(&value) { Ok(value) } else { self.0.within(&self.written(key), value, range, unit) }
    }

    /// Passes a value above zero and at most so great.
    pub fn positive_to(&self, key: &str, value: f64, most: f64, unit: &str) -> Result<f64, FileError> {
        if value.is_finite() && value > 0.0 {
            return self.within(key, value, 0.0..=most, unit);
        }
        self.0.positive(&self.written(key), value, unit)
    }

    /// Heading of an array of tables, such as `[[calibration.self_heating]]`.
    pub fn heading(&self, key: &str) -> String {
        format!("[[{}]]", self.written(&format!("calibration.{key}")))
    }

    /// The key as the file has it.
    fn written(&self, key: &str) -> String {
        let document = toml::from_str::<toml::Value>(&self.0.text).ok();
        let mut table = document.as_ref();
        let mut steps = Vec::new();
        for step in key.split('.') {
            let (name, index) = step.split_at(step.find('[').unwrap_or(step.len()));
            let old = RENAMED.iter().find(|(new, _)| *new == name).map(|(_, old)| *old);
            let has = |name: &str| table.is_some_and(|table| table.get(name).is_some());
            let name = old.filter(|old| has(old)).unwrap_or(name);
            steps.push(format!("{name}{index}"));
            table = table.and_then(|table| table.get(name));
            if let Ok(index) = index.trim_matches(['[', ']']).parse::<usize>() {
                table = table.and_then(|array| array.get(index));
            }
        }
        steps.join(".")
    }
}
