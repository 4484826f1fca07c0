//! What is to be predicted: elements with their drives, in winds that change, at a sample period.

use dr_core::control::Drive;
use dr_core::sensor::Level;

use crate::experiment::Experiment;
use crate::head;
use crate::model::export::part::element;
use crate::model::{ALL, Model};
use crate::toml_file::suggest;

/// An experiment as far as a model needs to know it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    pub sample_period_s: f64,
    pub ticks: usize,
    /// (first tick, index into the model's classes), ascending, the first at 0.
    pub winds: Vec<(usize, usize)>,
    /// One an input of the model, in its order.
    pub elements: Vec<Heated>,
    /// Temperature of the gas, °C; the model's own if not given.
    pub gas_c: Option<f64>,
}

/// One element.
#[derive(Debug, Clone, PartialEq)]
pub struct Heated {
    pub name: String,
    pub drive: Drive,
    pub heater: Heater,
}

/// What the levels give off.
#[derive(Debug, Clone, PartialEq)]
pub enum Heater {
    /// The same at any temperature, W.
    Fixed { low_w: f64, high_w: f64 },
    /// I²R of a resistor that warms up.
    Resistor(Box<head::Element>),
}

impl Heater {
    /// Power of the low and the high level in W at a temperature in °C.
    pub fn levels_w(&self, temperature_c: f64) -> (f64, f64) {
        match self {
            Self::Fixed { low_w, high_w } => (*low_w, *high_w),
            Self::Resistor(element) => {
                (element.power_w(temperature_c, Level::Low), element.power_w(temperature_c, Level::High))
            }
        }
    }
}

impl Scenario {
    /// An experiment as a model sees it, and notes for the user.
    ///
    /// # Errors
    /// A sentence: inputs that are no elements of the head, winds that the model has not seen.
    pub fn of(experiment: &Experiment, model: &Model) -> Result<(Self, Vec<String>), String> {
        let names = experiment.head.names();
        let mut notes = Vec::new();
        let mut elements = Vec::with_capacity(model.inputs.len());
        for input in &model.inputs {
            let name = element(input);
            let Some(at) = names.iter().position(|known| *known == name) else {
                let hint = suggest(name, names.iter().copied());
                return Err(format!(
                    "the model's input `{input}` is no element of head `{}`; {hint}",
                    experiment.head.name
                ));
            };
            let heater = Heater::Resistor(Box::new(experiment.head.elements[at].clone()));
            elements.push(Heated { name: name.to_owned(), drive: experiment.drives[at], heater });
        }
        let strangers: Vec<&str> = (names.iter().zip(&experiment.drives))
            .filter(|(name, drive)| **drive != Drive::Passive && !elements.iter().any(|own| own.name == **name))
            .map(|(name, _)| *name)
            .collect();
        if !strangers.is_empty() {
            notes.push(format!("the model knows nothing of {}, which are heated as well", strangers.join(", ")));
        }
        let mut winds = Vec::with_capacity(experiment.wind.len());
        for entry in &experiment.wind {
            let first = (entry.start_s.max(0.0) / experiment.sample_period_s).round() as usize;
            winds.push((first, class(model, &entry.label, experiment.wind.len())?));
            if entry.turbulence.is_some() && !notes.iter().any(|note| note.starts_with("turbulence")) {
                notes.push("turbulence is left out: a class of the model is a steady wind".to_owned());
            }
        }
        let scenario = Self {
            sample_period_s: experiment.sample_period_s,
            ticks: experiment.ticks as usize,
            winds,
            elements,
            gas_c: Some(experiment.gas_temperature_c),
        };
        Ok((scenario, notes))
    }

    /// Class of every tick.
    pub fn classes(&self) -> Vec<usize> {
        let mut classes = Vec::with_capacity(self.ticks);
        for (at, (_, class)) in self.winds.iter().enumerate() {
            let end = self.winds.get(at + 1).map_or(self.ticks, |(next, _)| *next);
            classes.resize(end.clamp(classes.len(), self.ticks), *class);
        }
        classes
    }
}

/// The model's class of a wind. A model without classes answers for an experiment in one wind.
fn class(model: &Model, label: &str, winds: usize) -> Result<usize, String> {
    if let Some(class) = model.classes.iter().position(|known| known == label) {
        return Ok(class);
    }
    if model.classes.len() == 1 && model.classes[0] == ALL {
        return if winds == 1 {
            Ok(0)
        } else {
            Err(format!(
                "the experiment has {winds} winds and the model knows of none: identify it from a record with events"
            ))
        };
    }
    let hint = suggest(label, model.classes.iter().map(String::as_str));
    Err(format!("the wind `{label}` of the experiment is no class of the model; {hint}"))
}
