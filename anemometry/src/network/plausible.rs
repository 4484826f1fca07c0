//! What an identified network shows if the ratio of an element's two currents is off: its heat is
//! not what it seems, since readings jump with the level.
//!
//! | shown | by |
//! |---|---|
//! | residuals of an element in its own record | more than twice the noise of its readings at the low level, which is the greater one |
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
    (residual_k > RESIDUALS * noise_k).then(|| {
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
