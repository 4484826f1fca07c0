//! The simulated sensor: a sphere of prototype B in a wind tunnel, with its front end.
//!
//! | file | what |
//! |---|---|
//! | [`gas`] | properties of carbon dioxide and air |
//! | [`convection`] | Nusselt number of every sector for any wind vector |
//! | [`network`] | thermal network in f64, integrated; never a diffusive model, so that identification meets something else |
//! | [`sphere`] | prototype B as such a network |
//! | [`wind`] | held entries and turbulence |
//! | [`front_end`] | currents, resistors, converter, faults |
//!
//! [`Sphere`] puts them together. One tick: the controller decides the heater bits, [`Sphere::advance`] lets one sample period pass
//! under them, [`Sphere::codes`] is what the converter then says and [`Sphere::truth`] what nobody but a simulation knows.
//! The same configuration, seed included, gives the same bits.
//!
//! ```
//! use host_sim::sensor::{Sphere, SphereConfig};
//!
//! let mut sphere = Sphere::new(&SphereConfig::default())?;
//! let rest_c = sphere.truth().element_temperature_c[0];
//! for _ in 0..100 {
//!     sphere.advance(0b000001); // sector 1 at its high level, for a second
//! }
//! assert!(sphere.truth().element_temperature_c[0] > rest_c + 0.3);
//! assert!(sphere.codes()[0] > 0);
//! # Ok::<(), host_sim::sensor::SensorError>(())
//! ```

pub mod convection;
pub mod front_end;
pub mod gas;
pub mod network;
pub mod sphere;
pub mod wind;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use convection::{Convection, SECTORS};
use front_end::FrontEnd;
pub use front_end::{ElementConfig, Fault, Imperfections, PlatinumKind};
pub use gas::Species;
use gas::{Gas, ZERO_CELSIUS_K};
pub use sphere::Construction;
use sphere::{Body, Flows};
use wind::Wind;
pub use wind::{Turbulence, WindEntry};

pub const CORES: usize = 2;
/// `sector1` … `sector4`, `core1`, `core2`.
pub const ELEMENTS: usize = SECTORS + CORES;

/// Why a simulated sensor cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    #[error("`{name}` is {value}; it must be {expected}")]
    OutOfRange { name: String, value: f64, expected: &'static str },
    #[error(
        "`gas.pressure_pa` is {pressure_pa}: the gas is no continuum around the sphere (Knudsen number {knudsen:.3}, at most 0.01); \
         {lowest_pressure_pa:.0} Pa or more would be"
    )]
    NotAContinuum { knudsen: f64, pressure_pa: f64, lowest_pressure_pa: f64 },
    #[error(
        "currents of element {element} are {low_a} A low and {high_a} A high; they must be positive and the low one smaller"
    )]
    Currents { element: usize, low_a: f64, high_a: f64 },
    #[error("platinum of element {element}: {source}")]
    Platinum { element: usize, source: dr_core::ConfigError },
}

impl SensorError {
    fn out_of_range(name: impl Into<String>, value: f64, expected: &'static str) -> SensorError {
        SensorError::OutOfRange { name: name.into(), value, expected }
    }
}

/// Everything that a simulated sphere is made from. The default is prototype B in still carbon dioxide of 1000 Pa and −53.15 °C,
/// with a perfect front end.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereConfig {
    pub seed: u64,
    pub sample_period_s: f64,
    pub species: Species,
    pub pressure_pa: f64,
    pub gas_temperature_c: f64,
    pub support_temperature_c: f64,
    pub elements: [ElementConfig; ELEMENTS],
    pub volt_per_code: f64,
    pub imperfections: Imperfections,
    /// In order of `start_s`, the first at 0; none at all is still gas.
    pub wind: Vec<WindEntry>,
    pub faults: Vec<TimedFault>,
    pub construction: Construction,
}

/// A fault that an element has from `start_s` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFault {
    pub element: usize,
    pub fault: Fault,
    pub start_s: f64,
}

impl Default for SphereConfig {
    fn default() -> SphereConfig {
        let element = ElementConfig {
            platinum: PlatinumKind::Linear { resistance_0c_ohm: 175.0, coefficient_per_c: 0.0031 },
            current_low_a: 3e-3,
            current_high_a: 16e-3,
        };
        SphereConfig {
            seed: 0,
            sample_period_s: 0.01,
            species: Species::CarbonDioxide,
            pressure_pa: 1000.0,
            gas_temperature_c: -53.15,
            support_temperature_c: -43.15,
            elements: [element; ELEMENTS],
            volt_per_code: 4.0 / 8_388_608.0,
            imperfections: Imperfections::default(),
            wind: Vec::new(),
            faults: Vec::new(),
            construction: Construction::default(),
        }
    }
}

/// What is really so, at the end of the last sample period; powers and heat flows are means over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    pub time_s: f64,
    /// Chips of the four sectors, then the two cores.
    pub element_temperature_c: [f64; ELEMENTS],
    pub sector_temperature_c: [f64; SECTORS],
    /// Electrical heat of every element.
    pub power_w: [f64; ELEMENTS],
    /// From a sector to the gas.
    pub convection_w: [f64; SECTORS],
    /// From a sector to its surroundings.
    pub radiation_w: [f64; SECTORS],
    /// From a sector to cores and other sectors.
    pub conduction_w: [f64; SECTORS],
    /// From the stem to the support.
    pub support_w: f64,
    pub wind_m_s: [f64; 3],
    /// The wind was beyond the Nusselt table (Re 200), so convection is an extrapolation.
    pub wind_extrapolated: bool,
}

