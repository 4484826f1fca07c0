//! A whole model as one linear system, in which any elements are held at constant temperature and
//! the others heated.
//!
//! States z_s in K, one a rate of a pair; s heats output o(s) from input i(s). In the wind j
//!
//! ```text
//! dz_s/dt = −ξ_s z_s + η_s(j) w_i(s),   T_o = base_o + Σ_{o(s)=o} z_s
//! w_i = u_i − ΔG_i(j) (T_i − T_gas)
//! ```
//!
//! ΔG = 0 for structure `symbol`, whose η change with the wind instead (injection form, thesis 2.19
//! and 2.54). Elements H that are held have dT_H/dt = 0, so that with C the sums over states, Ξ =
//! diag ξ, and Γ_oi = Σ_{s: i → o} η_s
//!
//! ```text
//! w_H = Γ_HH⁻¹ (C_H Ξ z − Γ_HR w_R)
//! ```
//!
//! with R the others: for one element that is the equivalent control of dr-core. For every wind and
//! set H all is linear with constant coefficients, and one step of any length is one matrix
//! exponential, which is made once. Losses that grow with temperature, w_i −= g (T_o − base_o)²,
//! are not linear; whoever moves the system takes them out of the powers step by step.

use nalgebra::{DMatrix, DVector};

use dr_core::model::mesh;

use super::exponential::exponential;
use super::loop_model::{followed_k, gas_temperature_c};
use super::sliding_surface::{feed_through, no_surface};
use crate::model::pair_class::{element, name, unseen};
use crate::model::{Model, ModelError, ModelOutput, PlacedLoss, Structure, refuse_other_units};

/// Masks of held elements have so many bits.
const MOST_ELEMENTS: usize = usize::BITS as usize;

/// A model in matrices.
#[derive(Debug, Clone)]
pub struct System {
    /// By state.
    rates: Vec<f64>,
    input: Vec<usize>,
    output: Vec<usize>,
    /// By class and state.
    eta: Vec<Vec<f64>>,
    /// By class and element, W/K.
    conductance: Vec<Vec<f64>>,
    base_c: Vec<f64>,
    gas_c: f64,
    /// Losses that grow with temperature, by elements.
    losses: Vec<PlacedLoss>,
    /// By element: which of the model's outputs it is regulated by.
    regulated_by: Vec<usize>,
}

/// w = of_state z + of_power u + constant, for every element.
struct Injected {
    of_state: DMatrix<f64>,
    of_power: DMatrix<f64>,
    constant: DVector<f64>,
}

/// The motion in one wind with one set of held elements, over one length of time.
pub struct Motion {
    step: Advance,
    held: Vec<usize>,
    rows: Vec<HeldElement>,
}

/// u of a held element.
struct HeldElement {
    element: usize,
    of_state: Vec<f64>,
    of_power: Vec<f64>,
    constant: f64,
}

enum Advance {
    /// No feedback: every state by itself, z ← z + gain (R u − z).
    Diagonal {
        gain: Vec<f64>,
        r: Vec<f64>,
        input: Vec<usize>,
    },
    Dense {
        of_state: DMatrix<f64>,
        of_power: DMatrix<f64>,
        constant: DVector<f64>,
    },
}

