//! Small models for tests.

use std::collections::BTreeMap;

use super::content::{
    Chosen, Class, ElementLoss, Estimate, Followed, Following, LossOrigin, Model, ModelGas, ModelLosses, ModelOutput,
    ModelWind, Pair, Provenance, Structure, VERSION,
};

/// One input `power_w_a`, one output `temperature_c_a`, class `all`, sampled every 0.1 s, offset 20
/// °C.
pub fn model(mesh_rad_s: &[f64], r_k_per_w: &[f64]) -> Model {
    let output = ModelOutput {
        name: "temperature_c_a".to_owned(),
        offset_c: 20.0,
        se_offset_c: 0.01,
        residual_rms: 0.005,
        fit_percent: 99.0,
        spread_rms: None,
        whiteness: None,
        drift: None,
        forecast_rms: None,
    };
    let pair = Pair {
        input: "power_w_a".to_owned(),
        output: output.name.clone(),
        mesh_rad_s: mesh_rad_s.to_vec(),
        se_rate_rad_s: None,
        dead_time_samples: 0,
        non_negative: r_k_per_w.iter().all(|resistance| *resistance >= 0.0),
        classes: BTreeMap::from([("all".to_owned(), class(r_k_per_w))]),
    };
    Model {
        format: "anemo-model".to_owned(),
        version: VERSION,
        structure: Structure::Symbol,
        sample_period_s: 0.1,
        inputs: vec![pair.input.clone()],
        outputs: vec![output],
        pairs: vec![pair],
        event_column: None,
        classes: vec!["all".to_owned()],
        conductance_w_per_k: BTreeMap::new(),
        wind: None,
        ambient: None,
        losses: None,
        offset_c: 20.0,
        residual_rms: 0.005,
        fit_percent: 99.0,
        forecast_rms: None,
        supported: true,
        warnings: Vec::new(),
        advice: Vec::new(),
        chosen: Chosen::default(),
        provenance: Provenance { tool: "test".to_owned(), ..Provenance::default() },
        end: None,
    }
}

/// A class of these resistances without feed-through.
pub fn class(r_k_per_w: &[f64]) -> Class {
    Class {
        r_k_per_w: r_k_per_w.to_vec(),
        se_k_per_w: vec![0.01; r_k_per_w.len()],
        steady_gain_k_per_w: r_k_per_w.iter().sum(),
        se_steady_gain_k_per_w: 0.02,
        interval_95: None,
        feed_through_k_per_w: 0.0,
        se_feed_through_k_per_w: 0.0,
        covariance: None,
    }
}

/// Makes it one of structure `conductance`, with the reference `still` and one other class.
pub fn add_wind(model: &mut Model, label: &str, conductance_w_per_k: f64) {
    let own = model.pairs[0].classes.remove("all").expect("a model of `model`");
    model.pairs[0].classes.insert("still".to_owned(), own);
    model.structure = Structure::Conductance;
    model.classes = vec!["still".to_owned(), label.to_owned()];
    let estimate = |value| Estimate { value, se: 0.001 };
    let elements =
        BTreeMap::from([("still".to_owned(), estimate(0.0)), (label.to_owned(), estimate(conductance_w_per_k))]);
    model.conductance_w_per_k.clone_from(&elements);
    model.wind = Some(ModelWind {
        reference: "still".to_owned(),
        gas: ModelGas::ConstantC(20.0),
        elements: vec![elements],
        following: None,
    });
}

/// Gives the first pair a loss that grows with temperature.
pub fn add_loss(model: &mut Model, g_w_per_k2: f64) {
    let pair = &model.pairs[0];
    let gain = pair.classes.values().next().map_or(0.0, |class| class.steady_gain_k_per_w);
    model.losses = Some(ModelLosses {
        origin: LossOrigin::Offset,
        elements: vec![ElementLoss {
            output: pair.output.clone(),
            input: pair.input.clone(),
            g_w_per_k2: Estimate { value: g_w_per_k2, se: 1e-6 },
            b_per_k: Estimate { value: g_w_per_k2 * gain, se: 1e-5 },
        }],
    });
}

/// Lets the outputs of a model with a wind follow a gas column in full, with 0.1 rad/s.
pub fn follow_gas(model: &mut Model, from_c: f64) {
    let followed = Followed {
        f_k_per_k: vec![1.0],
        se_k_per_k: vec![0.01],
        steady_gain_k_per_k: 1.0,
        se_steady_gain_k_per_k: 0.01,
    };
    let outputs = vec![followed; model.outputs.len()];
    if let Some(wind) = &mut model.wind {
        wind.gas = ModelGas::Column("gas_c".to_owned());
        wind.following =
            Some(Following { from_c, range_c: [from_c - 1.0, from_c + 1.0], mesh_rad_s: vec![0.1], outputs });
    }
}
