//! The inverse against a truth in f64 that it does not share a line with.

extern crate std;

mod amplitudes;
pub(crate) mod cards;
mod following;
mod forms;
mod noise;
mod partial;
mod round_trip;
mod surfaces;
pub(super) mod table;

use super::form::HeadForm;
use super::sphere::{hemispheres, tetrahedral_sectors};
use super::surface_inverse::{MeasuredConductance, WindVector};
use crate::error::Parameter;
use table::{DIAMETER_M, published};

/// 30°, under which a direction is one.
const DIRECTION_BOUND_RAD: f32 = 0.5;

pub(super) fn sphere_b() -> WindVector {
    let d = DIAMETER_M as f32;
    WindVector::new(HeadForm::Sphere, &published(), &tetrahedral_sectors(d), d, DIRECTION_BOUND_RAD).unwrap()
}

fn sphere_a() -> WindVector {
    let d = DIAMETER_M as f32;
    WindVector::new(HeadForm::Sphere, &published(), &hemispheres(d), d, DIRECTION_BOUND_RAD).unwrap()
}

/// Conductances with a standard error of this share of each.
fn measured<const N: usize>(conductances: [f64; N], share: f64) -> [Option<MeasuredConductance>; N] {
    conductances.map(|g| {
        Some(MeasuredConductance { conductance_w_k: g as f32, variance_w2_k2: ((g * share) * (g * share)) as f32 })
    })
}

#[test]
fn refuses_a_head_by_the_name_of_what_is_wrong() {
    let (amplitudes, surfaces) = (published(), tetrahedral_sectors(0.01));
    let refused = |diameter, bound| {
        WindVector::new(HeadForm::Sphere, &amplitudes, &surfaces, diameter, bound).unwrap_err().parameter
    };
    assert_eq!(refused(0.0, 0.5), Parameter::DiameterM);
    assert_eq!(refused(f32::NAN, 0.5), Parameter::DiameterM);
    assert_eq!(refused(0.01, 0.0), Parameter::DirectionErrorMaxRad);
    assert_eq!(refused(0.01, 2.0), Parameter::DirectionErrorMaxRad);
    let mut bad = surfaces;
    bad[3].area_m2 = 0.0;
    assert_eq!(
        WindVector::new(HeadForm::Sphere, &amplitudes, &bad, 0.01, 0.5).unwrap_err().parameter,
        Parameter::AreaM2
    );
}
