//! Experiments on a device: which symbols it is driven by, for how long, in which surroundings.
//!
//! | table | keys |
//! |---|---|
//! | top | `title`, `device` (a path from this file), `symbol_time_s` (T_s, 0.01 … 10), `duration_s`, `seed`, `drive`, and optionally `unreachable_after_s` (a loop that wants one symbol for so long trips; never, if not given) |
//! | `[symbols]` | `positive_v`, `negative_v`, `second_share` (δ) |
//! | `[[changes]]` | `start_s`, `drive`, and optionally `label` |
//! | `[[surroundings]]` | `start_s`, `temperature_c`, `humidity_percent`: of a simulated device, straight between them |
//!
//! A drive is `"zero"` (0 V, and no readings), `{ symbol = 1 }` or `{ symbol = -1 }` (the same
//! symbol again and again: with a small δ nearly a constant bias), `{ mean_symbol = 0.25 }` (an
//! open-loop sigma-delta), `{ prbs = { order, bit_time_s, seed } }`, or `{ hold = { shift_v, order
//! } }` (the closed loop, of first or second order; `gain` a tick is that of the second, 0.1 if not
//! given).

mod check;
mod read;

use dr_core::Command;
use dr_core::control::{Drive, GuardConfig};
use recording::toml_file::{FileError, TomlSource};

pub use check::{CheckedPhase, DeviceCheck};

use crate::device::Device;
use crate::port::SymbolShape;
use crate::simulated::{SimulatedDevice, SurroundingsPoint};

/// A checked experiment with its device.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceExperiment {
    /// The file, which errors name.
    pub source: TomlSource,
    /// Title.
    pub title: String,
    /// Device.
    pub device: Device,
    /// Voltages and times of its symbols.
    pub shape: SymbolShape,
    /// Length in symbols.
    pub ticks: u32,
    /// Seed of the simulated meter's noise.
    pub seed: u64,
    /// Limit of the guard for a loop that wants one symbol all the time.
    pub unreachable_ticks: u32,
    /// Phases, the first at 0, ascending.
    pub phases: Vec<DevicePhase>,
    /// Around a simulated device.
    pub surroundings: Vec<SurroundingsPoint>,
}

/// Phase of a device from a tick on.
#[derive(Debug, Clone, PartialEq)]
pub struct DevicePhase {
    /// First tick.
    pub tick: u32,
    /// Name in the recording.
    pub label: String,
    /// Drive.
    pub drive: Drive,
}

impl DeviceExperiment {
    /// Time of a tick, s.
    pub fn time_s(&self, tick: u32) -> f64 {
        host_sim::experiment::time_s(tick, self.shape.symbol_time_s)
    }

    /// The phase that a tick is in.
    pub fn phase(&self, tick: u32) -> &DevicePhase {
        let begun = self.phases.partition_point(|phase| phase.tick <= tick);
        &self.phases[begun.max(1) - 1]
    }

    /// Commands that set a controller up for it, in the order that it needs.
    ///
    /// # Errors
    /// If the core cannot take a number of the device.
    pub fn setup(&self) -> Result<Vec<Command>, FileError> {
        let config = self.device.config(&self.shape);
        let config = config.map_err(|error| self.source.refuse("device", format!("cannot be used: {error}")))?;
        let guard = GuardConfig { unreachable_limit_ticks: self.unreachable_ticks, ..GuardConfig::default() };
        Ok(vec![
            Command::SamplePeriod { sample_period_s: self.shape.symbol_time_s as f32 },
            Command::Guard(guard),
            Command::Capacitor { element: 0, config },
            Command::Drive { element: 0, drive: self.phases[0].drive },
        ])
    }

    /// The simulated device of this experiment.
    ///
    /// # Errors
    /// If its file does not have what simulates it.
    pub fn simulated(&self) -> Result<SimulatedDevice, FileError> {
        SimulatedDevice::new(&self.device, &self.surroundings, self.seed).ok_or_else(|| {
            let sentence =
                format!("is `{}`, whose file has no [simulation]: only a real one can be run", self.device.name);
            self.source.refuse("device", sentence)
        })
    }

    /// Tells whether a file is an experiment on a device, and not on a head.
    pub fn is_one(source: &TomlSource) -> bool {
        source.text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("device"))
    }
}
