//! A simulated sensor tick by tick: wind and gas into its body, heater bits into powers,
//! temperatures into codes.
//!
//! One tick: the controller decides the heater bits, [`Sensor::advance`] lets one sample period
//! pass under them, [`Sensor::codes`] is what the converter then reads and [`Sensor::truth`] what
//! only a simulation knows.

use anemometry::gas::{IdealGas, ZERO_CELSIUS_K};
use dr_core::sensor::FrontEndInput;
use dr_core::sensor::reading::REFERENCE_CODE;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::body::{Flows, ThermalBody};
use super::config::{SensorConfig, TemperatureSwing, TimedFault};
use super::error::{SensorError, require};
use super::field::AppliedField;
use super::front_end::SimulatedFrontEnd;
use super::wind::SimulatedWind;

/// More steps of the integration in a sample period would take for ever.
const MOST_SUBSTEPS: usize = 20_000;

/// A simulated sensor with its front end in the wind tunnel, advanced tick by tick.
#[derive(Clone, Debug)]
pub struct Sensor {
    sample_period_s: f64,
    tick: u64,
    wind: SimulatedWind,
    pub(super) body: ThermalBody,
    gas_temperature_c: f64,
    /// About that temperature.
    gas_swing: Option<TemperatureSwing>,
    support_temperature_c: f64,
    support_swing: Option<TemperatureSwing>,
    front_end: SimulatedFrontEnd,
    faults: Vec<TimedFault>,
    field: AppliedField,
    element_temperature_c: Vec<f64>,
    codes: Vec<i32>,
    wind_m_s: [f64; 3],
}

