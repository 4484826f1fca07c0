//! Turbulent fluxes by eddy covariance.
//!
//! The frame is turned into the mean wind, so that v̄ = w̄ = 0 (double rotation: about the vertical
//! by η, then by ζ):
//!
//! η = atan2(v̄, ū), ζ = atan2(w̄, (ū² + v̄²)^½)
//! u* = (−u'w')^½, L = −u*³ T̄/(κ g w'T'), κ = 0.40
//!
//! u* friction velocity, w'T' kinematic heat flux, L Obukhov length, T̄ in kelvins, g gravity.
//! Sources: J. C. Kaimal, J. J. Finnigan, Atmospheric Boundary Layer Flows, Oxford 1994, ch. 6;
//! A. M. Obukhov, Trudy Inst. Teor. Geofiz. AN SSSR 1 (1946) 95–115. Deviations are those from the
//! mean of the interval. L is that of dry gas.
//!
//! Share of a turbulent flux at the frequencies that an instrument's bandwidth and the length of an
//! interval hold, by the cospectra of the neutral surface layer over flat land:
//!
//! n = f z/U; momentum: n C/u*² = 14 n/(1 + 9.6 n)^2.4
//! heat: 11 n/(1 + 13.3 n)^1.75 up to n = 1, 4.4 n/(1 + 3.8 n)^2.4 beyond
//!
//! f frequency, z height, U mean speed. Source: J. C. Kaimal et al., Spectral characteristics of
//! surface-layer turbulence, Q. J. R. Meteorol. Soc. 98 (1972) 563–589. Both integrate in closed
//! form. The cut-offs are taken for sharp ones, at the bandwidth and at one period in the interval.
//!
//! Standard uncertainty of a covariance by the length of the record, from the record itself:
//!
//! u² = (1/n) Σ_p (γ_xx(p) γ_yy(p) + γ_xy(p) γ_yx(p)), p from −m to m
//!
//! with γ the auto- and cross-covariances at a lag of p samples. Source: P. L. Finkelstein, P. F.
//! Sims, Sampling error in eddy correlation flux measurements, J. Geophys. Res. 106 (2001)
//! 3503–3509. Lags go up to a tenth of the record; eddies longer than that are not in it.

use serde::Serialize;

const KARMAN: f64 = 0.40;
const KELVIN: f64 = 273.15;
/// A flux of fewer standard uncertainties has no root and no inverse.
const SIGNIFICANT: f64 = 2.0;
/// Least share of a flux that must be resolved.
pub const LEAST_RESOLVED: f64 = 0.9;

/// Options that fluxes need besides the wind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EddyOptions {
    /// Height above the ground, m.
    pub height_m: f64,
    /// Bandwidth of the wind, Hz.
    pub bandwidth_hz: f64,
    /// Bandwidth of the gas temperature, Hz, where one is known.
    pub temperature_bandwidth_hz: Option<f64>,
    /// m/s².
    pub gravity_m_s2: f64,
}

/// A number with its standard uncertainty by the length of the record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sampled {
    /// The number.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
}

/// The fluxes of an interval. What is missing has its reason in `left_out`.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct EddyFluxes {
    /// u'w', m²/s².
    pub uw_m2_s2: Option<Sampled>,
    /// u*, m/s.
    pub friction_velocity_m_s: Option<Sampled>,
    /// w'T', K m/s; upward is positive.
    pub heat_flux_k_m_s: Option<Sampled>,
    /// L, m; positive where the layer is stable.
    pub obukhov_length_m: Option<Sampled>,
    /// Why something is missing.
    pub left_out: Vec<String>,
}

