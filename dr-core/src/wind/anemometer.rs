//! The anemometer: it estimates the wind from each tick of the controller.
//!
//! ```text
//! tick ─► quiescent-gas network ─► convective powers q, surfaces Ts ─► conductances G ─► wind
//!   └───► reference element ─► gas temperature ────────────────────────┘
//! ```
//!
//! ```text
//! G   = gain · (q + G_0 (Ts − T_ref)) / (Ts − T_gas)        var G = gain² var q / (Ts − T_gas)²
//! raw = P / (T − T_gas)                                      with P smoothed
//! ```
//!
//! G_0 is the conductance to quiescent gas at the temperature T_ref at which the quiescent-gas
//! network was identified; the network contains it. A gas whose temperature differs from T_ref
//! heats each surface by G_0 times the difference. This term is added here, so that the network
//! needs no gas temperature.
//!
//! Initial state: a head that has stood at its low levels for long. If the head is warmer than
//! that, G is negative at first, because the temperature of its structure is unknown. The estimate
//! then carries the flag `starting` until the slowest relaxation of the network has decayed.
//!
//! `raw` follows from the power alone and contains the slow response of the structure. It is
//! reported beside G and enters no estimate.
//!
//! The anemometer decides nothing: the controller does not read its output.

pub mod command;

mod head_inverse;
mod integrity;
mod output;
mod setup;
mod slow;

use crate::checksum::Checksum;
use crate::control::state::{BOARD_ELEMENTS, MOST_ELEMENTS, RunState, Tick};
use crate::digest::Digest;
use crate::error::{self, ConfigError, Parameter};
use crate::fields::Fields;
use crate::model::convection_observer::{
    ConvectionEstimate, ConvectionObserver, ConvectionObserverState, NO_SUCH_ELEMENT, TickInput,
};
use crate::room::room;
use crate::wind::calibration_uncertainty::ContradictionMemory;
use crate::wind::convection::ConvectionSettings;
use crate::wind::estimate::WindEstimate;
use crate::wind::form::MOST_SURFACES;
use crate::wind::gas::GasState;
use crate::wind::gas_law::{GasLaw, ZERO_CELSIUS_K};
use crate::wind::quality_flags::QualityFlags;
use crate::wind::slow_errors::SurfaceCorrection;
use crate::wind::sphere::SECTORS;
use crate::wind::surface_inverse::{MeasuredConductance, WindState};
use command::{HeadSurface, WindCommand, WindOutputConfig};
use output::PreparedOutput;
use setup::AnemometerSetup;

/// Least overheat of a surface that enters the estimate, K.
const LEAST_OVERHEAT_K: f32 = 1.0;
/// After a warm start the estimate is `starting` for this many time constants of the network's
/// slowest rate: 5 % of the initial error is left then.
const STARTING_WARM: f32 = 3.0;

/// Settings that are verified piece by piece, beside those of the network.
const OTHER_PIECES: usize = 3;
/// Pieces of the largest instrument.
const MOST_PIECES: usize = ConvectionObserver::<{ room(BOARD_ELEMENTS, MOST_ELEMENTS) }>::PIECES + OTHER_PIECES;

/// The wind estimate of one tick, with the quantities from which it was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindTick {
    /// Number of valid entries in the lists below.
    pub surfaces: u8,
    /// Conductances of the surfaces to the gas, W/K; zero for a surface that is not measured.
    pub conductance_w_k: [f32; MOST_SURFACES],
    /// The same from the power alone, W/K.
    pub raw_w_k: [f32; MOST_SURFACES],
    /// Variances of the first conductances by the noise of the readings, W²/K²; zero as above.
    pub variance_w2_k2: [f32; SECTORS],
    /// Overheats of the first surfaces, K; zero as above.
    pub overheat_k: [f32; SECTORS],
    /// Temperature of the gas, °C; zero if it is not known.
    pub gas_c: f32,
    /// The wind estimate.
    pub wind: WindEstimate,
    /// Quality flags of the estimate.
    pub quality_flags: QualityFlags,
}

