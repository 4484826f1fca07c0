//! The linear algebra of wind as feedback, on a record small enough to be gone through by hand.

use nalgebra::DVector;

use super::plan::{GasBanks, design};
use super::solver::Solver;
use super::terms::{ClassConductances, ConductanceColumns};
use super::*;
use crate::identify::candidates::{self, CandidateMesh};
use crate::identify::design::{GasSource, RegressionDesign, Role};
use crate::identify::gram::Gram;
use crate::identify::normal_equations::{NormalEquations, in_columns};
use crate::identify::options::InitialState;
use crate::identify::options::Signs;
use crate::identify::pass::{Passed, pass};
use crate::identify::prior::{Prior, Scales};
use crate::identify::record::RecordTable;
use crate::model::Structure;

const PERIOD_S: f64 = 0.1;
const ROWS: usize = 400;
const GAS_C: f64 = 17.0;

struct SmallRecord {
    powers_w: Vec<Vec<f64>>,
    temperatures_c: Vec<Vec<f64>>,
    class: Vec<usize>,
    winds: ClassConductances,
}

/// Two elements and three classes; temperatures are any numbers, since the columns do not ask where
/// they come from.
fn case() -> SmallRecord {
    let wave = |at: usize, n: usize, low: f64, swing: f64| low + swing * libm::sin(0.37 * (at + 1) as f64 * n as f64);
    let columns = |low: f64, swing: f64, from: usize| -> Vec<Vec<f64>> {
        (from..from + 2).map(|at| (0..ROWS).map(|n| wave(at, n, low, swing)).collect()).collect()
    };
    SmallRecord {
        powers_w: columns(0.04, 0.03, 0),
        temperatures_c: columns(25.0, 4.0, 2),
        class: (0..ROWS).map(|n| (n / 23 + n / 41) % 3).collect(),
        winds: ClassConductances { conductance: vec![vec![0.0, 8e-4, 1.6e-3], vec![0.0, 3e-4, -2e-4]], gas_c: GAS_C },
    }
}

fn passed(case: &SmallRecord, design: &RegressionDesign, gas: GasSource) -> Passed {
    let named = |name: &str, columns: &[Vec<f64>]| -> Vec<(String, Vec<f64>)> {
        columns.iter().enumerate().map(|(at, values)| (format!("{name}:{at}"), values.clone())).collect()
    };
    let labels = ["a", "b", "c"];
    let events: Vec<&str> = case.class.iter().map(|&class| labels[class]).collect();
    let mut table =
        RecordTable::new(PERIOD_S, named("power", &case.powers_w), named("temperature", &case.temperatures_c))
            .and_then(|table| table.with_events(&events))
            .unwrap();
    pass(&mut table, std::slice::from_ref(design), 2, gas, u64::MAX, &mut |_| {}).unwrap()
}

fn banks(gates: bool) -> GasBanks {
    if gates { GasBanks::Gates } else { GasBanks::None }
}

fn small_mesh() -> CandidateMesh {
    candidates::dense(PERIOD_S * ROWS as f64, PERIOD_S, 1.0, 1.5)
}

fn solver<'a>(roles: &'a [Role], design: &RegressionDesign, gates: bool) -> Solver<'a> {
    Solver {
        places: ConductanceColumns { roles, elements: 2, classes: 3, reference: 0, gates, follows: false },
        scales: Scales { drive: vec![1.0; design.banks.len()], thesis_rad_s: 0.1 },
        prior: Prior::Tapered(1e-9),
        initial_state: InitialState::Rest,
        sample_period_s: PERIOD_S,
        signs: &Signs::Any,
    }
}

/// States of w = u − ΔG (y − T_gas), stepped directly: rows by relaxations of both elements.
fn states_of_w(case: &SmallRecord, rates_rad_s: &[f64]) -> Vec<Vec<f64>> {
    let mut states = Vec::new();
    for element in 0..2 {
        for &rate in rates_rad_s {
            let gain = -libm::expm1(-rate * PERIOD_S);
            let (mut x, mut column) = (0.0, Vec::with_capacity(ROWS));
            for n in 0..ROWS {
                column.push(x);
                let taken = case.winds.conductance[element][case.class[n]];
                let w = case.powers_w[element][n] - taken * (case.temperatures_c[element][n] - case.winds.gas_c);
                x += gain * (w - x);
            }
            states.push(column);
        }
    }
    states
}

