//! What an identified network shows if the ratio of an element's two currents is off: its heat is
//! not what it seems, since readings jump with the level.
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

use dr_core::sensor::Level;

use super::parameters::{QuiescentNetwork, SelfHeatingParameters};
use crate::head::element::HeadElement;
use crate::head::file::Head;

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

/// What to do, behind what was found.
const ADVICE: &str = "the ratio of its currents may be off: `anemo self-test EXPERIMENT --currents` measures it";

/// The sentence on residuals in an element's own record, K rms, if they are suspicious.
pub(super) fn residuals(element: &str, residual_k: f64, noise_k: f64) -> Option<String> {
    (residual_k > LEAST_RESIDUAL_K.max(RESIDUALS * noise_k)).then(|| {
        format!(
            "{element}: its record leaves {:.1} mK, and its readings have {:.1} mK of noise: {ADVICE}",
            1e3 * residual_k,
            1e3 * noise_k
        )
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

/// Of a layer whose resistance is not that of the others of its kind.
fn unlike_its_kind(own: &SelfHeatingParameters, network: &QuiescentNetwork, head: &Head) -> Option<String> {
    let kind = |of: &SelfHeatingParameters| head.elements[of.element].kind.as_deref();
    let alike: Vec<_> = network.own.iter().filter(|of| kind(of).is_some() && kind(of) == kind(own)).collect();
    own.layers.iter().enumerate().find_map(|(k, layer)| {
        let mut all: Vec<f64> =
            alike.iter().filter_map(|of| of.layers.get(k)).map(|of| of.resistance_k_per_w).collect();
        // Of two, neither is the usual one.
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
mod tests {
    use std::path::Path;

    use super::*;
    use crate::network::ladder::LadderSection;
    use crate::network::parameters::ReadingNoise;

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
