//! A device: one MEMS capacitor with its limits, the meter that reads it, and what simulates it.
//!
//! | table | keys |
//! |---|---|
//! | top | `name` |
//! | `[capacitor]` | `curvature_f_v2` (α), `offset_f` (C₀), `pull_in_v` (the membrane falls at so many volts, beyond the shift) |
//! | `[limits]` | `bias_max_v` either way, `shift_max_v` either way, `capacitance_max_f` |
//! | `[meter]` | `full_scale_f`; of a real one `frequency_hz`, `level_v`; of a simulated one `noise_f` rms a reading |
//! | `[simulation]` | `temperature_c` and `humidity_percent` at which C₀ is as above, and its shares `offset_per_k`, `offset_per_percent`, `offset_per_hour`; `charging_per_k`, the share by which charging grows |
//! | `[[simulation.carriers]]` | `polarity` of the bias under which they charge, and a diffusive bank: [`Carriers`] |

mod carriers;

use std::path::Path;

use dr_core::control::CapacitorConfig;
use dr_core::sensor::Capacitor;
use recording::toml_file::{FileError, TomlSource};
use serde::Deserialize;

use crate::port::SymbolShape;
pub use carriers::{Carriers, Polarity};

/// Greatest code of a reading: those of a link have 24 bit.
const CODE_MAX: i32 = 8_388_000;

/// A checked device.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Device {
    /// The file, which errors name.
    #[serde(skip)]
    pub source: TomlSource,
    /// Name, in columns too.
    pub name: String,
    /// Its capacitance.
    pub capacitor: MemsCapacitor,
    /// Limits that it bears.
    pub limits: DeviceLimits,
    /// Meter that reads it.
    pub meter: MeterRange,
    /// Simulation; without it, only a real one can be run.
    pub simulation: Option<Simulation>,
}

/// C(V) = C₀ + α (V − V_sh)².
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemsCapacitor {
    /// α, F/V².
    pub curvature_f_v2: f64,
    /// C₀ at the conditions of the simulation, F.
    pub offset_f: f64,
    /// |V − V_sh| at which the membrane falls, V.
    pub pull_in_v: f64,
}

/// Limits of a device.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceLimits {
    /// Greatest bias, either way, V.
    pub bias_max_v: f64,
    /// Greatest plausible voltage shift, either way, V.
    pub shift_max_v: f64,
    /// Capacitance above which the membrane has fallen, F.
    pub capacitance_max_f: f64,
}

/// Range and noise of the meter that reads a device.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeterRange {
    /// Capacitance of the greatest code, F.
    pub full_scale_f: f64,
    /// Noise of a reading, F rms.
    #[serde(default)]
    pub noise_f: f64,
    /// Frequency of the oscillator, Hz.
    #[serde(default = "megahertz")]
    pub frequency_hz: f64,
    /// Level of the oscillator, V rms.
    #[serde(default = "tenth_of_a_volt")]
    pub level_v: f64,
}

const fn megahertz() -> f64 {
    1e6
}

const fn tenth_of_a_volt() -> f64 {
    0.1
}

/// Simulation of a device.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simulation {
    /// Temperature at which C₀ is `offset_f`, °C.
    #[serde(default = "room_c")]
    pub temperature_c: f64,
    /// Relative humidity at which C₀ is `offset_f`, %.
    #[serde(default)]
    pub humidity_percent: f64,
    /// Share by which C₀ grows a kelvin.
    #[serde(default)]
    pub offset_per_k: f64,
    /// Share by which C₀ grows a percent of humidity.
    #[serde(default)]
    pub offset_per_percent: f64,
    /// Share by which C₀ grows an hour.
    #[serde(default)]
    pub offset_per_hour: f64,
    /// Share by which charging grows a kelvin.
    #[serde(default)]
    pub charging_per_k: f64,
    /// Carriers.
    pub carriers: Vec<Carriers>,
}

const fn room_c() -> f64 {
    20.0
}

