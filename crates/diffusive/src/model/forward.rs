//! Running a model forward over a record's inputs, row by row, in f64.
//!
//! ```text
//! x_k ← x_k + g_k (u − x_k),    g_k = 1 − e^(−ξ_k Ts)
//! ```
//!
//! The exact step for an input that is held between rows, at any sample period. In f64 it needs no
//! compensation: a rate with ξTs = 1e-9 still has seven digits more than any record.

use dr_core::model::mesh;

use super::content::{Following, LossOrigin, Model, RecordEnd, Structure};
use super::losses::PlacedLoss;

/// Memory of one output: relaxations of one pair and class, or decays that no input drives.
struct ForwardBank {
    input: usize,
    output: usize,
    /// The class whose intervals drive it; `None`: all of them.
    class: Option<usize>,
    delay: usize,
    gain: Vec<f64>,
    resistance: Vec<f64>,
    x: Vec<f64>,
    feed_through: f64,
}

impl ForwardBank {
    /// Response at once to inputs of a class.
    fn fed_through(&self, (values, class): &(Vec<f64>, usize)) -> f64 {
        let is_driven = self.feed_through != 0.0 && self.class.is_none_or(|own| own == *class);
        if is_driven { self.feed_through * values[self.input] } else { 0.0 }
    }
}

struct Decay {
    output: usize,
    /// e^(−ξ Ts)
    factor: f64,
    amplitude_k: f64,
}

/// Response of all outputs to a gas that moves.
struct GasFollower {
    from_c: f64,
    rate_rad_s: Vec<f64>,
    gain: Vec<f64>,
    /// By output.
    f_k_per_k: Vec<Vec<f64>>,
    /// `None` until the first row says where the gas rests.
    x: Option<Vec<f64>>,
}

impl GasFollower {
    fn of(following: &Following, sample_period_s: f64) -> Self {
        Self {
            from_c: following.from_c,
            rate_rad_s: following.mesh_rad_s.clone(),
            gain: following.mesh_rad_s.iter().map(|&rate| mesh::gain(rate, sample_period_s)).collect(),
            f_k_per_k: following.outputs.iter().map(|output| output.f_k_per_k.clone()).collect(),
            x: None,
        }
    }

    fn add(&mut self, gas_c: f64, outputs: &mut [f64]) {
        let x = self.x.get_or_insert_with(|| vec![gas_c - self.from_c; self.gain.len()]);
        for (output, f_k_per_k) in outputs.iter_mut().zip(&self.f_k_per_k) {
            *output += x.iter().zip(f_k_per_k).map(|(x, f_k_per_k)| x * f_k_per_k).sum::<f64>();
        }
    }

    fn hold(&mut self, gas_c: f64) {
        for (x, gain) in self.x.iter_mut().flatten().zip(&self.gain) {
            *x += gain * (gas_c - self.from_c - *x);
        }
    }
}

/// A model in motion.
pub struct Forward {
    banks: Vec<ForwardBank>,
    decays: Vec<Decay>,
    offset_c: Vec<f64>,
    /// ΔG by element and class; empty for structure `symbol`.
    conductance: Vec<Vec<f64>>,
    gas: Option<GasFollower>,
    /// Losses that grow with temperature, and whether they count from the gas rather than the
    /// offset.
    losses: Vec<PlacedLoss>,
    from_gas: bool,
    /// The gas that is followed is a measured surrounding.
    has_ambient: bool,
    /// The inputs' last values (newest last) and their class, as far back as the longest dead time.
    past: Vec<(Vec<f64>, usize)>,
}

