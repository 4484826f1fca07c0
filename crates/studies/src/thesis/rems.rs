//! Common parts of the studies of the REMS transducer: the dice of one card, and which of them is
//! driven.

use dr_core::control::Drive;

use host_sim::experiment::Experiment;

/// The first elements of the head. Dice 1 and 2 are neighbours, 1 and 4 too; 1 and 3 are across.
pub const DICE: [&str; 4] = ["card1-die1", "card1-die2", "card1-die3", "card1-die4"];

/// An experiment with the first die, with what it does moved to another one. Noise is another's
/// too.
pub fn moved(experiment: &Experiment, die: usize) -> Experiment {
    let mut moved = experiment.clone();
    moved.drives.swap(0, die);
    moved.seed += 1000 * die as u64;
    moved
}

/// An experiment with all dice, in which only one does anything. Noise is its own.
pub fn alone(experiment: &Experiment, die: usize) -> Experiment {
    let mut alone = experiment.clone();
    for (place, drive) in alone.drives.iter_mut().enumerate().filter(|(place, _)| *place != die) {
        if place < DICE.len() {
            *drive = Drive::Passive;
        }
    }
    alone.seed += 1000 * (die as u64 + 1);
    alone
}
