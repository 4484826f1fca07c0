//! Wind from recordings: the board's own anemometer goes through the rows of a recording.
//!
//! | file | what |
//! |---|---|
//! | [`estimate`] | wind estimates of a recording |
//! | [`off_line`] | the anemometer of a calibrated head, off line, and what is refused |
//! | [`moment`] | a tick with its conditions, also of a run while it goes on |
//! | [`replay`] | a recording as the ticks that made it |
//! | [`gas_input`] | pressure and temperature of the gas |
//! | [`gas_uncertainty`] | what their uncertainty does to a wind |
//! | [`given_winds`] | a table of true winds |
//! | [`comparison`] | errors against the true wind |
//! | [`field_correction`] | slow errors found by the redundancy of four surfaces |
//! | [`tally`] | statistics of the estimates |
//! | [`report`] | all of these as text and as JSON |

pub mod comparison;
pub mod estimate;
pub mod field_correction;
pub mod gas_input;
pub mod gas_uncertainty;
pub mod given_winds;
pub mod moment;
pub mod off_line;
pub mod replay;
pub mod report;
pub mod tally;

pub use estimate::{EstimatedWind, WindEstimation, WindOptions};
pub use report::WindReport;
