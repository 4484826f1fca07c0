//! What lies between an element and its surface: the first sections of the ladder of its
//! self-heating, and the share that they let through.
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

use super::error::NetworkError;
use diffusive::model::export::cauer::cauer;

pub use diffusive::model::export::cauer::LadderSection;

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
/// As long as no node before the surface has turned its sign (by Sturm's theorem: below all rates
/// of the layers by themselves) the polynomial is a share between 0 and 1. Beyond, it would grow
/// without bounds, whereas of heat at the surface such a fast relaxation, in which the element's
/// own layers would have to take part, passes next to nothing on: it is held at 0.
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

#[cfg(test)]
mod tests {
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
            let now = cross_share(&found, 1e-3 * 10f64.powf(n as f64 / 50.0));
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
