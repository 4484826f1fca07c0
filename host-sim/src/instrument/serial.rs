//! The sensor board at a serial port: real sensor, real time.
//!
//! Its timeouts are in the time of the stream, which for a port is that of this computer.
//!
//! A cable loses and garbles, so commands are repeated until they are answered (see
//! [`BoardLink::command`]), and samples are taken by their ticks: what is missing shows as a gap. A
//! board that falls silent, starts anew or is unplugged ends the run with an error.

use super::error::InstrumentError;
use super::link::{BoardLink, BoardStream, RetryPolicy};
use super::observation::{LinkReport, Observation, TickReport};
use super::port::{InstrumentPort, SettingsPort, granted_by};
use super::status::{BoardStatus, why_it_started};
use dr_core::control::{HardwareLimits, Refusal, RunState, SelfTestFinding};
use dr_core::wind::WindCommand;
use dr_core::{Command, Reply, RunDigests};
use serialport::{SerialPort, TTYPort};
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::time::Duration;
use wire::{FromBoard, Identity, SettingsReply, SettingsRequest, Status, ToBoard, WindFrame};

/// Baud of the host link.
pub const BAUD: u32 = 921_600;

/// A board that starts up answers within a second.
const HELLO_TIMEOUT: Duration = Duration::from_secs(3);

/// A command is answered within milliseconds: whoever waits for a second has lost something.
const RETRIES: RetryPolicy = RetryPolicy { tries: 3, timeout: Duration::from_secs(1) };

/// A request about settings may have to wait for a sector to be erased, or for a head to be set up.
const SETTINGS_RETRIES: RetryPolicy = RetryPolicy { tries: 3, timeout: Duration::from_secs(3) };

/// A board that sends nothing for so long, and for a few ticks, is gone: it sends its status each
/// second.
const SILENCE: Duration = Duration::from_secs(3);
const SILENT_TICKS: f32 = 3.0;

/// Ticks behind a sample after which its estimate has got lost: as many as may wait for theirs on
/// the board.
const MOST_TICKS_BEHIND: u32 = 8;

/// Time that the status of the end may take, which comes each second.
const STATUS_TIMEOUT: Duration = Duration::from_millis(1500);

/// Time that the system may take to accept a frame.
const WRITE_TIMEOUT: Duration = Duration::from_secs(1);

fn gone(error: io::Error) -> io::Error {
    match error.kind() {
        ErrorKind::TimedOut | ErrorKind::Interrupted => error,
        kind => io::Error::new(kind, format!("{error}; has it been unplugged?")),
    }
}

impl BoardStream for TTYPort {
    fn read_within(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        self.set_timeout(timeout)?;
        match self.read(buffer).map_err(gone)? {
            0 => Err(gone(io::Error::new(ErrorKind::UnexpectedEof, "end of file"))),
            read => Ok(read),
        }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.set_timeout(WRITE_TIMEOUT)?;
        Write::write_all(self, bytes).map_err(gone)
    }
}

/// Messages that the board has sent by itself.
#[derive(Default)]
struct Heard {
    samples: VecDeque<TickReport>,
    /// Estimates are due at multiples of so many ticks; none of a head without a calibration.
    interval_ticks: Option<u16>,
    status: Option<Status>,
    findings: Vec<SelfTestFinding>,
    /// Start of the life in which the conversation began.
    starts: Option<u32>,
    restarted: bool,
}

impl Heard {
    fn take(&mut self, message: FromBoard) {
        match message {
            FromBoard::Sample(_) | FromBoard::Observed(_) => self.samples.extend(TickReport::of(message)),
            FromBoard::Wind(WindFrame { tick, interval_ticks, wind }) => {
                self.interval_ticks = Some(interval_ticks);
                if let Some(report) = self.samples.iter_mut().find(|report| report.sample.tick == tick) {
                    report.wind = Some(wind);
                }
            }
            FromBoard::Status(status) => {
                self.restarted |= self.status.as_ref().is_some_and(|before| status.uptime_s <= before.uptime_s);
                self.status = Some(status);
            }
            FromBoard::Tested(finding) => self.findings.push(finding),
            // Changes of state are in every sample; a reply that comes now is the second to a
            // repeated command. A board sends its identity when it starts, and whenever it is
            // requested.
            FromBoard::Identity(identity) => {
                self.restarted |= self.starts.is_some_and(|starts| starts != identity.starts)
            }
            FromBoard::Reply { .. } | FromBoard::Setting(_) | FromBoard::Event(_) | FromBoard::Heaters(_) => {}
        }
    }

    /// The next sample, once its estimate has come, or would have.
    fn next(&mut self) -> Option<TickReport> {
        let first = self.samples.front()?;
        let (tick, interval_ticks) = (first.sample.tick, u32::from(self.interval_ticks.unwrap_or(0)));
        let is_due = interval_ticks > 0 && tick.is_multiple_of(interval_ticks) && first.wind.is_none();
        let has_passed =
            |later: &TickReport| later.wind.is_some() || later.sample.tick >= tick.saturating_add(MOST_TICKS_BEHIND);
        if is_due && !self.samples.iter().any(has_passed) {
            return None;
        }
        self.samples.pop_front()
    }

    /// Drops what belongs to the standby before a run.
    fn begin(&mut self, reply: Reply) {
        let standby = match reply {
            // A board answers before it sends the first sample of the run.
            Reply::Started { .. } => self.samples.len(),
            // The answer got lost, and the run has begun meanwhile.
            Reply::Done => self
                .samples
                .iter()
                .rposition(|report| report.sample.state == RunState::Standby)
                .map_or(0, |last| last + 1),
        };
        self.samples.drain(..standby);
    }
}

