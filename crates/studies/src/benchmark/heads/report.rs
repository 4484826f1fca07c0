//! The page of the heads' figures.

use dr_core::wind::HeadForm;

use crate::table::ResultTable;

use super::{BANDWIDTH, HeadFigures, MeasuredHead};

/// Report of `studies benchmark heads`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeadsReport {
    /// Head by head, and mode by mode.
    pub heads: Vec<HeadFigures>,
    /// Heads that could not be calibrated in a mode, and why.
    pub refused: Vec<String>,
}

const TITLES: &str = "head | surfaces | mode | unseen winds | direction rms | speed rms (mean)";

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

impl HeadsReport {
    /// Adds the figures of another head.
    pub fn extend(&mut self, other: MeasuredHead) {
        self.heads.extend(other.figures);
        self.refused.extend(other.refused);
    }

    /// The page of a day under a title, by a command.
    pub fn page(&self, title: &str, command: &str, day: &str) -> String {
        let made: String =
            self.heads.iter().map(|of| format!("- {}, {}: {}\n", of.head, of.mode.name(), of.made_from)).collect();
        let refused: String = self.refused.iter().map(|sentence| format!("- {sentence}\n")).collect();
        let refused = if refused.is_empty() { refused } else { format!("\nNot calibrated:\n\n{refused}") };
        let table = ResultTable::new(TITLES, self.heads.iter().map(HeadFigures::cells)).markdown();
        format!(
            "# {title}\n\nBy `{command}`, {day}. Each head is identified, calibrated in 60 winds and judged in winds that it has \
             not seen, at {BANDWIDTH} and noise of 4 µV a reading: folders of `anemo head new`, and nothing of the truth. CTA, CCA \
             and CPA are constant temperature, current and power: the latter two at what quiescent gas bears.\n\n{table}\nTheir \
             calibrations, with errors in winds that were left out:\n\n{made}{refused}"
        )
    }
}
