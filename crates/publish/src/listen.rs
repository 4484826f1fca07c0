//! The only place that opens sockets which others can reach (docs/explanation/safety.md, S-21).
//!
//! Any page in a browser reaches the loopback, and a form of it can carry any text to any port.
//! So loopback alone protects nothing that can command:
//!
//! - a listener binds to the loopback, or to the one address that `--listen` names;
//! - who can command knows a [`Token`];
//! - what speaks HTTP checks Host and Origin ([`check_http`]), against pages of other sites and
//!   names that are made to point here.

use std::net::{IpAddr, Ipv6Addr, SocketAddr, TcpStream};
use std::{fmt, io};
// The types that clippy.toml disallows everywhere else.
#[allow(clippy::disallowed_types)]
use std::net::{TcpListener, UdpSocket};

/// Addresses that listeners may bind to, and what commands need.
#[derive(Debug, Clone)]
pub struct Listening {
    /// The address of `--listen`.
    beyond: Option<IpAddr>,
    token: Token,
}

/// Why a listener did not open.
#[derive(Debug, thiserror::Error)]
pub enum ListenError {
    /// Nobody said that others may reach it.
    #[error("{0} can be reached by other machines: `--listen {ip}` allows it", ip = .0.ip())]
    NotAllowed(SocketAddr),
    /// The system refuses.
    #[error("cannot listen on {address}: {source}")]
    Bind {
        /// Where.
        address: SocketAddr,
        /// Why.
        source: io::Error,
    },
}

impl Listening {
    /// Listeners on the loopback, and on `beyond` if it is given.
    pub fn new(beyond: Option<IpAddr>, token: Token) -> Self {
        Self { beyond, token }
    }

    /// Token that a listener wants before it obeys.
    pub fn token(&self) -> &Token {
        &self.token
    }

    /// Opens a listener; port 0 lets the system choose.
    ///
    /// # Errors
    /// If the address is neither the loopback nor the one of `--listen`, or the system refuses.
    #[allow(clippy::disallowed_types)]
    pub fn bind(&self, address: SocketAddr) -> Result<Listener, ListenError> {
        if !address.ip().is_loopback() && self.beyond != Some(address.ip()) {
            return Err(ListenError::NotAllowed(address));
        }
        let bind = || {
            let listener = TcpListener::bind(address)?;
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok(Listener { listener, address })
        };
        bind().map_err(|source| ListenError::Bind { address, source })
    }
}

/// A listener that is asked for connections.
#[derive(Debug)]
pub struct Listener {
    #[allow(clippy::disallowed_types)]
    listener: TcpListener,
    address: SocketAddr,
}

impl Listener {
    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A connection that waits, if there is one. Its stream blocks.
    ///
    /// # Errors
    /// Those of the system.
    pub fn accept(&self) -> io::Result<Option<TcpStream>> {
        match self.listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false)?;
                Ok(Some(stream))
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }
}

/// Sends datagrams to one address and receives none.
#[derive(Debug)]
pub struct DatagramSender {
    #[allow(clippy::disallowed_types)]
    socket: UdpSocket,
    to: SocketAddr,
}

impl DatagramSender {
    /// From a port that the system chooses; from the loopback if it sends there.
    ///
    /// # Errors
    /// Those of the system.
    #[allow(clippy::disallowed_types)]
    pub fn new(to: SocketAddr) -> io::Result<Self> {
        let from: IpAddr = match to.ip() {
            ip if ip.is_loopback() => ip,
            IpAddr::V4(_) => [0, 0, 0, 0].into(),
            IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let socket = UdpSocket::bind((from, 0))?;
        // A network may be many readers.
        socket.set_broadcast(true)?;
        Ok(Self { socket, to })
    }

    /// Sends one.
    ///
    /// # Errors
    /// Those of the system. That nobody listens is none.
    pub fn send(&self, datagram: &[u8]) -> io::Result<()> {
        self.socket.send_to(datagram, self.to).map(drop)
    }
}

/// A secret that whoever commands knows. Its text appears in no debug output.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

/// Characters of a token at least.
const TOKEN_CHARACTERS: usize = 16;

/// Why a text is no token.
#[derive(Debug, thiserror::Error)]
#[error("a token has at least {TOKEN_CHARACTERS} characters: letters, digits, `-` and `_`")]
pub struct TokenError;

impl Token {
    /// A token that somebody chose.
    ///
    /// # Errors
    /// If it is short, or has characters that an address or a header does not carry as they are.
    pub fn new(text: &str) -> Result<Self, TokenError> {
        let is_plain = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte));
        if is_plain && text.len() >= TOKEN_CHARACTERS { Ok(Self(text.to_owned())) } else { Err(TokenError) }
    }

    /// A new one, of 128 random bits.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn random() -> io::Result<Self> {
        let mut bits = [0; 16];
        getrandom::fill(&mut bits).map_err(io::Error::other)?;
        Ok(Self(format!("{:032x}", u128::from_le_bytes(bits))))
    }

    /// Its text, for who may know it.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Tells whether `given` is it, in a time that does not depend on where they differ.
    pub fn is(&self, given: &str) -> bool {
        let (known, given) = (self.0.as_bytes(), given.as_bytes());
        let difference = known.iter().zip(given).fold(0, |difference, (a, b)| difference | (a ^ b));
        known.len() == given.len() && difference == 0
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token")
    }
}

