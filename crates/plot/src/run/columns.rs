//! Parts of a recording: vectors of columns, stretches of rows, rows that count, set-points of the
//! experiment that it carries.
//!
//! Histograms count the wind estimates that the summary of `anemo wind` counts. Both leave out rows
//! before `counted_from_s`, and the first `settle_s` of every label; the file of the estimates has
//! both numbers among its metadata. A label begins here with its first estimate, in the summary
//! with its first tick: at most one output interval before.

use recording::{ColumnWords, Recording};

/// The components of a vector, row by row.
#[derive(Debug, Clone, Copy)]
pub struct VectorColumns<'r>(pub [&'r [f64]; 3]);

impl<'r> VectorColumns<'r> {
    /// None where one of these columns is missing.
    pub fn of(recording: &'r Recording, names: [&str; 3]) -> Option<Self> {
        let [x, y, z] = names.map(|name| recording.numbers(name).ok());
        Some(Self([x?, y?, z?]))
    }

    pub fn at(&self, row: usize) -> [f64; 3] {
        self.0.map(|component| component[row])
    }
}

/// First row, row after the last, and word of the stretches of a column; none without a column.
pub fn stretches(words: Option<&ColumnWords>) -> Vec<(usize, usize, &str)> {
    words.map_or_else(Vec::new, |words| words.stretches().collect())
}

/// Tells whether the row of an estimate counts, for every row of a recording; without such metadata
/// all do.
pub fn counted(recording: &Recording, time_s: &[f64]) -> Vec<bool> {
    let number = |key| recording.metadata(key).and_then(|text| text.parse::<f64>().ok()).unwrap_or(0.0);
    let (from_s, settle_s) = (number("counted_from_s"), number("settle_s"));
    let mut counts: Vec<bool> = time_s.iter().map(|at_s| *at_s >= from_s).collect();
    let mut labels: Vec<(usize, usize)> =
        stretches(recording.events()).into_iter().map(|(from, to, _)| (from, to)).collect();
    if labels.is_empty() {
        labels.push((0, time_s.len()));
    }
    for (from, to) in labels {
        let to = to.min(time_s.len());
        for row in from..to {
            counts[row] &= time_s[row] - time_s[from] >= settle_s;
        }
    }
    counts
}

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

    #[test]
    fn the_beginning_of_every_label_and_of_the_recording_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.csv");
        let rows: String = (0..12).map(|n| format!("{n},{},{n}\n", if n < 6 { "a" } else { "b" })).collect();
        let read = |metadata: &str| {
            std::fs::write(&path, format!("{metadata}time_s,event,wind_speed_m_s\n{rows}")).unwrap();
            let recording = Recording::read(&path).unwrap();
            let counted = counted(&recording, recording.time_s().unwrap());
            (0..12).filter(|row| counted[*row]).collect::<Vec<usize>>()
        };
        assert_eq!(read("# counted_from_s: 3\n# settle_s: 2\n"), [3, 4, 5, 8, 9, 10, 11]);
        assert_eq!(read("").len(), 12);
    }

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
