//! Common parts of measurements of identification's speed: records of any size, the work that is
//! timed, and this machine's limits.

use std::hint::black_box;
use std::time::Instant;

use diffusive::identify::InitialState;
use diffusive::identify::candidates::terms;
use diffusive::identify::design::{BankDrive, GasSource, RegressionDesign, RelaxationBank};
use diffusive::identify::drift;
use diffusive::identify::folds::FOLDS;
use diffusive::identify::gram::Gram;
use diffusive::identify::normal_equations::NormalEquations;
use diffusive::identify::pass::{Passed, pass};
use diffusive::identify::record::RecordTable;
use nalgebra::{DMatrix, DVector};

/// 2 kHz
pub const SAMPLE_PERIOD_S: f64 = 5e-4;

/// 2π times 1 mHz to 1 kHz, rad/s: as far as such a record can tell.
pub const EDGES_RAD_S: (f64, f64) = (std::f64::consts::TAU * 1e-3, std::f64::consts::TAU * 1e3);

/// Rows that a bit of the input lasts: 1 s.
const BIT: usize = 2_000;

/// A record of chance bits on every input, and an output that follows them slowly; a class for each
/// 10 s, in turn.
pub fn record(rows: usize, inputs: usize, classes: usize) -> RecordTable {
    let mut seed = 1_u64;
    let mut chance = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / (1_u64 << 24) as f64
    };
    let columns: Vec<(String, Vec<f64>)> = (0..inputs)
        .map(|input| {
            let bits = (0..rows.div_ceil(BIT)).map(|_| chance().round()).collect::<Vec<f64>>();
            (format!("u{input}"), (0..rows).map(|n| bits[n / BIT]).collect())
        })
        .collect();
    let (mut fast, mut slow) = (0.0, 0.0);
    let output: Vec<f64> = (0..rows)
        .map(|n| {
            let y = fast + slow + 0.1 * (chance() - 0.5);
            let drive: f64 = columns.iter().map(|(_, values)| values[n]).sum();
            fast += 1e-3 * (drive - fast);
            slow += 1e-5 * (drive - slow);
            y
        })
        .collect();
    let table =
        RecordTable::new(SAMPLE_PERIOD_S, columns, vec![("y".to_owned(), output)]).expect("the record is in order");
    if classes == 1 {
        return table;
    }
    let labels: Vec<String> = (0..classes).map(|class| format!("wind {class}")).collect();
    let of_row: Vec<&str> = (0..rows).map(|n| labels[n / (10 * BIT) % classes].as_str()).collect();
    table.with_events(&of_row).expect("the labels are few")
}

/// The regression that is timed: a mesh of `order` rates an input and class, from rest, with an
/// offset.
pub fn design(order: usize, inputs: usize, classes: usize) -> RegressionDesign {
    let (first, last) = EDGES_RAD_S;
    let rates: Vec<f64> = (0..order).map(|k| dr_core::model::mesh::rate_rad_s(first, last, k, order)).collect();
    let drives = (0..inputs).flat_map(|input| (0..classes).map(move |class| (input, class)));
    let bank = |(input, class)| RelaxationBank {
        drive: if classes == 1 { BankDrive::Input(input) } else { BankDrive::Gated { input, class } },
        rates_rad_s: rates.clone(),
        delay: 0,
        feed_through: false,
    };
    RegressionDesign { banks: drives.map(bank).collect(), initial_rad_s: Vec::new(), outputs: 1, from_rest: true }
}

/// The same regression with all columns that drifts of every size need.
pub fn drift_design(order: usize, rows: usize) -> RegressionDesign {
    let plain = design(order, 1, 1);
    let rates = &plain.banks[0].rates_rad_s;
    let poles = drift::poles(rates, rows as f64 * SAMPLE_PERIOD_S, SAMPLE_PERIOD_S);
    let bank = |drive, rates_rad_s| RelaxationBank { drive, rates_rad_s, delay: 0, feed_through: false };
    RegressionDesign {
        banks: vec![
            bank(BankDrive::Input(0), [&rates[..], &poles].concat()),
            bank(BankDrive::Output(0), poles.clone()),
        ],
        initial_rad_s: poles,
        outputs: 1,
        from_rest: false,
    }
}

/// One reading of a record in memory, for one design.
pub fn read(table: &mut RecordTable, design: &RegressionDesign) -> Passed {
    let designs = std::slice::from_ref(design);
    pass(table, designs, FOLDS, GasSource::Constant(0.0), u64::MAX, &mut |_| {}).expect("a table is read")
}

/// States, normal equations and solution: plain least squares on a record in memory. Resistances in
/// K/W, and the offset behind them.
pub fn solve(table: &mut RecordTable, design: &RegressionDesign) -> DVector<f64> {
    let passed = read(table, design);
    let terms = terms(&design.roles(), InitialState::Rest, false, &vec![0.0; design.banks.len()]);
    let problem = NormalEquations::of(&Gram::total(&passed.folds[0]), &terms, 1, 0);
    let mut theta = problem.solve(&DMatrix::zeros(terms.len(), terms.len()), None).theta;
    theta[terms.len() - 1] += passed.output_shift[0];
    theta
}

/// Operations that no way of doing it can spare: 3 a state (two products, a sum), 2 an entry of the
/// upper half of AᵀA.
pub fn flops_a_row(design: &RegressionDesign) -> f64 {
    let states: usize = design.banks.iter().map(|bank| bank.rates_rad_s.len()).sum();
    let width = design.width();
    (3 * states + width * (width + 1)) as f64
}

/// Bytes of a row in memory: its inputs, its output and its class.
pub fn bytes_a_row(inputs: usize) -> f64 {
    8.0 * (inputs as f64 + 1.0) + 4.0
}

/// Operations in s⁻¹ of one core: the best of some products of two matrices of 512 by 512.
pub fn flops_a_second() -> f64 {
    let n = 512;
    let (a, b) = (DMatrix::from_element(n, n, 0.5), DMatrix::from_element(n, n, 0.25));
    let mut product = DMatrix::zeros(n, n);
    2.0 * (n as f64).powi(3) / least_s(20, || product.gemm(1.0, black_box(&a), black_box(&b), 0.0))
}

/// Bytes in s⁻¹ that one core reads from memory: the best of some sums over 256 MiB.
pub fn bytes_a_second() -> f64 {
    let values = vec![1.0; 1 << 25];
    let total = || {
        let mut sums = [0.0; 16];
        for group in black_box(&values).as_chunks::<16>().0 {
            for (sum, value) in sums.iter_mut().zip(group) {
                *sum += value;
            }
        }
        black_box(sums);
    };
    size_of_val(values.as_slice()) as f64 / least_s(5, total)
}

/// The least time of some runs, s: on a machine that others use as well, that is the one they
/// disturbed least.
pub fn least_s(runs: usize, mut work: impl FnMut()) -> f64 {
    let time = |()| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    std::iter::repeat_n((), runs).map(time).fold(f64::INFINITY, f64::min)
}
