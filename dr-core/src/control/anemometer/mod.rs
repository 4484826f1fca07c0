//! The anemometer: from a tick of the controller to the wind.
//!
//! ```text
//! tick ──► windless network ──► convective powers q, surfaces Ts ──► conductances G ──► wind vector
//!   └────► reference element ──► gas temperature ─────────────────────────┘
//! ```
//!
//! ```text
//! G   = gain · (q + G_0 (Ts − T_ref)) / (Ts − T_gas)        var G = gain² var q / (Ts − T_gas)²
//! raw = P / (T − T_gas)                                      with P smoothed
//! ```
//!
//! G_0 is the conductance to still gas at the reference's temperature T_ref, at which the windless network was identified and which it
//! therefore contains. A gas that moves away from T_ref heats each surface by G_0 times that; so it enters here, and the network does
//! not have to follow it.
//!
//! The network begins as if the head had stood at its low levels for long. If it is warm already, sooner than that explains, G comes out below
//! zero at first: how warm the structure is nobody knows, and the answer is `starting` until its slowest rate has forgotten it.
//!
//! `raw` is what the power says by itself, slow tail of the structure included; it is told beside G and used for nothing.
//!
//! Answers are only made; they decide nothing. The controller never looks here.

mod command;
mod doubts;
mod head;
mod seals;
mod setup;

pub use command::{AnswerConfig, PartOfHead, WindCommand};
pub use doubts::Doubts;

use super::controller::{RunState, Tick};
use super::digest::Digest;
use crate::error::ConfigError;
use crate::model::{Convection, Look, Network, NetworkState};
use crate::sensor::wind::{Gas, Measured, Wind, WindState};
use head::Head;
use seals::Seals;
use setup::Setup;

/// Most parts of a head that answers.
pub const MOST_PARTS: usize = 4;

/// A part less warmer than the gas than this tells nothing, K.
const LEAST_OVERHEAT_K: f32 = 1.0;
/// An element that has not been read for so long is left out, s.
const PATIENCE_S: f32 = 0.05;
/// A reference that has not been read for so long is not believed, s.
const REFERENCE_PATIENCE_S: f32 = 1.0;
/// An element at one level for so long is saturated, s.
const SATURATED_S: f32 = 1.0;
/// The observer is told to be starting for so many smoothing times of the raw power.
const STARTING: f32 = 10.0;
/// After a warm beginning, for so many time constants of the network's slowest rate: then a twentieth of what was not known is left.
const STARTING_WARM: f32 = 3.0;

/// What is said of the wind at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindTick {
    /// How many of the entries below mean something.
    pub parts: u8,
    /// Conductances of the parts to the gas, W/K; zero for a part that is not measured.
    pub conductance_w_k: [f32; MOST_PARTS],
    /// The same from the power alone, W/K.
    pub raw_w_k: [f32; MOST_PARTS],
    /// Temperature of the gas, °C; zero if it is not known.
    pub gas_c: f32,
    /// The wind.
    pub wind: Wind,
    /// What is to be doubted.
    pub doubts: Doubts,
}

/// The anemometer of an instrument of up to N elements.
#[derive(Debug, Clone, PartialEq)]
pub struct Anemometer<const N: usize> {
    network: Network<N>,
    setup: Setup,
    /// From the last command of the set-up on.
    answer: Option<Answer>,
    pressure_pa: Option<f32>,
    told_gas_c: Option<f32>,
    state: State<N>,
    seals: Seals<N>,
}

/// How it answers, made ready.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Answer {
    config: AnswerConfig,
    head: Option<Head>,
    /// Shares of a new reading of the reference and of a new power.
    gas_share: f32,
    power_share: f32,
    patience_ticks: u32,
    reference_patience_ticks: u32,
    saturated_ticks: u32,
    starting_ticks: u32,
}

/// What it remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State<const N: usize> {
    network: NetworkState<N>,
    /// Levels since the last tick.
    levels: u16,
    /// Ticks in a row without a reading.
    absent_ticks: [u32; N],
    /// Ticks in a row at the same level, of elements that have been heated since the run began.
    level_ticks: [u32; N],
    heated: u16,
    /// Ticks since the network began, and how many of them it is starting.
    ticks: u32,
    starting_ticks: u32,
    gas_c: Option<f32>,
    /// Smoothed powers, W.
    power_w: [f32; N],
    wind: WindState,
}

impl<const N: usize> Default for State<N> {
    fn default() -> Self {
        Self {
            network: NetworkState::default(),
            levels: 0,
            absent_ticks: [0; N],
            level_ticks: [0; N],
            heated: 0,
            ticks: 0,
            starting_ticks: 0,
            gas_c: None,
            power_w: [0.0; N],
            wind: WindState::default(),
        }
    }
}

