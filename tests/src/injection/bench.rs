//! The firmware's parts in this process: receiver, inbox, station, dead man's handle and memory of
//! past lives, put together as its tasks are.

use super::Subject;
use dr_core::control::{Cause, Heaters};
use dr_core::sensor::Reading;
use dr_core::{Command, Reply, RunDigests};
use firmware::crash_record::{CrashRecord, end_of};
use firmware::dead_man::DeadManCounter;
use firmware::inbox::{Exchange, Inbox, Request, SettingsJob, TelemetryRequests, Wake};
use heapless::spsc::{Consumer, Queue};
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentError, LinkReport, LockStepController, TickReport};
use host_sim::settings::Settings;
use wire::{
    BoardKind, Crash, CrashKind, Identity, LinkCounters, MOST_ELEMENTS, Name, Provocation, Receiver, ResetCause,
    SettingsRefusal, ToBoard,
};

/// The parts of a board that knows its host by bytes alone.
pub struct Bench<'a> {
    identity: Identity,
    body: InProcess,
    receiver: Receiver,
    inbox: Inbox<'a>,
    requests: Consumer<'a, Request>,
    dead_man: DeadManCounter,
    bitten: bool,
    pins: Heaters,
    past: CrashRecord,
    /// Its time goes on when somebody asks for it.
    asked_s: u32,
}

/// Lends such a board.
pub fn with_bench<R>(take: impl FnOnce(Bench<'_>) -> R) -> R {
    let (mut requests, mut exchanges, questions) =
        (Queue::<Request, 8>::new(), Queue::<Exchange, 4>::new(), TelemetryRequests::starting());
    // It keeps no settings: what is asked of them waits for ever.
    let mut errands = Queue::<SettingsJob, 2>::new();
    let ((request_in, requests), (exchange_in, _)) = (requests.split(), exchanges.split());
    take(Bench {
        identity: Identity {
            firmware: Name::try_from("the firmware's parts").unwrap_or_default(),
            board: BoardKind::Virtual,
            elements: MOST_ELEMENTS as u8,
            order: dr_core::model::ORDER as u8,
            reset: ResetCause::PowerOn,
            starts: 1,
            crash: None,
            unique_id: [0; 3],
        },
        body: InProcess::new(),
        receiver: Receiver::new(),
        inbox: Inbox::new(request_in, exchange_in, errands.split().0, &questions, false),
        requests,
        dead_man: DeadManCounter::stopped(),
        bitten: false,
        pins: Heaters::default(),
        past: CrashRecord::FIRST,
        asked_s: 0,
    })
}

impl Bench<'_> {
    /// Starts anew as the firmware does.
    fn start_anew(&mut self, reset: ResetCause) {
        // Without supply the RAM is lost.
        self.past = match reset {
            ResetCause::PowerOn => CrashRecord::FIRST,
            _ => CrashRecord::after(&self.past.record()),
        };
        (self.body, self.receiver) = (InProcess::new(), Receiver::new());
        (self.dead_man, self.bitten, self.pins) = (DeadManCounter::stopped(), false, Heaters::default());
        while self.requests.dequeue().is_some() {}
        if let Some(cause) = self.past.trip(reset) {
            self.body.station_mut().trip(cause);
        }
        (self.identity.reset, self.identity.starts) = (reset, self.past.starts);
        self.identity.crash.clone_from(&self.past.crash);
        self.past = self.past.kept();
    }

    fn crash(&mut self, kind: CrashKind) {
        self.pins = Heaters::default();
        self.past.crash = Some(Crash { kind, file: end_of("somewhere.rs"), at: 1 });
        self.past.requested = true;
        self.start_anew(ResetCause::Software);
    }
}

impl LockStepController for Bench<'_> {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        let reply = self.body.command(command)?;
        if command == Command::Acknowledge {
            self.past.crash = None;
        }
        Ok(reply)
    }

    fn exchange(&mut self, readings: &[Reading]) -> Result<TickReport, InstrumentError> {
        if core::mem::take(&mut self.bitten) {
            self.body.station_mut().trip(Cause::Deadline);
        }
        let told = self.body.exchange(readings)?;
        self.pins = told.sample.heaters;
        self.dead_man.decided(self.pins.0 != 0);
        Ok(told)
    }

    fn digests(&self) -> RunDigests {
        self.body.digests()
    }

    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        Ok(LinkReport::default())
    }
}

impl Subject for Bench<'_> {
    fn silence(&mut self) -> Result<Heaters, InstrumentError> {
        if self.dead_man.tick_passed() {
            (self.pins, self.bitten) = (Heaters::default(), true);
        }
        Ok(self.pins)
    }

    fn hear(&mut self, bytes: &[u8]) -> Result<(), InstrumentError> {
        for &byte in bytes {
            if let Some(received) = self.receiver.push::<ToBoard>(byte) {
                let stop = matches!(self.inbox.accept(&received), Wake::Stop(_)).then_some(Command::Stop);
                if let Some(command) = stop.or_else(|| self.requests.dequeue().map(|(_, command)| command)) {
                    // A refusal is told to whoever sent it.
                    self.command(command).ok();
                }
            }
        }
        Ok(())
    }

    fn counted(&mut self) -> Result<(u32, LinkCounters), InstrumentError> {
        self.asked_s += 1;
        Ok((self.asked_s, self.receiver.counters()))
    }

    fn harm(&mut self, harm: Provocation) -> Result<(), InstrumentError> {
        match harm {
            Provocation::Panic => self.crash(CrashKind::Panic),
            Provocation::Fault => self.crash(CrashKind::Fault),
            Provocation::Reset => self.start_anew(ResetCause::Pin),
            // Memory and flash have ways of their own.
            Provocation::BitFlip { .. } | Provocation::CutPower { .. } => {}
        }
        Ok(())
    }

    fn upset(&mut self, which: usize, element: usize, bit: u32) -> Result<bool, InstrumentError> {
        Ok(self.body.station_mut().flip_bit(which, element, bit).is_some())
    }

    fn kept(&mut self) -> Result<Settings, InstrumentError> {
        Err(keeps_none())
    }

    fn store_with_a_cut(&mut self, _: &Settings, _: u32) -> Result<bool, InstrumentError> {
        Err(keeps_none())
    }
}

fn keeps_none() -> InstrumentError {
    InstrumentError::Settings(SettingsRefusal::Flash)
}
