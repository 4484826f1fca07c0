//! Stated standard errors, held against a thousand records whose truth is known.
//!
//! If standard errors are right, the interval R_k ± 1.96 se holds the truth in 95 % of all records.
//! A thousand records know that share to √(0.95 · 0.05 / 1000) = 0.7 %, so that 93–97 % is three of
//! those.

use anemo_tests::records::excitation::fraction;
use anemo_tests::records::foster::{Foster, FosterRecord, Poles, Start};
use anemo_tests::records::{Noise, random};
use diffusive::identify::record::RecordTable;
use diffusive::identify::{Constraints, InitialState};
use diffusive::identify::{IdentifyOptions, identify};
use diffusive::model::Model;
use dr_core::model::mesh;

/// Standard deviations on either side that hold 95 % of a normal distribution.
const Z: f64 = 1.959_964;

/// Number of intervals that held the truth.
#[derive(Debug, Default)]
struct Coverage {
    records: usize,
    /// By k.
    of: Vec<(usize, usize)>,
    steady: usize,
}

impl Coverage {
    fn count(&mut self, rates: usize, is_held: impl Fn(usize) -> bool, is_steady_held: bool) {
        self.of.resize(self.of.len().max(rates), (0, 0));
        for (k, (held, all)) in self.of.iter_mut().enumerate().take(rates) {
            *held += usize::from(is_held(k));
            *all += 1;
        }
        self.records += 1;
        self.steady += usize::from(is_steady_held);
    }

    /// Shares in percent: of every k, of all R_k, of the steady gain.
    fn percent(&self) -> (Vec<f64>, f64, f64) {
        let share = |held: usize, all: usize| 100.0 * held as f64 / all as f64;
        let (held, all) = self.of.iter().fold((0, 0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
        (self.of.iter().map(|of| share(of.0, of.1)).collect(), share(held, all), share(self.steady, self.records))
    }
}

/// The model of a record by what is given.
fn identified(record: &FosterRecord, sample_period_s: f64, constraints: Constraints) -> Model {
    let mut table = RecordTable::new(
        sample_period_s,
        vec![("power".into(), record.input_w.clone())],
        vec![("temperature".into(), record.output_c.clone())],
    )
    .unwrap();
    let options = IdentifyOptions { constraints, ..IdentifyOptions::default() };
    identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
}

/// A thousand records of random networks whose rates are those of the mesh that is asked for.
fn coverage(ridge: Option<f64>, told: impl Fn(Start) -> Option<InitialState>) -> Coverage {
    let mut coverage = Coverage::default();
    for seed in 0..1000 {
        let draw = &mut random(seed, 77);
        let order = 4 + (seed % 3) as usize;
        let rows = 2000 + (3000.0 * fraction(draw)) as usize;
        let sample_period_s = 0.1;
        // From the thesis' lower edge to 10 rad/s.
        let (first, _) = mesh::thesis_edges_rad_s(rows as f64 * sample_period_s, sample_period_s, 1);
        let rates_rad_s: Vec<f64> = (0..order).map(|k| mesh::rate_rad_s(first, 10.0, k, order)).collect();
        let resistances_k_per_w: Vec<f64> = (0..order).map(|_| 3.0 * libm::pow(10.0, fraction(draw))).collect();
        let start = if seed % 2 == 0 { Start::Rest } else { Start::Anywhere };
        let record = Foster {
            poles: Poles::Given { rates_rad_s, resistances_k_per_w },
            rows,
            sample_period_s,
            start,
            noise: Noise::white(0.05),
            seed,
            ..Foster::default()
        }
        .simulate();
        let given = Constraints {
            order: Some(order),
            edges_rad_s: Some((first, 10.0)),
            ridge,
            initial_state: told(start),
            ..Constraints::default()
        };
        let model = identified(&record, sample_period_s, given);
        let class = &model.pairs[0].classes["all"];
        let is_held = |estimate: f64, se: f64, truth: f64| (estimate - truth).abs() <= Z * se;
        coverage.count(
            order,
            |k| is_held(class.r_k_per_w[k], class.se_k_per_w[k], record.resistances_k_per_w[k]),
            is_held(class.steady_gain_k_per_w, class.se_steady_gain_k_per_w, record.steady_gain_k_per_w),
        );
    }
    coverage
}

fn covers(name: &str, coverage: &Coverage) {
    let (each, all, steady) = coverage.percent();
    println!("{name}: R_k {all:.1} %, by k {each:.1?}, steady gain {steady:.1} %");
    for share in each.iter().chain([&all, &steady]) {
        assert!((93.0..=97.0).contains(share), "{name}: {share:.1} % in {each:.1?}, {steady:.1}");
    }
}

fn told(start: Start) -> Option<InitialState> {
    Some(match start {
        Start::Rest => InitialState::Rest,
        Start::Anywhere => InitialState::Free,
    })
}

#[test]
fn least_squares_knows_how_sure_it_is() {
    covers("ridge 0, beginning given", &coverage(Some(0.0), told));
    covers("ridge 0, beginning chosen", &coverage(Some(0.0), |_| None));
}

#[test]
fn the_prior_that_is_chosen_leaves_the_standard_errors_true() {
    covers("prior chosen, beginning given", &coverage(None, told));
    covers("prior and beginning chosen", &coverage(None, |_| None));
}

/// Rates between those of any mesh, noise so small that too few rates show.
#[test]
fn edges_that_are_given_get_as_many_rates_as_the_record_shows() {
    for seed in [1, 2, 3] {
        let rates_rad_s: Vec<f64> = (0..9).map(|k| 0.0131 * 2.3_f64.powi(k)).collect();
        let resistances_k_per_w = (0..9).map(|k| 10.0 / f64::from(1 + k)).collect();
        let poles = Poles::Given { rates_rad_s, resistances_k_per_w };
        let noise = Noise::white(1e-4);
        let record = Foster { poles, rows: 20_000, sample_period_s: 0.1, noise, seed, ..Foster::default() }.simulate();
        let given = Constraints { edges_rad_s: Some((0.005, 31.0)), ..Constraints::default() };
        let model = identified(&record, 0.1, given);
        let class = &model.pairs[0].classes["all"];
        let off = class.steady_gain_k_per_w - record.steady_gain_k_per_w;
        println!("{} rates, gain off by {off} ± {}", class.r_k_per_w.len(), class.se_steady_gain_k_per_w);
        assert!(off.abs() < 4.0 * class.se_steady_gain_k_per_w, "{off} ± {}", class.se_steady_gain_k_per_w);
        assert!(class.se_steady_gain_k_per_w < 0.01 * record.steady_gain_k_per_w);
    }
}
