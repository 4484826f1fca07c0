//! The anemometer, held against heads of which everything is known.
//!
//! | file | what |
//! |---|---|
//! | `balance` | a head that stands in balance: every answer in closed form |
//! | `bodies` | a head that lives: the controller holds it in a wind, and the wind is found |
//! | `heads` | hemispheres, dice of a card, and heads that are not whole |
//! | `settings` | what a digest sees |

extern crate std;

use super::command::WindOutputConfig;
use super::*;
use crate::model::{GainsConfig, NetworkSelfHeatingConfig, mesh};
use crate::wind::{GasLaw, GasLawConfig, HeadForm, NusseltConfig, WindVector, sphere};

mod balance;
mod bit_flips;
mod bodies;
mod heads;
mod settings;

const SECTORS: usize = 4;
const DIAMETER_M: f32 = 0.01;

fn nusselt() -> NusseltConfig {
    let amplitudes = core::array::from_fn(|j| {
        let root = 1.089_f32.powi(j as i32 + 1);
        [2.0 + 0.53 * root, 0.55 * root, 0.01 * root, -0.02 * root, 0.01 * root, 0.0]
    });
    NusseltConfig { least_reynolds: 1.0, most_reynolds: 200.0, amplitudes }
}

fn law() -> GasLawConfig {
    let constant = |value| [value, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    GasLawConfig {
        gas_constant_j_kg_k: 188.9,
        least_c: -120.0,
        most_c: 100.0,
        viscosity_pa_s: constant(11.05e-6),
        conductivity_w_m_k: constant(10.84e-3),
    }
}

fn vector() -> WindVector {
    WindVector::new(HeadForm::Sphere, &nusselt(), &sphere::tetrahedral_sectors(DIAMETER_M), DIAMETER_M, 0.5).unwrap()
}

fn off(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}
