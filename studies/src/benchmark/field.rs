//! Effects of the field on the wind of sphere B: `anemo benchmark field`.
//!
//! Each specimen is identified and calibrated without any effect, by the records of
//! `experiments/wind/quick`, and judged in the winds of `experiments/field`, in which something is
//! otherwise: how wrong the wind is, and whether the estimates say so.

use std::fmt;
use std::path::Path;

use anemometry::head::Head;
use anemometry::network::identify::PolesPerPair;
use anemometry::vector::{angle_deg, length};
use anemometry::wind::comparison::{Coverage, SLOWEST_M_S, WindComparison};
use anemometry::wind::field_correction::SlowErrorKind;
use anemometry::wind::moment::Moment;
use anemometry::wind::off_line::axes;
use dr_core::wind::QualityFlags;
use host_sim::experiment::Experiment;
use host_sim::sensor::field::{DriftQuantity, ElementDrift, FieldEffects, Sun};
use recording::text::count;
use serde::Serialize;
use wire::WindSample;

use super::field_correction::blow_corrected;
use super::wind::blown::blow;
use super::wind::{SPHERE_B, WindMode, chain};
use crate::thesis::{StudyError, StudyLab};

const MODE: WindMode = WindMode { bandwidth_hz: 0.5, fixed: false };
/// Of the first specimen.
const SEED: u64 = 41;
/// Left out of every wind of the short tunnel, and of every wind that is judged, s.
const TUNNEL_SETTLE_S: f64 = 10.0;
const SETTLE_S: f64 = 5.0;
/// Speeds off by so many standard uncertainties, and angles about two axes by so many, are by
/// chance in 0.3 % of cases.
const BEYOND: f64 = 3.0;
const BEYOND_OF_TWO: f64 = 3.44;

/// Names of the experiments of `experiments/field`, each with what is otherwise in it, and by what
/// it is corrected.
const EFFECTS: [(&str, &str, Option<SlowErrorKind>); 7] = [
    ("sun", "sun, up to 3 mW, turning", Some(SlowErrorKind::Offsets)),
    ("surface-heat", "3 mW on one sector, from half way", Some(SlowErrorKind::Offsets)),
    ("sky", "sky of 180 K, emissivity 0.13", Some(SlowErrorKind::Offsets)),
    ("drifts", "gain −5 %, R₀ +0.01 %, contact −20 %, one sector each", Some(SlowErrorKind::Both)),
    ("film", "gas and set-point 20 K warmer, film properties", None),
    ("buoyancy", "buoyancy on Mars, 0.3 to 2 m/s", None),
    ("stem", "stem cooled by the wind, and its wake", None),
];

/// A tenth of a turn in the time of the experiment.
const SLOW_SUN_S: f64 = 12_000.0;

/// What an effect does, over all specimens.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectFigures {
    /// What is otherwise.
    pub effect: String,
    /// Errors of direction, °.
    pub direction_rms_deg: Option<f64>,
    /// Errors of speed, as shares.
    pub speed_rms: Option<f64>,
    /// Their mean.
    pub speed_mean: Option<f64>,
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

/// What `anemo benchmark field` reports.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldReport {
    /// How many specimens were calibrated.
    pub specimens: u64,
    /// Effect by effect.
    pub effects: Vec<EffectFigures>,
}

