//! Set-points over time, read from the experiment that a recording carries.

use recording::Recording;

/// A temperature that an element has to hold for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct SetPoint {
    pub element: String,
    pub from_s: f64,
    /// Infinite for the last one.
    pub to_s: f64,
    pub celsius: f64,
}

impl SetPoint {
    /// The constant set-points of a recording. Changes after `tripped_s` were never made.
    pub fn of(recording: &Recording, tripped_s: f64) -> Vec<Self> {
        recording.metadata("experiment").map_or_else(Vec::new, |text| Self::of_experiment(text, tripped_s))
    }

    fn of_experiment(text: &str, tripped_s: f64) -> Vec<Self> {
        let Ok(table) = text.parse::<toml::Table>() else { return Vec::new() };
        let mut set_points: Vec<Self> = Vec::new();
        let first = table.get("drives").and_then(toml::Value::as_table).map(|drives| (0.0, drives));
        let changes = table.get("changes").and_then(toml::Value::as_array).into_iter().flatten();
        let changes =
            changes.filter_map(|change| Some((number(change.get("start_s")?)?, change.get("drives")?.as_table()?)));
        for (from_s, drives) in first.into_iter().chain(changes.filter(|(from_s, _)| *from_s <= tripped_s)) {
            for (element, drive) in drives {
                // Whatever it has to do now, what it had to do before is over.
                for before in set_points.iter_mut().filter(|before| before.element == *element) {
                    before.to_s = before.to_s.min(from_s);
                }
                if let Some(celsius) = drive.get("temperature_c").and_then(number) {
                    set_points.push(Self { element: element.clone(), from_s, to_s: f64::INFINITY, celsius });
                }
            }
        }
        set_points
    }

    /// Rows in which the element holds it: from its arrival there, from below or above, until the
    /// next change.
    ///
    /// Warming up is another story, and so is cooling down after a trip.
    pub fn rows_held(&self, time_s: &[f64], temperature_c: &[f64], running_until: usize) -> std::ops::Range<usize> {
        // A change belongs to the tick that starts with it, whatever the last digits of its time.
        let row_at = |moment_s: f64| time_s.partition_point(|row_s| *row_s < moment_s - 1e-6);
        let (from, to) = (row_at(self.from_s), row_at(self.to_s).min(running_until));
        let rows = temperature_c.get(from..to).unwrap_or_default();
        let from_below = rows.iter().find(|celsius| celsius.is_finite()).is_some_and(|celsius| *celsius < self.celsius);
        let there = |celsius: &f64| if from_below { *celsius >= self.celsius } else { *celsius <= self.celsius };
        rows.iter().position(there).map_or(to, |row| from + row)..to
    }
}

/// A number of a TOML file, which may be written without a decimal point.
pub fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPERIMENT: &str = r#"
[drives]
boom = { temperature_c = 28.5 }
die = { temperature_c = 40 }
core = "passive"

[[changes]]
start_s = 100.0
drives = { boom = { temperature_c = 25.0 }, core = { temperature_c = 20.0 } }

[[changes]]
start_s = 200.0
drives = { boom = "passive" }
"#;

    fn set_point(element: &str, from_s: f64, to_s: f64, celsius: f64) -> SetPoint {
        SetPoint { element: element.to_owned(), from_s, to_s, celsius }
    }

    #[test]
    fn a_change_ends_one_set_point_and_begins_another() {
        assert_eq!(
            SetPoint::of_experiment(EXPERIMENT, f64::INFINITY),
            [
                set_point("boom", 0.0, 100.0, 28.5),
                set_point("die", 0.0, f64::INFINITY, 40.0),
                set_point("boom", 100.0, 200.0, 25.0),
                set_point("core", 100.0, f64::INFINITY, 20.0),
            ]
        );
    }

    #[test]
    fn changes_after_a_trip_count_for_nothing() {
        assert_eq!(
            SetPoint::of_experiment(EXPERIMENT, 50.0),
            [set_point("boom", 0.0, f64::INFINITY, 28.5), set_point("die", 0.0, f64::INFINITY, 40.0)]
        );
        assert!(SetPoint::of_experiment("no toml", 0.0).is_empty());
    }
}
