//! The simulated sensors in their wind tunnel, with their front end.
//!
//! | file | what |
//! |---|---|
//! | [`gas`] | properties of carbon dioxide and air |
//! | [`convection`] | conductance of every surface to the gas, for any wind vector |
//! | [`network`] | thermal network in f64, integrated; never a diffusive model, so that identification meets something else |
//! | [`sphere_a`], [`sphere_b`], [`rems`] | the sensors of the thesis as such networks, from geometry and materials |
//! | [`rod`] | what holds them |
//! | [`reference`](mod@reference) | what measures the gas beside a sphere |
//! | [`body`] | what all of them do: take heat, lose it and account for it |
//! | [`construction`] | one of them, by its name |
//! | [`wind`] | held entries, and turbulence, gusts, sines and dust devils on top of them |
//! | [`gas_swing`] | a gas whose temperature swings |
//! | [`front_end`] | currents, resistors, converter, faults |
//!
//! [`Sensor`] puts them together. One tick: the controller decides the heater bits, [`Sensor::advance`] lets one sample period pass
//! under them, [`Sensor::codes`] is what the converter then says and [`Sensor::truth`] what nobody but a simulation knows.
//! The same configuration, seed included, gives the same bits.
//!
//! ```
//! use host_sim::sensor::{Sensor, SensorConfig};
//!
//! let mut sensor = Sensor::new(&SensorConfig::default())?;
//! let rest_c = sensor.truth().element_temperature_c[0];
//! for _ in 0..100 {
//!     sensor.advance(0b000001); // sector 1 at its high level, for a second
//! }
//! assert!(sensor.truth().element_temperature_c[0] > rest_c + 0.3);
//! assert!(sensor.codes()[0] > 0);
//! # Ok::<(), host_sim::sensor::SensorError>(())
//! ```

pub mod body;
pub mod construction;
pub mod convection;
pub mod front_end;
pub mod gas;
pub mod gas_swing;
pub mod network;
pub mod reference;
pub mod rems;
pub mod rod;
pub mod sphere_a;
pub mod sphere_b;
pub mod wind;

use dr_core::sensor::Input;
use dr_core::sensor::reading::REFERENCE_CODE;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use body::Body;
pub use construction::{Construction, Part};
use front_end::FrontEnd;
pub use front_end::{ElementConfig, Fault, Imperfections, PlatinumKind};
pub use gas::Species;
use gas::{Gas, ZERO_CELSIUS_K};
pub use gas_swing::GasSwing;
use wind::Wind;
pub use wind::{DustDevil, Gust, Sine, Spectrum, Swing, Turbulence, WindEntry};

/// Why a simulated sensor cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    #[error("`{name}` is {value}; it must be {expected}")]
    OutOfRange { name: String, value: f64, expected: &'static str },
    #[error(
        "`gas.pressure_pa` is {pressure_pa}: the gas is no continuum around the sensor (Knudsen number {knudsen:.3}, at most 0.01); \
         {lowest_pressure_pa:.0} Pa or more would be"
    )]
    NotAContinuum { knudsen: f64, pressure_pa: f64, lowest_pressure_pa: f64 },
    #[error(
        "currents of element {element} are {low_a} A low and {high_a} A high; they must be positive and the low one smaller"
    )]
    Currents { element: usize, low_a: f64, high_a: f64 },
    #[error("{found} elements are given, but `{sensor}` has {expected}")]
    Elements { sensor: &'static str, expected: usize, found: usize },
    #[error("platinum of element {element}: {source}")]
    Platinum { element: usize, source: dr_core::ConfigError },
}

impl SensorError {
    pub(crate) fn out_of_range(name: impl Into<String>, value: f64, expected: &'static str) -> SensorError {
        SensorError::OutOfRange { name: name.into(), value, expected }
    }
}

/// Everything that a simulated sensor is made from. The default is sphere B in still carbon dioxide of 1000 Pa and −53.15 °C,
/// with a perfect front end.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorConfig {
    pub construction: Construction,
    pub seed: u64,
    pub sample_period_s: f64,
    pub species: Species,
    pub pressure_pa: f64,
    /// The mean, of a gas that swings.
    pub gas_temperature_c: f64,
    pub gas_swing: Option<GasSwing>,
    pub support_temperature_c: f64,
    /// One for each of the construction's [`parts`](Construction::parts), in their order.
    pub elements: Vec<ElementConfig>,
    pub volt_per_code: f64,
    pub imperfections: Imperfections,
    /// In order of `start_s`, the first at 0; none at all is still gas.
    pub wind: Vec<WindEntry>,
    pub faults: Vec<TimedFault>,
}

/// A fault that an element has from `start_s` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFault {
    pub element: usize,
    pub fault: Fault,
    pub start_s: f64,
}