/// Counts over all specimens.
#[derive(Debug, Clone, Default)]
struct EffectTally {
    errors: WindComparison,
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
        self.inconsistent.add(flags.has(QualityFlags::INCONSISTENT));
        let off_m_s = (f64::from(estimate.speed_m_s) - speed_m_s).abs();
        let off_rad = angle_deg(estimate.wind_m_s.map(f64::from), truth_m_s).to_radians();
        let is_beyond = off_m_s > BEYOND * f64::from(estimate.speed_error_m_s)
            || off_rad > BEYOND_OF_TWO * f64::from(estimate.direction_error_rad);
        self.unsaid.add(is_beyond && flags == QualityFlags::default());
    }

    fn figures(&self, effect: &str) -> EffectFigures {
        EffectFigures {
            effect: effect.to_owned(),
            direction_rms_deg: self.errors.direction_deg.rms(),
            speed_rms: self.errors.speed.rms(),
            speed_mean: self.errors.speed.mean(),
            inconsistent: self.inconsistent.share(),
            direction_coverage: self.errors.direction_coverage.share(),
            speed_coverage: self.errors.speed_coverage.share(),
            unsaid: self.unsaid.share(),
        }
    }
}

/// Measures all effects on so many specimens; `experiments` is the folder of those of the wind,
/// with those of the field beside it.
///
/// # Errors
/// What could not be run, identified or calibrated.
pub fn measure(experiments: &Path, specimens: u64, progress: &dyn Fn(&str)) -> Result<FieldReport, StudyError> {
    let quick = StudyLab::new(experiments.join("quick"), progress);
    let field = StudyLab::new(experiments.join("../field"), progress);
    let sun = field.experiment("sun")?;
    let gain = ElementDrift {
        element: "sector1".to_owned(),
        quantity: DriftQuantity::Gain,
        change: -0.05,
        start_s: 0.0,
        until_s: None,
    };
    let with = |title: &str, drifts: Vec<ElementDrift>| Experiment {
        title: title.to_owned(),
        field: FieldEffects { drifts, ..FieldEffects::default() },
        ..sun.clone()
    };
    let slow = Sun { period_s: Some(SLOW_SUN_S), ..sun.field.sun.ok_or_else(no_sun)? };
    let slow_sun = Experiment {
        title: "Sphere B: a slower sun".to_owned(),
        field: FieldEffects { sun: Some(slow), ..FieldEffects::default() },
        ..sun.clone()
    };
    let (offsets, gains) = (Some(SlowErrorKind::Offsets), Some(SlowErrorKind::Gains));
    let mut cases = vec![
        ("nothing".to_owned(), with("Sphere B: nothing is otherwise", Vec::new()), offsets),
        ("gain of one sector −5 %".to_owned(), with("Sphere B: a coating on one sector", vec![gain]), gains),
        ("sun, up to 3 mW, turning ten times slower".to_owned(), slow_sun, offsets),
    ];
    for (name, effect, kind) in EFFECTS {
        cases.push((effect.to_owned(), field.experiment(name)?, kind));
    }
    let mut tallies = vec![[EffectTally::default(), EffectTally::default()]; cases.len()];
    for seed in (SEED..).take(specimens as usize) {
        let head = calibrated(&quick, seed)?;
        for ((_, experiment, kind), tallies) in cases.iter().zip(&mut tallies) {
            let experiment = Experiment { seed, ..experiment.clone() };
            field.announce(&experiment);
            judge(&experiment, &head, *kind, tallies)?;
        }
    }
    let mut effects = Vec::new();
    for ((effect, _, kind), [as_it_is, corrected]) in cases.iter().zip(&tallies) {
        effects.push(as_it_is.figures(effect));
        if let Some(kind) = kind {
            effects.push(corrected.figures(&format!("… corrected: {}", kind.word())));
        }
    }
    Ok(FieldReport { specimens, effects })
}

/// A specimen from nothing to a calibrated head.
fn calibrated(quick: &StudyLab<'_>, seed: u64) -> Result<Head, StudyError> {
    let of = |name: &str| quick.experiment(name).map(|experiment| Experiment { seed, ..experiment });
    let records = SPHERE_B.elements.iter().map(|element| of(&format!("identify-{element}")));
    let model =
        chain::network_of(quick, records.collect::<Result<_, _>>()?, SPHERE_B.elements, PolesPerPair::default())?;
    let tunnel = of("tunnel")?;
    quick.announce(&tunnel);
    Ok(chain::calibrated(&tunnel, &model, TUNNEL_SETTLE_S)?.0)
}

