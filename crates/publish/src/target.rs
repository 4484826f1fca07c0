//! Where to publish what: addresses as a user writes them.
//!
//! | address | what it does |
//! |---|---|
//! | `nmea+udp://HOST:PORT`, `gill+udp:`, `gill-uv+udp:` | sends datagrams |
//! | `nmea+tcp://HOST:PORT`, `gill+tcp:`, `gill-uv+tcp:` | listens; who connects gets every line |
//! | `nmea+serial:/dev/ttyUSB0?baud=4800`, `gill+serial:`, `gill-uv+serial:` | writes to a port |
//! | `mqtt://[USER:PASSWORD@]HOST[:PORT]`, `mqtts:` | sends messages to a broker |
//! | `scpi://HOST[:PORT]` | listens and answers |
//!
//! `every=SECONDS` after a question mark is the least time from one row to the next: 1 for MQTT, 0
//! (every row with a wind estimate) for the others.

use anyhow::{Context, anyhow, bail, ensure};
use recording::toml_file::TomlSource;
use serde::Deserialize;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// One address with what belongs to it.
#[derive(Clone, PartialEq)]
pub struct PublishTarget {
    /// The address without password.
    pub name: String,
    pub(crate) format: PublishFormat,
    pub(crate) way: PublishWay,
    /// From one row to the next at least, s.
    pub(crate) every_s: f64,
    pub(crate) login: Option<PublishLogin>,
    /// Certificates of authorities, in PEM; those of the web where it is not given.
    pub(crate) ca_file: Option<PathBuf>,
}

/// Login at a broker.
#[derive(Clone, PartialEq)]
pub(crate) struct PublishLogin {
    pub(crate) user: String,
    pub(crate) password: String,
}

/// Format that is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PublishFormat {
    Nmea,
    GillPolar,
    GillUv,
    Mqtt,
    Scpi,
}

/// By which way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PublishWay {
    /// Datagrams to `host:port`.
    Datagrams(String),
    /// A listener at `host:port`.
    Listener(String),
    /// A serial port.
    Serial { device: String, baud: u32 },
    /// A connection to `host:port`.
    Connection { host: String, port: u16, is_encrypted: bool },
}

const KNOWN: &str = "nmea+udp, nmea+tcp, nmea+serial (the same with gill and gill-uv), mqtt, mqtts or scpi";

/// Refusal of an address without a known format or way.
fn nowhere(address: &str) -> String {
    format!("`{address}` is nowhere to publish: an address begins with {KNOWN}")
}

impl PublishTarget {
    /// Tells whether it is told of nothing but the wind.
    pub const fn is_wind_only(&self) -> bool {
        matches!(self.format, PublishFormat::Nmea | PublishFormat::GillPolar | PublishFormat::GillUv)
    }

    /// Tells whether its clients can command, if they know the token.
    pub fn takes_commands(&self) -> bool {
        self.format == PublishFormat::Scpi
    }
}

impl FromStr for PublishTarget {
    type Err = anyhow::Error;

    fn from_str(address: &str) -> anyhow::Result<Self> {
        let (scheme, rest) = address.split_once(':').with_context(|| nowhere(address))?;
        let (place, query) = rest.split_once('?').unwrap_or((rest, ""));
        let place = place.strip_prefix("//").unwrap_or(place);
        let (login, place) = match place.rsplit_once('@') {
            Some((login, place)) => (Some(PublishLogin::new(login)), place),
            None => (None, place),
        };
        let name = format!("{scheme}:{}{place}", if rest.starts_with("//") { "//" } else { "" });
        let mut options = TargetOptions::read(&name, query)?;
        let (format, way) = scheme.split_once('+').unwrap_or((scheme, ""));
        let (format, port) = match (format, way) {
            ("nmea", "udp" | "tcp" | "serial") => (PublishFormat::Nmea, Some(10_110)),
            ("gill", "udp" | "tcp" | "serial") => (PublishFormat::GillPolar, None),
            ("gill-uv", "udp" | "tcp" | "serial") => (PublishFormat::GillUv, None),
            ("mqtt", "") => (PublishFormat::Mqtt, Some(1_883)),
            ("mqtts", "") => (PublishFormat::Mqtt, Some(8_883)),
            ("scpi", "") => (PublishFormat::Scpi, Some(5_025)),
            _ => bail!(nowhere(&name)),
        };
        let way = match (scheme, way) {
            (_, "serial") if place.is_empty() => bail!("`{name}` lacks a device"),
            // The speeds that the makers of the formats chose.
            (_, "serial") => {
                let baud = options.baud.take().unwrap_or(if format == PublishFormat::Nmea { 4_800 } else { 9_600 });
                PublishWay::Serial { device: place.to_owned(), baud }
            }
            _ => {
                let (host, port) = host_and_port(&name, place, port)?;
                match (scheme, way) {
                    // Only a listener may take any that is free.
                    _ if port == 0 && way != "tcp" && scheme != "scpi" => bail!("`{name}` lacks {PORT}"),
                    (_, "udp") => PublishWay::Datagrams(format!("{host}:{port}")),
                    (_, "tcp") | ("scpi", _) => PublishWay::Listener(format!("{host}:{port}")),
                    _ => PublishWay::Connection {
                        host: host.trim_matches(['[', ']']).to_owned(),
                        port,
                        is_encrypted: scheme == "mqtts",
                    },
                }
            }
        };
        options.all_used(&name)?;
        let default_s = if format == PublishFormat::Mqtt { 1.0 } else { 0.0 };
        Ok(Self { every_s: options.every_s.unwrap_or(default_s), name, format, way, login, ca_file: None })
    }
}

