//! The wind off line: the board's own anemometer over the rows of a recording.
//!
//! | file | what |
//! |---|---|
//! | [`calibrated`] | a head with a calibration, from its network and its steady winds |
//! | [`off_line`] | a calibrated head's anemometer beside ticks |
//! | [`moment`] | a tick with what is known of its conditions |
//! | [`replay`] | a recording as the ticks that made it |
//! | [`live`] | rows of a run that goes on, the same way |
//! | [`steady`] | means of convective powers and overheats in steady winds, for a calibration |
//! | [`winds`] | winds that are known: from the recording, or from a table |
//! | [`errors`] | answers beside a wind that is known |
//! | [`median`] | a median in little memory |
//! | [`tally`] | what a run's answers amount to |

pub mod calibrated;
pub mod errors;
pub mod live;
pub mod median;
pub mod moment;
pub mod off_line;
pub mod replay;
pub mod steady;
pub mod tally;
pub mod winds;