/// Why a request by HTTP is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum HttpRefusal {
    /// No Host, or a name that is not this listener's.
    #[error("the request is for another host")]
    Host,
    /// It comes from a page of somewhere else.
    #[error("the request comes from a page of another site")]
    Origin,
    /// It does not know the token.
    #[error("the token is missing or wrong")]
    Token,
}

/// Checks a request to a listener at `address`: its headers Host and Origin, and the token that it
/// brought.
///
/// Accepted hosts are `localhost`, the loopback's addresses and the listener's own, with its port.
///
/// # Errors
/// What is wrong with it.
pub fn check_http(
    address: SocketAddr,
    host: Option<&str>,
    origin: Option<&str>,
    token: (&Token, Option<&str>),
) -> Result<(), HttpRefusal> {
    let port = address.port();
    let own = [format!("localhost:{port}"), format!("127.0.0.1:{port}"), format!("[::1]:{port}"), address.to_string()];
    let is_own = |host: &str| own.iter().any(|own| own.eq_ignore_ascii_case(host));
    if !host.is_some_and(is_own) {
        return Err(HttpRefusal::Host);
    }
    // A browser names the page that asks; other programs have none.
    if origin.is_some_and(|origin| !origin.strip_prefix("http://").is_some_and(is_own)) {
        return Err(HttpRefusal::Origin);
    }
    let (known, given) = token;
    if given.is_some_and(|given| known.is(given)) { Ok(()) } else { Err(HttpRefusal::Token) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};

    fn listening(beyond: Option<IpAddr>) -> Listening {
        Listening::new(beyond, Token::random().expect("random numbers"))
    }

    #[test]
    fn only_the_loopback_or_the_address_of_listen_is_bound() {
        let loopback: SocketAddr = ([127, 0, 0, 1], 0).into();
        let everywhere: SocketAddr = ([0, 0, 0, 0], 0).into();
        assert!(listening(None).bind(loopback).is_ok());
        let refusal = listening(None).bind(everywhere).unwrap_err().to_string();
        assert_eq!(refusal, "0.0.0.0:0 can be reached by other machines: `--listen 0.0.0.0` allows it");
        assert!(listening(Some([10, 0, 0, 1].into())).bind(everywhere).is_err(), "another one is not it");
        assert!(listening(Some(everywhere.ip())).bind(everywhere).is_ok());
    }

    #[test]
    fn a_port_in_use_is_one_sentence() {
        let listening = listening(None);
        let first = listening.bind(([127, 0, 0, 1], 0).into()).expect("it is free");
        let sentence = listening.bind(first.address()).unwrap_err().to_string();
        assert!(sentence.starts_with(&format!("cannot listen on {}: ", first.address())), "{sentence}");
    }

    #[test]
    fn a_connection_is_accepted_when_it_is_there() -> io::Result<()> {
        let listener = listening(None).bind(([127, 0, 0, 1], 0).into()).expect("it is free");
        assert!(listener.accept()?.is_none());
        let mut there = TcpStream::connect(listener.address())?;
        let mut here = loop {
            if let Some(stream) = listener.accept()? {
                break stream;
            }
        };
        here.write_all(b"wind")?;
        let mut received = [0; 4];
        there.read_exact(&mut received)?;
        assert_eq!(&received, b"wind");
        Ok(())
    }

    #[test]
    fn a_token_is_long_plain_and_secret() {
        let token = Token::random().expect("random numbers");
        assert!(token.is(token.text()) && Token::new(token.text()).is_ok());
        assert_ne!(token, Token::random().expect("random numbers"));
        for wrong in ["", &token.text()[1..], &format!("{}0", token.text())] {
            assert!(!token.is(wrong), "{wrong}");
        }
        assert!(Token::new("short").is_err() && Token::new("sixteen letters & more").is_err());
        assert!(!format!("{:?}", Listening::new(None, token.clone())).contains(token.text()));
    }

    #[test]
    fn a_page_of_another_site_gets_nothing() {
        let address: SocketAddr = ([127, 0, 0, 1], 8080).into();
        let token = Token::random().expect("random numbers");
        let check = |host, origin, given| check_http(address, host, origin, (&token, given));
        let (own, given) = (Some("localhost:8080"), Some(token.text()));
        assert_eq!(check(own, None, given), Ok(()));
        assert_eq!(check(Some("[::1]:8080"), Some("http://LOCALHOST:8080"), given), Ok(()));
        // A name that somebody made to point to the loopback, and ports that are not this one's.
        for host in [None, Some("evil.example:8080"), Some("localhost"), Some("localhost:80")] {
            assert_eq!(check(host, None, given), Err(HttpRefusal::Host), "{host:?}");
        }
        for origin in ["http://evil.example", "null", "http://localhost:3000", "https://localhost:8080"] {
            assert_eq!(check(own, Some(origin), given), Err(HttpRefusal::Origin), "{origin}");
        }
        assert_eq!(check(own, None, None), Err(HttpRefusal::Token));
        assert_eq!(check(own, None, Some("guessed")), Err(HttpRefusal::Token));
    }
}
