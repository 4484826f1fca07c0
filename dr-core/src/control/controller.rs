//! The controller of N elements: one entry a tick, no clock, no pins.
//!
//! ```text
//! readings ──► guard ──► temperatures ──► drives ──► heater levels ──► powers ──► models
//!                └── a bad reading trips all heaters to the low level in the same tick, until acknowledged
//! ```
//!
//! At t_n it is given what the front end read at the end of [t_{n−1}, t_n), and decides the levels that are held over
//! [t_n, t_{n+1}). Power n is I²R of the level decided, at the resistance just read.
//!
//! States: `Standby` → `Running` → `Standby`, and `Tripped` from anywhere. Heaters are low in `Standby` and `Tripped`.

use super::command::{Command, Refusal, Reply};
use super::digest::Digest;
use super::drive::{Drive, DriveInput, DriveState};
use super::guard::{self, Cause, GuardConfig, Judgement, Limits, Trip};
use crate::error::{self, ConfigError, Parameter};
use crate::model::{ORDER, Reachability, RelaxationState, SelfHeating};
use crate::sensor::{Channel, Level, Reading};

/// What the instrument is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RunState {
    /// Sensing, all heaters low.
    #[default]
    Standby,
    /// Driving.
    Running,
    /// All heaters low until acknowledged.
    Tripped(Trip),
}

/// Levels of all elements: bit i is set while element i is at its high level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Heaters(pub u16);

impl Heaters {
    /// Whether element `i` is at its high level.
    pub const fn is_high(self, i: usize) -> bool {
        i < 16 && self.0 >> i & 1 == 1
    }
}

/// An element's wiring and limits.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ElementConfig {
    /// From code to resistance, temperature and power.
    pub channel: Channel,
    /// What is plausible.
    pub limits: Limits,
}

/// What one tick brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick<const N: usize> {
    /// Number of the tick since the start of the run.
    pub tick: u32,
    /// Levels held until the next tick.
    pub heaters: Heaters,
    /// Bit i is set if element i had a good reading in this tick.
    pub valid: u16,
    /// Temperatures at this tick, °C; the last good one where the reading was not, 0 for elements that are not there.
    pub temperature_c: [f32; N],
    /// Heating power held until the next tick, W.
    pub power_w: [f32; N],
    /// The state after this tick.
    pub state: RunState,
    /// The trip that happened in this very tick.
    pub trip: Option<Trip>,
}

/// What an element is, once configured.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Element {
    config: ElementConfig,
    model: Option<SelfHeating>,
    drive: Drive,
}

/// What an element remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct ElementState {
    drive: DriveState,
    level: Level,
    temperature_c: f32,
    resistance_ohm: f32,
    /// Ticks in a row without a fresh reading.
    absent_ticks: u32,
    /// Ticks in a row that the drive was saturated.
    saturated_ticks: u32,
    model: RelaxationState<ORDER>,
}

/// Everything that decides, for an instrument of up to N elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller<const N: usize> {
    sample_period_s: Option<f32>,
    guard: GuardConfig,
    elements: [Option<Element>; N],
    states: [ElementState; N],
    state: RunState,
    tick: u32,
}

impl<const N: usize> Default for Controller<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Controller<N> {
    const FITS_THE_MASKS: () = assert!(N <= 16, "heaters and validity are masks of 16 bits");

    /// A controller in standby that knows no element yet.
    pub fn new() -> Self {
        let () = Self::FITS_THE_MASKS;
        Self {
            sample_period_s: None,
            guard: GuardConfig::default(),
            elements: [None; N],
            states: [ElementState::default(); N],
            state: RunState::Standby,
            tick: 0,
        }
    }

    /// What the instrument is doing.
    pub const fn state(&self) -> RunState {
        self.state
    }

    /// Number of the next tick.
    pub const fn ticks(&self) -> u32 {
        self.tick
    }

