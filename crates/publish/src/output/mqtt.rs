//! MQTT 3.1.1: a client that only publishes, at most once each (QoS 0).
//!
//! `mqttbytes` has the packets; the connection is one blocking stream, since there is nothing to
//! wait for beside it. A client with a runtime of its own would bring 28 packages for that.

use super::text::{TIMEOUT, resolved};
use super::{BrokerStream, Output};
use crate::feed::{FeedEvent, FeedLayout, FeedRow};
use crate::format::FeedColumns;
use crate::format::home_assistant::{self, MqttTopics};
use crate::target::{PublishTarget, PublishWay};
#[cfg(feature = "tls")]
use anyhow::Context;
use anyhow::{anyhow, bail};
use bytes::BytesMut;
use mqttbytes::QoS;
use mqttbytes::v4::{Connect, ConnectReturnCode, Disconnect, LastWill, Login, Packet, PingReq, Publish};
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A broker takes a client for lost after one and a half times this.
const KEEP_ALIVE: Duration = Duration::from_secs(20);
/// The longest packet that a broker sends to somebody who only publishes.
const MOST_RECEIVED: usize = 1_024;

struct MqttOutput {
    stream: Box<dyn BrokerStream>,
    /// Sets how long a read waits.
    socket: TcpStream,
    topics: MqttTopics,
    columns: FeedColumns,
    asked: Instant,
    heard: Instant,
    received: BytesMut,
}

/// Connects, and says who is there.
pub(super) fn open(target: &PublishTarget, layout: &FeedLayout) -> anyhow::Result<Box<dyn Output>> {
    let PublishWay::Connection { host, port, is_encrypted } = &target.way else {
        bail!("MQTT needs a connection");
    };
    let address = resolved(&if host.contains(':') { format!("[{host}]:{port}") } else { format!("{host}:{port}") })?;
    let socket = TcpStream::connect_timeout(&address, TIMEOUT)?;
    socket.set_nodelay(true)?;
    socket.set_read_timeout(Some(TIMEOUT))?;
    socket.set_write_timeout(Some(TIMEOUT))?;
    let stream: Box<dyn BrokerStream> = match is_encrypted {
        false => Box::new(socket.try_clone()?),
        true => encrypted(host, socket.try_clone()?, target)?,
    };
    let (topics, columns) = (MqttTopics::new(&layout.id()), FeedColumns::new(layout));
    let now = Instant::now();
    let mut output = MqttOutput { stream, socket, topics, columns, asked: now, heard: now, received: BytesMut::new() };
    output.connect(target, layout)?;
    Ok(Box::new(output))
}

/// A stream to the broker `host`, whose certificate one of the authorities in `ca_file` has signed,
/// by the feature `tls`: rustls with ring, 23 packages.
#[cfg(feature = "tls")]
fn encrypted(host: &str, socket: TcpStream, target: &PublishTarget) -> anyhow::Result<Box<dyn BrokerStream>> {
    use rustls::pki_types::pem::PemObject;
    use rustls::pki_types::{CertificateDer, ServerName};
    use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
    let ca_file = target.ca_file.as_deref().context("a `ca_file` belongs to it, in a file of addresses")?;
    let in_file = |error: &dyn std::fmt::Display| anyhow!("{}: {error}", ca_file.display());
    let mut roots = RootCertStore::empty();
    for certificate in CertificateDer::pem_file_iter(ca_file).map_err(|error| in_file(&error))? {
        roots.add(certificate.map_err(|error| in_file(&error))?).map_err(|error| in_file(&error))?;
    }
    let name = ServerName::try_from(host.to_owned()).map_err(|error| anyhow!("{host}: {error}"))?;
    let config = ClientConfig::builder().with_root_certificates(roots).with_no_client_auth();
    let connection = ClientConnection::new(Arc::new(config), name)?;
    Ok(Box::new(StreamOwned::new(connection, socket)))
}

#[cfg(not(feature = "tls"))]
fn encrypted(_: &str, _: TcpStream, _: &PublishTarget) -> anyhow::Result<Box<dyn BrokerStream>> {
    bail!("this program was built without the feature `tls`")
}

