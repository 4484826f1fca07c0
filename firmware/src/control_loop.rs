//! What the control task does each time that it runs: trips and commands first, then the ticks whose
//! readings are complete.
//!
//! A board is a [`ControlBoard`]; the tests have one of their own.

use crate::cut_off::CutOff;
use crate::estimates::{Estimates, Origin};
use crate::inbox::{Outcome, Request, TelemetryRequests};
use crate::interlock::Interlock;
use crate::outbox::Outbox;
use crate::phase::Phase;
use crate::queue;
use crate::settings::PendingFindings;
use dr_core::control::{Cause, HardwareLimits, Lockout, LockoutWords, Refusal, RunState, Tick};
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::{Command, ConfigError, Decider, Digest};
use heapless::spsc::{Consumer, Producer};
use wire::{ControlStatus, Event, FromBoard};

/// Functions that the loop needs of a board of N elements.
pub trait ControlBoard<const N: usize> {
    /// The readings of the next tick that is complete. Asked until there is none: a silence can
    /// bring several at once.
    fn poll(&mut self) -> Option<[Reading; N]>;
    /// Puts the levels on the pins; returns whether that succeeded. If not, they are low.
    fn apply(&mut self, tick: &Tick<N>) -> bool;
    /// Returns true if the pins have the levels that were put on them.
    fn holds_levels(&mut self) -> bool;
    /// Lowers all heaters at once, whatever state the rest is in.
    fn heaters_low(&mut self);
    /// The same on the way to a stop; returns whether any was high. If so, a tick begins anew.
    fn lower(&mut self) -> bool;
    /// Connects another input from the next tick on.
    fn select(&mut self, input: FrontEndInput);
    /// A new run begins with a whole tick.
    fn restart(&mut self);
    /// Plans ticks of another length.
    ///
    /// # Errors
    /// A period that the board cannot make.
    fn set_sample_period(&mut self, sample_period_s: f32) -> Result<(), ConfigError>;
    /// Returns true if a tick overran since the last call: the next one came before its end.
    fn overran(&mut self) -> bool;
    /// Returns once the cause that a check of the front end has found.
    fn take_fault(&mut self) -> Option<Cause>;
    /// Puts counters of the front end into the status.
    fn report(&self, _status: &mut ControlStatus) {}
    /// The tick is through, but for its estimate. For boards whose front end is a link.
    fn decided(&mut self, _decider: &Decider<N>, _tick: &Tick<N>) {}
    /// A reply that such a front end waits for. The digest of the wind, and whether the host gets an
    /// estimate, are there once all is estimated.
    fn reply(&mut self, _estimated: Option<(Digest, bool)>) -> Option<FromBoard> {
        None
    }
}

/// Queues and flags of the control task.
pub struct ControlLinks<'a, const N: usize> {
    /// Commands of the host.
    pub requests: Consumer<'a, Request>,
    /// Commands of the settings loader.
    pub orders: Consumer<'a, Command>,
    /// To the estimator.
    pub estimates: Estimates<'a, N>,
    /// Reasons for which no heater may be high.
    pub interlock: &'a Interlock,
    /// Start, set-up, standby.
    pub phase: &'a Phase,
    /// Samples that the host wants.
    pub telemetry: &'a TelemetryRequests,
}

/// State that the control task shares with tasks of lower priority.
pub struct ControlShared<'a, 'b> {
    /// To the host.
    pub outbox: &'a mut Outbox<'b>,
    /// To the settings loader.
    pub outcomes: &'a mut Producer<'b, Outcome>,
    /// To the settings server.
    pub findings: &'a mut PendingFindings,
    /// For the status.
    pub status: &'a mut ControlStatus,
    /// Digest after the last estimated tick, and true if the host gets its estimate.
    pub estimated: (Digest, bool),
}

/// Work that a run leaves: tasks to wake, words to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Woken {
    /// The transmitter.
    pub transmit: bool,
    /// The estimator.
    pub estimate: bool,
    /// The settings server.
    pub settings: bool,
    /// The crash of an earlier start has been acknowledged.
    pub acknowledged: bool,
    /// [`ControlLoop::kept_lockout`] has changed.
    pub lockout: bool,
}

