//! Setting an instrument up for a run, command by command in the order that it needs: sample
//! period, guard, elements with their models and drives, and what the anemometer has to know.

use super::error::InstrumentError;
use super::port::InstrumentPort;
use dr_core::Command;
use dr_core::control::{Refusal, Trip};

/// Sent before any command that heats: time enough for the next command to be repeated until it
/// arrives.
pub const ARM: Command = Command::Arm { window_s: 30.0 };

/// Brings an instrument from whatever it does to running this set-up.
///
/// # Errors
/// The first command that is refused; the instrument is in standby then, or tripped as it was
/// before.
pub fn start(instrument: &mut dyn InstrumentPort, setup: &[Command]) -> Result<(), InstrumentError> {
    configure(instrument, setup)?;
    instrument.command(ARM)?;
    instrument.command(Command::Start).map(drop)
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

/// What of a head tripped, for people.
pub fn place(trip: Trip, names: &[&str]) -> String {
    match trip.element {
        None => "the whole instrument".to_owned(),
        Some(element) => {
            names.get(usize::from(element)).map_or_else(|| format!("element {element}"), |&name| name.to_owned())
        }
    }
}
