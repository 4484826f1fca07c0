//! Drift: an offset that moves, because the room does, as a disturbance with a state of its own.
//!
//! ```text
//! y_n = offset + Σ_k R_k x_k(t_n) + d_n + e_n,        e white
//! ```
//!
//! | kind | d | its future |
//! |---|---|---|
//! | random walk | increments without memory | its last level is held |
//! | integrated walk | slope with such increments | its last level is held |
//! | correlated | returns to the offset within a correlation time | it decays |
//!
//! Any of them beside white noise has innovations that a filter of one or two sections gives, so
//! that generalised least squares is ordinary least squares on filtered columns:
//!
//! ```text
//! v = Π_i (1 − φ_i L)/(1 − ϑ_i L) (y − Aθ),     ϑ_i = e^(−ξ_i Ts),  φ_i = e^(−ζ_i Ts),  ζ < ξ
//! ```
//!
//! φ = 1 is a walk, whose level is found from the last 1/ξ of rows; φ < 1 returns at the rate ζ.
//! Two sections with one of the zeros between the poles are one whose pole lies between
//! (`sections`).
//!
//! No row is filtered. The mean E of what a column was, weighed by ϑ^j, is a column too, since a
//! relaxation of a relaxation is a sum of two ([`columns`]); only the means of the outputs are read
//! beside them. One reading serves filters of every size, memory does not grow with the record, and
//! sums of its parts are added up. Which filter follows from the marginal likelihood
//! ([`mod@search`]).
//!
//! (G. E. P. Box and G. M. Jenkins, *Time Series Analysis*, 1970, ARIMA(0,1,1) and (0,2,2); A. C.
//! Harvey, *Forecasting, Structural Time Series Models and the Kalman Filter*, 1989.)
//!
//! Limits: the filter is the steady state's. At the first row, where nothing is known of the level,
//! the offset stands for it.

pub mod columns;
pub mod filter;
pub mod search;
mod tracker;

pub use columns::PoleColumns;
pub use filter::{NoiseFilter, RunningFilter, Section};
pub use tracker::{ChosenDrift, DriftTracker};

/// Poles a decade that filters may have.
const POLES_PER_DECADE: f64 = 2.0;
/// Least rate of a pole, in units of one over the record's length: a level that a quarter of the
/// record tells.
const SLOWEST: f64 = 4.0;

/// Whether the offset may move.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum DriftGiven {
    /// If the record shows it: kind and size of most evidence.
    #[default]
    Auto,
    /// The offset stands, and one candidate is taken.
    None,
    /// It moves, as this kind of process; its size has most evidence.
    Kind(DriftKind),
}

/// Kinds of drift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriftKind {
    /// Level without a memory of where it belongs.
    RandomWalk,
    /// Slope without such a memory.
    IntegratedWalk,
    /// Level that returns.
    Correlated,
}

impl DriftKind {
    /// All, the plainest first.
    pub const ALL: [Self; 3] = [Self::RandomWalk, Self::IntegratedWalk, Self::Correlated];

    /// As on the command line and in a model file.
    pub fn name(self) -> &'static str {
        match self {
            Self::RandomWalk => "random-walk",
            Self::IntegratedWalk => "integrated-walk",
            Self::Correlated => "correlated",
        }
    }
}

/// Rates of the poles that filters may have beside a mesh, each in the middle between two of its
/// rates: a filter cannot have a pole where a column has one.
pub fn poles(mesh_rad_s: &[f64], duration_s: f64, sample_period_s: f64) -> Vec<f64> {
    let (least, most) = (SLOWEST / duration_s, std::f64::consts::PI / sample_period_s);
    let middles = mesh_rad_s.windows(2).map(|two| (two[0] * two[1]).sqrt());
    let mut poles: Vec<f64> = Vec::new();
    let apart = libm::pow(10.0, 0.9 / POLES_PER_DECADE);
    for rate in middles.filter(|rate| (least..=most).contains(rate)) {
        if poles.last().is_none_or(|last| rate >= apart * last) {
            poles.push(rate);
        }
    }
    poles
}
