//! The wind off line: the board's own anemometer over the rows of a recording.
//!
//! | file | what |
//! |---|---|
//! | [`replay`] | a recording as the ticks that made it |
//! | [`steady`] | means of convective powers and overheats in steady winds, for a calibration |
//! | [`winds`] | winds that are known: from the recording, or from a table |
//! | [`errors`] | answers beside a wind that is known |

pub mod errors;
pub mod replay;
pub mod steady;
pub mod winds;
