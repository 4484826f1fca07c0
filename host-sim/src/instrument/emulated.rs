//! The firmware on an emulated Cortex-M4F: `qemu-system-arm -M netduinoplus2`, in lock-step.
//!
//! Two ways to it ([`EmulatorLink`]): `Usart`, which is what a cable would carry, and `Fifo`, the
//! same messages through named pipes, many times faster. Emulator and this thread are kept on one
//! core: each waits for the other all the time, and waking up on another core costs more than the
//! work.

mod process;

use super::error::InstrumentError;
use super::link::{Aside, BoardLink, BoardStream, RetryPolicy};
use super::observation::{LinkReport, TickReport};
use super::port::{LockStepController, SettingsPort, granted_by};
use super::status::why_it_started;
use dr_core::control::{HardwareLimits, SelfTestFinding};
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::{Command, Digest, Reply, RunDigests};
pub use process::Pipe;
use process::Process;
use std::path::Path;
use std::time::Duration;
use wire::{
    FromBoard, HeaterFrame, Identity, MOST_ELEMENTS, Provocation, Readings, SettingsReply, SettingsRequest, Status,
    ToBoard, WindFrame,
};

/// Exchanges after which the host link is looked at, where exchanges do not go by it.
const ATTEND_EVERY: u32 = 256;

/// Way to talk to the emulated board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EmulatorLink {
    /// A pair of named pipes.
    #[default]
    Fifo,
    /// Two emulated USARTs: host link and front end.
    Usart,
}

/// Readings as they travel.
fn packed(readings: &[Reading]) -> Result<Readings, InstrumentError> {
    Readings::new(readings).ok_or(InstrumentError::TooManyElements { head: readings.len(), board: MOST_ELEMENTS })
}

/// The links of the emulated board.
struct Links {
    host: BoardLink<Pipe>,
    /// Its own only where the front end has a USART of its own.
    bench: Option<BoardLink<Pipe>>,
}

impl Links {
    /// Readings and levels go this way.
    fn bench(&mut self) -> &mut BoardLink<Pipe> {
        self.bench.as_mut().unwrap_or(&mut self.host)
    }
}

/// The firmware, running in an emulator.
pub struct Emulated {
    process: Process,
    links: Links,
    identity: Identity,
    digests: RunDigests,
    answer: Option<HeaterFrame>,
    sample: Option<TickReport>,
    wind: Option<WindFrame>,
    status: Option<Status>,
    input: FrontEndInput,
    findings: Vec<SelfTestFinding>,
    /// Its identity after a start that this host did not request.
    reborn: Option<Identity>,
    /// Exchanges since the host link was last read.
    unattended: u32,
}

impl Emulated {
    /// Starts the emulator with a firmware and waits until it answers.
    ///
    /// # Errors
    /// If there is no emulator or no firmware, or if it does not answer.
    pub fn start(firmware: &Path, path: EmulatorLink) -> Result<Self, InstrumentError> {
        Self::start_with(firmware, path, None)
    }

