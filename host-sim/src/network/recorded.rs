//! A record of still gas in which one element is driven and all others only measure.
//!
//! Which one is driven is found: its power spans more than all others' by far. What these span, some per cent of their little power, is
//! the resistance that changes with temperature. A record that shows no driven element or several, or wind, is refused, because nothing that
//! is identified from it would be the network without wind.

use std::path::Path;

use crate::model::Conditions;
use crate::recording::{POWER, Recording, STATE, TEMPERATURE, WIND};

/// Part of the greatest range of power below which an element only measures.
const MEASURES: f64 = 0.05;
/// Part of its own mean that the power of a driven element spans at least.
const DRIVEN: f64 = 0.5;
/// Labels that a refusal names.
const LABELS: usize = 3;
/// Speed of simulated wind below which the gas is still, m/s.
const STILL_M_S: f64 = 1e-3;

/// A record, in memory.
#[derive(Debug, Clone)]
pub struct Recorded {
    /// What refusals call it.
    pub name: String,
    /// As the file that it was recorded with says, if it does.
    pub head: Option<String>,
    pub conditions: Option<Conditions>,
    pub sample_period_s: f64,
    /// In the record's order.
    pub elements: Vec<String>,
    /// Which of them.
    pub driven: usize,
    /// By element and row.
    pub power_w: Vec<Vec<f64>>,
    pub temperature_c: Vec<Vec<f64>>,
}

