//! The gas of the simulated tunnel as the polynomials that the board carries, [`GasLawConfig`].
//!
//! ```text
//! f(T) = Σ a_n sⁿ,   s = (2 T − T_least − T_most)/(T_most − T_least)
//! through the values at s_j = cos((2j + 1)π/14), j = 0 … 6
//! ```
//!
//! Interpolation at Chebyshev's nodes is within a small factor of the best polynomial (L. N.
//! Trefethen, *Approximation Theory and Approximation Practice*, ch. 15), and the formulae of
//! [`gas`](crate::gas) stand in one place. Measured over ±60 K: within 1e-5 of the properties, but
//! for CO2's conductivity where the range holds 200 K, at which its law has a bend: 6e-4 there
//! (test).

use dr_core::wind::GasLawConfig;
use dr_core::wind::gas_law::TERMS;
use nalgebra::{SMatrix, SVector};

use super::gas::{GasError, IdealGas, Species, ZERO_CELSIUS_K};

/// Any will do: viscosity and conductivity do not depend on it, nor does p/(ρT).
const PRESSURE_PA: f64 = 1000.0;

/// The law of a gas between two temperatures, °C.
///
/// # Errors
/// If they leave the 150 to 400 K in which the gas is known, or do not ascend.
pub fn gas_law(species: Species, least_c: f64, most_c: f64) -> Result<GasLawConfig, GasError> {
    if least_c.partial_cmp(&most_c) != Some(std::cmp::Ordering::Less) {
        let expected = "more than the least temperature";
        return Err(GasError { name: "gas.temperature_c", value: most_c, expected });
    }
    let node = |j: usize| libm::cos((2 * j + 1) as f64 * std::f64::consts::PI / (2 * TERMS) as f64);
    let at = |s: f64| 0.5 * (least_c + most_c + s * (most_c - least_c)) + ZERO_CELSIUS_K;
    // The ends lie beyond the outermost nodes, and have to be good as well.
    for s in [-1.0, 1.0] {
        IdealGas::new(species, PRESSURE_PA, at(s))?;
    }
    let mut powers = SMatrix::<f64, TERMS, TERMS>::zeros();
    let (mut viscosity, mut conductivity) = (SVector::<f64, TERMS>::zeros(), SVector::<f64, TERMS>::zeros());
    let mut gas_constant_j_kg_k = 0.0;
    for j in 0..TERMS {
        let gas = IdealGas::new(species, PRESSURE_PA, at(node(j)))?;
        for n in 0..TERMS {
            powers[(j, n)] = node(j).powi(n as i32);
        }
        (viscosity[j], conductivity[j]) = (gas.viscosity_pa_s, gas.conductivity_w_m_k);
        gas_constant_j_kg_k = gas.pressure_pa / (gas.density_kg_m3 * gas.temperature_k);
    }
    // Nodes are distinct, so that the matrix is regular.
    let factors = powers.lu();
    let solved = |values: SVector<f64, TERMS>| {
        let a = factors.solve(&values).unwrap_or_else(SVector::zeros);
        std::array::from_fn(|n| a[n] as f32)
    };
    Ok(GasLawConfig {
        gas_constant_j_kg_k: gas_constant_j_kg_k as f32,
        least_c: least_c as f32,
        most_c: most_c as f32,
        viscosity_pa_s: solved(viscosity),
        conductivity_w_m_k: solved(conductivity),
    })
}

#[cfg(test)]
mod tests {
    use dr_core::wind::GasLaw;

    use super::*;

    #[test]
    fn the_board_knows_the_gas_of_the_tunnel_to_a_hundred_thousandth_but_for_a_bend() {
        for species in [Species::CarbonDioxide, Species::Air] {
            for reference_c in [-60.0, -53.15, -20.0, 20.0, 60.0] {
                let law = GasLaw::new(&gas_law(species, reference_c - 60.0, reference_c + 60.0).unwrap()).unwrap();
                let mut worst = [0.0_f64; 2];
                for n in 0..=480 {
                    let temperature_c = (reference_c - 60.0 + 0.25 * f64::from(n)) as f32;
                    let truth = IdealGas::new(species, 700.0, f64::from(temperature_c) + ZERO_CELSIUS_K).unwrap();
                    let found = law.at(700.0, temperature_c).unwrap();
                    let kinematic = f64::from(found.reynolds_per_speed(0.01)) / truth.reynolds(1.0, 0.01);
                    let conductivity =
                        f64::from(found.conductance_per_nusselt_w_k(1.0, 1.0)) / truth.conductivity_w_m_k;
                    worst = [worst[0].max((kinematic - 1.0).abs()), worst[1].max((conductivity - 1.0).abs())];
                }
                println!(
                    "{} around {reference_c} °C: ρ/µ within {:.1e}, k within {:.1e}",
                    species.name(),
                    worst[0],
                    worst[1]
                );
                let has_bend = species == Species::CarbonDioxide && reference_c - 60.0 < 200.0 - ZERO_CELSIUS_K;
                let bar = if has_bend { 6e-4 } else { 1e-5 };
                assert!(worst[0] < 1e-5 && worst[1] < bar, "{species:?} {reference_c}: {worst:?}");
            }
        }
    }

    #[test]
    fn temperatures_at_which_the_gas_is_not_known_are_refused() {
        assert!(gas_law(Species::Air, -130.0, 0.0).is_err());
        assert!(gas_law(Species::Air, 0.0, 130.0).is_err());
        assert!(gas_law(Species::Air, 10.0, 10.0).is_err());
    }
}
