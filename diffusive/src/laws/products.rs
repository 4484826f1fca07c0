//! The columns of a law at given shapes, and the products of all of them.
//!
//! ```text
//! [v_1, D_1, …, 1 | ∂v_1/∂p, ∂D_1/∂p, … | y]
//! ```
//!
//! v_i is the answer of term i to the input from rest, D_i its decay from the first row.

use nalgebra::{DMatrix, DVector};

use super::kernel::{StepAnswer, StepKernel};
use super::law::ResponseLaw;
use super::stream::InputStream;

/// Rows of a panel, which fit in a fast cache with all columns.
const PANEL: usize = 512;

/// Columns of a law, row by row.
pub struct LawColumns {
    /// Two a term, then a column of ones.
    pub linear: Vec<Vec<f64>>,
    /// Two a shape: of the answer and of the decay.
    pub slopes: Vec<Vec<f64>>,
}

impl LawColumns {
    pub fn of(law: ResponseLaw, shapes: &[f64], stream: &InputStream, sample_period_s: f64) -> Self {
        let mut columns = Self { linear: Vec::new(), slopes: Vec::new() };
        let mut shapes = shapes;
        for kernel in law.kernels() {
            let (own, others) = shapes.split_at(kernel.shapes());
            columns.add(kernel, own, stream, sample_period_s);
            shapes = others;
        }
        columns.linear.push(vec![1.0; stream.rows()]);
        columns
    }

    fn add(&mut self, kernel: StepKernel, shapes: &[f64], stream: &InputStream, sample_period_s: f64) {
        if kernel == StepKernel::Exponential {
            let both = [InputStream::relaxation, InputStream::decay];
            for [values, slopes] in both.map(|column| column(stream, shapes[0].exp(), sample_period_s)) {
                self.linear.push(values);
                self.slopes.push(slopes);
            }
            return;
        }
        let answer = |n: usize| kernel.answer(shapes, n as f64 * sample_period_s);
        let answers: Vec<StepAnswer> = (0..stream.rows()).map(answer).collect();
        let of = |value: &dyn Fn(&StepAnswer) -> f64| answers.iter().map(value).collect::<Vec<f64>>();
        self.linear.push(stream.response(&of(&|answer| answer.value)));
        self.linear.push(of(&|answer| answer.left));
        for which in 0..shapes.len() {
            self.slopes.push(stream.response(&of(&|answer| answer.slopes[which])));
            self.slopes.push(of(&|answer| -answer.slopes[which]));
        }
    }

    /// What weights make of the linear columns.
    pub fn weighed(&self, weights: &DVector<f64>) -> Vec<f64> {
        let mut sum = vec![0.0; self.linear[0].len()];
        for (column, weight) in self.linear.iter().zip(weights.iter()) {
            sum.iter_mut().zip(column).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }

    /// Products of all columns and y over the rows that have an output, in which y is not NaN.
    pub fn products(&self, y: &[f64]) -> DMatrix<f64> {
        let columns: Vec<&[f64]> = self.linear.iter().chain(&self.slopes).map(Vec::as_slice).chain([y]).collect();
        let width = columns.len();
        let mut sums = DMatrix::zeros(width, width);
        for from in (0..y.len()).step_by(PANEL) {
            let to = y.len().min(from + PANEL);
            let rows: Vec<usize> = (from..to).filter(|&row| !y[row].is_nan()).collect();
            let panel = DMatrix::from_fn(rows.len(), width, |i, j| columns[j][rows[i]]);
            for i in 0..width {
                for j in 0..=i {
                    sums[(i, j)] += panel.column(i).dot(&panel.column(j));
                }
            }
        }
        sums.fill_upper_triangle_with_lower_triangle();
        sums
    }
}
