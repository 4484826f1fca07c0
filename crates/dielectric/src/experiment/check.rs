//! Preview of an experiment, without doing it.

use std::fmt;

use dr_core::control::Drive;
use dr_core::sensor::Level;
use recording::text::four_digits as brief;
use serde::Serialize;

use super::DeviceExperiment;

/// An experiment in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceCheck {
    /// Title.
    pub title: String,
    /// Name of the device.
    pub device: String,
    /// Number of symbols.
    pub ticks: u32,
    /// Its length, s.
    pub duration_s: f64,
    /// V₋ and V₊, V.
    pub bias_v: [f64; 2],
    /// Lengths of the two parts of a symbol, s.
    pub parts_s: [f64; 2],
    /// Standard uncertainty of a voltage shift by the two readings of a symbol, V.
    pub shift_noise_v: f64,
    /// By how much a hundredth of C₀ moves a shift by one reading; that by two it does not, V.
    pub single_shift_v_per_percent: f64,
    /// Phases and their beginnings.
    pub phases: Vec<CheckedPhase>,
    /// Its device can be simulated.
    pub is_simulated: bool,
}

/// A phase in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckedPhase {
    /// Its start, s.
    pub start_s: f64,
    /// Name.
    pub label: String,
    /// Drive of the device.
    pub drive: String,
}

impl DeviceCheck {
    /// Statistics of a checked experiment.
    pub fn new(experiment: &DeviceExperiment) -> Self {
        let (device, shape) = (&experiment.device, &experiment.shape);
        let second_s = shape.second_share * shape.symbol_time_s;
        let phase = |phase: &super::DevicePhase| CheckedPhase {
            start_s: experiment.time_s(phase.tick),
            label: phase.label.clone(),
            drive: words(&phase.drive, shape.symbol_time_s),
        };
        Self {
            title: experiment.title.clone(),
            device: device.name.clone(),
            ticks: experiment.ticks,
            duration_s: experiment.time_s(experiment.ticks),
            bias_v: [shape.negative_v, shape.positive_v],
            parts_s: [shape.symbol_time_s - second_s, second_s],
            shift_noise_v: device.shift_noise_v(shape),
            single_shift_v_per_percent: 0.01 * device.capacitor.offset_f
                / (2.0 * device.capacitor.curvature_f_v2 * shape.positive_v.abs()),
            phases: experiment.phases.iter().map(phase).collect(),
            is_simulated: device.simulation.is_some(),
        }
    }
}

fn words(drive: &Drive, symbol_time_s: f64) -> String {
    match *drive {
        Drive::Level(Level::High) => "symbol 1".to_owned(),
        Drive::Level(Level::Low) => "symbol −1".to_owned(),
        Drive::Power { power_w } => format!("mean symbol {power_w}, open loop"),
        Drive::Prbs { order, seed, ticks_per_bit } => {
            let bit_s = f64::from(ticks_per_bit) * symbol_time_s;
            format!("pseudo-random bits of {} s, order {order}, seed {seed}", brief(bit_s))
        }
        Drive::Temperature { target_c } => format!("holds {target_c} V, loop of first order"),
        Drive::SecondOrder { target, gain_per_tick } => {
            format!("holds {target} V, loop of second order, gain {gain_per_tick} a symbol")
        }
        Drive::Passive | Drive::Setpoints { .. } | Drive::Alternation { .. } => "0 V".to_owned(),
    }
}

impl fmt::Display for DeviceCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([low_v, high_v], [first_s, second_s]) = (self.bias_v, self.parts_s);
        writeln!(f, "{} · device {}", self.title, self.device)?;
        writeln!(f, "{} symbols, {} s", self.ticks, self.duration_s)?;
        writeln!(
            f,
            "symbols: one voltage for {} s, the other for {} s; {high_v} and {low_v} V are 1, {low_v} and {high_v} V are −1",
            brief(first_s),
            brief(second_s)
        )?;
        writeln!(
            f,
            "voltage shift: ± {} V a symbol by the noise of the meter; a hundredth of C₀ would move a single reading by {} V",
            brief(self.shift_noise_v),
            brief(self.single_shift_v_per_percent)
        )?;
        if !self.is_simulated {
            writeln!(f, "the device's file has no [simulation]: only a real one can be run")?;
        }
        for phase in &self.phases {
            let label = if phase.label.is_empty() { String::new() } else { format!(" ({})", phase.label) };
            writeln!(f, "from {} s{label}: {}", phase.start_s, phase.drive)?;
        }
        Ok(())
    }
}
