//! Bodies whose conductance to the surroundings grows with temperature, simulated by small explicit
//! steps of their own, against what is identified.

use dr_core::model::Reachability;

use super::super::record::RecordTable;
use super::super::validate::{ValidationStart, validate};
use super::super::{IdentifyOptions, Losses, identify};
use super::elements;
use super::source::{LossColumns, LossSource};
use crate::model::{Model, Structure};
use crate::predict::analysis_report::{AnalysisReport, AnalysisRequest};
use crate::predict::closed::{LoopStart, predict};
use crate::predict::scenario::{Heated, Heater, Scenario};

const NOISE_K: f64 = 0.01;
const AMBIENT_C: f64 = 21.5;

/// A heated body of capacity C with the conductance G_0 (1 + β ΔT) to the surroundings, coupled to
/// others that only it heats: (conductance in W/K, capacity in J/K) each.
struct Body {
    conductance_w_per_k: f64,
    growth_per_k: f64,
    capacity_j_per_k: f64,
    beside: &'static [(f64, f64)],
}

/// A sensor on a small holder, and a block with a slow neighbour that takes a third of the heat up.
const SMALL: Body =
    Body { conductance_w_per_k: 0.02, growth_per_k: 0.003, capacity_j_per_k: 0.2, beside: &[(0.03, 0.6)] };
const LARGE: Body =
    Body { conductance_w_per_k: 0.05, growth_per_k: 0.003, capacity_j_per_k: 1.0, beside: &[(0.2, 0.5), (0.02, 1.5)] };

struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

impl Body {
    /// Power that holds a steady rise.
    fn steady_w(&self, rise_k: f64) -> f64 {
        self.conductance_w_per_k * rise_k * (1.0 + self.growth_per_k * rise_k)
    }

    /// Rises at the start of every sample, from rest, by two hundred Heun steps a sample.
    fn rises_k(&self, power_w: &[f64], period_s: f64) -> Vec<f64> {
        let mut x = vec![0.0; 1 + self.beside.len()];
        let slope = |x: &[f64], power_w: f64| -> Vec<f64> {
            let of =
                |(at, (conductance, capacity)): (usize, &(f64, f64))| (conductance * (x[0] - x[at + 1]), *capacity);
            let exchanged: Vec<(f64, f64)> = self.beside.iter().enumerate().map(of).collect();
            let lost = self.steady_w(x[0]) + exchanged.iter().map(|(power_w, _)| power_w).sum::<f64>();
            let own = (power_w - lost) / self.capacity_j_per_k;
            std::iter::once(own).chain(exchanged.iter().map(|(power_w, capacity)| power_w / capacity)).collect()
        };
        let step_s = period_s / 200.0;
        power_w
            .iter()
            .map(|&power_w| {
                let now = x[0];
                for _ in 0..200 {
                    let first = slope(&x, power_w);
                    let trial: Vec<f64> = x.iter().zip(&first).map(|(x, slope)| x + step_s * slope).collect();
                    let second = slope(&trial, power_w);
                    x.iter_mut().zip(first.iter().zip(&second)).for_each(|(x, (a, b))| *x += 0.5 * step_s * (a + b));
                }
                now
            })
            .collect()
    }

    /// A random two-level record between no heat and what would hold `rise_k`, after a stretch of
    /// rest.
    fn record(&self, rise_k: f64, seed: u64, ambient_c: f64) -> RecordTable {
        const PERIOD_S: f64 = 0.2;
        let mut random = Random(seed);
        let high_w = self.steady_w(rise_k);
        let mut level = 0.0;
        let power_w: Vec<f64> = (0..4000)
            .map(|row| {
                if row >= 20 && row % 40 == 20 {
                    // More often on than off, so that the body does warm to the level.
                    level = if random.uniform() < 0.7 { high_w } else { 0.0 };
                }
                level
            })
            .collect();
        let rises_k = self.rises_k(&power_w, PERIOD_S);
        let read_c = rises_k.iter().map(|rise_k| ambient_c + rise_k + NOISE_K * random.normal()).collect();
        RecordTable::new(PERIOD_S, vec![("p".to_owned(), power_w)], vec![("t".to_owned(), read_c)]).unwrap()
    }
}