/// A board at a port, or at the end of another stream.
pub struct Serial<S = TTYPort> {
    link: BoardLink<S>,
    identity: Identity,
    heard: Heard,
    silence: Duration,
}

impl Serial {
    /// Opens a port and asks who is there.
    ///
    /// # Errors
    /// If the port cannot be opened, or no board of our version answers.
    pub fn open(device: &str) -> Result<Self, InstrumentError> {
        let port = TTYPort::open(&serialport::new(device, BAUD)).map_err(|error| {
            InstrumentError::Unusable(format!("the port {device} cannot be opened: {error}; {}", known_ports()))
        })?;
        Self::over(port)
    }
}

impl<S: BoardStream> Serial<S> {
    /// Asks who is at the end of a stream.
    ///
    /// # Errors
    /// If no board of our version answers.
    pub fn over(stream: S) -> Result<Self, InstrumentError> {
        let mut link = BoardLink::new(stream);
        // Ends whatever the board may have taken for the beginning of a frame.
        link.stream_mut().write_all(&[0])?;
        let identity = link.hello(HELLO_TIMEOUT)?;
        let heard = Heard { starts: Some(identity.starts), ..Heard::default() };
        Ok(Self { link, identity, heard, silence: SILENCE })
    }

    /// The next status of the board, which comes each second; whatever it does, it goes on with it.
    ///
    /// # Errors
    /// If none comes.
    pub fn status(&mut self) -> Result<BoardStatus, InstrumentError> {
        self.await_status()?;
        let status = self.heard.status.as_ref().ok_or(InstrumentError::Silent(STATUS_TIMEOUT))?;
        Ok(BoardStatus::of(&self.identity, status))
    }

    fn await_status(&mut self) -> Result<(), InstrumentError> {
        let before = self.heard.status.clone();
        let deadline = self.link.now() + STATUS_TIMEOUT;
        while self.heard.status == before && self.link.now() < deadline {
            match self.link.receive(deadline.saturating_sub(self.link.now())) {
                Ok(message) => self.heard.take(message),
                Err(InstrumentError::Silent(_)) => break,
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

impl<S: BoardStream> InstrumentPort for Serial<S> {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        let Self { link, heard, .. } = self;
        if matches!(command, Command::Start | Command::SelfTest(_)) {
            // Another host may have asked for fewer.
            link.send(&ToBoard::Telemetry { every: 1 })?;
        }
        let reply = link.command(command, RETRIES, &mut |message| heard.take(message))?;
        match command {
            Command::Start => heard.begin(reply),
            Command::Clear => heard.interval_ticks = None,
            Command::Wind(WindCommand::Output(output)) => heard.interval_ticks = Some(output.output_interval_ticks),
            Command::SamplePeriod { sample_period_s } => {
                heard.interval_ticks = None;
                self.silence = SILENCE.max(Duration::from_secs_f32(SILENT_TICKS * sample_period_s));
            }
            _ => {}
        }
        Ok(reply)
    }

    fn observe(&mut self) -> Result<Observation, InstrumentError> {
        let deadline = self.link.now() + self.silence;
        self.link.keep_alive()?;
        loop {
            if let Some(TickReport { sample, equivalent_power_w, wind }) = self.heard.next() {
                return Ok(Observation {
                    sample,
                    equivalent_power_w,
                    wind,
                    true_wind_m_s: self.link.stream_mut().true_wind_m_s(),
                    gas_temperature_c: None,
                    extrapolated: false,
                });
            }
            if self.heard.restarted {
                let identity = self.link.hello(HELLO_TIMEOUT)?;
                return Err(InstrumentError::Restarted(why_it_started(&identity)));
            }
            if self.link.now() >= deadline {
                // It may still send its status.
                return Err(InstrumentError::Silent(self.silence));
            }
            let message = self.link.receive(self.silence)?;
            self.heard.take(message);
        }
    }

    fn findings(&mut self) -> Vec<SelfTestFinding> {
        std::mem::take(&mut self.heard.findings)
    }

    fn digests(&self) -> Option<RunDigests> {
        None
    }

    fn finish(mut self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        match self.command(Command::Stop) {
            // A tripped board has its heaters low already, and stays tripped until somebody has
            // looked.
            Ok(_) | Err(InstrumentError::Refused(Refusal::Tripped(_))) => {}
            Err(error) => return Err(error),
        }
        // The status of the end counts everything; should it get lost, the one before will do.
        self.await_status()?;
        Ok(LinkReport { link: self.link.counters(), status: self.heard.status, log: Vec::new() })
    }
}

impl<S: BoardStream> SettingsPort for Serial<S> {
    fn firmware(&self) -> &str {
        &self.identity.firmware
    }

    fn limits(&self) -> &'static HardwareLimits {
        granted_by(self.identity.board)
    }

    fn ask_settings(&mut self, request: &SettingsRequest) -> Result<SettingsReply, InstrumentError> {
        let Self { link, heard, .. } = self;
        link.ask(request, SETTINGS_RETRIES, &mut |message| heard.take(message))
    }
}

fn known_ports() -> String {
    match serialport::available_ports() {
        Ok(ports) if !ports.is_empty() => {
            let names: Vec<String> = ports.into_iter().map(|port| port.port_name).collect();
            format!("there are {}", names.join(", "))
        }
        _ => "this computer has no serial port".to_owned(),
    }
}
