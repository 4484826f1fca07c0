//! Weighted least squares for all unknowns at once: Gauss–Newton, damped after Levenberg and
//! Marquardt.
//!
//! A step is that of the linear equations with γ ≥ 0 and κ ≥ 0 kept exactly (Lawson and Hanson). It
//! is taken if the cost falls. It ends where an undamped step would lower the cost by less than
//! `SMALL` standard errors squared. It descends twice: `FIRST` from afar, to find the mounting, and
//! then with the weights of the readings (`LAST`).
//!
//! Smooth amplitudes do not follow every bend of the true ones. What they leave is most where the
//! weights are, in the lee, and alike on all surfaces of a wind. The covariance is therefore that
//! of the winds' own scatter, each wind left out once (J. G. MacKinnon and H. White,
//! J. Econometrics 29 (1985) 305); of quiescent gas, whose Nu is known, that of its noise:
//!
//! ```text
//! cov = C (Σ g gᵀ) C       C = H⁻¹, sum over the winds
//! g = Xᵀ (1 − X C Xᵀ)⁻¹ e  of the rows X and residuals e of a wind
//! ```
//!
//! Weights are those of the readings: the solution does not depend on the misfit.
//!
//! A calibration in a word, by what its model leaves of the readings.
//!
//! The bounds are the tunnel's: speeds of a good one are known to 0.5 %, of an ordinary one to 2 %,
//! and the convective power goes as the speed to the power of 0.3 to 0.4.

use diffusive::identify::nonnegative;
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::Serialize;

use super::super::steady_wind::CalibrateError;
use super::equations::{FIRST, FitPoint, FitStage, LAST, SurfaceEquations, SurfaceProblem};

const DAMPING: f64 = 1e-2;
const MOST_STEPS: usize = 200;
/// Far below one standard error, and above what the f32 means of the surfaces make of the cost.
const SMALL: f64 = 1e-3;
/// The same where no step pays any more: dr-core's means and streams are f32, whose rounding the
/// cost has, too.
const ROUNDED: f64 = 0.5;
/// The same where the stream is sought: all of it is f32.
const ROUNDED_OF_STREAM: f64 = 5.0;
/// Damping at which a step is too short to be one.
const MOST_DAMPING: f64 = 1e8;
const LEAST_DAMPING: f64 = 1e-9;
/// No head is made worse than this.
const LIKELY_GAINS: std::ops::Range<f64> = 0.2..5.0;

/// Exponents of laminar layers and wires lie about 0.5.
const LIKELY_EXPONENTS: std::ops::Range<f64> = 0.1..1.3;

/// A solution and how sure it is.
pub struct SurfaceFit {
    /// The solution.
    pub place: FitPoint,
    /// The equations there.
    pub equations: SurfaceEquations,
    /// Covariance of the unknowns, misfit included; zero for a γ that stands at zero.
    pub covariance: DMatrix<f64>,
    /// Readings less what of the unknowns they determine.
    pub degrees_of_freedom: f64,
}

/// King's law as it was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FittedKing {
    /// m
    pub exponent: f64,
    /// Standard uncertainty of m; zero where it was given.
    pub se_exponent: f64,
    /// k, of wires.
    pub yaw_factor: Option<f64>,
    /// Standard uncertainty of k.
    pub se_yaw_factor: Option<f64>,
}

/// Fits all unknowns.
///
/// # Errors
/// If no minimum is found.
pub fn fit(problem: &SurfaceProblem<'_>) -> Result<SurfaceFit, CalibrateError> {
    fit_from(problem, problem.drawn())
}

/// Fits all unknowns, from a point near the head as drawn.
///
/// # Errors
/// If no minimum is found.
pub fn fit_from(problem: &SurfaceProblem<'_>, start: FitPoint) -> Result<SurfaceFit, CalibrateError> {
    let first = descend(problem, start, FIRST).ok_or(CalibrateError::NoMinimum)?;
    let mut place = descend(problem, first, LAST).ok_or(CalibrateError::NoMinimum)?;
    place.mounting = place.mounting.smallest();
    let equations = problem.equations(&place, LAST);
    let covariance = covariance(problem, &place, &equations).ok_or(CalibrateError::NoMinimum)?;
    let determined = (&covariance * &equations.of_readings).trace();
    let degrees_of_freedom = equations.residuals.len() as f64 - determined;
    let scatter = scatter(problem, &equations, &covariance).ok_or(CalibrateError::NoMinimum)?;
    let covariance = &covariance * scatter * &covariance;
    Ok(SurfaceFit { place, equations, covariance, degrees_of_freedom })
}

