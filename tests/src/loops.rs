//! Closed loops for tests: a structure of eight poles in three winds, and a one-bit loop around it
//! that shares no code with the prediction.

use std::collections::BTreeMap;

use diffusive::model::{Chosen, Class, FORMAT, Model, ModelOutput, Pair, Provenance, Structure, VERSION};
use diffusive::predict::scenario::{Heated, Heater, Scenario};
use dr_core::control::Drive;

pub const RATES_RAD_S: [f64; 8] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
pub const LABELS: [&str; 3] = ["still", "breeze", "gale"];
/// By wind.
pub const R_K_PER_W: [[f64; 8]; 3] = [
    [60.0, 90.0, 130.0, 120.0, 30.0, 3.0, 0.3, 0.05],
    [57.0, 80.0, 100.0, 95.0, 27.0, 2.9, 0.3, 0.05],
    [54.0, 70.0, 80.0, 75.0, 24.0, 2.8, 0.3, 0.05],
];
pub const LEVELS_W: (f64, f64) = (0.0015, 0.06);
pub const OFFSET_C: f64 = 20.0;

/// The truth as a model.
pub fn symbol_model() -> Model {
    let output = ModelOutput {
        name: "temperature_c_sector1".to_owned(),
        offset_c: OFFSET_C,
        se_offset_c: 0.0,
        residual_rms: 0.0,
        fit_percent: 100.0,
        spread_rms: None,
        whiteness: None,
        drift: None,
        forecast_rms: None,
    };
    let class = |r: [f64; 8]| Class {
        r_k_per_w: r.to_vec(),
        se_k_per_w: vec![0.0; 8],
        covariance: None,
        steady_gain_k_per_w: r.iter().sum(),
        se_steady_gain_k_per_w: 0.0,
        interval_95: None,
        feed_through_k_per_w: 0.0,
        se_feed_through_k_per_w: 0.0,
    };
    let pair = Pair {
        input: "power_w_sector1".to_owned(),
        output: output.name.clone(),
        mesh_rad_s: RATES_RAD_S.to_vec(),
        se_rate_rad_s: None,
        dead_time_samples: 0,
        non_negative: true,
        classes: LABELS.iter().zip(R_K_PER_W).map(|(label, r)| ((*label).to_owned(), class(r))).collect(),
    };
    Model {
        format: FORMAT.to_owned(),
        version: VERSION,
        structure: Structure::Symbol,
        sample_period_s: 0.01,
        inputs: vec![pair.input.clone()],
        outputs: vec![output],
        pairs: vec![pair],
        event_column: Some("event".to_owned()),
        classes: LABELS.map(str::to_owned).to_vec(),
        conductance_w_per_k: BTreeMap::new(),
        wind: None,
        ambient: None,
        losses: None,
        offset_c: OFFSET_C,
        residual_rms: 0.0,
        fit_percent: 100.0,
        forecast_rms: None,
        supported: true,
        advice: Vec::new(),
        warnings: Vec::new(),
        chosen: Chosen::default(),
        provenance: Provenance { input_range: vec![[LEVELS_W.0, LEVELS_W.1]], ..Provenance::default() },
        end: None,
    }
}

/// One element held at a temperature, at 100 Hz.
pub fn scenario(target_c: f32, winds: Vec<(usize, usize)>, ticks: usize) -> Scenario {
    let heater = Heater::Fixed { low_w: LEVELS_W.0, high_w: LEVELS_W.1 };
    let heated = Heated { name: "sector1".to_owned(), drive: Drive::Temperature { target_c }, heater };
    Scenario { sample_period_s: 0.01, ticks, winds, elements: vec![heated], gas_c: None }
}

/// The structure by itself: one set of relaxations a wind, of which only those of the present wind
/// are heated.
#[derive(Default)]
pub struct Truth {
    x: [[f64; 8]; 3],
}

impl Truth {
    pub fn temperature_c(&self) -> f64 {
        let rise = |(x, r): (&[f64; 8], [f64; 8])| x.iter().zip(r).map(|(x, r)| x * r).sum::<f64>();
        OFFSET_C + self.x.iter().zip(R_K_PER_W).map(rise).sum::<f64>()
    }

    pub fn heat(&mut self, wind: usize, power_w: f64, period_s: f64) {
        for (own, x) in self.x.iter_mut().enumerate() {
            let u = if own == wind { power_w } else { 0.0 };
            for (x, rate) in x.iter_mut().zip(RATES_RAD_S) {
                *x += (1.0 - libm::exp(-rate * period_s)) * (u - *x);
            }
        }
    }
}

/// Powers that a one-bit loop takes from rest, and where it first was at its target: powers in W by
/// tick, tick.
pub fn closed(target_c: f64, class: &[usize], period_s: f64) -> (Vec<f64>, Option<usize>) {
    let mut truth = Truth::default();
    let mut met = None;
    let powers = class.iter().enumerate().map(|(tick, &wind)| {
        let warm = truth.temperature_c() >= target_c;
        if warm {
            met.get_or_insert(tick);
        }
        let power_w = if warm { LEVELS_W.0 } else { LEVELS_W.1 };
        truth.heat(wind, power_w, period_s);
        power_w
    });
    let powers = powers.collect();
    (powers, met)
}
