//! Residuals of a model over all segments of a record, from sums.

use super::closed::{ClosedSegment, ClosedSums};
use super::designs::{SummedDesigns, columns_of};
use super::left::{LeftSums, SegmentEdges};
use super::own_start::{OwnStart, StartedResidual};
use crate::identify::drift::{NoiseFilter, PoleColumns};
use crate::identify::fitted::FittedOutput;
use crate::identify::residuals::{LAGS, Residuals};
use crate::identify::segment::with_starts;
use crate::identify::spread::ValueSpread;

/// One output's model beside the sums of a record.
pub struct ResidualSums<'a> {
    designs: &'a SummedDesigns,
    closed: &'a ClosedSums,
    /// Which design is its.
    at: usize,
    fitted: &'a FittedOutput<'a>,
    output: usize,
}

/// What is left of an output, as weights of an opened design's columns.
struct Weights {
    /// By what drives it, drift included; and without what the drift's filter expects.
    unexplained: Vec<f64>,
    left: Vec<f64>,
}

/// Sums over the segments so far.
#[derive(Default)]
struct Totals {
    /// Of residuals, and of those with the drift.
    squares: [f64; 2],
    products: Vec<f64>,
    greatest: (f64, u64),
    rows: u64,
    /// The last residuals, oldest first.
    last: Vec<f64>,
}

impl<'a> ResidualSums<'a> {
    pub fn of(
        designs: &'a SummedDesigns,
        closed: &'a ClosedSums,
        at: usize,
        fitted: &'a FittedOutput<'a>,
        output: usize,
    ) -> Self {
        Self { designs, closed, at, fitted, output }
    }

    /// `facts` of the output over the record.
    pub fn residuals(&self, facts: &ValueSpread) -> Residuals {
        let opened = &self.designs.opened[self.at];
        let gram = self.closed.plain(self.at, opened);
        let edges: Vec<SegmentEdges> = self.closed.segments.iter().map(|segment| self.edges(segment)).collect();
        let period_s = self.designs.record.sample_period_s;
        let sums = LeftSums::of(opened, period_s, &gram, &self.closed.products, &edges);
        let weights = self.weights();
        let mut totals = Totals {
            squares: [&weights.left, &weights.unexplained].map(|weights| sums.squares(weights)),
            products: sums.products(&weights.left),
            ..Totals::default()
        };
        let (offset, y) = (opened.decays().end, opened.width() - opened.outputs + self.output);
        let mut y_sum = gram.sums[(offset, y)];
        for (number, (segment, edges)) in self.closed.segments.iter().zip(&edges).enumerate() {
            let values = [sums.first_values(*edges, &weights.left), sums.last_values(*edges, &weights.left)];
            if number == 0 {
                totals.push(values, edges.rows.rows);
                continue;
            }
            let start = OwnStart::of(self.designs, segment);
            y_sum += start.output(self.designs.signals.banks.len() + self.output);
            let [left, unexplained] = self.started(&start, &sums, *edges, &weights, values);
            totals.add(&left, &unexplained);
            totals.push(left.values(), edges.rows.rows);
        }
        // From its first value, as residuals count it; the sums count from another.
        let (n, apart) = (totals.rows as f64, self.designs.record.output_shift[self.output] - facts.from);
        let squares = gram.sums[(y, y)];
        let moved = [y_sum + n * apart, squares + 2.0 * apart * y_sum + n * apart * apart];
        let moved = if facts.least == facts.greatest { [0.0; 2] } else { moved };
        Residuals::of_sums(
            totals.rows,
            totals.squares.map(|squares| squares.max(0.0)),
            totals.products,
            totals.greatest,
            facts.from,
            moved,
        )
    }

    /// What a later segment began with, behind its last row: decays, rate in rad/s and K, and the
    /// offset, K.
    pub fn start_of(&self, segment: &ClosedSegment) -> (Vec<(f64, f64)>, f64) {
        let opened = &self.designs.opened[self.at];
        let gram = self.closed.plain(self.at, opened);
        let edges = [self.edges(segment)];
        let sums = LeftSums::of(opened, self.designs.record.sample_period_s, &gram, &self.closed.products, &edges);
        let start = OwnStart::of(self.designs, segment);
        let states = [edges[0].first, edges[0].next];
        let mut begun = start.fitted(&start.with_driven(&sums.columns, states, &self.weights().unexplained));
        let offset = begun.pop().map_or(0.0, |(_, offset)| offset);
        let decayed = |(at, (rate, size)): (usize, (f64, f64))| (rate, size * start.next(at));
        (begun.into_iter().enumerate().map(decayed).collect(), offset)
    }