impl Sensor {
    /// The sensor starts in the steady state of the first wind entry with all elements at their low
    /// level, as it is after standing by for long.
    pub fn new(config: &SensorConfig) -> Result<Sensor, SensorError> {
        let sample_period_s = config.sample_period_s;
        require((1e-6..=10.0).contains(&sample_period_s), "sample_period_s", sample_period_s, "1e-6 to 10")?;
        let (expected, found) = (config.construction.elements().len(), config.elements.len());
        if found != expected {
            let sensor = config.construction.name();
            return Err(SensorError::Elements(format!("{found} elements are given, but `{sensor}` has {expected}")));
        }
        let gas = IdealGas::new(config.species, config.pressure_pa, config.gas_temperature_c + ZERO_CELSIUS_K)?;
        // Streams of one generator: noise does not change when turbulence is switched on, nor the
        // resistors with either.
        let stream = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
            rng.set_stream(number);
            rng
        };
        let wind = SimulatedWind::new(&config.wind, sample_period_s, stream(0))?;
        let parts = config.construction.elements();
        let elements: Vec<_> = parts.iter().map(|part| part.name.as_str()).zip(config.elements.clone()).collect();
        let front_end =
            SimulatedFrontEnd::new(&elements, config.volt_per_code, &config.imperfections, stream(1), stream(2))?;
        let mut body = config.construction.body(&gas, config.support_temperature_c + ZERO_CELSIUS_K, config.seed)?;
        let field = AppliedField::new(&config.field, &config.construction, &mut body)?;
        if let Some(swing) = &config.gas_swing {
            swing.check("gas", sample_period_s)?;
            check_range(&gas, swing, config)?;
        }
        if let Some(swing) = &config.support_swing {
            swing.check("support", sample_period_s)?;
        }
        let wind_m_s = wind.mean_m_s();
        let mut sensor = Sensor {
            sample_period_s,
            tick: 0,
            wind,
            body,
            gas_temperature_c: config.gas_temperature_c,
            gas_swing: config.gas_swing,
            support_temperature_c: config.support_temperature_c,
            support_swing: config.support_swing,
            front_end,
            faults: checked_faults(&config.faults, expected)?,
            field,
            element_temperature_c: vec![0.0; expected],
            codes: vec![0; expected],
            wind_m_s,
        };
        sensor.apply_faults();
        sensor.field.apply(0.0, &mut sensor.body, &mut sensor.front_end);
        sensor.body.set_wind(wind_m_s);
        let substeps = sensor.body.substeps(sample_period_s);
        if substeps > MOST_SUBSTEPS {
            let fastest_s = sensor.body.time_constants_s().last().copied().unwrap_or(0.0);
            return Err(SensorError::Elements(format!(
                "its fastest part has a time constant of {fastest_s:.1e} s, which takes {substeps} steps in every sample \
                 period: join small nodes to what they sit on"
            )));
        }
        sensor.front_end.hold(0);
        let front_end = &sensor.front_end;
        sensor.body.settle(|i, temperature_c| front_end.power_w(i, temperature_c));
        sensor.sample(0);
        Ok(sensor)
    }

    /// Lets one sample period pass with the heaters held; bit i of `heaters` is element i at its
    /// high level.
    pub fn advance(&mut self, heaters: usize) {
        self.apply_faults();
        self.wind_m_s = self.wind.advance();
        if self.gas_swing.is_some() {
            self.body.set_gas_temperature_k(self.gas_at_c(self.tick) + ZERO_CELSIUS_K);
        }
        if let Some(swing) = self.support_swing {
            let support_c = self.support_temperature_c + swing.offset_k(self.time_s());
            self.body.set_support_temperature_k(support_c + ZERO_CELSIUS_K);
        }
        self.field.apply(self.time_s(), &mut self.body, &mut self.front_end);
        self.body.set_wind(self.wind_m_s);
        self.front_end.hold(heaters);
        let front_end = &self.front_end;
        self.body.advance(self.sample_period_s, |i, temperature_c| front_end.power_w(i, temperature_c));
        self.tick += 1;
        self.sample(heaters);
    }

    /// The converter's codes at the end of the last period, at the currents of that period; at
    /// first at the low level.
    pub fn codes(&self) -> &[i32] {
        &self.codes
    }

    /// The codes that another input of the converter would have given then.
    pub fn codes_of(&self, input: FrontEndInput) -> Vec<i32> {
        match input {
            FrontEndInput::Element => self.codes.clone(),
            FrontEndInput::Shorted => self.front_end.codes_without_elements(0),
            FrontEndInput::Reference => self.front_end.codes_without_elements(REFERENCE_CODE),
        }
    }

    /// The true state at the end of the last period.
    pub fn truth(&self) -> SensorTruth {
        let surfaces = 0..self.body.surface_names().count();
        SensorTruth {
            time_s: self.time_s(),
            element_temperature_c: self.element_temperature_c.clone(),
            surface_temperature_c: surfaces.map(|i| self.body.surface_temperature_c(i)).collect(),
            flows: self.body.flows().clone(),
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

    /// Tells whether the gas's temperature swings.
    pub fn gas_swings(&self) -> bool {
        self.gas_swing.is_some()
    }

    /// The wind of the last period was beyond what is known of convection from this body.
    pub fn wind_extrapolated(&self) -> bool {
        self.body.extrapolated(self.wind_m_s)
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

    fn sample(&mut self, heaters: usize) {
        for (i, temperature_c) in self.element_temperature_c.iter_mut().enumerate() {
            *temperature_c = self.body.element_temperature_c(i);
        }
        self.front_end.sample(&self.element_temperature_c, heaters, &mut self.codes);
    }
}

/// Refuses a swing that leaves the range in which the gas or its convection is known.
fn check_range(gas: &IdealGas, swing: &TemperatureSwing, config: &SensorConfig) -> Result<(), SensorError> {
    for end_k in [gas.temperature_k - swing.amplitude_k, gas.temperature_k + swing.amplitude_k] {
        let gas = IdealGas::new(gas.species, gas.pressure_pa, end_k).map_err(|_| {
            let expected = "so small that the gas stays within -123.15 to 126.85 °C, where its properties are known";
            SensorError::out_of_range("gas.swing.amplitude_k", swing.amplitude_k, expected)
        })?;
        config.construction.body(&gas, config.support_temperature_c + ZERO_CELSIUS_K, config.seed)?;
    }
    Ok(())
}

/// The faults, latest first, so that the next one is the last of the list.
fn checked_faults(faults: &[TimedFault], elements: usize) -> Result<Vec<TimedFault>, SensorError> {
    for (i, fault) in faults.iter().enumerate() {
        let (known, element) = (fault.element < elements, fault.element as f64);
        require(known, &format!("faults[{i}].element"), element, "the number of an element, from 0")?;
        let later = fault.start_s.is_finite() && fault.start_s >= 0.0;
        require(later, &format!("faults[{i}].start_s"), fault.start_s, "zero or more")?;
    }
    let mut faults = faults.to_vec();
    faults.sort_by(|a, b| b.start_s.total_cmp(&a.start_s));
    Ok(faults)
}

/// The true state at the end of the last sample period; powers and heat flows are means over it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorTruth {
    /// Since the start, s.
    pub time_s: f64,
    /// Temperature of every element, °C.
    pub element_temperature_c: Vec<f64>,
    /// Temperature of every surface, in the order of
    /// [`Sensor::surface_names`](super::Sensor::surface_names).
    pub surface_temperature_c: Vec<f64>,
    /// Mean heat flows.
    pub flows: Flows,
    /// Temperature of the gas, °C.
    pub gas_temperature_c: f64,
    /// Wind vector, m/s.
    pub wind_m_s: [f64; 3],
    /// The wind was beyond what is known of convection from this body, which is then an
    /// extrapolation.
    pub wind_extrapolated: bool,
}

impl SensorTruth {
    /// All heat that leaves a surface: to gas, surroundings and the inside.
    pub fn surface_loss_w(&self, surface: usize) -> f64 {
        self.flows.convection_w[surface] + self.flows.radiation_w[surface] + self.flows.conduction_w[surface]
    }
}
