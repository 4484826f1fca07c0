//! The inverse against a truth in f64 that it does not share a line with.

extern crate std;

mod amplitudes;
pub(crate) mod cards;
mod noise;
mod partial;
mod round_trip;
mod surfaces;
pub(super) mod table;

use super::sphere::{SECTORS, hemispheres, tetrahedral_sectors};
use super::{Measured, WindVector};
use table::{DIAMETER_M, published};

/// 30°, under which a direction is one.
const DIRECTION_BOUND_RAD: f32 = 0.5;

fn sphere_b() -> WindVector<SECTORS> {
    let d = DIAMETER_M as f32;
    WindVector::new(&published(), &tetrahedral_sectors(d), d, DIRECTION_BOUND_RAD).unwrap()
}

fn sphere_a() -> WindVector<2> {
    let d = DIAMETER_M as f32;
    WindVector::new(&published(), &hemispheres(d), d, DIRECTION_BOUND_RAD).unwrap()
}

/// Conductances with a standard error of this share of each.
fn measured<const N: usize>(conductances: [f64; N], share: f64) -> [Option<Measured>; N] {
    conductances
        .map(|g| Some(Measured { conductance_w_k: g as f32, variance_w2_k2: ((g * share) * (g * share)) as f32 }))
}