impl Default for SensorConfig {
    fn default() -> SensorConfig {
        let construction = Construction::default();
        let element = ElementConfig {
            platinum: PlatinumKind::Linear { resistance_0c_ohm: 175.0, coefficient_per_c: 0.0031 },
            current_low_a: 3e-3,
            current_high_a: 16e-3,
        };
        SensorConfig {
            elements: vec![element; construction.parts().len()],
            construction,
            seed: 0,
            sample_period_s: 0.01,
            species: Species::CarbonDioxide,
            pressure_pa: 1000.0,
            gas_temperature_c: -53.15,
            gas_swing: None,
            support_temperature_c: -43.15,
            volt_per_code: 4.0 / 8_388_608.0,
            imperfections: Imperfections::default(),
            wind: Vec::new(),
            faults: Vec::new(),
        }
    }
}

/// What is really so, at the end of the last sample period; powers and heat flows are means over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    pub time_s: f64,
    pub element_temperature_c: Vec<f64>,
    /// Electrical heat of every element.
    pub power_w: Vec<f64>,
    /// Of every surface, in the order of [`Sensor::surface_names`]; so are the next three.
    pub surface_temperature_c: Vec<f64>,
    /// To the gas.
    pub convection_w: Vec<f64>,
    /// To the surroundings.
    pub radiation_w: Vec<f64>,
    /// To the inside and to other surfaces.
    pub conduction_w: Vec<f64>,
    /// From stem or boom to the support.
    pub support_w: f64,
    pub gas_temperature_c: f64,
    pub wind_m_s: [f64; 3],
    /// The wind was beyond what is known of convection from this body, which is then an extrapolation.
    pub wind_extrapolated: bool,
}

impl Truth {
    /// All heat that leaves a surface: to gas, surroundings and the inside.
    pub fn surface_loss_w(&self, surface: usize) -> f64 {
        self.convection_w[surface] + self.radiation_w[surface] + self.conduction_w[surface]
    }
}

/// A simulated sensor with its front end in the wind tunnel, advanced tick by tick.
#[derive(Clone, Debug)]
pub struct Sensor {
    sample_period_s: f64,
    tick: u64,
    wind: Wind,
    body: Body,
    gas_temperature_c: f64,
    /// About that temperature.
    gas_swing: Option<GasSwing>,
    front_end: FrontEnd,
    faults: Vec<TimedFault>,
    element_temperature_c: Vec<f64>,
    codes: Vec<i32>,
    wind_m_s: [f64; 3],
}