impl Truth {
    /// All heat that leaves a sector: to gas, surroundings and the inside.
    pub fn sector_loss_w(&self, sector: usize) -> f64 {
        self.convection_w[sector] + self.radiation_w[sector] + self.conduction_w[sector]
    }
}

/// A simulated sphere with its front end in the wind tunnel, advanced tick by tick.
#[derive(Clone, Debug)]
pub struct Sphere {
    sample_period_s: f64,
    tick: u64,
    convection: Convection,
    wind: Wind,
    body: Body,
    front_end: FrontEnd,
    faults: Vec<TimedFault>,
    codes: [i32; ELEMENTS],
    flows: Flows,
    wind_m_s: [f64; 3],
}

impl Sphere {
    /// The sphere starts in the steady state of the first wind entry with all elements at their low level, as it is after standing
    /// by for long.
    pub fn new(config: &SphereConfig) -> Result<Sphere, SensorError> {
        let sample_period_s = config.sample_period_s;
        if !(1e-6..=10.0).contains(&sample_period_s) {
            return Err(SensorError::out_of_range("sample_period_s", sample_period_s, "1e-6 to 10"));
        }
        let gas = Gas::new(config.species, config.pressure_pa, config.gas_temperature_c + ZERO_CELSIUS_K)?;
        let convection = Convection::new(&gas, config.construction.diameter_m)?;
        // Streams of one generator: noise does not change when turbulence is switched on, nor the resistors with either.
        let stream = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
            rng.set_stream(number);
            rng
        };
        let wind = Wind::new(&config.wind, sample_period_s, stream(0))?;
        let front_end =
            FrontEnd::new(&config.elements, config.volt_per_code, &config.imperfections, stream(1), stream(2))?;
        let body = Body::new(&config.construction, &gas, config.support_temperature_c + ZERO_CELSIUS_K)?;
        let wind_m_s = wind.mean_m_s();
        let mut sphere = Sphere {
            sample_period_s,
            tick: 0,
            convection,
            wind,
            body,
            front_end,
            faults: checked_faults(&config.faults)?,
            codes: [0; ELEMENTS],
            flows: Flows::default(),
            wind_m_s,
        };
        sphere.apply_faults();
        sphere.settle_at_low_level();
        Ok(sphere)
    }

    /// Lets one sample period pass with the heaters held; bit i of `heaters` is element i at its high level.
    pub fn advance(&mut self, heaters: u16) {
        self.apply_faults();
        self.wind_m_s = self.wind.advance();
        let conductance_w_k = self.convection.sector_conductance_w_k(self.wind_m_s);
        self.body.set_convection(&conductance_w_k);
        let front_end = &self.front_end;
        self.flows = self.body.advance(self.sample_period_s, |i, temperature_c| {
            front_end.power_w(i, temperature_c, heaters >> i & 1 == 1)
        });
        self.tick += 1;
        self.codes = self.front_end.sample(&self.element_temperature_c(), heaters);
    }

    /// The converter's codes at the end of the last period, at the currents of that period; at first at the low level.
    pub fn codes(&self) -> [i32; ELEMENTS] {
        self.codes
    }

    pub fn truth(&self) -> Truth {
        Truth {
            time_s: self.time_s(),
            element_temperature_c: self.element_temperature_c(),
            sector_temperature_c: std::array::from_fn(|i| self.body.sector_temperature_c(i)),
            power_w: self.flows.power_w,
            convection_w: self.flows.convection_w,
            radiation_w: self.flows.radiation_w,
            conduction_w: self.flows.conduction_w,
            support_w: self.flows.support_w,
            wind_m_s: self.wind_m_s,
            wind_extrapolated: self.wind_extrapolated(),
        }
    }

    /// Wind of the last period, m/s.
    pub fn wind_m_s(&self) -> [f64; 3] {
        self.wind_m_s
    }

    /// The wind of the last period was beyond the Nusselt table.
    pub fn wind_extrapolated(&self) -> bool {
        self.convection.extrapolated(self.wind_m_s)
    }

    /// Label of the wind entry of the last period.
    pub fn wind_label(&self) -> &str {
        self.wind.label()
    }

    /// Time since the start, s.
    pub fn time_s(&self) -> f64 {
        self.tick as f64 * self.sample_period_s
    }

    fn element_temperature_c(&self) -> [f64; ELEMENTS] {
        std::array::from_fn(|i| self.body.element_temperature_c(i))
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
        let conductance_w_k = self.convection.sector_conductance_w_k(self.wind_m_s);
        self.body.set_convection(&conductance_w_k);
        let front_end = &self.front_end;
        self.body.settle(|i, temperature_c| front_end.power_w(i, temperature_c, false));
        self.flows = self.body.steady_flows(|i, temperature_c| front_end.power_w(i, temperature_c, false));
        self.codes = self.front_end.sample(&self.element_temperature_c(), 0);
    }
}

/// The faults, latest first, so that the next one is the last of the list.
fn checked_faults(faults: &[TimedFault]) -> Result<Vec<TimedFault>, SensorError> {
    for (i, fault) in faults.iter().enumerate() {
        if fault.element >= ELEMENTS {
            let name = format!("faults[{i}].element");
            return Err(SensorError::out_of_range(name, fault.element as f64, "0 to 5"));
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
