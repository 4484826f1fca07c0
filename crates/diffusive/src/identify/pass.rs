//! One reading of a record: the normal equations of several designs, and the plain facts that
//! checks and priors need.

use super::accumulator::Accumulator;
use super::design::{BankDrive, GasSource, RegressionDesign, RelaxationBank};
use super::gram::Gram;
use super::options::Progress;
use super::quiet_start::QuietStart;
use super::record::{Block, InBlocks, RecordError, RecordSource, Survey};
use super::segment::start_rates;
use super::spread::{InputMoves, ValueSpread, deviation};
use super::whole_batches::WholeBatches;
use crate::model::Provenance;

/// Spreads of inputs, in one class and in all, of outputs and of the gas, each counted from the
/// first row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Facts {
    pub rows: u64,
    pub first_inputs: Vec<f64>,
    pub first_class: usize,
    pub outputs: Vec<ValueSpread>,
    /// `None` without a gas column.
    pub gas: Option<ValueSpread>,
    /// By class and input.
    pub classes: Vec<Vec<ValueSpread>>,
    /// Σ(u_i − u_i0)(u_j − u_j0)
    products: Vec<Vec<f64>>,
    /// By input.
    moves: Vec<InputMoves>,
    /// Before the first power.
    pub quiet_start: QuietStart,
}

impl Facts {
    /// Where a model of this record comes from.
    pub fn provenance(&self, survey: &Survey) -> Provenance {
        Provenance {
            tool: format!("anemo {}", env!("CARGO_PKG_VERSION")),
            records: survey.paths.iter().map(|path| path.display().to_string()).collect(),
            rows: self.rows,
            uneven_times: survey.is_uneven,
            duration_s: if survey.is_uneven { survey.duration_s() } else { self.rows as f64 * survey.sample_period_s },
            input_range: (0..self.first_inputs.len()).map(|input| self.input_range(input)).collect(),
            conditions: survey.conditions.clone(),
        }
    }

    /// Takes the next rows.
    pub(super) fn add(&mut self, block: &Block) {
        let inputs = block.inputs.len();
        if self.rows == 0 {
            self.first_inputs = block.inputs.iter().map(|values| values[0]).collect();
            self.first_class = block.class[0] as usize;
            self.outputs = block.outputs.iter().map(|values| ValueSpread::from(values[0])).collect();
            self.gas = block.gas.first().map(|&gas_c| ValueSpread::from(gas_c));
            self.products = vec![vec![0.0; inputs]; inputs];
            self.moves = self.first_inputs.iter().map(|&last| InputMoves { last, ..InputMoves::default() }).collect();
        }
        self.rows += block.len() as u64;
        self.quiet_start.add(block);
        for (spread, values) in self.outputs.iter_mut().zip(&block.outputs) {
            spread.add(values);
        }
        if let Some(gas) = &mut self.gas {
            gas.add(&block.gas);
        }
        let mut from = 0;
        for stretch in block.class.chunk_by(|one, next| one == next) {
            let (class, to) = (stretch[0] as usize, from + stretch.len());
            while self.classes.len() <= class {
                self.classes.push(self.first_inputs.iter().map(|&first| ValueSpread::from(first)).collect());
            }
            for (spread, values) in self.classes[class].iter_mut().zip(&block.inputs) {
                spread.add(&values[from..to]);
            }
            from = to;
        }
        for (input, values) in block.inputs.iter().enumerate() {
            let [least, most] = self.input_range(input);
            let far = 0.1 * (most - least);
            self.moves[input].add(values, far);
        }
        for i in 0..inputs {
            for j in 0..i {
                let pairs = block.inputs[i].iter().zip(&block.inputs[j]);
                self.products[i][j] +=
                    pairs.map(|(a, b)| (a - self.first_inputs[i]) * (b - self.first_inputs[j])).sum::<f64>();
            }
        }
    }

