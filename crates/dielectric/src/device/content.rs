//! A checked device, and what follows from its numbers.

use dr_core::control::CapacitorConfig;
use dr_core::sensor::Capacitor;
use recording::toml_file::TomlSource;

use super::carriers::Carriers;
use crate::symbol::SymbolShape;

/// Greatest code of a reading: those of a link have 24 bit.
const CODE_MAX: i32 = 8_388_000;

/// A checked device.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// The file, which errors name.
    pub source: TomlSource,
    /// What it is called, in columns too.
    pub name: String,
    /// α, F/V².
    pub curvature_f_v2: f64,
    /// C₀ at the conditions of the simulation, F.
    pub offset_f: f64,
    /// |V − V_sh| at which the membrane falls, V.
    pub pull_in_v: f64,
    /// Greatest bias, either way, V.
    pub bias_max_v: f64,
    /// Greatest plausible voltage shift, either way, V.
    pub shift_max_v: f64,
    /// Capacitance above which the membrane has fallen, F.
    pub capacitance_max_f: f64,
    /// How it is read.
    pub meter: MeterRange,
    /// What simulates it; without it, only a real one can be run.
    pub simulation: Option<Simulation>,
}

/// How a device is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeterRange {
    /// Capacitance of the greatest code, F.
    pub full_scale_f: f64,
    /// Noise of a reading, F rms.
    pub noise_f: f64,
    /// Frequency of the oscillator, Hz.
    pub frequency_hz: f64,
    /// Level of the oscillator, V rms.
    pub level_v: f64,
}

/// What simulates a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Temperature at which C₀ is `offset_f`, °C.
    pub temperature_c: f64,
    /// Relative humidity at which C₀ is `offset_f`, %.
    pub humidity_percent: f64,
    /// Share by which C₀ grows a kelvin, a percent of humidity, and an hour.
    pub offset_per: [f64; 3],
    /// Share by which charging grows a kelvin.
    pub charging_per_k: f64,
    /// What charges.
    pub carriers: Vec<Carriers>,
}

impl Device {
    /// Farad a code.
    pub fn farad_per_code(&self) -> f64 {
        self.meter.full_scale_f / f64::from(CODE_MAX)
    }

    /// Standard uncertainty of a voltage shift by one quasi-differential reading, V, from the noise
    /// of the meter: both readings have it.
    pub fn shift_noise_v(&self, shape: &SymbolShape) -> f64 {
        let width_v = shape.positive_v - shape.negative_v;
        std::f64::consts::SQRT_2 * self.meter.noise_f / (2.0 * self.curvature_f_v2 * width_v)
    }

    /// Voltage shift by a single reading of `capacitance_f` at `bias_v`, with C₀ as the file has
    /// it; what a quasi-differential reading is compared with.
    pub fn single_shift_v(&self, capacitance_f: f64, bias_v: f64) -> f64 {
        bias_v - bias_v.signum() * ((capacitance_f - self.offset_f) / self.curvature_f_v2).max(0.0).sqrt()
    }

    /// The device as a controller knows it.
    ///
    /// # Errors
    /// If it refuses a number.
    pub fn config(&self, shape: &SymbolShape) -> Result<CapacitorConfig, dr_core::ConfigError> {
        Ok(CapacitorConfig {
            capacitor: Capacitor::new(
                self.farad_per_code() as f32,
                self.curvature_f_v2 as f32,
                shape.negative_v as f32,
                shape.positive_v as f32,
                shape.second_share as f32,
            )?,
            capacitance_max_f: self.capacitance_max_f as f32,
            shift_max_v: self.shift_max_v as f32,
            code_max: CODE_MAX,
        })
    }

    /// The code of a capacitance in F: the end of the range beyond it.
    pub fn code(&self, capacitance_f: f64) -> i32 {
        (capacitance_f / self.farad_per_code()).round().clamp(-f64::from(CODE_MAX), f64::from(CODE_MAX)) as i32
    }
}
