//! Slow errors of a head of four surfaces, found in the field by the number that its conductances
//! have to spare ([`dr_core::wind::slow_errors`]), and taken out of the recording.
//!
//! | file | what |
//! |---|---|
//! | [`evidence`] | conductances of a recording, slot by slot, and one equation of each |
//! | [`halves`] | what lies at each of two overheats, where they alternate, and what it says of heat |
//! | [`smoother`] | errors over time, with covariance |
//! | [`find`] | the search of all this, and of how large and quick errors are |
//! | [`correction`] | what was found, as corrections over time and in the head, or why nothing was |
//! | [`report`] | both in words and as JSON |

pub mod correction;
pub mod evidence;
pub mod find;
pub mod halves;
pub mod report;
pub mod smoother;
#[cfg(test)]
mod tests;

pub use correction::FieldCorrection;
pub use correction::SlowErrorKind;
pub use correction::SlowErrorsUnknown;
pub use evidence::SlowEvidence;
pub use report::SlowErrorReport;
