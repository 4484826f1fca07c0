//! The continuous diffusive symbol from the discrete one (thesis 2.18).
//!
//! ```text
//! η(ξ_k) = η_k / λ_k,    λ_k = ln(r) ξ_k,    so η(ξ_k) = R_k / ln r    in K/W
//! ```
//!
//! It does not depend on how finely the mesh is cut, so that models of different order can be laid
//! over one another. r is the ratio of neighbouring rates; where a mesh is not geometric, ln r is
//! the local spacing: half the distance between the two neighbours on the logarithmic axis, and at
//! an edge the distance to the only one. Σ_k η(ξ_k) ln r is the steady gain again.

use crate::model::ModelError;

/// η(ξ_k) in K/W at every rate of an ascending mesh.
///
/// # Errors
/// If there is one rate only.
pub fn continuous_symbol(mesh_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<Vec<f64>, ModelError> {
    let spacing = log_spacing(mesh_rad_s)?;
    Ok(r_k_per_w.iter().zip(spacing).map(|(resistance, spacing)| resistance / spacing).collect())
}

/// ln r at every rate.
///
/// # Errors
/// If there is one rate only.
pub fn log_spacing(mesh_rad_s: &[f64]) -> Result<Vec<f64>, ModelError> {
    let last = mesh_rad_s.len().checked_sub(1).filter(|&last| last > 0).ok_or_else(|| {
        model_error!("a single rate has no distance to a neighbour, by which the continuous symbol is weighted: it needs an order of 2 at least")
    })?;
    let spacing = |k: usize| {
        let (below, above) = (k.saturating_sub(1), (k + 1).min(last));
        libm::log(mesh_rad_s[above] / mesh_rad_s[below]) / (above - below) as f64
    };
    Ok((0..=last).map(spacing).collect())
}

#[cfg(test)]
mod tests {
    use dr_core::model::mesh;

    use super::*;

    #[test]
    fn does_not_depend_on_how_finely_the_mesh_is_cut() {
        // Cole–Cole with α = ½, τ = 1: η(ξ) = √ξ / (π (1 + ξ)), discrete R_k = η(ξ_k) ln r
        let density = |rate: f64| rate.sqrt() / (std::f64::consts::PI * (1.0 + rate));
        for order in [7, 25] {
            let rates: Vec<f64> = (0..order).map(|k| mesh::rate_rad_s(1e-3, 1e3, k, order)).collect();
            let ratio = libm::pow(1e6, 1.0 / (order - 1) as f64);
            let r: Vec<f64> = rates.iter().map(|&rate| density(rate) * libm::log(ratio)).collect();
            for (value, &rate) in continuous_symbol(&rates, &r).unwrap().iter().zip(&rates) {
                // a few roundings
                assert!((value / density(rate) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn an_uneven_mesh_is_weighted_by_its_local_spacing() {
        let e = std::f64::consts::E;
        // distances of 1, 1, 3 on the logarithmic axis
        let spacing = log_spacing(&[1.0, e, e * e, e.powi(5)]).unwrap();
        for (spacing, expected) in spacing.iter().zip([1.0, 1.0, 2.0, 3.0]) {
            assert!((spacing - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn a_single_rate_has_no_continuous_symbol() {
        assert!(continuous_symbol(&[1.0], &[2.0]).unwrap_err().to_string().contains("a single rate"));
    }
}