/// The loop. It owns the decider.
pub struct ControlLoop<'a, B, const N: usize> {
    decider: Decider<N>,
    /// As the last start left it, until the decider has it. Not given to it at the start, where
    /// the stack would hold the decider more than once.
    lockout_before: Option<Lockout>,
    /// The trip counter as RAM keeps it across a reset.
    pub kept_lockout: LockoutWords,
    board: B,
    links: ControlLinks<'a, N>,
    cut_off: CutOff,
    woken: Woken,
}

impl<'a, B: ControlBoard<N>, const N: usize> ControlLoop<'a, B, N> {
    /// A loop in standby.
    pub fn new(limits: &'static HardwareLimits, lockout: Lockout, board: B, links: ControlLinks<'a, N>) -> Self {
        Self {
            decider: Decider::new(limits),
            kept_lockout: lockout.words(),
            lockout_before: Some(lockout),
            board,
            links,
            cut_off: CutOff::open(),
            woken: Woken::default(),
        }
    }

    /// Runs once.
    #[inline(never)] // its path is bounded under its name
    pub fn run(&mut self, shared: &mut ControlShared<'_, '_>) -> Woken {
        // Before any trip and any command.
        if let Some(lockout) = self.lockout_before.take() {
            self.decider.restore_lockout(lockout);
            self.decider.expect_host();
        }
        if let Some(cause) = self.links.interlock.take_trip() {
            self.decider.trip(cause);
        }
        if self.links.phase.host_heard.take() {
            self.decider.host_heard();
        }
        if matches!(self.decider.controller().state(), RunState::Running | RunState::Testing) {
            // Nothing holds the lock while the instrument runs; a flipped bit in it must not block
            // `Stop`.
            self.links.phase.lock.give_back();
        }
        self.carry_out_commands(shared);
        // One tick or none; several if the front end was silent.
        while let Some(readings) = self.board.poll() {
            self.tick(&readings, shared);
        }
        if let Some(cause) = self.board.take_fault() {
            self.board.heaters_low();
            self.decider.trip(cause);
        }
        let estimated = self.links.estimates.is_drained().then_some(shared.estimated);
        if let Some(reply) = self.board.reply(estimated) {
            shared.outbox.put(reply);
        }
        self.report(shared);
        self.woken.transmit = shared.outbox.waits();
        self.woken.estimate = !self.links.estimates.is_drained();
        core::mem::take(&mut self.woken)
    }

    fn carry_out_commands(&mut self, shared: &mut ControlShared<'_, '_>) {
        self.carry_out_orders(shared);
        if let Some(to) = self.links.interlock.take_stop() {
            self.stop(to, shared);
        }
        self.carry_out_requests(shared);
    }

    fn carry_out_orders(&mut self, shared: &mut ControlShared<'_, '_>) {
        while self.links.estimates.has_room()
            && let Some(command) = self.links.orders.dequeue()
        {
            if let Some(result) = self.carry_out(Origin::Loader, command, shared.status) {
                // It has room for one, and the loader takes each outcome before its next order.
                queue::put(shared.outcomes, result.map(drop)).ok();
            }
        }
    }

    fn stop(&mut self, to: u16, shared: &mut ControlShared<'_, '_>) {
        // What waited is void: nothing starts behind it.
        while let Some((to, _)) = self.links.requests.dequeue() {
            shared.outbox.put(FromBoard::Reply { to, result: Err(Refusal::Stopped) });
        }
        if let Some(result) = self.carry_out(Origin::Host(to), Command::Stop, shared.status) {
            shared.outbox.put(FromBoard::Reply { to, result });
        }
    }

    fn carry_out_requests(&mut self, shared: &mut ControlShared<'_, '_>) {
        // While settings are written or loaded, the host's commands wait: nothing starts then.
        while !self.links.phase.lock.is_taken()
            && self.links.estimates.has_room()
            && let Some((to, command)) = self.links.requests.dequeue()
        {
            if let Some(result) = self.carry_out(Origin::Host(to), command, shared.status) {
                shared.outbox.put(FromBoard::Reply { to, result });
            }
        }
    }