/// Fluxes of winds (east, north, up), m/s, and the gas temperatures beside them, °C.
pub fn fluxes(wind_m_s: &[[f64; 3]], gas_c: &[f64], interval_s: f64, options: &EddyOptions) -> EddyFluxes {
    let mut fluxes = EddyFluxes::default();
    let count = wind_m_s.len() as f64;
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| wind_m_s.iter().map(of).sum::<f64>() / count;
    let [u, v, w] = [mean(&|of| of[0]), mean(&|of| of[1]), mean(&|of| of[2])];
    let horizontal = libm::hypot(u, v);
    let turned: Vec<[f64; 3]> =
        wind_m_s.iter().map(|of| turn(*of, libm::atan2(v, u), libm::atan2(w, horizontal))).collect();
    let speed_m_s = libm::hypot(horizontal, w);
    let along: Vec<f64> = turned.iter().map(|of| of[0] - speed_m_s).collect();
    let across: Vec<f64> = turned.iter().map(|of| of[2]).collect();
    if across.iter().all(|w| w.abs() < 1e-9) {
        fluxes.left_out.push("fluxes: the head does not measure the vertical wind".to_owned());
        return fluxes;
    }
    let resolves = |flux: TurbulentFlux, bandwidth_hz: f64, name: &str| {
        let share = flux.resolved(options.height_m, horizontal, bandwidth_hz, interval_s);
        let is_enough = share >= LEAST_RESOLVED;
        let ([percent, needed], height_m) = ([share, LEAST_RESOLVED].map(|share| 100.0 * share), options.height_m);
        let band = format!("{percent:.0} % of it lie between 1/{interval_s} Hz and {bandwidth_hz} Hz");
        let sentence = format!("{name}: at {height_m} m and {horizontal:.1} m/s {band}, {needed:.0} % are needed");
        (!is_enough).then_some(sentence)
    };
    if let Some(sentence) = resolves(TurbulentFlux::Momentum, options.bandwidth_hz, "momentum flux") {
        fluxes.left_out.push(sentence);
    } else {
        let flux = covariance(&along, &across);
        fluxes.uw_m2_s2 = Some(flux);
        match -flux.value > SIGNIFICANT * flux.u {
            true => {
                let value = (-flux.value).sqrt();
                fluxes.friction_velocity_m_s = Some(Sampled { value, u: flux.u / (2.0 * value) });
            }
            false => {
                fluxes.left_out.push("friction velocity: −u'w' is below twice its standard uncertainty".to_owned())
            }
        }
    }
    let Some(bandwidth_hz) = options.temperature_bandwidth_hz else {
        fluxes.left_out.push("heat flux: the bandwidth of the gas temperature is not known".to_owned());
        return fluxes;
    };
    if gas_c.len() != wind_m_s.len() || gas_c.iter().any(|of| !of.is_finite()) {
        fluxes.left_out.push("heat flux: no gas temperature".to_owned());
        return fluxes;
    }
    if let Some(sentence) = resolves(TurbulentFlux::Heat, bandwidth_hz.min(options.bandwidth_hz), "heat flux") {
        fluxes.left_out.push(sentence);
        return fluxes;
    }
    let mean_c = gas_c.iter().sum::<f64>() / count;
    let heat = covariance(&across, &gas_c.iter().map(|of| of - mean_c).collect::<Vec<_>>());
    fluxes.heat_flux_k_m_s = Some(heat);
    if heat.value.abs() < SIGNIFICANT * heat.u {
        fluxes.left_out.push("Obukhov length: w'T' is below twice its standard uncertainty".to_owned());
        return fluxes;
    }
    fluxes.obukhov_length_m = fluxes.friction_velocity_m_s.map(|of| {
        let value = -of.value.powi(3) * (mean_c + KELVIN) / (KARMAN * options.gravity_m_s2 * heat.value);
        Sampled { value, u: value.abs() * libm::hypot(3.0 * of.u / of.value, heat.u / heat.value) }
    });
    fluxes
}

/// A vector in the frame of the mean wind.
fn turn([x, y, z]: [f64; 3], eta: f64, zeta: f64) -> [f64; 3] {
    let ((sin, cos), (rise, level)) = (libm::sincos(eta), libm::sincos(zeta));
    let ahead = x * cos + y * sin;
    [ahead * level + z * rise, y * cos - x * sin, z * level - ahead * rise]
}

fn covariance(x: &[f64], y: &[f64]) -> Sampled {
    let value = x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / x.len() as f64;
    Sampled { value, u: covariance_u(x, y) }
}

/// A flux.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TurbulentFlux {
    /// −u'w'.
    Momentum,
    /// w'T'.
    Heat,
}

