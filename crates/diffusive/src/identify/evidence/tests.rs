//! Records with known truth.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::Distribution;

use super::columns::{OutputTable, factor_of};
use super::poles::Transient;
use super::search::{Asked, search};
use crate::identify::design::{BankDrive, RegressionDesign, RelaxationBank};
use crate::identify::options::InitialState;
use crate::identify::record::Block;
use crate::random::StandardNormal;

/// A body of 5 and 20 K/W with 1 and 20 s in a room of 25 °C, rows every 0.1 s, 10 mK of noise.
fn record(power_w: &[f64], delay: usize, seed: u64) -> OutputTable {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut states = [power_w[0]; 2];
    let mut output = Vec::new();
    for n in 0..power_w.len() {
        let noise: f64 = StandardNormal.sample(&mut random);
        output.push(25.0 + 5.0 * states[0] + 20.0 * states[1] + 0.01 * noise);
        let drive = power_w[n.saturating_sub(delay)];
        for (state, tau_s) in states.iter_mut().zip([1.0, 20.0]) {
            *state += -libm::expm1(-0.1 / tau_s) * (drive - *state);
        }
    }
    let block = Block {
        inputs: vec![power_w.to_vec()],
        class: vec![0; output.len()],
        outputs: vec![output],
        ..Block::default()
    };
    OutputTable { blocks: vec![block], period_s: 0.1 }
}

fn asked() -> Asked {
    Asked { may_move: true, may_answer_at_once: true, ..Asked::default() }
}

#[test]
fn intervals_of_a_step_and_of_a_cooling_curve_hold_the_gain() {
    let step: Vec<f64> = (0..2000).map(|n| if n < 2 { 0.0 } else { 2.0 }).collect();
    let cooling: Vec<f64> = (0..2000).map(|n| if n < 2 { 2.0 } else { 0.0 }).collect();
    for (name, power_w) in [("step", step), ("cooling", cooling)] {
        let mut held = 0;
        for seed in 0..5 {
            let table = record(&power_w, 0, seed);
            let found = search(&table, &asked());
            let gain = found.average.gain(0);
            let [low, high] = gain.interval(0.95);
            println!("{name} {seed}: {} in {low} to {high}", gain.mean());
            assert!(high - low < 3.0, "{name} {seed}: {low} to {high}");
            held += u32::from((low..=high).contains(&25.0));
        }
        assert!(held >= 4, "{name}: {held} of 5");
    }
}

#[test]
fn a_dead_time_is_found_and_missing_rows_cost_next_to_nothing() {
    let power_w: Vec<f64> = (0..2000).map(|n| if (50..=1200).contains(&n) { 2.0 } else { 0.0 }).collect();
    let whole = record(&power_w, 7, 3);
    let mut holed = whole.clone();
    for row in [60, 61, 700] {
        // A row that is missing has the value before it.
        holed.blocks[0].outputs[0][row] = holed.blocks[0].outputs[0][row - 1];
        holed.blocks[0].missing.push(row as u32);
    }
    let [whole, holed] = [whole, holed].map(|table| {
        let found = search(&table, &asked());
        assert_eq!(found.delays(&found.average.members[0].1), [7]);
        found.average.gain(0).interval(0.95)
    });
    println!("{whole:?}, with missing rows {holed:?}");
    assert!(whole[0] < 25.0 && 25.0 < whole[1] && holed[0] < 25.0 && 25.0 < holed[1]);
    assert!(holed[1] - holed[0] < 1.2 * (whole[1] - whole[0]), "{whole:?}, {holed:?}");
}

/// Poles of 3, 8 and 14 K/W with 50 µs, 0.1 s and 80 s, in `per_decade` rows a decade from 1 µs to
/// 1 000 s behind a first one at 0 s, 1 W, 10 mK of noise.
fn transient(per_decade: usize, seed: u64) -> OutputTable {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let after = (0..=9 * per_decade).map(|n| libm::pow(10.0, n as f64 / per_decade as f64 - 6.0));
    let time_s: Vec<f64> = [0.0].into_iter().chain(after).collect();
    let poles = [(3.0, 5e-5), (8.0, 0.1), (14.0, 80.0)];
    let rise = |time_s: &f64| -> f64 { poles.iter().map(|(r, tau_s)| -r * libm::expm1(-time_s / tau_s)).sum() };
    let output = time_s.iter().map(|time_s| 22.0 + rise(time_s) + 0.01 * StandardNormal.sample(&mut random)).collect();
    let mut interval_s: Vec<f64> = time_s.windows(2).map(|two| two[1] - two[0]).collect();
    interval_s.push(1.0);
    let rows = time_s.len();
    let block = Block {
        inputs: vec![vec![1.0; rows]],
        outputs: vec![output],
        class: vec![0; rows],
        interval_s,
        ..Block::default()
    };
    OutputTable { blocks: vec![block], period_s: 1e-6 }
}

#[test]
fn the_interval_of_a_log_spaced_transient_holds_the_gain_and_its_poles_are_found() {
    let asked = Asked { initial_state: Some(InitialState::Rest), delays: Some(vec![0]), ..Asked::default() };
    let mut held = 0;
    for seed in 0..8 {
        let table = transient(50, seed);
        let [low, high] = search(&table, &asked).average.gain(0).interval(0.95);
        assert!(high - low < 3.0, "{seed}: {low} to {high}");
        held += u32::from((low..=high).contains(&25.0));
        let found = Transient::of(&table, InitialState::Rest).model().unwrap().model;
        assert_eq!(found.free_rates, 3, "{seed}");
        for (r, expected) in found.theta.iter().zip([14.0, 8.0, 3.0]) {
            assert!((r / expected - 1.0).abs() < 0.01, "{seed}: {r} for {expected} K/W");
        }
    }
    assert!(held >= 7, "{held} of 8");
}

#[test]
fn rows_of_equal_intervals_are_those_of_a_uniform_record() {
    let power_w: Vec<f64> = (0..1000).map(|n| if n % 300 < 120 { 2.0 } else { 0.5 }).collect();
    let uniform = record(&power_w, 0, 5);
    let mut timed = uniform.clone();
    timed.blocks[0].interval_s = vec![0.1; 1000];
    let bank =
        RelaxationBank { drive: BankDrive::Input(0), rates_rad_s: vec![0.01, 0.3, 7.0], delay: 2, feed_through: true };
    let design = RegressionDesign { banks: vec![bank], initial_rad_s: vec![0.02, 5.0], outputs: 1, from_rest: false };
    let [(a, ..), (b, ..)] = [&uniform, &timed].map(|table| factor_of(table, &design, 0, 1000));
    for row in 0..design.width() {
        for column in row..design.width() {
            let (one, other) = (a.at(row, column), b.at(row, column));
            assert!((one - other).abs() <= 1e-11 * one.abs().max(1.0), "{row}, {column}: {one}, {other}");
        }
    }
}