impl Forward {
    /// A model at rest, and in balance with the gas of its first row, to be stepped every
    /// `sample_period_s`. Dead times are whole periods of the model's own record, so they are kept
    /// in time and rounded to the new period.
    pub fn at_rest(model: &Model, sample_period_s: f64) -> Self {
        let class_of = |label: &str| model.classes.iter().position(|known| known == label);
        let mut banks = Vec::new();
        let mut longest = 0;
        for pair in &model.pairs {
            let input = model.inputs.iter().position(|name| *name == pair.input).unwrap_or(0);
            let output = model.outputs.iter().position(|output| output.name == pair.output).unwrap_or(0);
            let delay = (pair.dead_time_samples as f64 * model.sample_period_s / sample_period_s).round() as usize;
            longest = longest.max(delay);
            for (label, class) in &pair.classes {
                let gated = model.structure == Structure::Symbol && model.classes.len() > 1;
                banks.push(ForwardBank {
                    input,
                    output,
                    class: if gated { class_of(label) } else { None },
                    delay,
                    gain: pair.mesh_rad_s.iter().map(|&rate| mesh::gain(rate, sample_period_s)).collect(),
                    resistance: class.r_k_per_w.clone(),
                    x: vec![0.0; pair.mesh_rad_s.len()],
                    feed_through: class.feed_through_k_per_w,
                });
            }
        }
        let conductance = model.wind.as_ref().map_or_else(Vec::new, |wind| {
            let of = |label: &String, element: &std::collections::BTreeMap<String, super::content::Estimate>| {
                element.get(label).map_or(0.0, |estimate| estimate.value)
            };
            wind.elements.iter().map(|element| model.classes.iter().map(|label| of(label, element)).collect()).collect()
        });
        Self {
            banks,
            decays: Vec::new(),
            offset_c: model.outputs.iter().map(|output| output.offset_c).collect(),
            conductance,
            gas: model.following().map(|following| GasFollower::of(following, sample_period_s)),
            losses: model.placed_losses(),
            from_gas: model.losses.as_ref().is_some_and(|losses| matches!(losses.origin, LossOrigin::Column(_))),
            has_ambient: model.ambient.is_some(),
            past: vec![(vec![0.0; model.inputs.len()], 0); longest],
        }
    }

    /// A model that goes on from where its record ended.
    pub fn going_on(model: &Model, end: &RecordEnd) -> Self {
        let mut forward = Self::at_rest(model, model.sample_period_s);
        for (output, decays) in end.decays.iter().enumerate() {
            forward.add_decays(output, decays, model.sample_period_s);
        }
        if let Some(gas) = &mut forward.gas {
            // The past of the gas is in the decays.
            gas.x = Some(vec![0.0; gas.gain.len()]);
        }
        let longest = forward.past.len();
        for at in 0..longest {
            for (input, values) in end.pending.iter().enumerate() {
                let skipped = values.len().saturating_sub(longest);
                if let Some(&value) = values.get(skipped + at) {
                    forward.past[at].0[input] = value;
                }
            }
            let skipped = end.pending_class.len().saturating_sub(longest);
            forward.past[at].1 = end.pending_class.get(skipped + at).copied().unwrap_or(0);
        }
        forward
    }

    /// Adds what an output does by itself: (rate in rad/s, amplitude in K at the next row).
    pub fn add_decays(&mut self, output: usize, decays: &[(f64, f64)], sample_period_s: f64) {
        self.decays.extend(decays.iter().map(|&(rate, amplitude_k)| Decay {
            output,
            factor: 1.0 - mesh::gain(rate, sample_period_s),
            amplitude_k,
        }));
    }

    /// An offset in place of the model's own, as every new day has one.
    pub fn set_offset(&mut self, output: usize, offset_c: f64) {
        self.offset_c[output] = offset_c;
    }

    /// One row: writes the outputs at t_n, then holds the inputs over [t_n, t_{n+1}).
    ///
    /// `class` is the row's index into the model's classes, `gas_c` the gas temperature (where it
    /// is followed, or takes heat).
    pub fn row(&mut self, inputs: &[f64], class: usize, gas_c: f64, outputs: &mut [f64]) {
        self.predict(inputs, class, gas_c, outputs);
        self.hold(class, gas_c, outputs);
    }

    /// The same, but the wind takes what the measured temperatures say, as in identification.
    /// Outputs are then linear in offsets and decays, and what those are can be read off them at
    /// once.
    pub fn row_of_measured(
        &mut self,
        inputs: &[f64],
        class: usize,
        gas_c: f64,
        measured_c: &[f64],
        outputs: &mut [f64],
    ) {
        self.predict(inputs, class, gas_c, outputs);
        self.hold(class, gas_c, measured_c);
    }

