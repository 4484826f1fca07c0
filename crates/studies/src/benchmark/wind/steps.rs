//! Sudden steps of the wind, 2 → 6 → 2 m/s: how soon the answer stays within 5 % of the new speed,
//! and what drifts afterwards.
//!
//! | figure | of |
//! |---|---|
//! | response of the mean | the mean of all repeats: what is answered without the noise |
//! | response of one | the median over the repeats of the last moment outside 5 % in the 6 s of each |
//! | noise | standard deviation of single answers in the second half of each |
//! | drift | means over half a minute: the end of ten minutes beside five seconds after the step |
//! | raw | the speed of the mean raw conductance by the power law through its own two settled values: of the mean of all repeats where they settle, or else of means over a second of the ten minutes |

use super::blown::{RawLaw, blow, raw_w_k};
use super::sphere::WindMode;
use crate::thesis::StudyLab;
use crate::thesis::lab::alternating;
use anemometry::head::Head;
use anyhow::{Result, bail};

/// Distance within which an answer has to stay.
const WITHIN: f64 = 0.05;
const REPEATS: usize = 60;
/// Before the first step, and between steps, s.
const BEFORE_S: f64 = 120.0;
const HOLD_S: f64 = 6.0;
/// Means of a drift, s.
const MEAN_S: f64 = 30.0;
/// Left out after a step, s: what is slower is a drift.
const AFTER_S: f64 = 5.0;
/// Length of means of raw powers that drift, s: single ones are noisy.
const RAW_MEAN_S: f64 = 1.0;
/// Raw powers are looked at so: smoothed by far less than their 0.7 s.
const RAW: WindMode = WindMode { bandwidth_hz: 5.0, fixed: true };
/// And drifts so.
const DRIFT: WindMode = WindMode { bandwidth_hz: 0.5, fixed: false };

/// One way of a step: to so many m/s.
#[derive(Debug, Clone)]
pub struct Way {
    /// Response of the mean of all repeats, s.
    pub mean_response_s: f64,
    /// Median response of single repeats, s.
    pub single_response_s: f64,
    /// Relative, of single answers.
    pub noise: f64,
    /// Share of single answers in the second half.
    pub outside: f64,
}

/// Both ways in one mode.
#[derive(Debug, Clone)]
pub struct StepResponses {
    /// The bandwidth.
    pub mode: WindMode,
    /// To 6 and to 2 m/s.
    pub ways: [Way; 2],
}

/// Measures the responses to many short steps, by bandwidth.
///
/// # Errors
/// What could not be run.
pub fn measure(lab: &StudyLab, head: &Head, modes: &[WindMode], drift: &mut Drift) -> Result<Vec<StepResponses>> {
    let base = lab.experiment("steps")?;
    let experiment = alternating(&base, BEFORE_S, HOLD_S, 2 * REPEATS, base.sample_period_s)?;
    lab.announce(&experiment);
    let mut speeds: Vec<Vec<f64>> = vec![Vec::new(); modes.len()];
    let mut raw = Vec::new();
    let mut every_s = 0.0;
    let all: Vec<WindMode> = modes.iter().copied().chain([RAW]).collect();
    blow(&experiment, head, &all, &mut |place, moment, answer| {
        if place == modes.len() {
            raw.push(drift.law.speed_m_s(raw_w_k(answer)));
            return;
        }
        if place == 0 && speeds[0].len() == 1 {
            every_s = moment.time_s;
        }
        speeds[place].push(f64::from(answer.speed_m_s));
    })?;
    let rows = |time_s: f64| (time_s / every_s).round() as usize;
    let (before, hold) = (rows(BEFORE_S), rows(HOLD_S));
    let to = [experiment.wind[1].speed_m_s, experiment.wind[2].speed_m_s];
    let ways = |speeds: &[f64]| {
        [0, 1].map(|first| {
            let stretches = speeds[before.min(speeds.len())..].chunks_exact(hold).skip(first).step_by(2);
            way(&stretches.collect::<Vec<_>>(), to[first], every_s)
        })
    };
    for (response_s, way) in drift.raw_response_s.iter_mut().zip(ways(&raw)) {
        if *response_s <= 0.5 * HOLD_S {
            *response_s = way.mean_response_s;
        }
    }
    Ok(speeds.iter().zip(modes).map(|(speeds, &mode)| StepResponses { mode, ways: ways(speeds) }).collect())
}

fn way(stretches: &[&[f64]], to_m_s: f64, every_s: f64) -> Way {
    let rows = stretches.first().map_or(0, |first| first.len());
    let count = stretches.len().max(1) as f64;
    let mean: Vec<f64> = (0..rows).map(|n| stretches.iter().map(|of| of[n]).sum::<f64>() / count / to_m_s).collect();
    let relative = |of: &[f64]| of.iter().map(|speed| speed / to_m_s).collect::<Vec<_>>();
    let mut singles: Vec<f64> = stretches.iter().map(|of| settled_s(&relative(of), every_s)).collect();
    singles.sort_by(f64::total_cmp);
    let late = stretches.iter().flat_map(|of| of[rows / 2..].iter().map(|speed| speed / to_m_s - 1.0));
    let late: Vec<f64> = late.collect();
    let centre = late.iter().sum::<f64>() / late.len().max(1) as f64;
    let noise = (late.iter().map(|e| (e - centre).powi(2)).sum::<f64>() / late.len().max(1) as f64).sqrt();
    Way {
        mean_response_s: settled_s(&mean, every_s),
        single_response_s: singles.get(singles.len() / 2).copied().unwrap_or(f64::NAN),
        noise,
        outside: late.iter().filter(|e| e.abs() > WITHIN).count() as f64 / late.len().max(1) as f64,
    }
}

