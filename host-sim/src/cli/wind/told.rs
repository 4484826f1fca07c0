//! What became of the answers: in words, and as JSON.

use serde_json::{Value, json};

use super::Arguments;
use super::gas::GasTold;
use crate::answer::errors::Errors;
use crate::answer::tally::{AnswerSummary, Tally};
use crate::head::{Answering, Calibration, Head};
use crate::recording::tidy;

/// What is kept of all answers.
pub(super) struct Told {
    /// All of them.
    pub answers: u64,
    /// Those that count, by `--from` and `--settle`.
    pub tally: Tally,
    /// The same beside the true wind.
    pub errors: Errors,
    /// Whether any of them had a true wind beside it.
    pub has_truth: bool,
    /// Gaps of the recording, and how long they are, s.
    pub gaps: (u64, f64),
}

/// What the answers were made with.
pub(super) struct Made<'a> {
    pub arguments: &'a Arguments,
    pub head: &'a Head,
    pub calibration: &'a Calibration,
    pub answering: &'a Answering,
    pub gas: &'a GasTold,
    /// Elements that stay at the steady bandwidth after a jump, and why.
    pub not_quick: &'a [String],
}

impl Told {
    pub fn json(&self, made: &Made<'_>) -> Value {
        let (errors, tally) = (&self.errors, self.tally.summary());
        json!({
            "head": made.head.name,
            "answers": self.answers,
            "bandwidth_hz": made.answering.bandwidth_hz,
            "fixed": made.answering.fixed,
            "every_s": made.answering.every_s,
            "gas": made.gas.json(),
            "warnings": made.gas.warnings,
            "gaps": self.gaps.0,
            "missing_s": self.gaps.1,
            "counted": tally.answers,
            "doubts": tally.doubts,
            "mean_speed_m_s": tally.mean_speed_m_s,
            "speed_error_m_s": tally.speed_error_m_s,
            "speed_standard_error": tally.speed_standard_error,
            "direction_standard_error_deg": tally.direction_standard_error_deg,
            "compared": errors.count,
            "failed": errors.failed,
            "without_direction": errors.no_direction,
            "speed_rms_error": errors.speed_rms(),
            "speed_bias": errors.speed_bias(),
            "speed_worst_error": errors.speed_worst(),
            "direction_rms_error_deg": errors.direction_rms_deg(),
            "direction_worst_error_deg": errors.direction_worst_deg(),
            "linear_direction_rms_error_deg": errors.linear_rms_deg(),
        })
    }

    pub fn text(&self, made: &Made<'_>) -> String {
        let tally = self.tally.summary();
        let mut text = format!(
            "{} · head {} · {}\ngas: {}\n{} answers, one each {} s, bandwidth {} Hz{}\n",
            made.arguments.recording.display(),
            made.head.name,
            made.calibration.made_from(),
            made.gas,
            self.answers,
            made.answering.every_s,
            made.answering.bandwidth_hz,
            if made.answering.fixed { ", fixed" } else { "" }
        );
        for sentence in made.not_quick {
            text += &format!("bandwidth fixed for {sentence}\n");
        }
        for warning in &made.gas.warnings {
            text += &format!("warning: {warning}\n");
        }
        if self.gaps.0 > 0 {
            text += &format!(
                "{} gaps in the recording, {} s in all: for ten times as long after each, answers are `starting`\n",
                self.gaps.0,
                tidy(self.gaps.1)
            );
        }
        text += &counting(made.arguments, &tally);
        text += &doubts(&tally);
        if self.has_truth {
            text += &beside_the_truth(&self.errors, made.calibration.card_normal().is_some());
        }
        for path in [&made.arguments.output, &made.arguments.plot].into_iter().flatten() {
            text += &format!("\nwritten to {}\n", path.display());
        }
        text
    }
}

/// Which answers count, and how noisy they are.
fn counting(arguments: &Arguments, tally: &AnswerSummary) -> String {
    let mut text = String::new();
    if arguments.from > 0.0 || arguments.settle > 0.0 {
        let mut which = Vec::new();
        if arguments.from > 0.0 {
            which.push(format!("from {} s on", arguments.from));
        }
        if arguments.settle > 0.0 {
            which.push(format!("{} s after every change of label", arguments.settle));
        }
        text += &match tally.answers {
            0 => format!("none of them counts: {}\n", which.join(", ")),
            count => format!("{count} of them count: {}\n", which.join(", ")),
        };
    }
    if let Some(error) = tally.speed_standard_error {
        text += &format!("standard error by the noise of the readings, median: speed {:.2} %", 100.0 * error);
        if let Some(error_deg) = tally.direction_standard_error_deg {
            text += &format!(", direction {error_deg:.2}°");
        }
        text += "\n";
    }
    text
}

fn doubts(tally: &AnswerSummary) -> String {
    if tally.answers == 0 {
        return String::new();
    }
    if tally.doubts.is_empty() {
        return "no doubts\n".to_owned();
    }
    let share = |count: u64| 100.0 * count as f64 / tally.answers as f64;
    let line = |(name, count): (&&str, &u64)| format!("{name:<13} {count} answers, {:.1} %\n", share(*count));
    tally.doubts.iter().map(line).collect()
}

fn beside_the_truth(errors: &Errors, is_card: bool) -> String {
    if errors.count == 0 {
        return "\nbeside the true wind: no answers to compare\n".to_owned();
    }
    let mut text = format!("\nbeside the true wind, {} answers", errors.count);
    if errors.failed > 0 {
        text += &format!(", {} of them without a wind", errors.failed);
    }
    text += "\n";
    if let (Some(rms), Some(bias), Some(worst)) = (errors.speed_rms(), errors.speed_bias(), errors.speed_worst()) {
        let percent = |of: f64| format!("{:.2} %", 100.0 * of);
        text += &format!("  speed      {} rms, {} mean, {} at worst\n", percent(rms), percent(bias), percent(worst));
    }
    if let (Some(rms), Some(worst)) = (errors.direction_rms_deg(), errors.direction_worst_deg()) {
        text += &format!("  direction  {rms:.2}° rms, {worst:.2}° at worst");
        if is_card {
            text += ", in the plane of the card";
        } else if let Some(linear) = errors.linear_rms_deg() {
            text += &format!("; linear inverse {linear:.2}° rms");
        }
        text += "\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_compared_is_not_shown_as_perfect() {
        assert_eq!(beside_the_truth(&Errors::default(), false), "\nbeside the true wind: no answers to compare\n");
        // One axis: a speed, and no direction.
        let mut errors = Errors::default();
        let mut answer = crate::answer::errors::tests::answer([0.0, 2.2, 0.0]);
        answer.doubts = dr_core::control::Doubts::UNDETERMINED;
        errors.add(&answer, &[[0.0, 1.0, 0.0]; 2], [0.0, 2.0, 0.0]);
        let text = beside_the_truth(&errors, false);
        assert_eq!(
            text,
            "\nbeside the true wind, 1 answers\n  speed      10.00 % rms, 10.00 % mean, 10.00 % at worst\n"
        );
        let mut failed = Errors::default();
        answer.doubts = dr_core::control::Doubts::FAILED;
        failed.add(&answer, &[], [0.0, 2.0, 0.0]);
        assert!(beside_the_truth(&failed, false).ends_with("1 answers, 1 of them without a wind\n"));
    }
}
