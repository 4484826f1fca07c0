//! Slow errors of a head of four surfaces, found in the field by the number that its conductances
//! have to spare ([`dr_core::wind::slow_errors`]), and taken out of the recording.
//!
//! | file | what |
//! |---|---|
//! | [`evidence`] | conductances of a recording, slot by slot |
//! | [`equations`] | one equation a slot |
//! | [`halves`] | what lies at each of two overheats, where they alternate |
//! | [`overheats`] | equations of their differences |
//! | [`smoother`] | errors over time, with covariance |
//! | `open` | what the winds do not determine |
//! | [`report`] | both in words and as JSON |
//! | `widen` | what their covariance adds to that of a wind |
//! | `likeliest` | how large and quick errors are: by likelihood |
//! | [`find`] | the search of all this |
//! | [`kind`], `likelier` | heat or gains, and which of them |
//! | [`correction`] | what was found, as corrections over time |
//! | `constant` | what a head may carry of it |
//! | [`unknown`] | why nothing can be found |

mod constant;
pub mod correction;
pub mod equations;
pub mod evidence;
pub mod find;
pub mod halves;
pub mod kind;
mod likelier;
mod likeliest;
mod open;
pub mod overheats;
pub mod report;
pub mod smoother;
#[cfg(test)]
mod tests;
pub mod unknown;
mod widen;

pub use correction::FieldCorrection;
pub use evidence::SlowEvidence;
pub use kind::SlowErrorKind;
pub use report::SlowErrorReport;
pub use unknown::SlowErrorsUnknown;
