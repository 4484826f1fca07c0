//! Check of a head's purpose, from its file alone: `anemo head check`.
//!
//! | file | what |
//! |---|---|
//! | [`conditions`] | gas, overheat, sample period and noise; numbers of each element; elements held in quiescent gas |
//! | [`fault`] | what keeps it from an overheat, and which ones are possible |
//! | [`winds`] | needed powers by wind speed, the range of winds, the resolution |
//! | [`warnings`] | what would go wrong |
//! | [`report`] | all of it as text and as JSON |

pub mod conditions;
pub mod fault;
pub mod report;
pub mod warnings;
pub mod winds;

pub use conditions::{ElementCheck, GivenConditions, HeadConditions};
pub use fault::{ElementFault, OverheatError};
pub use report::{HeadCheckReport, check};
pub use winds::WindNeeds;

#[cfg(test)]
mod tests;
