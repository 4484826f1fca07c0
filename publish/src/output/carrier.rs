//! What carries lines: datagrams, connections that others open, a serial port, requests by HTTP.

use super::PublishError;
use crate::listen::{DatagramSender, Listener, Listening};
use crate::target::{PublishLogin, PublishTarget, PublishWay};
use serialport::SerialPort;
use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// Carries lines.
pub(super) trait Carrier: Send {
    /// Sends a line.
    fn send(&mut self, line: &str) -> Result<(), PublishError>;

    /// What is to be done several times a second; `is_last` for the last time.
    fn turn(&mut self, _is_last: bool) -> Result<(), PublishError> {
        Ok(())
    }
}

/// Opens the way of a target.
pub(super) fn open(target: &PublishTarget, listening: &Listening) -> Result<Box<dyn Carrier>, PublishError> {
    Ok(match &target.way {
        PublishWay::Datagrams(to) => Box::new(DatagramSender::new(resolved(to)?)?),
        PublishWay::Listener(at) => Box::new(Readers { listener: listening.bind(resolved(at)?)?, readers: Vec::new() }),
        PublishWay::Serial { device, baud } => {
            let port = serialport::new(device, *baud).timeout(TIMEOUT).open();
            Box::new(port.map_err(|error| io::Error::other(error.to_string()))?)
        }
        PublishWay::Http(url) => Box::new(Requests::new(url, target)?),
        PublishWay::Connection { host, .. } => return Err(PublishError::Refused(format!("{host} takes no lines"))),
    })
}

/// The address of a host's name.
pub(super) fn resolved(place: &str) -> Result<SocketAddr, PublishError> {
    let found = place.to_socket_addrs()?.next();
    found.ok_or_else(|| PublishError::Refused("the host has no address".to_owned()))
}

/// For a peer that does not answer.
pub(super) const TIMEOUT: Duration = Duration::from_secs(5);

impl Carrier for DatagramSender {
    fn send(&mut self, line: &str) -> Result<(), PublishError> {
        Ok(DatagramSender::send(self, line.as_bytes())?)
    }
}

/// All who connected.
struct Readers {
    listener: Listener,
    readers: Vec<TcpStream>,
}

/// Who connects beyond them is disconnected.
const MOST_READERS: usize = 16;

impl Carrier for Readers {
    /// A reader that has left, or does not take a line at once, is disconnected.
    fn send(&mut self, line: &str) -> Result<(), PublishError> {
        self.readers.retain_mut(|reader| reader.write_all(line.as_bytes()).is_ok());
        Ok(())
    }

    fn turn(&mut self, _is_last: bool) -> Result<(), PublishError> {
        while let Some(reader) = self.listener.accept()? {
            if self.readers.len() < MOST_READERS && reader.set_nonblocking(true).is_ok() {
                reader.set_nodelay(true).ok();
                self.readers.push(reader);
            }
        }
        Ok(())
    }
}

impl Carrier for Box<dyn SerialPort> {
    fn send(&mut self, line: &str) -> Result<(), PublishError> {
        Ok(self.write_all(line.as_bytes())?)
    }
}

/// Lines that wait for the next request.
struct Requests {
    agent: ureq::Agent,
    url: String,
    login: Option<PublishLogin>,
    lines: String,
    since: Instant,
}

/// From one request to the next, unless there is much to send.
const BETWEEN_REQUESTS: Duration = Duration::from_secs(1);
/// Bytes of lines that make a request.
const MUCH: usize = 1 << 18;

impl Requests {
    fn new(url: &str, target: &PublishTarget) -> Result<Self, PublishError> {
        let config = ureq::Agent::config_builder().timeout_global(Some(TIMEOUT)).max_redirects(0);
        #[cfg(feature = "tls")]
        let config = config.tls_config(crate::tls::of_requests(target.ca_file.as_deref())?);
        #[cfg(not(feature = "tls"))]
        if url.starts_with("https:") {
            return Err(PublishError::no_tls());
        }
        Ok(Self {
            agent: config.build().into(),
            url: url.to_owned(),
            login: target.login.clone(),
            lines: String::new(),
            since: Instant::now(),
        })
    }

    fn post(&mut self) -> Result<(), PublishError> {
        let lines = std::mem::take(&mut self.lines);
        self.since = Instant::now();
        let mut request = self.agent.post(&self.url).content_type("text/plain; charset=utf-8");
        if let Some(PublishLogin { user, password }) = &self.login {
            // By header rather than in the address, which proxies write into their logs. A token
            // stands alone.
            let login = if password.is_empty() { user.clone() } else { format!("{user}:{password}") };
            request = request.header("Authorization", format!("Token {login}"));
        }
        match request.send(&lines) {
            Ok(_) => Ok(()),
            Err(ureq::Error::StatusCode(status)) => Err(PublishError::Refused(format!("answers with status {status}"))),
            Err(error) => Err(PublishError::Refused(error.to_string())),
        }
    }
}

impl Carrier for Requests {
    fn send(&mut self, line: &str) -> Result<(), PublishError> {
        self.lines.push_str(line);
        self.turn(false)
    }

    fn turn(&mut self, is_last: bool) -> Result<(), PublishError> {
        let is_due = is_last || self.since.elapsed() >= BETWEEN_REQUESTS || self.lines.len() >= MUCH;
        if is_due && !self.lines.is_empty() { self.post() } else { Ok(()) }
    }
}
