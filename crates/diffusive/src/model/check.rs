//! Conditions on a model that was read from a file, and types alone do not say: whoever computes
//! with a model relies on it.

use recording::text::{one_line, tidy};

use super::ModelError;
use super::content::{Following, Model, ModelGas, Pair, RecordEnd, Structure};

/// Sample periods that a record can have, s.
const PERIODS_S: (f64, f64) = (1e-12, 1e12);

/// Rates times the sample period: a faster relaxation has ended and a slower one not begun within
/// any record.
const RATE_TIMES_PERIOD: (f64, f64) = (1e-12, 1e6);

impl Model {
    /// # Errors
    /// The key and what would be right.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        let (period_s, (least_s, most_s)) = (self.sample_period_s, PERIODS_S);
        let is_period = period_s.is_finite() && period_s > 0.0;
        refuse_if!(!is_period, model_error!("`sample_period_s` must be a number greater than zero, and is {period_s}"));
        if !(least_s..=most_s).contains(&period_s) {
            return Err(model_error!("`sample_period_s` is {period_s:e}, and must be from {least_s:e} to {most_s:e}"));
        }
        if self.inputs.is_empty() || self.outputs.is_empty() || self.pairs.is_empty() || self.classes.is_empty() {
            return Err(model_error!("must have at least one input, output, pair and class"));
        }
        once("inputs", self.inputs.iter())?;
        once("outputs", self.outputs.iter().map(|output| &output.name))?;
        once("classes", self.classes.iter())?;
        for (at, pair) in self.pairs.iter().enumerate() {
            let name = format!("pair {} → {}", one_line(pair.input.clone()), one_line(pair.output.clone()));
            let is_twice = self.pairs[..at].iter().any(|of| of.input == pair.input && of.output == pair.output);
            refuse_if!(is_twice, model_error!("{name} is there twice: delete one of them"));
            self.check_pair(&name, pair)?;
        }
        self.check_wind()?;
        self.check_ambient()?;
        self.check_losses()?;
        self.end.as_ref().map_or(Ok(()), |end| self.check_end(end))
    }

    fn check_pair(&self, name: &str, pair: &Pair) -> Result<(), ModelError> {
        if !self.inputs.contains(&pair.input) || !self.outputs.iter().any(|output| output.name == pair.output) {
            return Err(model_error!("{name} names an input or output that the model does not have"));
        }
        let (dead_time, rates) = (pair.dead_time_samples, pair.mesh_rad_s.len());
        refuse_if!(
            dead_time > 1_000_000,
            model_error!("{name}: `dead_time_samples` is {dead_time}, more than a million")
        );
        self.check_rates(name, &pair.mesh_rad_s)?;
        if pair.se_rate_rad_s.as_ref().is_some_and(|se| se.len() != rates) {
            return Err(model_error!(
                "{name}: `se_rate_rad_s` must have one value for each of the {rates} rates, or be absent"
            ));
        }
        refuse_if!(pair.classes.is_empty(), model_error!("{name} has no class"));
        for (label, class) in &pair.classes {
            let is_known = self.classes.contains(label);
            let label = one_line(label.clone());
            refuse_if!(!is_known, model_error!("{name}: class `{label}` is none of the model's `classes`"));
            if class.r_k_per_w.len() != rates || class.se_k_per_w.len() != rates {
                return Err(model_error!(
                    "{name}, class `{label}`: `r_k_per_w` and `se_k_per_w` must have one value for each of the {rates} rates"
                ));
            }
            let known = class.covariance.as_ref().map(Vec::len);
            let free = if pair.se_rate_rad_s.is_some() { rates } else { 0 };
            let triangle = (rates + 1 + free) * (rates + 2 + free) / 2;
            if let Some(has) = known.filter(|has| *has != triangle) {
                return Err(model_error!(
                    "{name}, class `{label}`: `covariance` must have {triangle} values, the lower triangle, and has {has}"
                ));
            }
            let mut values = class.r_k_per_w.iter().chain([&class.feed_through_k_per_w, &class.steady_gain_k_per_w]);
            if let Some(value) = values.find(|value| !value.is_finite()) {
                return Err(model_error!("{name}, class `{label}`: {value} is no resistance"));
            }
        }
        Ok(())
    }

    fn check_rates(&self, name: &str, mesh_rad_s: &[f64]) -> Result<(), ModelError> {
        refuse_if!(mesh_rad_s.is_empty(), model_error!("{name}: `mesh_rad_s` has no rate, and needs one at least"));
        let (least, most) = RATE_TIMES_PERIOD;
        let (least, most) = (least / self.sample_period_s, most / self.sample_period_s);
        let mut before = 0.0;
        for &rate in mesh_rad_s {
            if !(rate.is_finite() && rate > before) {
                return Err(model_error!(
                    "{name}: `mesh_rad_s` must hold ascending rates above zero, and has {rate} after {before}"
                ));
            }
            if rate < least || rate > most {
                return Err(model_error!(
                    "{name}: `mesh_rad_s` has {rate:e} rad/s, which samples every {} s cannot show; rates must be from {least:.0e} to {most:.0e}",
                    tidy(self.sample_period_s)
                ));
            }
            before = rate;
        }
        Ok(())
    }

    fn check_wind(&self) -> Result<(), ModelError> {
        let wind = match (self.structure, &self.wind) {
            (Structure::Symbol, None) => return Ok(()),
            (Structure::Symbol, Some(_)) => return Err(model_error!("has `wind`, which structure `symbol` does not")),
            (Structure::Conductance, None) => return Err(model_error!("has structure `conductance` but no `wind`")),
            (Structure::Conductance, Some(wind)) => wind,
        };
        let elements = wind.elements.len();
        if elements != self.inputs.len() || elements != self.outputs.len() {
            return Err(model_error!(
                "structure `conductance` needs one input, one output and one set of conductances an element"
            ));
        }
        let missing = self.classes.iter().find(|label| wind.elements.iter().any(|of| !of.contains_key(*label)));
        if let Some(label) = missing {
            return Err(model_error!("`wind` has no conductance for class `{}`", one_line(label.clone())));
        }
        let Some(following) = &wind.following else { return Ok(()) };
        let is_column = matches!(wind.gas, ModelGas::Column(_));
        refuse_if!(!is_column, model_error!("`wind.following` needs the gas as a column, which outputs could follow"));
        self.check_following("`wind.following`", following)
    }

    fn check_ambient(&self) -> Result<(), ModelError> {
        let Some(ambient) = &self.ambient else { return Ok(()) };
        refuse_if!(
            self.structure != Structure::Symbol,
            model_error!("has `ambient`, which belongs to structure `symbol`: others have a gas")
        );
        self.check_following("`ambient.following`", &ambient.following)
    }

    fn check_following(&self, name: &str, following: &Following) -> Result<(), ModelError> {
        self.check_rates(name, &following.mesh_rad_s)?;
        let (has, outputs) = (following.outputs.len(), self.outputs.len());
        refuse_if!(
            has != outputs,
            model_error!("{name}: `outputs` has {has} entries for the model's {outputs} outputs")
        );
        let rates = following.mesh_rad_s.len();
        if following.outputs.iter().any(|of| of.f_k_per_k.len() != rates || of.se_k_per_k.len() != rates) {
            return Err(model_error!(
                "{name}: `f_k_per_k` and `se_k_per_k` must have one value for each of the {rates} rates"
            ));
        }
        let (from_c, [least_c, most_c]) = (following.from_c, following.range_c);
        if !(least_c <= from_c && from_c <= most_c) {
            return Err(model_error!(
                "{name}: `from_c` is {from_c}, which is not within `range_c`, {least_c} to {most_c}"
            ));
        }
        Ok(())
    }

    fn check_end(&self, end: &RecordEnd) -> Result<(), ModelError> {
        let (inputs, outputs) = (self.inputs.len(), self.outputs.len());
        let (decays, pending, classes) = (end.decays.len(), end.pending.len(), self.classes.len());
        if decays != outputs {
            return Err(model_error!(
                "`end.decays` must have one list for each of the {outputs} outputs, and has {decays}; without `end`, the model can be used but not continued"
            ));
        }
        if let Some((rate, _)) = end.decays.iter().flatten().find(|(rate, _)| *rate < 0.0) {
            return Err(model_error!("`end.decays` has the rate {rate}, and what is left of a record can only decay"));
        }
        if pending != 0 && pending != inputs {
            return Err(model_error!(
                "`end.pending` must have one list for each of the {inputs} inputs, and has {pending}"
            ));
        }
        let foreign = end.pending_class.iter().find(|class| **class >= classes);
        let fault = |class| model_error!("`end.pending_class` has {class}, and classes are 0 to {}", classes - 1);
        foreign.map_or(Ok(()), |class| Err(fault(class)))
    }
}