fn identified(record: &mut RecordTable, losses: Losses) -> Model {
    let options = IdentifyOptions { losses, ..IdentifyOptions::default() };
    identify(record, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
}

fn rmse(model: &Model, record: &mut RecordTable, start: ValidationStart) -> f64 {
    validate(model, record, start, &mut |_| {}).unwrap().outputs[0].rmse
}

#[test]
fn a_body_trained_to_60_k_is_predicted_at_20_k_to_twice_the_noise_and_its_growth_is_found() {
    for (name, body) in [("small", SMALL), ("large", LARGE)] {
        for seed in 1..=3 {
            let model = identified(&mut body.record(60.0, seed, AMBIENT_C), Losses::Growing);
            let b = model.losses.as_ref().unwrap().elements[0].b_per_k;
            // Another day, at another temperature of the room.
            let mut at_20_k = body.record(20.0, seed + 100, 24.0);
            let rmse = rmse(&model, &mut at_20_k, ValidationStart::Estimate);
            println!("{name}, seed {seed}: b {} ± {} 1/K, rmse {rmse} K", b.value, b.se);
            assert!((b.value / body.growth_per_k - 1.0).abs() < 0.1, "{name} {seed}: {b:?}");
            // What the stretch between two samples adds is a percent of b.
            assert!((b.value - body.growth_per_k).abs() < 4.0 * b.se + 0.01 * b.value, "{name} {seed}: {b:?}");
            assert!(rmse <= 2.0 * NOISE_K, "{name} {seed}: {rmse}");
        }
    }
}

#[test]
fn auto_takes_losses_that_leave_no_doubt_and_none_of_a_linear_body() {
    let model = identified(&mut LARGE.record(60.0, 1, AMBIENT_C), Losses::Auto);
    let asked = identified(&mut LARGE.record(60.0, 1, AMBIENT_C), Losses::Growing);
    let b = |model: &Model| model.losses.as_ref().unwrap().elements[0].b_per_k;
    assert!((b(&model).value - b(&asked).value).abs() < b(&asked).se, "{:?} {:?}", b(&model), b(&asked));
    let linear = Body { growth_per_k: 0.0, ..LARGE };
    for seed in 1..=3 {
        let mut record = linear.record(60.0, seed, AMBIENT_C);
        assert_eq!(identified(&mut record, Losses::Auto), identified(&mut record, Losses::None));
        // Asked for, it is next to nothing, and said not to be told from it.
        let b = b(&identified(&mut record, Losses::Growing));
        println!("seed {seed}: b {} ± {}", b.value, b.se);
        assert!(b.value < 1e-4 && b.value < 4.0 * b.se, "{b:?}");
    }
}

#[test]
fn losses_of_nothing_are_the_linear_model_to_the_bit() {
    let mut record = SMALL.record(60.0, 1, AMBIENT_C);
    let options = IdentifyOptions::default();
    let plain = identified(&mut record, Losses::None);
    let none = elements(&plain);
    let mut source = LossSource::new(&mut record, &none, LossColumns::Taken, false);
    let same = identify(&mut source, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap();
    assert_eq!(plain.to_json(), same.to_json());
    // And in motion.
    let mut lossy = plain.clone();
    crate::model::testing::add_loss(&mut lossy, 0.0);
    let mut other = SMALL.record(20.0, 2, AMBIENT_C);
    let rows = |model: &Model, record: &mut RecordTable| {
        let mut rows = Vec::new();
        validate(model, record, ValidationStart::Rest, &mut |row| rows.push(row.predicted[0].to_bits())).unwrap();
        rows
    };
    assert_eq!(rows(&plain, &mut other), rows(&lossy, &mut other));
}

#[test]
fn two_elements_have_a_growth_each() {
    // Two bodies that know each other by a conductance, heated at random times of their own.
    const PERIOD_S: f64 = 0.2;
    let (growth_per_k, conductance_w_per_k, between_w_per_k) = ([0.003, 0.006], [0.05, 0.04], 0.01);
    let mut random = Random(5);
    let (mut x, mut level) = ([0.0, 0.0], [0.0, 0.0]);
    let (mut power_w, mut read_c) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    for row in 0..6000 {
        for i in 0..2 {
            if row >= 20 && row % 40 == 20 {
                level[i] = if random.uniform() < 0.7 { 3.5 } else { 0.0 };
            }
            power_w[i].push(level[i]);
            read_c[i].push(AMBIENT_C + x[i] + NOISE_K * random.normal());
        }
        for _ in 0..500 {
            let slope = |i: usize| {
                let lost_w = conductance_w_per_k[i] * x[i] * (1.0 + growth_per_k[i] * x[i]);
                level[i] - lost_w - between_w_per_k * (x[i] - x[1 - i])
            };
            x = [x[0] + slope(0) * PERIOD_S / 500.0, x[1] + slope(1) * PERIOD_S / 500.0];
        }
    }
    let [first_w, second_w] = power_w;
    let [first_c, second_c] = read_c;
    let inputs = vec![("p1".to_owned(), first_w), ("p2".to_owned(), second_w)];
    let outputs = vec![("t1".to_owned(), first_c), ("t2".to_owned(), second_c)];
    let model = identified(&mut RecordTable::new(PERIOD_S, inputs, outputs).unwrap(), Losses::Growing);
    let elements = &model.losses.as_ref().unwrap().elements;
    for (i, loss) in elements.iter().enumerate() {
        let truth = growth_per_k[i] * conductance_w_per_k[i];
        let g = loss.g_w_per_k2;
        println!("g {} ± {} for {truth} W/K², b {:?}", g.value, g.se, loss.b_per_k);
        assert_eq!((loss.input.as_str(), loss.output.as_str()), ([["p1", "t1"], ["p2", "t2"]][i][0], ["t1", "t2"][i]));
        assert!((g.value / truth - 1.0).abs() < 0.1, "{g:?} for {truth}");
    }
}

#[test]
fn a_held_temperature_takes_the_power_and_the_time_that_the_body_does() {
    const RISE_K: f64 = 40.0;
    const TICK_S: f64 = 0.02;
    let model = identified(&mut SMALL.record(60.0, 1, AMBIENT_C), Losses::Growing);
    let (low_w, high_w) = (0.0, SMALL.steady_w(75.0));
    let target_c = model.offset_c + RISE_K;
    let drive = dr_core::control::Drive::Temperature { target_c: target_c as f32 };
    let scenario = Scenario {
        sample_period_s: TICK_S,
        ticks: 10_000,
        winds: vec![(0, 0)],
        elements: vec![Heated { name: "p".to_owned(), drive, heater: Heater::Fixed { low_w, high_w } }],
        gas_c: None,
    };
    let predicted = &predict(&model, &scenario, LoopStart::Rest).unwrap().elements[0];

    // The body itself: under the high level until it is there, then held, while the holder warms.
    let rises_k = SMALL.rises_k(&vec![high_w; 10_000], TICK_S);
    let met = rises_k.iter().position(|rise_k| *rise_k >= RISE_K).unwrap();
    let met_s = met as f64 * TICK_S;
    let first_met_s = predicted.first_met_s.unwrap();
    assert!((first_met_s / met_s - 1.0).abs() < 0.01, "{first_met_s} s for {met_s} s");
    let (coupling, capacity) = SMALL.beside[0];
    let on_its_way = SMALL.rises_k(&vec![high_w; met], TICK_S);
    let mut holder_k = 0.0;
    for rise_k in on_its_way {
        holder_k += TICK_S * coupling * (rise_k - holder_k) / capacity;
    }
    for tick in met + 1..scenario.ticks {
        holder_k += TICK_S * coupling * (RISE_K - holder_k) / capacity;
        let truth_w = SMALL.steady_w(RISE_K) + coupling * (RISE_K - holder_k);
        // A tick or two after it was met, where the limit of the loop begins to hold.
        if tick > met + 5 {
            let power_w = predicted.limit_w[tick];
            assert!((power_w / truth_w - 1.0).abs() < 0.01, "tick {tick}: {power_w} W for {truth_w} W");
        }
    }
    let tail = &predicted.sampled_w[5_000..];
    let mean_w = tail.iter().sum::<f64>() / tail.len() as f64;
    assert!((mean_w / SMALL.steady_w(RISE_K) - 1.0).abs() < 0.01, "{mean_w}");

    let request = AnalysisRequest {
        target_k: Some(RISE_K),
        power_low_w: Some(low_w),
        power_high_w: Some(high_w),
        ..AnalysisRequest::default()
    };
    let held = AnalysisReport::new(&model, &request).unwrap().analysis.held.unwrap();
    let Reachability::Reachable { steady_power_w } = held.verdict else { panic!("{held:?}") };
    assert!((steady_power_w / SMALL.steady_w(RISE_K) - 1.0).abs() < 0.01, "{held:?}");
    assert!((held.reaching_time_s.unwrap() / met_s - 1.0).abs() < 0.01, "{held:?} for {met_s}");
    // What the linear part alone could hold, the body cannot.
    let most = AnalysisRequest { target_k: Some(76.0), ..request };
    let beyond = AnalysisReport::new(&model, &most).unwrap().analysis.held.unwrap();
    let Reachability::HighLevelTooCold { most_rise_k } = beyond.verdict else { panic!("{beyond:?}") };
    assert!((most_rise_k - 75.0).abs() < 0.75, "{most_rise_k}");
}

#[test]
fn what_losses_do_not_go_with_is_refused() {
    let refused = |change: fn(&mut IdentifyOptions)| {
        let mut options = IdentifyOptions { losses: Losses::Growing, ..IdentifyOptions::default() };
        change(&mut options);
        let mut record = SMALL.record(60.0, 1, AMBIENT_C);
        identify(&mut record, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap_err().to_string()
    };
    let conductance = refused(|options| options.structure = Some(Structure::Conductance));
    assert!(conductance.contains("are for structure `symbol`"), "{conductance}");
    let at_once = refused(|options| options.constraints.feed_through = Some(true));
    assert!(at_once.contains("do not go together"), "{at_once}");
}
