//! The quiescent-gas network of a head from the model of all its pairs.
//!
//! | of the model | of the network |
//! |---|---|
//! | pair `power_w_a` → `temperature_c_a` | self-heating of `a`: at most 8 rates, none negative if the head has layers there |
//! | pair `power_w_a` → `temperature_c_b` | cross-heating: at most 4 rates of any sign |
//! | offset of `temperature_c_a` | its temperature with no heating at all, °C |
//! | residuals of `temperature_c_a`, at its low level | noise of its readings |
//!
//! Elements with an outward normal have a surface and so a convective loss; the others are only
//! held on their temperatures. An element that the model does not have is not in the network.

use dr_core::model::ORDER;
use dr_core::model::convection_observer::config::CROSS_ORDER;

use super::error::NetworkError;
use super::ladder::{cross_share, sections, share};
use super::parameters::{CrossHeatingParameters, QuiescentNetwork, ReadingNoise, SelfHeatingParameters};
use super::plausible::absurdities;
use crate::head::element::HeadElement;
use crate::head::file::Head;
use diffusive::model::{Model, ModelOutput, Pair, Structure};
use recording::{POWER, TEMPERATURE};

impl QuiescentNetwork {
    /// The network of the elements of `head` that `model` has.
    ///
    /// # Errors
    /// Which pair or element cannot be in a quiescent-gas network, and why.
    pub fn of(model: &Model, head: &Head) -> Result<Self, NetworkError> {
        if model.structure != Structure::Symbol {
            return Err(NetworkError::new(
                "structure `conductance` has its wind inside; a quiescent-gas network is made of structure `symbol`, from records in quiescent gas",
            ));
        }
        let [label] = &model.classes[..] else {
            return Err(NetworkError::new(format!(
                "the model has the classes {}: a quiescent-gas network has one, quiescent gas",
                model.classes.join(", ")
            )));
        };
        let mut own = Vec::new();
        for (element, of) in head.elements.iter().enumerate() {
            let (input, output) =
                (recording::column_name(POWER, &of.name), recording::column_name(TEMPERATURE, &of.name));
            let Some(pair) = model.pair(&input, &output) else { continue };
            let Some(known) = model.outputs.iter().find(|known| known.name == output) else { continue };
            own.push(self_heating(pair, label, of, element, known)?);
        }
        if own.is_empty() {
            return Err(NetworkError::new(format!(
                "the model heats none of head `{}` and sees it become warm: its pairs must be named after {}",
                head.name,
                head.names().join(", ")
            )));
        }
        let mut cross = Vec::new();
        for from in &own {
            for to in own.iter().filter(|to| to.element != from.element) {
                cross.push(cross_heating(model, label, from, to)?);
            }
        }
        Ok(Self { own, cross })
    }
}

/// The network of a head, if it is known; what keeps it from being one becomes a warning of the
/// model.
pub fn checked(model: &mut Model, head: Option<&Head>) -> Option<QuiescentNetwork> {
    let network = match head {
        None => {
            Err("the records carry no head: what lies between elements and surface is not known; name one with --head"
                .to_owned())
        }
        Some(head) => QuiescentNetwork::of(model, head).map_err(|error| error.to_string()),
    };
    let network = network.map_err(|sentence| model.warnings.push(sentence)).ok();
    if let (Some(network), Some(head)) = (&network, head) {
        model.warnings.extend(absurdities(network, head, model.sample_period_s));
    }
    model.supported = model.warnings.is_empty();
    network
}

fn self_heating(
    pair: &Pair,
    label: &str,
    of: &HeadElement,
    element: usize,
    known: &ModelOutput,
) -> Result<SelfHeatingParameters, NetworkError> {
    let r_k_per_w = resistances(pair, label, ORDER)?;
    let layers = sections(&pair.mesh_rad_s, &r_k_per_w, of.layers).map_err(|error| error.of(&of.name))?;
    let shares = || pair.mesh_rad_s.iter().map(|&rate| share(&layers, rate)).collect();
    Ok(SelfHeatingParameters {
        element,
        name: of.name.clone(),
        rest_c: known.offset_c,
        noise: ReadingNoise::by_low(known.residual_rms, &of.nominal),
        surface: of.is_surface().then(shares),
        mesh_rad_s: pair.mesh_rad_s.clone(),
        r_k_per_w,
        layers,
    })
}

fn cross_heating(
    model: &Model,
    label: &str,
    from: &SelfHeatingParameters,
    to: &SelfHeatingParameters,
) -> Result<CrossHeatingParameters, NetworkError> {
    let (input, output) = (recording::column_name(POWER, &from.name), recording::column_name(TEMPERATURE, &to.name));
    let Some(pair) = model.pair(&input, &output) else {
        return Err(NetworkError::new(format!(
            "the model does not say how `{}` heats `{}`: identify `{input}` with all temperatures as outputs",
            from.name, to.name
        )));
    };
    let r_k_per_w = resistances(pair, label, CROSS_ORDER)?;
    let mesh_rad_s = pair.mesh_rad_s.clone();
    let surface = mesh_rad_s.iter().map(|&rate| cross_share(&from.layers, rate)).collect();
    let (from_name, to_name) = (from.name.clone(), to.name.clone());
    let (from, to) = (from.element, to.element);
    Ok(CrossHeatingParameters { from, to, from_name, to_name, mesh_rad_s, r_k_per_w, surface })
}

/// R_k of a pair that the board can run.
fn resistances(pair: &Pair, label: &str, most: usize) -> Result<Vec<f64>, NetworkError> {
    let refuse = |why: String| Err(NetworkError::new(format!("pair {} → {} {why}", pair.input, pair.output)));
    let Some(class) = pair.classes.get(label) else { return refuse(format!("has no class `{label}`")) };
    let rates = pair.mesh_rad_s.len();
    if rates > most {
        return refuse(format!("has {rates} rates, and the board carries {most} of it: identify it with --free-poles"));
    }
    if class.feed_through_k_per_w != 0.0 || pair.dead_time_samples != 0 {
        return refuse(
            "answers at once or late, which the board's network does not: identify it with --feed-through no --dead-time 0"
                .to_owned(),
        );
    }
    Ok(class.r_k_per_w.clone())
}

#[cfg(test)]
pub(crate) mod tests;
