//! A record of quiescent gas in which one element is driven and all others only measure.
//!
//! The driven element is found: the range of its power is by far the greatest. The range of the
//! others, some per cent of their little power, comes from resistances that change with
//! temperature. A record without a driven element, with several, or with wind is refused: it does
//! not determine a quiescent-gas network.

use std::path::Path;

use super::error::NetworkError;
use diffusive::model::Conditions;
use recording::text::listed;
use recording::{POWER, Recording, RecordingError, STATE, TEMPERATURE, TRUE_WIND};

/// Share of the greatest range of power below which an element only measures.
const MEASURES: f64 = 0.05;
/// Least range of a driven element's power over its mean.
const DRIVEN: f64 = 0.5;
/// Labels that a refusal names.
const LABELS: usize = 3;
/// Speed of simulated wind below which the gas is quiescent, m/s.
const STILL_M_S: f64 = 1e-3;

/// A record, in memory.
#[derive(Debug, Clone)]
pub struct QuiescentRecord {
    /// Name of the record in errors.
    pub name: String,
    /// Text of the head file that the recording carries.
    pub head: Option<String>,
    /// Gas and support, if the recording has them.
    pub conditions: Option<Conditions>,
    /// Time between two rows, s.
    pub sample_period_s: f64,
    /// Names, in the record's order.
    pub elements: Vec<String>,
    /// Place of the driven element among them.
    pub driven: usize,
    /// Heating power by element and row, W.
    pub power_w: Vec<Vec<f64>>,
    /// Temperature by element and row, °C.
    pub temperature_c: Vec<Vec<f64>>,
}

impl QuiescentRecord {
    /// Reads a record from a recording.
    ///
    /// # Errors
    /// What keeps the recording from being one of quiescent gas with one driven element.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        Self::of(&Recording::read(path)?)
    }

    /// The record that a recording holds.
    ///
    /// # Errors
    /// As [`QuiescentRecord::read`].
    pub fn of(recording: &Recording) -> Result<Self, RecordingError> {
        let refuse = |sentence| Err(RecordingError::new(&recording.path, sentence));
        if let Some(problem) = wind(recording)? {
            return refuse(problem);
        }
        if let Ok(states) = recording.words(STATE)
            && let Some((row, _, state)) = states.stretches().find(|(_, _, state)| state.starts_with("tripped"))
        {
            return refuse(format!("is in state `{state}` from row {} on: cut it there", row + 1));
        }
        let both = |element: &&str| {
            recording.has(&recording::column_name(POWER, element))
                && recording.has(&recording::column_name(TEMPERATURE, element))
        };
        let elements: Vec<String> = recording.elements().into_iter().filter(both).map(str::to_owned).collect();
        let mut power_w = Vec::new();
        let mut temperature_c = Vec::new();
        for element in &elements {
            power_w.push(recording.finite(&recording::column_name(POWER, element))?.to_vec());
            temperature_c.push(recording.finite(&recording::column_name(TEMPERATURE, element))?.to_vec());
        }
        let ranges: Vec<(f64, f64)> = power_w.iter().map(|power_w| range_and_mean(power_w)).collect();
        let Some(driven) = (0..ranges.len()).max_by(|&a, &b| ranges[a].0.total_cmp(&ranges[b].0)) else {
            return refuse(format!("has no element with columns `{POWER}…` and `{TEMPERATURE}…`"));
        };
        let (element, (range_w, mean_w)) = (&elements[driven], ranges[driven]);
        if range_w <= DRIVEN * mean_w.abs() {
            return refuse(format!(
                "drives no element: the power that varies most is `{element}`'s, by {range_w:.3e} W about {mean_w:.3e} W; drive one of them pseudo-randomly"
            ));
        }
        let others = (0..ranges.len()).filter(|&i| i != driven && ranges[i].0 > MEASURES * range_w);
        let others: Vec<&str> = others.map(|i| elements[i].as_str()).collect();
        if !others.is_empty() {
            return refuse(format!(
                "drives `{element}` and also {}: one record is needed for each of them, in which all others stay at their low level",
                others.join(", ")
            ));
        }
        Ok(Self {
            head: recording.metadata("head").map(str::to_owned),
            conditions: Conditions::of_metadata(&recording.metadata),
            sample_period_s: recording.sample_period_s()?,
            name: recording.path.display().to_string(),
            elements,
            driven,
            power_w,
            temperature_c,
        })
    }

    /// The record of some of its elements, in its own order; what the others do counts as part of
    /// the structure.
    ///
    /// # Errors
    /// If an element is unknown, or the driven one is not among them.
    pub fn only(self, wanted: &[String]) -> Result<Self, RecordingError> {
        let refuse = |sentence| Err(RecordingError::new(Path::new(&self.name), sentence));
        let wanted: Vec<String> = wanted.iter().map(|name| recording::in_columns(name)).collect();
        if let Some(element) = wanted.iter().find(|name| !self.elements.contains(name)) {
            let hint = recording::text::suggest(element, self.elements.iter().map(String::as_str));
            return refuse(format!("has no element `{element}`; {hint}"));
        }
        let driven = self.driven_name();
        let Some(place) = self.elements.iter().filter(|name| wanted.contains(name)).position(|name| name == driven)
        else {
            return refuse(format!("drives `{driven}`, which is not among {}", wanted.join(", ")));
        };
        let kept: Vec<bool> = self.elements.iter().map(|name| wanted.contains(name)).collect();
        let columns =
            |of: Vec<Vec<f64>>| of.into_iter().zip(&kept).filter(|(_, kept)| **kept).map(|(of, _)| of).collect();
        Ok(Self {
            driven: place,
            power_w: columns(self.power_w),
            temperature_c: columns(self.temperature_c),
            elements: self.elements.into_iter().filter(|name| wanted.contains(name)).collect(),
            ..self
        })
    }

    /// Name of the driven element.
    pub fn driven_name(&self) -> &str {
        &self.elements[self.driven]
    }

    /// Checks that two records belong to one network.
    ///
    /// # Errors
    /// If their elements or their gases differ.
    pub fn alike(&self, first: &Self) -> Result<(), NetworkError> {
        if self.elements != first.elements {
            return Err(NetworkError::new(format!(
                "{} has the elements {}, {} has {}: all records must be of one head",
                first.name,
                first.elements.join(", "),
                self.name,
                self.elements.join(", ")
            )));
        }
        let (Some(own), Some(its)) = (&self.conditions, &first.conditions) else { return Ok(()) };
        let differences = its.differences(own, true);
        if differences.is_empty() {
            return Ok(());
        }
        let (own, its, differences) = (&self.name, &first.name, differences.join(" and "));
        Err(NetworkError::new(format!("{own} was taken {differences}, as {its} is: a network holds for one gas")))
    }
}

