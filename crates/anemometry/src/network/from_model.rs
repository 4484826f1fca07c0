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
//!
//! Layers between an element and its surface: the first sections of the ladder of its self-heating,
//! and the share that they let through.
//!
//! ```text
//! element ─┬─ R_1 ─┬─ R_2 ─ surface …        T_0 = 1, I_0 = 0
//!         C_1     C_2                         per section  I ← I + C_i s T,  T ← T + R_i I
//!                                             m_k = T_n at s = −ξ_k
//! ```
//!
//! In a mode of the network all nodes decay with one rate ξ_k, and what flows out of a node is what
//! it and those before it give up: so the temperature of the surface over that of the element is
//! the polynomial above. By reciprocity the same number says how much of the heat that the surface
//! loses enters the mode, counted as heat of the element.
//!
//! | check | |
//! |---|---|
//! | Σ R_k m_k = Σ R_k − Σ R_i | in the end the surface is colder by the resistances before it |
//!
//! Limits: the number of sections is known from how the sensor is built; a Foster model that leaves
//! more than noise has a ladder whose first sections are no layers. A pair of different elements
//! has effective rates, which are no modes where they are fast; see [`cross_share`].
//!
//! Signs in an identified network if the ratio of an element's two currents is off: its heat is not
//! what it seems, since readings jump with the level.
//!
//! | shown | by |
//! |---|---|
//! | residuals of an element in its own record | more than twice the noise of its readings at the low level, which is the greater one, and more than 5 mK, as some 30 ppm leave |
//! | share of the surface in the slowest relaxation | less than 0.9: the layers are no longer those below the surface |
//! | resistance of a layer | more than twice, or less than half of, the median of its kind |
//! | heat within a tick | a relaxation of more than 3 rad a tick that would be an error of more than 100 ppm: ε = R (P_high − P_low)/κ, κ = R/(dR/dT) |
//!
//! Limits: in records of long ticks a layer that relaxes within one and such an error are the same;
//! below 100 ppm only the self-test of the currents tells them apart.

pub use diffusive::model::export::cauer::LadderSection;
use diffusive::model::export::cauer::cauer;
use diffusive::model::{Model, ModelOutput, Pair, Structure};
use dr_core::model::ORDER;
use dr_core::model::convection_observer::config::CROSS_ORDER;
use dr_core::sensor::Level;
use recording::{POWER, TEMPERATURE};

use super::parameters::{CrossHeatingParameters, NetworkError, QuiescentNetwork, ReadingNoise, SelfHeatingParameters};

use crate::head::element::HeadElement;
use crate::head::file::Head;

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
            let classes = model.classes.join(", ");
            let sentence =
                format!("the model has the classes {classes}: a quiescent-gas network has one, quiescent gas");
            return Err(NetworkError::new(sentence));
        };
        let mut own = Vec::new();
        for (element, of) in head.elements.iter().enumerate() {
            let [input, output] = [POWER, TEMPERATURE].map(|quantity| recording::column_name(quantity, &of.name));
            let Some(pair) = model.pair(&input, &output) else { continue };
            let Some(known) = model.outputs.iter().find(|known| known.name == output) else { continue };
            own.push(self_heating(pair, label, of, element, known)?);
        }
        if own.is_empty() {
            let (head, names) = (&head.name, head.names().join(", "));
            let sentence = format!("the model heats none of head `{head}` and sees it become warm");
            return Err(NetworkError::new(format!("{sentence}: its pairs must be named after {names}")));
        }
        let pairs = own.iter().flat_map(|from| own.iter().map(move |to| (from, to)));
        let cross = pairs.filter(|(from, to)| from.element != to.element);
        let cross = cross.map(|(from, to)| cross_heating(model, label, from, to)).collect::<Result<_, _>>()?;
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

/// The first `layers` sections of the impedance Σ R_k/(1 + s/ξ_k).
///
/// # Errors
/// Too few rates for so many layers, or a negative resistance.
pub fn sections(mesh_rad_s: &[f64], r_k_per_w: &[f64], layers: usize) -> Result<Vec<LadderSection>, NetworkError> {
    if layers == 0 {
        return Ok(Vec::new());
    }
    let mut ladder = cauer(mesh_rad_s, r_k_per_w).map_err(NetworkError::new)?;
    let known = ladder.len();
    if known <= layers {
        return Err(NetworkError::new(format!(
            "{known} rates make a ladder of {known} sections, and {layers} layers between element and surface take at least {}: identify it with more free poles, or say fewer `layers` in the head",
            layers + 1
        )));
    }
    ladder.truncate(layers);
    Ok(ladder)
}

