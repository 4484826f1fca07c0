//! What a model says of its losses: g and b with standard errors, reasons, warnings.

use super::super::folds::change;
use super::search::FoundLoss;
use super::source::SearchedLoss;
use crate::model::{ElementLoss, Estimate, LossOrigin, Model, ModelLosses};
use recording::text::estimate;

/// Warning of a model that has none of the losses that were asked for.
pub const UNTOLD: &str = "losses that grow with temperature are not told from others, so the model has none: record for longer, over a wider range of temperatures, and until they stand";

/// By how much standard errors that take residuals for white are too small.
pub fn inflation(model: &Model) -> f64 {
    let of = model.outputs.iter().filter_map(|output| output.whiteness.as_ref());
    of.map(|white| white.inflation).fold(1.0, f64::max)
}

/// Adds its losses to a model that was identified with them, and what they add to its standard
/// errors. `plain` is the one without, of which `first` has the cross-validated error.
pub fn complete(model: &mut Model, plain: &Model, losses: &[SearchedLoss], first: &[FoundLoss], found: &[FoundLoss]) {
    // Inputs are those of the record, not what is left of them.
    model.provenance = plain.provenance.clone();
    let mut elements = Vec::new();
    for (used, found) in losses.iter().zip(found) {
        let (input, output) = (model.inputs[used.placed.input].clone(), model.outputs[used.placed.output].name.clone());
        let of_output = &mut model.outputs[used.placed.output];
        let inflation = of_output.whiteness.as_ref().map_or(1.0, |white| white.inflation);
        let g = Estimate { value: used.placed.g_w_per_k2, ..found.g(inflation) };
        of_output.se_offset_c = libm::hypot(of_output.se_offset_c, found.offset_slope * found.se_w_per_k2);
        let b_slope = found.gain_k_per_w + g.value * found.gain_slope;
        let first = model.classes.first();
        let mut pair = model.pairs.iter_mut().find(|pair| pair.input == input && pair.output == output);
        let mut b = Estimate { value: found.b_per_k(), se: 0.0 };
        for (label, class) in pair.iter_mut().flat_map(|pair| &mut pair.classes) {
            if Some(label) == first {
                // Σ R moves with g, and is not known for a given g either.
                let given_g = g.value * class.se_steady_gain_k_per_w;
                let se = libm::hypot(b_slope * found.se_w_per_k2, given_g);
                b = Estimate { value: g.value * class.steady_gain_k_per_w, se: inflation * se };
            }
            let own = found.gain_slope * found.se_w_per_k2;
            class.se_steady_gain_k_per_w = libm::hypot(class.se_steady_gain_k_per_w, own);
        }
        elements.push(ElementLoss { output, input, g_w_per_k2: g, b_per_k: b });
    }
    for ((loss, first), found) in elements.iter().zip(first).zip(found) {
        let (without, with) = (first.scores[0].overall(), found.scores[1].overall());
        model.chosen.reasons.push(format!(
            "losses of `{}` that grow with `{}`: g = {} per K², b = {} 1/K; cross-validated error without them {}",
            loss.input,
            loss.output,
            estimate(loss.g_w_per_k2.value, loss.g_w_per_k2.se),
            estimate(loss.b_per_k.value, loss.b_per_k.se),
            change(without / with.max(1e-300))
        ));
        model.warnings.extend(warning(loss, found));
    }
    model.supported = model.warnings.is_empty();
    model.losses = Some(ModelLosses { origin: LossOrigin::Offset, elements });
}

/// Why a loss that was asked for is not known.
fn warning(loss: &ElementLoss, found: &FoundLoss) -> Option<String> {
    let Estimate { value, se } = loss.b_per_k;
    let felt = found.greatest_rise_k * value.max(2.0 * se);
    (value < 2.0 * se && felt > 0.02).then(|| {
        format!(
            "`{}`: the growth of losses, {} 1/K, is not told from none: record with a wider range of temperatures",
            loss.output,
            estimate(value, se)
        )
    })
}
