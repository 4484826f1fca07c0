//! One reading of a record: the normal equations of several designs, and the plain facts that
//! checks and priors need.

use super::design::RegressionDesign;
use super::gas_source::GasSource;
use super::gram::{Accumulator, Gram};
use super::record::{Block, RecordError, RecordSource, Survey};
use super::spread::ValueSpread;
use crate::model::Provenance;

/// Sums over inputs and outputs, in one class and in all.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    pub rows: u64,
    pub first_inputs: Vec<f64>,
    pub first_class: usize,
    /// Least and greatest value of every input.
    pub input_range: Vec<[f64; 2]>,
    pub output_range: Vec<[f64; 2]>,
    /// The value from which `output_sum` and `output_squares` are counted: the first row's.
    pub output_first: Vec<f64>,
    output_sum: Vec<f64>,
    output_squares: Vec<f64>,
    /// Least and greatest temperature of the gas, °C; `None` without a gas column.
    pub gas_range: Option<[f64; 2]>,
    pub gas_first: f64,
    gas_sum: f64,
    gas_squares: f64,
    /// By class: rows, and by input Σ(u − u_0) and Σ(u − u_0)².
    pub class_rows: Vec<u64>,
    class_sum: Vec<Vec<f64>>,
    class_squares: Vec<Vec<f64>>,
    /// Σ(u_i − u_i0)(u_j − u_j0)
    products: Vec<Vec<f64>>,
}

impl Facts {
    fn new(inputs: usize, outputs: usize) -> Self {
        Self {
            rows: 0,
            first_inputs: Vec::new(),
            first_class: 0,
            input_range: vec![[f64::INFINITY, f64::NEG_INFINITY]; inputs],
            output_range: vec![[f64::INFINITY, f64::NEG_INFINITY]; outputs],
            output_first: Vec::new(),
            output_sum: vec![0.0; outputs],
            output_squares: vec![0.0; outputs],
            gas_range: None,
            gas_first: 0.0,
            gas_sum: 0.0,
            gas_squares: 0.0,
            class_rows: Vec::new(),
            class_sum: Vec::new(),
            class_squares: Vec::new(),
            products: vec![vec![0.0; inputs]; inputs],
        }
    }

    /// Where a model of this record comes from.
    pub fn provenance(&self, survey: &Survey) -> Provenance {
        Provenance {
            tool: format!("anemo {}", env!("CARGO_PKG_VERSION")),
            records: vec![survey.path.display().to_string()],
            rows: self.rows,
            duration_s: self.rows as f64 * survey.sample_period_s,
            input_range: self.input_range.clone(),
            conditions: survey.conditions.clone(),
        }
    }

    fn add(&mut self, block: &Block) {
        if self.rows == 0 {
            self.first_inputs = block.inputs.iter().map(|values| values[0]).collect();
            self.output_first = block.outputs.iter().map(|values| values[0]).collect();
            self.first_class = block.class[0] as usize;
        }
        self.rows += block.len() as u64;
        for (output, values) in block.outputs.iter().enumerate() {
            let spread = ValueSpread::of(values, self.output_first[output]);
            widen(&mut self.output_range[output], &spread);
            self.output_sum[output] += spread.sum;
            self.output_squares[output] += spread.squares;
        }
        if let Some(&first) = block.gas.first() {
            if self.gas_range.is_none() {
                self.gas_first = first;
            }
            let spread = ValueSpread::of(&block.gas, self.gas_first);
            widen(self.gas_range.get_or_insert([f64::INFINITY, f64::NEG_INFINITY]), &spread);
            self.gas_sum += spread.sum;
            self.gas_squares += spread.squares;
        }
        let inputs = block.inputs.len();
        let mut from = 0;
        for stretch in stretches(&block.class) {
            let (class, to) = (stretch[0] as usize, from + stretch.len());
            while self.class_rows.len() <= class {
                self.class_rows.push(0);
                self.class_sum.push(vec![0.0; inputs]);
                self.class_squares.push(vec![0.0; inputs]);
            }
            self.class_rows[class] += stretch.len() as u64;
            for input in 0..inputs {
                let spread = ValueSpread::of(&block.inputs[input][from..to], self.first_inputs[input]);
                widen(&mut self.input_range[input], &spread);
                self.class_sum[class][input] += spread.sum;
                self.class_squares[class][input] += spread.squares;
            }
            from = to;
        }
        for i in 0..inputs {
            for j in 0..i {
                let pairs = block.inputs[i].iter().zip(&block.inputs[j]);
                self.products[i][j] +=
                    pairs.map(|(a, b)| (a - self.first_inputs[i]) * (b - self.first_inputs[j])).sum::<f64>();
            }
        }
    }

