//! Running a model forward over a record's inputs, row by row, in f64.
//!
//! ```text
//! x_k ← x_k + g_k (u − x_k),    g_k = 1 − e^(−ξ_k Ts)
//! ```
//!
//! The exact step for an input that is held between rows, at any sample period. In f64 it needs no compensation: a rate with
//! ξTs = 1e-9 still has seven digits more than any record.

use dr_core::model::mesh;

use super::{End, Model, Structure};

/// What one output's memory is made of: relaxations of one pair and class, or decays that no input drives.
struct Bank {
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

struct Decay {
    output: usize,
    /// e^(−ξ Ts)
    factor: f64,
    amplitude_k: f64,
}

/// A model in motion.
pub struct Forward {
    banks: Vec<Bank>,
    decays: Vec<Decay>,
    offset_c: Vec<f64>,
    /// ΔG by element and class; empty for structure `symbol`.
    conductance: Vec<Vec<f64>>,
    /// The inputs' last values (newest last) and their class, as far back as the longest dead time.
    past: Vec<(Vec<f64>, usize)>,
}

impl Forward {
    /// A model at rest, to be stepped every `sample_period_s`. Dead times are whole periods of the model's own record, so they
    /// are kept in time and rounded to the new period.
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
                banks.push(Bank {
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
            let of = |label: &String, element: &std::collections::BTreeMap<String, super::Estimate>| {
                element.get(label).map_or(0.0, |estimate| estimate.value)
            };
            wind.elements.iter().map(|element| model.classes.iter().map(|label| of(label, element)).collect()).collect()
        });
        Self {
            banks,
            decays: Vec::new(),
            offset_c: model.outputs.iter().map(|output| output.offset_c).collect(),
            conductance,
            past: vec![(vec![0.0; model.inputs.len()], 0); longest],
        }
    }

    /// A model that goes on from where its record ended.
    pub fn going_on(model: &Model, end: &End) -> Self {
        let mut forward = Self::at_rest(model, model.sample_period_s);
        for (output, decays) in end.decays.iter().enumerate() {
            forward.add_decays(output, decays, model.sample_period_s);
        }
        let longest = forward.past.len();
        for (slot, at) in (0..longest).enumerate() {
            for (input, values) in end.pending.iter().enumerate() {
                let skipped = values.len().saturating_sub(longest);
                if let Some(&value) = values.get(skipped + at) {
                    forward.past[slot].0[input] = value;
                }
            }
            let skipped = end.pending_class.len().saturating_sub(longest);
            forward.past[slot].1 = end.pending_class.get(skipped + at).copied().unwrap_or(0);
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
    /// `class` is the row's index into the model's classes, `gas_c` the gas temperature (for structure `conductance` only).
    pub fn row(&mut self, inputs: &[f64], class: usize, gas_c: f64, outputs: &mut [f64]) {
        self.predict(inputs, class, outputs);
        self.hold(class, gas_c, outputs);
    }

    /// The same, but the wind takes what the measured temperatures say, as in identification. Outputs are then linear in offsets and
    /// decays, and what those are can be read off them at once.
    pub fn row_of_measured(
        &mut self,
        inputs: &[f64],
        class: usize,
        gas_c: f64,
        measured_c: &[f64],
        outputs: &mut [f64],
    ) {
        self.predict(inputs, class, outputs);
        self.hold(class, gas_c, measured_c);
    }

    /// Outputs at t_n; the inputs wait to be held.
    fn predict(&mut self, inputs: &[f64], class: usize, outputs: &mut [f64]) {
        outputs.copy_from_slice(&self.offset_c);
        for decay in &mut self.decays {
            outputs[decay.output] += decay.amplitude_k;
            decay.amplitude_k *= decay.factor;
        }
        for bank in &self.banks {
            outputs[bank.output] +=
                bank.x.iter().zip(&bank.resistance).map(|(x, resistance)| x * resistance).sum::<f64>();
        }
        let newest = (inputs.to_vec(), class);
        self.past.push(newest);
        let last = self.past.len() - 1;
        // Feed-through answers to the input of this very row, as far as the dead time lets it.
        for bank in &self.banks {
            if bank.feed_through != 0.0 {
                let (values, class) = &self.past[last - bank.delay];
                if bank.class.is_none_or(|own| own == *class) {
                    outputs[bank.output] += bank.feed_through * values[bank.input];
                }
            }
        }
    }

    /// Holds the inputs over [t_n, t_{n+1}), less what the wind takes from elements of these temperatures.
    fn hold(&mut self, class: usize, gas_c: f64, temperatures_c: &[f64]) {
        let last = self.past.len() - 1;
        for (element, conductance) in self.conductance.iter().enumerate() {
            let rise_k = temperatures_c.get(element).copied().unwrap_or(gas_c) - gas_c;
            let taken = conductance.get(class).copied().unwrap_or(0.0) * rise_k;
            self.past[last].0[element] -= taken;
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

    /// Decays that stand for the whole present state, by output: what [`End`] keeps.
    pub fn decays(&self, model: &Model) -> Vec<Vec<(f64, f64)>> {
        let mut all = vec![Vec::new(); self.offset_c.len()];
        for decay in &self.decays {
            all[decay.output].push((-decay.factor.ln() / model.sample_period_s, decay.amplitude_k));
        }
        let meshes = model.pairs.iter().flat_map(|pair| pair.classes.values().map(move |_| &pair.mesh_rad_s));
        for (bank, mesh) in self.banks.iter().zip(meshes) {
            let own = mesh.iter().zip(&bank.x).zip(&bank.resistance);
            all[bank.output].extend(own.map(|((&rate, x), resistance)| (rate, x * resistance)));
        }
        all
    }
}
