//! The controller of N elements: one entry a tick, no clock, no pins.
//!
//! ```text
//! readings ──► guard ──► temperatures ──► drives ──► heater levels ──► powers ──► models, or their observers
//!                └── a bad reading trips all heaters to the low level in the same tick, until acknowledged
//! ```
//!
//! At t_n it is given what the front end read at the end of [t_{n−1}, t_n), and decides the levels that are held over
//! [t_n, t_{n+1}). Power n is I²R of the level decided, at the resistance just read.
//!
//! States: `Standby` → `Running` → `Standby`, likewise `Testing`, and `Tripped` from anywhere. Heaters are low in `Standby` and `Tripped`.

use super::drive::{Drive, DriveInput, DriveState};
use super::guard::{self, Cause, GuardConfig, Judgement, Limits, Trip};
use super::targets::{self, Margins};
use crate::model::{ORDER, Observer, ObserverState, RelaxationState, SelfHeating};
use crate::sensor::{Channel, Level, Reading};
use seals::Seals;

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
    /// In a self-test that heats, for so long as it was planned for.
    Testing,
}

impl RunState {
    /// All of it in one word.
    pub(crate) fn word(self) -> u32 {
        match self {
            Self::Standby => 0,
            Self::Running => 1,
            Self::Tripped(Trip { cause, element }) => {
                2 | (cause as u32) << 8 | u32::from(element.unwrap_or(0xff)) << 16
            }
            Self::Testing => 3,
        }
    }
}

/// What a self-test wishes of a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Probe {
    /// Nothing beside the usual.
    None,
    /// What is read may be of something else, or be missing: no reason to trip. Not granted while running.
    Blind,
    /// This element at the high level. Granted while testing, if its reading is valid.
    Pulse(u8),
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

/// What one tick brought. Of the lists only the entries of configured elements mean anything: the first `elements`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick<const N: usize> {
    /// Number of the tick since the start of the run.
    pub tick: u32,
    /// How many elements are configured.
    pub elements: u8,
    /// Levels held until the next tick.
    pub heaters: Heaters,
    /// Bit i is set if element i had a good reading in this tick.
    pub valid: u16,
    /// Temperatures at this tick, °C; the last good one where the reading was not.
    pub temperature_c: [f32; N],
    /// Heating power held until the next tick, W.
    pub power_w: [f32; N],
    /// What the elements' structures take at this tick by their observers, W; 0 for elements without a model. Only while observing.
    pub equivalent_power_w: Option<[f32; N]>,
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
    /// Holds the model's states on the measured temperature; in use while the controller observes.
    observer: Option<Observer<ORDER>>,
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
    /// The last code, and ticks in a row that it has been the same.
    code: i32,
    same_ticks: u32,
    model: RelaxationState<ORDER>,
    observer: ObserverState,
}

impl ElementState {
    /// Remembers a code, and how often it has come.
    fn see(&mut self, reading: Reading) {
        let Reading::Code(code) = reading else { return };
        self.same_ticks = if code == self.code { self.same_ticks.saturating_add(1) } else { 0 };
        self.code = code;
    }
}