    /// Length of a tick in s, once it is set.
    pub const fn sample_period_s(&self) -> Option<f32> {
        self.sample_period_s
    }

    /// What an element's model says its temperature is, °C, if it has one.
    pub fn model_temperature_c(&self, element: usize) -> Option<f32> {
        let model = self.elements.get(element)?.as_ref()?.model.as_ref()?;
        Some(model.temperature_c(&self.states.get(element)?.model))
    }

    /// One tick.
    pub fn tick(&mut self, readings: &[Reading; N]) -> Tick<N> {
        let (valid, fault) = self.take_in(readings);
        let mut trip = fault.filter(|_| !matches!(self.state, RunState::Tripped(_)));
        if trip.is_none() && self.state == RunState::Running {
            trip = self.decide(valid);
        }
        if let Some(trip) = trip {
            self.state = RunState::Tripped(trip);
        }
        if self.state != RunState::Running {
            self.states.iter_mut().for_each(|state| state.level = Level::Low);
        }
        let power_w = self.heat();
        let output = Tick {
            tick: self.tick,
            heaters: Heaters(mask(&self.states, |state| state.level == Level::High)),
            valid,
            temperature_c: self.states.map(|state| state.temperature_c),
            power_w,
            state: self.state,
            trip,
        };
        self.tick = self.tick.wrapping_add(1);
        output
    }

    /// Judges the readings; gives the mask of good ones and the first fault.
    fn take_in(&mut self, readings: &[Reading; N]) -> (u16, Option<Trip>) {
        let (mut valid, mut fault) = (0, None);
        for (i, ((element, state), reading)) in self.elements.iter().zip(&mut self.states).zip(readings).enumerate() {
            let Some(element) = element else { continue };
            let cause = match guard::judge(&element.config.limits, &element.config.channel, *reading, state.level) {
                Judgement::Good { resistance_ohm, temperature_c } => {
                    state.absent_ticks = 0;
                    state.resistance_ohm = resistance_ohm;
                    state.temperature_c = temperature_c;
                    valid |= 1 << i;
                    continue;
                }
                Judgement::Absent(cause) => {
                    state.absent_ticks = state.absent_ticks.saturating_add(1);
                    if state.absent_ticks <= self.guard.missing_limit_ticks {
                        continue;
                    }
                    cause
                }
                Judgement::Bad(cause) => cause,
            };
            fault = fault.or(Some(Trip { cause, element: i as u8 }));
        }
        (valid, fault)
    }

    /// Lets every element with a good reading choose its level; the others go low.
    fn decide(&mut self, valid: u16) -> Option<Trip> {
        let mut trip = None;
        for (i, (element, state)) in self.elements.iter().zip(&mut self.states).enumerate() {
            let Some(element) = element else { continue };
            if valid >> i & 1 == 0 {
                state.level = Level::Low;
                continue;
            }
            let channel = &element.config.channel;
            let input = DriveInput {
                temperature_c: state.temperature_c,
                power_low_w: channel.power_w(state.resistance_ohm, Level::Low),
                power_high_w: channel.power_w(state.resistance_ohm, Level::High),
            };
            state.level = element.drive.step(&mut state.drive, &input);
            state.saturated_ticks = if state.drive.saturated { state.saturated_ticks.saturating_add(1) } else { 0 };
            if state.saturated_ticks > self.guard.unreachable_limit_ticks {
                trip = trip.or(Some(Trip { cause: Cause::Unreachable, element: i as u8 }));
            }
        }
        trip
    }

    /// Works out the power of every element and lets the models live through the tick.
    fn heat(&mut self) -> [f32; N] {
        let mut power_w = [0.0; N];
        for ((element, state), power) in self.elements.iter().zip(&mut self.states).zip(&mut power_w) {
            let Some(element) = element else { continue };
            *power = element.config.channel.power_w(state.resistance_ohm, state.level);
            if let Some(model) = &element.model {
                model.step(&mut state.model, *power);
            }
        }
        power_w
    }

