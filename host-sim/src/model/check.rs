//! What must hold in a model that was read from a file, and types alone do not say: whoever computes with a model relies on it.

use super::{End, Following, Gas, Model, Pair, Structure};
use crate::recording::tidy;

/// Sample periods that a record can have, s.
const PERIODS_S: (f64, f64) = (1e-12, 1e12);

/// Rates times the sample period: a faster relaxation has ended and a slower one not begun within any record.
const RATE_TIMES_PERIOD: (f64, f64) = (1e-12, 1e6);

impl Model {
    /// # Errors
    /// A sentence that names the key and what would be right.
    pub(super) fn check(&self) -> Result<(), String> {
        let period_s = self.sample_period_s;
        if !(period_s.is_finite() && period_s > 0.0) {
            return Err(format!("`sample_period_s` must be a number greater than zero, and is {period_s}"));
        }
        if !(PERIODS_S.0..=PERIODS_S.1).contains(&period_s) {
            let (least, most) = PERIODS_S;
            return Err(format!("`sample_period_s` is {period_s:e}, and must be from {least:e} to {most:e}"));
        }
        if self.inputs.is_empty() || self.outputs.is_empty() || self.pairs.is_empty() || self.classes.is_empty() {
            return Err("must have at least one input, output, pair and class".to_owned());
        }
        once("inputs", self.inputs.iter())?;
        once("outputs", self.outputs.iter().map(|output| &output.name))?;
        once("classes", self.classes.iter())?;
        for (at, pair) in self.pairs.iter().enumerate() {
            if self.pairs[..at].iter().any(|known| known.input == pair.input && known.output == pair.output) {
                return Err(format!("pair {} → {} is there twice: delete one of them", pair.input, pair.output));
            }
            self.check_pair(pair).map_err(|sentence| format!("pair {} → {}{sentence}", pair.input, pair.output))?;
        }
        self.check_wind()?;
        self.end.as_ref().map_or(Ok(()), |end| self.check_end(end))
    }

    /// The rest of a sentence that begins with the pair.
    fn check_pair(&self, pair: &Pair) -> Result<(), String> {
        if !self.inputs.contains(&pair.input) || !self.outputs.iter().any(|output| output.name == pair.output) {
            return Err(" names an input or output that the model does not have".to_owned());
        }
        if pair.dead_time_samples > 1_000_000 {
            return Err(format!(": `dead_time_samples` is {}, more than a million", pair.dead_time_samples));
        }
        let rates = pair.mesh_rad_s.len();
        self.check_mesh(&pair.mesh_rad_s)?;
        if pair.se_rate_rad_s.as_ref().is_some_and(|se| se.len() != rates) {
            return Err(format!(": `se_rate_rad_s` must have one value for each of the {rates} rates, or be absent"));
        }
        if pair.classes.is_empty() {
            return Err(" has no class".to_owned());
        }
        for (label, class) in &pair.classes {
            if !self.classes.contains(label) {
                return Err(format!(": class `{label}` is none of the model's `classes`"));
            }
            if class.r_k_per_w.len() != rates || class.se_k_per_w.len() != rates {
                return Err(format!(
                    ", class `{label}`: `r_k_per_w` and `se_k_per_w` must have one value for each of the {rates} rates"
                ));
            }
            let mut values = class.r_k_per_w.iter().chain([&class.feed_through_k_per_w, &class.steady_gain_k_per_w]);
            if let Some(value) = values.find(|value| !value.is_finite()) {
                return Err(format!(", class `{label}`: {value} is no resistance"));
            }
        }
        Ok(())
    }

    /// The rest of a sentence that begins with what has the mesh.
    fn check_mesh(&self, mesh_rad_s: &[f64]) -> Result<(), String> {
        if mesh_rad_s.is_empty() {
            return Err(": `mesh_rad_s` has no rate, and needs one at least".to_owned());
        }
        let (least, most) = RATE_TIMES_PERIOD;
        let (least, most) = (least / self.sample_period_s, most / self.sample_period_s);
        let mut before = 0.0;
        for &rate in mesh_rad_s {
            if !(rate.is_finite() && rate > before) {
                return Err(format!(
                    ": `mesh_rad_s` must hold ascending rates above zero, and has {rate} after {before}"
                ));
            }
            if rate < least || rate > most {
                return Err(format!(
                    ": `mesh_rad_s` has {rate:e} rad/s, which samples every {} s cannot show; rates must be from {least:.0e} to {most:.0e}",
                    tidy(self.sample_period_s)
                ));
            }
            before = rate;
        }
        Ok(())
    }

    fn check_wind(&self) -> Result<(), String> {
        match (self.structure, &self.wind) {
            (Structure::Symbol, None) => Ok(()),
            (Structure::Symbol, Some(_)) => Err("has `wind`, which structure `symbol` does not".to_owned()),
            (Structure::Conductance, None) => Err("has structure `conductance` but no `wind`".to_owned()),
            (Structure::Conductance, Some(wind)) => {
                let elements = wind.elements.len();
                if elements != self.inputs.len() || elements != self.outputs.len() {
                    return Err(
                        "structure `conductance` needs one input, one output and one set of conductances an element"
                            .to_owned(),
                    );
                }
                let missing = self.classes.iter().find(|label| wind.elements.iter().any(|of| !of.contains_key(*label)));
                if let Some(label) = missing {
                    return Err(format!("`wind` has no conductance for class `{label}`"));
                }
                let following = wind.following.as_ref();
                following.map_or(Ok(()), |following| {
                    let checked = self.check_following(following, &wind.gas);
                    checked.map_err(|sentence| format!("`wind.following`{sentence}"))
                })
            }
        }
    }