/// m: temperature of the surface over that of the element in what decays with `rate_rad_s`.
pub fn share(sections: &[LadderSection], rate_rad_s: f64) -> f64 {
    walk(sections, rate_rad_s).1
}

/// The same for a relaxation of a pair of different elements, whose rate is an effective one.
///
/// Share for as long as no node before the surface has turned its sign (by Sturm's theorem: below
/// all rates of the layers by themselves) the polynomial is a share between 0 and 1. Beyond, it
/// would grow without bounds, whereas of heat at the surface such a fast relaxation, in which the
/// element's own layers would have to take part, passes next to nothing on: it is held at 0.
pub fn cross_share(sections: &[LadderSection], rate_rad_s: f64) -> f64 {
    let (least, last) = walk(sections, rate_rad_s);
    if least > 0.0 { last } else { 0.0 }
}

/// The time by which the surface lags behind the element, s: Σ_i R_i Σ_{j≤i} C_j, the polynomial's
/// slope.
pub fn contact_time_s(sections: &[LadderSection]) -> f64 {
    let mut capacitance = 0.0;
    let of = |section: &LadderSection| {
        capacitance += section.capacitance_j_per_k;
        section.resistance_k_per_w * capacitance
    };
    sections.iter().map(of).sum()
}

/// Least temperature of all nodes, and that of the last one.
fn walk(sections: &[LadderSection], rate_rad_s: f64) -> (f64, f64) {
    let (mut least, mut temperature, mut current) = (1.0_f64, 1.0, 0.0);
    for section in sections {
        current -= section.capacitance_j_per_k * rate_rad_s * temperature;
        temperature += section.resistance_k_per_w * current;
        least = least.min(temperature);
    }
    (least, temperature)
}

/// Residuals over noise that are suspicious; without an error it is 0.7 to 1.6.
const RESIDUALS: f64 = 2.0;
/// Less than 30 ppm would leave is of the model, K.
const LEAST_RESIDUAL_K: f64 = 5e-3;
/// Least share of a surface in the slowest relaxation.
const SHARE: f64 = 0.9;
/// A layer's resistance over the median of its kind.
const APART: f64 = 2.0;
/// A relaxation is within a tick from this angle on, rad.
const WITHIN_TICK_RAD: f64 = 3.0;
/// Heat within a tick that is suspicious, as an error of the ratio, ppm.
const ERROR_PPM: f64 = 100.0;

/// Advice, behind what was found.
const ADVICE: &str = "the ratio of its currents may be off: `anemo self-test EXPERIMENT --currents` measures it";

/// The sentence on residuals in an element's own record, K rms, if they are suspicious.
pub(super) fn residuals(element: &str, residual_k: f64, noise_k: f64) -> Option<String> {
    (residual_k > LEAST_RESIDUAL_K.max(RESIDUALS * noise_k)).then(|| {
        let [left, noise] = [residual_k, noise_k].map(|kelvin| 1e3 * kelvin);
        format!("{element}: its record leaves {left:.1} mK, and its readings have {noise:.1} mK of noise: {ADVICE}")
    })
}

/// Sentences on self-heating that no head has.
pub(super) fn absurdities(network: &QuiescentNetwork, head: &Head, sample_period_s: f64) -> Vec<String> {
    let mut sentences = Vec::new();
    for own in &network.own {
        let of = &head.elements[own.element];
        let slowest = own.surface.as_ref().and_then(|surface| surface.first()).copied();
        let error_ppm = within_tick_ppm(own, of, sample_period_s);
        let found = if let Some(share) = slowest.filter(|share| *share < SHARE) {
            format!("the surface has {share:.2} of its slowest relaxation, which is no layer's")
        } else if let Some(words) = unlike_its_kind(own, network, head) {
            words
        } else if error_ppm > ERROR_PPM {
            format!("{error_ppm:.0} ppm of its current would be the heat that it shows within a tick")
        } else {
            continue;
        };
        sentences.push(format!("{}: {found}: {ADVICE}", own.name));
    }
    sentences
}