impl TurbulentFlux {
    /// ∫ C/flux dn from 0 to n, not normalised.
    fn integral(self, n: f64) -> f64 {
        match self {
            Self::Momentum => 14.0 / (9.6 * 1.4) * (1.0 - libm::pow(1.0 + 9.6 * n, -1.4)),
            Self::Heat => {
                let low = |n: f64| 11.0 / (13.3 * 0.75) * (1.0 - libm::pow(1.0 + 13.3 * n, -0.75));
                let high = |n: f64| 4.4 / (3.8 * 1.4) * (libm::pow(4.8, -1.4) - libm::pow(1.0 + 3.8 * n, -1.4));
                if n <= 1.0 { low(n) } else { low(1.0) + high(n) }
            }
        }
    }

    /// Share of the flux that is resolved at a height in a mean speed.
    pub fn resolved(self, height_m: f64, speed_m_s: f64, bandwidth_hz: f64, interval_s: f64) -> f64 {
        let n = |frequency_hz: f64| frequency_hz * height_m / speed_m_s;
        let (low, high) = (self.integral(n(1.0 / interval_s)), self.integral(n(bandwidth_hz)));
        (high - low) / self.integral(f64::INFINITY)
    }
}

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
mod tests {
    use super::sampling_tests::correlated;
    use super::*;

    const OPTIONS: EddyOptions =
        EddyOptions { height_m: 10.0, bandwidth_hz: 2.0, temperature_bandwidth_hz: Some(5.0), gravity_m_s2: 9.81 };

    /// A wind from the south-west, on a slope of 3°, with u'w' = −0.09 m²/s² and w'T' = 0.05 K m/s.
    fn series(seed: u64) -> (Vec<[f64; 3]>, Vec<f64>) {
        let (u, w) = correlated(seed, 36_000, -0.3, 20.0);
        let (other, _) = correlated(seed + 1000, 36_000, 0.0, 20.0);
        let (azimuth, slope) = (50.0_f64.to_radians(), 3.0_f64.to_radians());
        let wind = u.iter().zip(&w).map(|(u, w)| {
            let (ahead, up) = (6.0 + 0.75 * u, 0.4 * w);
            let (level, rise) =
                (ahead * libm::cos(slope) - up * libm::sin(slope), ahead * libm::sin(slope) + up * libm::cos(slope));
            [level * libm::cos(azimuth), level * libm::sin(azimuth), rise]
        });
        // 0.4 m/s · 0.5 K · 0.25.
        let gas = w.iter().zip(&other).map(|(w, other)| 20.0 + 0.5 * (0.25 * w + 0.968 * other));
        (wind.collect(), gas.collect())
    }

    #[test]
    fn fluxes_of_a_known_series_are_found_within_their_uncertainty() {
        let mut within = 0;
        for seed in 0..40 {
            let (wind, gas) = series(seed);
            let found = fluxes(&wind, &gas, 1800.0, &OPTIONS);
            assert!(found.left_out.is_empty(), "{found:?}");
            let [uw, heat] = [found.uw_m2_s2.unwrap(), found.heat_flux_k_m_s.unwrap()];
            within +=
                i32::from((uw.value + 0.09).abs() < 2.0 * uw.u) + i32::from((heat.value - 0.05).abs() < 2.0 * heat.u);
            let friction = found.friction_velocity_m_s.unwrap();
            assert!((friction.value - 0.3).abs() < 5.0 * friction.u && friction.u < 0.015, "{friction:?}");
        }
        // 95 % of 80 within two standard uncertainties, less three standard deviations of it.
        assert!(within >= 70, "{within} of 80");
    }

    #[test]
    fn the_obukhov_length_is_that_of_its_definition() {
        let (wind, gas) = series(3);
        let found = fluxes(&wind, &gas, 1800.0, &OPTIONS);
        let (friction, heat) = (found.friction_velocity_m_s.unwrap().value, found.heat_flux_k_m_s.unwrap().value);
        let length = found.obukhov_length_m.unwrap();
        let mean_k = 273.15 + gas.iter().sum::<f64>() / gas.len() as f64;
        assert!((length.value / (-friction.powi(3) * mean_k / (0.4 * 9.81 * heat)) - 1.0).abs() < 1e-12);
        // Upward heat: unstable. −0.3³·293/(0.4·9.81·0.05) is −40 m.
        assert!(length.value < -20.0 && length.value > -80.0, "{length:?}");
    }

