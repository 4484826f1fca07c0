//! Wind from recordings: the board's own anemometer goes through the rows of a recording.
//!
//! | file | what |
//! |---|---|
//! | [`estimate`] | wind estimates of a recording |
//! | [`off_line`] | the anemometer of a calibrated head, off line |
//! | [`moment`] | a tick with its conditions |
//! | [`replay`] | a recording as the ticks that made it |
//! | [`live`] | rows of a run while it goes on, as ticks |
//! | `level_record` | elements that no loop holds |
//! | [`gas_input`] | pressure and temperature of the gas |
//! | [`gas_uncertainty`] | what their uncertainty does to a wind |
//! | `added_uncertainty` | what adds to the uncertainty of a wind |
//! | [`given_winds`] | a table of true winds |
//! | [`comparison`] | errors against the true wind |
//! | [`field_correction`] | slow errors found by the redundancy of four surfaces |
//! | [`tally`], [`median`] | statistics of the estimates |
//! | [`report`] | all of these as text and as JSON |
//! | [`error`] | what is refused |

mod added_uncertainty;
pub mod comparison;
pub mod error;
pub mod estimate;
pub mod field_correction;
pub mod gas_input;
pub mod gas_uncertainty;
pub mod given_winds;
mod level_record;
pub mod live;
pub mod median;
pub mod moment;
pub mod off_line;
pub mod replay;
pub mod report;
pub mod tally;
pub mod unknown_heat;

pub use estimate::{EstimatedWind, WindEstimation, WindOptions};
pub use report::WindReport;
