//! Why an instrument cannot go on.

use dr_core::control::Refusal;
use std::io;
use wire::SettingsRefusal;

/// Why an instrument cannot go on, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum InstrumentError {
    /// The instrument refuses a command.
    #[error("the instrument refuses: {0}")]
    Refused(Refusal),
    /// The board does not keep it, or has not kept it.
    #[error("the board refuses: {0}")]
    Settings(SettingsRefusal),
    /// There is nothing to talk to: no emulator, no firmware, no port, or another program's.
    #[error("{0}")]
    Unusable(String),
    /// It has tripped, now or before.
    #[error(
        "the board is tripped ({cause}, {element}) and keeps its heaters low; mend the cause, then run again with --acknowledge"
    )]
    Tripped {
        /// By what.
        cause: &'static str,
        /// Where.
        element: String,
    },
    /// It forgot everything in the middle of a run.
    #[error("the board has started anew in the middle of the run, heaters low; it says that {0}")]
    Restarted(String),
    /// It went to standby in the middle of a run, by no command of ours.
    #[error(
        "the board went to standby in the middle of the run, heaters low, and did not trip: did another program stop it?"
    )]
    Stopped,
    /// Nobody answers.
    #[error("the board has not answered for {:.1} s; is its firmware running, and is this its port?", .0.as_secs_f64())]
    Silent(std::time::Duration),
    /// It sends something else than the protocol has here.
    #[error("the board broke the protocol: {0}")]
    Protocol(String),
    /// The head has more elements than the board.
    #[error("the head has {head} elements, the board can drive {board}")]
    TooManyElements {
        /// Version of the head's format.
        head: usize,
        /// Version of the board's format.
        board: usize,
    },
    /// The head is more than boards have room for.
    #[error("the head has {head} {what}, boards have room for {board}")]
    NoRoom {
        /// Name of what there is too much.
        what: &'static str,
        /// Number that the head has.
        head: usize,
        /// Number that a board takes.
        board: usize,
    },
    /// The link broke.
    #[error("the link to the board broke: {0}")]
    BoardLink(#[from] io::Error),
}