#[test]
fn sums_of_the_terms_are_those_of_states_that_w_drives() {
    let mesh = small_mesh();
    for gates in [false, true] {
        // Gas known: it is in the drive, and nothing is added to it. Unknown: it is in the terms.
        let gas = GasSource::Constant(if gates { 0.0 } else { GAS_C });
        let case = case();
        let winds = ClassConductances { gas_c: if gates { GAS_C } else { 0.0 }, ..case.winds.clone() };
        let design = design(&mesh, 2, 3, 0, banks(gates));
        let passed = passed(&case, &design, gas);
        let total = Gram::total(&passed.folds[0]);
        let roles = design.roles();
        let solver = solver(&roles, &design, gates);
        let terms = solver.places.terms(InitialState::Rest, &winds);
        let mut columns = states_of_w(&case, &mesh.rates_rad_s);
        columns.push(vec![1.0; ROWS]);
        assert_eq!(terms.len(), columns.len());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for output in 0..2 {
            let problem = NormalEquations::of(&total, &terms, 2, output);
            let y: Vec<f64> =
                case.temperatures_c[output].iter().map(|value| value - passed.output_shift[output]).collect();
            for (i, left) in columns.iter().enumerate() {
                // Sums of 400 products: rounding is 1e-13 of the largest that cancel in them,
                // losses of at most 0.02 W beside 0.07 W.
                let scale = dot(left, left).sqrt();
                assert!(
                    (problem.b[i] - dot(left, &y)).abs() < 1e-10 * scale * dot(&y, &y).sqrt(),
                    "b {i}, gates {gates}"
                );
                for (j, right) in columns.iter().enumerate() {
                    let bound = 1e-10 * scale * dot(right, right).sqrt();
                    assert!((problem.g[(i, j)] - dot(left, right)).abs() < bound, "{i} {j}, gates {gates}");
                }
            }
        }
    }
}

#[test]
fn slopes_are_differences_of_the_prediction() {
    let mesh = small_mesh();
    let case = case();
    for gates in [false, true] {
        let design = design(&mesh, 2, 3, 0, banks(gates));
        let roles = design.roles();
        let solver = solver(&roles, &design, gates);
        let winds = ClassConductances { gas_c: if gates { GAS_C } else { 0.0 }, ..case.winds.clone() };
        let terms = solver.places.terms(InitialState::Rest, &winds);
        let theta = DVector::from_fn(terms.len(), |k, _| 3.0 + libm::cos(k as f64));
        // A prediction is a weight for every column, so its derivative is one as well.
        let prediction = |winds: &ClassConductances| {
            DVector::from_vec(in_columns(&solver.places.terms(InitialState::Rest, winds), &theta, design.width()))
        };
        let slopes = solver.slopes(&terms, &theta, &winds);
        assert_eq!(slopes.len(), 4 + usize::from(gates));
        for (at, slope) in slopes.iter().enumerate() {
            // Bilinear in ΔG and T_gas: central differences are exact but for rounding.
            let h = if at == 4 { 1.0 } else { 1e-3 };
            let unit = DVector::from_fn(slopes.len(), |row, _| if row == at { h } else { 0.0 });
            let ahead = prediction(&solver.moved(&winds, &unit, 1.0));
            let behind = prediction(&solver.moved(&winds, &unit, -1.0));
            let difference = (ahead - behind) / (2.0 * h);
            let stated = DVector::from_vec(in_columns(
                std::slice::from_ref(slope),
                &DVector::from_element(1, 1.0),
                design.width(),
            ));
            assert!((&difference - &stated).norm() < 1e-9 * difference.norm(), "slope {at}, gates {gates}");
            assert!(stated.norm() > 0.0);
        }
    }
}

/// A record of one element that is the structure itself, without noise, and what a kelvin of it
/// takes from the next row.
fn held(loop_gain: f64, noise_k: f64) -> (RecordTable, CandidateMesh, ClassConductances) {
    let (resistances, rates_rad_s) = ([100.0, 50.0], vec![0.05, 0.5]);
    let gains: Vec<f64> = rates_rad_s.iter().map(|rate: &f64| -libm::expm1(-rate * PERIOD_S)).collect();
    let of_a_watt: f64 = resistances.iter().zip(&gains).map(|(resistance, gain)| resistance * gain).sum();
    let taken = [0.0, loop_gain / of_a_watt];
    let (mut x, mut powers_w, mut temperatures_c, mut events) = ([0.0; 2], Vec::new(), Vec::new(), Vec::new());
    for n in 0..ROWS {
        let (class, power_w) = ((n / 23) % 2, 0.04 + 0.03 * libm::sin(0.37 * (n * n % 101) as f64));
        let rise_k = x[0] * resistances[0] + x[1] * resistances[1];
        powers_w.push(power_w);
        temperatures_c.push(GAS_C + rise_k + noise_k * libm::sin(2.3 * (n * n % 89) as f64));
        events.push(["a", "b"][class]);
        for (x, gain) in x.iter_mut().zip(&gains) {
            *x += gain * (power_w - taken[class] * rise_k - *x);
        }
    }
    let table = RecordTable::new(
        PERIOD_S,
        vec![("power".to_owned(), powers_w)],
        vec![("temperature".to_owned(), temperatures_c)],
    )
    .and_then(|table| table.with_events(&events))
    .unwrap();
    (
        table,
        CandidateMesh { rates_rad_s, ..small_mesh() },
        ClassConductances { conductance: vec![taken.to_vec()], gas_c: 0.0 },
    )
}