impl Sensor {
    /// The sensor starts in the steady state of the first wind entry with all elements at their low level, as it is after standing
    /// by for long.
    pub fn new(config: &SensorConfig) -> Result<Sensor, SensorError> {
        let sample_period_s = config.sample_period_s;
        if !(1e-6..=10.0).contains(&sample_period_s) {
            return Err(SensorError::out_of_range("sample_period_s", sample_period_s, "1e-6 to 10"));
        }
        let (expected, found) = (config.construction.parts().len(), config.elements.len());
        if found != expected {
            return Err(SensorError::Elements { sensor: config.construction.name(), expected, found });
        }
        let gas = Gas::new(config.species, config.pressure_pa, config.gas_temperature_c + ZERO_CELSIUS_K)?;
        // Streams of one generator: noise does not change when turbulence is switched on, nor the resistors with either.
        let stream = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
            rng.set_stream(number);
            rng
        };
        let wind = Wind::new(&config.wind, sample_period_s, stream(0))?;
        let front_end =
            FrontEnd::new(&config.elements, config.volt_per_code, &config.imperfections, stream(1), stream(2))?;
        let body = config.construction.body(&gas, config.support_temperature_c + ZERO_CELSIUS_K)?;
        if let Some(swing) = &config.gas_swing {
            swing.check(sample_period_s)?;
            check_range(&gas, swing, &body)?;
        }
        let wind_m_s = wind.mean_m_s();
        let mut sensor = Sensor {
            sample_period_s,
            tick: 0,
            wind,
            body,
            gas_temperature_c: config.gas_temperature_c,
            gas_swing: config.gas_swing,
            front_end,
            faults: checked_faults(&config.faults, expected)?,
            element_temperature_c: vec![0.0; expected],
            codes: vec![0; expected],
            wind_m_s,
        };
        sensor.apply_faults();
        sensor.settle_at_low_level();
        Ok(sensor)
    }

    /// Lets one sample period pass with the heaters held; bit i of `heaters` is element i at its high level.
    pub fn advance(&mut self, heaters: u16) {
        self.apply_faults();
        self.wind_m_s = self.wind.advance();
        if self.gas_swing.is_some() {
            self.body.set_gas_temperature_k(self.gas_at_c(self.tick) + ZERO_CELSIUS_K);
        }
        self.body.set_wind(self.wind_m_s);
        let front_end = &self.front_end;
        self.body.advance(self.sample_period_s, |i, temperature_c| {
            front_end.power_w(i, temperature_c, heaters >> i & 1 == 1)
        });
        self.tick += 1;
        self.sample(heaters);
    }

    /// The converter's codes at the end of the last period, at the currents of that period; at first at the low level.
    pub fn codes(&self) -> &[i32] {
        &self.codes
    }

    /// The codes that another input of the converter would have given then.
    pub fn codes_of(&self, input: Input) -> Vec<i32> {
        match input {
            Input::Element => self.codes.clone(),
            Input::Shorted => self.front_end.codes_without_elements(0),
            Input::Reference => self.front_end.codes_without_elements(REFERENCE_CODE),
        }
    }

    pub fn truth(&self) -> Truth {
        let flows = self.body.flows().clone();
        Truth {
            time_s: self.time_s(),
            element_temperature_c: self.element_temperature_c.clone(),
            surface_temperature_c: (0..flows.convection_w.len()).map(|i| self.body.surface_temperature_c(i)).collect(),
            power_w: flows.power_w,
            convection_w: flows.convection_w,
            radiation_w: flows.radiation_w,
            conduction_w: flows.conduction_w,
            support_w: flows.support_w,
            gas_temperature_c: self.gas_temperature_c(),
            wind_m_s: self.wind_m_s,
            wind_extrapolated: self.wind_extrapolated(),
        }
    }

    /// Names of the surfaces that the wind cools.
    pub fn surface_names(&self) -> impl Iterator<Item = &str> {
        self.body.surface_names()
    }

    /// Wind of the last period, m/s.
    pub fn wind_m_s(&self) -> [f64; 3] {
        self.wind_m_s
    }

    /// Temperature of the gas in the last period, °C.
    pub fn gas_temperature_c(&self) -> f64 {
        self.gas_at_c(self.tick.saturating_sub(1))
    }

    /// Whether the gas's temperature swings.
    pub fn gas_swings(&self) -> bool {
        self.gas_swing.is_some()
    }

    /// The wind of the last period was beyond what is known of convection from this body.
    pub fn wind_extrapolated(&self) -> bool {
        self.body.extrapolated(self.wind_m_s)
    }

    /// Label of the wind entry of the last period.
    pub fn wind_label(&self) -> &str {
        self.wind.label()
    }

    /// Time since the start, s.
    pub fn time_s(&self) -> f64 {
        self.tick as f64 * self.sample_period_s
    }

    /// Temperature of the gas over the period that begins with a tick, °C.
    fn gas_at_c(&self, tick: u64) -> f64 {
        let offset_k = self.gas_swing.map_or(0.0, |swing| swing.offset_k(tick as f64 * self.sample_period_s));
        self.gas_temperature_c + offset_k
    }

    /// Faults whose time has come, at the resolution of a tick.
    fn apply_faults(&mut self) {
        let now_s = self.time_s() + 1e-6 * self.sample_period_s;
        while let Some(fault) = self.faults.last().copied().filter(|fault| fault.start_s <= now_s) {
            self.front_end.set_fault(fault.element, Some(fault.fault));
            self.faults.pop();
        }
    }

    fn settle_at_low_level(&mut self) {
        self.body.set_wind(self.wind_m_s);
        let front_end = &self.front_end;
        self.body.settle(|i, temperature_c| front_end.power_w(i, temperature_c, false));
        self.sample(0);
    }

    fn sample(&mut self, heaters: u16) {
        for (i, temperature_c) in self.element_temperature_c.iter_mut().enumerate() {
            *temperature_c = self.body.element_temperature_c(i);
        }
        self.front_end.sample(&self.element_temperature_c, heaters, &mut self.codes);
    }
}

/// Refuses a swing that leaves the range in which the gas or its convection is known.
fn check_range(gas: &Gas, swing: &GasSwing, body: &Body) -> Result<(), SensorError> {
    for end_k in [gas.temperature_k - swing.amplitude_k, gas.temperature_k + swing.amplitude_k] {
        let gas = Gas::new(gas.species, gas.pressure_pa, end_k).map_err(|_| {
            let expected = "so small that the gas stays within -123.15 to 126.85 °C, where its properties are known";
            SensorError::out_of_range("gas.swing.amplitude_k", swing.amplitude_k, expected)
        })?;
        body.check_gas(&gas)?;
    }
    Ok(())
}

/// The faults, latest first, so that the next one is the last of the list.
fn checked_faults(faults: &[TimedFault], elements: usize) -> Result<Vec<TimedFault>, SensorError> {
    for (i, fault) in faults.iter().enumerate() {
        if fault.element >= elements {
            let name = format!("faults[{i}].element");
            return Err(SensorError::out_of_range(name, fault.element as f64, "the number of an element, from 0"));
        }
        if !(fault.start_s.is_finite() && fault.start_s >= 0.0) {
            return Err(SensorError::out_of_range(format!("faults[{i}].start_s"), fault.start_s, "zero or more"));
        }
    }
    let mut faults = faults.to_vec();
    faults.sort_by(|a, b| b.start_s.total_cmp(&a.start_s));
    Ok(faults)
}

#[cfg(test)]
mod tests;
