//! Losses that grow with temperature: heat that an element's own temperature takes out of its
//! input, beside what its resistances know.
//!
//! ```text
//! w_i = u_i − Σ g (T_o − T_0)²,    y = offset + H · w,    steady state: ΔT + b ΔT² = Z · u
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | g | growth of the conductance to the surroundings with temperature | W/K² |
//! | b = g Σ R | the same over the conductance itself, at ΔT = 0 | 1/K |
//! | T_0 | temperature without heat: the offset, or a measured ambient | °C |
//!
//! A body with the conductance G = G_0 (1 + β ΔT) has b = β. As wind does (theory 12), the loss
//! stands in the input, so that H stays linear.
//!
//! Limits: the loss is that of the heated body itself, taken at the start of each sample and held;
//! below T_0 it goes on as the square, as the conductance falls there.

use super::ModelError;
use super::content::{Model, Structure};
use super::pair_class::PairClass;
use recording::text::one_line;

/// One loss, by the places of its columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedLoss {
    /// Place of the input.
    pub input: usize,
    /// Place of the output.
    pub output: usize,
    /// g, W/K².
    pub g_w_per_k2: f64,
}

impl PlacedLoss {
    /// Power in W that it takes at a rise in K over its origin.
    pub fn taken_w(&self, rise_k: f64) -> f64 {
        self.g_w_per_k2 * (rise_k * rise_k)
    }
}

impl Model {
    /// Losses that grow with temperature, by the places of their columns; none for a linear model.
    pub fn placed_losses(&self) -> Vec<PlacedLoss> {
        let elements = self.losses.iter().flat_map(|losses| &losses.elements);
        let placed = elements.filter_map(|loss| {
            let input = self.inputs.iter().position(|name| *name == loss.input)?;
            let output = self.outputs.iter().position(|output| output.name == loss.output)?;
            Some(PlacedLoss { input, output, g_w_per_k2: loss.g_w_per_k2.value })
        });
        placed.collect()
    }

    /// Refuses what only a linear model can go through.
    ///
    /// # Errors
    /// If losses grow with temperature; `what` ends the sentence.
    pub fn refuse_losses(&self, what: &str) -> Result<(), ModelError> {
        refuse_if!(self.losses.is_some(), model_error!("has `losses` that grow with temperature, and {what}"));
        Ok(())
    }

    pub(super) fn check_losses(&self) -> Result<(), ModelError> {
        let Some(losses) = &self.losses else { return Ok(()) };
        refuse_if!(
            self.structure == Structure::Conductance,
            model_error!("`losses` belong to structure `symbol`, and the model's is `conductance`")
        );
        refuse_if!(losses.elements.is_empty(), model_error!("`losses.elements` is empty: leave `losses` out"));
        for (at, loss) in losses.elements.iter().enumerate() {
            let (input, output) = (one_line(loss.input.clone()), one_line(loss.output.clone()));
            let name = format!("`losses.elements[{at}]`, {input} → {output}");
            let pair = self.pair(&loss.input, &loss.output);
            let Some(pair) = pair else {
                return Err(model_error!(
                    "{name}: there is no pair of this input and output, from which heat could be lost"
                ));
            };
            let is_twice = losses.elements[..at].iter().any(|of| of.input == loss.input && of.output == loss.output);
            refuse_if!(is_twice, model_error!("{name} is there twice: delete one of them"));
            let g = loss.g_w_per_k2.value;
            refuse_if!(
                !(g.is_finite() && g >= 0.0),
                model_error!("{name}: `g_w_per_k2` is {g}, and must not be negative")
            );
            // A response at once would be lost at once: a loop without a step between.
            let of_input = self.pairs.iter().filter(|other| other.input == pair.input);
            let is_at_once = of_input.flat_map(|other| other.classes.values()).any(|of| of.feed_through_k_per_w != 0.0);
            refuse_if!(
                is_at_once,
                model_error!("{name}: losses that grow with temperature and `feed_through_k_per_w` do not go together")
            );
        }
        Ok(())
    }
}

impl PairClass<'_> {
    /// g of the pair in W/K²; 0 where its losses do not grow.
    pub fn loss_w_per_k2(&self) -> f64 {
        let elements = self.model.losses.iter().flat_map(|losses| &losses.elements);
        let own = elements.filter(|loss| loss.input == self.pair.input && loss.output == self.pair.output);
        own.map(|loss| loss.g_w_per_k2.value).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::content::LossOrigin;
    use super::super::testing;
    use super::*;

    #[test]
    fn losses_are_read_as_they_were_written_and_old_models_have_none() {
        let plain = testing::model(&[0.5], &[10.0]);
        assert!(!plain.to_json().contains("losses"));
        let mut model = plain;
        testing::add_loss(&mut model, 3e-4);
        for origin in [LossOrigin::Offset, LossOrigin::Column("ambient".to_owned())] {
            model.losses.as_mut().unwrap().origin = origin;
            assert_eq!(Model::from_json(&model.to_json()), Ok(model.clone()));
        }
        assert_eq!(model.placed_losses(), [PlacedLoss { input: 0, output: 0, g_w_per_k2: 3e-4 }]);
    }

    #[test]
    fn losses_that_nothing_can_be_computed_from_are_refused() {
        let sentence = |change: &dyn Fn(&mut Model)| {
            let mut model = testing::model(&[0.5], &[10.0]);
            testing::add_loss(&mut model, 3e-4);
            change(&mut model);
            Model::from_json(&model.to_json()).unwrap_err().to_string()
        };
        let first = |model: &mut Model| model.losses.as_mut().unwrap().elements.remove(0);
        assert!(sentence(&|model| drop(first(model))).contains("`losses.elements` is empty"));
        assert!(
            sentence(&|model| model.losses.as_mut().unwrap().elements[0].g_w_per_k2.value = -1.0)
                .contains("not be negative")
        );
        assert!(
            sentence(&|model| model.losses.as_mut().unwrap().elements[0].input = "x".to_owned())
                .contains("there is no pair")
        );
        let at_once = |model: &mut Model| {
            model.pairs[0].classes.values_mut().for_each(|class| class.feed_through_k_per_w = 1.0);
        };
        assert!(sentence(&at_once).contains("do not go together"));
        let double = |model: &mut Model| {
            let losses = model.losses.as_mut().unwrap();
            losses.elements.push(losses.elements[0].clone());
        };
        assert!(sentence(&double).contains("is there twice"));
    }
}
