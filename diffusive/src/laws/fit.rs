//! The one driver that fits every law: variable projection.
//!
//! ```text
//! minimise over p   min_a ‖y − Φ(p) a‖²
//! H = Dᵀ(1 − P)D,   b = Dᵀ(1 − P)y,   D = Σ_i a_i ∂φ_i/∂p
//! ```
//!
//! P projects on the columns Φ. Gains, decays and the rest value a are solved for at all shapes p
//! (G. H. Golub and V. Pereyra 1973, *SIAM J. Numer. Anal.* 10, 413, with the slope of L. Kaufman
//! 1975, *BIT* 15, 49), so that only shapes are searched, by [damped descent](crate::optimise).
//!
//! Limits: the best of the minima next to its starts. Two exponentials do not come closer than
//! refined rates do.

use nalgebra::{DMatrix, DVector};

use super::law::{ResponseLaw, ShapeRange};
use super::products::LawColumns;
use super::stream::InputStream;
use crate::identify::normal_equations::NormalEquations;
use crate::identify::refine::LEAST_RATIO;
use crate::optimise::{DampingRule, damped_step};

const RULE: DampingRule = DampingRule { start: 1e-3, eased: |l| 0.1 * l, raised: |l| 10.0 * l.max(1e-6), most: 1e6 };
/// Steps of a descent, at most.
const MOST_STEPS: usize = 40;
/// Starts from which a descent goes on: those of least error.
const DESCENTS: usize = 3;
/// Of a shape's logarithm: a smaller step ends the search, a longer one is cut.
const SETTLED: f64 = 1e-7;
const LONGEST_STEP: f64 = 1.5;
/// Relative to the squares of the output: squared errors are not known better.
const ROUNDING: f64 = 1e-13;

/// A law with its numbers.
#[derive(Debug, Clone)]
pub struct LawFit {
    pub law: ResponseLaw,
    /// Logarithms of τ and β, term by term.
    pub shapes: Vec<f64>,
    /// Gain and decay of each term, then the rest value.
    pub weights: DVector<f64>,
    /// Which shapes lie at an edge of what the record shows.
    pub at_edge: Vec<bool>,
}

impl LawFit {
    /// The output at all rows of a stream, of which the fitted ones are the first.
    pub fn predicted(&self, stream: &InputStream, sample_period_s: f64) -> Vec<f64> {
        LawColumns::of(self.law, &self.shapes, stream, sample_period_s).weighed(&self.weights)
    }
}

/// What is fitted: an input and an output, NaN where it is missing.
pub struct FitProblem {
    pub stream: InputStream,
    pub sample_period_s: f64,
    /// The output, less its mean.
    y: Vec<f64>,
    mean: f64,
    rows: f64,
    range: ShapeRange,
}

/// One place of the search.
#[derive(Debug, Clone)]
struct ShapePoint {
    shapes: Vec<f64>,
    weights: DVector<f64>,
    squares: f64,
    h: DMatrix<f64>,
    b: DVector<f64>,
}

impl FitProblem {
    pub fn new(input: &[f64], output: &[f64], sample_period_s: f64) -> Self {
        let known = || output.iter().filter(|y| !y.is_nan());
        let rows = known().count() as f64;
        let mean = known().sum::<f64>() / rows;
        let range = ShapeRange::of(input.len() as f64 * sample_period_s, sample_period_s);
        let y = output.iter().map(|y| y - mean).collect();
        Self { stream: InputStream::new(input), sample_period_s, y, mean, rows, range }
    }

    /// Fits a law. `shorter` are the shapes of a sum of one exponential less.
    pub fn fit(&self, law: ResponseLaw, shorter: &[f64]) -> Option<LawFit> {
        let bounds: Vec<(f64, f64)> = law.kernels().into_iter().flat_map(|kernel| self.range.bounds(kernel)).collect();
        let mut places: Vec<ShapePoint> =
            law.starts(self.range, shorter).into_iter().filter_map(|shapes| self.place(law, shapes)).collect();
        places.sort_by(|a, b| a.squares.total_cmp(&b.squares));
        places.truncate(DESCENTS);
        let ends = places.into_iter().map(|place| self.descend(law, place, &bounds));
        let best = ends.min_by(|a, b| a.squares.total_cmp(&b.squares))?;
        let mut weights = best.weights;
        let last = weights.len() - 1;
        weights[last] += self.mean;
        let near = |(shape, (low, high)): (&f64, &(f64, f64))| shape - low < 1e-6 || high - shape < 1e-6;
        let at_edge = best.shapes.iter().zip(&bounds).map(near).collect();
        Some(LawFit { law, shapes: best.shapes, weights, at_edge })
    }

