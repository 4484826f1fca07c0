//! The controller of N elements: one entry a tick, no clock, no pins.
//!
//! ```text
//! readings ─► guard ─► temperatures ─► drives ─► heater levels ─► powers ─► models or observers
//!               └── a bad reading trips all heaters to the low level in the same tick,
//!                   until acknowledged
//! ```
//!
//! At t_n it is given what the front end read at the end of [t_{n−1}, t_n), and decides the levels
//! that are held over [t_n, t_{n+1}). Power n is I²R of the level decided, at the resistance just
//! read.
//!
//! States: `Standby` → `Running` → `Standby`, `Standby` → `Testing` → `Standby`, and `Tripped` from
//! anywhere. Heaters are low in `Standby` and `Tripped`.

use super::drive::{Drive, DriveInput, DriveState};
use super::energy::EnergyBudget;
use super::fingerprint::{COEFFICIENT_PER_K, Fingerprint, HeadCheck};
use super::guard::{self, Cause, GuardConfig, ReadingJudgement, Trip};
use super::hardware_limits::HardwareLimits;
use super::lockout::Lockout;
use super::rise::{self, Rise};
use super::state::{BOARD_ELEMENTS, Heaters, MOST_ELEMENTS, Probe, RunState, Tick};
use super::targets::{self, Margins};
use super::transducer::{Transducer, judge_symbol};
use crate::checksum::Checksum;
use crate::command::HOST_TIMEOUT_S;
use crate::model::{ORDER, Observer, ObserverState, RelaxationState, SelfHeating};
use crate::sensor::{Channel, Level, Reading};

/// A configured element.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ControlledElement {
    transducer: Transducer,
    model: Option<SelfHeating>,
    /// Holds the states of the model on the measured temperature while the controller observes.
    observer: Option<Observer<ORDER>>,
    drive: Drive,
}

/// State of an element.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct ElementState {
    drive: DriveState,
    /// Temperature, °C, or voltage shift, V.
    measured: f32,
    /// Measured value: resistance, Ω, or offset of the capacitance, F.
    raw: f32,
    /// Ticks in a row without a fresh reading.
    absent_ticks: u32,
    /// Ticks in a row that the drive was saturated.
    saturated_ticks: u32,
    /// The last code, and ticks in a row that it has been the same.
    code: i32,
    same_ticks: u32,
    rise: Rise,
    model: RelaxationState<ORDER>,
    observer: ObserverState,
}

impl ElementState {
    /// Takes a judged reading: whether it was good, or why it trips.
    #[inline(always)] // into the tick, where time counts
    fn take(&mut self, judgement: ReadingJudgement, reading: Reading, missing_limit_ticks: u32) -> Result<bool, Cause> {
        match judgement {
            ReadingJudgement::Good { raw, value } => {
                self.absent_ticks = 0;
                self.track_code(reading);
                (self.raw, self.measured) = (raw, value);
                Ok(true)
            }
            ReadingJudgement::Absent(cause) => {
                self.absent_ticks = self.absent_ticks.saturating_add(1);
                if self.absent_ticks <= missing_limit_ticks { Ok(false) } else { Err(cause) }
            }
            ReadingJudgement::Bad(cause) => Err(cause),
        }
    }

    /// Counts the ticks in which the code has not changed.
    fn track_code(&mut self, reading: Reading) {
        let Reading::Code(code) = reading else { return };
        self.same_ticks = if code == self.code { self.same_ticks.saturating_add(1) } else { 0 };
        self.code = code;
    }
}

/// Everything that decides, for an instrument of up to N elements. They are configured from the
/// first on, without gaps; room for more costs a few words a tick that are cleared and passed on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller<const N: usize> {
    /// In flash, and no command changes them.
    hardware: &'static HardwareLimits,
    /// Outlives every command.
    energy: [EnergyBudget; N],
    sample_period_s: Option<f32>,
    guard: GuardConfig,
    observing: bool,
    /// Number of elements: the first entries of `elements` are filled.
    configured: usize,
    elements: [Option<ControlledElement>; N],
    states: [ElementState; N],
    /// The levels held since the last tick.
    levels: Heaters,
    state: RunState,
    tick: u32,
    /// Ticks for which commands that can heat are still accepted.
    armed_ticks: u32,
    /// Checksum of the settings that are verified in every tick.
    sealed_settings: Checksum,
    /// Checksum of the states that are verified in every tick.
    sealed_states: Checksum,
    /// Checksums of each element's drive, model and observer.
    sealed_elements: [Checksum; N],
    /// Number of checksums that have failed.
    bit_flips: u32,
    lockout: Lockout,
    /// Longest time without a frame of the host while heating, s; 0 for ever.
    host_timeout_s: f32,
    /// Ticks since the last frame of the host; none where there is no link.
    host_silence: Option<u32>,
    fingerprint_ohm: Fingerprint,
    head: HeadCheck,
}

