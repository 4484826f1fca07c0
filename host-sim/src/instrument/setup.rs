//! Setting an instrument up for a run, command by command in the order that it needs: sample
//! period, guard, elements with their models and drives, and what the anemometer has to know.
//!
//! A controller on the host has room for more than boards have, so a set-up is counted before a
//! board gets it.

use std::collections::BTreeSet;

use dr_core::Command;
use dr_core::control::{Refusal, Trip};
use dr_core::model::{BOARD_FASTER_ELEMENTS, BOARD_PAIRS};
use dr_core::wind::{BOARD_SURFACES, WindCommand};
use wire::MOST_ELEMENTS;

use super::error::InstrumentError;
use super::port::InstrumentPort;

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

/// Part of a head that tripped, for people.
pub fn place(trip: Trip, names: &[&str]) -> String {
    match trip.element {
        None => "the whole instrument".to_owned(),
        Some(element) => {
            names.get(usize::from(element)).map_or_else(|| format!("element {element}"), |&name| name.to_owned())
        }
    }
}

/// Tells whether boards have room for a set-up.
///
/// # Errors
/// What there is too much of.
pub fn fits_boards<'a>(setup: impl IntoIterator<Item = &'a Command>) -> Result<(), InstrumentError> {
    let [mut elements, mut surfaces, mut pairs, mut quick] = [(); 4].map(|()| BTreeSet::new());
    for command in setup {
        match command {
            Command::Element { element, .. } => elements.insert((*element, 0)),
            Command::Wind(WindCommand::Surface { surface, .. }) => surfaces.insert((*surface, 0)),
            Command::Wind(WindCommand::CrossHeating(cross)) => pairs.insert((cross.from, cross.to)),
            Command::Wind(WindCommand::FasterGains(faster)) => quick.insert((faster.element, 0)),
            _ => continue,
        };
    }
    let counts = [
        (elements.len(), MOST_ELEMENTS, "elements"),
        (surfaces.len(), BOARD_SURFACES, "surfaces"),
        (pairs.len(), BOARD_PAIRS, "pairs of elements that heat each other"),
        (quick.len(), BOARD_FASTER_ELEMENTS, "elements whose bandwidth rises after a jump of the wind"),
    ];
    match counts.into_iter().find(|(head, board, _)| head > board) {
        Some((head, board, what)) => Err(InstrumentError::NoRoom { what, head, board }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use dr_core::control::{ElementConfig, Limits};
    use dr_core::model::NetworkCrossHeatingConfig;
    use dr_core::sensor::{Channel, Platinum};

    use super::*;

    #[test]
    fn a_board_has_room_for_16_elements_and_56_pairs() {
        let channel = Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), 5e-7, 3e-3, 16e-3).unwrap();
        let config = ElementConfig { channel, limits: Limits::SPHERE_B };
        let elements: Vec<Command> = (0..17).map(|element| Command::Element { element, config }).collect();
        let pair = |of: u8| {
            let (from, to) = (of / 8, of % 8);
            let numbers = [0.0; 4];
            let config =
                NetworkCrossHeatingConfig { from, to, mesh_rad_s: numbers, r_k_per_w: numbers, surface: numbers };
            Command::Wind(WindCommand::CrossHeating(config))
        };
        let pairs: Vec<Command> = (0..57).map(pair).collect();
        let said = |setup: &[Command]| fits_boards(setup).map_err(|error| error.to_string());
        assert_eq!(said(&elements[..16]), Ok(()));
        assert_eq!(said(&elements), Err("the head has 17 elements, boards have room for 16".to_owned()));
        assert_eq!(said(&pairs[..56]), Ok(()));
        let expected = "the head has 57 pairs of elements that heat each other, boards have room for 56";
        assert_eq!(said(&pairs), Err(expected.to_owned()));
    }
}