impl PublishLogin {
    fn new(text: &str) -> Self {
        let (user, password) = text.split_once(':').unwrap_or((text, ""));
        Self { user: user.to_owned(), password: password.to_owned() }
    }
}

const PORT: &str = "a port: 1 … 65535";

fn host_and_port(name: &str, place: &str, port: Option<u16>) -> anyhow::Result<(String, u16)> {
    let place = place.trim_end_matches('/');
    let missing = |what| anyhow!("`{name}` lacks {what}");
    // Colons in brackets are those of an address of version 6.
    let (host, given) = match place.rsplit_once(':') {
        Some((host, port)) if !port.ends_with(']') => (host, Some(port.parse().map_err(|_| missing(PORT))?)),
        _ => (place, None),
    };
    if host.is_empty() {
        return Err(missing("a host"));
    }
    Ok((host.to_owned(), given.or(port).ok_or_else(|| missing("a port"))?))
}

/// Options behind the question mark.
#[derive(Default)]
struct TargetOptions<'a> {
    every_s: Option<f64>,
    baud: Option<u32>,
    /// First option of another name.
    unknown: Option<&'a str>,
}

impl<'a> TargetOptions<'a> {
    fn read(name: &str, query: &'a str) -> anyhow::Result<Self> {
        let mut options = Self::default();
        for option in query.split('&').filter(|option| !option.is_empty()) {
            let wrong = |what: &str| anyhow!("`{name}`: `{option}` is no {what}");
            let once = |is_first: bool| -> anyhow::Result<()> {
                ensure!(is_first, "`{name}`: `{option}` stands beside another");
                Ok(())
            };
            match option.split_once('=') {
                Some(("every", seconds)) => {
                    let every_s = seconds.parse().ok().filter(|&s| is_interval(s));
                    once(options.every_s.is_none())?;
                    options.every_s = Some(every_s.ok_or_else(|| wrong("time in seconds, 0 … 86400"))?);
                }
                Some(("baud", baud)) => {
                    once(options.baud.is_none())?;
                    options.baud = Some(baud.parse().map_err(|_| wrong("speed of a serial port"))?);
                }
                _ => options.unknown = options.unknown.or(Some(option)),
            }
        }
        Ok(options)
    }

    fn all_used(&self, name: &str) -> anyhow::Result<()> {
        let unknown = self.unknown.or(self.baud.map(|_| "baud"));
        unknown.map_or(Ok(()), |option| bail!("`{name}`: `{option}` is no option of it; `every=SECONDS` is"))
    }
}

/// Longer than a day, somebody forgot a unit.
fn is_interval(every_s: f64) -> bool {
    (0.0..=86_400.0).contains(&every_s)
}

/// A file of addresses, for passwords that do not belong on a command line.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TargetsFile {
    publish: Vec<TargetEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TargetEntry {
    to: String,
    user: Option<String>,
    password: Option<String>,
    ca_file: Option<PathBuf>,
}

/// The targets of an argument: an address, or the path of a file of them, which ends in `.toml`.
///
/// ```toml
/// [[publish]]
/// to = "mqtts://broker.example"
/// user = "mast"
/// password = "…"
/// ca_file = "ca.pem"   # beside this file
/// ```
///
/// # Errors
/// What is wrong with the address, or the file and its line.
pub fn targets(argument: &str) -> anyhow::Result<Vec<PublishTarget>> {
    let path = Path::new(argument);
    if path.extension().is_none_or(|extension| extension != "toml") {
        return Ok(vec![argument.parse()?]);
    }
    let source = TomlSource::read(path)?;
    let file: TargetsFile = source.parse()?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let entries = file.publish.into_iter().enumerate();
    entries.map(|(index, entry)| entry.target(index, &source, folder)).collect()
}