    /// Outputs at the next row, but for what its own inputs and gas add to them at once.
    pub fn outputs(&self, outputs: &mut [f64]) {
        outputs.copy_from_slice(&self.offset_c);
        for decay in &self.decays {
            outputs[decay.output] += decay.amplitude_k;
        }
        for bank in &self.banks {
            outputs[bank.output] +=
                bank.x.iter().zip(&bank.resistance).map(|(x, resistance)| x * resistance).sum::<f64>();
            let late = self.past.len().checked_sub(bank.delay).filter(|_| bank.delay > 0);
            outputs[bank.output] += late.map_or(0.0, |at| bank.fed_through(&self.past[at]));
        }
    }

    /// Outputs at t_n; the inputs wait to be held.
    fn predict(&mut self, inputs: &[f64], class: usize, gas_c: f64, outputs: &mut [f64]) {
        self.outputs(outputs);
        self.decays.iter_mut().for_each(|decay| decay.amplitude_k *= decay.factor);
        if let Some(gas) = &mut self.gas {
            gas.add(gas_c, outputs);
        }
        let newest = (inputs.to_vec(), class);
        // Without a dead time, feed-through answers to the input of this very row.
        for bank in self.banks.iter().filter(|bank| bank.delay == 0) {
            outputs[bank.output] += bank.fed_through(&newest);
        }
        self.past.push(newest);
    }

    /// Holds the inputs over [t_n, t_{n+1}), less what the wind and growing losses take from
    /// elements of these temperatures.
    fn hold(&mut self, class: usize, gas_c: f64, temperatures_c: &[f64]) {
        let last = self.past.len() - 1;
        for (element, conductance) in self.conductance.iter().enumerate() {
            let rise_k = temperatures_c.get(element).copied().unwrap_or(gas_c) - gas_c;
            let taken = conductance.get(class).copied().unwrap_or(0.0) * rise_k;
            self.past[last].0[element] -= taken;
        }
        for loss in &self.losses {
            // An offset belongs to a surrounding of `from`, and moves with what is measured of it.
            let ambient_k =
                if self.has_ambient { self.gas.as_ref().map_or(0.0, |gas| gas_c - gas.from_c) } else { 0.0 };
            let origin_c = if self.from_gas { gas_c } else { self.offset_c[loss.output] + ambient_k };
            self.past[last].0[loss.input] -= loss.taken_w(temperatures_c[loss.output] - origin_c);
        }
        if let Some(gas) = &mut self.gas {
            gas.hold(gas_c);
        }
        for bank in &mut self.banks {
            let (values, class) = &self.past[last - bank.delay];
            let driven = bank.class.is_none_or(|own| own == *class);
            let u = if driven { values[bank.input] } else { 0.0 };
            for (x, gain) in bank.x.iter_mut().zip(&bank.gain) {
                *x += gain * (u - *x);
            }
        }
        self.past.remove(0);
    }

