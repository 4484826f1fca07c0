//! What a run's answers amount to: how many, what of them is to be doubted, and how fast the wind was.

use std::collections::BTreeMap;
use std::fmt;

use dr_core::control::Doubts;
use serde::Serialize;
use wire::WindSample;

/// What is added up.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    answers: u64,
    doubts: BTreeMap<&'static str, u64>,
    /// Of answers that have a wind.
    winds: u64,
    speed_m_s: f64,
    variance_m2_s2: f64,
}

/// All of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnswerSummary {
    pub answers: u64,
    /// By name, in how many answers; those that were never raised are left out.
    pub doubts: BTreeMap<&'static str, u64>,
    /// Of answers that have a wind; `None` if there was none.
    pub mean_speed_m_s: Option<f64>,
    /// Standard error of one answer by the noise of the readings, as a root mean square.
    pub speed_error_m_s: Option<f64>,
}

impl Tally {
    pub fn add(&mut self, answer: &WindSample) {
        self.answers += 1;
        for (doubt, name) in Doubts::NAMES {
            if answer.doubts.has(doubt) {
                *self.doubts.entry(name).or_default() += 1;
            }
        }
        if !answer.doubts.has(Doubts::FAILED) {
            self.winds += 1;
            self.speed_m_s += f64::from(answer.speed_m_s);
            self.variance_m2_s2 += f64::from(answer.speed_error_m_s).powi(2);
        }
    }

    pub fn summary(&self) -> AnswerSummary {
        let mean = |sum: f64| (self.winds > 0).then(|| sum / self.winds as f64);
        AnswerSummary {
            answers: self.answers,
            doubts: self.doubts.clone(),
            mean_speed_m_s: mean(self.speed_m_s),
            speed_error_m_s: mean(self.variance_m2_s2).map(f64::sqrt),
        }
    }
}

impl fmt::Display for AnswerSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} answers", self.answers)?;
        if let (Some(speed_m_s), Some(error_m_s)) = (self.mean_speed_m_s, self.speed_error_m_s) {
            write!(f, ", mean speed {speed_m_s:.2} m/s, each with a standard error of {error_m_s:.2} m/s")?;
        } else {
            write!(f, ", none with a wind")?;
        }
        writeln!(f)?;
        for (name, count) in &self.doubts {
            writeln!(f, "  {name:<13} {:.1} %", 100.0 * *count as f64 / self.answers.max(1) as f64)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(speed_m_s: f32, doubts: Doubts) -> WindSample {
        WindSample {
            doubts,
            wind_m_s: [speed_m_s, 0.0, 0.0],
            speed_m_s,
            across_m_s: 0.0,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.5,
            direction_error_rad: 0.0,
            chi_square: 0.0,
            gas_c: 0.0,
            conductance_w_k: [0.0; 4].into_iter().collect(),
            raw_w_k: [0.0; 4].into_iter().collect(),
        }
    }

    #[test]
    fn answers_without_a_wind_are_counted_and_have_no_speed() {
        let mut tally = Tally::default();
        tally.add(&answer(2.0, Doubts::default()));
        tally.add(&answer(4.0, Doubts::STARTING));
        tally.add(&answer(0.0, Doubts(Doubts::FAILED.0 | Doubts::NO_GAS.0)));
        let summary = tally.summary();
        assert_eq!((summary.answers, summary.mean_speed_m_s, summary.speed_error_m_s), (3, Some(3.0), Some(0.5)));
        assert_eq!(summary.doubts, BTreeMap::from([("failed", 1), ("no-gas", 1), ("starting", 1)]));
        let text = summary.to_string();
        assert!(text.contains("3 answers, mean speed 3.00 m/s") && text.contains("no-gas        33.3 %"), "{text}");
        let mut none = Tally::default();
        none.add(&answer(0.0, Doubts::FAILED));
        assert_eq!(none.summary().mean_speed_m_s, None);
        assert!(none.summary().to_string().starts_with("1 answers, none with a wind\n"));
    }
}
