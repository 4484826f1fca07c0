//! Rows of the regression, made one after the other from the record: exact states, one step a sample.
//!
//! ```text
//! x ← x + g (u − x),    g = 1 − e^(−ξ Ts)        u is held over [t_n, t_{n+1})
//! ```
//!
//! In f64 the plain update keeps ten digits at ξTs = 1e-6 (in f32 it would not: `dr_core::model::relaxation`). It is written as
//! a x + g u, which has one operation less between a state and its successor: that chain is what limits the speed.

use dr_core::model::mesh;

use super::design::{Design, Drive};

/// What one row of a record holds.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    pub inputs: &'a [f64],
    pub outputs: &'a [f64],
    pub class: usize,
    pub gas_c: f64,
}

/// The state between two rows.
pub struct Rows {
    banks: Vec<BankState>,
    /// Present value and factor of every initial decay.
    initial: Vec<(f64, f64)>,
    outputs: usize,
    width: usize,
}

struct BankState {
    drive: Drive,
    feed_through: bool,
    /// e^(−ξ Ts) and 1 − e^(−ξ Ts)
    keep: Vec<f64>,
    gain: Vec<f64>,
    x: Vec<f64>,
    /// Drives that have not arrived yet, oldest at `next`.
    late: Vec<f64>,
    next: usize,
}

impl Rows {
    pub fn new(design: &Design, sample_period_s: f64) -> Self {
        let banks = design.banks.iter().map(|bank| {
            let gain: Vec<f64> = bank.rates_rad_s.iter().map(|&rate| mesh::gain(rate, sample_period_s)).collect();
            BankState {
                drive: bank.drive,
                feed_through: bank.feed_through,
                keep: gain.iter().map(|gain| 1.0 - gain).collect(),
                x: vec![0.0; gain.len()],
                gain,
                late: vec![0.0; bank.delay],
                next: 0,
            }
        });
        let decay = |&rate: &f64| (1.0, 1.0 - mesh::gain(rate, sample_period_s));
        Self {
            banks: banks.collect(),
            initial: design.initial_rad_s.iter().map(decay).collect(),
            outputs: design.outputs,
            width: design.width(),
        }
    }

    pub fn width(&self) -> usize {
        self.width
    }

    /// The columns that remember, as the next row will have them; 0 for those that do not.
    pub fn states(&self) -> Vec<f64> {
        let mut states = Vec::with_capacity(self.width);
        for bank in &self.banks {
            states.extend(&bank.x);
            states.extend(bank.feed_through.then_some(0.0));
        }
        states.extend(self.initial.iter().map(|(value, _)| value));
        states.resize(self.width, 0.0);
        states
    }

    /// Writes the row of `sample` and steps to the next one.
    #[inline]
    pub fn row(&mut self, sample: Sample<'_>, row: &mut [f64]) {
        let mut at = 0;
        for bank in &mut self.banks {
            let mut drive = match bank.drive {
                Drive::Input(input) => sample.inputs[input],
                Drive::Gated { input, class } => gated(sample.class == class, sample.inputs[input]),
                Drive::Loss { output, class } => gated(sample.class == class, sample.outputs[output] - sample.gas_c),
                Drive::Gate { class } => gated(sample.class == class, 1.0),
            };
            if !bank.late.is_empty() {
                std::mem::swap(&mut drive, &mut bank.late[bank.next]);
                bank.next = if bank.next + 1 == bank.late.len() { 0 } else { bank.next + 1 };
            }
            let order = bank.x.len();
            let columns = &mut row[at..at + order];
            for (((column, x), keep), gain) in columns.iter_mut().zip(&mut bank.x).zip(&bank.keep).zip(&bank.gain) {
                *column = *x;
                *x = keep * *x + gain * drive;
            }
            at += order;
            if bank.feed_through {
                row[at] = drive;
                at += 1;
            }
        }
        for (value, factor) in &mut self.initial {
            row[at] = *value;
            *value *= *factor;
            at += 1;
        }
        row[at] = 1.0;
        row[at + 1..at + 1 + self.outputs].copy_from_slice(sample.outputs);
    }
}

fn gated(open: bool, value: f64) -> f64 {
    if open { value } else { 0.0 }
}
