//! Slow errors in words and as JSON: how large they are, over time, and what the winds leave open.

use std::fmt;

use dr_core::wind::sphere::SECTORS;
use serde::Serialize;

use super::correction::{FieldCorrection, OverheatFinding, SlowErrorKind, open_errors};

/// Moments of the series.
const MOMENTS: usize = 24;
/// Errors of so many standard uncertainties, and of this share of the largest, are named.
const CLEAR: f64 = 3.0;
const NAMED: f64 = 0.2;

/// Report of slow errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlowErrorReport {
    /// Kind that was sought.
    pub kind: SlowErrorKind,
    /// The wind is corrected by it.
    pub is_applied: bool,
    /// Winds that said something.
    pub winds: usize,
    /// Time constant of offsets, s.
    pub time_constant_s: f64,
    /// Mean squares of what contradicts, over the variance by noise and calibration, without and
    /// with the errors.
    pub chi_square: [f64; 2],
    /// Finding of halves of alternating overheat, if they do.
    pub overheats: Option<OverheatFinding>,
    /// Explanation of as much, in words.
    pub as_likely: Option<String>,
    /// Errors of every surface.
    pub surfaces: Vec<SurfaceErrorReport>,
    /// Errors that the winds leave open, in words.
    pub open: Vec<String>,
    /// Offsets over time.
    pub series: Vec<SlowErrorMoment>,
}

/// Errors of one surface, mean over the winds that said something.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceErrorReport {
    /// Element.
    pub element: String,
    /// Heat that it takes up beside the wind, W, and its standard uncertainty.
    pub offset_w: f64,
    /// Standard uncertainty, W.
    pub offset_u_w: f64,
    /// Least and greatest, W.
    pub offset_range_w: [f64; 2],
    /// Change of its gain, as a share.
    pub gain_change: f64,
    /// Standard uncertainty.
    pub gain_change_u: f64,
    /// Least and greatest.
    pub gain_range: [f64; 2],
}

/// Offsets at a time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlowErrorMoment {
    /// s.
    pub time_s: f64,
    /// W.
    pub offset_w: [f64; SECTORS],
    /// Their standard uncertainties, W.
    pub offset_u_w: [f64; SECTORS],
}

impl SlowErrorReport {
    /// Report of a correction; `names` are the elements of the surfaces.
    pub fn of(correction: &FieldCorrection, names: &[String], is_applied: bool) -> Self {
        let known: Vec<_> = correction.known().collect();
        let count = known.len().max(1) as f64;
        let mean = |of: &dyn Fn(usize) -> f64| (0..known.len()).map(of).sum::<f64>() / count;
        let range = |of: &dyn Fn(usize) -> f64| {
            (0..known.len()).map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        };
        let surface = |(i, element): (usize, &String)| {
            let offset_w = |n: usize| 1e-3 * known[n].1.errors[i];
            // A factor of the conductance takes back what its gain has lost.
            let gain = |n: usize| 1.0 / (1.0 + 1e-2 * known[n].1.errors[SECTORS + i]) - 1.0;
            let deviation = |n: usize, error: usize| known[n].1.covariance[(error, error)].max(0.0).sqrt();
            SurfaceErrorReport {
                element: element.clone(),
                offset_w: mean(&offset_w),
                offset_u_w: mean(&|n| 1e-3 * deviation(n, i)),
                offset_range_w: range(&offset_w),
                gain_change: mean(&gain),
                gain_change_u: mean(&|n| 1e-2 * deviation(n, SECTORS + i)),
                gain_range: range(&gain),
            }
        };
        let step = known.len().div_ceil(MOMENTS).max(1);
        let series = known.iter().step_by(step).map(|(time_s, at)| SlowErrorMoment {
            time_s: *time_s,
            offset_w: core::array::from_fn(|i| 1e-3 * at.errors[i]),
            offset_u_w: core::array::from_fn(|i| 1e-3 * at.covariance[(i, i)].max(0.0).sqrt()),
        });
        Self {
            kind: correction.kind,
            is_applied: is_applied && correction.explains(),
            winds: correction.count,
            time_constant_s: correction.prior.time_s,
            chi_square: correction.chi_square,
            overheats: correction.overheats.clone(),
            as_likely: None,
            surfaces: names.iter().enumerate().map(surface).collect(),
            open: open_errors(&correction.prior, known.iter().map(|(_, at)| *at))
                .iter()
                .map(ToString::to_string)
                .collect(),
            series: if correction.kind == SlowErrorKind::Gains { Vec::new() } else { series.collect() },
        }
    }
}

