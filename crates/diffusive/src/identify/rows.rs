//! Rows of the regression, made batch by batch from the record: exact states, one step a sample.
//!
//! ```text
//! x ← x + g (u − x),    g = 1 − e^(−ξ Ts)        u is held over [t_n, t_{n+1})
//! ```
//!
//! In f64 the plain update keeps ten digits at ξTs = 1e-6 (in f32 it would not:
//! `dr_core::model::relaxation`). It is written as a x + g u, which has one operation less between
//! a state and its successor: that chain is what limits the speed.
//!
//! Every column is such a state: an initial decay has g = 0 and begins with 1, the offset has a = 1
//! as well. Those that are none (feed-through, outputs) are written over it.
//!
//! In an uneven record g follows from each interval: exact, since u is held over it.

use dr_core::model::mesh;
use pulp::{Simd, WithSimd};

use super::design::{BankDrive, GasSource, RegressionDesign};
use super::panels::{BATCH, LANES, Lanes, Panel, panels};
use super::record::Block;

/// States that have decayed below this are 0 from the next batch on: they would end as denormal
/// numbers, with which processors are slow, and no sum has digits for them.
const NOTHING: f64 = 1e-100;

/// The same of initial decays, which begin with 1: their panels cost no products from there on.
const DECAYED: f64 = 1e-30;

/// The state between two rows.
pub struct RegressionRows {
    lanes: Vec<States>,
    banks: Vec<BankSignal>,
    /// What drives each bank in the rows of a batch; at least one, for columns that nothing drives.
    drives: Vec<[f64; BATCH]>,
    /// Column and bank of every feed-through.
    feed_through: Vec<(usize, usize)>,
    /// Whether a column is a state, and not an offset, a feed-through or an output.
    remembers: Vec<bool>,
    /// Subtracted from every output, so that a large offset does not eat the digits of what moves.
    output_shift: Vec<f64>,
    /// The states with which a segment begins.
    first: Vec<Lanes>,
    /// Which panels are all of decays, and which of those have not decayed in the batch.
    decays: Vec<bool>,
    is_live: Vec<bool>,
}

/// The states of a panel of columns.
#[derive(Debug, Clone, Copy, Default)]
struct States {
    /// e^(−ξ Ts) and 1 − e^(−ξ Ts)
    keep: Lanes,
    gain: Lanes,
    rate_rad_s: Lanes,
    x: Lanes,
    drive: [usize; LANES],
}

struct BankSignal {
    drive: BankDrive,
    /// Gas temperature of the first row, °C.
    first_gas_c: Option<f64>,
    /// Drives that have not arrived yet, oldest at `next`.
    late: Vec<f64>,
    /// The next drive was held before, as none is known.
    is_held: bool,
    next: usize,
    /// Subtracted from an output, as it is from its column.
    shift: f64,
}

impl RegressionRows {
    pub fn new(design: &RegressionDesign, sample_period_s: f64, output_shift: &[f64]) -> Self {
        let width = design.width();
        let mut lanes = vec![States::default(); panels(width)];
        let mut remembers = vec![false; width];
        let mut feed_through = Vec::new();
        let mut column = 0;
        let mut put = |column: usize, rate_rad_s: f64, is_driven: bool, x: f64, drive: usize| {
            let (states, lane) = (&mut lanes[column / LANES], column % LANES);
            let gain = mesh::gain(rate_rad_s, sample_period_s);
            states.rate_rad_s[lane] = rate_rad_s;
            states.keep[lane] = 1.0 - gain;
            states.gain[lane] = if is_driven { gain } else { 0.0 };
            states.x[lane] = x;
            states.drive[lane] = drive;
        };
        for (index, bank) in design.banks.iter().enumerate() {
            for &rate_rad_s in &bank.rates_rad_s {
                put(column, rate_rad_s, true, 0.0, index);
                remembers[column] = true;
                column += 1;
            }
            if bank.feed_through {
                feed_through.push((column, index));
                column += 1;
            }
        }
        for &rate_rad_s in &design.initial_rad_s {
            put(column, rate_rad_s, false, 1.0, 0);
            remembers[column] = true;
            column += 1;
        }
        put(column, 0.0, false, 1.0, 0);
        let source = |bank: &super::design::RelaxationBank| BankSignal {
            drive: bank.drive,
            first_gas_c: None,
            late: vec![0.0; bank.delay],
            is_held: !design.from_rest,
            next: 0,
            shift: match bank.drive {
                BankDrive::Output(output) => output_shift[output],
                _ => 0.0,
            },
        };
        let first = lanes.iter().map(|states| states.x).collect();
        let decays: Vec<bool> = (lanes.iter().zip(remembers.chunks(LANES)))
            .map(|(states, remembers)| remembers == [true; LANES] && states.gain == [0.0; LANES])
            .collect();
        Self {
            first,
            is_live: vec![true; decays.len()],
            decays,
            lanes,
            banks: design.banks.iter().map(source).collect(),
            drives: vec![[0.0; BATCH]; design.banks.len().max(1)],
            feed_through,
            remembers,
            output_shift: output_shift.to_vec(),
        }
    }

