//! Settings that an instrument stores in its flash: one record of name, head and set-up.
//!
//! A record is one byte, its format ([`FORMAT`]), then the postcard encodings of a [`Preface`] and
//! of the commands of the set-up, in their order. It is longer than a frame, so it is sent and read
//! in pieces; a CRC over all of it commits it. An instrument uses all of a record or nothing of it.
//!
//! Results of self-tests are records of their own ([`TestRecord`]), which only the instrument writes.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use dr_core::Command;
use dr_core::control::{Refusal, SelfTestFinding};
use serde::{Deserialize, Serialize};

use crate::list::{List, Name};

/// Format of the records. Any change of their bytes raises it. Formats 1 and 2 had a value under
/// each of some twenty kinds of keys.
pub const FORMAT: u8 = 3;

/// Longest piece of a record, bytes. A command is never longer; the longest has 50 numbers.
pub const MOST_PIECE: usize = 224;

/// Longest record of a self-test, bytes.
pub const MOST_TEST: usize = 1024;

/// Bytes of a record.
pub type Piece = heapless::Vec<u8, MOST_PIECE>;

/// Bytes of a self-test's record.
pub type TestBytes = heapless::Vec<u8, MOST_TEST>;

/// The sum that commits a record.
pub const CHECK: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Beginning of a record of settings: everything that is not a command.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Preface {
    /// Name of the instrument.
    pub name: Name,
    /// Ticks a sample after a start, as in `Telemetry`.
    pub telemetry_every: u16,
}

impl Default for Preface {
    fn default() -> Self {
        Self { name: Name::new(), telemetry_every: 1 }
    }
}

impl Preface {
    /// Encodes it, with the format in front.
    ///
    /// # Errors
    /// If it is longer than a piece, which it never is.
    pub fn bytes(&self) -> Result<Piece, postcard::Error> {
        encoded(&(FORMAT, self))
    }

    /// Takes it off the front of a record.
    ///
    /// # Errors
    /// If the format is another one, or the bytes are damaged.
    pub fn take(record: &[u8]) -> Result<(Self, &[u8]), Unusable> {
        postcard::take_from_bytes(content(record)?).map_err(|_| Unusable::Damaged)
    }
}

/// Encodes a command of a set-up.
///
/// # Errors
/// If it is longer than a piece, which it never is.
pub fn command_bytes(command: &Command) -> Result<Piece, postcard::Error> {
    encoded(command)
}

/// Takes a command of a set-up off the front of the rest of a record.
///
/// # Errors
/// If the bytes are damaged, or a command that sets nothing up.
pub fn take_command(record: &[u8]) -> Result<(Command, &[u8]), Unusable> {
    let taken = postcard::take_from_bytes(record).map_err(|_| Unusable::Damaged)?;
    if sets_up(&taken.0) { Ok(taken) } else { Err(Unusable::Damaged) }
}

/// Returns true if a command sets an instrument up, so that a record may contain it.
pub const fn sets_up(command: &Command) -> bool {
    match command {
        Command::SamplePeriod { .. }
        | Command::Guard(_)
        | Command::Observe { .. }
        | Command::HostTimeout { .. }
        | Command::Fingerprint { .. }
        | Command::Element { .. }
        | Command::Model { .. }
        | Command::Drive { .. }
        | Command::Wind(_) => true,
        Command::Clear
        | Command::Start
        | Command::Stop
        | Command::Acknowledge
        | Command::Arm { .. }
        | Command::Disarm
        | Command::SelfTest(_)
        // A capacitor is set up by its host, which reads the meter.
        | Command::Capacitor { .. } => false,
    }
}

/// Findings of a self-test, when it was, and by which firmware.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TestRecord {
    /// Start time given by the host, s since 1970. A self-test after a start does not know the date.
    pub unix_s: Option<u32>,
    /// The firmware that tested.
    pub firmware: Name,
    /// How often it had started since its supply came up.
    pub starts: u32,
    /// One entry an element.
    pub findings: List<SelfTestFinding>,
}

impl TestRecord {
    /// Encodes it, with the format in front.
    ///
    /// # Errors
    /// If it is longer than [`MOST_TEST`], which it never is.
    pub fn bytes(&self) -> Result<TestBytes, postcard::Error> {
        encoded(&(FORMAT, self))
    }

