//! Settings that an instrument stores in its flash, each under a key of its own.
//!
//! | number | key | what |
//! |---|---|---|
//! | 0x0100 | `name` | what the instrument is called |
//! | 0x0200 | `telemetry_every` | ticks a sample after a start |
//! | 0x0300 | `sample_period_s` | command `SamplePeriod` |
//! | 0x0400 | `guard` | command `Guard` |
//! | 0x0500 | `observe` | command `Observe` |
//! | 0x0600 | `host_timeout_s` | command `HostTimeout` |
//! | 0x0700 | `fingerprint` | command `Fingerprint` |
//! | 0x10ee, 0x11ee, 0x12ee | `element`, `model`, `drive` | of element ee |
//! | 0x1c00 … 0x1f00 | `correction`, `convection`, `uncertainty`, `form` | what a head has of them |
//! | 0x20ee | `own` | command `SelfHeating` of element ee |
//! | 0x21es | `faster` | command `FasterGains`: set s of element e |
//! | 0x22ft | `cross` | command `CrossHeating` from element f to element t |
//! | 0x23pp | `point` | command `NusseltPoint` |
//! | 0x24pp | `part` | command `Surface` |
//! | 0x2500 … 0x2800 | `card`, `gas_law`, `answer`, `gas` | the others |
//! | 0x30ee, 0x31ee | `tested`, `tested_at_start` | finding for element ee of the last self-test requested by a host, and of the last one after a start; written by the instrument itself, and sent to hosts only |
//!
//! The upper byte is the kind, the lower one the index. Numbers never change their meaning. Their
//! ascending order is the order of a set-up.
//!
//! A value is its format, one byte ([`FORMAT`]), and the postcard encoding of a [`Setting`]. It
//! says itself what it is of: a value that is found under another key than its own is refused, as
//! is one of a later format.

use dr_core::Command;
use dr_core::control::{Refusal, SelfTestFinding};
use dr_core::wind::WindCommand;
use serde::{Deserialize, Serialize};

use crate::list::Name;

/// Format of the values. Any change of what a [`Setting`] looks like in bytes raises it.
pub const FORMAT: u8 = 2;

/// Longest value: a card, of 50 numbers.
pub const MOST_VALUE: usize = 224;

/// A value as it is kept: format, then bytes.
pub type SettingValue = heapless::Vec<u8, MOST_VALUE>;

/// Number of a key.
pub type KeyNumber = u16;

/// What kind of thing a key is of, in the order of a set-up.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, strum::EnumString, strum::FromRepr, strum::IntoStaticStr,
)]
#[strum(serialize_all = "snake_case")]
#[repr(u8)]
pub enum SettingKind {
    /// What the instrument is called.
    Name = 0x01,
    /// Ticks a sample.
    TelemetryEvery = 0x02,
    /// Length of a tick.
    #[strum(to_string = "sample_period_s")]
    SamplePeriod = 0x03,
    /// Limits of the guard.
    Guard = 0x04,
    /// Whether observers run.
    Observe = 0x05,
    /// Longest run without a host.
    #[strum(to_string = "host_timeout_s")]
    HostTimeout = 0x06,
    /// Resistances of the head.
    Fingerprint = 0x07,
    /// Wiring and limits of an element.
    Element = 0x10,
    /// Its model.
    Model = 0x11,
    /// What it does.
    Drive = 0x12,
    /// Slow errors of surfaces that are taken out.
    Correction = 0x1c,
    /// How the convection of surfaces is taken.
    Convection = 0x1d,
    /// What the calibration adds to the uncertainty of the wind.
    Uncertainty = 0x1e,
    /// What the surfaces of the head belong to.
    Form = 0x1f,
    /// Self-heating of an element.
    #[strum(to_string = "own")]
    SelfHeating = 0x20,
    /// Faster gains.
    #[strum(to_string = "faster")]
    FasterGains = 0x21,
    /// Cross-heating of a pair.
    #[strum(to_string = "cross")]
    CrossHeating = 0x22,
    /// Amplitudes at a Reynolds number.
    #[strum(to_string = "point")]
    NusseltPoint = 0x23,
    /// A surface of the head.
    #[strum(to_string = "part")]
    Surface = 0x24,
    /// Four dice on a card.
    Card = 0x25,
    /// The gas.
    GasLaw = 0x26,
    /// Output settings of the wind estimate.
    #[strum(to_string = "answer")]
    WindOutput = 0x27,
    /// State of the gas.
    Gas = 0x28,
    /// Finding of a requested self-test for an element.
    Tested = 0x30,
    /// Finding of the self-test after a start.
    TestedAtStart = 0x31,
}

