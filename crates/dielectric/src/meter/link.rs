//! Lines to a meter and lines back, none of them waited for beyond the time-out.

use super::address;
use super::answer;
use super::error::MeterError;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

/// A longer answer is none.
const LONGEST_ANSWER: usize = 4_096;

const NEXT_ERROR: &str = ":SYST:ERR?";
const IDENTITY: &str = "*IDN?";

pub(super) struct MeterLink {
    stream: TcpStream,
    /// The address that answered, for a second connection.
    at: SocketAddr,
    timeout: Duration,
    received: Vec<u8>,
}

impl MeterLink {
    pub(super) fn connect(address: &str, timeout: Duration) -> Result<Self, MeterError> {
        let (stream, at) = address::connect(address, timeout)?;
        let ready = ready(&stream, timeout);
        ready.map_err(|source| MeterError::Unreachable { address: address.to_owned(), source })?;
        Ok(Self { stream, at, timeout, received: Vec::new() })
    }

    /// Gives the connection up for a new one.
    pub(super) fn reconnect(&mut self) -> Result<(), MeterError> {
        // A meter that takes one connection only has to notice that this one is over.
        self.stream.shutdown(std::net::Shutdown::Both).ok();
        let anew = || {
            let stream = TcpStream::connect_timeout(&self.at, self.timeout)?;
            ready(&stream, self.timeout)?;
            Ok(stream)
        };
        let unreachable = |source| MeterError::Unreachable { address: self.at.to_string(), source };
        self.stream = anew().map_err(unreachable)?;
        self.received.clear();
        Ok(())
    }

    /// Sends a command that has no answer.
    pub(super) fn send(&mut self, command: &str) -> Result<(), MeterError> {
        let sent = self.stream.write_all(format!("{command}\n").as_bytes());
        sent.map_err(|source| self.broken(command, source))
    }

    /// Sends a command, and reads whether the meter refuses it.
    pub(super) fn command(&mut self, command: &str) -> Result<(), MeterError> {
        self.send(command)?;
        match self.next_error()? {
            None => Ok(()),
            Some(reason) => Err(MeterError::Refused { command: command.to_owned(), reason }),
        }
    }

    /// Takes the oldest error from the meter's queue.
    pub(super) fn next_error(&mut self) -> Result<Option<String>, MeterError> {
        answer::queued_error(NEXT_ERROR, &self.query(NEXT_ERROR)?)
    }

    /// Sends a command, and reads its answer of one line.
    pub(super) fn query(&mut self, command: &str) -> Result<String, MeterError> {
        self.send(command)?;
        self.line(command, Instant::now() + self.timeout)
    }

    pub(super) fn identity(&mut self) -> Result<String, MeterError> {
        self.query(IDENTITY)
    }

    /// Drops whatever comes before the next answer: asks for the identity, which no other answer
    /// resembles, and reads until it is there.
    pub(super) fn resynchronise(&mut self, identity: &str) -> Result<(), MeterError> {
        self.send(IDENTITY)?;
        let deadline = Instant::now() + self.timeout;
        let mut dropped = None;
        loop {
            match (self.line(IDENTITY, deadline), dropped) {
                // Half an answer may stand before it.
                (Ok(line), _) if line.ends_with(identity) => return Ok(()),
                (Ok(line), _) => dropped = Some(line),
                // It is not silent: it talks, and not of itself.
                (Err(MeterError::Silent { command, .. }), Some(answer)) => {
                    return Err(MeterError::Garbled { command, answer });
                }
                (Err(error), _) => return Err(error),
            }
        }
    }

    fn line(&mut self, command: &str, deadline: Instant) -> Result<String, MeterError> {
        loop {
            if let Some(end) = self.received.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.received.drain(..=end).collect();
                return Ok(String::from_utf8_lossy(&line).trim().to_owned());
            }
            if self.received.len() > LONGEST_ANSWER {
                return Err(self.garbled(command));
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(self.silent(command));
            }
            let mut buffer = [0; 512];
            let read = self.stream.set_read_timeout(Some(left)).and_then(|()| self.stream.read(&mut buffer));
            match read {
                Ok(0) => return Err(self.broken(command, io::Error::new(ErrorKind::UnexpectedEof, "it was closed"))),
                Ok(read) => self.received.extend_from_slice(&buffer[..read]),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                // A signal, such as Ctrl-C: the caller looks after it.
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.broken(command, error)),
            }
        }
    }

    fn silent(&mut self, command: &str) -> MeterError {
        let command = command.to_owned();
        match self.take_received() {
            answer if answer.is_empty() => MeterError::Silent { command, timeout_s: self.timeout.as_secs_f64() },
            answer => MeterError::CutShort { command, answer },
        }
    }

    fn garbled(&mut self, command: &str) -> MeterError {
        MeterError::Garbled { command: command.to_owned(), answer: self.take_received() }
    }

    fn broken(&mut self, command: &str, source: io::Error) -> MeterError {
        let command = command.to_owned();
        match self.take_received() {
            answer if answer.is_empty() => MeterError::Broken { command, source },
            answer => MeterError::CutShort { command, answer },
        }
    }

    fn take_received(&mut self) -> String {
        let received = std::mem::take(&mut self.received);
        let shown = &received[..received.len().min(80)];
        String::from_utf8_lossy(shown).trim().to_owned()
    }
}

fn ready(stream: &TcpStream, timeout: Duration) -> io::Result<()> {
    // A command is shorter than a packet, and waits for no other.
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(timeout))
}

#[cfg(test)]
mod tests {
    use super::*;
    use publish::listen::{Listening, Token};

    #[test]
    fn a_flood_is_given_up_in_time() {
        let listening = Listening::new(None, Token::random().expect("random numbers"));
        let listener = listening.bind(([127, 0, 0, 1], 0).into()).expect("the loopback");
        let mut link =
            MeterLink::connect(&listener.address().to_string(), Duration::from_millis(100)).expect("a connection");
        let mut there = loop {
            if let Some(stream) = listener.accept().expect("a listener") {
                break stream;
            }
        };
        let flood = std::thread::spawn(move || while there.write_all(b"1\n22\n").is_ok() {});
        let sentence = link.resynchronise("Keysight").expect_err("a flood").to_string();
        // Where it is given up depends on where the line ends then.
        assert!(sentence.starts_with("the meter's answer to *IDN? "), "{sentence}");
        drop(link);
        flood.join().expect("it ends with the connection");
    }
}
