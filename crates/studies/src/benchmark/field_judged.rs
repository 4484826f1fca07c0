//! Influence of an effect of the field on estimates: how wrong they are, and whether they say so.

use anemometry::head::Head;
use anemometry::vector::{self, angle_deg, length};
use anemometry::wind::comparison::{Coverage, SLOWEST_M_S, WindComparison};
use anemometry::wind::field_correction::SlowErrorKind;
use anemometry::wind::gas_uncertainty::GasUncertainty;
use anemometry::wind::moment::Moment;
use anemometry::wind::off_line::axes;
use anyhow::Result;
use dr_core::wind::QualityFlags;
use host_sim::experiment::Experiment;
use wire::WindSample;

use super::field_correction::blow_corrected;
use super::wind::WindMode;
use super::wind::blown::blow;

/// Bandwidth by which winds are estimated.
pub(super) const MODE: WindMode = WindMode { bandwidth_hz: 0.5, fixed: false };
/// Left out of every wind of the short tunnel, and of every wind that is judged, s.
pub(super) const TUNNEL_SETTLE_S: f64 = 10.0;
pub(super) const SETTLE_S: f64 = 5.0;
/// Speeds off by so many standard uncertainties, and angles about two axes by so many, are by
/// chance in 0.3 % of cases.
const BEYOND: f64 = 3.0;
const BEYOND_OF_TWO: f64 = 3.44;

/// Figures of an effect, over all specimens.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectFigures {
    /// Difference.
    pub effect: String,
    /// Errors of direction, °.
    pub direction_rms_deg: Option<f64>,
    /// Errors of speed, as shares.
    pub speed_rms: Option<f64>,
    /// Their mean.
    pub speed_mean: Option<f64>,
    /// Share of estimates with any flag.
    pub flagged: Option<f64>,
    /// Share of estimates flagged `inconsistent`.
    pub inconsistent: Option<f64>,
    /// Shares of 95 % intervals of estimates without a flag that hold the true value.
    pub direction_coverage: Option<f64>,
    /// The same of the speed.
    pub speed_coverage: Option<f64>,
    /// Share of all estimates that are off by more than three standard uncertainties without a
    /// flag.
    pub unsaid: Option<f64>,
}

/// Counts over all specimens.
#[derive(Debug, Clone, Default)]
pub(super) struct EffectTally {
    errors: WindComparison,
    flagged: Coverage,
    inconsistent: Coverage,
    unsaid: Coverage,
}

impl EffectTally {
    fn add(&mut self, estimate: &WindSample, axes: &[[f64; 3]], truth_m_s: [f64; 3]) {
        let speed_m_s = length(truth_m_s);
        if speed_m_s < SLOWEST_M_S {
            return;
        }
        self.errors.add(estimate, axes, truth_m_s);
        let flags = estimate.quality_flags;
        self.flagged.add(flags != QualityFlags::default());
        self.inconsistent.add(flags.has(QualityFlags::INCONSISTENT));
        let off_m_s = (f64::from(estimate.speed_m_s) - speed_m_s).abs();
        let off_rad = angle_deg(estimate.wind_m_s.map(f64::from), truth_m_s).to_radians();
        let is_beyond = off_m_s > BEYOND * f64::from(estimate.speed_error_m_s)
            || off_rad > BEYOND_OF_TWO * f64::from(estimate.direction_error_rad);
        self.unsaid.add(is_beyond && flags == QualityFlags::default());
    }

    pub(super) fn figures(&self, effect: &str) -> EffectFigures {
        EffectFigures {
            effect: effect.to_owned(),
            direction_rms_deg: self.errors.direction_deg.rms(),
            speed_rms: self.errors.speed.rms(),
            speed_mean: self.errors.speed.mean(),
            flagged: self.flagged.share(),
            inconsistent: self.inconsistent.share(),
            direction_coverage: self.errors.direction_coverage.share(),
            speed_coverage: self.errors.speed_coverage.share(),
            unsaid: self.unsaid.share(),
        }
    }
}

/// Second judgement of an experiment: corrected, with such an uncertainty of its gas, K.
pub(super) type CorrectionOfCase = Option<(SlowErrorKind, Option<f64>)>;

/// Adds the estimates of an experiment, but for the beginnings of its winds: as they are to the
/// first tally, corrected to the second; of a stem with a wake those of winds that come from within
/// it to the second.
pub(super) fn judge(
    experiment: &Experiment,
    head: &Head,
    correction: CorrectionOfCase,
    tallies: &mut [EffectTally; 2],
) -> Result<()> {
    let axes = head.calibration.as_ref().map(|calibration| axes(head, calibration)).unwrap_or_default();
    let stem = experiment.field.stem.and_then(|stem| Some((stem.axis, stem.wake?.angle_deg)));
    let is_behind = |wind_m_s: [f64; 3]| {
        stem.is_some_and(|(axis, angle_deg)| angle_deg > vector::angle_deg(wind_m_s.map(|of| -of), axis))
    };
    let mut label = String::new();
    let mut from_s = 0.0;
    let mut each = |is_corrected: bool, moment: &Moment, estimate: &WindSample| {
        if label != moment.event {
            (label, from_s) = (moment.event.clone(), moment.time_s);
        }
        if let Some(truth_m_s) = moment.wind_m_s
            && moment.time_s - from_s >= SETTLE_S
        {
            tallies[usize::from(is_corrected || is_behind(truth_m_s))].add(estimate, &axes, truth_m_s);
        }
    };
    match correction {
        Some((kind, temperature_k)) => {
            let gas = GasUncertainty { temperature_k, pressure_pa: None };
            blow_corrected(experiment, head, MODE, kind, gas, &mut each)
        }
        None => blow(experiment, head, &[MODE], &mut |_, moment, estimate| each(false, moment, estimate)),
    }
}

/// Titles of the cells of an effect.
pub(super) const TITLES: &str = "otherwise | direction rms | speed rms (mean) | flagged (`inconsistent`) | 95 % intervals: direction, speed | unsaid";

impl EffectFigures {
    pub(super) fn cells(&self) -> [String; 6] {
        let percent = |share: Option<f64>, digits: usize| {
            share.map_or_else(|| "none".to_owned(), |share| format!("{:.digits$} %", 100.0 * share))
        };
        let mean = self.speed_mean.map_or_else(String::new, |mean| format!(" ({:+.1} %)", 100.0 * mean));
        [
            self.effect.clone(),
            self.direction_rms_deg.map_or_else(|| "none".to_owned(), |deg| format!("{deg:.2}°")),
            percent(self.speed_rms, 2) + &mean,
            format!("{} ({})", percent(self.flagged, 1), percent(self.inconsistent, 1)),
            format!("{}, {}", percent(self.direction_coverage, 0), percent(self.speed_coverage, 0)),
            percent(self.unsaid, 1),
        ]
    }
}