impl<const N: usize> Default for Anemometer<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Anemometer<N> {
    /// One that knows no head yet and has nothing to say.
    pub fn new() -> Self {
        Self {
            network: Network::default(),
            setup: Setup::default(),
            answer: None,
            pressure_pa: None,
            told_gas_c: None,
            state: State::default(),
            seals: Seals::default(),
        }
    }

    /// Whether it has been set up to answer.
    pub const fn answers(&self) -> bool {
        self.answer.is_some()
    }

    /// Begins anew, with the same head and gas.
    pub fn restart(&mut self) {
        self.state = State::default();
    }

    /// Carries out a command; `sample_period_s` is the controller's.
    ///
    /// # Errors
    /// Names the number that is wrong or missing, and changes nothing.
    pub fn handle(&mut self, command: &WindCommand, sample_period_s: f32) -> Result<(), ConfigError> {
        match command {
            WindCommand::Own { element, config } => {
                self.network.set_own(usize::from(*element), config, sample_period_s)?;
            }
            WindCommand::Faster(config) => self.network.set_faster(config, sample_period_s)?,
            WindCommand::Cross(config) => self.network.set_cross(config, sample_period_s)?,
            WindCommand::Point { point, amplitudes } => self.setup.set_point(*point, *amplitudes)?,
            WindCommand::Part { part, config } => {
                setup::check_element(self.network.knows(usize::from(config.element)))?;
                self.setup.set_part(*part, config)?;
            }
            WindCommand::Card(config) => self.setup.set_card(config),
            WindCommand::GasLaw(config) => self.setup.set_gas_law(config)?,
            WindCommand::Answer(config) => {
                self.answer = Some(self.setup.answer::<N>(config, sample_period_s)?);
                self.restart();
            }
            WindCommand::Gas { pressure_pa, temperature_c } => {
                setup::check_gas(*pressure_pa, *temperature_c)?;
                (self.pressure_pa, self.told_gas_c) = (Some(*pressure_pa), *temperature_c);
                self.seal_gas();
                return Ok(());
            }
        }
        self.seal_all();
        Ok(())
    }

    /// Follows a tick of the controller; gives an answer where one is due.
    ///
    /// A run begins after a long standby: `standing_w` is the power of an element at its low level and this temperature. It is asked
    /// for once.
    pub fn step(&mut self, tick: &Tick<N>, standing_w: impl Fn(usize, f32) -> f32) -> Option<WindTick> {
        let answer = self.answer?;
        let state = &mut self.state;
        let has_begun = self.network.has_begun(&state.network);
        let standing_w = match has_begun {
            true => [0.0; N],
            false => core::array::from_fn(|i| standing_w(i, tick.temperature_c[i])),
        };
        let look = Look {
            temperature_c: &tick.temperature_c,
            valid: tick.valid,
            read_high: state.levels,
            power_w: &tick.power_w,
            standing_w: &standing_w,
        };
        let convection = self.network.step(&mut state.network, &look);
        state.count(tick);
        if !has_begun {
            state.ticks = 0;
        }
        state.smooth(&answer, tick, convection.is_some());
        if !has_begun && let Some(convection) = &convection {
            self.state.starting_ticks = self.starting_ticks(&answer, convection);
        }
        if !tick.tick.is_multiple_of(u32::from(answer.config.every_ticks)) {
            return None;
        }
        Some(self.tell(&answer, tick, convection.as_ref()))
    }

    /// The answer at a tick.
    fn tell(&mut self, answer: &Answer, tick: &Tick<N>, convection: Option<&Convection<N>>) -> WindTick {
        let gas_c = self.gas_c(answer);
        let gas = self.gas(gas_c);
        let mut doubts = Doubts::default()
            .with(Doubts::NO_GAS, gas.is_none())
            .with(Doubts::NOT_RUNNING, tick.state != RunState::Running)
            .with(Doubts::STARTING, convection.is_none() || self.state.ticks < self.state.starting_ticks)
            .with(Doubts::SATURATED, self.is_saturated(answer))
            .with(Doubts::UNCALIBRATED, answer.head.is_none());
        let mut told = WindTick {
            parts: answer.config.parts,
            conductance_w_k: [0.0; MOST_PARTS],
            raw_w_k: [0.0; MOST_PARTS],
            gas_c: gas_c.unwrap_or(0.0),
            wind: Wind::none(),
            doubts,
        };
        let mut measured = [None; MOST_PARTS];
        if let (Some(convection), Some(gas_c)) = (convection, gas_c) {
            for (p, part) in self.setup.parts().enumerate().take(usize::from(answer.config.parts)) {
                let i = usize::from(part.element);
                // The network does not know such an element, so no part has it; said for the compiler, which else leaves a panic here.
                if i >= N || p >= MOST_PARTS {
                    continue;
                }
                let overheat_k = convection.surface_c[i] - gas_c;
                if overheat_k < LEAST_OVERHEAT_K {
                    doubts = doubts.with(Doubts::COLD, true);
                    continue;
                }
                let raw_k = tick.temperature_c[i] - gas_c;
                if raw_k >= LEAST_OVERHEAT_K {
                    told.raw_w_k[p] = self.state.power_w[i] / raw_k;
                }
                if self.state.absent_ticks[i] > answer.patience_ticks {
                    continue;
                }
                let conductance_w_k = part.gain * flow_w(part, answer, convection) / overheat_k;
                told.conductance_w_k[p] = conductance_w_k;
                let share = part.gain / overheat_k;
                measured[p] =
                    Some(Measured { conductance_w_k, variance_w2_k2: share * share * convection.variance_w2[i] });
            }
        }
        if let (Some(head), Some(gas)) = (&answer.head, gas) {
            told.wind = head.step(&mut self.state.wind, &gas, &measured);
        }
        told.doubts = Doubts(doubts.0 | Doubts::of(&told.wind.quality).0);
        told
    }

