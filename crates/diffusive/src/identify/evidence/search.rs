//! The search: dead times one input after the other, then everything else where they count.

use super::average::{Average, Member, ln_sum};
use super::columns::{Columns, ColumnsKey, Delay, OutputTable};
use super::grid::{COARSE, FINE, Grid, Shape};
use super::hypotheses::{Drift, delay_prior, drifts, initial_states};
use super::problem::{Posterior, Problem, Units};
use crate::identify::options::InitialState;

/// Rows in which dead times are looked for.
const WINDOW: usize = 10_000;
/// Dead times that are tried first, in samples.
const DELAYS: [Delay; 12] = [0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48];
/// Evidence in nats within which other dead times count, and how many of them.
const DELAY_COUNTS: f64 = 6.0;
const MOST_DELAYS: usize = 3;
/// Evidence within which a drift is looked at with all shapes of the prior, and any hypothesis
/// beside the best.
const DRIFT_COUNTS: f64 = 7.0;
const COUNTS: f64 = 14.0;

/// Choices that the user fixed.
#[derive(Debug, Clone, Default)]
pub struct Asked {
    pub initial_state: Option<InitialState>,
    pub delays: Option<Vec<Delay>>,
    /// The offset may move.
    pub may_move: bool,
    /// The output may answer in the row of its input.
    pub may_answer_at_once: bool,
}

/// A record read for one grid, paths as they are asked for.
struct Reading<'a> {
    table: &'a OutputTable,
    grid: Grid,
    rows: usize,
    is_driven: bool,
    columns: Vec<Columns>,
}

impl<'a> Reading<'a> {
    fn new(table: &'a OutputTable, rows: usize, per_decade: f64) -> Self {
        let is_driven = table.blocks[0].inputs.iter().any(|values| values[0] != 0.0);
        let grid = Grid::of(table, rows, per_decade);
        Self { table, grid, rows, is_driven, columns: Vec::new() }
    }

    /// The place of the columns of some dead times.
    fn place(&mut self, delays: &[Delay], initial_state: InitialState) -> usize {
        let longest = delays.iter().copied().max().unwrap_or(0).max(0);
        let key = ColumnsKey {
            delays: delays.to_vec(),
            // Nothing is known of powers before the record: rows that they still move are left out.
            skipped: if initial_state == InitialState::Free { longest as usize } else { 0 },
            from_rest: initial_state == InitialState::Rest && self.is_driven && longest > 0,
            rows: self.rows,
        };
        self.place_of(key)
    }

    fn place_of(&mut self, key: ColumnsKey) -> usize {
        self.columns.iter().position(|known| known.key == key).unwrap_or_else(|| {
            self.columns.push(Columns::read(self.table, &self.grid, key));
            self.columns.len() - 1
        })
    }
}

/// Result of a search.
pub struct Found<'a> {
    reading: Reading<'a>,
    units: Units,
    pub states: Vec<(InitialState, f64)>,
    pub drifts: Vec<Drift>,
    shapes: Vec<Shape>,
    pub average: Average,
}

/// Looks for dead times on a coarse grid.
struct PathSearch<'a> {
    reading: Reading<'a>,
    units: Units,
    states: Vec<(InitialState, f64)>,
    drifts: Vec<Drift>,
    tried: Vec<(Vec<Delay>, f64)>,
}