impl Recorded {
    /// # Errors
    /// A sentence that names the record and what keeps it from being one of still gas with one driven element.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::of(&Recording::read(path).map_err(|error| error.to_string())?)
    }

    /// # Errors
    /// As [`Recorded::read`].
    pub fn of(recording: &Recording) -> Result<Self, String> {
        let name = recording.path.display().to_string();
        let refuse = |sentence: String| Err(format!("{name}: {sentence}"));
        if let Some(sentence) = wind(recording)? {
            return refuse(sentence);
        }
        if let Ok(states) = recording.words(STATE)
            && let Some((row, _, state)) = states.stretches().find(|(_, _, state)| state.starts_with("tripped"))
        {
            return refuse(format!("is in state `{state}` from row {} on: cut it there", row + 1));
        }
        let both = |element: &&str| {
            recording.has(&format!("{POWER}{element}")) && recording.has(&format!("{TEMPERATURE}{element}"))
        };
        let elements: Vec<String> = recording.elements().into_iter().filter(both).map(str::to_owned).collect();
        let mut power_w = Vec::new();
        let mut temperature_c = Vec::new();
        for element in &elements {
            let column =
                |prefix: &str| recording.finite(&format!("{prefix}{element}")).map_err(|error| error.to_string());
            power_w.push(column(POWER)?.to_vec());
            temperature_c.push(column(TEMPERATURE)?.to_vec());
        }
        let ranges: Vec<(f64, f64)> = power_w.iter().map(|power_w| range_and_mean(power_w)).collect();
        let Some(driven) = (0..ranges.len()).max_by(|&a, &b| ranges[a].0.total_cmp(&ranges[b].0)) else {
            return refuse(format!("has no element with columns `{POWER}…` and `{TEMPERATURE}…`"));
        };
        if ranges[driven].0 <= DRIVEN * ranges[driven].1.abs() {
            return refuse(format!(
                "drives no element: the power that varies most is `{}`'s, by {:.3e} W about {:.3e} W; drive one of them pseudo-randomly",
                elements[driven], ranges[driven].0, ranges[driven].1
            ));
        }
        let others = (0..ranges.len()).filter(|&i| i != driven && ranges[i].0 > MEASURES * ranges[driven].0);
        let others: Vec<&str> = others.map(|i| elements[i].as_str()).collect();
        if !others.is_empty() {
            return refuse(format!(
                "drives `{}` and also {}: one record is needed for each of them, in which all others stay at their low level",
                elements[driven],
                others.join(", ")
            ));
        }
        Ok(Self {
            head: recording.metadata("head").map(str::to_owned),
            conditions: Conditions::of_metadata(&recording.metadata),
            sample_period_s: recording.sample_period_s().map_err(|error| error.to_string())?,
            name,
            elements,
            driven,
            power_w,
            temperature_c,
        })
    }

    /// The same of some of its elements, in its own order; what the others do counts as part of the structure.
    ///
    /// # Errors
    /// A sentence: no such element, or the driven one is not among them.
    pub fn only(self, wanted: &[String]) -> Result<Self, String> {
        if let Some(name) = wanted.iter().find(|name| !self.elements.contains(name)) {
            let hint = crate::toml_file::suggest(name, self.elements.iter().map(String::as_str));
            return Err(format!("{}: has no element `{name}`; {hint}", self.name));
        }
        let driven = self.driven_name().to_owned();
        let Some(place) = self.elements.iter().filter(|name| wanted.contains(name)).position(|name| *name == driven)
        else {
            return Err(format!("{}: drives `{driven}`, which is not among {}", self.name, wanted.join(", ")));
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

    pub fn driven_name(&self) -> &str {
        &self.elements[self.driven]
    }

    /// What keeps it from being of one network with another record.
    ///
    /// # Errors
    /// A sentence that names both.
    pub fn alike(&self, first: &Self) -> Result<(), String> {
        if self.elements != first.elements {
            return Err(format!(
                "{} has the elements {}, {} has {}: all records must be of one head",
                first.name,
                first.elements.join(", "),
                self.name,
                self.elements.join(", ")
            ));
        }
        let (Some(own), Some(its)) = (&self.conditions, &first.conditions) else { return Ok(()) };
        let differences = its.differences(own, true);
        if differences.is_empty() {
            return Ok(());
        }
        Err(format!(
            "{} was taken {}, as {} is: a network holds for one gas",
            self.name,
            differences.join(" and "),
            first.name
        ))
    }
}

/// What speaks of wind.
fn wind(recording: &Recording) -> Result<Option<String>, String> {
    if let Some(events) = recording.events() {
        let labels: Vec<&str> =
            events.dictionary().iter().map(String::as_str).filter(|label| !label.is_empty()).collect();
        if labels.len() > 1 {
            return Ok(Some(format!(
                "was taken under several conditions, {}: a network without wind takes records of still gas only",
                some_of(&labels)
            )));
        }
    }
    for name in WIND.iter().filter(|name| recording.has(name)) {
        let speed = recording.numbers(name).map_err(|error| error.to_string())?;
        // A missing value is no wind.
        if let Some(row) = speed.iter().position(|speed| speed.abs() > STILL_M_S) {
            return Ok(Some(format!(
                "row {}: `{name}` is {:.3} m/s: a network without wind takes records of still gas only",
                row + 1,
                speed[row]
            )));
        }
    }
    Ok(None)
}

/// The first of many labels.
fn some_of(labels: &[&str]) -> String {
    match labels.len().checked_sub(LABELS) {
        None | Some(0) => labels.join(", "),
        Some(more) => format!("{} and {more} more", labels[..LABELS].join(", ")),
    }
}

fn range_and_mean(values: &[f64]) -> (f64, f64) {
    let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    (most - least, values.iter().sum::<f64>() / values.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Column, Values};

    /// Two elements at 10 Hz, of which `a` is driven and `b` measures.
    fn recording() -> Recording {
        let numbers = |name: &str, of: &dyn Fn(usize) -> f64| Column {
            name: name.to_owned(),
            values: Values::Numbers((0..50).map(of).collect()),
        };
        let columns = vec![
            numbers("time_s", &|n| 0.1 * n as f64),
            numbers("temperature_c:a", &|_| 20.0),
            numbers("power_w:a", &|n| 0.04 * (n % 2) as f64),
            numbers("temperature_c:b", &|_| 20.0),
            numbers("power_w:b", &|n| 1e-3 + 1e-6 * n as f64),
            numbers("wind_x_m_s", &|_| 0.0),
        ];
        Recording { path: "r.csv".into(), metadata: Vec::new(), columns }
    }

    fn refused(column: usize, of: &dyn Fn(usize) -> f64) -> String {
        let mut recording = recording();
        recording.columns[column].values = Values::Numbers((0..50).map(of).collect());
        Recorded::of(&recording).unwrap_err()
    }

    #[test]
    fn finds_which_element_is_driven() {
        let record = Recorded::of(&recording()).unwrap();
        assert_eq!((record.driven_name(), record.elements.len()), ("a", 2));
        assert!((record.sample_period_s - 0.1).abs() < 1e-12);
    }

    #[test]
    fn some_of_its_elements_are_a_record_too() {
        let record = Recorded::of(&recording()).unwrap();
        let only = |names: &[&str]| record.clone().only(&names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>());
        let alone = only(&["a"]).unwrap();
        assert_eq!((alone.driven_name(), alone.elements.len(), alone.power_w.len()), ("a", 1, 1));
        assert!(only(&["b"]).unwrap_err().contains("drives `a`, which is not among b"));
        assert!(only(&["a", "c"]).unwrap_err().contains("has no element `c`"));
    }

    #[test]
    fn what_drives_none_or_two_or_has_wind_is_refused() {
        let none = refused(2, &|_| 1e-3);
        assert!(none.starts_with("r.csv: drives no element"), "{none}");
        let two = refused(4, &|n| 0.01 * (n % 3) as f64);
        assert!(two.starts_with("r.csv: drives `a` and also b"), "{two}");
        let labels = ["still", "wind 1", "wind 2", "wind 3", "wind 4"];
        assert_eq!(some_of(&labels), "still, wind 1, wind 2 and 2 more");
        assert_eq!(some_of(&labels[..3]), "still, wind 1, wind 2");
        let windy = refused(5, &|n| if n == 7 { 2.0 } else { 0.0 });
        assert!(windy.starts_with("r.csv: row 8: `wind_x_m_s` is 2.000 m/s"), "{windy}");
    }
}
