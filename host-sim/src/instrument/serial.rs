//! The sensor board at a serial port: real sensor, real time.

use super::link::{Link, Stream};
use super::{Account, Instrument, InstrumentError, Observation};
use dr_core::control::{Command, Reply};
use serialport::{SerialPort, TTYPort};
use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::time::Duration;
use wire::{FromBoard, Identity, Sample, Status, ToBoard};

/// Baud of the host link.
pub const BAUD: u32 = 921_600;

/// A tick lasts 10 s at the most; a board that says nothing for longer is gone.
const SAMPLE_PATIENCE: Duration = Duration::from_secs(12);

/// A port, as a stream.
pub struct Port(TTYPort);

impl Stream for Port {
    fn read_within(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.0.set_timeout(patience)?;
        self.0.read(buffer)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }
}

/// A board at a port.
pub struct Serial {
    link: Link<Port>,
    identity: Identity,
    samples: VecDeque<Sample>,
    status: Option<Status>,
}

impl Serial {
    /// Opens a port and asks who is there.
    ///
    /// # Errors
    /// If the port cannot be opened, or nobody answers that speaks our version.
    pub fn open(device: &str) -> Result<Self, InstrumentError> {
        let port = TTYPort::open(&serialport::new(device, BAUD)).map_err(|error| InstrumentError::Port {
            device: device.to_owned(),
            reason: error.to_string(),
            ports: known_ports(),
        })?;
        let mut link = Link::new(Port(port));
        // Ends whatever the board may have taken for the beginning of a frame.
        link.stream_mut().write_all(&[0])?;
        let identity = link.hello(Duration::from_secs(3))?;
        link.send(&ToBoard::Telemetry { every: 1 })?;
        Ok(Self { link, identity, samples: VecDeque::new(), status: None })
    }

    fn sort(message: FromBoard, samples: &mut VecDeque<Sample>, status: &mut Option<Status>) {
        match message {
            FromBoard::Sample(sample) => samples.push_back(sample),
            FromBoard::Status(its) => *status = Some(its),
            // Changes of state are in every sample.
            FromBoard::Identity(_) | FromBoard::Reply { .. } | FromBoard::Event(_) | FromBoard::Heaters(_) => {}
        }
    }
}

impl Instrument for Serial {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        let Self { link, samples, status, .. } = self;
        let reply = link.command(command, &mut |message| Self::sort(message, samples, status))?;
        if command == Command::Start {
            // What came before the reply belongs to the standby before the run.
            samples.clear();
        }
        Ok(reply)
    }

    fn observe(&mut self) -> Result<Observation, InstrumentError> {
        loop {
            if let Some(sample) = self.samples.pop_front() {
                return Ok(Observation { sample, wind_m_s: None, extrapolated: false });
            }
            let message = self.link.receive(SAMPLE_PATIENCE)?;
            Self::sort(message, &mut self.samples, &mut self.status);
        }
    }

    fn digest(&self) -> Option<u64> {
        None
    }

    fn finish(mut self: Box<Self>) -> Result<Account, InstrumentError> {
        match self.command(Command::Stop) {
            // A tripped board has its heaters low already, and stays tripped until somebody has looked.
            Ok(_) | Err(InstrumentError::Refused(_)) => {}
            Err(error) => return Err(error),
        }
        // One more second brings the status of the end.
        while self.status.is_none() {
            let message = self.link.receive(Duration::from_secs(2))?;
            Self::sort(message, &mut self.samples, &mut self.status);
        }
        Ok(Account { link: self.link.counters(), status: self.status, log: Vec::new() })
    }
}

fn known_ports() -> String {
    match serialport::available_ports() {
        Ok(ports) if !ports.is_empty() => {
            let names: Vec<String> = ports.into_iter().map(|port| port.port_name).collect();
            format!("there are {}", names.join(", "))
        }
        _ => "this machine has no serial port".to_owned(),
    }
}
