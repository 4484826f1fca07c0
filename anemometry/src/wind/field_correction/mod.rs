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
//! | [`find`] | how large and quick errors are: by likelihood; the errors themselves |

pub mod equations;
pub mod evidence;
pub mod find;
pub mod halves;
mod open;
pub mod overheats;
pub mod report;
pub mod smoother;
mod widen;

pub use evidence::SlowEvidence;
pub use find::{FieldCorrection, SlowErrorKind, SlowErrorsUnknown};
pub use report::SlowErrorReport;
