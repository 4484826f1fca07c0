//! Settings of the meter, biases applied to the device, and misbehaviour on purpose.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Capacitance of a device in F, none at an overload: it is called with the bias in V that has been
/// applied, and with the time since the last call, whenever the bias changes and at each reading.
/// What it gives counts at readings.
pub type PretendedDevice = Box<dyn FnMut(f64, Duration) -> Option<f64> + Send>;

/// A change of the applied bias.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiasStep {
    /// Since the meter was switched on.
    pub time: Duration,
    /// Applied from now on: 0 V while the bias is off.
    pub bias_v: f64,
}

/// Commands that are remembered.
const MOST_COMMANDS: usize = 1_000;

pub(super) struct MeterState {
    device: PretendedDevice,
    misbehaviour: Option<Misbehaviour>,
    pub(super) identity: String,
    pub(super) errors: VecDeque<&'static str>,
    pub(super) bias_v: f64,
    pub(super) is_on: bool,
    pub(super) waits_for_bus: bool,
    pub(super) is_long: bool,
    pub(super) has_overload: bool,
    /// The last reading: F, and its status.
    pub(super) reading: (f64, i8),
    begun: Instant,
    /// Time of the last call of the device.
    called: Instant,
    commands: usize,
    pub(super) latest_commands: VecDeque<String>,
    pub(super) history: Vec<BiasStep>,
}

/// The value that stands where there is none.
pub(super) const NO_NUMBER: f64 = 9.9e37;

impl MeterState {
    pub(super) fn new(identity: String, misbehaviour: Option<Misbehaviour>, device: PretendedDevice) -> Self {
        let now = Instant::now();
        Self {
            device,
            misbehaviour,
            identity,
            errors: VecDeque::new(),
            bias_v: 0.0,
            is_on: false,
            waits_for_bus: false,
            is_long: false,
            has_overload: false,
            reading: (NO_NUMBER, -1),
            begun: now,
            called: now,
            commands: 0,
            latest_commands: VecDeque::new(),
            history: vec![BiasStep { time: Duration::ZERO, bias_v: 0.0 }],
        }
    }

    /// Counts a command: how the meter misbehaves at it.
    pub(super) fn count(&mut self, command: &str) -> Option<MisbehaviourKind> {
        let kind = self.misbehaviour.and_then(|misbehaviour| misbehaviour.kind_at(self.commands));
        self.commands += 1;
        if self.latest_commands.len() == MOST_COMMANDS {
            self.latest_commands.pop_front();
        }
        self.latest_commands.push_back(command.to_owned());
        kind
    }

    /// Tells whether it accepts nobody any more.
    pub(super) fn is_gone(&self) -> bool {
        let now = self.misbehaviour.filter(|misbehaviour| misbehaviour.is_lasting && self.commands > misbehaviour.at);
        now.is_some_and(|misbehaviour| misbehaviour.kind == MisbehaviourKind::Disconnect)
    }

    pub(super) fn reset(&mut self) {
        (self.waits_for_bus, self.is_long) = (false, false);
        self.reading = (NO_NUMBER, -1);
        self.bias(0.0, false);
    }

    pub(super) fn bias(&mut self, bias_v: f64, is_on: bool) {
        let before_v = self.applied_v();
        (self.bias_v, self.is_on) = (bias_v, is_on);
        let after_v = self.applied_v();
        if after_v != before_v {
            self.call_device(before_v);
            self.history.push(BiasStep { time: self.begun.elapsed(), bias_v: after_v });
        }
    }

    pub(super) fn measure(&mut self) {
        let capacitance_f = self.call_device(self.applied_v()).filter(|_| !self.has_overload);
        self.reading = capacitance_f.map_or((NO_NUMBER, 1), |capacitance_f| (capacitance_f, 0));
    }

    pub(super) fn applied_v(&self) -> f64 {
        if self.is_on { self.bias_v } else { 0.0 }
    }

    fn call_device(&mut self, bias_v: f64) -> Option<f64> {
        let held = self.called.elapsed();
        self.called = Instant::now();
        (self.device)(bias_v, held)
    }
}

/// When a pretended meter misbehaves, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misbehaviour {
    /// Number of the command, counted from 0 over all connections.
    pub at: usize,
    /// At all commands from there, rather than at this one.
    pub is_lasting: bool,
    /// Kind of misbehaviour.
    pub kind: MisbehaviourKind,
}

impl Misbehaviour {
    /// Kind of misbehaviour at a command.
    fn kind_at(self, command: usize) -> Option<MisbehaviourKind> {
        let is_now = command == self.at || self.is_lasting && command > self.at;
        is_now.then_some(self.kind)
    }
}

/// Kinds of misbehaviour of a simulated meter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MisbehaviourKind {
    /// Closes the connection and does nothing; if that lasts, new ones too.
    Disconnect,
    /// Obeys, and sends a line of rubbish in place of an answer, also where none is due.
    Garbage,
    /// Obeys, and sends the first half of an answer.
    HalfAnswer,
    /// Neither obeys nor answers.
    Silence,
    /// Has no reading.
    Overload,
    /// Puts an error into its queue, and neither obeys nor answers.
    Refusal,
    /// Obeys, and reads a bias back that it has not.
    WrongBias,
}