    /// Begins anew, as nothing is known of what was before.
    pub fn restart(&mut self) {
        self.lanes.iter_mut().zip(&self.first).for_each(|(states, first)| states.x = *first);
        self.banks.iter_mut().for_each(|bank| bank.late.fill(0.0));
    }

    /// For every panel whether it has another value than 0 in the batch that was written last.
    pub fn is_live(&self) -> &[bool] {
        &self.is_live
    }

    pub fn width(&self) -> usize {
        self.remembers.len()
    }

    /// The columns that remember, as the next row will have them; 0 for those that do not.
    pub fn states(&self) -> Vec<f64> {
        let states = self.lanes.iter().flat_map(|lanes| lanes.x);
        states.zip(&self.remembers).map(|(x, &remembers)| if remembers { x } else { 0.0 }).collect()
    }

    /// Writes the rows of a block from row `from` on, `rows` of them and [`BATCH`] at most, and
    /// steps behind them.
    pub fn fill(&mut self, block: &Block, gas: GasSource, from: usize, rows: usize, panels: &mut [Panel]) {
        let to = from + rows;
        for (bank, values) in self.banks.iter_mut().zip(&mut self.drives) {
            bank.drive(block, gas, from, &mut values[..rows]);
        }
        for ((is_live, is_decay), states) in self.is_live.iter_mut().zip(&self.decays).zip(&mut self.lanes) {
            if *is_decay {
                states.x = states.x.map(|x| if x < DECAYED { 0.0 } else { x });
            }
            *is_live = !is_decay || states.x != [0.0; LANES];
        }
        match block.interval_s.get(from..to) {
            Some(interval_s) => self.step_each(interval_s, panels),
            None => {
                pulp::Arch::new().dispatch(BatchSteps { lanes: &mut self.lanes, drives: &self.drives, rows, panels });
            }
        }
        for &(column, bank) in &self.feed_through {
            write(panels, column, &self.drives[bank][..rows], 0.0);
        }
        let first_output = self.remembers.len() - self.output_shift.len();
        for (output, (values, &shift)) in block.outputs.iter().zip(&self.output_shift).enumerate() {
            write(panels, first_output + output, &values[from..to], shift);
        }
    }
}

impl RegressionRows {
    /// Writes rows whose intervals differ, and steps over each.
    fn step_each(&mut self, interval_s: &[f64], panels: &mut [Panel]) {
        for (states, panel) in self.lanes.iter_mut().zip(panels) {
            let drives = states.drive.map(|bank| &self.drives[bank]);
            let is_driven = states.gain.map(|gain| gain > 0.0);
            for (n, &interval_s) in interval_s.iter().enumerate() {
                panel[n] = states.x;
                for lane in 0..LANES {
                    let gain = mesh::gain(states.rate_rad_s[lane], interval_s);
                    let drive = if is_driven[lane] { drives[lane][n] } else { 0.0 };
                    states.x[lane] = (1.0 - gain) * states.x[lane] + gain * drive;
                }
            }
            states.x = states.x.map(|x| if x.abs() < NOTHING { 0.0 } else { x });
        }
    }
}

fn write(panels: &mut [Panel], column: usize, values: &[f64], shift: f64) {
    for (lanes, value) in panels[column / LANES].iter_mut().zip(values) {
        lanes[column % LANES] = value - shift;
    }
}

