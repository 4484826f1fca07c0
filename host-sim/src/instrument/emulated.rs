//! The firmware on an emulated Cortex-M4F: `qemu-system-arm -M netduinoplus2`, in lock-step.
//!
//! Two ways to it ([`Path`]): `Usart`, which is what a cable would carry, and `Fifo`, the same messages through named
//! pipes, many times faster. Emulator and this thread are kept on one core: each waits for the other all the time, and
//! waking up on another core costs more than the work.

mod process;
mod stream;

use super::link::{Link, Persistence, Stream};
use super::lock_step::packed;
use super::{Account, Body, InstrumentError, Keeper, TickReport, why_it_started};
use dr_core::control::{Command, Finding, Heaters, Reply};
use dr_core::sensor::{Input, Reading};
use process::Process;
use std::path::Path as FilePath;
use std::time::Duration;
pub use stream::Pipe;
use wire::{FromBoard, HeaterFrame, Identity, Provocation, SettingsReply, SettingsRequest, Status, ToBoard};

/// Exchanges after which the host link is looked at, where exchanges do not go by it.
const ATTEND_EVERY: u32 = 256;

/// How to talk to the emulated board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Path {
    /// A pair of named pipes.
    #[default]
    Fifo,
    /// Two emulated USARTs: host link and front end.
    Usart,
}

/// The links of the emulated board.
struct Links {
    host: Link<Pipe>,
    /// Its own only where the front end has a USART of its own.
    bench: Option<Link<Pipe>>,
}

impl Links {
    /// Readings and levels go this way.
    fn bench(&mut self) -> &mut Link<Pipe> {
        self.bench.as_mut().unwrap_or(&mut self.host)
    }
}

/// The firmware, running in an emulator.
pub struct Emulated {
    process: Process,
    links: Links,
    identity: Identity,
    digest: u64,
    answer: Option<HeaterFrame>,
    sample: Option<TickReport>,
    status: Option<Status>,
    input: Input,
    findings: Vec<Finding>,
    /// Who it has become by a start that nobody here asked for.
    reborn: Option<Identity>,
    /// Exchanges since the host link was last read.
    unattended: u32,
}

impl Emulated {
    /// Starts the emulator with a firmware and waits until it answers.
    ///
    /// # Errors
    /// If there is no emulator or no firmware, or if it does not answer.
    pub fn start(firmware: &FilePath, path: Path) -> Result<Self, InstrumentError> {
        Self::start_with(firmware, path, None)
    }

    /// The same with settings that last from run to run: in this file, which is made if there is none.
    ///
    /// # Errors
    /// As [`start`](Self::start), and if the file is no flash.
    pub fn start_with(firmware: &FilePath, path: Path, flash: Option<&FilePath>) -> Result<Self, InstrumentError> {
        let mut process = Process::prepare(firmware)?;
        if let Some(flash) = flash {
            process.keep_settings_in(flash)?;
        }
        let mut links = match path {
            Path::Fifo => Links { host: Link::new(process.start_with_fifos()?), bench: None },
            Path::Usart => {
                let (host, bench) = process.start_with_usarts()?;
                Links { host: Link::new(host), bench: Some(Link::new(bench)) }
            }
        };
        let identity = process.patiently(|patience| links.host.hello(patience)).map_err(|error| match error {
            InstrumentError::Silent(patience) => InstrumentError::Mute { firmware: firmware.to_owned(), patience },
            other => other,
        })?;
        // What is kept may ask for fewer, and here each tick's sample is waited for.
        links.host.send(&ToBoard::Telemetry { every: 1 })?;
        Ok(Self {
            process,
            links,
            identity,
            digest: 0,
            answer: None,
            sample: None,
            status: None,
            input: Input::Element,
            findings: Vec::new(),
            reborn: None,
            unattended: 0,
        })
    }

    /// Puts bytes on the host link that no host would: to see what the board makes of them.
    ///
    /// # Errors
    /// If the board is gone.
    pub fn inject(&mut self, bytes: &[u8]) -> Result<(), InstrumentError> {
        Ok(self.links.host.stream_mut().write_all(bytes)?)
    }

    /// Waits no longer than so for any answer: where boards are expected that never answer again.
    pub const fn be_patient_for(&mut self, patience: Duration) {
        self.process.set_patience(patience);
    }