/// The anemometer of an instrument of up to N elements. At first it has no head, and outputs
/// nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Anemometer<const N: usize> {
    network: ConvectionObserver<N>,
    setup: AnemometerSetup,
    /// Set by the last command of the set-up.
    output: Option<PreparedOutput>,
    pressure_pa: Option<f32>,
    given_gas_c: Option<f32>,
    /// Corrections of slow errors, by the head's table or, off line, by what was found in a
    /// recording.
    corrections: Option<[SurfaceCorrection; SECTORS]>,
    state: AnemometerState<N>,
    /// Checksums of all pieces; set with the first command. Checksums in the constructor would make
    /// the compiler build the large value on the stack and copy it.
    checksums: Option<[Checksum; MOST_PIECES]>,
}

/// State of the anemometer.
#[derive(Debug, Clone, Copy, PartialEq)]
struct AnemometerState<const N: usize> {
    network: ConvectionObserverState<N>,
    /// Levels since the last tick.
    levels: usize,
    /// Ticks in a row without a reading.
    absent_ticks: [u32; N],
    /// Ticks in a row at the same level, of elements that have been heated since the run began.
    level_ticks: [u32; N],
    heated: usize,
    /// Ticks since the network began, and how many of them it is starting.
    ticks: u32,
    starting_ticks: u32,
    gas_c: Option<f32>,
    /// Smoothed powers, W.
    power_w: [f32; N],
    wind: WindState,
    contradictions: ContradictionMemory,
}

impl<const N: usize> Default for AnemometerState<N> {
    fn default() -> Self {
        Self {
            network: ConvectionObserverState::default(),
            levels: 0,
            absent_ticks: [0; N],
            level_ticks: [0; N],
            heated: 0,
            ticks: 0,
            starting_ticks: 0,
            gas_c: None,
            power_w: [0.0; N],
            wind: WindState::default(),
            contradictions: ContradictionMemory::default(),
        }
    }
}

impl<const N: usize> Anemometer<N> {
    /// Resets the state; head and gas stay.
    pub fn restart(&mut self) {
        self.state = AnemometerState::default();
    }

    /// Carries out a command; `sample_period_s` is the controller's.
    ///
    /// # Errors
    /// Names the number that is wrong or missing, and changes nothing.
    pub fn handle(&mut self, command: &WindCommand, sample_period_s: f32) -> Result<(), ConfigError> {
        match command {
            WindCommand::SelfHeating { element, config } => {
                self.network.set_self_heating(usize::from(*element), config, sample_period_s)?;
            }
            WindCommand::FasterGains(config) => self.network.set_faster_gains(config, sample_period_s)?,
            WindCommand::CrossHeating(config) => self.network.set_cross_heating(config, sample_period_s)?,
            WindCommand::NusseltPoint { point, amplitudes } => self.setup.set_point(*point, *amplitudes)?,
            WindCommand::Surface { surface, config } => {
                if !self.network.knows(usize::from(config.element)) {
                    return Err(NO_SUCH_ELEMENT);
                }
                self.setup.set_surface(*surface, config)?;
            }
            WindCommand::Card(config) => self.setup.card = Some(*config),
            WindCommand::Form(form) => self.setup.form = *form,
            WindCommand::Uncertainty(uncertainty) => self.setup.uncertainty = Some(uncertainty.checked()?),
            WindCommand::Convection(config) => self.setup.convection = Some(ConvectionSettings::new(config)?),
            WindCommand::Correction(corrections) => {
                for correction in corrections {
                    correction.checked()?;
                }
                self.corrections = Some(*corrections);
            }
            WindCommand::GasLaw(config) => self.setup.gas_law = Some(GasLaw::new(config)?),
            WindCommand::Output(config) => {
                self.output = Some(self.setup.prepare::<N>(config, sample_period_s)?);
                self.restart();
            }
            WindCommand::Gas { pressure_pa, temperature_c } => {
                error::positive(Parameter::PressurePa, *pressure_pa)?;
                if let Some(temperature_c) = *temperature_c {
                    error::within(Parameter::GasTemperatureC, temperature_c, -273.15, 1e4)?;
                }
                (self.pressure_pa, self.given_gas_c) = (Some(*pressure_pa), *temperature_c);
                self.update_given_checksum();
                return Ok(());
            }
        }
        self.update_checksums();
        Ok(())
    }

