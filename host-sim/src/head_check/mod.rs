//! Whether a head can do what it is meant for, from its file alone: `anemo head check`.
//!
//! | file | what |
//! |---|---|
//! | [`conditions`] | gas, overheat, sample period and noise that it is judged in |
//! | `element` | what each element comes to |
//! | [`fault`] | what keeps it from an overheat, and which ones are possible |
//! | `rest` | which elements are held in quiescent gas |
//! | [`winds`] | needed powers by wind speed, the range of winds, the resolution |
//! | [`warnings`] | what would go wrong |
//! | [`report`] | all of it as text and as JSON |

pub mod conditions;
mod element;
pub mod fault;
pub mod report;
mod rest;
pub mod warnings;
pub mod winds;

pub use conditions::{GivenConditions, HeadConditions};
pub use element::ElementCheck;
pub use fault::{ElementFault, OverheatError};
pub use report::{HeadCheckReport, check};
pub use winds::WindNeeds;

#[cfg(test)]
mod tests;
