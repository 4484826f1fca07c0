//! What a run's answers amount to: how many, what of them is to be doubted, and how fast the wind was.

use std::collections::BTreeMap;
use std::fmt;

use dr_core::control::Doubts;
use serde::Serialize;
use wire::WindSample;

use super::errors::SLOWEST_M_S;
use super::median::Median;

/// What is added up.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    answers: u64,
    doubts: BTreeMap<&'static str, u64>,
    /// Of answers that have a wind.
    winds: u64,
    speed_m_s: f64,
    speed_error_m_s: Median,
    /// Of winds that have a relative speed to speak of, and of those that have a direction, °.
    relative_error: Median,
    direction_error_deg: Median,
}

/// All of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnswerSummary {
    pub answers: u64,
    /// By name, in how many answers; those that were never raised are left out.
    pub doubts: BTreeMap<&'static str, u64>,
    /// Of answers that have a wind; `None` if there was none.
    pub mean_speed_m_s: Option<f64>,
    /// Standard error of one answer by the noise of the readings: the median, since few answers right after a jump of the wind have very great ones.
    pub speed_error_m_s: Option<f64>,
    /// The same as a share of the speed.
    pub speed_standard_error: Option<f64>,
    pub direction_standard_error_deg: Option<f64>,
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
            self.speed_error_m_s.add(f64::from(answer.speed_error_m_s));
            if f64::from(answer.speed_m_s) >= SLOWEST_M_S {
                self.relative_error.add(f64::from(answer.speed_error_m_s / answer.speed_m_s));
                if !answer.doubts.has(Doubts::NO_DIRECTION) {
                    self.direction_error_deg.add(f64::from(answer.direction_error_rad.to_degrees()));
                }
            }
        }
    }

    pub fn summary(&self) -> AnswerSummary {
        AnswerSummary {
            answers: self.answers,
            doubts: self.doubts.clone(),
            mean_speed_m_s: (self.winds > 0).then(|| self.speed_m_s / self.winds as f64),
            speed_error_m_s: self.speed_error_m_s.value(),
            speed_standard_error: self.relative_error.value(),
            direction_standard_error_deg: self.direction_error_deg.value(),
        }
    }
}

impl fmt::Display for AnswerSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} answers", self.answers)?;
        if let (Some(speed_m_s), Some(error_m_s)) = (self.mean_speed_m_s, self.speed_error_m_s) {
            write!(f, ", mean speed {speed_m_s:.2} m/s, each with a standard error of about {error_m_s:.2} m/s")?;
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
        assert_eq!((summary.answers, summary.mean_speed_m_s), (3, Some(3.0)));
        assert!((summary.speed_error_m_s.unwrap() - 0.5).abs() < 3e-3);
        // 0.5 m/s of 2 m/s, and of 4 m/s: the median is the lower one of two.
        assert!((summary.speed_standard_error.unwrap() - 0.125).abs() < 1e-3);
        assert_eq!(summary.doubts, BTreeMap::from([("failed", 1), ("no-gas", 1), ("starting", 1)]));
        let text = summary.to_string();
        assert!(text.contains("3 answers, mean speed 3.00 m/s") && text.contains("no-gas        33.3 %"), "{text}");
        let mut none = Tally::default();
        none.add(&answer(0.0, Doubts::FAILED));
        assert_eq!(none.summary().mean_speed_m_s, None);
        assert!(none.summary().to_string().starts_with("1 answers, none with a wind\n"));
    }
}
