//! Outputs of lines: a format, and what carries it: datagrams, connections that others open, a
//! serial port.

use super::{Output, PublishContext};
use crate::feed::FeedRow;
use crate::format;
use crate::listen::{DatagramSender, Listener, Listening};
use crate::target::{PublishFormat, PublishTarget, PublishWay};
use anyhow::{Context, bail};
use serialport::SerialPort;
use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::time::Duration;

struct TextOutput {
    format: PublishFormat,
    carrier: Box<dyn Carrier>,
}

/// Opens the way.
pub(super) fn open(target: &PublishTarget, context: &PublishContext) -> anyhow::Result<Box<dyn Output>> {
    let carrier = carrier_of(target, &context.listening)?;
    Ok(Box::new(TextOutput { format: target.format, carrier }))
}

impl Output for TextOutput {
    fn row(&mut self, row: &Arc<FeedRow>) -> anyhow::Result<()> {
        let line = match (self.format, &row.wind) {
            (PublishFormat::Nmea, Some(wind)) => format::mwv(wind),
            (PublishFormat::GillPolar, Some(wind)) => format::polar(wind),
            (PublishFormat::GillUv, Some(wind)) => format::uv(wind),
            _ => return Ok(()),
        };
        self.carrier.send(&line)
    }

    fn turn(&mut self) -> anyhow::Result<()> {
        self.carrier.turn()
    }
}

/// Carries lines.
trait Carrier: Send {
    /// Sends a line.
    fn send(&mut self, line: &str) -> anyhow::Result<()>;

    /// Work to be done several times a second.
    fn turn(&mut self) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Opens the way of a target.
fn carrier_of(target: &PublishTarget, listening: &Listening) -> anyhow::Result<Box<dyn Carrier>> {
    Ok(match &target.way {
        PublishWay::Datagrams(to) => Box::new(DatagramSender::new(resolved(to)?)?),
        PublishWay::Listener(at) => Box::new(Readers { listener: listening.bind(resolved(at)?)?, readers: Vec::new() }),
        PublishWay::Serial { device, baud } => {
            let port = serialport::new(device, *baud).timeout(TIMEOUT).open();
            Box::new(port.map_err(|error| io::Error::other(error.to_string()))?)
        }
        PublishWay::Connection { host, .. } => bail!("{host} takes no lines"),
    })
}

/// The address of a host's name.
pub(super) fn resolved(place: &str) -> anyhow::Result<SocketAddr> {
    let found = place.to_socket_addrs()?.next();
    found.context("the host has no address")
}

/// For a peer that does not answer.
pub(super) const TIMEOUT: Duration = Duration::from_secs(5);

impl Carrier for DatagramSender {
    fn send(&mut self, line: &str) -> anyhow::Result<()> {
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
    fn send(&mut self, line: &str) -> anyhow::Result<()> {
        self.readers.retain_mut(|reader| reader.write_all(line.as_bytes()).is_ok());
        Ok(())
    }

    fn turn(&mut self) -> anyhow::Result<()> {
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
    fn send(&mut self, line: &str) -> anyhow::Result<()> {
        Ok(self.write_all(line.as_bytes())?)
    }
}