    /// Processes a tick of the controller; returns an estimate at the end of each output interval.
    ///
    /// `standing_w` returns the power of an element at its low level and a temperature. It is
    /// called once, for the initial state: a run begins after a long standby.
    pub fn step(&mut self, tick: &Tick<N>, standing_w: impl Fn(usize, f32) -> f32) -> Option<WindTick> {
        let output = self.output.as_ref()?;
        let state = &mut self.state;
        let was_initialised = self.network.is_initialised(&state.network);
        let standing_w = match was_initialised {
            true => [0.0; N],
            false => core::array::from_fn(|i| standing_w(i, tick.temperature_c[i])),
        };
        let input = TickInput {
            temperature_c: &tick.temperature_c,
            valid: tick.valid,
            read_high: state.levels,
            power_w: &tick.power_w,
            standing_w: &standing_w,
        };
        let convection = self.network.step(&mut state.network, &input);
        state.count(tick);
        if !was_initialised {
            state.ticks = 0;
        }
        state.smooth(output, tick, convection.is_some());
        if !was_initialised && let Some(convection) = &convection {
            self.state.starting_ticks = self.starting_ticks(output, convection);
        }
        if !tick.tick.is_multiple_of(u32::from(output.config.output_interval_ticks)) {
            return None;
        }
        let mut wind = self.state.wind;
        let mut report = self.report(output, tick, convection.as_ref(), &mut wind);
        self.state.wind = wind;
        if self.setup.uncertainty.is_some() {
            report.quality_flags = self.state.contradictions.with(report.quality_flags, output.memory_gain);
        }
        Some(report)
    }

    /// The estimate at a tick; `wind` becomes what the next one begins with.
    fn report(
        &self,
        output: &PreparedOutput,
        tick: &Tick<N>,
        convection: Option<&ConvectionEstimate<N>>,
        wind: &mut WindState,
    ) -> WindTick {
        let gas_c = self.gas_c(output);
        let mut quality_flags = QualityFlags::default()
            .with(QualityFlags::NOT_RUNNING, tick.state != RunState::Running)
            .with(QualityFlags::STARTING, convection.is_none() || self.state.ticks < self.state.starting_ticks)
            .with(QualityFlags::SATURATED, self.is_saturated(output))
            .with(QualityFlags::UNCALIBRATED, output.head.is_none());
        let mut report = WindTick {
            surfaces: output.config.surfaces,
            conductance_w_k: [0.0; MOST_SURFACES],
            raw_w_k: [0.0; MOST_SURFACES],
            variance_w2_k2: [0.0; SECTORS],
            overheat_k: [0.0; SECTORS],
            gas_c: gas_c.unwrap_or(0.0),
            wind: WindEstimate::none(),
            quality_flags,
        };
        let mut measured = [None; MOST_SURFACES];
        let (mut overheat_sum_k, mut warm) = (0.0, 0.0_f32);
        if let (Some(convection), Some(gas_c)) = (convection, gas_c) {
            for (p, part) in self.setup.surfaces().enumerate().take(usize::from(output.config.surfaces)) {
                let i = usize::from(part.element);
                // Every surface belongs to an element of the network. The check lets the compiler
                // drop a panic.
                if i >= N || p >= MOST_SURFACES {
                    continue;
                }
                let overheat_k = convection.surface_c[i] - gas_c;
                if overheat_k < LEAST_OVERHEAT_K {
                    quality_flags = quality_flags.with(QualityFlags::COLD, true);
                    continue;
                }
                overheat_sum_k += overheat_k;
                warm += 1.0;
                let raw_k = tick.temperature_c[i] - gas_c;
                if raw_k >= LEAST_OVERHEAT_K {
                    report.raw_w_k[p] = self.state.power_w[i] / raw_k;
                }
                if self.state.absent_ticks[i] > output.reading_timeout_ticks {
                    continue;
                }
                let mut conductance_w_k = part.gain * flow_w(part, output, convection) / overheat_k;
                let share = part.gain / overheat_k;
                let noise_w2_k2 = share * share * convection.variance_w2[i];
                let mut variance_w2_k2 = noise_w2_k2;
                if let Some(correction) = self.corrections.as_ref().and_then(|of| of.get(p)) {
                    variance_w2_k2 += correction.variance_w2_k2(conductance_w_k, share);
                    conductance_w_k = correction.corrected_w_k(conductance_w_k, share);
                }
                report.conductance_w_k[p] = conductance_w_k;
                if let (Some(variance), Some(overheat)) =
                    (report.variance_w2_k2.get_mut(p), report.overheat_k.get_mut(p))
                {
                    (*variance, *overheat) = (noise_w2_k2, overheat_k);
                }
                measured[p] = Some(MeasuredConductance { conductance_w_k, variance_w2_k2 });
            }
        }
        let overheat_k = overheat_sum_k / warm.max(1.0);
        let gas = self.gas(gas_c, overheat_k);
        quality_flags = quality_flags.with(QualityFlags::NO_GAS, gas.is_none());
        if let (Some(head), Some(gas), Some(gas_c)) = (&output.head, gas, gas_c) {
            let WindOutputConfig { diameter_m, direction_error_max_rad, .. } = output.config;
            report.wind = head.step(wind, &gas, &measured);
            if let Some(convection) = &self.setup.convection {
                let free_stream = &convection.free_stream;
                let rise_speed_m_s = free_stream.rise_speed_m_s(overheat_k, gas_c + ZERO_CELSIUS_K, diameter_m);
                report.wind = free_stream.described(report.wind, rise_speed_m_s, direction_error_max_rad);
            }
            if let (Some(uncertainty), Some(scale)) =
                (&self.setup.uncertainty, self.setup.scale(&output.config, &gas, gas_c))
            {
                report.wind = uncertainty.added_to(report.wind, &measured, &scale, direction_error_max_rad);
            }
        }
        report.quality_flags = quality_flags.with(report.wind.quality, true);
        report
    }