    /// Decodes it.
    ///
    /// # Errors
    /// If the format is another one, or the bytes are damaged.
    pub fn read(record: &[u8]) -> Result<Self, Unusable> {
        postcard::from_bytes(content(record)?).map_err(|_| Unusable::Damaged)
    }
}

fn encoded<const N: usize>(value: &impl Serialize) -> Result<heapless::Vec<u8, N>, postcard::Error> {
    let mut bytes = heapless::Vec::new();
    // It has room for so many.
    bytes.resize_default(N).ok();
    let length = postcard::to_slice(value, &mut bytes)?.len();
    bytes.truncate(length);
    Ok(bytes)
}

/// Returns what follows the format.
fn content(record: &[u8]) -> Result<&[u8], Unusable> {
    match record.split_first() {
        None => Err(Unusable::Damaged),
        Some((&FORMAT, content)) => Ok(content),
        Some((&found, _)) => Err(Unusable::Format { found }),
    }
}

/// Why stored settings are not used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum Unusable {
    /// An older or a newer firmware wrote them.
    #[error("they are of format {found}, and this firmware reads format {FORMAT}")]
    Format {
        /// Format of the record.
        found: u8,
    },
    /// They cannot be decoded.
    #[error("they are damaged")]
    Damaged,
    /// The instrument refuses a command.
    #[error("the instrument refuses command {number} of them: {refusal}")]
    Refused {
        /// Its number, from 1.
        number: u16,
        /// Why.
        refusal: Refusal,
    },
}

/// Records that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum StoredRecord {
    /// The settings.
    Settings,
    /// The last self-test that a host requested.
    Test,
    /// The self-test of the last set-up, which is not stored: each start tests anew.
    TestAtStart,
}

/// Requests of a host to the settings. The reply to each is one `Setting`. In standby only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // there is no heap to put the piece on
pub enum SettingsRequest {
    /// Writes a piece of new settings; the settings in force stay. The first piece erases what was
    /// written and not committed.
    Write {
        /// Where it begins: a multiple of 4, 0 for the first piece.
        at: u16,
        /// All pieces but the last have a multiple of 4 bytes.
        bytes: Piece,
    },
    /// Puts the new settings in the place of those in force, if their sum is this one. They apply
    /// after the next `Load` or the next start.
    Commit {
        /// Bytes of the record.
        length: u16,
        /// Their [`CHECK`].
        crc: u32,
    },
    /// Reads a piece of a record; without a byte at its end.
    Read {
        /// The record.
        record: StoredRecord,
        /// Where the piece begins.
        at: u16,
    },
    /// Clears the instrument and applies the settings, all of them or nothing.
    Load,
    /// Says whether the settings can be read and are used: `Done`, or why not.
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
#[allow(clippy::large_enum_variant)] // there is no heap to put the piece on
pub enum SettingsReply {
    /// Done.
    Done,
    /// A piece of a record.
    Piece(Piece),
}

/// Why a request was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum SettingsRefusal {
    /// Only possible in standby.
    #[error("settings can only be changed in standby: stop the run, or acknowledge the trip")]
    NotInStandby,
    /// This firmware does not use such settings.
    #[error("the settings are not used: {0}")]
    Unusable(Unusable),
    /// The record is too long for its place.
    #[error("there is no room for the settings: they may have {most} bytes")]
    TooLong {
        /// Bytes that a record may have.
        most: u16,
    },
    /// The flash cannot be read or written.
    #[error("the flash of the settings cannot be read or written")]
    Flash,
    /// Bytes there are no record.
    #[error("the flash of the settings holds settings of an older firmware, or other data")]
    Foreign,
    /// The settings in force have changed by themselves.
    #[error("the settings in flash are damaged")]
    Damaged,
    /// The sum of the pieces is not that of the commit.
    #[error("the settings have not arrived as they were sent")]
    NotWhole,
}

impl Unusable {
    /// For a log.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Format { .. } => "of another format",
            Self::Damaged => "damaged",
            Self::Refused { .. } => "refused by the instrument",
        }
    }
}

#[cfg(test)]
mod tests;
