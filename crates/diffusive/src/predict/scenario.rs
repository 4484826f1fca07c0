//! Scenario that is predicted: elements with their drives, in winds that change, at a sample
//! period.

use dr_core::control::Drive;
use dr_core::sensor::{Channel, Level};

/// An experiment as far as a model needs to know it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Length of a tick, s.
    pub sample_period_s: f64,
    /// Number of ticks.
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
    /// Name of the element.
    pub name: String,
    /// Drive that heats it.
    pub drive: Drive,
    /// Heater: powers of its levels.
    pub heater: Heater,
}

/// Powers of the levels.
#[derive(Debug, Clone, PartialEq)]
pub enum Heater {
    /// The same at any temperature, W.
    Fixed {
        /// Low level, W.
        low_w: f64,
        /// High level, W.
        high_w: f64,
    },
    /// I²R of a resistor that warms up.
    Resistor(Channel),
}

impl Heater {
    /// Power of the low and the high level in W at a temperature in °C.
    pub fn levels_w(&self, temperature_c: f64) -> (f64, f64) {
        match self {
            Self::Fixed { low_w, high_w } => (*low_w, *high_w),
            Self::Resistor(channel) => {
                let power_w = |level| f64::from(channel.power_at_w(temperature_c as f32, level));
                (power_w(Level::Low), power_w(Level::High))
            }
        }
    }
}

impl Scenario {
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