impl MqttOutput {
    fn connect(&mut self, target: &PublishTarget, layout: &FeedLayout) -> anyhow::Result<()> {
        // It names the process, too: a second one with the same name would throw the first out.
        let mut connect = Connect::new(format!("anemo_{}_{}", layout.id(), std::process::id()));
        connect.keep_alive = KEEP_ALIVE.as_secs() as u16;
        connect.last_will = Some(LastWill::new(&self.topics.status, "offline", QoS::AtMostOnce, true));
        connect.login =
            target.login.as_ref().map(|login| Login { username: login.user.clone(), password: login.password.clone() });
        self.send(|packet| connect.write(packet))?;
        loop {
            match self.packet()? {
                Some(Packet::ConnAck(answer)) if answer.code == ConnectReturnCode::Success => break,
                Some(Packet::ConnAck(answer)) => {
                    let why = match answer.code {
                        ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized => {
                            "user or password are wrong".to_owned()
                        }
                        code => format!("{code:?}"),
                    };
                    bail!("the broker refuses: {why}");
                }
                Some(_) => {}
                None => bail!("the broker does not answer"),
            }
        }
        // From now on reads only see what is there.
        self.socket.set_read_timeout(Some(Duration::from_millis(1)))?;
        let MqttTopics { status, discovery, .. } = self.topics.clone();
        self.publish(&discovery, home_assistant::discovery(layout), true)?;
        self.publish(&status, "online".to_owned(), true)
    }

    fn publish(&mut self, topic: &str, message: String, retain: bool) -> anyhow::Result<()> {
        let mut publish = Publish::new(topic, QoS::AtMostOnce, message);
        publish.retain = retain;
        self.send(|packet| publish.write(packet))
    }

    fn send(&mut self, write: impl FnOnce(&mut BytesMut) -> Result<usize, mqttbytes::Error>) -> anyhow::Result<()> {
        let mut packet = BytesMut::new();
        write(&mut packet).map_err(|error| anyhow!("no message of MQTT: {error}"))?;
        self.stream.write_all(&packet)?;
        Ok(self.stream.flush()?)
    }

    /// The next packet of the broker, if one comes within the time that reads wait.
    fn packet(&mut self) -> anyhow::Result<Option<Packet>> {
        loop {
            match mqttbytes::v4::read(&mut self.received, MOST_RECEIVED) {
                Ok(packet) => return Ok(Some(packet)),
                Err(mqttbytes::Error::InsufficientBytes(_)) => {}
                Err(error) => bail!("this is no broker: {error}"),
            }
            let mut chunk = [0; 256];
            match self.stream.read(&mut chunk) {
                Ok(0) => bail!("the broker closed the connection"),
                Ok(bytes) => {
                    self.received.extend_from_slice(&chunk[..bytes]);
                    self.heard = Instant::now();
                }
                Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
                    return Ok(None);
                }
                Err(error) => return Err(error.into()),
            }
        }
    }
}

impl Output for MqttOutput {
    fn row(&mut self, row: &Arc<FeedRow>) -> anyhow::Result<()> {
        let message = home_assistant::state(&self.columns, row);
        self.publish(&self.topics.state.clone(), message, true)
    }

    fn event(&mut self, event: &FeedEvent) -> anyhow::Result<()> {
        self.publish(&self.topics.event.clone(), home_assistant::event(event), false)
    }

    fn turn(&mut self) -> anyhow::Result<()> {
        while self.packet()?.is_some() {}
        if self.heard.elapsed() > 2 * KEEP_ALIVE {
            bail!("the broker does not answer");
        }
        // Only its answers show that a broker is there, so it is asked even while rows go out.
        if self.asked.elapsed() > KEEP_ALIVE / 2 {
            self.asked = Instant::now();
            self.send(|packet| PingReq.write(packet))?;
        }
        Ok(())
    }

    fn end(&mut self) {
        // A broker that left needs no good-bye: its will does the same.
        let status = self.topics.status.clone();
        self.publish(&status, "offline".to_owned(), true).ok();
        self.send(|packet| Disconnect.write(packet)).ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Anything may answer at a broker's port.
    #[test]
    fn no_bytes_break_the_reader_of_packets() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u8
        };
        for _ in 0..100_000 {
            let mut bytes = BytesMut::new();
            let length = next() % 16;
            // Half of them have a length that fits.
            bytes.extend_from_slice(&[next(), if next() % 2 == 0 { length } else { next() }]);
            bytes.extend((0..length).map(|_| next() % 8));
            while mqttbytes::v4::read(&mut bytes, MOST_RECEIVED).is_ok() {}
        }
    }
}
