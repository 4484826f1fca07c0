//! Heads and overheats whose experiments would come to nothing, and what to know of the others.

use std::fmt::Display;
use std::path::PathBuf;

use anemometry::calibrate::drawn::drawn;
use anemometry::calibrate::{DrawnOptions, LossLaw};
use anemometry::head::Head;
use recording::text::short;
use recording::toml_file::FileError;

use crate::head_check::{ElementFault, HeadCheckReport};

/// Longest experiment.
const MOST_DAYS: f64 = 7.0;
const DAY_S: f64 = 86_400.0;

/// Refuses what would trip, hold nothing, or take too long.
pub fn refuse(head: &Head, report: &HeadCheckReport, longest_s: f64) -> Result<(), NewHeadError> {
    if let Some(fault) = &report.fault {
        return Err(match fault.fault {
            ElementFault::Shorted { .. } | ElementFault::Senses => in_file(head, fault),
            _ => NewHeadError::Refused(format!("--overheat is {}: {fault}", report.conditions.overheat_k)),
        });
    }
    if longest_s > MOST_DAYS * DAY_S {
        let slowest_s = short(report.time_constants_s[0], 3);
        let days = short(longest_s / DAY_S, 3);
        let sentence = format!(
            "`body` has a slowest time constant of {slowest_s} s, so that identifying it would take {days} days: {MOST_DAYS} are the most, by less `capacity_j_k` or more `conductance_w_k`"
        );
        return Err(in_file(head, sentence));
    }
    Ok(())
}

/// Refuses a head by its file.
fn in_file(head: &Head, sentence: impl Display) -> NewHeadError {
    NewHeadError::Refused(format!("{}: {sentence}", head.source.path.display()))
}

/// Why `anemo calibrate` would refuse the head as it is operated.
pub fn uncalibrated(head: &Head, report: &HeadCheckReport) -> Option<String> {
    let surfaces = match drawn(head, &DrawnOptions::default(), LossLaw::Spline) {
        Ok((surfaces, _)) => surfaces,
        Err(error) => return Some(format!("no `anemo calibrate` follows: {error}")),
    };
    let missing = surfaces.into_iter().find(|&place| !report.elements[place].held)?;
    let (name, overheat_k) = (&head.elements[missing].name, report.conditions.overheat_k);
    Some(format!("no `anemo calibrate` follows: it takes all surfaces, and `{name}` cannot be held at {overheat_k} K"))
}

/// Fate of winds up to a speed that the head cannot follow.
pub fn too_strong(head: &Head, report: &HeadCheckReport, most_m_s: f64) -> Option<String> {
    let (greatest_m_s, element) = (report.range.greatest_m_s?, report.range.limited_by?);
    (greatest_m_s < most_m_s).then(|| {
        format!(
            "winds of the experiments reach {most_m_s} m/s, but `{}` can be held up to {} m/s: stronger ones are flagged `saturated`; less overheat, or less `most_m_s`",
            head.elements[element].name,
            short(greatest_m_s, 3)
        )
    })
}

/// Why a new head was not written.
#[derive(Debug, thiserror::Error)]
pub enum NewHeadError {
    /// The head's file is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// Head, overheat or folder is refused, in one sentence.
    #[error("{0}")]
    Refused(String),
    /// A file cannot be written.
    #[error("{}: cannot be written: {error}", path.display())]
    Unwritten {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        error: std::io::Error,
    },
}