    fn descend(&self, law: ResponseLaw, mut place: ShapePoint, bounds: &[(f64, f64)]) -> ShapePoint {
        let mut damping = RULE.start;
        for _ in 0..MOST_STEPS {
            let free = free_shapes(&place, bounds);
            if free.is_empty() {
                break;
            }
            let h = place.h.select_rows(&free).select_columns(&free);
            let b = place.b.select_rows(&free);
            let lower = |damping: f64| {
                let step = damped_step(&h, &b, damping)?;
                let mut shapes = place.shapes.clone();
                for (&at, step) in free.iter().zip(step.iter()) {
                    let (low, high) = bounds[at];
                    shapes[at] = (shapes[at] + step.clamp(-LONGEST_STEP, LONGEST_STEP)).clamp(low, high);
                }
                let next = self.place(law, shapes)?;
                (next.squares < place.squares).then_some(next)
            };
            let Some(next) = RULE.first_that_pays(&mut damping, lower) else { break };
            let moved = next.shapes.iter().zip(&place.shapes).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let fell = place.squares - next.squares;
            place = next;
            if moved < SETTLED || fell < ROUNDING * self.y_squares() {
                break;
            }
        }
        place
    }

    fn y_squares(&self) -> f64 {
        self.y.iter().filter(|y| !y.is_nan()).map(|y| y * y).sum()
    }

    /// The law at these shapes; `None` where two exponentials are one, or nothing can be computed.
    fn place(&self, law: ResponseLaw, mut shapes: Vec<f64>) -> Option<ShapePoint> {
        if let ResponseLaw::Exponentials(_) = law {
            shapes.sort_by(f64::total_cmp);
            if shapes.windows(2).any(|pair| pair[1] - pair[0] < LEAST_RATIO.ln()) {
                return None;
            }
        }
        let columns = LawColumns::of(law, &shapes, &self.stream, self.sample_period_s);
        let products = columns.products(&self.y);
        let (linear, slopes) = (columns.linear.len(), columns.slopes.len());
        let last = products.ncols() - 1;
        let equations = |b: DVector<f64>| NormalEquations {
            g: products.view((0, 0), (linear, linear)).into_owned(),
            b,
            yy: products[(last, last)],
            rows: self.rows,
        };
        let free = DMatrix::zeros(linear, linear);
        let own = equations(products.view((0, last), (linear, 1)).column(0).into_owned());
        let weights = own.estimate(&free, None);
        let squares = own.squared_error(&weights);
        // Slopes of the whole sum: those of a term's answer and decay with its gain and decay.
        let mut of_shape = DMatrix::zeros(slopes, shapes.len());
        let terms = law.kernels().into_iter().enumerate().flat_map(|(term, kernel)| vec![term; kernel.shapes()]);
        for (shape, term) in terms.enumerate() {
            of_shape[(2 * shape, shape)] = weights[2 * term];
            of_shape[(2 * shape + 1, shape)] = weights[2 * term + 1];
        }
        let among = products.view((linear, linear), (slopes, slopes)) * &of_shape;
        let with_linear = products.view((0, linear), (linear, slopes)) * &of_shape;
        let with_y = of_shape.tr_mul(&products.view((linear, last), (slopes, 1)));
        let mut h = of_shape.tr_mul(&among);
        for shape in 0..shapes.len() {
            let explained = equations(with_linear.column(shape).into_owned()).estimate(&free, None);
            let taken = with_linear.tr_mul(&explained);
            h.column_mut(shape).axpy(-1.0, &taken, 1.0);
        }
        let b = with_y.column(0) - with_linear.tr_mul(&weights);
        let is_finite = squares.is_finite() && h.iter().chain(b.iter()).all(|entry| entry.is_finite());
        is_finite.then_some(ShapePoint { shapes, weights, squares, h, b })
    }
}

/// Shapes that are not held at a bound beyond which the descent would lead.
fn free_shapes(place: &ShapePoint, bounds: &[(f64, f64)]) -> Vec<usize> {
    let is_held = |at: usize| {
        let (low, high) = bounds[at];
        (place.shapes[at] <= low && place.b[at] < 0.0) || (place.shapes[at] >= high && place.b[at] > 0.0)
    };
    (0..bounds.len()).filter(|&at| !is_held(at)).collect()
}