/// Heat within a tick as an error of the ratio, ppm.
fn within_tick_ppm(own: &SelfHeatingParameters, of: &HeadElement, sample_period_s: f64) -> f64 {
    let quick =
        own.mesh_rad_s.iter().zip(&own.r_k_per_w).filter(|(rate, _)| **rate * sample_period_s > WITHIN_TICK_RAD);
    let k_per_w: f64 = quick.map(|(_, r)| r).sum();
    let power_w = of.power_w(own.rest_c, Level::High) - of.power_w(own.rest_c, Level::Low);
    let ohm = f64::from(of.config.channel.platinum().resistance_ohm(own.rest_c as f32));
    1e6 * k_per_w * power_w * of.ohm_per_k(own.rest_c) / ohm
}

/// Sentence of a layer whose resistance is not that of the others of its kind.
fn unlike_its_kind(own: &SelfHeatingParameters, network: &QuiescentNetwork, head: &Head) -> Option<String> {
    let kind = |of: &SelfHeatingParameters| head.elements[of.element].kind.as_deref();
    let alike: Vec<_> = network.own.iter().filter(|of| kind(of).is_some() && kind(of) == kind(own)).collect();
    own.layers.iter().enumerate().find_map(|(k, layer)| {
        let mut all: Vec<f64> =
            alike.iter().filter_map(|of| of.layers.get(k)).map(|of| of.resistance_k_per_w).collect();
        // Neither of two is the usual one.
        if all.len() < 3 {
            return None;
        }
        all.sort_by(f64::total_cmp);
        let usual = all[all.len() / 2];
        let ratio = layer.resistance_k_per_w / usual;
        let is_apart = !(1.0 / APART..=APART).contains(&ratio);
        is_apart.then(|| {
            format!("its layer {} has {:.3} K/W, others of its kind have {usual:.3}", k + 1, layer.resistance_k_per_w)
        })
    })
}

#[cfg(test)]
pub(crate) mod tests;

#[cfg(test)]
mod ladder_tests {
    use nalgebra::DMatrix;

    use super::*;

    /// Film, packaging, silver, and the way to the surroundings.
    const C: [f64; 3] = [1e-3, 3.8e-3, 0.35];
    const R: [f64; 3] = [10.0, 125.0, 500.0];

    /// Rates, R_k and the shares of the last node, from the eigenvectors of the chain.
    fn modes() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let g: Vec<f64> = R.iter().map(|r| 1.0 / r).collect();
        let mut a = DMatrix::zeros(3, 3);
        for i in 0..3 {
            let before = if i > 0 { g[i - 1] } else { 0.0 };
            a[(i, i)] = (before + g[i]) / C[i];
            if i > 0 {
                a[(i, i - 1)] = -g[i - 1] / (C[i] * C[i - 1]).sqrt();
                a[(i - 1, i)] = a[(i, i - 1)];
            }
        }
        let eigen = a.symmetric_eigen();
        let mut order: Vec<usize> = (0..3).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        // Temperatures are the symmetric vector over √C; the gain of a mode is v_0²/C_0 over its
        // rate.
        let v = |node: usize, k: usize| eigen.eigenvectors[(node, k)] / C[node].sqrt();
        let rates = order.iter().map(|&k| eigen.eigenvalues[k]).collect();
        let r = order.iter().map(|&k| v(0, k).powi(2) / eigen.eigenvalues[k]).collect();
        let shares = order.iter().map(|&k| v(2, k) / v(0, k)).collect();
        (rates, r, shares)
    }

    #[test]
    fn finds_the_layers_and_the_modes_shares_of_a_chain() {
        let (rates, r, shares) = modes();
        let found = sections(&rates, &r, 2).unwrap();
        for (i, section) in found.iter().enumerate() {
            assert!((section.capacitance_j_per_k / C[i] - 1.0).abs() < 1e-9, "{section:?}");
            assert!((section.resistance_k_per_w / R[i] - 1.0).abs() < 1e-9, "{section:?}");
        }
        for (rate, expected) in rates.iter().zip(&shares) {
            // The fastest mode's polynomial is 40 times what is left of it.
            assert!((share(&found, *rate) - expected).abs() < 1e-9, "{rate}");
        }
        let steady: f64 = rates.iter().zip(&r).map(|(rate, r)| r * share(&found, *rate)).sum();
        assert!((steady - R[2]).abs() < 1e-7, "{steady}");
        assert!((contact_time_s(&found) - (10.0 * 1e-3 + 125.0 * 4.8e-3)).abs() < 1e-9);
    }

    #[test]
    fn without_layers_the_element_is_the_surface() {
        assert_eq!(sections(&[1.0], &[-1.0], 0).unwrap(), []);
        assert_eq!((share(&[], 1e6), cross_share(&[], 1e6), contact_time_s(&[])), (1.0, 1.0, 0.0));
    }

    #[test]
    fn effective_rates_are_held_where_the_polynomial_has_turned() {
        let (rates, r, _) = modes();
        let found = sections(&rates, &r, 2).unwrap();
        let mut before = 1.0;
        for n in 0..400 {
            let now = cross_share(&found, 1e-3 * libm::pow(10.0, n as f64 / 50.0));
            assert!((0.0..=before).contains(&now));
            before = now;
        }
        assert_eq!(before, 0.0);
        assert_eq!(cross_share(&found, 0.1), share(&found, 0.1));
    }

    #[test]
    fn more_layers_than_rates_can_show_are_refused() {
        let sentence = sections(&[1.0, 2.0], &[1.0, 2.0], 2).unwrap_err().to_string();
        assert!(sentence.contains("take at least 3"), "{sentence}");
        assert!(sections(&[1.0, 2.0], &[1.0, -2.0], 1).unwrap_err().to_string().contains("R_2 = -2"));
    }
}