    /// Carries out a command.
    ///
    /// # Errors
    /// Says why not, and changes nothing.
    pub fn handle(&mut self, command: Command) -> Result<Reply, Refusal> {
        match command {
            Command::Clear => {
                self.in_standby()?;
                *self = Self::new();
            }
            Command::SamplePeriod { sample_period_s } => {
                self.in_standby()?;
                let period = error::within(Parameter::SamplePeriodS, sample_period_s, 1e-4, 10.0);
                self.sample_period_s = Some(period.map_err(|error| Refusal::Invalid { element: None, error })?);
                // Their gains were for the old period.
                self.elements.iter_mut().flatten().for_each(|element| element.model = None);
            }
            Command::Guard(config) => {
                self.in_standby()?;
                self.guard = config;
            }
            Command::Element { element, config } => {
                self.in_standby()?;
                let slot = self.elements.get_mut(usize::from(element)).ok_or(Refusal::NoSuchElement { element })?;
                let invalid = |error| Refusal::Invalid { element: Some(element), error };
                let config = ElementConfig {
                    channel: config.channel.checked().map_err(invalid)?,
                    limits: config.limits.checked(config.channel.platinum()).map_err(invalid)?,
                };
                *slot = Some(Element { config, model: None, drive: Drive::Passive });
            }
            Command::Model { element, model } => {
                self.in_standby()?;
                let sample_period_s = self.sample_period_s.ok_or(Refusal::NoSamplePeriod)?;
                let model = SelfHeating::new(&model, sample_period_s);
                let model = model.map_err(|error| Refusal::Invalid { element: Some(element), error })?;
                self.element_mut(element)?.model = Some(model);
            }
            Command::Drive { element, drive } => self.set_drive(element, drive)?,
            Command::Start => return self.start(),
            Command::Stop => {
                if let RunState::Tripped(trip) = self.state {
                    return Err(Refusal::Tripped(trip));
                }
                self.state = RunState::Standby;
            }
            Command::Acknowledge => {
                if !matches!(self.state, RunState::Tripped(_)) {
                    return Err(Refusal::NotTripped);
                }
                self.state = RunState::Standby;
            }
        }
        Ok(Reply::Done)
    }

    fn in_standby(&self) -> Result<(), Refusal> {
        match self.state {
            RunState::Standby => Ok(()),
            RunState::Running => Err(Refusal::NotInStandby),
            RunState::Tripped(trip) => Err(Refusal::Tripped(trip)),
        }
    }

    fn element_mut(&mut self, element: u8) -> Result<&mut Element, Refusal> {
        let slot = self.elements.get_mut(usize::from(element)).ok_or(Refusal::NoSuchElement { element })?;
        slot.as_mut().ok_or(Refusal::NotConfigured { element })
    }

    fn set_drive(&mut self, element: u8, drive: Drive) -> Result<(), Refusal> {
        if let RunState::Tripped(trip) = self.state {
            return Err(Refusal::Tripped(trip));
        }
        let slot = self.element_mut(element)?;
        let invalid = |error| Refusal::Invalid { element: Some(element), error };
        let state = drive.start(slot.config.channel.platinum()).map_err(invalid)?;
        check_power(&drive, &slot.config).map_err(invalid)?;
        check_targets(element, &drive, slot)?;
        slot.drive = drive;
        if let Some(of) = self.states.get_mut(usize::from(element)) {
            of.drive = state;
            of.saturated_ticks = 0;
        }
        Ok(())
    }