impl Device {
    /// Reads a device.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let source = TomlSource::read(path)?;
        let device: Self = source.parse()?;
        device.check(&source)?;
        Ok(Self { source, ..device })
    }

    fn check(&self, source: &TomlSource) -> Result<(), FileError> {
        let Self { name, capacitor, limits, meter, .. } = self;
        if name.is_empty() || !name.chars().all(|of| of.is_ascii_alphanumeric() || of == '-' || of == '_') {
            return Err(
                source.refuse("name", "stands in the columns of recordings: letters, digits, - and _ belong here")
            );
        }
        for (key, value, unit) in [
            ("capacitor.curvature_f_v2", capacitor.curvature_f_v2, "F/V²"),
            ("capacitor.offset_f", capacitor.offset_f, "F"),
            ("capacitor.pull_in_v", capacitor.pull_in_v, "V"),
            ("limits.bias_max_v", limits.bias_max_v, "V"),
            ("limits.shift_max_v", limits.shift_max_v, "V"),
            ("limits.capacitance_max_f", limits.capacitance_max_f, "F"),
            ("meter.full_scale_f", meter.full_scale_f, "F"),
            ("meter.frequency_hz", meter.frequency_hz, "Hz"),
            ("meter.level_v", meter.level_v, "V"),
        ] {
            source.positive(key, value, unit)?;
        }
        source.within("meter.noise_f", meter.noise_f, 0.0..=meter.full_scale_f, "F")?;
        if limits.bias_max_v >= capacitor.pull_in_v {
            let sentence = format!(
                "is {} V, but the membrane falls at `pull_in_v`, {} V: it must lie below",
                limits.bias_max_v, capacitor.pull_in_v
            );
            return Err(source.refuse("limits.bias_max_v", sentence));
        }
        let pulled_f = capacitor.offset_f + capacitor.curvature_f_v2 * capacitor.pull_in_v.powi(2);
        if meter.full_scale_f <= limits.capacitance_max_f || limits.capacitance_max_f <= capacitor.offset_f {
            let sentence = format!(
                "is {:e} F: it must lie above `offset_f`, {:e} F, and below the meter's `full_scale_f`, {:e} F; at pull-in C(V) is {pulled_f:.3e} F",
                limits.capacitance_max_f, capacitor.offset_f, meter.full_scale_f
            );
            return Err(source.refuse("limits.capacitance_max_f", sentence));
        }
        self.simulation.as_ref().map_or(Ok(()), |simulation| simulation.check(source))
    }

    /// Farad a code.
    pub fn farad_per_code(&self) -> f64 {
        self.meter.full_scale_f / f64::from(CODE_MAX)
    }

    /// Standard uncertainty of a voltage shift by one quasi-differential reading, V, from the noise
    /// of the meter: both readings have it.
    pub fn shift_noise_v(&self, shape: &SymbolShape) -> f64 {
        let width_v = shape.positive_v - shape.negative_v;
        std::f64::consts::SQRT_2 * self.meter.noise_f / (2.0 * self.capacitor.curvature_f_v2 * width_v)
    }

    /// Voltage shift by a single reading of `capacitance_f` at `bias_v`, with C₀ as the file has
    /// it; what a quasi-differential reading is compared with.
    pub fn single_shift_v(&self, capacitance_f: f64, bias_v: f64) -> f64 {
        bias_v
            - bias_v.signum()
                * ((capacitance_f - self.capacitor.offset_f) / self.capacitor.curvature_f_v2).max(0.0).sqrt()
    }

    /// The device as a controller knows it.
    ///
    /// # Errors
    /// If it refuses a number.
    pub fn config(&self, shape: &SymbolShape) -> Result<CapacitorConfig, dr_core::ConfigError> {
        Ok(CapacitorConfig {
            capacitor: Capacitor::new(
                self.farad_per_code() as f32,
                self.capacitor.curvature_f_v2 as f32,
                shape.negative_v as f32,
                shape.positive_v as f32,
                shape.second_share as f32,
            )?,
            capacitance_max_f: self.limits.capacitance_max_f as f32,
            shift_max_v: self.limits.shift_max_v as f32,
            code_max: CODE_MAX,
        })
    }

    /// The code of a capacitance in F: the end of the range beyond it.
    pub fn code(&self, capacitance_f: f64) -> i32 {
        (capacitance_f / self.farad_per_code()).round().clamp(-f64::from(CODE_MAX), f64::from(CODE_MAX)) as i32
    }
}

impl Simulation {
    fn check(&self, source: &TomlSource) -> Result<(), FileError> {
        let finite = |key: &str, value: f64, unit| source.within(key, value, -1e3..=1e3, unit);
        finite("simulation.temperature_c", self.temperature_c, "°C")?;
        source.within("simulation.humidity_percent", self.humidity_percent, 0.0..=100.0, "%")?;
        finite("simulation.offset_per_k", self.offset_per_k, "a kelvin")?;
        finite("simulation.offset_per_percent", self.offset_per_percent, "a percent")?;
        finite("simulation.offset_per_hour", self.offset_per_hour, "an hour")?;
        finite("simulation.charging_per_k", self.charging_per_k, "a kelvin")?;
        if self.carriers.is_empty() {
            return Err(
                source.refuse("simulation.carriers", "is empty: one [[simulation.carriers]] at least belongs here")
            );
        }
        let mut carriers = self.carriers.iter().enumerate();
        carriers.try_for_each(|(i, of)| of.check(source, &format!("simulation.carriers[{i}]")))
    }
}