impl<const N: usize> Controller<N> {
    const FITS_THE_MASKS: () = assert!(N <= MOST_ELEMENTS, "heaters and validity are masks");

    /// A controller in standby that knows no element yet, on a board with these limits.
    pub fn new(hardware: &'static HardwareLimits) -> Self {
        let () = Self::FITS_THE_MASKS;
        let mut new = Self {
            hardware,
            energy: [EnergyBudget::default(); N],
            sample_period_s: None,
            guard: hardware.guard(),
            observing: false,
            configured: 0,
            elements: [None; N],
            states: [ElementState::default(); N],
            levels: Heaters(0),
            state: RunState::Standby,
            tick: 0,
            armed_ticks: 0,
            sealed_settings: Checksum::default(),
            sealed_states: Checksum::default(),
            sealed_elements: [Checksum::default(); N],
            bit_flips: 0,
            lockout: Lockout::new(),
            host_timeout_s: HOST_TIMEOUT_S,
            host_silence: None,
            fingerprint_ohm: [0.0; BOARD_ELEMENTS],
            head: HeadCheck::default(),
        };
        new.update_checksums();
        new
    }

    /// Run state.
    pub const fn state(&self) -> RunState {
        self.state
    }

    /// Number of the next tick.
    pub const fn ticks(&self) -> u32 {
        self.tick
    }

    /// Tells whether commands that can heat are accepted now.
    pub const fn is_armed(&self) -> bool {
        self.armed_ticks > 0
    }

    /// Number of bit flips found in settings, states or models.
    pub const fn bit_flips(&self) -> u32 {
        self.bit_flips
    }

    /// Trips so far, and whether they can be acknowledged.
    pub const fn lockout(&self) -> &Lockout {
        &self.lockout
    }

    /// Number of configured elements.
    pub const fn elements(&self) -> usize {
        self.configured
    }

    /// Length of a tick in s, once it is set.
    pub const fn sample_period_s(&self) -> Option<f32> {
        self.sample_period_s
    }

    /// Wiring of an element.
    pub(crate) fn channel(&self, element: usize) -> Option<&Channel> {
        Some(&self.elements.get(element)?.as_ref()?.transducer.resistor()?.channel)
    }

    /// An element's model, if it has one.
    pub(crate) fn model(&self, element: usize) -> Option<&SelfHeating> {
        self.elements.get(element)?.as_ref()?.model.as_ref()
    }

    /// The guard's judgement of a reading; none if the element is not configured.
    #[inline(never)] // beside the one in the tick, which is where time counts
    pub(crate) fn judge(&self, element: usize, reading: Reading, level: Level) -> Option<ReadingJudgement> {
        let config = self.elements.get(element)?.as_ref()?.transducer.resistor()?;
        Some(guard::judge(&config.limits, &config.channel, reading, level))
    }

    /// Temperature of an element by its model, °C, if it has one. While observing, the model is
    /// held on the measured temperature.
    pub fn model_temperature_c(&self, element: usize) -> Option<f32> {
        let model = self.elements.get(element)?.as_ref()?.model.as_ref()?;
        Some(model.temperature_c(&self.states.get(element)?.model))
    }

    /// Power of an element at its low level and a temperature, W; nothing for one that is not
    /// configured.
    pub fn standing_power_w(&self, element: usize, temperature_c: f32) -> f32 {
        self.channel(element).map_or(0.0, |channel| channel.standing_power_w(temperature_c))
    }

    /// Distance of each configured element that holds a temperature from either level, by its
    /// model.
    pub fn margins(&self) -> impl Iterator<Item = Option<Margins>> {
        self.elements
            .iter()
            .map_while(Option::as_ref)
            .map(|element| targets::margins(&element.drive, &element.transducer, element.model.as_ref()?))
    }

    /// One tick. Readings of elements that are not configured are ignored.
    pub fn tick(&mut self, readings: &[Reading; N]) -> Tick<N> {
        self.tick_with(readings, Probe::None)
    }