    /// Everything starts afresh, so that two runs of the same experiment are the same run.
    fn start(&mut self) -> Result<Reply, Refusal> {
        self.in_standby()?;
        if self.sample_period_s.is_none() {
            return Err(Refusal::NoSamplePeriod);
        }
        let (mut judged, mut unjudged) = (0, 0);
        let mut states = self.states;
        for (i, (element, state)) in self.elements.iter().zip(&mut states).enumerate() {
            let Some(element) = element else { continue };
            let start = element.drive.start(element.config.channel.platinum());
            let drive = start.map_err(|error| Refusal::Invalid { element: Some(i as u8), error })?;
            if element.drive.target_range_c().is_some() {
                // The model may have been loaded after the drive.
                check_targets(i as u8, &element.drive, element)?;
                *(if element.model.is_some() { &mut judged } else { &mut unjudged }) += 1;
            }
            *state = ElementState {
                drive,
                temperature_c: state.temperature_c,
                resistance_ohm: state.resistance_ohm,
                ..ElementState::default()
            };
        }
        self.states = states;
        self.tick = 0;
        self.state = RunState::Running;
        Ok(Reply::Started { judged, unjudged })
    }

    /// Folds all that the controller knows after `tick` into a digest: temperatures, bits, powers and every state. Of the
    /// configuration it says nothing.
    pub fn fold(&self, tick: &Tick<N>, digest: &mut Digest) {
        digest.word(tick.tick);
        digest.word(u32::from(tick.heaters.0) | u32::from(tick.valid) << 16);
        digest.word(match tick.state {
            RunState::Standby => 0,
            RunState::Running => 1,
            RunState::Tripped(trip) => 2 | (trip.cause as u32) << 8 | u32::from(trip.element) << 16,
        });
        for (state, power_w) in self.states.iter().zip(tick.power_w) {
            digest.number(state.temperature_c);
            digest.number(state.resistance_ohm);
            digest.word(state.absent_ticks);
            digest.word(state.saturated_ticks);
            digest.word(state.drive.ticks_left);
            digest.word(state.drive.level as u32 | (state.drive.saturated as u32) << 1 | (state.level as u32) << 2);
            digest.number(power_w);
            digest.number(state.drive.modulator.accumulator);
            digest.number(state.drive.target_c);
            digest.word(state.drive.register.map_or(0, |register| register.register()));
            state.model.x.iter().chain(&state.model.excess).for_each(|&number| digest.number(number));
        }
    }
}

/// A mean power must lie where at least some plausible resistance could give it off.
fn check_power(drive: &Drive, config: &ElementConfig) -> Result<(), ConfigError> {
    if let Drive::Power { power_w } = *drive {
        let least = config.channel.power_w(config.limits.resistance_min_ohm, Level::Low);
        let most = config.channel.power_w(config.limits.resistance_max_ohm, Level::High);
        error::within(Parameter::PowerW, power_w, least, most)?;
    }
    Ok(())
}

/// Set-points must stay under the temperature limit and, where there is a model, within what it says can be held.
fn check_targets(index: u8, drive: &Drive, element: &Element) -> Result<(), Refusal> {
    let Some((low_c, high_c)) = drive.target_range_c() else { return Ok(()) };
    let (coldest_c, _) = element.config.channel.platinum().range_c();
    let parameter = if low_c < high_c { Parameter::HighC } else { Parameter::TargetC };
    error::within(parameter, high_c, coldest_c, element.config.limits.temperature_max_c)
        .map_err(|error| Refusal::Invalid { element: Some(index), error })?;
    let Some(model) = &element.model else { return Ok(()) };
    for target_c in [low_c, high_c] {
        let channel = &element.config.channel;
        let power_w = |level| channel.power_w(channel.platinum().resistance_ohm(target_c), level);
        let verdict = model.reachability(target_c, power_w(Level::Low), power_w(Level::High));
        if !matches!(verdict, Reachability::Reachable { .. }) {
            return Err(Refusal::Unreachable { element: index, target_c, verdict });
        }
    }
    Ok(())
}

fn mask<T>(items: &[T], is_set: impl Fn(&T) -> bool) -> u16 {
    items.iter().enumerate().fold(0, |mask, (i, item)| mask | u16::from(is_set(item)) << i)
}

#[cfg(test)]
mod tests;