impl PathSearch<'_> {
    /// Evidence of dead times by the plain prior: the best initial state and drift.
    fn evidence(&mut self, delays: &[Delay]) -> f64 {
        if let Some((_, known)) = self.tried.iter().find(|(tried, _)| tried == delays) {
            return *known;
        }
        let mut best = f64::NEG_INFINITY;
        let mut of_states = Vec::new();
        for &(state, prior) in &self.states {
            let place = self.reading.place(delays, state);
            let columns = &self.reading.columns[place];
            let of = |drift: &Drift| {
                let problem = Problem::of(columns, &self.reading.grid, &self.units, state, drift.filter.as_ref());
                ln_sum(problem.evidence(Shape::PLAIN).iter().map(|scaled| scaled.ln)) + drift.ln_prior
            };
            let own = self.drifts.iter().map(of).fold(f64::NEG_INFINITY, f64::max) + prior;
            of_states.push(own);
            best = best.max(own);
        }
        if self.tried.is_empty() {
            // A state that is out of the question without a dead time is so with one.
            let mut own = of_states.iter();
            self.states.retain(|_| own.next().is_some_and(|own| *own > best - 4.0 * COUNTS));
        }
        // Columns of the same dead times serve all states; others are not asked for again.
        self.reading.columns.clear();
        let of_delays = best + delays.iter().map(|delay| delay_prior(*delay)).sum::<f64>();
        self.tried.push((delays.to_vec(), of_delays));
        of_delays
    }

    /// Dead times of the most evidence, best first.
    fn search(&mut self, asked: &Asked) -> Vec<Vec<Delay>> {
        let inputs = self.reading.table.inputs();
        let mut delays = vec![0; inputs];
        self.evidence(&delays);
        let least = if asked.may_answer_at_once { -1 } else { 0 };
        let longest = (self.reading.table.rows() / 20).max(2) as Delay;
        for input in (0..inputs).cycle().take(if inputs == 1 { 1 } else { 2 * inputs }) {
            let with = |delays: &[Delay], delay: Delay| {
                let mut own = delays.to_vec();
                own[input] = delay;
                own
            };
            let mut wanted: Vec<Delay> = [least].into_iter().chain(DELAYS).filter(|delay| *delay <= longest).collect();
            for round in 0..3 {
                for &delay in &wanted {
                    self.evidence(&with(&delays, delay));
                }
                let is_its = |(tried, _): &&(Vec<Delay>, f64)| with(tried, 0) == with(&delays, 0);
                let best = self.tried.iter().filter(is_its).max_by(|a, b| a.1.total_cmp(&b.1));
                delays[input] = best.map_or(0, |(tried, _)| tried[input]);
                let step = if round == 0 { (delays[input] / 8).max(1) } else { 1 };
                wanted = (-3..=3).map(|n| delays[input] + n * step).collect();
                wanted.retain(|delay| (least..=longest).contains(delay));
            }
        }
        let mut tried = self.tried.clone();
        tried.sort_by(|a, b| b.1.total_cmp(&a.1));
        let most = tried[0].1;
        tried.retain(|(_, own)| *own > most - DELAY_COUNTS);
        tried.truncate(MOST_DELAYS);
        tried.into_iter().map(|(delays, _)| delays).collect()
    }
}

/// Returns true if all inputs move in the first rows.
fn moves_in(table: &OutputTable, rows: usize) -> bool {
    (0..table.inputs()).all(|input| table.input(input, rows).windows(2).any(|two| two[0] != two[1]))
}

/// Finds what a record says of one output.
pub fn search<'a>(table: &'a OutputTable, asked: &Asked) -> Found<'a> {
    let rows = table.rows();
    let part = if rows > WINDOW && moves_in(table, WINDOW) { WINDOW } else { rows };
    let coarse = Reading::new(table, part, COARSE);
    let mut screened = drifts(&coarse.grid, asked.may_move);
    screened.retain(|drift| drift.is_screened);
    let states = initial_states(asked.initial_state, coarse.is_driven);
    let units = Units::of(table, part);
    let mut paths = PathSearch { reading: coarse, units, states: states.clone(), drifts: screened, tried: Vec::new() };
    let kept = asked.delays.clone().map_or_else(|| paths.search(asked), |delays| vec![delays]);
    // Effects of several inputs have scales of their own.
    for input in 1..table.inputs() {
        let try_one = |paths: &mut PathSearch<'_>, relative: f64| {
            let own = paths.units.relative[input];
            paths.units.relative[input] = own * relative;
            paths.tried.clear();
            let evidence = paths.evidence(&kept[0]);
            paths.units.relative[input] = own;
            evidence
        };
        let of: Vec<(f64, f64)> =
            [0.1, 0.3, 1.0, 3.0].map(|relative| (relative, try_one(&mut paths, relative))).to_vec();
        let best = of.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(1.0, |(relative, _)| *relative);
        paths.units.relative[input] *= best;
    }
    let mut units = Units::of(table, rows);
    units.relative = paths.units.relative;
    let reading = Reading::new(table, rows, FINE);
    let drifts = drifts(&reading.grid, asked.may_move);
    let mut found = Found { reading, units, states, drifts, shapes: Shape::all(), average: Average::of(Vec::new()) };
    let members = found.members(&kept);
    found.average = Average::of(members);
    found
}