fn no_sun() -> StudyError {
    StudyError::Other("the experiment `sun` of the field has no [sun]".to_owned())
}

/// Adds the estimates of an experiment, but for the beginnings of its winds: as they are, and
/// corrected.
fn judge(
    experiment: &Experiment,
    head: &Head,
    kind: Option<SlowErrorKind>,
    tallies: &mut [EffectTally; 2],
) -> Result<(), StudyError> {
    let axes = head.calibration.as_ref().map(|calibration| axes(head, calibration)).unwrap_or_default();
    let mut label = String::new();
    let mut from_s = 0.0;
    let mut each = |is_corrected: bool, moment: &Moment, estimate: &WindSample| {
        if label != moment.event {
            (label, from_s) = (moment.event.clone(), moment.time_s);
        }
        if let Some(truth_m_s) = moment.wind_m_s
            && moment.time_s - from_s >= SETTLE_S
        {
            tallies[usize::from(is_corrected)].add(estimate, &axes, truth_m_s);
        }
    };
    match kind {
        Some(kind) => blow_corrected(experiment, head, MODE, kind, &mut each),
        None => blow(experiment, head, &[MODE], &mut |_, moment, estimate| each(false, moment, estimate)),
    }
}

const TITLES: [&str; 6] =
    ["otherwise", "direction rms", "speed rms (mean)", "`inconsistent`", "95 % intervals: direction, speed", "unsaid"];

impl EffectFigures {
    fn cells(&self) -> [String; 6] {
        let percent = |share: Option<f64>, digits: usize| {
            share.map_or_else(|| "none".to_owned(), |share| format!("{:.digits$} %", 100.0 * share))
        };
        let mean = self.speed_mean.map_or_else(String::new, |mean| format!(" ({:+.1} %)", 100.0 * mean));
        [
            self.effect.clone(),
            self.direction_rms_deg.map_or_else(|| "none".to_owned(), |deg| format!("{deg:.2}°")),
            percent(self.speed_rms, 2) + &mean,
            percent(self.inconsistent, 1),
            format!("{}, {}", percent(self.direction_coverage, 0), percent(self.speed_coverage, 0)),
            percent(self.unsaid, 1),
        ]
    }
}

impl FieldReport {
    fn legend(&self) -> String {
        format!(
            "Sphere B, {}: identified and calibrated without any effect by `experiments/wind/quick`, judged in the winds of \
             `experiments/field` at {MODE}, {SETTLE_S} s after each change. *95 % intervals*: how many of estimates without a flag \
             hold the true value. *Unsaid*: estimates off by more than three standard uncertainties without a flag. \
             *Corrected*: the same by [`--field-correction`](../explanation/slow-errors.md).",
            count(self.specimens as usize, "specimen")
        )
    }

    /// The page of a day.
    pub fn page(&self, day: &str) -> String {
        let line = |cells: [String; 6]| format!("| {} |\n", cells.join(" | "));
        let rows: String = self.effects.iter().map(|of| line(of.cells())).collect();
        format!(
            "# Effects of the field\n\nBy `anemo benchmark field --specimens {}`, {day}. {}\n\n{}{}\n{rows}",
            self.specimens,
            self.legend(),
            line(TITLES.map(str::to_owned)),
            "|---".repeat(TITLES.len()) + "|"
        )
    }
}

impl fmt::Display for FieldReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for cells in std::iter::once(TITLES.map(|title| title.replace('`', "")))
            .chain(self.effects.iter().map(EffectFigures::cells))
        {
            let [effect, direction, speed, inconsistent, held, unsaid] = cells;
            writeln!(f, "{effect:<54} {direction:>13} {speed:>18} {inconsistent:>12} {held:>32} {unsaid:>7}")?;
        }
        writeln!(f, "\n{}", self.legend())
    }
}
