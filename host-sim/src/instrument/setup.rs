//! Setting an instrument up for a run, command by command in the order that it needs: sample
//! period, guard, elements with their models and drives, and what the anemometer has to know.

use super::error::InstrumentError;
use super::port::InstrumentPort;
use dr_core::control::{Refusal, Trip};
use dr_core::{Command, Reply};

/// Sent before any command that heats: time enough for the next command to be repeated until it
/// arrives.
pub const ARM: Command = Command::Arm { window_s: 30.0 };

/// Brings an instrument from whatever it does to running this set-up.
///
/// # Errors
/// The first command that is refused; the instrument is in standby then, or tripped as it was
/// before.
pub fn start(instrument: &mut dyn InstrumentPort, setup: &[Command]) -> Result<Reply, InstrumentError> {
    configure(instrument, setup)?;
    instrument.command(ARM)?;
    Ok(match instrument.command(Command::Start)? {
        // It runs, but what it said got lost: that much is known here as well.
        Reply::Done => judged(setup),
        started @ Reply::Started { .. } => started,
    })
}

/// Brings an instrument from whatever it does to standby, knowing this set-up.
///
/// # Errors
/// As [`start`].
pub fn configure(instrument: &mut dyn InstrumentPort, setup: &[Command]) -> Result<(), InstrumentError> {
    let board = usize::from(instrument.identity().elements);
    let head = setup.iter().filter(|command| matches!(command, Command::Element { .. })).count();
    if head > board {
        return Err(InstrumentError::TooManyElements { head, board });
    }
    for command in [Command::Stop, Command::Clear].iter().chain(setup) {
        instrument.command(*command)?;
    }
    Ok(())
}

/// Brings a tripped instrument back to standby; one that is not tripped stays as it is.
///
/// # Errors
/// If the instrument cannot be reached.
pub fn acknowledge(instrument: &mut dyn InstrumentPort) -> Result<(), InstrumentError> {
    match instrument.command(Command::Acknowledge) {
        Ok(_) | Err(InstrumentError::Refused(Refusal::NotTripped)) => Ok(()),
        Err(error) => Err(error),
    }
}

/// How many set-points a model has judged, and how many none could.
fn judged(setup: &[Command]) -> Reply {
    let has_model =
        |of: u8| setup.iter().any(|command| matches!(command, Command::Model { element, .. } if *element == of));
    let (mut judged, mut unjudged) = (0, 0);
    for command in setup {
        match command {
            Command::Drive { drive, .. } if drive.target_range_c().is_none() => {}
            Command::Drive { element, .. } if has_model(*element) => judged += 1,
            Command::Drive { .. } => unjudged += 1,
            _ => {}
        }
    }
    Reply::Started { judged, unjudged }
}

/// What of a head tripped, for people.
pub fn place(trip: Trip, names: &[&str]) -> String {
    match trip.element {
        None => "the whole instrument".to_owned(),
        Some(element) => {
            names.get(usize::from(element)).map_or_else(|| format!("element {element}"), |&name| name.to_owned())
        }
    }
}