    /// Standard deviation of an input over the whole record.
    pub fn input_sd(&self, input: usize) -> f64 {
        let (sum, squares) = self.input_sums(input);
        deviation(sum, squares, self.rows)
    }

    /// How far an input moves: its standard deviation, or its size if it is constant.
    pub fn input_scale(&self, input: usize) -> f64 {
        let sd = self.input_sd(input);
        if sd > 0.0 { sd } else { self.first_inputs[input].abs().max(f64::MIN_POSITIVE) }
    }

    /// For how many rows an input would have to stand at its greatest departure from its first
    /// value for the same sum of squares.
    pub fn full_rows(&self, input: usize) -> f64 {
        let ([least, most], first) = (self.input_range[input], self.first_inputs[input]);
        let greatest = (most - first).abs().max((least - first).abs());
        if greatest > 0.0 { self.input_sums(input).1 / (greatest * greatest) } else { 0.0 }
    }

    /// Standard deviation of an input in the rows of a class.
    pub fn class_input_sd(&self, class: usize, input: usize) -> f64 {
        deviation(self.class_sum[class][input], self.class_squares[class][input], self.class_rows[class])
    }

    pub fn output_sd(&self, output: usize) -> f64 {
        deviation(self.output_sum[output], self.output_squares[output], self.rows)
    }

    /// Standard deviation of the gas temperature, K; 0 without a gas column.
    pub fn gas_sd(&self) -> f64 {
        deviation(self.gas_sum, self.gas_squares, self.rows)
    }

    /// Correlation of two inputs.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        let n = self.rows as f64;
        let covariance = self.products[i][j] / n - self.input_sums(i).0 * self.input_sums(j).0 / (n * n);
        covariance / (self.input_sd(i) * self.input_sd(j)).max(f64::MIN_POSITIVE)
    }

    fn input_sums(&self, input: usize) -> (f64, f64) {
        let sum = self.class_sum.iter().map(|of| of[input]).sum();
        (sum, self.class_squares.iter().map(|of| of[input]).sum())
    }
}

/// Stretches of rows of one class. As a rule that is the whole block, which is told faster than
/// where a stretch ends.
fn stretches(class: &[u32]) -> impl Iterator<Item = &[u32]> {
    let alike = class.iter().fold(true, |alike, of| alike & (*of == class[0]));
    let mut rest = class;
    std::iter::from_fn(move || {
        let first = rest.first()?;
        let other = if alike { None } else { rest.iter().position(|of| of != first) };
        let (stretch, behind) = rest.split_at(other.unwrap_or(rest.len()));
        rest = behind;
        Some(stretch)
    })
}

fn widen(range: &mut [f64; 2], spread: &ValueSpread) {
    *range = [range[0].min(spread.least), range[1].max(spread.greatest)];
}

fn deviation(sum: f64, squares: f64, rows: u64) -> f64 {
    let n = (rows as f64).max(1.0);
    (squares / n - (sum / n).powi(2)).max(0.0).sqrt()
}

/// What a reading gives.
pub struct Passed {
    /// By design: the folds.
    pub folds: Vec<Vec<Gram>>,
    pub facts: Facts,
    /// Subtracted from the outputs before they entered the sums.
    pub output_shift: Vec<f64>,
}

/// Reads the record once. `rows` at most are taken; `progress` hears of every block.
pub fn pass(
    source: &mut dyn RecordSource,
    designs: &[RegressionDesign],
    folds: usize,
    gas: GasSource,
    rows: u64,
    progress: &mut dyn FnMut(u64),
) -> Result<Passed, RecordError> {
    source.restart()?;
    let survey = source.survey();
    let (inputs, outputs) = (survey.inputs.len(), survey.outputs.len());
    let (sample_period_s, expected) = (survey.sample_period_s, survey.rows.min(rows));
    let mut facts = Facts::new(inputs, outputs);
    let mut accumulators = Vec::new();
    let mut output_shift = Vec::new();
    while let Some(block) = source.next_block()? {
        if accumulators.is_empty() {
            output_shift = block.outputs.iter().map(|values| mean(values)).collect();
            let of = |design| Accumulator::new(design, sample_period_s, expected, folds, &output_shift);
            accumulators = designs.iter().map(of).collect();
        }
        // In this order, rows come from memory while there is much to do with those before.
        for accumulator in &mut accumulators {
            accumulator.push(block, gas);
        }
        facts.add(block);
        progress(facts.rows);
        if facts.rows >= rows {
            break;
        }
    }
    Ok(Passed { folds: accumulators.into_iter().map(Accumulator::finish).collect(), facts, output_shift })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