    fn edges(&self, segment: &'a ClosedSegment) -> SegmentEdges<'a> {
        let [first, next] = &segment.states[self.at];
        SegmentEdges { first, next, rows: &segment.edges }
    }

    fn weights(&self) -> Weights {
        let (design, opened) = (self.fitted.design, &self.designs.opened[self.at]);
        let columns = columns_of(design, opened);
        let explained = self.fitted.weights();
        let own = explained.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
        let mut unexplained: Vec<(usize, f64)> = own.map(|(column, weight)| (column, -weight)).collect();
        unexplained.push((design.width() - design.outputs + self.output, 1.0));
        let left = match self.filter() {
            None => unexplained.clone(),
            Some(filter) => PoleColumns::of(design, self.fitted.sample_period_s).innovations(&unexplained, filter),
        };
        let in_opened = |of: &[(usize, f64)]| {
            let mut weights = vec![0.0; opened.width()];
            of.iter().for_each(|&(column, weight)| weights[columns[column]] += weight);
            weights
        };
        Weights { unexplained: in_opened(&unexplained), left: in_opened(&left) }
    }

    fn filter(&self) -> Option<&'a NoiseFilter> {
        self.fitted.drift.and_then(|drift| drift.filter.as_ref())
    }

    /// What is left in a later segment, and what is with the drift, with the start that explains
    /// most of it. `values`: what drives leave in the first rows and in the last.
    fn started<'s>(
        &self,
        start: &'s OwnStart,
        sums: &LeftSums<'_>,
        edges: SegmentEdges<'_>,
        weights: &Weights,
        values: [Vec<f64>; 2],
    ) -> [StartedResidual<'s>; 2] {
        let states = [edges.first, edges.next];
        let with_driven = |weights: &[f64]| start.with_driven(&sums.columns, states, weights);
        let unexplained = with_driven(&weights.unexplained);
        let fitted = start.fitted(&unexplained);
        let design = with_starts(self.fitted.design, &self.designs.record.starts_rad_s);
        let (end, roles) = (design.decays().end, design.roles());
        let own = end + 1 - fitted.len()..end + 1;
        let begun: Vec<(usize, f64)> = own.zip(&fitted).map(|(column, (_, size))| (column, -size)).collect();
        let sizes = |of: &[(usize, f64)]| start.sizes(of.iter().map(|&(column, size)| (roles[column], size)));
        let filtered = match self.filter() {
            None => sizes(&begun),
            Some(filter) => sizes(&PoleColumns::of(&design, self.fitted.sample_period_s).innovations(&begun, filter)),
        };
        let (of_left, rows) = (with_driven(&weights.left), edges.rows.rows);
        [
            start.beside_driven(filtered, of_left, values, rows),
            start.beside_driven(sizes(&begun), unexplained, Default::default(), rows),
        ]
    }
}

impl Totals {
    /// Adds what a start makes of residuals.
    fn add(&mut self, left: &StartedResidual<'_>, unexplained: &StartedResidual<'_>) {
        self.squares[0] += left.squares();
        self.squares[1] += unexplained.squares();
        self.products.iter_mut().zip(left.products()).for_each(|(total, product)| *total += product);
    }

    /// Takes a segment's first residuals and its last: products with those of the segment before
    /// count as well.
    fn push(&mut self, [first, last]: [Vec<f64>; 2], rows: u64) {
        for (lag, product) in (1..).zip(&mut self.products) {
            let before = |row: usize| (self.last.len() + row).checked_sub(lag).map_or(0.0, |at| self.last[at]);
            *product += first.iter().take(lag).enumerate().map(|(row, value)| value * before(row)).sum::<f64>();
        }
        for (row, value) in (self.rows + 1..).zip(&first) {
            if value * value > self.greatest.0 {
                self.greatest = (value * value, row);
            }
        }
        self.rows += rows;
        self.last.extend(last);
        self.last.drain(..self.last.len().saturating_sub(LAGS));
    }
}
