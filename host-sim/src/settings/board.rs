//! Reading and replacing a board's settings, and the rehearsal before anything is written.

use dr_core::Instrument;
use dr_core::control::{HardwareLimits, Refusal};
use wire::settings::{CHECK, MOST_PIECE, Piece};
use wire::{MOST_ELEMENTS, SettingsRefusal, SettingsReply, SettingsRequest, StoredRecord, TestRecord};

use super::edit::{Settings, SettingsError, key};
use crate::instrument::setup::fits_boards;
use crate::instrument::{InstrumentError, SettingsPort};

/// Records of a board.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredSettings {
    /// The settings, if they can be read.
    pub settings: Result<Settings, SettingsRefusal>,
    /// Why the board does not use them.
    pub unused: Option<SettingsRefusal>,
    /// The last self-test that a host requested.
    pub test: Option<TestRecord>,
    /// The self-test of the last start.
    pub test_at_start: Option<TestRecord>,
}

/// Reads all records of a board.
///
/// # Errors
/// If the board cannot be reached, or is not in standby.
pub fn read_all(board: &mut dyn SettingsPort) -> Result<StoredSettings, InstrumentError> {
    let unused = refused(board.ask_settings(&SettingsRequest::Check))?.err();
    let settings = refused(read(board, StoredRecord::Settings))?
        .and_then(|bytes| Settings::from_bytes(&bytes).map_err(SettingsRefusal::Unusable));
    // One of another firmware is none of this one's.
    let mut test = |record| read(board, record).map(|bytes| TestRecord::read(&bytes).ok());
    let (test, test_at_start) = (test(StoredRecord::Test)?, test(StoredRecord::TestAtStart)?);
    Ok(StoredSettings { settings, unused, test, test_at_start })
}

/// Separates a refusal that concerns the settings from other errors.
fn refused<T>(result: Result<T, InstrumentError>) -> Result<Result<T, SettingsRefusal>, InstrumentError> {
    match result {
        Err(InstrumentError::Settings(why)) if why != SettingsRefusal::NotInStandby => Ok(Err(why)),
        result => result.map(Ok),
    }
}

fn read(board: &mut dyn SettingsPort, record: StoredRecord) -> Result<Vec<u8>, InstrumentError> {
    let mut bytes = Vec::new();
    loop {
        match board.ask_settings(&SettingsRequest::Read { record, at: bytes.len() as u16 })? {
            SettingsReply::Piece(piece) if piece.is_empty() => return Ok(bytes),
            SettingsReply::Piece(piece) => bytes.extend(piece),
            SettingsReply::Done => {
                return Err(InstrumentError::Protocol(format!("a piece of {record:?} is missing in a reply")));
            }
        }
    }
}

/// Sets a controller of this process up by settings, as a board with these limits would be set up.
///
/// # Errors
/// The first command that it refuses, or what boards have no room for.
pub fn rehearse(settings: &Settings, limits: &'static HardwareLimits) -> Result<(), SettingsError> {
    fits_boards(settings.commands()).map_err(|error| SettingsError(error.to_string()))?;
    let mut station = Instrument::<MOST_ELEMENTS>::new(limits);
    for command in settings.commands() {
        station.handle(*command).map_err(|refusal| {
            let first = if refusal == Refusal::NoSamplePeriod { "; set sample_period_s first" } else { "" };
            SettingsError(format!("{}: {refusal}{first}", key(command)))
        })?;
    }
    Ok(())
}

/// The requests that replace a board's settings by others: pieces, then the commit. A board whose
/// supply fails meanwhile has the settings before or the new ones.
///
/// # Errors
/// If the settings cannot be encoded.
pub fn write_requests(settings: &Settings) -> Result<Vec<SettingsRequest>, SettingsError> {
    let bytes = settings.bytes()?;
    let length =
        u16::try_from(bytes.len()).map_err(|_| SettingsError(format!("{} bytes are too long", bytes.len())))?;
    let pieces = (0..).step_by(MOST_PIECE).zip(bytes.chunks(MOST_PIECE));
    let writes =
        pieces.map(|(at, piece)| SettingsRequest::Write { at, bytes: piece.iter().copied().collect::<Piece>() });
    Ok(writes.chain([SettingsRequest::Commit { length, crc: CHECK.checksum(&bytes) }]).collect())
}

/// Replaces a board's settings, and sets it up by the new ones.
///
/// # Errors
/// If the board cannot be reached, or refuses.
pub fn write(board: &mut dyn SettingsPort, settings: &Settings) -> Result<(), InstrumentError> {
    let requests = write_requests(settings).map_err(|error| InstrumentError::Protocol(error.to_string()))?;
    for request in requests.iter().chain([&SettingsRequest::Load]) {
        board.ask_settings(request)?;
    }
    Ok(())
}