impl System {
    /// # Errors
    /// What this model has that cannot be predicted.
    pub fn new(model: &Model, gas_c: Option<f64>) -> Result<Self, ModelError> {
        refuse_other_units(model)?;
        let elements = model.inputs.len();
        refuse_if!(
            elements > MOST_ELEMENTS,
            model_error!("the model has {elements} inputs; loops of {MOST_ELEMENTS} at most can be predicted")
        );
        // By name; by order, unless that output has the name of another input.
        let output_of = |at: usize| {
            let named = |output: &ModelOutput, input: &String| element(&output.name) == element(input);
            let is_free = |output: &ModelOutput| !model.inputs.iter().any(|input| named(output, input));
            let by_name = model.outputs.iter().position(|output| named(output, &model.inputs[at]));
            by_name.or_else(|| model.outputs.get(at).filter(|output| is_free(output)).map(|_| at))
        };
        let mut system = Self {
            rates: Vec::new(),
            input: Vec::new(),
            output: Vec::new(),
            eta: vec![Vec::new(); model.classes.len()],
            conductance: vec![vec![0.0; elements]; model.classes.len()],
            base_c: Vec::new(),
            gas_c: 0.0,
            losses: Vec::new(),
            regulated_by: Vec::with_capacity(elements),
        };
        let gas = match &model.wind {
            Some(wind) => gas_temperature_c(wind, gas_c, true).map_err(|error| model_error!("the model {error}"))?,
            None => gas_c,
        };
        system.gas_c = gas.unwrap_or(0.0);
        for at in 0..elements {
            let input = &model.inputs[at];
            let none = || {
                model_error!(
                    "the model has no output of the element that input `{input}` heats: identify it again with that temperature among its --output"
                )
            };
            let output = output_of(at).ok_or_else(none)?;
            system.regulated_by.push(output);
            let of = &model.outputs[output];
            system.base_c.push(of.offset_c + followed_k(model, &of.name, gas));
            for (class, label) in model.classes.iter().enumerate() {
                let estimate = model.wind.as_ref().and_then(|wind| wind.elements.get(at)?.get(label));
                system.conductance[class][at] = estimate.map_or(0.0, |estimate| estimate.value);
            }
        }
        for loss in model.placed_losses() {
            let output = system.regulated_by.iter().position(|at| *at == loss.output);
            let name = &model.outputs[loss.output].name;
            let none = || model_error!("the model's losses grow with `{name}`, which no element is regulated by");
            system.losses.push(PlacedLoss { output: output.ok_or_else(none)?, ..loss });
        }
        for pair in &model.pairs {
            let input = model.inputs.iter().position(|input| *input == pair.input);
            let output = system.regulated_by.iter().position(|at| model.outputs[*at].name == pair.output);
            let (Some(input), Some(output)) = (input, output) else { continue };
            if pair.dead_time_samples > 0 {
                return Err(model_error!(
                    "{} has a dead time of {} samples, which a prediction of the loop leaves out: identify it without",
                    name(pair),
                    pair.dead_time_samples
                ));
            }
            system.rates.extend(&pair.mesh_rad_s);
            system.input.extend(std::iter::repeat_n(input, pair.mesh_rad_s.len()));
            system.output.extend(std::iter::repeat_n(output, pair.mesh_rad_s.len()));
            for (at, label) in model.classes.iter().enumerate() {
                let own = match model.structure {
                    Structure::Symbol => pair.classes.get(label),
                    Structure::Conductance => pair.classes.values().next(),
                };
                let own = own.ok_or_else(|| unseen(pair, label))?;
                if own.feed_through_k_per_w != 0.0 {
                    let error = feed_through(own.feed_through_k_per_w);
                    return Err(model_error!("{}, class `{label}`, {error}", name(pair)));
                }
                system.eta[at].extend(pair.mesh_rad_s.iter().zip(&own.r_k_per_w).map(|(rate, r)| rate * r));
            }
        }
        Ok(system)
    }

    /// Number of states.
    pub fn order(&self) -> usize {
        self.rates.len()
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.base_c.len()
    }

    /// The states with which the model's record ended. What no pair has a rate for becomes a state
    /// that nothing heats.
    ///
    /// # Errors
    /// If the model does not hold them.
    pub fn end(&mut self, model: &Model) -> Result<DVector<f64>, ModelError> {
        let end = model.end.as_ref().ok_or_else(|| {
            model_error!("the model does not hold the state at the end of its record: begin from standby or rest")
        })?;
        let mut z = vec![0.0; self.order()];
        for (element, &output) in self.regulated_by.clone().iter().enumerate() {
            for &(rate, amplitude_k) in end.decays.get(output).into_iter().flatten() {
                let own = (0..self.order()).find(|&s| self.output[s] == element && self.rates[s] == rate);
                // All states of one output and one rate move alike: which of them is warm does not
                // matter.
                match own {
                    Some(state) => z[state] += amplitude_k,
                    None => {
                        self.rates.push(rate);
                        self.input.push(element);
                        self.output.push(element);
                        self.eta.iter_mut().for_each(|eta| eta.push(0.0));
                        z.push(amplitude_k);
                    }
                }
            }
        }
        Ok(DVector::from_vec(z))
    }