    /// The board's last word on its health.
    pub fn status(&self) -> Option<&Status> {
        self.status.as_ref()
    }

    /// Makes something go wrong on the board. What becomes of it shows in what it does next.
    ///
    /// # Errors
    /// If the board is gone.
    pub fn provoke(&mut self, what: Provocation) -> Result<(), InstrumentError> {
        self.links.bench().send(&ToBoard::Provoke(what)).map(drop)
    }

    /// A tick passes in which the front end says nothing; gives the levels as they stand then.
    ///
    /// # Errors
    /// If the board is gone, or answers something else.
    pub fn silence(&mut self) -> Result<HeaterFrame, InstrumentError> {
        self.answered(&ToBoard::Silence).map_err(|error| self.process.explain(error))
    }

    /// Waits for a board to start anew, and goes on with it as it is then.
    ///
    /// # Errors
    /// If it does not.
    pub fn reborn(&mut self) -> Result<Identity, InstrumentError> {
        while self.reborn.is_none() {
            let message = self.process.patiently(|patience| self.links.host.receive(patience))?;
            self.hear(message);
        }
        self.forget();
        self.identity = self.reborn.take().unwrap_or_else(|| self.identity.clone());
        Ok(self.identity.clone())
    }

    /// Asks something of the settings while the supply fails after so many more bytes of writing (an erase counts as 16). Says whether it has failed: the
    /// board has started anew then, as if it had just been switched on.
    ///
    /// # Errors
    /// If the board is gone, or refuses.
    pub fn ask_with_a_cut(&mut self, after_bytes: u32, request: &SettingsRequest) -> Result<bool, InstrumentError> {
        // What it has said before is taken by then: whoever says who he is after that has started anew.
        self.ask_settings(&SettingsRequest::Read { key: 0 })?;
        self.provoke(Provocation::CutPower { after_bytes })?;
        let asked = self.links.host.send(&ToBoard::Settings(request.clone()))?;
        loop {
            match self.process.patiently(|patience| self.links.host.receive(patience))? {
                FromBoard::Setting(answer) if answer.to == asked => {
                    answer.result.map_err(InstrumentError::Settings)?;
                    self.provoke(Provocation::CutPower { after_bytes: u32::MAX })?;
                    return Ok(false);
                }
                FromBoard::Identity(identity) => {
                    self.forget();
                    self.identity = identity;
                    return Ok(true);
                }
                other => self.hear(other),
            }
        }
    }

    /// Asks for no samples: what is left of an exchange is readings, levels and digest. For runs of millions of ticks of
    /// which only the digest is wanted, by [`exchange_levels`](Self::exchange_levels).
    ///
    /// # Errors
    /// If the board is gone.
    pub fn without_samples(&mut self) -> Result<(), InstrumentError> {
        self.links.host.send(&ToBoard::Telemetry { every: 0 }).map(drop)
    }

    /// One tick, answered by levels and digest alone.
    ///
    /// # Errors
    /// If the board is gone, or answers something else.
    pub fn exchange_levels(&mut self, readings: &[Reading]) -> Result<HeaterFrame, InstrumentError> {
        self.unattended += 1;
        if self.unattended >= ATTEND_EVERY {
            self.attend()?;
        }
        self.ask(readings).map_err(|error| self.process.explain(error))
    }

    /// Takes what has come by the host link, waiting for nothing. Left alone, a link fills up with status messages within
    /// ten seconds, and the emulator stands still until somebody reads them.
    fn attend(&mut self) -> Result<(), InstrumentError> {
        self.unattended = 0;
        loop {
            match self.links.host.receive(Duration::ZERO) {
                Ok(message) => self.hear(message),
                Err(InstrumentError::Silent(_)) => return Ok(()),
                Err(error) => return Err(self.process.explain(error)),
            }
        }
    }

    fn ask(&mut self, readings: &[Reading]) -> Result<HeaterFrame, InstrumentError> {
        self.answered(&ToBoard::Readings(packed(readings)?))
    }

