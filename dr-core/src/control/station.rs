//! A controller with its anemometer: all that an instrument of N elements decides and answers.

use super::anemometer::{Anemometer, WindCommand, WindTick};
use super::command::{Command, Refusal, Reply};
use super::controller::{Controller, Probe, RunState, Tick};
use super::digest::Digest;
use super::guard::{Cause, Trip};
use super::self_test::SelfTest;
use crate::sensor::{Input, Reading};

/// The two, which are told and ticked together.
///
/// A tick has two halves, so that heaters have their levels before the wind is worked out:
/// [`tick`](Self::tick) decides, [`sense`](Self::sense) answers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Station<const N: usize> {
    controller: Controller<N>,
    anemometer: Anemometer<N>,
    /// The one that goes on, or the last one that came to its end.
    self_test: SelfTest<N>,
    /// Nobody has asked yet what it has found.
    is_news: bool,
    /// What the front end has been asked for with the last tick.
    input: Input,
}

impl<const N: usize> Station<N> {
    /// In standby, and knowing nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// The controller, to look at.
    pub const fn controller(&self) -> &Controller<N> {
        &self.controller
    }

    /// Carries out a command.
    ///
    /// # Errors
    /// Says why not, and changes nothing.
    pub fn handle(&mut self, command: Command) -> Result<Reply, Refusal> {
        if let Command::Wind(wind) = &command {
            return self.handle_wind(wind);
        }
        let was_upset = matches!(self.controller.state(), RunState::Tripped(Trip { cause: Cause::Upset, .. }));
        let reply = self.controller.handle(command)?;
        match command {
            // What was upset cannot be told from what was not.
            Command::Acknowledge if was_upset => self.anemometer = Anemometer::new(),
            // Its gains were for the old period, or for another head.
            Command::Clear | Command::SamplePeriod { .. } => self.anemometer = Anemometer::new(),
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
            // Sealed with the command, an upset would not be found any more.
            return Err(Refusal::Tripped(self.controller.trip_for_upset()));
        }
        let element = match command {
            WindCommand::Own { element, .. } => Some(*element),
            WindCommand::Faster(faster) => Some(faster.element),
            WindCommand::Cross(cross) => Some(cross.to),
            WindCommand::Part { config, .. } => Some(config.element),
            _ => None,
        };
        let invalid = |error| Refusal::Invalid { element, error };
        self.anemometer.handle(command, sample_period_s).map_err(invalid)?;
        Ok(Reply::Done)
    }

    /// Trips for a cause that the controller cannot see by itself, unless it is tripped already.
    pub fn trip(&mut self, cause: Cause) {
        self.controller.trip(cause);
    }

    /// Flips a bit of the controller's, for fault injection: [`Controller::upset`].
    #[cfg(feature = "upset")]
    pub fn upset(&mut self, which: usize, element: usize, bit: u32) -> Option<&'static str> {
        self.controller.upset(which, element, bit)
    }

    /// What the front end is to read from now on, asked for after each tick.
    pub const fn input(&self) -> Input {
        self.input
    }

    /// A self-test that is over: once.
    pub fn take_self_test(&mut self) -> Option<&SelfTest<N>> {
        core::mem::take(&mut self.is_news).then_some(&self.self_test)
    }

    /// The first half of a tick: readings in, levels out.
    pub fn tick(&mut self, readings: &[Reading; N]) -> Tick<N> {
        // What is not of the elements is none of the controller's business.
        let nothing = [Reading::Missing; N];
        let (of_elements, probe) = match self.input {
            Input::Element => (readings, self.self_test.probe()),
            Input::Shorted | Input::Reference => (&nothing, Probe::Blind),
        };
        let mut tick = self.controller.tick_with(of_elements, probe);
        if !self.self_test.is_over() || !matches!(self.input, Input::Element) {
            self.step_test(readings, &mut tick);
        }
        tick
    }

    /// What a tick means to the self-test, and to the front end after one that was ended early.
    #[inline(never)]
    fn step_test(&mut self, readings: &[Reading; N], tick: &mut Tick<N>) {
        self.input = Input::Element;
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

    /// The second half: the wind, where an answer is due.
    pub fn sense(&mut self, tick: &Tick<N>) -> Option<WindTick> {
        if !matches!(tick.state, RunState::Tripped(_)) && !self.anemometer.is_whole_at(tick.tick) {
            self.controller.trip_for_upset();
        }
        self.anemometer.step(tick, |element, temperature_c| self.controller.standing_power_w(element, temperature_c))
    }

    /// Folds all that is known after both halves into a digest.
    pub fn fold(&self, tick: &Tick<N>, told: Option<&WindTick>, digest: &mut Digest) {
        self.controller.fold(tick, digest);
        self.anemometer.fold(told, digest);
    }
}

#[cfg(test)]
mod tests;
