//! A head with high currents that were measured, its file otherwise as it is.

use dr_core::sensor::Level;
use recording::toml_file::FileError;
use toml::de::{DeTable, DeValue};

use super::file::Head;

use crate::current_ratio::CurrentRatioError;

/// Significant digits of a current that is written; f32 has seven.
const DIGITS: usize = 9;

impl Head {
    /// The same head with the high currents that go with these errors of their ratios, one an
    /// element in the head's order; an element without one keeps what it has.
    ///
    /// Its own `current_high_a` stands below the element's name from then on, with the uncertainty
    /// as a comment, and as `current_high_nominal_a` what the source was made for.
    ///
    /// # Errors
    /// If the file with these currents makes no head.
    pub fn with_current_ratios(&self, errors: &[Option<CurrentRatioError>]) -> Result<Head, FileError> {
        let mut source = self.source.clone();
        // From the last element on: places before a change stay.
        for (place, error) in errors.iter().enumerate().rev() {
            if let (Some(error), Some(element)) = (error, self.elements.get(place)) {
                let high_a = decimal(element.config.channel.current_a(Level::High));
                let (corrected_a, nominal_a) = (error.corrected_a(high_a), element.nominal.current_high_a);
                let keys = [("current_high_a", rounded(corrected_a)), ("current_high_nominal_a", rounded(nominal_a))];
                let before_ppm = 1e6 * (high_a / nominal_a - 1.0);
                source.text = with_keys(&source.text, place, &keys, &comment(error, before_ppm));
            }
        }
        Head::from_source(source)
    }
}

/// Comment on a measurement; where an earlier measurement is in the file already, that of both, as
/// the number beside it is.
fn comment(error: &CurrentRatioError, before_ppm: f64) -> String {
    let CurrentRatioError { error_ppm, error_u_ppm, .. } = error;
    let measured = |ppm: f64| {
        format!("  # measured: {ppm:+.1} ppm of the ratio high/low, standard uncertainty {error_u_ppm:.1} ppm")
    };
    // An f32 has its current to a tenth of a ppm.
    if before_ppm.abs() < 0.2 {
        return measured(*error_ppm);
    }
    let both_ppm = 1e6 * ((1.0 + 1e-6 * before_ppm) * (1.0 + 1e-6 * error_ppm) - 1.0);
    format!("{}; {before_ppm:+.1} ppm before, {error_ppm:+.1} ppm since", measured(both_ppm))
}

/// The number that a file had: of an f32 the shortest decimal.
fn decimal(current_a: f32) -> f64 {
    current_a.to_string().parse().unwrap_or(f64::from(current_a))
}

fn rounded(current_a: f64) -> f64 {
    format!("{current_a:.*e}", DIGITS - 1).parse().unwrap_or(current_a)
}

/// The text with these keys in table number `place` of the elements, behind its name.
fn with_keys(text: &str, place: usize, keys: &[(&str, f64); 2], comment: &str) -> String {
    let mut text = text.to_owned();
    for (key, _) in keys {
        // A value that is there goes with its line; a table within one line keeps it, with another
        // number.
        if let Some((start, end)) = span(&text, place, key)
            && text[start..].starts_with(key)
            && line_start(&text, start) == start
        {
            let end = text[end..].find('\n').map_or(text.len(), |more| end + more + 1);
            text.replace_range(start..end, "");
        }
    }
    let Some((start, end)) = span(&text, place, "name") else { return text };
    if text[line_start(&text, start)..start].trim().is_empty() {
        let end = text[end..].find('\n').map_or(text.len(), |more| end + more);
        let lines = format!("\n{} = {:?}{comment}\n{} = {:?}", keys[0].0, keys[0].1, keys[1].0, keys[1].1);
        text.insert_str(end, &lines);
        return text;
    }
    for (key, current_a) in keys {
        match span(&text, place, key) {
            Some((start, end)) => text.replace_range(start..end, &format!("{key} = {current_a:?}")),
            None => text.insert_str(end, &format!(", {key} = {current_a:?}")),
        }
    }
    text
}

/// From the begin of an element's key to the end of its value.
fn span(text: &str, place: usize, key: &str) -> Option<(usize, usize)> {
    let document = DeTable::parse(text).ok()?;
    let DeValue::Array(elements) = document.get_ref().get("elements")?.get_ref() else { return None };
    let (key, value) = elements.get(place)?.get_ref().as_table()?.get_key_value(key)?;
    Some((key.span().start, value.span().end))
}

fn line_start(text: &str, place: usize) -> usize {
    text[..place].rfind('\n').map_or(0, |end| end + 1)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use recording::toml_file::TomlSource;

    use super::*;

    const OFF: CurrentRatioError = CurrentRatioError { error_ppm: 1000.0, error_u_ppm: 0.8, ticks: 60_000 };

    fn sphere_b() -> Head {
        Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-b.toml")).unwrap()
    }

    fn high_a(head: &Head, place: usize) -> (f64, f64) {
        let element = &head.elements[place];
        (f64::from(element.config.channel.current_a(Level::High)), element.nominal.current_high_a)
    }

    #[test]
    fn a_measured_current_is_the_controllers_and_the_nominal_one_the_simulations() {
        let head = sphere_b().with_current_ratios(&[None, Some(OFF), None]).unwrap();
        assert_eq!(high_a(&head, 0), (f64::from(0.016_f32), 0.016));
        let (measured, nominal) = high_a(&head, 1);
        assert_eq!(nominal, 0.016);
        // A current of the controller is an f32.
        assert!((measured / 0.016016 - 1.0).abs() < 1e-7, "{measured}");
        let text = &head.source.text;
        assert!(text.contains("name = \"sector2\"\ncurrent_high_a = 0.016016 "), "{text}");
        assert!(text.contains("standard uncertainty 0.8 ppm\ncurrent_high_nominal_a = 0.016\nkind"), "{text}");
    }

    #[test]
    fn measured_again_the_errors_multiply_and_the_keys_stand_once() {
        let once = sphere_b().with_current_ratios(&[Some(OFF); 6]).unwrap();
        let twice = once.with_current_ratios(&[Some(OFF); 6]).unwrap();
        let (measured, nominal) = high_a(&twice, 5);
        assert!((measured / (0.016 * 1.001 * 1.001) - 1.0).abs() < 2e-7 && nominal == 0.016, "{measured}");
        assert_eq!(once.source.text.lines().count(), twice.source.text.lines().count());
        let said =
            "+2001.0 ppm of the ratio high/low, standard uncertainty 0.8 ppm; +1000.0 ppm before, +1000.0 ppm since\n";
        assert!(twice.source.text.contains(said), "{}", twice.source.text);
    }

    #[test]
    fn elements_within_one_line_stay_there() {
        let text = sphere_b().source.text;
        let (before, _) = text.split_once("[[elements]]").unwrap();
        let line = "elements = [{ name = \"a\", kind = \"core\" }, { name = \"b\", current_high_a = 0.015, kind = \"core\" }]\n";
        let source = TomlSource { path: "one.toml".into(), text: format!("{line}{before}") };
        let head = Head::from_source(source).unwrap().with_current_ratios(&[Some(OFF); 2]).unwrap();
        assert!((high_a(&head, 0).0 / 0.016016 - 1.0).abs() < 1e-7);
        assert!((high_a(&head, 1).0 / 0.015015 - 1.0).abs() < 1e-7 && high_a(&head, 1).1 == 0.015);
    }
}