impl SurfaceErrorReport {
    /// Its offset or gain in words, if there is one.
    fn words(&self, gains: bool, largest: f64, clear: f64) -> Option<String> {
        let (value, u, [least, most]) = match gains {
            false => (self.offset_w, self.offset_u_w, self.offset_range_w),
            true => (self.gain_change, self.gain_change_u, self.gain_range),
        };
        let size = least.abs().max(most.abs());
        if !(size > clear * u && size > NAMED * largest) {
            return None;
        }
        let (scale, unit, digits) = if gains { (1e2, "%", 1) } else { (1e3, "mW", 2) };
        // Digits that say something of the uncertainty.
        let digits = if u > 0.0 { (-libm::log10(scale * u).floor()).clamp(f64::from(digits), 4.0) as usize } else { 2 };
        let moves = most - least > CLEAR * u;
        let over =
            if moves { format!(" ({:.digits$} to {:.digits$})", scale * least, scale * most) } else { String::new() };
        let what = if gains { "gain" } else { "heat" };
        let element = &self.element;
        Some(format!("{what} of `{element}` {:+.digits$} ± {:.digits$} {unit}{over}", scale * value, scale * u))
    }
}

impl SlowErrorReport {
    /// Errors that are clear, a comma between them.
    pub fn words(&self) -> String {
        let size = |[least, most]: [f64; 2]| least.abs().max(most.abs());
        let offsets = self.surfaces.iter().map(|of| size(of.offset_range_w)).fold(0.0, f64::max);
        let gains = self.surfaces.iter().map(|of| size(of.gain_range)).fold(0.0, f64::max);
        let mut words = Vec::new();
        for of in &self.surfaces {
            // A corrected error is named, clear or not: what all surfaces share makes each unclear.
            let clear = if self.is_applied { 0.0 } else { CLEAR };
            words.extend(of.words(false, offsets, clear));
            words.extend(of.words(true, gains, clear));
        }
        words.join(", ")
    }
}

impl fmt::Display for SlowErrorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let option = self.kind.word();
        let [before, after] = self.chi_square;
        let list = self.words();
        if let Some(OverheatFinding { overheat_k: [high_k, low_k], halves, chi_square: [without, with], .. }) =
            &self.overheats
        {
            writeln!(
                f,
                "{halves} halves at overheats of {high_k:.1} and {low_k:.1} K: differences, χ² {without:.1} without and {with:.1} with heat; \
                 gains do not show in them"
            )?;
        }
        if list.is_empty() {
            return writeln!(
                f,
                "no slow error is clear in {} slots of wind: nothing to correct by `{option}`; where estimates are `inconsistent`, --bandwidth \
                 0.5 shows more than a wider one",
                self.winds
            );
        }
        let squares = format!("χ² {before:.1} before and {after:.1} after");
        if self.is_applied {
            writeln!(f, "corrected: {list}; contradictions, {squares}")?;
        } else {
            writeln!(f, "contradictions explained: {list}; {squares}, with --field-correction {option}")?;
        }
        if let Some(other) = self.as_likely.as_ref().filter(|other| !other.is_empty()) {
            writeln!(f, "as likely: {other}; winds of more directions and speeds would say which")?;
        }
        if !self.open.is_empty() {
            writeln!(f, "left open by these winds, and not corrected: {}", self.open.join(", "))?;
        }
        Ok(())
    }
}