    /// Carries out a command, and passes on what board and estimator need of it. No result where
    /// the estimator replies.
    fn carry_out(
        &mut self,
        origin: Origin,
        command: Command,
        status: &mut ControlStatus,
    ) -> Option<Result<dr_core::Reply, Refusal>> {
        let Self { decider, board, links, woken, .. } = self;
        if let (Command::SamplePeriod { sample_period_s }, RunState::Standby) = (command, decider.controller().state())
            && let Err(error) = board.set_sample_period(sample_period_s)
        {
            return Some(Err(Refusal::Invalid { element: None, error }));
        }
        let is_lowered = matches!(command, Command::Stop) && board.lower();
        let reply = match decider.handle(command, |handover| links.estimates.put(origin, handover)) {
            Ok(reply) => reply?,
            Err(refusal) => return Some(Err(refusal)),
        };
        if is_lowered {
            decider.lowered();
        }
        status.margins.clear();
        for of_element in decider.controller().margins() {
            status.margins.push(of_element).ok();
        }
        match command {
            // Not before: a start that is refused must not disturb the run.
            Command::Start => board.restart(),
            Command::SelfTest(_) => links.phase.proof_due.raise(),
            Command::Acknowledge => {
                woken.acknowledged = true;
                // A bit flip has cleared its settings.
                let has_forgotten = decider.controller().sample_period_s().is_none();
                woken.settings |= links.phase.acknowledge(has_forgotten);
            }
            _ => {}
        }
        Some(Ok(reply))
    }

    fn tick(&mut self, readings: &[Reading; N], shared: &mut ControlShared<'_, '_>) {
        let Self { decider, board, links, cut_off, woken, .. } = self;
        // Before the reasons for which others have lowered them.
        let held = board.holds_levels();
        if links.interlock.expired.take() {
            decider.trip(Cause::Deadline);
        }
        if !held && !links.interlock.requests_trip() {
            decider.trip(Cause::Heater);
        }
        let tick = decider.tick(readings);
        // The heaters first: all else decides nothing.
        let applied = board.apply(&tick);
        // If the timer has expired since, these levels are too old; the next tick trips. If the
        // supply has fallen since, this task is pending again, and trips then. Either may have
        // lowered a pin while it was raised, which is no fault of the pin.
        if links.interlock.forbids() {
            board.heaters_low();
        } else if !applied {
            decider.trip(Cause::Heater);
        }
        let is_tripped = matches!(tick.state, RunState::Tripped(_));
        links.interlock.cut.set(cut_off.judge(is_tripped, readings));
        board.select(decider.input());
        links.estimates.put_tick(decider, &tick);
        board.decided(decider, &tick);
        if let Some(test) = decider.take_self_test() {
            test.findings().iter().for_each(|finding| shared.outbox.put(FromBoard::Tested(*finding)));
            shared.findings.put(test.unix_s(), test.findings());
            woken.settings = true;
        }
        if links.telemetry.wants_sample(tick.tick) {
            shared.outbox.put(FromBoard::of_tick(&tick));
        }
        shared.status.late_ticks = shared.status.late_ticks.wrapping_add(u32::from(board.overran()));
    }

    /// Says how things stand after a run.
    fn report(&mut self, shared: &mut ControlShared<'_, '_>) {
        let Self { decider, board, links, kept_lockout, woken, .. } = self;
        let (controller, status) = (decider.controller(), &mut *shared.status);
        status.missed_estimates = links.estimates.missed;
        board.report(status);
        status.bit_flips = controller.bit_flips();
        status.armed = controller.is_armed();
        let lockout = controller.lockout();
        if lockout.words() != *kept_lockout {
            // Once a second, and with each trip.
            *kept_lockout = lockout.words();
            woken.lockout = true;
            status.history = lockout.history();
        }
        let state = controller.state();
        links.phase.lock.standby(state == RunState::Standby);
        if core::mem::replace(&mut status.state, state) != state {
            shared.outbox.put(FromBoard::Event(Event { tick: controller.ticks(), state }));
        }
    }
}

#[cfg(test)]
mod tests;