    /// Ticks for which a network that was just initialised is starting: more if the heat flow of a
    /// surface is negative, which only a warm structure explains.
    fn starting_ticks(&self, output: &PreparedOutput, convection: &ConvectionEstimate<N>) -> u32 {
        let gas_c = self.gas_c(output).unwrap_or(output.config.reference_gas_c);
        // Every surface belongs to an element. The check lets the compiler drop a panic.
        let mut surfaces =
            self.setup.surfaces().take(usize::from(output.config.surfaces)).filter(|p| usize::from(p.element) < N);
        let is_warm = surfaces.any(|part| {
            let overheat_k = convection.surface_c[usize::from(part.element)] - gas_c;
            overheat_k >= LEAST_OVERHEAT_K && flow_w(part, output, convection) < -part.windless_w_k * LEAST_OVERHEAT_K
        });
        let settling_ticks = if is_warm { (STARTING_WARM * self.network.slowest_ticks()) as u32 } else { 0 };
        output.starting_ticks.max(settling_ticks)
    }

    /// Convective power of an element, or what a core loses on unknown ways, W.
    pub fn convection_w(&self, element: usize) -> Option<f32> {
        self.state.network.convection_w(element)
    }

    /// Tells whether an element with a surface has been at one level for too long. A core that
    /// loses its fight with a warm support does no harm: its temperature is read, and its heat is
    /// not taken for known.
    fn is_saturated(&self, output: &PreparedOutput) -> bool {
        let mut level_ticks = self.state.level_ticks.iter().enumerate();
        level_ticks.any(|(i, &ticks)| {
            ticks > output.saturated_ticks
                && self.network.knows(i)
                && self.setup.surfaces().any(|part| usize::from(part.element) == i)
        })
    }

    /// Temperature of the gas, measured or given, °C.
    fn gas_c(&self, output: &PreparedOutput) -> Option<f32> {
        let Some(reference) = output.config.reference else { return self.given_gas_c };
        let absent_ticks = *self.state.absent_ticks.get(usize::from(reference))?;
        self.state.gas_c.filter(|_| absent_ticks <= output.reference_timeout_ticks)
    }