fn one_element<'a>(roles: &'a [Role], design: &RegressionDesign) -> Solver<'a> {
    Solver {
        places: ConductanceColumns { roles, elements: 1, classes: 2, reference: 0, gates: false, follows: false },
        scales: Scales { drive: vec![1.0; design.banks.len()], thesis_rad_s: 0.1 },
        prior: Prior::Tapered(1e-13),
        initial_state: InitialState::Rest,
        sample_period_s: PERIOD_S,
        signs: &Signs::Any,
    }
}

#[test]
fn a_loss_that_takes_more_than_a_kelvin_of_a_kelvin_by_the_next_row_is_never_chosen() {
    for loop_gain in [0.9, 1.1] {
        let (mut table, mesh, winds) = held(loop_gain, 0.0);
        let design = design(&mesh, 1, 2, 0, GasBanks::None);
        let gas = GasSource::Constant(GAS_C);
        let passed = pass(&mut table, std::slice::from_ref(&design), 1, gas, u64::MAX, &mut |_| {}).unwrap();
        let total = Gram::total(&passed.folds[0]);
        let roles = design.roles();
        let solver = one_element(&roles, &design);
        // The truth explains all either way: only what it would do from row to row tells them
        // apart.
        let (terms, thetas, errors) = solver.linear(&total, &winds);
        let swing = passed.facts.outputs[0].sd().powi(2) * ROWS as f64;
        assert!(errors[0] < 1e-6 * swing, "{} of {swing}", errors[0]);
        let found = solver.held_loop_gain(0, &terms, &thetas[0], &winds);
        assert!((found - loop_gain).abs() < 1e-3, "{found}, true {loop_gain}");
        assert_eq!(solver.cost(&total, &winds).is_finite(), loop_gain < 1.0);

        let start = ClassConductances { conductance: vec![vec![0.0; 2]], gas_c: 0.0 };
        let solved = solver.solve(&total, start);
        let (terms, thetas, _) = solver.linear(&total, &solved);
        let gain = solver.held_loop_gain(0, &terms, &thetas[0], &solved);
        assert!(gain < 1.0, "{gain}");
        if loop_gain < 1.0 {
            assert!((solved.conductance[0][1] / winds.conductance[0][1] - 1.0).abs() < 1e-3, "{solved:?}");
        }
    }
}

#[test]
fn resistances_that_may_not_be_negative_are_not_and_winds_make_the_best_of_it() {
    let (mut table, mesh, winds) = held(0.02, -1e-2);
    // One rate that the record does not have, between two that it has: noise of any kind gives it a
    // sign.
    let mesh = CandidateMesh { rates_rad_s: vec![0.05, 0.12, 0.5, 2.0], ..mesh };
    let design = design(&mesh, 1, 2, 0, GasBanks::None);
    let passed = pass(&mut table, std::slice::from_ref(&design), 1, GasSource::Constant(GAS_C), u64::MAX, &mut |_| {});
    let total = Gram::total(&passed.unwrap().folds[0]);
    let roles = design.roles();
    let of = |signs: &Signs| {
        let solver = Solver { signs, ..one_element(&roles, &design) };
        let solved = solver.solve(&total, ClassConductances { conductance: vec![vec![0.0; 2]], gas_c: 0.0 });
        let (terms, thetas, _) = solver.linear(&total, &solved);
        let least = thetas[0].iter().take(4).fold(f64::INFINITY, |least, theta| least.min(*theta));
        // At the best winds no step is left.
        let step = solver.step(&total, &solved).change[0] / solved.conductance[0][1];
        assert_eq!(terms.len(), 5);
        (least, solved.conductance[0][1] / winds.conductance[0][1] - 1.0, step)
    };
    let (any, held) = (of(&Signs::Any), of(&Signs::AllPositive));
    assert!(any.0 < 0.0 && held.0 == 0.0, "{any:?} {held:?}");
    assert!(held.1.abs() < 0.02 && held.2.abs() < 1e-3, "{held:?}");
}

#[test]
fn signs_that_were_asked_for_are_in_the_model() {
    let of = |signs: Signs| {
        let (mut table, ..) = held(0.02, -1e-2);
        let options = IdentifyOptions {
            structure: Some(Structure::Conductance),
            gas: GasGiven::ConstantC(GAS_C),
            signs,
            ..IdentifyOptions::default()
        };
        identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
    };
    let (any, held) = (of(Signs::Any), of(Signs::AllPositive));
    let least = |model: &Model| {
        model.pairs[0].classes.values().flat_map(|class| &class.r_k_per_w).fold(f64::INFINITY, |a, b| a.min(*b))
    };
    assert!(least(&any) < 0.0 && !any.pairs[0].non_negative, "{}", least(&any));
    assert!(least(&held) >= 0.0 && held.pairs[0].non_negative && held.chosen.non_negative, "{}", least(&held));
}
