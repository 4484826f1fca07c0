//! The laws: which terms each has, within which bounds its shapes lie, and where its search starts.

use std::f64::consts::PI;

use dr_core::model::mesh;

use super::kernel::StepKernel;

/// Time constants of a start: so many from the shortest to the record's length.
const GRID: usize = 8;
/// Exponents of a start.
const EXPONENTS: [f64; 3] = [0.3, 0.5, 0.8];
/// A time constant so many times the fitted part is the same to it as a longer one.
const LONGEST: f64 = 100.0;
/// The least exponent.
const LEAST_EXPONENT: f64 = 0.05;

/// A law of response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseLaw {
    /// A sum of so many exponentials, one to four.
    Exponentials(usize),
    /// The stretched exponential of Kohlrausch.
    Stretched,
    /// The square root of time.
    SquareRoot,
}

impl ResponseLaw {
    /// All that are compared, in the order of the table. A sum of exponentials follows the shorter
    /// one from which its search starts.
    pub const ALL: [Self; 6] = [
        Self::Exponentials(1),
        Self::Exponentials(2),
        Self::Exponentials(3),
        Self::Exponentials(4),
        Self::Stretched,
        Self::SquareRoot,
    ];

    /// What the law is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exponentials(1) => "one exponential",
            Self::Exponentials(2) => "two exponentials",
            Self::Exponentials(3) => "three exponentials",
            Self::Exponentials(_) => "four exponentials",
            Self::Stretched => "stretched exponential",
            Self::SquareRoot => "square root of time",
        }
    }

    /// Its terms.
    pub fn kernels(self) -> Vec<StepKernel> {
        match self {
            Self::Exponentials(count) => vec![StepKernel::Exponential; count],
            Self::Stretched => vec![StepKernel::Stretched],
            Self::SquareRoot => vec![StepKernel::SquareRoot],
        }
    }

    /// How many numbers are fitted: shapes, a gain and a decay for each term, the rest value.
    pub fn numbers(self) -> usize {
        let kernels = self.kernels();
        kernels.iter().map(|kernel| kernel.shapes() + 2).sum::<usize>() + 1
    }

    /// Where the search starts: shapes term by term. `shorter` are those that were found for a sum
    /// of one exponential less.
    pub fn starts(self, range: ShapeRange, shorter: &[f64]) -> Vec<Vec<f64>> {
        let grid = range.grid();
        match self {
            Self::Exponentials(_) => grid
                .map(|ln_tau| {
                    let mut start: Vec<f64> = shorter.iter().copied().chain([ln_tau]).collect();
                    start.sort_by(f64::total_cmp);
                    start
                })
                .collect(),
            Self::Stretched => grid.flat_map(|ln_tau| EXPONENTS.map(|exponent| vec![ln_tau, exponent.ln()])).collect(),
            Self::SquareRoot => vec![Vec::new()],
        }
    }
}

/// Which time constants a record shows anything of, as logarithms of s.
#[derive(Debug, Clone, Copy)]
pub struct ShapeRange {
    shortest: f64,
    duration: f64,
}

impl ShapeRange {
    /// Of a record of that length and sample period.
    pub fn of(duration_s: f64, sample_period_s: f64) -> Self {
        let (_, fastest_rad_s) = mesh::thesis_edges_rad_s(duration_s, sample_period_s, 1);
        Self { shortest: (1.0 / fastest_rad_s).ln(), duration: duration_s.ln() }
    }

    fn grid(self) -> impl Iterator<Item = f64> {
        // Time constants of a row or less are found from longer ones, if they are there.
        let first = self.shortest + PI.ln();
        (0..GRID).map(move |k| first + (self.duration - first) * (k as f64 + 0.5) / GRID as f64)
    }

    /// Bounds of each of a kernel's shapes.
    pub fn bounds(self, kernel: StepKernel) -> Vec<(f64, f64)> {
        let both = [(self.shortest, self.duration + LONGEST.ln()), (LEAST_EXPONENT.ln(), 0.0)];
        both[..kernel.shapes()].to_vec()
    }
}
