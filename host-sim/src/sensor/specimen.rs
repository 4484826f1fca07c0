//! One specimen of a body whose file states tolerances: every number of it off by a drawn error.

use anemometry::head::body::{Body, BodyLink};
use anemometry::vector::{cross, unit};
use diffusive::random::StandardNormal;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::Distribution;

/// Stream of the seed's generator; those before it are wind, resistors and noise.
const STREAM: u64 = 3;

/// The bodies of the specimen of a seed; none where no file states tolerances.
pub fn drawn(bodies: &[Body], seed: u64) -> Option<Vec<Body>> {
    bodies.iter().any(|body| body.tolerances.is_some()).then(|| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(STREAM);
        let mut bodies = bodies.to_vec();
        bodies.iter_mut().for_each(|body| differ(body, &mut rng));
        bodies
    })
}

fn differ(body: &mut Body, rng: &mut ChaCha8Rng) {
    let Some(tolerances) = body.tolerances else { return };
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    // A factor above zero, however unlikely the draw.
    let factor = |percent: f64, normal: &mut dyn FnMut() -> f64| libm::exp(0.01 * percent * normal());
    for node in &mut body.nodes {
        node.capacity_j_k *= factor(tolerances.capacity_percent, &mut normal);
    }
    for link in &mut body.links {
        let error = factor(tolerances.conductance_percent, &mut normal);
        match link {
            BodyLink::Solid { conductance_w_k, .. } | BodyLink::Rod { conductance_w_k, .. } => {
                *conductance_w_k *= error
            }
            BodyLink::Gap { area_over_width_m, .. } => *area_over_width_m *= error,
        }
    }
    for surface in body.convection.iter_mut().flat_map(|group| &mut group.surfaces) {
        surface.area_factor *= factor(tolerances.area_percent, &mut normal);
        let turn = [normal(), normal()].map(|error| (tolerances.normal_deg * error).to_radians());
        if let Some(axis) = surface.normal.filter(|_| tolerances.normal_deg > 0.0) {
            let seed = if axis[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
            let one = unit(cross(axis, seed));
            let other = cross(axis, one);
            surface.normal = Some(unit(std::array::from_fn(|k| axis[k] + turn[0] * one[k] + turn[1] * other[k])));
        }
    }
}
