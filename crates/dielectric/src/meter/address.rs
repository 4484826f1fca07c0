//! From `HOST` or `HOST:PORT` to a connection.

use super::error::MeterError;
use std::io;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::Duration;

/// Where instruments listen for SCPI.
const PORT: u16 = 5025;

/// Connects to a name, an IPv4 or an IPv6 address, with or without a port; an IPv6 address with a
/// port is in brackets. The time-out is that of each address of a name; looking the name up takes
/// as long as the system lets it.
pub(super) fn connect(address: &str, timeout: Duration) -> Result<(TcpStream, SocketAddr), MeterError> {
    let unreachable = |source| MeterError::Unreachable { address: address.to_owned(), source };
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
            Err(MeterError::Unusable(format!("{address:?} is no address of a meter: {needed}")))
        }
    }
}

#[cfg(test)]
mod tests {
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