impl SettingKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SettingKey {
    /// What kind of thing it is of.
    pub kind: SettingKind,
    /// Which of them; 0 where there is only one.
    pub which: u8,
}

impl SettingKey {
    /// Its number, for ever.
    pub const fn number(self) -> KeyNumber {
        (self.kind as u16) << 8 | self.which as u16
    }

    /// The key of a number, if it is one.
    pub fn of_number(number: KeyNumber) -> Option<Self> {
        let [kind, which] = number.to_be_bytes();
        Some(Self { kind: SettingKind::from_repr(kind)?, which })
    }
}

/// What is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Setting {
    /// What the instrument is called.
    Name(Name),
    /// Ticks a sample after a start, as in `Telemetry`.
    TelemetryEvery(u16),
    /// A command that sets the instrument up.
    Command(Command),
    /// What a self-test has found of an element.
    Tested(TestRecord),
}

/// What a self-test has found of an element, when, and by whom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TestRecord {
    /// Start time given by the host, s since 1970; none for the self-test after a start, when the
    /// date is unknown.
    pub unix_s: Option<u32>,
    /// The firmware that tested.
    pub firmware: Name,
    /// How often it had started since its supply came up.
    pub starts: u32,
    /// What it found.
    pub finding: SelfTestFinding,
}

/// Why a stored value is not used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum Unusable {
    /// It is of another format, by an older or a newer firmware.
    #[error("it is of format {found}, and this firmware reads formats 1 to {FORMAT}")]
    Format {
        /// Its.
        found: u8,
    },
    /// This firmware does not know its key.
    #[error("this firmware does not know its key")]
    UnknownKey,
    /// It is no value.
    #[error("it is damaged")]
    Damaged,
    /// It is a value, but of another key.
    #[error("it is the value of another key")]
    Misplaced,
    /// The instrument refuses it.
    #[error("the instrument refuses it: {0}")]
    Refused(Refusal),
}

impl Setting {
    /// Where it belongs; none for a command that sets nothing up.
    pub fn key(&self) -> Option<SettingKey> {
        let pair = |a: u8, b: u8| (a < 16 && b < 16).then_some(a << 4 | b);
        let (kind, which) = match self {
            Self::Name(_) => (SettingKind::Name, 0),
            Self::TelemetryEvery(_) => (SettingKind::TelemetryEvery, 0),
            Self::Command(command) => match command {
                Command::SamplePeriod { .. } => (SettingKind::SamplePeriod, 0),
                Command::Guard(_) => (SettingKind::Guard, 0),
                Command::Observe { .. } => (SettingKind::Observe, 0),
                Command::HostTimeout { .. } => (SettingKind::HostTimeout, 0),
                Command::Fingerprint { .. } => (SettingKind::Fingerprint, 0),
                Command::Element { element, .. } => (SettingKind::Element, *element),
                Command::Model { element, .. } => (SettingKind::Model, *element),
                Command::Drive { element, .. } => (SettingKind::Drive, *element),
                Command::Wind(wind) => match wind {
                    WindCommand::SelfHeating { element, .. } => (SettingKind::SelfHeating, *element),
                    WindCommand::FasterGains(faster) => (SettingKind::FasterGains, pair(faster.element, faster.set)?),
                    WindCommand::CrossHeating(cross) => (SettingKind::CrossHeating, pair(cross.from, cross.to)?),
                    WindCommand::NusseltPoint { point, .. } => (SettingKind::NusseltPoint, *point),
                    WindCommand::Surface { surface, .. } => (SettingKind::Surface, *surface),
                    WindCommand::Form(_) => (SettingKind::Form, 0),
                    WindCommand::Card(_) => (SettingKind::Card, 0),
                    WindCommand::GasLaw(_) => (SettingKind::GasLaw, 0),
                    WindCommand::Output(_) => (SettingKind::WindOutput, 0),
                    WindCommand::Gas { .. } => (SettingKind::Gas, 0),
                    WindCommand::Uncertainty(_) => (SettingKind::Uncertainty, 0),
                    WindCommand::Convection(_) => (SettingKind::Convection, 0),
                    WindCommand::Correction(_) => (SettingKind::Correction, 0),
                },
                Command::Clear
                | Command::Start
                | Command::Stop
                | Command::Acknowledge
                | Command::Arm { .. }
                | Command::Disarm
                | Command::SelfTest(_)
                // A capacitor is set up by its host, which reads the meter.
                | Command::Capacitor { .. } => return None,
            },
            Self::Tested(record) => {
                let kind = if record.unix_s.is_some() { SettingKind::Tested } else { SettingKind::TestedAtStart };
                (kind, record.finding.element)
            }
        };
        Some(SettingKey { kind, which })
    }