#[cfg(test)]
mod plausible_tests {
    use std::path::Path;

    use super::*;

    use super::super::parameters::ReadingNoise;

    /// Four sectors of sphere B with these K/W of what is quick, and share of the surface in what
    /// is slow.
    fn found(quick_k_per_w: [f64; 4], share: f64) -> Vec<String> {
        let head = Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-b.toml")).unwrap();
        let own = quick_k_per_w.into_iter().enumerate().map(|(element, quick)| SelfHeatingParameters {
            element,
            name: head.elements[element].name.clone(),
            rest_c: -48.0,
            noise: ReadingNoise { low_k: 2.5e-3, high_k: 5e-4 },
            mesh_rad_s: vec![0.0025, 0.0095, 400.0],
            r_k_per_w: vec![636.0, 636.0, quick],
            surface: Some(vec![share, share, -0.05]),
            layers: vec![LadderSection { capacitance_j_per_k: 5e-3, resistance_k_per_w: quick }],
        });
        absurdities(&QuiescentNetwork { own: own.collect(), cross: Vec::new() }, &head, 0.02)
    }

    #[test]
    fn what_the_sphere_is_made_of_is_nothing_to_warn_of() {
        assert_eq!(found([0.46, 0.47, 0.55, 0.46], 1.0), Vec::<String>::new());
    }

    #[test]
    fn heat_within_a_tick_that_100_ppm_would_be_is_named() {
        // 0.46 K/W are 62 ppm by themselves.
        let sentences = found([1.21; 4], 1.0);
        assert_eq!(sentences.len(), 4);
        assert!(sentences[0].starts_with("sector1: 16") && sentences[0].contains("--currents"), "{sentences:?}");
    }

    #[test]
    fn a_layer_unlike_the_others_and_a_surface_that_is_none_are_named() {
        let sentences = found([0.46, 0.15, 0.47, 0.46], 1.0);
        assert_eq!(sentences.len(), 1);
        assert!(sentences[0].starts_with("sector2: its layer 1 has 0.150 K/W"), "{sentences:?}");
        assert!(found([0.46; 4], 0.7)[3].starts_with("sector4: the surface has 0.70"));
    }

    #[test]
    fn residuals_are_held_against_the_noise() {
        assert_eq!(residuals("core1", 4e-3, 2.5e-3), None);
        assert_eq!(residuals("film2", 2.9e-3, 1.4e-3), None, "of a tube, whose layers are finer than the model's");
        assert!(residuals("core1", 7e-3, 2.5e-3).unwrap().contains("core1: its record leaves 7.0 mK"));
    }
}