    /// For how long the network that has just begun is starting: longer if a part gives heat to it that it cannot have.
    fn starting_ticks(&self, answer: &Answer, convection: &Convection<N>) -> u32 {
        let gas_c = self.gas_c(answer).unwrap_or(answer.config.reference_gas_c);
        // Parts are of elements that there are; said for the compiler, which else leaves a panic here.
        let mut parts =
            self.setup.parts().take(usize::from(answer.config.parts)).filter(|p| usize::from(p.element) < N);
        let is_warm = parts.any(|part| {
            let overheat_k = convection.surface_c[usize::from(part.element)] - gas_c;
            overheat_k >= LEAST_OVERHEAT_K && flow_w(part, answer, convection) < -part.windless_w_k * LEAST_OVERHEAT_K
        });
        let settling_ticks = if is_warm { (STARTING_WARM * self.network.slowest_ticks()) as u32 } else { 0 };
        answer.starting_ticks.max(settling_ticks)
    }

    /// Whether an element of the network has been at one level for too long.
    fn is_saturated(&self, answer: &Answer) -> bool {
        let mut level_ticks = self.state.level_ticks.iter().enumerate();
        level_ticks.any(|(i, &ticks)| ticks > answer.saturated_ticks && self.network.knows(i))
    }

    /// Temperature of the gas as it is known, °C.
    fn gas_c(&self, answer: &Answer) -> Option<f32> {
        let Some(reference) = answer.config.reference else { return self.told_gas_c };
        let absent_ticks = *self.state.absent_ticks.get(usize::from(reference))?;
        self.state.gas_c.filter(|_| absent_ticks <= answer.reference_patience_ticks)
    }

    fn gas(&self, gas_c: Option<f32>) -> Option<Gas> {
        self.setup.gas_law()?.at(self.pressure_pa?, gas_c?).ok()
    }

    /// Folds all that it knows into a digest. Nothing as long as it does not answer.
    pub fn fold(&self, told: Option<&WindTick>, digest: &mut Digest) {
        if self.answer.is_none() {
            return;
        }
        self.network.each(&self.state.network, &mut |number| digest.number(number));
        digest.number(self.state.gas_c.unwrap_or(0.0));
        self.state.power_w.iter().for_each(|&power_w| digest.number(power_w));
        if let Some(told) = told {
            digest.word(u32::from(told.doubts.0));
            let numbers = told.conductance_w_k.iter().chain(&told.raw_w_k).chain(&told.wind.wind_m_s);
            numbers.chain(told.wind.covariance_m2_s2.as_flattened()).for_each(|&number| digest.number(number));
            digest.number(told.wind.speed_m_s);
        }
    }
}

/// What a part gives to the gas before its gain, W.
fn flow_w<const N: usize>(part: &PartOfHead, answer: &Answer, convection: &Convection<N>) -> f32 {
    let i = usize::from(part.element);
    let to_reference_k = convection.surface_c[i] - answer.config.reference_gas_c;
    convection.power_w[i] + part.windless_w_k * to_reference_k
}

impl<const N: usize> State<N> {
    /// What is counted from tick to tick.
    fn count(&mut self, tick: &Tick<N>) {
        // What is not held, or never heated, has no loop that could be at its end.
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
    fn smooth(&mut self, answer: &Answer, tick: &Tick<N>, begun: bool) {
        if let Some(reference) = answer.config.reference.map(usize::from)
            && tick.valid >> reference & 1 == 1
            && let Some(&read_c) = tick.temperature_c.get(reference)
        {
            self.gas_c = Some(match self.gas_c {
                Some(gas_c) => gas_c + answer.gas_share * (read_c - gas_c),
                None => read_c,
            });
        }
        if !begun {
            return;
        }
        for (smooth_w, power_w) in self.power_w.iter_mut().zip(tick.power_w) {
            if power_w.is_finite() {
                *smooth_w += answer.power_share * (power_w - *smooth_w);
            }
        }
        self.ticks = self.ticks.saturating_add(1);
    }
}

#[cfg(test)]
mod tests;