    /// The value of it, as it is kept.
    ///
    /// # Errors
    /// If it is longer than any value may be, which none is.
    pub fn value(&self) -> Result<SettingValue, postcard::Error> {
        let mut buffer = [0; MOST_VALUE];
        let [format, rest @ ..] = &mut buffer;
        *format = FORMAT;
        let length = 1 + postcard::to_slice(self, rest)?.len();
        let used = buffer.get(..length).unwrap_or_default();
        SettingValue::from_slice(used).map_err(|_| postcard::Error::SerializeBufferFull)
    }

    /// Reads a value that stands under a key.
    ///
    /// # Errors
    /// Why it is not used.
    pub fn read(number: KeyNumber, value: &[u8]) -> Result<Self, Unusable> {
        let key = SettingKey::of_number(number).ok_or(Unusable::UnknownKey)?;
        let (&found, bytes) = value.split_first().ok_or(Unusable::Damaged)?;
        // Values of older formats are converted here: `format1.txt` has bytes of the first, and a
        // test reads them.
        let mut now = SettingValue::from_slice(bytes).map_err(|_| Unusable::Damaged)?;
        match found {
            FORMAT => {}
            // An element has got a limit of energy since, which this one does without.
            1 if key.kind == SettingKind::Element => now.push(0).map_err(|_| Unusable::Damaged)?,
            1 => {}
            _ => return Err(Unusable::Format { found }),
        }
        let (setting, rest) = postcard::take_from_bytes::<Self>(&now).map_err(|_| Unusable::Damaged)?;
        if !rest.is_empty() {
            return Err(Unusable::Damaged);
        }
        if setting.key() == Some(key) { Ok(setting) } else { Err(Unusable::Misplaced) }
    }
}

/// Requests of a host to the settings. The reply to each is one `Setting`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // there is no heap to put the value on
pub enum SettingsRequest {
    /// Stores a value. In standby. It applies after the next `Load` or the next start.
    Store {
        /// Under this key.
        key: KeyNumber,
        /// Format, and bytes.
        value: SettingValue,
    },
    /// The value of a key.
    Read {
        /// Which.
        key: KeyNumber,
    },
    /// The first value whose key is greater than this one.
    Next {
        /// None: the first of all.
        after: Option<KeyNumber>,
    },
    /// Erases the value of a key. In standby.
    Erase {
        /// Which.
        key: KeyNumber,
    },
    /// Erases all values. In standby.
    EraseAll,
    /// Clears the instrument and applies the stored settings. In standby.
    Load,
    /// Verifies the stored settings. The reply is `Done`, or the refusal `NotWhole`.
    Check,
}

/// A reply of the settings server.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SettingsAnswer {
    /// Sequence number of the frame that brought the request.
    pub to: u16,
    /// What came of it.
    pub result: Result<SettingsReply, SettingsRefusal>,
}

/// Reply to a request that was carried out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // there is no heap to put the value on
pub enum SettingsReply {
    /// Done.
    Done,
    /// A value.
    Value {
        /// Its key.
        key: KeyNumber,
        /// Format and bytes, as they stand.
        value: SettingValue,
        /// Why it is not used, if it is not.
        unusable: Option<Unusable>,
    },
    /// There is nothing under this key, or none after it.
    Nothing,
    /// The instrument has been set up.
    Loaded {
        /// Number of settings applied.
        taken: u16,
        /// Number of values not used; `Read` returns the reason.
        left: u16,
    },
}

/// Why a request was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum SettingsRefusal {
    /// Only possible in standby.
    #[error("settings can only be changed in standby: stop the run, or acknowledge the trip")]
    NotInStandby,
    /// This firmware would not use such a value.
    #[error("this value would not be used: {0}")]
    Unusable(Unusable),
    /// There is no room for it: so many bytes are free.
    #[error("there is no room for it: {free} bytes are free")]
    Full {
        /// Bytes.
        free: u16,
    },
    /// The flash does not take it, does not give it back, or holds something else.
    #[error("the flash of the settings cannot be read or written, or holds other data")]
    Flash,
    /// The stored settings are corrupt: values may be missing or out of date.
    #[error("the settings in flash are corrupt: values may be missing or out of date")]
    NotWhole,
}

impl Unusable {
    /// For a log.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Format { .. } => "of another format",
            Self::UnknownKey => "of an unknown key",
            Self::Damaged => "damaged",
            Self::Misplaced => "of another key",
            Self::Refused(_) => "refused by the instrument",
        }
    }
}

#[cfg(test)]
mod tests;