    /// One tick with the request of a self-test.
    pub(crate) fn tick_with(&mut self, readings: &[Reading; N], probe: Probe) -> Tick<N> {
        let flipped = self.verify_integrity();
        let (valid, fault) = self.judge_readings(readings);
        let guarded = match self.state {
            RunState::Tripped(_) => false,
            RunState::Running => true,
            RunState::Standby | RunState::Testing => probe != Probe::Blind,
        };
        if probe == Probe::Blind && self.state != RunState::Running {
            // Readings skipped on purpose do not count as missing.
            self.states.iter_mut().for_each(|state| state.absent_ticks = 0);
        }
        let mut trip = flipped.or(fault.filter(|_| guarded)).or(self.compare_head(valid)).or(self.await_host());
        if trip.is_none() {
            match self.state {
                RunState::Running => trip = self.decide(valid),
                RunState::Testing => self.pulse(valid, probe),
                RunState::Standby | RunState::Tripped(_) => {}
            }
        }
        trip = trip.or_else(|| self.exceeded_energy());
        if let Some(trip) = trip {
            self.enter_tripped(trip);
        }
        if !matches!(self.state, RunState::Running | RunState::Testing) || self.head != HeadCheck::Same {
            self.levels = Heaters(0);
        }
        self.armed_ticks = self.armed_ticks.saturating_sub(1);
        if let Some(sample_period_s) = self.sample_period_s {
            self.lockout.tick(sample_period_s);
        }
        let (power_w, equivalent_power_w) = self.update_models(valid);
        let output = Tick {
            tick: self.tick,
            elements: self.configured as u8,
            heaters: self.levels,
            valid,
            temperature_c: self.states.map(|state| state.measured),
            power_w,
            equivalent_power_w: self.observing.then_some(equivalent_power_w),
            state: self.state,
            trip,
        };
        self.tick = self.tick.wrapping_add(1);
        self.update_state_checksum();
        output
    }

    /// Trips for a cause that the board reports, unless it is tripped already. The levels of the
    /// next tick are low; the board itself lowers those of this tick. A bit flip is counted.
    pub fn trip(&mut self, cause: Cause) {
        if !matches!(self.state, RunState::Tripped(_)) {
            self.bit_flips = self.bit_flips.saturating_add(u32::from(cause == Cause::BitFlip));
            self.enter_tripped(Trip::whole(cause));
            self.update_state_checksum();
        }
    }

    /// The board has lowered all heaters since the last tick, and begins the next one anew: its
    /// readings are those of the low level.
    pub(crate) fn lowered(&mut self) {
        self.levels = Heaters(0);
        self.update_state_checksum();
    }

    /// Ends a self-test.
    pub(crate) fn end_test(&mut self) {
        if self.state == RunState::Testing {
            (self.state, self.armed_ticks) = (RunState::Standby, 0);
            self.update_state_checksum();
        }
    }

    /// Compares the head on the plug with the fingerprint until it fits; trips before another one
    /// is heated.
    fn compare_head(&mut self, valid: usize) -> Option<Trip> {
        if self.head == HeadCheck::Same {
            return None;
        }
        let heats = matches!(self.state, RunState::Running | RunState::Testing);
        let all = self.elements.iter().zip(&self.states).zip(&self.fingerprint_ohm).zip(0..);
        let compared = HeadCheck::of(all.filter_map(|(((element, state), &taken_ohm), i)| {
            // In standby more elements may be configured yet.
            let is_compared = taken_ohm > 0.0 && (element.is_some() || !heats);
            let change_k = element
                .as_ref()
                .filter(|_| valid >> i & 1 == 1)
                .map(|_| (state.raw / taken_ohm - 1.0) / COEFFICIENT_PER_K);
            is_compared.then_some((i, change_k))
        }));
        self.head = compared.unwrap_or(self.head);
        let HeadCheck::Other(element) = self.head else { return None };
        heats.then_some(Trip::of(element.into(), Cause::OtherHead))
    }

    /// There is a link, and a host that is to be heard while the instrument heats.
    pub(crate) fn expect_host(&mut self) {
        self.host_silence = Some(0);
        self.update_checksums();
    }

    /// The host has sent a frame.
    pub(crate) fn host_heard(&mut self) {
        self.host_silence = self.host_silence.map(|_| 0);
    }

    /// Counts a tick without a frame of the host, and trips after too many.
    fn await_host(&mut self) -> Option<Trip> {
        let heats = matches!(self.state, RunState::Running | RunState::Testing);
        let ticks = self.host_silence.as_mut().filter(|_| heats)?;
        *ticks = ticks.saturating_add(1);
        let silence_s = *ticks as f32 * self.sample_period_s?;
        (self.host_timeout_s > 0.0 && silence_s > self.host_timeout_s).then_some(Trip::whole(Cause::HostTimeout))
    }