fn once<'n>(key: &str, names: impl Iterator<Item = &'n String>) -> Result<(), ModelError> {
    let names: Vec<&String> = names.collect();
    let double = (1..names.len()).find(|&at| names[..at].contains(&names[at]));
    let fault = |at: usize| model_error!("`{key}` has `{}` twice: names must differ", one_line(names[at].clone()));
    double.map_or(Ok(()), |at| Err(fault(at)))
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;

    fn sentence(change: impl FnOnce(&mut Model)) -> String {
        let mut model = testing::model(&[0.5, 5.0], &[10.0, 2.0]);
        model.end =
            Some(RecordEnd { decays: vec![vec![(0.5, 1.0)]], pending: vec![Vec::new()], ..RecordEnd::default() });
        assert_eq!(Model::from_json(&model.to_json()), Ok(model.clone()));
        change(&mut model);
        Model::from_json(&model.to_json()).unwrap_err().to_string()
    }

    #[test]
    fn rates_and_values_that_nothing_can_be_computed_from_are_refused() {
        assert_eq!(
            sentence(|model| model.pairs[0].mesh_rad_s[1] = 1e300),
            "`pairs[0].mesh_rad_s[1]` is a number too large to compute with"
        );
        assert_eq!(
            sentence(|model| model.pairs[0].mesh_rad_s[1] = 1e9),
            "pair power_w_a → temperature_c_a: `mesh_rad_s` has 1e9 rad/s, which samples every 0.1 s cannot show; rates must be from 1e-11 to 1e7"
        );
        assert!(sentence(|model| model.pairs[0].mesh_rad_s[0] = 1e-300).contains("has 1e-300 rad/s"));
        assert!(sentence(|model| model.pairs[0].mesh_rad_s.clear()).contains("`mesh_rad_s` has no rate"));
        assert!(sentence(|model| model.sample_period_s = 1e-30).starts_with("`sample_period_s` is 1e-30"));
        let huge = |model: &mut Model| {
            model.pairs[0].classes.values_mut().for_each(|class| class.r_k_per_w[0] = 1e308);
        };
        assert_eq!(sentence(huge), "`pairs[0].classes.all.r_k_per_w[0]` is a number too large to compute with");
    }

    #[test]
    fn a_number_beyond_what_a_double_holds_is_named() {
        let mut model = testing::model(&[0.5, 5.0], &[10.0, 2.0]);
        model.end =
            Some(RecordEnd { decays: vec![vec![(0.5, 1e300)]], pending: vec![Vec::new()], ..RecordEnd::default() });
        let text = model.to_json().replace("1e300", "1e999").replace("1e+300", "1e999");
        let sentence = Model::from_json(&text).unwrap_err().to_string();
        assert_eq!(sentence, "`end.decays[0][0][1]` is a number too large to compute with");
    }

    #[test]
    fn what_is_there_twice_is_refused() {
        let pair = sentence(|model| model.pairs.push(model.pairs[0].clone()));
        assert_eq!(pair, "pair power_w_a → temperature_c_a is there twice: delete one of them");
        assert_eq!(
            sentence(|model| model.inputs.push("power_w_a".to_owned())),
            "`inputs` has `power_w_a` twice: names must differ"
        );
        assert!(sentence(|model| model.outputs.push(model.outputs[0].clone())).starts_with("`outputs` has"));
        assert!(sentence(|model| model.classes.push("all".to_owned())).starts_with("`classes` has `all` twice"));
    }

    #[test]
    fn an_end_that_does_not_belong_to_the_model_is_refused() {
        let end = |change: fn(&mut RecordEnd)| sentence(|model| model.end.as_mut().into_iter().for_each(change));
        assert!(end(|end| end.decays.clear()).starts_with("`end.decays` must have one list for each of the 1 outputs"));
        assert!(end(|end| end.decays.push(Vec::new())).contains("and has 2"));
        assert!(end(|end| end.decays[0][0].0 = -1.0).contains("the rate -1"));
        assert!(end(|end| end.pending.push(Vec::new())).starts_with("`end.pending` must have one list"));
        assert_eq!(end(|end| end.pending_class.push(1)), "`end.pending_class` has 1, and classes are 0 to 0");
    }

    #[test]
    fn a_byte_order_mark_before_a_model_does_no_harm() {
        let model = testing::model(&[0.5], &[10.0]);
        assert_eq!(Model::from_json(&format!("\u{feff}{}", model.to_json())), Ok(model));
    }
}
