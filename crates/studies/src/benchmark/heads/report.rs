//! The figures of heads as text, as JSON and as a page.

use std::fmt;

use dr_core::wind::HeadForm;
use serde::Serialize;

use crate::table::ResultTable;

use super::{BANDWIDTH, HeadFigures, MeasuredHead};

/// What `studies benchmark heads` reports.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct HeadsReport {
    /// Head by head, and mode by mode.
    pub heads: Vec<HeadFigures>,
    /// What could not be calibrated in a mode, and why.
    pub refused: Vec<String>,
}

const TITLES: [&str; 6] = ["head", "surfaces", "mode", "unseen winds", "direction rms", "speed rms (mean)"];

impl HeadFigures {
    fn cells(&self) -> [String; 6] {
        let surfaces = match self.form {
            HeadForm::Sphere | HeadForm::Cube => format!("{} of a sphere", self.surfaces),
            HeadForm::Cylinder => format!("{} round a cylinder", self.surfaces),
            HeadForm::Wires => format!("{} wires", self.surfaces),
            HeadForm::Single => "one".to_owned(),
        };
        let direction = self.direction_rms_deg.map_or_else(|| "none".to_owned(), |deg| format!("{deg:.2}°"));
        let speed = format!("{:.2} % ({:+.2} %)", 100.0 * self.speed_rms, 100.0 * self.speed_mean);
        [self.head.clone(), surfaces, self.mode.name().to_owned(), self.winds.to_string(), direction, speed]
    }
}

fn legend() -> String {
    format!(
        "Each head is identified, calibrated in 60 winds and judged in winds that it has not seen, at {BANDWIDTH} and noise of 4 µV a \
         reading: folders of `anemo head new`, and nothing of the truth. CTA, CCA and CPA are constant temperature, current and power: the \
         latter two at what quiescent gas bears."
    )
}

impl HeadsReport {
    /// Adds the figures of another head.
    pub fn extend(&mut self, other: MeasuredHead) {
        self.heads.extend(other.figures);
        self.refused.extend(other.refused);
    }

    /// The page of a day under a title, by a command.
    pub fn page(&self, title: &str, command: &str, day: &str) -> String {
        let table = ResultTable::new(&TITLES.join(" | "), self.heads.iter().map(HeadFigures::cells)).markdown();
        let made: String =
            self.heads.iter().map(|of| format!("- {}, {}: {}\n", of.head, of.mode.name(), of.made_from)).collect();
        let refused: String = self.refused.iter().map(|sentence| format!("- {sentence}\n")).collect();
        let refused = if refused.is_empty() { refused } else { format!("\nNot calibrated:\n\n{refused}") };
        format!(
            "# {title}\n\nBy `{command}`, {day}. {}\n\n{table}\nTheir calibrations, with errors in winds that were left \
             out:\n\n{made}{refused}",
            legend()
        )
    }
}

impl fmt::Display for HeadsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = self.heads.iter().map(HeadFigures::cells);
        for cells in std::iter::once(TITLES.map(str::to_owned)).chain(rows) {
            let [head, surfaces, mode, winds, direction, speed] = cells;
            writeln!(f, "{head:<14} {surfaces:<20} {mode:<4} {winds:>12} {direction:>14} {speed:>20}")?;
        }
        self.refused.iter().try_for_each(|sentence| writeln!(f, "{sentence}"))?;
        writeln!(f, "\n{}", legend())
    }
}