    /// Goes on with the trips of before a reset.
    pub(crate) fn restore_lockout(&mut self, lockout: Lockout) {
        self.lockout = lockout;
    }

    /// Trips for the first element whose energy budget is exceeded while it could be heated.
    fn exceeded_energy(&self) -> Option<Trip> {
        let heats = matches!(self.state, RunState::Running | RunState::Testing);
        let mut all = self.elements.iter().map_while(Option::as_ref).zip(&self.energy).filter(|_| heats);
        let exceeded = all.position(|(element, energy)| match &element.transducer {
            Transducer::Resistor(config) => energy.is_exceeded(&config.bears(self.hardware)),
            Transducer::Capacitor(_) | Transducer::Bias => false,
        });
        exceeded.map(|i| Trip::of(i, Cause::Energy))
    }

    /// Enters `Tripped` from any state, and counts the trip.
    fn enter_tripped(&mut self, trip: Trip) {
        self.lockout.count(self.state, trip);
        self.head = self.head.after(trip);
        self.state = RunState::Tripped(trip);
        self.armed_ticks = 0;
    }

    /// Judges the readings; returns the mask of good ones and the first fault.
    fn judge_readings(&mut self, readings: &[Reading; N]) -> (usize, Option<Trip>) {
        let (mut valid, mut fault, mut others) = (0, None, false);
        for (i, ((element, state), reading)) in self.elements.iter().zip(&mut self.states).zip(readings).enumerate() {
            let Some(element) = element else { break };
            let Transducer::Resistor(config) = &element.transducer else {
                others = true;
                continue;
            };
            let judgement = guard::judge(&config.limits, &config.channel, *reading, self.levels.level(i));
            match state.take(judgement, *reading, self.guard.missing_limit_ticks) {
                Ok(is_good) => valid |= usize::from(is_good) << i,
                Err(cause) => fault = fault.or(Some(Trip::of(i, cause))),
            }
        }
        if others {
            self.judge_symbols(readings, &mut valid, &mut fault);
        }
        (valid, fault)
    }

    /// The same for capacitors and their biases.
    #[inline(never)] // resistors must not wait for what they are not
    fn judge_symbols(&mut self, readings: &[Reading; N], valid: &mut usize, fault: &mut Option<Trip>) {
        let mut offset_f = 0.0;
        for (i, (element, state)) in self.elements.iter().map_while(Option::as_ref).zip(&mut self.states).enumerate() {
            match &element.transducer {
                Transducer::Resistor(_) => {}
                // Without a bias the readings are of no symbol.
                Transducer::Capacitor(config) if self.levels.is_high(i + 1) => {
                    let both = [readings.get(i), readings.get(i + 1)].map(|of| *of.unwrap_or(&Reading::Missing));
                    let judgement = judge_symbol(config, both, self.levels.level(i));
                    match state.take(judgement, both[0], self.guard.missing_limit_ticks) {
                        Ok(is_good) => *valid |= usize::from(is_good) << i,
                        Err(cause) => *fault = fault.or(Some(Trip::of(i, cause))),
                    }
                    offset_f = state.raw;
                }
                Transducer::Capacitor(_) => {}
                Transducer::Bias => {
                    // It shows what else the readings of its capacitor amount to.
                    state.measured = offset_f;
                    *valid |= (*valid << 1) & (1 << i);
                }
            }
        }
    }

