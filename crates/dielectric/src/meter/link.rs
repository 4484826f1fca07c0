//! Lines to a meter and lines back, none of them waited for beyond the time-out.
//! An address is `HOST` or `HOST:PORT`. Answers become numbers, switches and capacitances.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use super::error::MeterError;

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
        let (stream, at) = dialled(address, timeout)?;
        let ready = ready(&stream, timeout);
        ready.map_err(|source| MeterError::unreachable(address, &source))?;
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
        self.stream = anew().map_err(|source: io::Error| MeterError::unreachable(&self.at.to_string(), &source))?;
        self.received.clear();
        Ok(())
    }

    /// Sends a command that has no answer.
    pub(super) fn send(&mut self, command: &str) -> Result<(), MeterError> {
        let sent = self.stream.write_all(format!("{command}\n").as_bytes());
        sent.map_err(|source| self.broken(command, &source))
    }

    /// Sends a command, and reads whether the meter refuses it.
    pub(super) fn command(&mut self, command: &str) -> Result<(), MeterError> {
        self.send(command)?;
        match self.next_error()? {
            None => Ok(()),
            Some(reason) => Err(MeterError::Other(format!("the meter refuses {command}: {reason}"))),
        }
    }

    /// Takes the oldest error from the meter's queue.
    pub(super) fn next_error(&mut self) -> Result<Option<String>, MeterError> {
        queued_error(NEXT_ERROR, &self.query(NEXT_ERROR)?)
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
                    return Err(MeterError::garbled(&command, &answer));
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
                return Err(MeterError::garbled(command, &self.take_received()));
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(self.silent(command));
            }
            let mut buffer = [0; 512];
            let read = self.stream.set_read_timeout(Some(left)).and_then(|()| self.stream.read(&mut buffer));
            match read {
                Ok(0) => return Err(self.broken(command, &io::Error::new(ErrorKind::UnexpectedEof, "it was closed"))),
                Ok(read) => self.received.extend_from_slice(&buffer[..read]),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                // A signal, such as Ctrl-C: the caller looks after it.
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.broken(command, &error)),
            }
        }
    }

    fn silent(&mut self, command: &str) -> MeterError {
        let (answer, timeout_s) = (self.take_received(), self.timeout.as_secs_f64());
        if answer.is_empty() {
            return MeterError::Silent { command: command.to_owned(), timeout_s };
        }
        MeterError::cut_short(command, &answer)
    }

    fn broken(&mut self, command: &str, source: &io::Error) -> MeterError {
        let answer = self.take_received();
        if answer.is_empty() {
            return MeterError::Other(format!("the connection to the meter broke at {command}: {source}"));
        }
        MeterError::cut_short(command, &answer)
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

/// Where instruments listen for SCPI.
const PORT: u16 = 5025;

/// Connects to a name, an IPv4 or an IPv6 address, with or without a port; an IPv6 address with a
/// port is in brackets. The time-out is that of each address of a name; looking the name up takes
/// as long as the system lets it.
fn dialled(address: &str, timeout: Duration) -> Result<(TcpStream, SocketAddr), MeterError> {
    let unreachable = |source| MeterError::unreachable(address, &source);
    let (host, port) = split(address)?;
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for at in (host, port).to_socket_addrs().map_err(unreachable)? {
        match TcpStream::connect_timeout(&at, timeout) {
            Ok(stream) => return Ok((stream, at)),
            Err(error) => last = error,
        }
    }
    Err(unreachable(last))
}

fn split(address: &str) -> Result<(&str, u16), MeterError> {
    let (host, port) = match address.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((host, "")) => (host, None),
        Some((host, rest)) => (host, Some(rest.strip_prefix(':').unwrap_or(rest))),
        // More than one colon is an IPv6 address without a port.
        None => match address.split_once(':') {
            Some((host, port)) if !port.contains(':') => (host, Some(port)),
            _ => (address, None),
        },
    };
    let port = match port {
        None => Ok(PORT),
        Some(port) => port.parse(),
    };
    match port {
        Ok(port) if !host.is_empty() && !host.contains(['[', ']']) => Ok((host, port)),
        _ => {
            let needed = format!("HOST or HOST:PORT is needed, as 192.168.0.7 or [fe80::7]:{PORT}");
            Err(MeterError::Other(format!("{address:?} is no address of a meter: {needed}")))
        }
    }
}