impl Found<'_> {
    /// Everything but dead times, at those that count.
    fn members(&mut self, kept: &[Vec<Delay>]) -> Vec<Member> {
        let mut members = Vec::new();
        let mut top = f64::NEG_INFINITY;
        let shape_prior = libm::log(self.shapes.len() as f64);
        for delays in kept {
            let of_delays: f64 = delays.iter().map(|delay| delay_prior(*delay)).sum();
            for (at, &(state, of_state)) in self.states.iter().enumerate() {
                let place = self.reading.place(delays, state);
                let (columns, prior) = (&self.reading.columns[place], of_state + of_delays);
                let problem =
                    |drift: &Drift| Problem::of(columns, &self.reading.grid, &self.units, state, drift.filter.as_ref());
                let problems: Vec<Problem> = self.drifts.iter().map(problem).collect();
                let plain = |(problem, drift): (&Problem, &Drift)| {
                    ln_sum(problem.evidence(Shape::PLAIN).iter().map(|scaled| scaled.ln)) + drift.ln_prior
                };
                let first: Vec<f64> = problems.iter().zip(&self.drifts).map(plain).collect();
                let most = first.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                top = top.max(most + prior);
                for (place_of_drift, (problem, drift)) in problems.iter().zip(&self.drifts).enumerate() {
                    let own = first[place_of_drift];
                    if own <= most - DRIFT_COUNTS || own + prior <= top - COUNTS {
                        continue;
                    }
                    for (shape, &of) in self.shapes.iter().enumerate() {
                        let scaled = problem.evidence(of).into_iter().map(|scaled| Member {
                            columns: place,
                            initial_state: at,
                            drift: place_of_drift,
                            shape,
                            kind: drift.filter.as_ref().map(|filter| filter.kind),
                            corner: of.corner,
                            ln: scaled.ln + prior + drift.ln_prior - shape_prior,
                            scaled,
                        });
                        let best = top - 2.0 * COUNTS;
                        members.extend(scaled.filter(|member| member.ln > best));
                    }
                }
            }
        }
        members
    }

    /// Dead times of a member.
    pub fn delays(&self, member: &Member) -> &[Delay] {
        &self.reading.columns[member.columns].key.delays
    }

    /// The place of columns that have all rows, for the dead times and initial state of a member. In
    /// rows that powers before the record still move, the first power stands for those.
    pub fn place_of_all_rows(&mut self, member: &Member) -> usize {
        let key = ColumnsKey { skipped: 0, ..self.reading.columns[member.columns].key.clone() };
        self.reading.place_of(key)
    }

    /// Columns at a place.
    pub fn columns(&self, place: usize) -> &Columns {
        &self.reading.columns[place]
    }

    /// The grid on which all members stand.
    pub fn grid(&self) -> &Grid {
        &self.reading.grid
    }

    /// Parameters of a member, on the columns at a place.
    pub fn posterior(&self, place: usize, member: &Member) -> Posterior {
        let (state, _) = self.states[member.initial_state];
        let filter = self.drifts[member.drift].filter.as_ref();
        Problem::of(self.columns(place), self.grid(), &self.units, state, filter)
            .posterior(self.shapes[member.shape], &member.scaled)
    }
}
