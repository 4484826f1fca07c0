//! Convection of a sphere in a calibration, and the unknowns of the stream that it meets: the rise
//! of the gas that it warms, and what is behind its stem.
//!
//! The equations of the stream stand in [`FreeStream`]; a calibration seeks their constants beside
//! all others, by winds that it knows. Known before, with standard errors:
//!
//! | of | value | standard error |
//! |---|---|---|
//! | a, b of the rise | 0.6, 1.2: forced and free convection of a sphere | as large |
//! | F − 1, E of the stem | 0 | 0.3, 0.4 |
//! | second differences of F, E | 0 | 0.05 |

use dr_core::wind::free_stream::STEM_KNOTS;
use dr_core::wind::{FreeStream, RiseConfig, StemConfig};

/// a and b before any reading.
const RISE: [f64; 2] = [0.6, 1.2];
const STEM_ERRORS: [f64; 2] = [0.3, 0.4];
const BEND_ERROR: f64 = 0.05;
/// Step of derivatives.
const STEP: f64 = 0.01;

/// Convection of a sphere, and what is sought of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SoughtConvection {
    /// Share of the way from the gas to the surfaces at which the properties of the gas are taken.
    pub film_share: f64,
    /// The Nusselt number at rest is sought.
    pub is_rest_sought: bool,
    /// Gravity, m/s², and where up is, if the rise of the warmed gas is sought.
    pub rise: Option<Gravity>,
    /// Outward along the stem, if what is behind it is sought.
    pub stem: Option<[f64; 3]>,
    /// Quiescent gas is left out, since it contradicts the winds.
    pub is_without_quiescent: bool,
}

/// Gravity in the tunnel's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// m/s²; 0 where nothing rises.
    pub m_s2: f64,
    /// Direction that points up.
    pub up: [f64; 3],
}

impl SoughtConvection {
    /// The unknowns as they are taken before any reading: a, b, F, E.
    pub fn start(&self) -> Vec<f64> {
        let mut start = Vec::new();
        if self.rise.is_some() {
            // A slope a b of less than one.
            start.extend([0.5, 1.0]);
        }
        if self.stem.is_some() {
            start.extend([1.0; STEM_KNOTS]);
            start.extend([0.0; STEM_KNOTS]);
        }
        start
    }

    /// Number of those of the rise, which are first and not negative.
    pub fn of_rise(&self) -> usize {
        2 * usize::from(self.rise.is_some())
    }

    /// The stream of these unknowns; none if they make one of two winds.
    pub fn free_stream(&self, unknowns: &[f64]) -> Option<FreeStream> {
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        let rise = self.rise.map(|gravity| RiseConfig {
            gravity_m_s2: gravity.m_s2 as f32,
            up: narrow(gravity.up),
            // Zero to rounding, where they stand at it.
            at_rest: unknowns[0].max(0.0) as f32,
            decay: unknowns[1].max(0.0) as f32,
        });
        let stem = self.stem.map(|axis| {
            let (factor, deflection) = self.stem_map(unknowns);
            let axis = narrow(axis);
            StemConfig {
                axis,
                unknown_chord: 0.0,
                factor: factor.map(|x| x as f32),
                deflection: deflection.map(|x| x as f32),
            }
        });
        FreeStream::new(rise, stem).ok()
    }

    /// F and E among the unknowns.
    pub fn stem_map(&self, unknowns: &[f64]) -> ([f64; STEM_KNOTS], [f64; STEM_KNOTS]) {
        let first = self.of_rise();
        let of = |from: usize| std::array::from_fn(|k| unknowns[from + k]);
        (of(first), of(first + STEM_KNOTS))
    }

    /// Streams with one unknown each moved by a step, over which their difference is to be divided.
    pub fn moved(&self, unknowns: &[f64]) -> Vec<(FreeStream, f64)> {
        let step = |k: usize, by: f64| {
            let mut there = unknowns.to_vec();
            there[k] += by;
            self.free_stream(&there).map(|stream| (stream, by))
        };
        let any = |k: usize| step(k, STEP).or_else(|| step(k, -STEP));
        (0..unknowns.len()).map(|k| any(k).unwrap_or((FreeStream::default(), f64::INFINITY))).collect()
    }

    /// Prior knowledge: rows of (place, factor) with the value that their sum has, each with a
    /// standard error of one.
    pub fn prior(&self) -> Vec<(Vec<(usize, f64)>, f64)> {
        let mut rows: Vec<(Vec<(usize, f64)>, f64)> = Vec::new();
        if self.rise.is_some() {
            rows.extend(RISE.iter().enumerate().map(|(k, value)| (vec![(k, 1.0 / value)], 1.0)));
        }
        if self.stem.is_some() {
            let first = self.of_rise();
            for (from, beyond, error) in [(first, 1.0, STEM_ERRORS[0]), (first + STEM_KNOTS, 0.0, STEM_ERRORS[1])] {
                for k in 0..STEM_KNOTS {
                    rows.push((vec![(from + k, 1.0 / error)], beyond / error));
                    // The map is even, and none beyond its last knot.
                    let below = from + if k == 0 { 1 } else { k - 1 };
                    let mut bend = vec![(below, 1.0 / BEND_ERROR), (from + k, -2.0 / BEND_ERROR)];
                    let mut value = 0.0;
                    if k + 1 < STEM_KNOTS {
                        bend.push((from + k + 1, 1.0 / BEND_ERROR));
                    } else {
                        value = -beyond / BEND_ERROR;
                    }
                    rows.push((bend, value));
                }
            }
        }
        rows
    }
}