/// Everything that decides, for an instrument of up to N elements. They are configured from the first on, without gaps; room
/// for more costs a few words a tick that are cleared and passed on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller<const N: usize> {
    sample_period_s: Option<f32>,
    guard: GuardConfig,
    observing: bool,
    /// How many elements there are: so many entries of `elements` are filled, from the first on.
    configured: usize,
    elements: [Option<Element>; N],
    states: [ElementState; N],
    state: RunState,
    tick: u32,
    /// Ticks for which what can heat may still be asked for.
    armed_ticks: u32,
    seals: Seals<N>,
    /// Times that a seal was broken.
    upsets: u32,
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
        let mut new = Self {
            sample_period_s: None,
            guard: GuardConfig::default(),
            observing: false,
            configured: 0,
            elements: [None; N],
            states: [ElementState::default(); N],
            state: RunState::Standby,
            tick: 0,
            armed_ticks: 0,
            seals: Seals::default(),
            upsets: 0,
        };
        new.seal_all();
        new
    }

    /// What the instrument is doing.
    pub const fn state(&self) -> RunState {
        self.state
    }

    /// Number of the next tick.
    pub const fn ticks(&self) -> u32 {
        self.tick
    }

    /// Whether what can heat may be asked for now.
    pub const fn is_armed(&self) -> bool {
        self.armed_ticks > 0
    }

    /// Times that what it knows was found to be something else than what it had been told.
    pub const fn upsets(&self) -> u32 {
        self.upsets
    }

    /// How many elements are configured.
    pub const fn elements(&self) -> usize {
        self.configured
    }

    /// Length of a tick in s, once it is set.
    pub const fn sample_period_s(&self) -> Option<f32> {
        self.sample_period_s
    }

    /// What is known of an element's wiring.
    pub(super) fn channel(&self, element: usize) -> Option<&Channel> {
        Some(&self.elements.get(element)?.as_ref()?.config.channel)
    }

    /// An element's model, if it has one.
    pub(super) fn model(&self, element: usize) -> Option<&SelfHeating> {
        self.elements.get(element)?.as_ref()?.model.as_ref()
    }

    /// What the guard makes of a reading of an element; none if it is not configured.
    #[inline(never)] // beside the one in the tick, which is where time counts
    pub(super) fn judge(&self, element: usize, reading: Reading, level: Level) -> Option<Judgement> {
        let config = &self.elements.get(element)?.as_ref()?.config;
        Some(guard::judge(&config.limits, &config.channel, reading, level))
    }

    /// What an element's model says its temperature is, °C, if it has one. While observing it is held on the measured one.
    pub fn model_temperature_c(&self, element: usize) -> Option<f32> {
        let model = self.elements.get(element)?.as_ref()?.model.as_ref()?;
        Some(model.temperature_c(&self.states.get(element)?.model))
    }

    /// Power of an element at its low level and a temperature, W; nothing for one that is not configured.
    pub fn standing_power_w(&self, element: usize, temperature_c: f32) -> f32 {
        let Some(Some(element)) = self.elements.get(element) else { return 0.0 };
        element.config.channel.standing_power_w(temperature_c)
    }

    /// How far each configured element that holds a temperature stays from either level, by its model.
    pub fn margins(&self) -> impl Iterator<Item = Option<Margins>> {
        self.elements
            .iter()
            .map_while(Option::as_ref)
            .map(|element| targets::margins(&element.drive, &element.config, element.model.as_ref()?))
    }

    /// One tick. Readings of elements that are not configured are not looked at.
    pub fn tick(&mut self, readings: &[Reading; N]) -> Tick<N> {
        self.tick_with(readings, Probe::None)
    }

    /// One tick with what a self-test wishes.
    pub(super) fn tick_with(&mut self, readings: &[Reading; N], probe: Probe) -> Tick<N> {
        let upset = self.look_for_upsets();
        let (valid, fault) = self.take_in(readings);
        let guarded = match self.state {
            RunState::Tripped(_) => false,
            RunState::Running => true,
            RunState::Standby | RunState::Testing => probe != Probe::Blind,
        };
        if probe == Probe::Blind && self.state != RunState::Running {
            // What was not read for a reason is not missing afterwards.
            self.states.iter_mut().for_each(|state| state.absent_ticks = 0);
        }
        let mut trip = upset.or(fault.filter(|_| guarded));
        if trip.is_none() {
            match self.state {
                RunState::Running => trip = self.decide(valid),
                RunState::Testing => self.pulse(valid, probe),
                RunState::Standby | RunState::Tripped(_) => {}
            }
        }
        if let Some(trip) = trip {
            self.fall(trip);
        }
        if !matches!(self.state, RunState::Running | RunState::Testing) {
            self.states.iter_mut().for_each(|state| state.level = Level::Low);
        }
        self.armed_ticks = self.armed_ticks.saturating_sub(1);
        let (power_w, equivalent_power_w) = self.heat(valid);
        let output = Tick {
            tick: self.tick,
            elements: self.configured as u8,
            heaters: Heaters(mask(&self.states, |state| state.level == Level::High)),
            valid,
            temperature_c: self.states.map(|state| state.temperature_c),
            power_w,
            equivalent_power_w: self.observing.then_some(equivalent_power_w),
            state: self.state,
            trip,
        };
        self.tick = self.tick.wrapping_add(1);
        self.seal_states();
        output
    }

    /// Trips for a cause that the controller cannot see by itself, unless it is tripped already. The levels of the next tick are low; those
    /// of this one are the board's to lower.
    pub fn trip(&mut self, cause: Cause) {
        if !matches!(self.state, RunState::Tripped(_)) {
            self.fall(Trip::whole(cause));
            self.seal_states();
        }
    }

    /// Trips for an upset of what it does not hold itself, and counts it.
    pub(super) fn trip_for_upset(&mut self) -> Trip {
        let trip = Trip::whole(Cause::Upset);
        self.upsets = self.upsets.saturating_add(1);
        self.fall(trip);
        self.seal_states();
        trip
    }

    /// A self-test is through.
    pub(super) fn end_test(&mut self) {
        if self.state == RunState::Testing {
            (self.state, self.armed_ticks) = (RunState::Standby, 0);
            self.seal_states();
        }
    }

    /// From whatever it did to tripped.
    const fn fall(&mut self, trip: Trip) {
        self.state = RunState::Tripped(trip);
        self.armed_ticks = 0;
    }

    /// Judges the readings; gives the mask of good ones and the first fault.
    fn take_in(&mut self, readings: &[Reading; N]) -> (u16, Option<Trip>) {
        let (mut valid, mut fault) = (0, None);
        for (i, ((element, state), reading)) in self.elements.iter().zip(&mut self.states).zip(readings).enumerate() {
            let Some(element) = element else { break };
            let cause = match guard::judge(&element.config.limits, &element.config.channel, *reading, state.level) {
                Judgement::Good { resistance_ohm, temperature_c } => {
                    state.absent_ticks = 0;
                    state.see(*reading);
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
            fault = fault.or(Some(Trip::of(i, cause)));
        }
        (valid, fault)
    }

    /// Lets every element with a good reading choose its level; the others go low.
    fn decide(&mut self, valid: u16) -> Option<Trip> {
        let mut trip = None;
        for (i, (element, state)) in self.elements.iter().zip(&mut self.states).enumerate() {
            let Some(element) = element else { break };
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
                trip = trip.or(Some(Trip::of(i, Cause::Unreachable)));
            }
            let may_stick = self.guard.stuck_limit_ticks == 0 || !element.drive.can_heat();
            if !may_stick && state.same_ticks > self.guard.stuck_limit_ticks {
                trip = trip.or(Some(Trip::of(i, Cause::Stuck)));
            }
        }
        trip
    }

    /// Lets the one element that a self-test asks for have the high level, if it has a good reading; ends a test that is beyond its time.
    fn pulse(&mut self, valid: u16, probe: Probe) {
        if !self.is_armed() {
            self.state = RunState::Standby;
            return;
        }
        for (i, state) in self.states.iter_mut().enumerate().take(self.configured) {
            let is_high = probe == Probe::Pulse(i as u8) && valid >> i & 1 == 1;
            state.level = if is_high { Level::High } else { Level::Low };
        }
    }

    /// Works out the power of every element and lets the models live through the tick; beside it what the observers see.
    fn heat(&mut self, valid: u16) -> ([f32; N], [f32; N]) {
        let (mut powers_w, mut equivalents_w) = ([0.0; N], [0.0; N]);
        let states = self.states.iter_mut().zip(&mut powers_w).zip(&mut equivalents_w);
        for (i, (element, ((state, power_w), equivalent_w))) in self.elements.iter().zip(states).enumerate() {
            let Some(element) = element else { break };
            *power_w = element.config.channel.power_w(state.resistance_ohm, state.level);
            let Some(model) = &element.model else { continue };
            let mut input_w = *power_w;
            if let Some(observer) = &element.observer {
                let measured_c = (valid >> i & 1 == 1).then_some(state.temperature_c);
                if let (0, Some(first_c)) = (self.tick, measured_c) {
                    // Before a run elements only sense, mostly for long: a better guess than no heat at all.
                    state.model = model.in_balance(first_c);
                }
                let seen = model.observe(observer, &mut state.observer, &state.model, measured_c);
                *equivalent_w = seen.equivalent_power_w;
                input_w += seen.correction_w;
            }
            model.step(&mut state.model, input_w);
        }
        (powers_w, equivalents_w)
    }
}

fn mask<T>(items: &[T], is_set: impl Fn(&T) -> bool) -> u16 {
    items.iter().enumerate().fold(0, |mask, (i, item)| mask | u16::from(is_set(item)) << i)
}

mod fold;
mod handle;
mod seals;
#[cfg(test)]
mod tests;
#[cfg(any(test, feature = "upset"))]
pub mod upset;