    /// Least and greatest value of an input.
    pub fn input_range(&self, input: usize) -> [f64; 2] {
        let own = self.classes.iter().map(|of| &of[input]);
        own.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], of| [least.min(of.least), most.max(of.greatest)])
    }

    /// In how many rows any input moved by more than a tenth of its range.
    pub fn moves(&self) -> u64 {
        self.moves.iter().map(|of| of.moves).max().unwrap_or(0)
    }

    /// How far an input travels up and down in all, in ranges: 1 for one that goes one way, as a
    /// step or a ramp does. The most of any input.
    pub fn travel(&self) -> f64 {
        let of = |(input, of): (usize, &InputMoves)| {
            let [least, most] = self.input_range(input);
            of.travel / (most - least).max(f64::MIN_POSITIVE)
        };
        self.moves.iter().enumerate().map(of).fold(0.0, f64::max)
    }

    /// Tells whether an input heats at one level only: up or down once, or once each. Values at two levels
    /// have the greatest variance that their range and mean allow (Bhatia and Davis 2000).
    pub fn is_of_one_level(&self, input: usize) -> bool {
        let ([least, most], (sum, _)) = (self.input_range(input), self.input_sums(input));
        let mean = self.first_inputs[input] + sum / self.rows as f64;
        let greatest = (mean - least) * (most - mean);
        self.moves[input].travel < 2.5 * (most - least) && self.input_sd(input).powi(2) > 0.95 * greatest
    }

    /// Standard deviation of an input over the whole record.
    pub fn input_sd(&self, input: usize) -> f64 {
        let (sum, squares) = self.input_sums(input);
        deviation(sum, squares, self.rows)
    }

    /// How far what drives a bank moves. Losses and gates carry no parameters that a prior speaks
    /// of.
    pub fn drive_scale(&self, drive: BankDrive) -> f64 {
        match drive {
            BankDrive::Input(input) | BankDrive::Gated { input, .. } => self.input_scale(input),
            BankDrive::Gas => self.gas_sd(),
            BankDrive::Loss { .. } | BankDrive::Gate { .. } | BankDrive::Output(_) => 1.0,
        }
    }

    /// What drove each bank of a design in the first row, where that is an input.
    pub fn first_drives(&self, design: &RegressionDesign) -> Vec<f64> {
        let of = |bank: &RelaxationBank| match bank.drive {
            BankDrive::Input(input) => self.first_inputs[input],
            BankDrive::Gated { input, class } if class == self.first_class => self.first_inputs[input],
            _ => 0.0,
        };
        design.banks.iter().map(of).collect()
    }

    /// How far an input moves: its standard deviation, or its size if it is constant.
    pub fn input_scale(&self, input: usize) -> f64 {
        let sd = self.input_sd(input);
        if sd > 0.0 { sd } else { self.first_inputs[input].abs().max(f64::MIN_POSITIVE) }
    }

    /// For how many rows an input would have to stand at its greatest departure from its first
    /// value for the same sum of squares.
    pub fn full_rows(&self, input: usize) -> f64 {
        let ([least, most], first) = (self.input_range(input), self.first_inputs[input]);
        let greatest = (most - first).abs().max((least - first).abs());
        if greatest > 0.0 { self.input_sums(input).1 / (greatest * greatest) } else { 0.0 }
    }

    /// Standard deviation of the gas temperature, K; 0 without a gas column.
    pub fn gas_sd(&self) -> f64 {
        self.gas.as_ref().map_or(0.0, ValueSpread::sd)
    }

    /// Correlation of two inputs.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        let n = self.rows as f64;
        let covariance = self.products[i][j] / n - self.input_sums(i).0 * self.input_sums(j).0 / (n * n);
        covariance / (self.input_sd(i) * self.input_sd(j)).max(f64::MIN_POSITIVE)
    }

    fn input_sums(&self, input: usize) -> (f64, f64) {
        let own = self.classes.iter().map(|of| &of[input]);
        (own.clone().map(|of| of.sum).sum(), own.map(|of| of.squares).sum())
    }
}

/// The labels of all classes: a record with an event column is read once for them.
pub fn labels(source: &mut dyn RecordSource, progress: &mut Progress<'_>) -> Result<Vec<String>, RecordError> {
    if source.survey().event_column.is_some() {
        source.restart()?;
        let (mut done, rows) = (0, source.survey().rows);
        while let Some(block) = source.next_block()? {
            done += block.len() as u64;
            progress("looking for events", done, rows);
        }
    }
    Ok(source.classes().to_vec())
}

/// What a reading gives.
pub struct Passed {
    /// By design: the folds.
    pub folds: Vec<Vec<Gram>>,
    /// By design: the states behind each fold, as the next row has them.
    pub ends: Vec<Vec<Vec<f64>>>,
    pub facts: Facts,
    /// Subtracted from the outputs before they entered the sums.
    pub output_shift: Vec<f64>,
}

/// Reads the record once, in blocks that do not depend on its files. `rows` at most are taken; `progress` hears of every block.
pub fn pass(
    source: &mut dyn RecordSource,
    designs: &[RegressionDesign],
    folds: usize,
    gas: GasSource,
    rows: u64,
    progress: &mut dyn FnMut(u64),
) -> Result<Passed, RecordError> {
    let source = &mut InBlocks::of(source);
    source.restart()?;
    let survey = source.survey();
    let (sample_period_s, expected) = (survey.sample_period_s, survey.rows.min(rows));
    let starts_rad_s = start_rates(survey);
    // All designs see the same rows.
    let lead = designs.iter().map(RegressionDesign::longest_delay).max().unwrap_or(0);
    let mut facts = Facts::default();
    let mut accumulators = Vec::new();
    let mut output_shift = Vec::new();
    let mut batches = WholeBatches::default();
    while let Some(block) = source.next_block()? {
        if facts.rows == 0 {
            output_shift = output_means(block);
            let of =
                |design| Accumulator::new(design, &starts_rad_s, sample_period_s, expected, folds, &output_shift, lead);
            accumulators = designs.iter().map(of).collect();
        }
        // In this order, rows come from memory while there is much to do with those before.
        batches.push(block, &mut |rows| accumulators.iter_mut().for_each(|accumulator| accumulator.push(rows, gas)));
        facts.add(block);
        progress(facts.rows);
        if facts.rows >= rows {
            break;
        }
    }
    batches.finish(&mut |rows| accumulators.iter_mut().for_each(|accumulator| accumulator.push(rows, gas)));
    let (folds, ends) = accumulators.into_iter().map(Accumulator::finish).unzip();
    Ok(Passed { folds, ends, facts, output_shift })
}

/// What is subtracted from the outputs of a record whose first rows these are.
pub(super) fn output_means(block: &Block) -> Vec<f64> {
    let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    block.outputs.iter().map(mean).collect()
}