    /// Steps the drive of every element with a good reading; the levels of the others go low.
    fn decide(&mut self, valid: usize) -> Option<Trip> {
        let (mut trip, mut high, mut others) = (None, 0, false);
        let no_rise_ticks = self.sample_period_s.map_or(0, |period_s| (self.hardware.no_rise_s / period_s) as u32);
        let no_rise_full = rise::full(no_rise_ticks);
        for (i, (element, state)) in self.elements.iter().zip(&mut self.states).enumerate() {
            let Some(element) = element else { break };
            let Transducer::Resistor(config) = &element.transducer else {
                others = true;
                continue;
            };
            if valid >> i & 1 == 0 {
                continue;
            }
            let input = DriveInput {
                measured: state.measured,
                low: config.channel.power_w(state.raw, Level::Low),
                high: config.channel.power_w(state.raw, Level::High),
            };
            high |= usize::from(element.drive.step(&mut state.drive, &input) == Level::High) << i;
            state.saturated_ticks = if state.drive.saturated { state.saturated_ticks.saturating_add(1) } else { 0 };
            let regulates = element.drive.target_range_c().is_some();
            let no_rise = state.rise.is_missing(self.levels.level(i), state.measured, regulates, no_rise_full);
            // One that is warm enough without its heater, as a core that loses its fight with a
            // warm support, is in no danger, and ends no run.
            let is_too_warm = regulates && high >> i & 1 == 0;
            if (state.saturated_ticks > self.guard.unreachable_limit_ticks && !is_too_warm) || no_rise {
                trip = trip.or(Some(Trip::of(i, Cause::Unreachable)));
            }
            let may_stick = self.guard.stuck_limit_ticks == 0 || !element.drive.can_heat();
            if !may_stick && state.same_ticks > self.guard.stuck_limit_ticks {
                trip = trip.or(Some(Trip::of(i, Cause::Stuck)));
            }
        }
        if others {
            trip = trip.or(self.decide_symbols(valid, &mut high));
        }
        self.levels = Heaters(high);
        trip
    }

    /// Steps the drive of every capacitor, and raises the bias of those that have one; a symbol
    /// without a good reading is repeated.
    #[inline(never)] // resistors must not wait for what they are not
    fn decide_symbols(&mut self, valid: usize, high: &mut usize) -> Option<Trip> {
        let mut trip = None;
        for (i, (element, state)) in self.elements.iter().map_while(Option::as_ref).zip(&mut self.states).enumerate() {
            let is_driven = matches!(element.transducer, Transducer::Capacitor(_)) && element.drive != Drive::Passive;
            if !is_driven {
                continue;
            }
            *high |= 2 << i;
            if self.levels.is_high(i + 1) && valid >> i & 1 == 0 {
                *high |= self.levels.0 & (1 << i);
                continue;
            }
            let input = DriveInput { measured: state.measured, low: -1.0, high: 1.0 };
            *high |= usize::from(element.drive.step(&mut state.drive, &input) == Level::High) << i;
            state.saturated_ticks = if state.drive.saturated { state.saturated_ticks.saturating_add(1) } else { 0 };
            if state.saturated_ticks > self.guard.unreachable_limit_ticks {
                trip = trip.or(Some(Trip::of(i, Cause::Unreachable)));
            }
        }
        trip
    }

    /// Sets the element under test to the high level if its reading is good; ends a test that has
    /// exceeded its time.
    fn pulse(&mut self, valid: usize, probe: Probe) {
        if !self.is_armed() {
            self.state = RunState::Standby;
            return;
        }
        self.levels = Heaters(match probe {
            Probe::Pulse(element) => valid & 1_usize.checked_shl(u32::from(element)).unwrap_or(0),
            Probe::None | Probe::Blind => 0,
        });
    }

    /// Computes the power of every element and steps its model; returns powers and equivalent
    /// controls.
    fn update_models(&mut self, valid: usize) -> ([f32; N], [f32; N]) {
        let (mut powers_w, mut equivalents_w) = ([0.0; N], [0.0; N]);
        let sample_period_s = self.sample_period_s.unwrap_or(0.0);
        let states = self.states.iter_mut().zip(&mut self.energy).zip(&mut powers_w).zip(&mut equivalents_w);
        for (i, (element, (((state, energy), power_w), equivalent_w))) in self.elements.iter().zip(states).enumerate() {
            let Some(element) = element else { break };
            let level = self.levels.level(i);
            match &element.transducer {
                Transducer::Resistor(config) => {
                    *power_w = config.channel.power_w(state.raw, level);
                    energy.spend(*power_w, sample_period_s, &config.bears(self.hardware));
                }
                Transducer::Capacitor(_) if self.levels.is_high(i + 1) => {
                    *power_w = if level == Level::High { 1.0 } else { -1.0 };
                }
                Transducer::Capacitor(_) | Transducer::Bias => {}
            }
            let Some(model) = &element.model else { continue };
            let mut input_w = *power_w;
            if let Some(observer) = &element.observer {
                let measured_c = (valid >> i & 1 == 1).then_some(state.measured);
                if let (0, Some(first_c)) = (self.tick, measured_c) {
                    // Before a run elements only sense, mostly for long: steady state is the best
                    // initial state.
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

#[cfg(any(test, feature = "bit-flips"))]
pub mod bit_flips;
mod digest;
mod handle;
mod integrity;
#[cfg(test)]
mod tests;