    /// Sends what is answered by levels.
    fn answered(&mut self, message: &ToBoard) -> Result<HeaterFrame, InstrumentError> {
        let asked = self.links.bench().send(message)?;
        let answer = loop {
            let message = self.process.patiently(|patience| self.links.bench().receive(patience))?;
            self.hear(message);
            if let Some(answer) = self.answer.take() {
                break answer;
            }
            self.still_the_same()?;
        };
        if answer.to != asked {
            return Err(InstrumentError::Protocol(format!("exchange {asked} was answered as {}", answer.to)));
        }
        (self.digest, self.input) = (answer.digest, answer.input);
        Ok(answer)
    }

    /// The sample of the exchange just answered: it comes by the host link.
    fn sample(&mut self, levels: Heaters) -> Result<TickReport, InstrumentError> {
        loop {
            if let Some(report) = self.sample.take() {
                return if report.sample.heaters == levels {
                    Ok(report)
                } else {
                    Err(InstrumentError::Protocol(format!(
                        "levels {levels:?} came with the sample {:?}",
                        report.sample
                    )))
                };
            }
            let message = self.process.patiently(|patience| self.links.host.receive(patience))?;
            self.hear(message);
            self.still_the_same()?;
            self.unattended = 0;
        }
    }

    /// An error if the board has started anew.
    fn still_the_same(&self) -> Result<(), InstrumentError> {
        self.reborn.as_ref().map_or(Ok(()), |reborn| Err(InstrumentError::Restarted(why_it_started(reborn))))
    }

    /// What was of the life before.
    fn forget(&mut self) {
        (self.answer, self.sample, self.status, self.input) = (None, None, None, Input::Element);
        self.findings.clear();
    }

    fn hear(&mut self, message: FromBoard) {
        match message {
            FromBoard::Heaters(answer) => self.answer = Some(answer),
            FromBoard::Sample(_) | FromBoard::Observed(_) => self.sample = TickReport::of(message),
            FromBoard::Status(status) => self.status = Some(status),
            FromBoard::Tested(finding) => self.findings.push(finding),
            // Changes of state are in every sample; the rest answers questions that an exchange does not ask.
            FromBoard::Event(_) | FromBoard::Reply { .. } | FromBoard::Setting(_) => {}
            // A board says who it is when it starts, and whenever it is asked.
            FromBoard::Identity(identity) => {
                if identity.starts != self.identity.starts {
                    self.reborn = Some(identity);
                }
            }
        }
    }
}

impl Keeper for Emulated {
    fn firmware(&self) -> &str {
        &self.identity.firmware
    }

    fn ask_settings(&mut self, request: &SettingsRequest) -> Result<SettingsReply, InstrumentError> {
        let mut aside = Vec::new();
        let once = Persistence { tries: 1, each: self.process.patience() };
        let reply = self.links.host.ask(request, once, &mut |message| aside.push(message));
        aside.into_iter().for_each(|message| self.hear(message));
        reply.map_err(|error| self.process.explain(error))
    }
}

impl Body for Emulated {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        let mut aside = Vec::new();
        // Nothing gets lost on the way to an emulator.
        let once = Persistence { tries: 1, each: self.process.patience() };
        let reply = self.links.host.command(command, once, &mut |message| aside.push(message));
        aside.into_iter().for_each(|message| self.hear(message));
        reply.map_err(|error| self.process.explain(error))
    }

    fn exchange(&mut self, readings: &[Reading]) -> Result<TickReport, InstrumentError> {
        let answer = self.exchange_levels(readings)?;
        self.sample(answer.heaters).map_err(|error| self.process.explain(error))
    }

    fn input(&self) -> Input {
        self.input
    }

    fn findings(&mut self) -> Vec<Finding> {
        std::mem::take(&mut self.findings)
    }

    fn digest(&self) -> u64 {
        self.digest
    }

    fn finish(mut self: Box<Self>) -> Result<Account, InstrumentError> {
        if self.links.bench.is_some() {
            // What the board has still to write is written when it answers; by one link for all it comes before the end in any case.
            let _ = self.ask_settings(&SettingsRequest::Check);
        }
        // The front end's link: the board looks there whatever it is doing.
        let sent = self.links.bench().send(&ToBoard::Finish { code: 0 });
        sent.map_err(|error| self.process.explain(error))?;
        let log = self.process.wait()?;
        Ok(Account { link: self.links.host.counters(), status: self.status, log })
    }
}