    /// Temperature of an element in °C.
    pub fn temperature_c(&self, z: &DVector<f64>, element: usize) -> f64 {
        let own = |(z, output): (&f64, &usize)| if *output == element { *z } else { 0.0 };
        self.base_c[element] + z.as_slice().iter().zip(&self.output).map(own).sum::<f64>()
    }

    /// Writes the power in W that growing losses take from every element. At a held temperature it
    /// does not change; else it is taken at the start of a step and held, as in identification.
    pub fn taken_w(&self, z: &DVector<f64>, taken_w: &mut [f64]) {
        taken_w.fill(0.0);
        for loss in &self.losses {
            let rise_k = self.temperature_c(z, loss.output) - self.base_c[loss.output];
            taken_w[loss.input] += loss.taken_w(rise_k);
        }
    }

    /// # Errors
    /// If an element has no surface to slide on in a wind.
    pub fn check_surface(&self, class: usize, element: usize) -> Result<(), ModelError> {
        let own = (0..self.order()).filter(|&s| self.input[s] == element && self.output[s] == element);
        let gamma: f64 = own.map(|s| self.eta[class][s]).sum();
        if gamma > 0.0 { Ok(()) } else { Err(no_surface(gamma)) }
    }

    fn injected(&self, class: usize, held: &[usize]) -> Result<Injected, ModelError> {
        let (n, elements) = (self.order(), self.elements());
        let sums = DMatrix::from_fn(elements, n, |o, s| f64::from(u8::from(self.output[s] == o)));
        let mut gamma = DMatrix::zeros(elements, elements);
        for s in 0..n {
            gamma[(self.output[s], self.input[s])] += self.eta[class][s];
        }
        let mut injected = Injected {
            of_state: DMatrix::zeros(elements, n),
            of_power: DMatrix::zeros(elements, elements),
            constant: DVector::zeros(elements),
        };
        let heated: Vec<usize> = (0..elements).filter(|element| !held.contains(element)).collect();
        for &i in &heated {
            let conductance = self.conductance[class][i];
            injected.of_state.row_mut(i).copy_from(&(sums.row(i) * -conductance));
            injected.of_power[(i, i)] = 1.0;
            injected.constant[i] = -conductance * (self.base_c[i] - self.gas_c);
        }
        if held.is_empty() {
            return Ok(injected);
        }
        let own = DMatrix::from_fn(held.len(), held.len(), |a, b| gamma[(held[a], held[b])]);
        let inverse = own.try_inverse().ok_or_else(|| {
            model_error!("the elements that are held cannot be distinguished: their Γ matrix is singular")
        })?;
        let cross =
            DMatrix::from_fn(held.len(), elements, |a, i| if held.contains(&i) { 0.0 } else { gamma[(held[a], i)] });
        let falling = DMatrix::from_fn(held.len(), n, |a, s| sums[(held[a], s)] * self.rates[s]);
        let of_state = &inverse * (falling - &cross * &injected.of_state);
        let of_power = -(&inverse * (&cross * &injected.of_power));
        let constant = -(&inverse * (&cross * &injected.constant));
        for (a, &i) in held.iter().enumerate() {
            injected.of_state.row_mut(i).copy_from(&of_state.row(a));
            injected.of_power.row_mut(i).copy_from(&of_power.row(a));
            injected.constant[i] = constant[a];
        }
        Ok(injected)
    }

