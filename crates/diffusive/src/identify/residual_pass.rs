//! A second reading of a record, for what fitted models leave of it: row by row, in bounded memory.
//!
//! Outputs that share a design share a reading.

use std::collections::VecDeque;
use std::ops::Range;

use nalgebra::{Cholesky, DMatrix};

use super::design::{GasSource, RegressionDesign};
use super::drift::{ChosenDrift, DriftTracker};
use super::fitted::FittedOutput;
use super::gram::in_one;
use super::options::{FitObserver, Progress};
use super::panels::{BATCH, LANES, Lanes, Panel, Tile, add_products, panels, tiles};
use super::record::{RecordError, RecordSource, copy_row};
use super::residuals::{FitRow, Residuals};
use super::rows::RegressionRows;
use super::segment;
use crate::model::RecordEnd;

/// Residuals of every output, and where the record ended.
pub struct ResidualPass {
    pub residuals: Vec<Residuals>,
    pub end: RecordEnd,
}

impl ResidualPass {
    /// Reads the record for the models of all its outputs. `seen` hears of every row of every
    /// reading.
    pub fn of(
        source: &mut dyn RecordSource,
        gas: GasSource,
        fitted: &[FittedOutput<'_>],
        seen: &mut dyn FnMut(&FitRow<'_>),
    ) -> Result<Self, RecordError> {
        let end = RecordEnd { decays: vec![Vec::new(); fitted.len()], ..RecordEnd::default() };
        let mut pass = Self { residuals: vec![Residuals::default(); fitted.len()], end };
        for first in 0..fitted.len() {
            let is_alike = |output: &usize| std::ptr::eq(fitted[*output].design, fitted[first].design);
            if !(0..first).any(|before| is_alike(&before)) {
                let alike: Vec<usize> = (first..fitted.len()).filter(is_alike).collect();
                pass.read(source, gas, fitted, &alike, seen)?;
            }
        }
        Ok(pass)
    }

    /// One reading for the outputs `alike`, which have the same design.
    fn read(
        &mut self,
        source: &mut dyn RecordSource,
        gas: GasSource,
        fitted: &[FittedOutput<'_>],
        alike: &[usize],
        seen: &mut dyn FnMut(&FitRow<'_>),
    ) -> Result<(), RecordError> {
        source.restart()?;
        let survey = source.survey();
        let (inputs, outputs, period_s) = (survey.inputs.len(), survey.outputs.len(), survey.sample_period_s);
        let (given, starts_rad_s) = (fitted[alike[0]].design, segment::start_rates(survey));
        let design = segment::with_starts(given, &starts_rad_s);
        let (own, longest) =
            (design.decays().end - starts_rad_s.len()..design.decays().end + 1, design.longest_delay());
        let mut rows = RegressionRows::new(&design, period_s, &vec![0.0; outputs]);
        // The decays of later segments are not among the model's.
        let weights_of = |&output: &usize| {
            let mut weights = fitted[output].weights();
            weights.splice(own.start..own.start, starts_rad_s.iter().map(|_| 0.0));
            weights
        };
        let of_model: Vec<Vec<f64>> = alike.iter().map(weights_of).collect();
        let mut batch = vec![[[0.0; LANES]; BATCH]; panels(rows.width())];
        let (mut input_row, mut output_row, mut predicted) =
            (vec![0.0; inputs], vec![0.0; outputs], vec![f64::NAN; outputs]);
        let (mut drift, mut drift_se) = (vec![0.0; outputs], vec![0.0; outputs]);
        let mut levels: Vec<DriftTracker> = fitted.iter().map(|fitted| DriftTracker::new(fitted, period_s)).collect();
        let (mut count, mut segment_row, mut segment) = (0_u64, 0, 0);
        let mut uneven_s = 0.0;
        // What later segments began with, output by output.
        let starts = match starts_rad_s.is_empty() {
            true => Vec::new(),
            false => segment_starts(source, gas, fitted, alike, &of_model, &design, own.clone())?,
        };
        source.restart()?;
        let mut weights: Vec<Vec<Lanes>> = of_model.iter().map(|weights| in_lanes(weights)).collect();
        // The last inputs and their classes, oldest first.
        let mut pending = VecDeque::with_capacity(longest + 1);
        while let Some(block) = source.next_block()? {
            if block.begins_segment && count > 0 {
                rows.restart();
                levels.iter_mut().for_each(DriftTracker::restart);
                pending.clear();
                for (weights, starts) in weights.iter_mut().zip(&starts) {
                    let weights = weights.as_flattened_mut();
                    weights[design.decays()].fill(0.0);
                    weights[own.clone()].copy_from_slice(&starts[segment]);
                }
                (segment, segment_row) = (segment + 1, 0);
            }
            let mut missing = block.missing.iter().map(|&row| row as usize).peekable();
            for at in 0..block.len() {
                let n = at % BATCH;
                if n == 0 {
                    rows.fill(block, gas, at, BATCH.min(block.len() - at), &mut batch);
                    for &output in alike {
                        levels[output].update_se(|column| batch[column / LANES][0][column % LANES]);
                        drift_se[output] = levels[output].se();
                    }
                }
                copy_row(&block.inputs, at, &mut input_row);
                copy_row(&block.outputs, at, &mut output_row);
                let class = block.class[at] as usize;
                let is_missing = missing.next_if_eq(&at).is_some();
                for (&output, weights) in alike.iter().zip(&weights) {
                    let mut explained = [0.0; LANES];
                    for (panel, weights) in batch.iter().zip(weights) {
                        for lane in 0..LANES {
                            explained[lane] += panel[n][lane] * weights[lane];
                        }
                    }
                    predicted[output] = explained.iter().sum::<f64>() + fitted[output].shift;
                    drift[output] = levels[output].level(output_row[output] - predicted[output]);
                    // What drove the first rows of a later segment late stood before it.
                    if segment > 0 && segment_row < longest as u64 {
                        predicted[output] = f64::NAN;
                    } else if !is_missing {
                        self.residuals[output].push(output_row[output], predicted[output], drift[output]);
                    }
                }
                if longest > 0 {
                    pending.push_back((input_row.clone(), class));
                    if pending.len() > longest {
                        pending.pop_front();
                    }
                }
                if is_missing {
                    output_row.fill(f64::NAN);
                }
                seen(&FitRow {
                    row: count,
                    since_s: if block.interval_s.is_empty() { count as f64 * period_s } else { uneven_s },
                    class,
                    measured: &output_row,
                    predicted: &predicted,
                    drift: &drift,
                    drift_se: &drift_se,
                });
                uneven_s += block.interval_s.get(at).unwrap_or(&0.0);
                count += 1;
                segment_row += 1;
            }
            self.end.next_time_s = block.time_s.1 + period_s;
        }
        source.restart()?;
        let states = rows.states();
        for ((&output, weights), of_model) in alike.iter().zip(&weights).zip(&of_model) {
            let weights = weights.as_flattened();
            self.end.decays[output] = design.decays_of(&states, weights);
            self.end.decays[output].extend(fitted[output].drift.map(ChosenDrift::end));
            if segment > 0 {
                // The last segment's own offset, over the model's.
                let offset = own.end - 1;
                self.end.decays[output].push((0.0, weights[offset] - of_model[offset]));
            }
        }
        if pending.len() >= self.end.pending_class.len() {
            let of = |input: usize| pending.iter().map(|(inputs, _)| inputs[input]).collect();
            self.end.pending = (0..inputs).map(of).collect();
            self.end.pending_class = pending.iter().map(|(_, class)| *class).collect();
        }
        Ok(())
    }
}

/// For every output in `alike`, what each segment but the first began with: the decays and the
/// offset that explain best what its model leaves there.
fn segment_starts(
    source: &mut dyn RecordSource,
    gas: GasSource,
    fitted: &[FittedOutput<'_>],
    alike: &[usize],
    of_model: &[Vec<f64>],
    design: &RegressionDesign,
    own: Range<usize>,
) -> Result<Vec<Vec<Vec<f64>>>, RecordError> {
    let (outputs, period_s) = (source.survey().outputs.len(), source.survey().sample_period_s);
    let without_starts = |weights: &Vec<f64>| {
        let mut weights = weights.clone();
        weights[design.decays().start..own.end].fill(0.0);
        weights
    };
    let weights: Vec<Vec<f64>> = of_model.iter().map(without_starts).collect();
    let mut rows = RegressionRows::new(design, period_s, &vec![0.0; outputs]);
    let mut batch = vec![[[0.0; LANES]; BATCH]; panels(rows.width())];
    let mut fit = StartFit::of(own.len(), alike.len());
    let (lead, mut segment_row, mut is_first) = (design.longest_delay() as u64, 0, true);
    source.restart()?;
    while let Some(block) = source.next_block()? {
        if block.begins_segment {
            fit.end_segment(is_first);
            rows.restart();
            (segment_row, is_first) = (0, false);
        }
        let mut missing = block.missing.iter().map(|&row| row as usize).peekable();
        for at in 0..block.len() {
            let n = at % BATCH;
            if n == 0 {
                fit.add_rows();
                rows.fill(block, gas, at, BATCH.min(block.len() - at), &mut batch);
            }
            let is_missing = missing.next_if_eq(&at).is_some();
            segment_row += 1;
            // What drives the first rows of a model with dead time stood before the segment.
            if is_missing || is_first || segment_row <= lead {
                continue;
            }
            let value = |column: usize| batch[column / LANES][n][column % LANES];
            let rest = |(&output, weights): (&usize, &Vec<f64>)| {
                let explained: f64 = weights.iter().enumerate().map(|(column, weight)| weight * value(column)).sum();
                block.outputs[output][at] - explained - fitted[output].shift
            };
            fit.push(own.clone().map(value).chain(alike.iter().zip(&weights).map(rest)));
        }
    }
    fit.end_segment(is_first);
    Ok(fit.starts)
}

/// Least squares on what a segment begins with. Decays are so dense that a change in the fourteenth
/// digit of their sums moves residuals by a millionth: so these are exact, as those of `panels`.
struct StartFit {
    /// How many decays there are, the offset with them.
    count: usize,
    width: usize,
    panels: Vec<Panel>,
    tiles: Vec<Tile>,
    /// Rows that wait in the panels.
    rows: usize,
    /// By output and segment.
    starts: Vec<Vec<Vec<f64>>>,
}

impl StartFit {
    fn of(count: usize, outputs: usize) -> Self {
        let (width, panels) = (count + outputs, panels(count + outputs));
        Self {
            count,
            width,
            panels: vec![[[0.0; LANES]; BATCH]; panels],
            tiles: vec![Tile::default(); tiles(panels)],
            rows: 0,
            starts: vec![Vec::new(); outputs],
        }
    }

    /// Takes a row of a batch: decays, the offset, and what is left of outputs.
    fn push(&mut self, values: impl Iterator<Item = f64>) {
        for (column, value) in values.enumerate() {
            self.panels[column / LANES][self.rows][column % LANES] = value;
        }
        self.rows += 1;
    }

    /// Adds the rows of a batch.
    fn add_rows(&mut self) {
        if self.rows > 0 {
            let is_live = vec![true; self.panels.len()];
            add_products(&self.panels, &is_live, self.width, self.rows, &mut self.tiles);
        }
        self.rows = 0;
    }

    fn end_segment(&mut self, is_first: bool) {
        self.add_rows();
        let sums = in_one(&self.tiles, self.width);
        self.tiles.fill(Tile::default());
        if is_first {
            return;
        }
        let count = self.count;
        let squares = sums.view((0, 0), (count, count)).into_owned();
        let held = DMatrix::from_diagonal(&squares.diagonal().map(segment::held));
        let factor = Cholesky::new(squares + held);
        for (output, starts) in self.starts.iter_mut().enumerate() {
            let products = sums.view((0, count + output), (count, 1)).into_owned();
            let start = factor.as_ref().map_or(DMatrix::zeros(count, 1), |factor| factor.solve(&products));
            starts.push(start.as_slice().to_vec());
        }
    }
}

/// Weights of columns, as the panels have them.
fn in_lanes(theta: &[f64]) -> Vec<Lanes> {
    let mut lanes = vec![[0.0; LANES]; panels(theta.len())];
    lanes.as_flattened_mut()[..theta.len()].copy_from_slice(theta);
    lanes
}

/// An observer that reports progress as well.
pub fn observed<'a>(
    progress: &'a mut Progress<'_>,
    what: &'static str,
    rows: u64,
    observer: &'a mut FitObserver<'_>,
) -> impl FnMut(&FitRow<'_>) + 'a {
    move |seen| {
        // Every so many rows, so that it costs nothing.
        if seen.row.is_multiple_of(65_536) {
            progress(what, seen.row, rows);
        }
        observer(seen);
    }
}