impl TargetEntry {
    fn target(self, index: usize, source: &TomlSource, folder: &Path) -> anyhow::Result<PublishTarget> {
        let refuse =
            |error: anyhow::Error| source.refuse(&format!("publish[{index}].to"), format!("is refused: {error}"));
        let mut target: PublishTarget = self.to.parse().map_err(refuse)?;
        if let Some(user) = self.user {
            target.login = Some(PublishLogin { user, password: self.password.unwrap_or_default() });
        }
        target.ca_file = self.ca_file.map(|file| folder.join(file));
        Ok(target)
    }
}

impl fmt::Debug for PublishTarget {
    /// Without the password.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} by {:?} every {} s", self.name, self.way, self.every_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(address: &str) -> PublishTarget {
        address.parse().expect(address)
    }

    fn refusal(address: &str) -> String {
        address.parse::<PublishTarget>().expect_err(address).to_string()
    }

    #[test]
    fn addresses_are_what_loggers_expect() {
        let ways = [
            ("nmea+udp://127.0.0.1:10110", PublishWay::Datagrams("127.0.0.1:10110".to_owned())),
            ("nmea+udp://127.0.0.1", PublishWay::Datagrams("127.0.0.1:10110".to_owned())),
            ("gill+tcp://[::1]:4001", PublishWay::Listener("[::1]:4001".to_owned())),
            ("scpi://127.0.0.1", PublishWay::Listener("127.0.0.1:5025".to_owned())),
            ("nmea+serial:/dev/ttyUSB0", PublishWay::Serial { device: "/dev/ttyUSB0".to_owned(), baud: 4_800 }),
            ("gill-uv+serial:COM3?baud=19200", PublishWay::Serial { device: "COM3".to_owned(), baud: 19_200 }),
            ("mqtt://broker", PublishWay::Connection { host: "broker".to_owned(), port: 1_883, is_encrypted: false }),
            ("mqtts://[::1]", PublishWay::Connection { host: "::1".to_owned(), port: 8_883, is_encrypted: true }),
        ];
        for (address, way) in ways {
            assert_eq!(target(address).way, way, "{address}");
        }
        assert_eq!(target("mqtt://broker?every=10").every_s, 10.0);
        assert_eq!((target("mqtt://broker").every_s, target("nmea+udp://b").every_s), (1.0, 0.0));
    }

    #[test]
    fn what_is_meant_by_nobody_is_refused_with_what_would_be_right() {
        assert!(
            refusal("nmea+upd://localhost")
                .starts_with("`nmea+upd://localhost` is nowhere to publish: an address begins with nmea+udp")
        );
        assert_eq!(refusal("gill+udp://localhost"), "`gill+udp://localhost` lacks a port");
        assert_eq!(refusal("mqtt://localhost:x"), "`mqtt://localhost:x` lacks a port: 1 … 65535");
        assert_eq!(refusal("mqtt://:1883"), "`mqtt://:1883` lacks a host");
        assert_eq!(refusal("mqtt://localhost:0"), "`mqtt://localhost:0` lacks a port: 1 … 65535");
        assert_eq!(refusal("mqtt://x:99999"), "`mqtt://x:99999` lacks a port: 1 … 65535");
        assert_eq!(refusal("nmea+serial:"), "`nmea+serial:` lacks a device");
        for wrong in ["every=-1", "every=nan", "every=1e9", "every=1&every=2", "evry=1", "baud=9600"] {
            assert!(refusal(&format!("mqtt://localhost?{wrong}")).starts_with("`mqtt://localhost`: "), "{wrong}");
        }
    }

    #[test]
    fn a_password_is_used_and_not_shown() {
        let target = target("mqtt://mast:p@ss:word@broker:1883");
        assert!(target.login.as_ref().is_some_and(|login| login.user == "mast" && login.password == "p@ss:word"));
        assert_eq!(target.name, "mqtt://broker:1883");
        assert!(!format!("{target:?}").contains("word"));
        assert!(!refusal("mqtt://mast:word@").contains("word"));
    }

    #[test]
    fn a_file_holds_what_a_command_line_should_not() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("publish.toml");
        let file = path.to_str().ok_or("a path of letters")?;
        std::fs::write(
            &path,
            "[[publish]]\nto = \"mqtts://broker\"\nuser = \"u\"\npassword = \"p\"\nca_file = \"ca.pem\"\n\n[[publish]]\nto = \"scpi://localhost\"\n",
        )?;
        let read = targets(file)?;
        assert_eq!(read.len(), 2);
        assert_eq!(read[0].ca_file, Some(folder.path().join("ca.pem")));
        assert!(read[0].login.as_ref().is_some_and(|login| login.password == "p"));
        std::fs::write(&path, "[[publish]]\n\nto = \"mqqt://broker\"\n")?;
        let sentence = targets(file).unwrap_err().to_string();
        assert!(sentence.contains(", line 3: ") && sentence.contains("nowhere to publish"), "{sentence}");
        Ok(())
    }
}