impl BankSignal {
    fn drive(&mut self, block: &Block, gas: GasSource, from: usize, values: &mut [f64]) {
        let rows = from..from + values.len();
        let class_of = &block.class[rows.clone()];
        let gate = |values: &mut [f64], class: usize| {
            for (value, &of) in values.iter_mut().zip(class_of) {
                *value = if of as usize == class { *value } else { 0.0 };
            }
        };
        match self.drive {
            BankDrive::Input(input) => values.copy_from_slice(&block.inputs[input][rows]),
            BankDrive::Gated { input, class } => {
                values.copy_from_slice(&block.inputs[input][rows]);
                gate(values, class);
            }
            BankDrive::Loss { output, class } => {
                values.copy_from_slice(&block.outputs[output][rows.clone()]);
                match gas {
                    GasSource::Constant(gas_c) => values.iter_mut().for_each(|value| *value -= gas_c),
                    GasSource::Column => values.iter_mut().zip(&block.gas[rows]).for_each(|(value, gas)| *value -= gas),
                }
                gate(values, class);
            }
            BankDrive::Gas => {
                let first_c = *self.first_gas_c.get_or_insert(block.gas[from]);
                values.iter_mut().zip(&block.gas[rows]).for_each(|(value, gas_c)| *value = gas_c - first_c);
            }
            BankDrive::Output(output) => {
                values.copy_from_slice(&block.outputs[output][rows]);
                values.iter_mut().for_each(|value| *value -= self.shift);
            }
            BankDrive::Gate { class } => {
                values.fill(1.0);
                gate(values, class);
            }
        }
        if !self.late.is_empty() {
            if std::mem::take(&mut self.is_held) {
                self.late.fill(values[0]);
            }
            for value in values {
                std::mem::swap(value, &mut self.late[self.next]);
                self.next = if self.next + 1 == self.late.len() { 0 } else { self.next + 1 };
            }
        }
    }
}

/// The states of all panels, over the rows of a batch.
struct BatchSteps<'a> {
    lanes: &'a mut [States],
    drives: &'a [[f64; BATCH]],
    rows: usize,
    panels: &'a mut [Panel],
}

impl WithSimd for BatchSteps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { lanes, drives, rows, panels } = self;
        // Three panels side by side: while one waits for its product, the others step.
        let (lanes, panels) = steps::<3>(lanes, drives, rows, panels);
        let (lanes, panels) = steps::<2>(lanes, drives, rows, panels);
        steps::<1>(lanes, drives, rows, panels);
    }
}

/// Steps panels in groups of `Q`, and hands back those that are left.
#[inline(always)]
fn steps<'a, const Q: usize>(
    lanes: &'a mut [States],
    drives: &[[f64; BATCH]],
    rows: usize,
    panels: &'a mut [Panel],
) -> (&'a mut [States], &'a mut [Panel]) {
    let (groups, lanes_left) = lanes.as_chunks_mut::<Q>();
    let (targets, panels_left) = panels.as_chunks_mut::<Q>();
    for (group, target) in groups.iter_mut().zip(targets) {
        let states = *group;
        let drive = states.map(|states| states.drive.map(|bank| &drives[bank]));
        let mut x = states.map(|states| states.x);
        for n in 0..rows.min(BATCH) {
            for q in 0..Q {
                target[q][n] = x[q];
                let u = drive[q].map(|drive| drive[n]);
                x[q] = step(&states[q], x[q], u);
            }
        }
        for (states, x) in group.iter_mut().zip(x) {
            states.x = x.map(|x| if x.abs() < NOTHING { 0.0 } else { x });
        }
    }
    (lanes_left, panels_left)
}

/// Written out lane by lane: so it becomes vector instructions.
#[inline(always)]
fn step(states: &States, x: Lanes, u: Lanes) -> Lanes {
    let (a, g) = (&states.keep, &states.gain);
    [a[0] * x[0] + g[0] * u[0], a[1] * x[1] + g[1] * u[1], a[2] * x[2] + g[2] * u[2], a[3] * x[3] + g[3] * u[3]]
}
