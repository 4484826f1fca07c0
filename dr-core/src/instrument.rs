//! An instrument of N elements: a controller, which decides, with an anemometer, which estimates
//! the wind.

use crate::command::{Command, Reply};
use crate::control::controller::Controller;
use crate::control::guard::{Cause, Trip};
use crate::control::hardware_limits::HardwareLimits;
use crate::control::lockout::Lockout;
use crate::control::refusal::Refusal;
use crate::control::self_test::SelfTest;
use crate::control::state::{Probe, RunState, Tick};
use crate::digest::Digest;
use crate::sensor::{FrontEndInput, Reading};
use crate::wind::anemometer::command::WindCommand;
use crate::wind::anemometer::{Anemometer, WindTick};

/// A controller and an anemometer that share commands and ticks.
///
/// A tick has two halves, so that the heaters are set before the wind is computed:
/// [`tick`](Self::tick) decides the levels, [`sense`](Self::sense) estimates the wind.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument<const N: usize> {
    controller: Controller<N>,
    anemometer: Anemometer<N>,
    /// The self-test in progress, or the last one.
    self_test: SelfTest<N>,
    /// Its findings have not been taken yet.
    is_news: bool,
    /// The input that the front end is to read.
    input: FrontEndInput,
}

impl<const N: usize> Instrument<N> {
    /// An instrument in standby, without settings, on a board with these limits.
    pub fn new(hardware: &'static HardwareLimits) -> Self {
        Self {
            controller: Controller::new(hardware),
            anemometer: Anemometer::default(),
            self_test: SelfTest::default(),
            is_news: false,
            input: FrontEndInput::default(),
        }
    }

    /// The controller, read only.
    pub const fn controller(&self) -> &Controller<N> {
        &self.controller
    }

    /// Carries out a command.
    ///
    /// # Errors
    /// Returns the reason, and changes nothing.
    pub fn handle(&mut self, command: Command) -> Result<Reply, Refusal> {
        if let Command::Wind(wind) = &command {
            return self.handle_wind(wind);
        }
        let had_bit_flip = matches!(self.controller.state(), RunState::Tripped(Trip { cause: Cause::BitFlip, .. }));
        let reply = self.controller.handle(command)?;
        match command {
            // A flipped bit cannot be located: all settings are void.
            Command::Acknowledge if had_bit_flip => self.anemometer = Anemometer::default(),
            // Its gains were for the old period, or for another head.
            Command::Clear | Command::SamplePeriod { .. } => self.anemometer = Anemometer::default(),
            Command::Start => self.anemometer.restart(),
            _ => {}
        }
        match command {
            Command::SelfTest(plan) => {
                let pulse_ticks = self.controller.pulse_ticks(&plan)?;
                self.self_test.begin(plan, pulse_ticks, self.controller.elements());
                self.is_news = false;
            }
            Command::Arm { .. } | Command::Disarm | Command::Acknowledge => {}
            _ => {
                self.self_test.leave();
                self.is_news = false;
            }
        }
        Ok(reply)
    }

    fn handle_wind(&mut self, command: &WindCommand) -> Result<Reply, Refusal> {
        match (command, self.controller.state()) {
            (WindCommand::Gas { .. }, _) | (_, RunState::Standby) => {}
            (_, RunState::Running | RunState::Testing) => return Err(Refusal::NotInStandby),
            (_, RunState::Tripped(trip)) => return Err(Refusal::Tripped(trip)),
        }
        let sample_period_s = self.controller.sample_period_s().ok_or(Refusal::NoSamplePeriod)?;
        if !matches!(command, WindCommand::Gas { .. }) && !self.anemometer.is_whole() {
            // An update of the checksums would hide the flipped bit.
            return Err(Refusal::Tripped(self.controller.trip_for_bit_flip()));
        }
        let element = match command {
            WindCommand::SelfHeating { element, .. } => Some(*element),
            WindCommand::FasterGains(faster) => Some(faster.element),
            WindCommand::CrossHeating(cross) => Some(cross.to),
            WindCommand::Surface { config, .. } => Some(config.element),
            _ => None,
        };
        let invalid = |error| Refusal::Invalid { element, error };
        self.anemometer.handle(command, sample_period_s).map_err(invalid)?;
        Ok(Reply::Done)
    }