    /// The same with settings that last from run to run: in this file, which is made if there is
    /// none.
    ///
    /// # Errors
    /// As [`start`](Self::start), and if the file is no flash.
    pub fn start_with(firmware: &Path, path: EmulatorLink, flash: Option<&Path>) -> Result<Self, InstrumentError> {
        let mut process = Process::prepare(firmware)?;
        if let Some(flash) = flash {
            process.keep_settings_in(flash)?;
        }
        let mut links = match path {
            EmulatorLink::Fifo => Links { host: BoardLink::new(process.start_with_fifos()?), bench: None },
            EmulatorLink::Usart => {
                let (host, bench) = process.start_with_usarts()?;
                Links { host: BoardLink::new(host), bench: Some(BoardLink::new(bench)) }
            }
        };
        let identity = process.until_timeout(|timeout| links.host.hello(timeout)).map_err(|error| match error {
            InstrumentError::Silent(timeout) => InstrumentError::Unusable(format!(
                "{} has not said a word for {:.0} s; is it the firmware of the virtual board?",
                firmware.display(),
                timeout.as_secs_f64()
            )),
            other => other,
        })?;
        // The kept settings may ask for fewer, and here each tick's sample is waited for.
        links.host.send(&ToBoard::Telemetry { every: 1 })?;
        Ok(Self {
            process,
            links,
            identity,
            digests: RunDigests::default(),
            answer: None,
            sample: None,
            wind: None,
            status: None,
            input: FrontEndInput::Element,
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

    /// Timeout of any answer: shorter where boards are expected that never answer again.
    pub const fn set_timeout(&mut self, timeout: Duration) {
        self.process.timeout = timeout;
    }

    /// The board's last status.
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

    /// Lets a tick pass without readings; returns the levels as they stand then.
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
            let message = self.next_message()?;
            self.hear(message);
        }
        self.forget();
        self.identity = self.reborn.take().unwrap_or_else(|| self.identity.clone());
        Ok(self.identity.clone())
    }

    /// Sends requests about settings while the supply fails after so many more bytes of writing
    /// (an erase counts as 16). Returns whether it has failed: the board has started anew then, as
    /// if it had just been switched on.
    ///
    /// # Errors
    /// If the board is gone, or refuses.
    pub fn ask_with_a_cut(&mut self, after_bytes: u32, requests: &[SettingsRequest]) -> Result<bool, InstrumentError> {
        // Earlier messages are taken by then: an identity after that means that the board has
        // started anew.
        self.ask_settings(&SettingsRequest::Check).ok();
        self.provoke(Provocation::CutPower { after_bytes })?;
        for request in requests {
            let asked = self.links.host.send(&ToBoard::Settings(request.clone()))?;
            loop {
                match self.next_message()? {
                    FromBoard::Setting(answer) if answer.to == asked => {
                        answer.result.map_err(InstrumentError::Settings)?;
                        break;
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
        self.provoke(Provocation::CutPower { after_bytes: u32::MAX })?;
        Ok(false)
    }

    /// Turns samples off: what is left of an exchange is readings, levels and digest. For runs of
    /// millions of ticks of which only the digest is wanted, by
    /// [`exchange_levels`](Self::exchange_levels).
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
        let packed = packed(readings)?;
        self.answered(&ToBoard::Readings(packed)).map_err(|error| self.process.explain(error))
    }

    /// Reads what has come by the host link, waiting for nothing. Left alone, a link fills up with
    /// status messages within ten seconds, and the emulator stands still until somebody reads them.
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

    /// Sends something by the host link and waits for the answer, hearing what else comes.
    fn converse<T>(
        &mut self,
        send: impl FnOnce(&mut BoardLink<Pipe>, RetryPolicy, Aside) -> Result<T, InstrumentError>,
    ) -> Result<T, InstrumentError> {
        let mut aside = Vec::new();
        // Nothing gets lost on the way to an emulator.
        let once = RetryPolicy { tries: 1, timeout: self.process.timeout };
        let reply = send(&mut self.links.host, once, &mut |message| aside.push(message));
        aside.into_iter().for_each(|message| self.hear(message));
        reply.map_err(|error| self.process.explain(error))
    }

    /// The next message of the host link.
    fn next_message(&mut self) -> Result<FromBoard, InstrumentError> {
        self.process.until_timeout(|timeout| self.links.host.receive(timeout))
    }

    /// Sends what is answered by levels.
    fn answered(&mut self, message: &ToBoard) -> Result<HeaterFrame, InstrumentError> {
        let asked = self.links.bench().send(message)?;
        let answer = loop {
            let message = self.process.until_timeout(|timeout| self.links.bench().receive(timeout))?;
            self.hear(message);
            if let Some(answer) = self.answer.take() {
                break answer;
            }
            self.still_the_same()?;
        };
        if answer.to != asked {
            return Err(InstrumentError::Protocol(format!("exchange {asked} was answered as {}", answer.to)));
        }
        let of_value = Digest::of_value;
        self.digests = RunDigests { control: of_value(answer.digest), wind: of_value(answer.wind_digest) };
        self.input = answer.input;
        Ok(answer)
    }

    /// The sample of the exchange just answered, with its wind: they come by the host link.
    fn sample(&mut self, answer: HeaterFrame) -> Result<TickReport, InstrumentError> {
        loop {
            if self.sample.is_some() && (self.wind.is_some() || !answer.has_wind) {
                let (report, wind) = (self.sample.take(), self.wind.take());
                let is_its = |report: &TickReport| {
                    let of_wind = wind.as_ref().is_none_or(|frame| frame.tick == report.sample.tick);
                    report.sample.heaters == answer.heaters && of_wind
                };
                if let Some(report) = report.clone().filter(is_its) {
                    return Ok(TickReport { wind: wind.map(|frame| frame.wind), ..report });
                }
                let sentence = format!("{answer:?} came with {report:?} and {wind:?}");
                return Err(InstrumentError::Protocol(sentence));
            }
            let message = self.next_message()?;
            self.hear(message);
            self.still_the_same()?;
            self.unattended = 0;
        }
    }

    /// An error if the board has started anew.
    fn still_the_same(&self) -> Result<(), InstrumentError> {
        self.reborn.as_ref().map_or(Ok(()), |reborn| Err(InstrumentError::Restarted(why_it_started(reborn))))
    }

    /// Forgets the life before.
    fn forget(&mut self) {
        (self.answer, self.sample, self.wind, self.status) = (None, None, None, None);
        self.input = FrontEndInput::Element;
        self.findings.clear();
    }

    fn hear(&mut self, message: FromBoard) {
        match message {
            FromBoard::Heaters(answer) => self.answer = Some(answer),
            FromBoard::Sample(_) | FromBoard::Observed(_) => self.sample = TickReport::of(message),
            FromBoard::Wind(frame) => self.wind = Some(frame),
            FromBoard::Status(status) => self.status = Some(status),
            FromBoard::Tested(finding) => self.findings.push(finding),
            // Changes of state are in every sample; the rest answers questions that an exchange
            // does not ask.
            FromBoard::Event(_) | FromBoard::Reply { .. } | FromBoard::Setting(_) => {}
            // A board sends its identity when it starts, and whenever it is requested.
            FromBoard::Identity(identity) => {
                if identity.starts != self.identity.starts {
                    self.reborn = Some(identity);
                }
            }
        }
    }
}

impl SettingsPort for Emulated {
    fn firmware(&self) -> &str {
        &self.identity.firmware
    }

    fn limits(&self) -> &'static HardwareLimits {
        granted_by(self.identity.board)
    }

    fn ask_settings(&mut self, request: &SettingsRequest) -> Result<SettingsReply, InstrumentError> {
        self.converse(|host, once, aside| host.ask(request, once, aside))
    }
}

impl LockStepController for Emulated {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        self.converse(|host, once, aside| host.command(command, once, aside))
    }

    fn exchange(&mut self, readings: &[Reading]) -> Result<TickReport, InstrumentError> {
        let answer = self.exchange_levels(readings)?;
        self.sample(answer).map_err(|error| self.process.explain(error))
    }

    fn input(&self) -> FrontEndInput {
        self.input
    }

    fn findings(&mut self) -> Vec<SelfTestFinding> {
        std::mem::take(&mut self.findings)
    }

    fn digests(&self) -> RunDigests {
        self.digests
    }

    fn finish(mut self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        if self.links.bench.is_some() {
            // Settings that the board has still to write is written when it answers; by one link
            // for all it comes before the end in any case.
            let _ = self.ask_settings(&SettingsRequest::Check);
        }
        // The front end's link: the board looks there whatever it is doing.
        let sent = self.links.bench().send(&ToBoard::Finish { code: 0 });
        sent.map_err(|error| self.process.explain(error))?;
        let log = self.process.wait()?;
        Ok(LinkReport { link: self.links.host.counters(), status: self.status, log })
    }
}