/// The first label or row that speaks of wind.
fn wind(recording: &Recording) -> Result<Option<String>, RecordingError> {
    const QUIESCENT: &str = "a quiescent-gas network takes records of quiescent gas only";
    if let Some(events) = recording.events() {
        let labels: Vec<&str> =
            events.dictionary().iter().map(String::as_str).filter(|label| !label.is_empty()).collect();
        if labels.len() > 1 {
            return Ok(Some(format!("was taken under several conditions, {}: {QUIESCENT}", listed(&labels, LABELS))));
        }
    }
    for column in TRUE_WIND.into_iter().filter(|name| recording.has(name)) {
        let speed = recording.numbers(column)?;
        // A missing value is no wind.
        if let Some(row) = speed.iter().position(|speed| speed.abs() > STILL_M_S) {
            return Ok(Some(format!("row {}: `{column}` is {:.3} m/s: {QUIESCENT}", row + 1, speed[row])));
        }
    }
    Ok(None)
}

fn range_and_mean(values: &[f64]) -> (f64, f64) {
    let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    (most - least, values.iter().sum::<f64>() / values.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::{ColumnValues, RecordingColumn};

    /// Two elements at 10 Hz, of which `a` is driven and `b` measures.
    fn recording() -> Recording {
        let numbers = |name: &str, of: &dyn Fn(usize) -> f64| RecordingColumn {
            name: name.to_owned(),
            values: ColumnValues::Numbers((0..50).map(of).collect()),
        };
        let columns = vec![
            numbers("time_s", &|n| 0.1 * n as f64),
            numbers("temperature_c_a", &|_| 20.0),
            numbers("power_w_a", &|n| 0.04 * (n % 2) as f64),
            numbers("temperature_c_b", &|_| 20.0),
            numbers("power_w_b", &|n| 1e-3 + 1e-6 * n as f64),
            numbers("true_wind_x_m_s", &|_| 0.0),
        ];
        Recording { path: "r.csv".into(), metadata: Vec::new(), columns }
    }

    fn refused(column: usize, of: &dyn Fn(usize) -> f64) -> String {
        let mut recording = recording();
        recording.columns[column].values = ColumnValues::Numbers((0..50).map(of).collect());
        QuiescentRecord::of(&recording).unwrap_err().to_string()
    }

    #[test]
    fn finds_which_element_is_driven() {
        let record = QuiescentRecord::of(&recording()).unwrap();
        assert_eq!((record.driven_name(), record.elements.len()), ("a", 2));
        assert!((record.sample_period_s - 0.1).abs() < 1e-12);
    }

    #[test]
    fn some_of_its_elements_are_a_record_too() {
        let record = QuiescentRecord::of(&recording()).unwrap();
        let only = |names: &[&str]| record.clone().only(&names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>());
        let alone = only(&["a"]).unwrap();
        assert_eq!((alone.driven_name(), alone.elements.len(), alone.power_w.len()), ("a", 1, 1));
        assert!(only(&["b"]).unwrap_err().to_string().contains("drives `a`, which is not among b"));
        assert!(only(&["a", "c"]).unwrap_err().to_string().contains("has no element `c`"));
    }

    #[test]
    fn what_drives_none_or_two_or_has_wind_is_refused() {
        let none = refused(2, &|_| 1e-3);
        assert!(none.starts_with("r.csv: drives no element"), "{none}");
        let two = refused(4, &|n| 0.01 * (n % 3) as f64);
        assert!(two.starts_with("r.csv: drives `a` and also b"), "{two}");
        let labels = ["still", "wind 1", "wind 2", "wind 3", "wind 4"];
        assert_eq!(listed(&labels, LABELS), "still, wind 1, wind 2 and 2 more");
        assert_eq!(listed(&labels[..3], LABELS), "still, wind 1, wind 2");
        let windy = refused(5, &|n| if n == 7 { 2.0 } else { 0.0 });
        assert!(windy.starts_with("r.csv: row 8: `true_wind_x_m_s` is 2.000 m/s"), "{windy}");
    }
}