    /// There is a link to a host, which has to send something while the instrument heats
    /// (`Command::HostTimeout`).
    pub fn expect_host(&mut self) {
        self.controller.expect_host();
    }

    /// The host has sent a frame.
    pub fn host_heard(&mut self) {
        self.controller.host_heard();
    }

    /// Goes on with the trips of before a reset.
    pub fn restore_lockout(&mut self, lockout: Lockout) {
        self.controller.restore_lockout(lockout);
    }

    /// Trips for a cause that the board reports, unless the instrument is tripped already.
    pub fn trip(&mut self, cause: Cause) {
        self.controller.trip(cause);
    }

    /// The board has lowered all heaters since the last tick, and begins the next one anew. To be
    /// called after [`handle`](Self::handle), which has found no bit flip.
    pub fn lowered(&mut self) {
        self.controller.lowered();
    }

    /// Flips a bit of the controller, for fault injection: [`Controller::flip_bit`].
    #[cfg(feature = "bit-flips")]
    pub fn flip_bit(&mut self, which: usize, element: usize, bit: u32) -> Option<&'static str> {
        self.controller.flip_bit(which, element, bit)
    }

    /// The input that the front end is to read next; valid after each tick.
    pub const fn input(&self) -> FrontEndInput {
        self.input
    }

    /// The finished self-test; returned once.
    pub fn take_self_test(&mut self) -> Option<&SelfTest<N>> {
        core::mem::take(&mut self.is_news).then_some(&self.self_test)
    }

    /// The first half of a tick: readings in, levels out.
    pub fn tick(&mut self, readings: &[Reading; N]) -> Tick<N> {
        // Readings of other inputs are not passed to the controller.
        let nothing = [Reading::Missing; N];
        let (of_elements, probe) = match self.input {
            FrontEndInput::Element => (readings, self.self_test.probe()),
            FrontEndInput::Shorted | FrontEndInput::Reference => (&nothing, Probe::Blind),
        };
        let mut tick = self.controller.tick_with(of_elements, probe);
        if !self.self_test.is_over() || !matches!(self.input, FrontEndInput::Element) {
            self.step_test(readings, &mut tick);
        }
        tick
    }

    /// Advances the self-test by a tick, and reconnects the elements after one that was ended
    /// early.
    #[inline(never)]
    fn step_test(&mut self, readings: &[Reading; N], tick: &mut Tick<N>) {
        self.input = FrontEndInput::Element;
        if self.self_test.is_over() {
            return;
        }
        self.self_test.step(readings, tick, &self.controller);
        self.input = self.self_test.input();
        self.is_news = self.self_test.is_over();
        if self.is_news {
            self.controller.end_test();
            tick.state = self.controller.state();
        }
    }

    /// The second half: the wind estimate, at the end of an output interval.
    pub fn sense(&mut self, tick: &Tick<N>) -> Option<WindTick> {
        if !matches!(tick.state, RunState::Tripped(_)) && !self.anemometer.is_intact_at(tick.tick) {
            self.controller.trip_for_bit_flip();
        }
        self.anemometer.step(tick, |element, temperature_c| self.controller.standing_power_w(element, temperature_c))
    }

    /// Adds the state after both halves to a digest.
    pub fn digest(&self, tick: &Tick<N>, report: Option<&WindTick>, digest: &mut Digest) {
        self.controller.digest(tick, digest);
        self.anemometer.digest(tick.elements, report, digest);
    }
}

#[cfg(test)]
mod tests;
