//! Standard uncertainty of a covariance by the length of the record, from the record itself:
//!
//! u² = (1/n) Σ_p (γ_xx(p) γ_yy(p) + γ_xy(p) γ_yx(p)), p from −m to m
//!
//! with γ the auto- and cross-covariances at a lag of p samples. Source: P. L. Finkelstein, P. F.
//! Sims, Sampling error in eddy correlation flux measurements, J. Geophys. Res. 106 (2001)
//! 3503–3509. Lags go up to a tenth of the record; eddies longer than that are not in it.

/// The samples that a covariance is made of are averaged to so many at most: longer eddies make
/// the uncertainty.
const MOST: usize = 2_000;
/// The greatest lag, as share of the record.
const LAGS: f64 = 0.1;

/// Standard uncertainty of the mean product of two series of deviations, which are as long as each
/// other; 0 of less than two.
pub fn covariance_u(x: &[f64], y: &[f64]) -> f64 {
    let block = x.len().div_ceil(MOST).max(1);
    let blocks = |of: &[f64]| -> Vec<f64> {
        of.chunks_exact(block).map(|chunk| chunk.iter().sum::<f64>() / block as f64).collect()
    };
    let (x, y) = (blocks(x), blocks(y));
    let count = x.len();
    if count < 2 {
        return 0.0;
    }
    let at_lag = |a: &[f64], b: &[f64], lag: usize| {
        a[..count - lag].iter().zip(&b[lag..]).map(|(a, b)| a * b).sum::<f64>() / count as f64
    };
    let lags = (LAGS * count as f64) as usize;
    let terms = (0..=lags).map(|lag| {
        let term = at_lag(&x, &x, lag) * at_lag(&y, &y, lag) + at_lag(&x, &y, lag) * at_lag(&y, &x, lag);
        // A lag and its negative give the same.
        if lag == 0 { term } else { 2.0 * term }
    });
    (terms.sum::<f64>().max(0.0) / count as f64).sqrt()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Two series with unit variances, this correlation, and a memory of `memory` samples (AR 1).
    pub fn correlated(seed: u64, count: usize, correlation: f64, memory: f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let keep = (-1.0 / memory).exp();
        let (mut a, mut b) = (normal(), normal());
        let renew = (1.0 - keep * keep).sqrt();
        let pair = |_| {
            (a, b) = (keep * a + renew * normal(), keep * b + renew * normal());
            (a, correlation * a + (1.0 - correlation * correlation).sqrt() * b)
        };
        (0..count).map(pair).unzip()
    }

    #[test]
    fn is_the_scatter_of_the_covariances_of_many_records() {
        let (count, correlation) = (6_000, -0.3);
        let (mut found, mut stated) = (Vec::new(), 0.0);
        for seed in 0..150 {
            let (x, y) = correlated(seed, count, correlation, 30.0);
            found.push(x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>() / count as f64);
            stated += covariance_u(&x, &y) / 150.0;
        }
        let scatter = (found.iter().map(|of| (of - correlation).powi(2)).sum::<f64>() / 150.0).sqrt();
        // Theory: (1 + ρ²) 2·15/6000 for e^(−2p/30) summed over both signs, ± 6 % by 150 records.
        let theory = ((1.0 + correlation * correlation) * 30.0 / count as f64).sqrt();
        assert!((scatter / theory - 1.0).abs() < 0.15, "{scatter} is not {theory}");
        assert!((stated / theory - 1.0).abs() < 0.1, "{stated} is not {theory}");
    }
}