    /// Decays that stand for the whole present state, by output: what
    /// [`RecordEnd`](crate::model::RecordEnd) keeps.
    pub fn decays(&self, model: &Model) -> Vec<Vec<(f64, f64)>> {
        let mut all = vec![Vec::new(); self.offset_c.len()];
        for decay in &self.decays {
            all[decay.output].push((-libm::log(decay.factor) / model.sample_period_s, decay.amplitude_k));
        }
        let meshes = model.pairs.iter().flat_map(|pair| pair.classes.values().map(move |_| &pair.mesh_rad_s));
        for (bank, mesh) in self.banks.iter().zip(meshes) {
            let own = mesh.iter().zip(&bank.x).zip(&bank.resistance);
            all[bank.output].extend(own.map(|((&rate, x), resistance)| (rate, x * resistance)));
        }
        if let Some((gas, x)) = self.gas.as_ref().and_then(|gas| Some((gas, gas.x.as_ref()?))) {
            for (decays, f_k_per_k) in all.iter_mut().zip(&gas.f_k_per_k) {
                let own = gas.rate_rad_s.iter().zip(x).zip(f_k_per_k);
                decays.extend(own.map(|((&rate, x), f_k_per_k)| (rate, x * f_k_per_k)));
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;

    /// One pole of 10 K/W at 0.5 rad/s, no wind, and a gas that is followed in full with 0.1 rad/s.
    fn model() -> Model {
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        testing::follow_gas(&mut model, 18.0);
        model
    }

    fn still(model: &Model) -> usize {
        model.classes.iter().position(|label| label == "still").unwrap()
    }

    #[test]
    fn a_model_rests_in_balance_with_the_gas_of_its_first_row_and_follows_its_steps() {
        let model = model();
        let mut forward = Forward::at_rest(&model, 0.1);
        let mut row = |gas_c: f64| {
            let mut outputs = [0.0];
            forward.row(&[0.0], still(&model), gas_c, &mut outputs);
            outputs[0]
        };
        // The offset belongs to 18 °C, and the gas begins 3 K above.
        let rest: Vec<f64> = (0..50).map(|_| row(21.0)).collect();
        assert!(rest.iter().all(|y| (y - (model.offset_c + 3.0)).abs() < 1e-12), "{rest:?}");
        // A step by 2 K, seen from the next row on: 2 (1 − e^(−ξt)).
        for n in 0..100 {
            let truth = model.offset_c + 3.0 + 2.0 * (1.0 - libm::exp(-0.1 * 0.1 * f64::from(n)));
            assert!((row(23.0) - truth).abs() < 1e-12);
        }
    }

    #[test]
    fn growing_losses_settle_where_their_square_says_from_offset_and_from_a_measured_ambient() {
        // 10 K/W and g = 2e-4 W/K²: ΔT + b ΔT² = 30 K with b = 2e-3 1/K, at 3 W.
        let truth_k = ((1.0 + 4.0 * 2e-3 * 30.0_f64).sqrt() - 1.0) / (2.0 * 2e-3);
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_loss(&mut model, 2e-4);
        let settled_c = |model: &Model, gas_c: f64| {
            let (mut forward, mut outputs) = (Forward::at_rest(model, 0.1), [0.0]);
            (0..2000).for_each(|_| forward.row(&[3.0], 0, gas_c, &mut outputs));
            outputs[0]
        };
        assert!((settled_c(&model, 0.0) - model.offset_c - truth_k).abs() < 1e-9);
        model.losses.as_mut().unwrap().origin = LossOrigin::Column("ambient".to_owned());
        assert!((settled_c(&model, model.offset_c) - model.offset_c - truth_k).abs() < 1e-9);
        assert!(settled_c(&model, model.offset_c - 5.0) < model.offset_c + truth_k - 0.5);
    }

    #[test]
    fn decays_of_the_whole_state_go_on_as_the_model_would_have() {
        let model = model();
        let gas_c = |n: usize| 18.0 + libm::sin(0.05 * n as f64);
        let power_w = |n: usize| 0.1 + 0.05 * libm::cos(0.3 * n as f64);
        let mut outputs = [0.0];
        let mut forward = Forward::at_rest(&model, model.sample_period_s);
        (0..200).for_each(|n| forward.row(&[power_w(n)], still(&model), gas_c(n), &mut outputs));
        let end = RecordEnd {
            next_time_s: 200.0 * model.sample_period_s,
            decays: forward.decays(&model),
            pending: vec![Vec::new()],
            pending_class: Vec::new(),
        };
        let mut other = Forward::going_on(&model, &end);
        for n in 200..400 {
            let mut continued = [0.0];
            forward.row(&[power_w(n)], still(&model), gas_c(n), &mut outputs);
            other.row(&[power_w(n)], still(&model), gas_c(n), &mut continued);
            assert!((outputs[0] - continued[0]).abs() < 1e-10, "{n}: {} {}", outputs[0], continued[0]);
        }
    }
}
