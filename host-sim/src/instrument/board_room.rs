//! What boards have room for. A controller on the host has room for more, and so a set-up is
//! counted before a board gets it.

use std::collections::BTreeSet;

use dr_core::Command;
use dr_core::model::{BOARD_FASTER_ELEMENTS, BOARD_PAIRS};
use dr_core::wind::{BOARD_SURFACES, WindCommand};
use wire::MOST_ELEMENTS;

use super::error::InstrumentError;

/// Whether boards have room for a set-up.
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
