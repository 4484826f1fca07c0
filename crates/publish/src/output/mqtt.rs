//! MQTT 3.1.1: a client that only publishes, at most once each (QoS 0).
//!
//! `mqttbytes` has the packets; the connection is one blocking stream, since there is nothing to
//! wait for beside it. A client with a runtime of its own would bring 28 packages for that.

use super::context::{BrokerStream, Output, PublishError};
use super::text::{TIMEOUT, resolved};
use crate::feed::{FeedEvent, FeedLayout, FeedRow};
use crate::format::FeedColumns;
use crate::format::home_assistant::{self, MqttTopics};
use crate::target::{PublishTarget, PublishWay};
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
pub(super) fn open(target: &PublishTarget, layout: &FeedLayout) -> Result<Box<dyn Output>, PublishError> {
    let PublishWay::Connection { host, port, is_encrypted } = &target.way else {
        return Err(PublishError::Refused("MQTT needs a connection".to_owned()));
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

#[cfg(feature = "tls")]
fn encrypted(host: &str, socket: TcpStream, target: &PublishTarget) -> Result<Box<dyn BrokerStream>, PublishError> {
    super::tls::to_broker(host, socket, target.ca_file.as_deref())
}

#[cfg(not(feature = "tls"))]
fn encrypted(_: &str, _: TcpStream, _: &PublishTarget) -> Result<Box<dyn BrokerStream>, PublishError> {
    Err(PublishError::no_tls())
}

impl MqttOutput {
    fn connect(&mut self, target: &PublishTarget, layout: &FeedLayout) -> Result<(), PublishError> {
        // Of the process, too: a second one with the same name would throw the first out.
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
                    return Err(PublishError::Refused(format!("the broker refuses: {why}")));
                }
                Some(_) => {}
                None => return Err(PublishError::Refused("the broker does not answer".to_owned())),
            }
        }
        // From now on reads only see what is there.
        self.socket.set_read_timeout(Some(Duration::from_millis(1)))?;
        let MqttTopics { status, discovery, .. } = self.topics.clone();
        self.publish(&discovery, home_assistant::discovery(layout), true)?;
        self.publish(&status, "online".to_owned(), true)
    }

    fn publish(&mut self, topic: &str, message: String, retain: bool) -> Result<(), PublishError> {
        let mut publish = Publish::new(topic, QoS::AtMostOnce, message);
        publish.retain = retain;
        self.send(|packet| publish.write(packet))
    }

    fn send(
        &mut self,
        write: impl FnOnce(&mut BytesMut) -> Result<usize, mqttbytes::Error>,
    ) -> Result<(), PublishError> {
        let mut packet = BytesMut::new();
        write(&mut packet).map_err(|error| PublishError::Refused(format!("no message of MQTT: {error}")))?;
        self.stream.write_all(&packet)?;
        Ok(self.stream.flush()?)
    }

    /// The next packet of the broker, if one comes within the time that reads wait.
    fn packet(&mut self) -> Result<Option<Packet>, PublishError> {
        loop {
            match mqttbytes::v4::read(&mut self.received, MOST_RECEIVED) {
                Ok(packet) => return Ok(Some(packet)),
                Err(mqttbytes::Error::InsufficientBytes(_)) => {}
                Err(error) => return Err(PublishError::Refused(format!("this is no broker: {error}"))),
            }
            let mut chunk = [0; 256];
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(PublishError::Refused("the broker closed the connection".to_owned())),
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
    fn row(&mut self, row: &Arc<FeedRow>) -> Result<(), PublishError> {
        let message = home_assistant::state(&self.columns, row);
        self.publish(&self.topics.state.clone(), message, true)
    }

    fn event(&mut self, event: &FeedEvent) -> Result<(), PublishError> {
        self.publish(&self.topics.event.clone(), home_assistant::event(event), false)
    }

    fn turn(&mut self) -> Result<(), PublishError> {
        while self.packet()?.is_some() {}
        if self.heard.elapsed() > 2 * KEEP_ALIVE {
            return Err(PublishError::Refused("the broker does not answer".to_owned()));
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

    /// What answers at a broker's port may be anything.
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