/// Time from the first row until values stay within 5 % of one; the row after the last one outside.
pub fn settled_s(values: &[f64], every_s: f64) -> f64 {
    let last = values.iter().rposition(|value| (value - 1.0).abs() > WITHIN || value.is_nan());
    last.map_or(0.0, |last| (last + 1) as f64 * every_s)
}

/// Drift in ten minutes after a step.
#[derive(Debug, Clone)]
pub struct Drift {
    /// The bandwidth.
    pub mode: WindMode,
    /// To 6 and to 2 m/s, relative.
    pub answer: [f64; 2],
    /// The same of the raw conductance.
    pub raw: [f64; 2],
    /// Law by which raw powers are read.
    pub law: RawLaw,
    /// Response of the speeds that they say: until within 5 % for good, s.
    pub raw_response_s: [f64; 2],
}

/// Measures what drifts in ten minutes after a step.
///
/// # Errors
/// What could not be run.
pub fn drift(lab: &StudyLab, head: &Head) -> Result<Drift> {
    let experiment = lab.experiment("steps")?;
    let [before, first, second] = &experiment.wind[..] else {
        bail!("{}: has {} winds in place of 3", experiment.title, experiment.wind.len());
    };
    lab.announce(&experiment);
    let (mut time_s, mut speed, mut raw) = (Vec::new(), Vec::new(), Vec::new());
    blow(&experiment, head, &[DRIFT, RAW], &mut |place, moment, answer| {
        if place == 0 {
            time_s.push(moment.time_s);
            speed.push(f64::from(answer.speed_m_s));
        } else {
            raw.push(raw_w_k(answer));
        }
    })?;
    let mean = |of: &[f64], from_s: f64, to_s: f64| {
        let rows = time_s.partition_point(|&t| t < from_s)..time_s.partition_point(|&t| t < to_s);
        of[rows.clone()].iter().sum::<f64>() / rows.len().max(1) as f64
    };
    let ends = [second.start_s, experiment.duration_s()];
    let law = RawLaw {
        slow: (before.speed_m_s, mean(&raw, first.start_s - MEAN_S, first.start_s)),
        fast: (first.speed_m_s, mean(&raw, ends[0] - MEAN_S, ends[0])),
    };
    let raw_speed: Vec<f64> = raw.iter().map(|&raw| law.speed_m_s(raw)).collect();
    let of = |values: &[f64]| {
        [(first.start_s, ends[0]), (second.start_s, ends[1])].map(|(from_s, to_s)| {
            let early = mean(values, from_s + AFTER_S, from_s + AFTER_S + MEAN_S);
            mean(values, to_s - MEAN_S, to_s) / early - 1.0
        })
    };
    let response = |from_s: f64, to_s: f64| {
        let last = mean(&raw_speed, to_s - MEAN_S, to_s);
        let seconds = (0..((to_s - from_s) / RAW_MEAN_S) as u32).map(|n| from_s + f64::from(n) * RAW_MEAN_S);
        let means: Vec<f64> = seconds.map(|s| mean(&raw_speed, s, s + RAW_MEAN_S) / last).collect();
        settled_s(&means, RAW_MEAN_S)
    };
    Ok(Drift {
        mode: DRIFT,
        law,
        answer: of(&speed),
        raw: of(&raw_speed),
        raw_response_s: [response(first.start_s, ends[0]), response(second.start_s, ends[1])],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_response_ends_with_the_last_value_outside() {
        assert_eq!(settled_s(&[0.3, 0.94, 1.06, 0.96, 1.04], 0.01), 0.03);
        assert_eq!(settled_s(&[1.0, 0.98], 0.01), 0.0);
        assert_eq!(settled_s(&[1.0, f64::NAN], 0.01), 0.02);
    }

    #[test]
    fn an_exponential_stays_within_five_percent_after_its_own_time() {
        // (6 − 2)/6 e^{−t/τ} = 0.05 at τ ln 13.33; two repeats that differ by ±1 % have the same
        // mean.
        let curve = |share: f64| {
            (0..600).map(|n| share * (6.0 - 4.0 * libm::exp(-f64::from(n) * 0.01 / 0.1))).collect::<Vec<f64>>()
        };
        let (a, b) = (curve(1.01), curve(0.99));
        let way = way(&[&a, &b], 6.0, 0.01);
        assert!((way.mean_response_s - 0.1 * libm::log(4.0_f64 / 6.0 / 0.05)).abs() <= 0.01, "{}", way.mean_response_s);
        assert!((way.noise - 0.01).abs() < 1e-6 && way.outside == 0.0);
    }
}