    /// dz/dt = a z + b u + c.
    fn coefficients(&self, class: usize, injected: &Injected) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
        let spread =
            DMatrix::from_fn(
                self.order(),
                self.elements(),
                |s, i| {
                    if self.input[s] == i { self.eta[class][s] } else { 0.0 }
                },
            );
        let own = DMatrix::from_diagonal(&DVector::from_iterator(self.order(), self.rates.iter().map(|rate| -rate)));
        (own + &spread * &injected.of_state, &spread * &injected.of_power, &spread * &injected.constant)
    }

    /// The motion over `time_s` in a wind with the elements of a bit mask held.
    ///
    /// # Errors
    /// If what is held has no sliding surface.
    pub fn motion(&self, class: usize, mask: usize, time_s: f64) -> Result<Motion, ModelError> {
        let held: Vec<usize> = (0..self.elements()).filter(|element| mask >> element & 1 == 1).collect();
        let injected = self.injected(class, &held)?;
        let free = held.is_empty() && self.conductance[class].iter().all(|conductance| *conductance == 0.0);
        let step = if free {
            Advance::Diagonal {
                gain: self.rates.iter().map(|&rate| mesh::gain(rate, time_s)).collect(),
                // An element that nothing heats may stand still.
                r: (self.rates.iter().zip(&self.eta[class]))
                    .map(|(rate, eta)| if *eta == 0.0 { 0.0 } else { eta / rate })
                    .collect(),
                input: self.input.clone(),
            }
        } else {
            let (n, elements) = (self.order(), self.elements());
            let (a, b, c) = self.coefficients(class, &injected);
            let mut all = DMatrix::zeros(n + elements + 1, n + elements + 1);
            all.view_mut((0, 0), (n, n)).copy_from(&(a * time_s));
            all.view_mut((0, n), (n, elements)).copy_from(&(b * time_s));
            all.view_mut((0, n + elements), (n, 1)).copy_from(&(c * time_s));
            let all = exponential(&all);
            Advance::Dense {
                of_state: all.view((0, 0), (n, n)).into_owned(),
                of_power: all.view((0, n), (n, elements)).into_owned(),
                constant: all.view((0, n + elements), (n, 1)).column(0).into_owned(),
            }
        };
        // u = w + ΔG (T − T_gas)
        let Injected { mut of_state, of_power, mut constant } = injected;
        for &i in &held {
            let conductance = self.conductance[class][i];
            for s in (0..self.order()).filter(|&s| self.output[s] == i) {
                of_state[(i, s)] += conductance;
            }
            constant[i] += conductance * (self.base_c[i] - self.gas_c);
        }
        let rows = held.iter().map(|&element| HeldElement {
            element,
            of_state: of_state.row(element).iter().copied().collect(),
            of_power: of_power.row(element).iter().copied().collect(),
            constant: constant[element],
        });
        let rows = rows.collect();
        Ok(Motion { step, held, rows })
    }

    /// Where the states end in a wind if all elements are heated with constant powers in W.
    pub fn steady_state(&self, class: usize, power_w: &[f64]) -> Result<DVector<f64>, ModelError> {
        let (a, b, c) = self.coefficients(class, &self.injected(class, &[])?);
        let rest = a.lu().solve(&-(b * DVector::from_column_slice(power_w) + c));
        rest.ok_or_else(|| model_error!("the model has no steady state in the first wind"))
    }
}

impl Motion {
    /// Writes the powers in W of the held elements; those of the others are given.
    #[inline]
    pub fn equivalent_w(&self, z: &DVector<f64>, power_w: &mut [f64]) {
        for &i in &self.held {
            power_w[i] = 0.0;
        }
        for HeldElement { element, of_state, of_power, constant } in &self.rows {
            let of_state: f64 = of_state.iter().zip(z.as_slice()).map(|(k, z)| k * z).sum();
            // Entries of held elements are zero.
            let of_power: f64 = of_power.iter().zip(power_w.iter()).map(|(k, u)| k * u).sum();
            power_w[*element] = of_state + of_power + constant;
        }
    }

    /// One step. Powers of held elements do not matter.
    #[inline]
    pub fn advance(&self, z: &mut DVector<f64>, power_w: &[f64], scratch: &mut DVector<f64>) {
        match &self.step {
            Advance::Diagonal { gain, r, input } => {
                for (((z, gain), r), input) in z.as_mut_slice().iter_mut().zip(gain).zip(r).zip(input) {
                    *z += gain * (r * power_w[*input] - *z);
                }
            }
            Advance::Dense { of_state, of_power, constant } => {
                let order = z.len();
                let next = scratch.as_mut_slice();
                next.copy_from_slice(constant.as_slice());
                // Columns stand one behind the other. Slices, because this is most of a
                // prediction's work.
                let add = |next: &mut [f64], column: &[f64], factor: f64| {
                    next.iter_mut().zip(column).for_each(|(next, k)| *next += factor * k);
                };
                for (column, z) in of_state.as_slice().chunks_exact(order).zip(z.as_slice()) {
                    add(next, column, *z);
                }
                for (column, u) in of_power.as_slice().chunks_exact(order).zip(power_w) {
                    if *u != 0.0 {
                        add(next, column, *u);
                    }
                }
                std::mem::swap(z, scratch);
            }
        }
    }
}

#[cfg(test)]
mod tests;