    /// The gas, with its properties where the head takes them.
    fn gas(&self, gas_c: Option<f32>, overheat_k: f32) -> Option<GasState> {
        let properties_c = match &self.setup.convection {
            Some(convection) => convection.properties_c(gas_c?, overheat_k),
            None => gas_c?,
        };
        self.setup.gas_law.as_ref()?.at(self.pressure_pa?, properties_c).ok()
    }

    /// Ticks from one estimate to the next; none before the set-up is complete.
    pub fn output_interval_ticks(&self) -> Option<u16> {
        self.output.as_ref().map(|output| output.config.output_interval_ticks)
    }

    /// Adds the state of an instrument of so many elements and the estimate to a digest; nothing
    /// before the set-up is complete.
    pub fn digest(&self, elements: u8, report: Option<&WindTick>, digest: &mut Digest) {
        if self.output.is_none() {
            return;
        }
        self.network.visit_state(&self.state.network, digest);
        self.state.gas_c.unwrap_or(0.0).visit(digest);
        // All of a board, whose room digests have had since there was no more.
        let powers_w = self.state.power_w.get(..usize::from(elements).max(BOARD_ELEMENTS));
        f32::visit_each(powers_w.unwrap_or(&self.state.power_w), digest);
        if let Some(report) = report {
            let WindTick { conductance_w_k, raw_w_k, wind, quality_flags, surfaces, .. } = report;
            quality_flags.0.visit(digest);
            // At least four of each, as digests have had since there were no more.
            let count = usize::from(*surfaces).clamp(4, MOST_SURFACES);
            for of_each in [conductance_w_k, raw_w_k] {
                f32::visit_each(of_each.get(..count).unwrap_or(of_each), digest);
            }
            (wind.wind_m_s, wind.covariance_m2_s2).visit(digest);
            wind.speed_m_s.visit(digest);
        }
    }
}

/// Heat flow from a surface into the gas, before its gain, W.
fn flow_w<const N: usize>(part: &HeadSurface, output: &PreparedOutput, convection: &ConvectionEstimate<N>) -> f32 {
    let i = usize::from(part.element);
    let to_reference_k = convection.surface_c[i] - output.config.reference_gas_c;
    convection.power_w[i] + part.windless_w_k * to_reference_k
}

impl<const N: usize> AnemometerState<N> {
    /// Updates the counters.
    fn count(&mut self, tick: &Tick<N>) {
        // An element that is not controlled, or was never heated, cannot saturate.
        self.heated = if tick.state == RunState::Running { self.heated | tick.heaters.0 } else { 0 };
        for i in 0..usize::from(tick.elements).min(N) {
            let absent = &mut self.absent_ticks[i];
            *absent = if tick.valid >> i & 1 == 1 { 0 } else { absent.saturating_add(1) };
            let same = (tick.heaters.0 ^ self.levels) >> i & 1 == 0;
            let level = &mut self.level_ticks[i];
            *level = if same && self.heated >> i & 1 == 1 { level.saturating_add(1) } else { 0 };
        }
        self.levels = tick.heaters.0;
    }

    /// Gas temperature and powers.
    fn smooth(&mut self, output: &PreparedOutput, tick: &Tick<N>, initialised: bool) {
        if let Some(reference) = output.config.reference.map(usize::from)
            && tick.valid >> reference & 1 == 1
            && let Some(&read_c) = tick.temperature_c.get(reference)
        {
            self.gas_c = Some(match self.gas_c {
                Some(gas_c) => gas_c + output.gas_share * (read_c - gas_c),
                None => read_c,
            });
        }
        if !initialised {
            return;
        }
        for (smooth_w, power_w) in self.power_w.iter_mut().zip(tick.power_w) {
            if power_w.is_finite() {
                *smooth_w += output.power_share * (power_w - *smooth_w);
            }
        }
        self.ticks = self.ticks.saturating_add(1);
    }
}

#[cfg(test)]
mod tests;