    #[test]
    fn what_is_not_resolved_is_left_out_with_its_reason() {
        let (wind, gas) = series(5);
        let at = |height_m, temperature_bandwidth_hz| {
            fluxes(&wind, &gas, 1800.0, &EddyOptions { height_m, temperature_bandwidth_hz, ..OPTIONS })
        };
        let low = at(0.5, Some(5.0));
        assert_eq!((low.uw_m2_s2, low.friction_velocity_m_s, low.obukhov_length_m), (None, None, None));
        assert!(low.left_out[0].starts_with("momentum flux: at 0.5 m and 6.0 m/s 7"), "{:?}", low.left_out);
        let slow = at(10.0, Some(0.05));
        assert!(slow.uw_m2_s2.is_some() && slow.heat_flux_k_m_s.is_none());
        assert!(slow.left_out[0].starts_with("heat flux: at 10 m"), "{:?}", slow.left_out);
        assert!(at(10.0, None).left_out[0].contains("bandwidth of the gas temperature"));
        // Turbulence that carries nothing.
        let (u, w) = correlated(9, 36_000, 0.0, 20.0);
        let idle: Vec<[f64; 3]> = u.iter().zip(&w).map(|(u, w)| [6.0 + 0.75 * u, 0.0, 0.4 * w]).collect();
        let none = fluxes(&idle, &gas, 1800.0, &OPTIONS);
        assert!(none.uw_m2_s2.is_some() && none.friction_velocity_m_s.is_none(), "{none:?}");
        assert!(none.left_out[0].starts_with("friction velocity: −u'w' is below"), "{none:?}");
        let plane: Vec<[f64; 3]> = wind.iter().map(|[x, y, _]| [*x, *y, 0.0]).collect();
        assert!(fluxes(&plane, &gas, 1800.0, &OPTIONS).left_out[0].contains("vertical wind"));
    }
}

#[cfg(test)]
mod cospectrum_tests {
    use super::*;

    #[test]
    fn closed_forms_are_the_integrals_of_the_cospectra() {
        let density = |flux, n: f64| match flux {
            TurbulentFlux::Momentum => 14.0 / libm::pow(1.0 + 9.6 * n, 2.4),
            TurbulentFlux::Heat if n <= 1.0 => 11.0 / libm::pow(1.0 + 13.3 * n, 1.75),
            TurbulentFlux::Heat => 4.4 / libm::pow(1.0 + 3.8 * n, 2.4),
        };
        for flux in [TurbulentFlux::Momentum, TurbulentFlux::Heat] {
            for to in [0.3, 1.0, 2.5] {
                let step = to / 1e5;
                let sum: f64 = (0..100_000).map(|k| density(flux, (f64::from(k) + 0.5) * step) * step).sum();
                assert!((flux.integral(to) - sum).abs() < 1e-6, "{flux:?} to {to}");
            }
        }
    }

    #[test]
    fn low_heights_and_slow_instruments_lose_flux() {
        let share = |height_m, bandwidth_hz| TurbulentFlux::Momentum.resolved(height_m, 5.0, bandwidth_hz, 600.0);
        // By hand: (1 + 9.6·0.00333)^−1.4 − (1 + 9.6·4)^−1.4, and with n = 0.6 and 0.0005.
        assert!((share(10.0, 2.0) - (0.956_86 - 0.005_857)).abs() < 1e-4, "{}", share(10.0, 2.0));
        assert!((share(1.5, 2.0) - (0.993_32 - 0.068_90)).abs() < 2e-4, "{}", share(1.5, 2.0));
        assert!((share(1.5, 0.5) - (0.993_32 - 0.286_9)).abs() < 2e-4, "{}", share(1.5, 0.5));
    }
}

#[cfg(test)]
pub(super) mod sampling_tests {
    use super::*;
    use diffusive::random::StandardNormal;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::Distribution;

    /// Two series with unit variances, this correlation, and a memory of `memory` samples (AR 1).
    pub fn correlated(seed: u64, count: usize, correlation: f64, memory: f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let keep = libm::exp(-1.0 / memory);
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
