//! A whole model in one class as matrices in discrete time, as control libraries take them.
//!
//! ```text
//! x(n+1) = A x(n) + B u(n),    y(n) = C x(n) + D u(n)        y in K above the offsets, u in W
//! ```
//!
//! Exact for inputs that are held between samples: A = e^(−ξ T) and B = 1 − e^(−ξ T) of every
//! relaxation, C its resistance. A dead time is a chain of states that hand the input on, so that
//! nothing is approximated.

use dr_core::model::mesh;
use nalgebra::DMatrix;

use super::super::ModelError;
use super::super::content::Model;
use super::super::pair_class::PairClass;

/// The matrices; D is that of feed-throughs.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    /// States by states.
    pub a: DMatrix<f64>,
    /// States by inputs, 1/W for relaxations normalised to the input.
    pub b: DMatrix<f64>,
    /// Outputs by states, K/W.
    pub c: DMatrix<f64>,
    /// Outputs by inputs, K/W.
    pub d: DMatrix<f64>,
    /// T, s.
    pub sample_period_s: f64,
    /// Warning of what is not in them, a sentence.
    pub warning: Option<String>,
}

/// The matrices of a class at a sample period, by default the record's.
///
/// # Errors
/// If the class is unknown or has no symbol of its own, or a dead time is no whole number of these
/// sample periods.
pub fn state_space(model: &Model, label: Option<&str>, sample_period_s: Option<f64>) -> Result<StateSpace, ModelError> {
    let period_s = sample_period_s.unwrap_or(model.sample_period_s);
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(model_error!("a sample period of {period_s} s: it must be finite and above 0 s"));
    }
    let mut parts = Vec::with_capacity(model.pairs.len());
    for pair in &model.pairs {
        let part = PairClass::find(model, Some(&format!("{}:{}", pair.input, pair.output)), label)?;
        part.refuse_wind()?;
        let late = part.dead_time_s() / period_s;
        if (late - late.round()).abs() > 1e-6 {
            return Err(model_error!(
                "a dead time of {} s is {late} of sample periods of {period_s} s, and only a whole number is exact",
                part.dead_time_s()
            ));
        }
        parts.push((part, late.round() as usize));
    }
    let index = |found: Option<usize>| found.unwrap_or_default();
    let input = |part: &PairClass| index(model.inputs.iter().position(|name| *name == part.pair.input));
    let output = |part: &PairClass| index(model.outputs.iter().position(|of| of.name == part.pair.output));
    let inputs = model.inputs.len();
    // Takes, of every input the longest chain that any of its pairs wants.
    let chain = |of: usize| parts.iter().filter(|(part, _)| input(part) == of).map(|(_, late)| *late).max();
    let chains: Vec<usize> = (0..inputs).map(|of| chain(of).unwrap_or(0)).collect();
    let relaxations: usize = parts.iter().map(|(part, _)| part.pair.mesh_rad_s.len()).sum();
    let states = relaxations + chains.iter().sum::<usize>();
    let mut space = StateSpace {
        a: DMatrix::zeros(states, states),
        b: DMatrix::zeros(states, inputs),
        c: DMatrix::zeros(model.outputs.len(), states),
        d: DMatrix::zeros(model.outputs.len(), inputs),
        sample_period_s: period_s,
        warning: parts.first().and_then(|(part, _)| part.warning()),
    };
    let mut first_late = Vec::with_capacity(inputs);
    let mut at = relaxations;
    for (of, &length) in chains.iter().enumerate() {
        first_late.push(at);
        for link in 0..length {
            if link == 0 { space.b[(at, of)] = 1.0 } else { space.a[(at + link, at + link - 1)] = 1.0 }
        }
        at += length;
    }
    let mut at = 0;
    for (part, late) in &parts {
        let (from, to) = (input(part), output(part));
        let feed_through = part.class.feed_through_k_per_w;
        match late {
            0 => space.d[(to, from)] += feed_through,
            late => space.c[(to, first_late[from] + late - 1)] += feed_through,
        }
        for (&rate, &resistance) in part.pair.mesh_rad_s.iter().zip(&part.class.r_k_per_w) {
            let gain = mesh::gain(rate, period_s);
            space.a[(at, at)] = 1.0 - gain;
            match late {
                0 => space.b[(at, from)] = gain,
                late => space.a[(at, first_late[from] + late - 1)] = gain,
            }
            space.c[(to, at)] = resistance;
            at += 1;
        }
    }
    Ok(space)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Forward, testing};
    use nalgebra::DVector;

    #[test]
    fn the_matrices_step_as_the_model_does_with_dead_time_and_feed_through() {
        let mut model = testing::model(&[0.5, 4.0], &[10.0, 3.0]);
        let mut other = model.pairs[0].clone();
        other.input = "power_w_b".to_owned();
        model.inputs.push(other.input.clone());
        other.dead_time_samples = 3;
        other.classes.get_mut("all").unwrap().feed_through_k_per_w = 2.0;
        model.pairs.push(other);
        let space = state_space(&model, None, None).unwrap();
        assert_eq!((space.a.nrows(), space.sample_period_s), (7, 0.1));
        let mut forward = Forward::at_rest(&model, 0.1);
        let mut x = DVector::zeros(7);
        let mut y = [0.0];
        for n in 0..60_u32 {
            let u = [f64::from(n * 7 % 5), f64::from(n * 11 % 3)];
            let input = DVector::from_row_slice(&u);
            forward.row(&u, 0, f64::NAN, &mut y);
            let own = (&space.c * &x + &space.d * &input)[0] + model.offset_c;
            // Some tens of K, sixty steps.
            assert!((own - y[0]).abs() < 1e-12, "{n}: {own} {}", y[0]);
            x = &space.a * x + &space.b * input;
        }
        let refused = state_space(&model, None, Some(0.2)).unwrap_err().to_string();
        assert!(refused.contains("only a whole number is exact"), "{refused}");
        assert!(state_space(&model, Some("gust"), None).is_err());
    }
}