/// Value in place of a number, if there is none.
const NO_NUMBER: f64 = 9.9e37;

/// A number.
pub(super) fn number(command: &str, answer: &str) -> Result<f64, MeterError> {
    let number = answer.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| MeterError::garbled(command, answer))
}

/// Tells whether a switch is on.
pub(super) fn switch(command: &str, answer: &str) -> Result<bool, MeterError> {
    match answer.trim().trim_start_matches('+') {
        "0" => Ok(false),
        "1" => Ok(true),
        _ => Err(MeterError::garbled(command, answer)),
    }
}

/// Capacitance of `<C>,<D>,<status>[,<bin>]` in F; none at a status other than 0.
pub(super) fn capacitance_f(command: &str, answer: &str) -> Result<Option<f64>, MeterError> {
    let fields: Vec<&str> = answer.split(',').collect();
    let [capacitance, loss, status, ..] = fields[..] else {
        return Err(MeterError::cut_short(command, answer));
    };
    // An answer is whole or it is nothing: D is not needed, but it has to be there.
    number(command, loss)?;
    let (capacitance_f, status) = (number(command, capacitance)?, number(command, status)?);
    Ok((status == 0.0 && capacitance_f.abs() < NO_NUMBER).then_some(capacitance_f))
}

/// An entry of the queue of errors; none if the queue is empty.
pub(super) fn queued_error(command: &str, answer: &str) -> Result<Option<String>, MeterError> {
    let (code, _) = answer.split_once(',').unwrap_or((answer, ""));
    Ok((number(command, code)? != 0.0).then(|| answer.to_owned()))
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

#[cfg(test)]
mod address_tests {
    use super::*;

    #[test]
    fn names_and_addresses_come_with_a_port_or_without() {
        for (address, expected) in [
            ("meter", ("meter", 5025)),
            ("meter.example.org:7", ("meter.example.org", 7)),
            ("10.0.0.1:65535", ("10.0.0.1", 65535)),
            ("::1", ("::1", 5025)),
            ("[::1]", ("::1", 5025)),
            ("[fe80::7]:80", ("fe80::7", 80)),
        ] {
            assert_eq!(split(address).expect(address), expected);
        }
        for wrong in ["", ":5025", "meter:", "meter:x", "meter:70000", "[::1", "[::1]5025x", "[]:5025"] {
            let sentence = split(wrong).expect_err(wrong).to_string();
            assert!(sentence.contains("HOST:PORT is needed"), "{sentence}");
        }
    }
}

#[cfg(test)]
mod answer_tests {
    use super::*;

    #[test]
    fn a_reading_is_there_or_missing_or_garbled() {
        let read = |answer| capacitance_f(":FETC?", answer);
        assert_eq!(read("+1.234567890E-12,+1.0E-03,+0").expect("a reading"), Some(1.23456789e-12));
        assert_eq!(read("-1.2E-15,-1.0E-03,+0,+1").expect("a bin behind it"), Some(-1.2e-15));
        for missing in ["+9.9E+37,+9.9E+37,+1", "+9.9E+37,+9.9E+37,+0", "+1E-12,+1E-3,+3", "+1E-12,+1E-3,-1"] {
            assert_eq!(read(missing).expect("an answer"), None, "{missing}");
        }
        let refused = |answer| read(answer).expect_err(answer).to_string();
        assert_eq!(refused("+1.2E-12,+1"), "the meter's answer to :FETC? is cut short: \"+1.2E-12,+1\"");
        for garbled in ["x,+1E-3,+0", "+1E-12,,+0", "+1E-12,+1E-3,", "nan,+1E-3,+0", "+1E-12,inf,+0", "1,2,3x"] {
            assert!(refused(garbled).starts_with("the meter's answer to :FETC? makes no sense: "), "{garbled}");
        }
    }

    #[test]
    fn an_empty_queue_is_no_error() {
        assert_eq!(queued_error("", "+0,\"No error\"").expect("an answer"), None);
        assert_eq!(queued_error("", "-222,\"x\"").expect("an answer").as_deref(), Some("-222,\"x\""));
        assert!(queued_error("", "#!").is_err());
    }
}