/// Down from a place to where an undamped step would not pay.
fn descend(problem: &SurfaceProblem<'_>, mut place: FitPoint, stage: FitStage) -> Option<FitPoint> {
    let mut here = problem.equations(&place, stage);
    let mut damping = DAMPING;
    let mut is_near = false;
    for _ in 0..MOST_STEPS {
        let step = step(problem, &place, &here, damping);
        let there = problem.moved(&place, &step);
        let promised = 2.0 * here.b.dot(&step) - (&here.h * &step).dot(&step);
        let sane = there.gains.iter().all(|c| LIKELY_GAINS.contains(c))
            && LIKELY_EXPONENTS.contains(&there.law.exponent)
            && (0.0..=1.0).contains(&there.law.yaw_square)
            && step.iter().all(|x| x.is_finite())
            && problem.has_stream(&there);
        let next = sane.then(|| problem.equations(&there, stage)).filter(|next| next.cost < here.cost);
        // Readings that scatter by more than they say have a larger standard error.
        let scatter = (here.cost / here.residuals.len() as f64).max(1.0);
        // Tenfold and a tenth of it do not bring a damping back to the bit.
        let is_free = damping < 2.0 * DAMPING;
        let done = is_free && promised < SMALL * scatter;
        let rounded = if place.stream.is_empty() { ROUNDED } else { ROUNDED_OF_STREAM };
        is_near = if is_free { promised < rounded * scatter } else { is_near };
        match next {
            Some(next) => {
                (place, here) = (there, next);
                damping = (damping * 0.1).max(LEAST_DAMPING);
            }
            None => damping *= 10.0,
        }
        if done {
            return Some(place);
        }
        if damping > MOST_DAMPING {
            return is_near.then_some(place);
        }
    }
    None
}

/// (H + λ diag H) δ = b with γ + δ ≥ 0, in units in which diag H is one.
fn step(problem: &SurfaceProblem<'_>, place: &FitPoint, at: &SurfaceEquations, damping: f64) -> DVector<f64> {
    let m = at.b.len();
    let unit = DVector::from_fn(m, |k, _| at.h[(k, k)].sqrt().max(f64::MIN_POSITIVE).recip());
    let mut h = DMatrix::from_fn(m, m, |i, j| at.h[(i, j)] * unit[i] * unit[j]);
    for k in 0..m {
        h[(k, k)] += damping;
    }
    let mut now = DVector::zeros(m);
    let mut positive = vec![false; m];
    for (k, value) in problem.not_negative(place) {
        now[k] = value / unit[k];
        positive[k] = true;
    }
    let b = at.b.component_mul(&unit) + &h * &now;
    (nonnegative::solve(&h, &b, &positive) - now).component_mul(&unit)
}

/// Σ g gᵀ, and the same of the prior.
fn scatter(problem: &SurfaceProblem<'_>, at: &SurfaceEquations, inverse: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (m, n) = (at.b.len(), problem.head.surfaces.len());
    // The prior scatters as its standard errors say.
    let mut scatter = &at.h - &at.of_readings;
    for (w, wind) in problem.winds.iter().enumerate() {
        let rows = DMatrix::from_fn(n, m, |i, k| at.rows[n * w + i][k]);
        if wind.is_quiescent() {
            scatter += rows.tr_mul(&rows);
            continue;
        }
        let residuals = DVector::from_column_slice(&at.residuals[n * w..n * (w + 1)]);
        let left = DMatrix::identity(n, n) - &rows * inverse * rows.transpose();
        let part = rows.tr_mul(&left.lu().solve(&residuals)?);
        scatter += &part * part.transpose();
    }
    Some(scatter)
}

fn covariance(problem: &SurfaceProblem<'_>, place: &FitPoint, at: &SurfaceEquations) -> Option<DMatrix<f64>> {
    let m = at.b.len();
    let first = problem.first_quiescent();
    let held = |k: usize| k.checked_sub(first).and_then(|i| place.quiescent.get(i)).is_some_and(|still| *still <= 0.0);
    let free: Vec<usize> = (0..m).filter(|&k| !held(k)).collect();
    let unit: Vec<f64> = free.iter().map(|&k| at.h[(k, k)].sqrt().recip()).collect();
    let h = DMatrix::from_fn(free.len(), free.len(), |i, j| at.h[(free[i], free[j])] * unit[i] * unit[j]);
    let inverse = Cholesky::new(h)?.inverse();
    let mut covariance = DMatrix::zeros(m, m);
    for (i, &k) in free.iter().enumerate() {
        for (j, &l) in free.iter().enumerate() {
            covariance[(k, l)] = inverse[(i, j)] * unit[i] * unit[j];
        }
    }
    Some(covariance)
}

/// Misfit up to which a calibration is good: 0.5 % of speed.
const GOOD: f64 = 2e-3;
/// Misfit up to which it is fair: 2 to 3 % of speed.
const FAIR: f64 = 1e-2;
/// Advice on a poor one.
pub const ADVICE: &str =
    "check labels and frame of the winds, the order of the surfaces, and what stands in the stream";

/// Grade of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CalibrationGrade {
    /// The misfit is less than what tunnels know of their speeds.
    Good,
    /// The misfit is that of an ordinary tunnel.
    Fair,
    /// No tunnel explains the misfit.
    Poor,
}

impl CalibrationGrade {
    /// Grade of a misfit over the convective power, rms.
    pub fn of(misfit_rms: f64) -> Self {
        match misfit_rms {
            misfit if misfit <= GOOD => Self::Good,
            misfit if misfit <= FAIR => Self::Fair,
            _ => Self::Poor,
        }
    }

    /// In a word and its meaning.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Self::Good => ["good", "the misfit is less than 0.5 % of speed; standard uncertainties include it"],
            Self::Fair => [
                "fair",
                "the misfit is up to 3 % of speed, as much as an ordinary tunnel's speeds are off; look at the worst wind",
            ],
            Self::Poor => ["poor", "the misfit is more than 3 % of speed"],
        }
    }
}
