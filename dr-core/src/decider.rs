//! The half of an instrument that decides: the controller with its self-test.

use crate::command::{Command, Reply};
use crate::control::controller::Controller;
use crate::control::guard::{Cause, Trip};
use crate::control::hardware_limits::HardwareLimits;
use crate::control::lockout::Lockout;
use crate::control::refusal::Refusal;
use crate::control::self_test::SelfTest;
use crate::control::state::{Probe, RunState, Tick};
use crate::estimator::Handover;
use crate::sensor::{FrontEndInput, Reading};
use crate::wind::anemometer::command::WindCommand;

/// A controller that tests itself, and hands over to an estimator what that needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Decider<const N: usize> {
    controller: Controller<N>,
    /// The self-test in progress, or the last one.
    self_test: SelfTest<N>,
    /// Its findings have not been taken yet.
    is_news: bool,
    /// The input that the front end is to read.
    input: FrontEndInput,
}

impl<const N: usize> Decider<N> {
    /// A decider in standby, without settings, on a board with these limits.
    pub fn new(hardware: &'static HardwareLimits) -> Self {
        Self {
            controller: Controller::new(hardware),
            self_test: SelfTest::default(),
            is_news: false,
            input: FrontEndInput::default(),
        }
    }

    /// The controller, read only.
    pub const fn controller(&self) -> &Controller<N> {
        &self.controller
    }

    /// Carries out a command, and hands over at most once what it means for the estimator. Returns
    /// no reply where the estimator is to reply.
    ///
    /// # Errors
    /// Returns the reason, and changes nothing.
    pub fn handle(&mut self, command: Command, hand_over: impl FnOnce(Handover<N>)) -> Result<Option<Reply>, Refusal> {
        if let Command::Wind(command) = command {
            let sample_period_s = self.check_wind(&command)?;
            hand_over(Handover::Command { command, sample_period_s });
            return Ok(None);
        }
        let had_bit_flip = matches!(self.controller.state(), RunState::Tripped(Trip { cause: Cause::BitFlip, .. }));
        let reply = self.controller.handle(command)?;
        match command {
            // A flipped bit cannot be located: all settings are void.
            Command::Acknowledge if had_bit_flip => hand_over(Handover::Clear),
            // Its gains were for the old period, or for another head.
            Command::Clear | Command::SamplePeriod { .. } => hand_over(Handover::Clear),
            Command::Start => hand_over(Handover::Start),
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
        Ok(Some(reply))
    }

    /// Checks that the anemometer may be told something now; returns the sample period.
    fn check_wind(&self, command: &WindCommand) -> Result<f32, Refusal> {
        match (command, self.controller.state()) {
            (WindCommand::Gas { .. }, _) | (_, RunState::Standby) => {}
            (_, RunState::Running | RunState::Testing) => return Err(Refusal::NotInStandby),
            (_, RunState::Tripped(trip)) => return Err(Refusal::Tripped(trip)),
        }
        self.controller.sample_period_s().ok_or(Refusal::NoSamplePeriod)
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

    /// Trips for a cause that the board or the estimator reports, unless it is tripped already.
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

    /// A tick: readings in, levels out.
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

    /// A tick with what an estimate of its wind needs.
    pub fn handover(&self, tick: &Tick<N>, follows_gap: bool) -> Handover<N> {
        let mut standing_w = [0.0; N];
        for (i, (standing_w, &temperature_c)) in standing_w.iter_mut().zip(&tick.temperature_c).enumerate() {
            *standing_w = self.controller.standing_power_w(i, temperature_c);
        }
        Handover::Tick { tick: *tick, standing_w, follows_gap }
    }
}