    /// The rest of a sentence that begins with the key.
    fn check_following(&self, following: &Following, gas: &Gas) -> Result<(), String> {
        if !matches!(gas, Gas::Column(_)) {
            return Err(" needs the gas as a column, which outputs could follow".to_owned());
        }
        self.check_mesh(&following.mesh_rad_s)?;
        let (has, outputs) = (following.outputs.len(), self.outputs.len());
        if has != outputs {
            return Err(format!(": `outputs` has {has} entries for the model's {outputs} outputs"));
        }
        let rates = following.mesh_rad_s.len();
        if following.outputs.iter().any(|of| of.f_k_per_k.len() != rates || of.se_k_per_k.len() != rates) {
            return Err(format!(": `f_k_per_k` and `se_k_per_k` must have one value for each of the {rates} rates"));
        }
        let [least, most] = following.range_c;
        if !(least <= following.from_c && following.from_c <= most) {
            let from_c = following.from_c;
            return Err(format!(": `from_c` is {from_c}, which is not within `range_c`, {least} to {most}"));
        }
        Ok(())
    }

    fn check_end(&self, end: &End) -> Result<(), String> {
        let (inputs, outputs) = (self.inputs.len(), self.outputs.len());
        if end.decays.len() != outputs {
            let has = end.decays.len();
            return Err(format!(
                "`end.decays` must have one list for each of the {outputs} outputs, and has {has}; without `end`, the model can be used but not continued"
            ));
        }
        if let Some((rate, _)) = end.decays.iter().flatten().find(|(rate, _)| *rate < 0.0) {
            return Err(format!("`end.decays` has the rate {rate}, and what is left of a record can only decay"));
        }
        if !end.pending.is_empty() && end.pending.len() != inputs {
            let has = end.pending.len();
            return Err(format!("`end.pending` must have one list for each of the {inputs} inputs, and has {has}"));
        }
        let classes = self.classes.len();
        match end.pending_class.iter().find(|class| **class >= classes) {
            Some(class) => Err(format!("`end.pending_class` has {class}, and classes are 0 to {}", classes - 1)),
            None => Ok(()),
        }
    }
}

fn once<'n>(key: &str, names: impl Iterator<Item = &'n String>) -> Result<(), String> {
    let names: Vec<&String> = names.collect();
    let double = (1..names.len()).find(|&at| names[..at].contains(&names[at]));
    double.map_or(Ok(()), |at| Err(format!("`{key}` has `{}` twice: names must differ", names[at])))
}

#[cfg(test)]
mod tests {
    use super::super::export::testing;
    use super::*;

    fn sentence(change: impl FnOnce(&mut Model)) -> String {
        let mut model = testing::model(&[0.5, 5.0], &[10.0, 2.0]);
        model.end = Some(End { decays: vec![vec![(0.5, 1.0)]], pending: vec![Vec::new()], ..End::default() });
        assert_eq!(Model::from_json(&model.to_json()), Ok(model.clone()));
        change(&mut model);
        Model::from_json(&model.to_json()).unwrap_err()
    }

    #[test]
    fn rates_and_values_that_nothing_can_be_computed_from_are_refused() {
        assert_eq!(
            sentence(|model| model.pairs[0].mesh_rad_s[1] = 1e300),
            "`pairs[0].mesh_rad_s[1]` is a number too large to compute with"
        );
        assert_eq!(
            sentence(|model| model.pairs[0].mesh_rad_s[1] = 1e9),
            "pair power_w:a → temperature_c:a: `mesh_rad_s` has 1e9 rad/s, which samples every 0.1 s cannot show; rates must be from 1e-11 to 1e7"
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
        model.end = Some(End { decays: vec![vec![(0.5, 1e300)]], pending: vec![Vec::new()], ..End::default() });
        let text = model.to_json().replace("1e300", "1e999").replace("1e+300", "1e999");
        let sentence = Model::from_json(&text).unwrap_err();
        assert_eq!(sentence, "`end.decays[0][0][1]` is a number too large to compute with");
    }

    #[test]
    fn what_is_there_twice_is_refused() {
        let pair = sentence(|model| model.pairs.push(model.pairs[0].clone()));
        assert_eq!(pair, "pair power_w:a → temperature_c:a is there twice: delete one of them");
        assert_eq!(
            sentence(|model| model.inputs.push("power_w:a".to_owned())),
            "`inputs` has `power_w:a` twice: names must differ"
        );
        assert!(sentence(|model| model.outputs.push(model.outputs[0].clone())).starts_with("`outputs` has"));
        assert!(sentence(|model| model.classes.push("all".to_owned())).starts_with("`classes` has `all` twice"));
    }

    #[test]
    fn an_end_that_does_not_belong_to_the_model_is_refused() {
        let end = |change: fn(&mut End)| sentence(|model| model.end.as_mut().into_iter().for_each(change));
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
