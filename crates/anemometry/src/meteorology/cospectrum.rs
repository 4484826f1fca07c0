//! Share of a turbulent flux at the frequencies that an instrument's bandwidth and the length of an
//! interval hold, by the cospectra of the neutral surface layer over flat land:
//!
//! n = f z/U; momentum: n C/u*² = 14 n/(1 + 9.6 n)^2.4
//! heat: 11 n/(1 + 13.3 n)^1.75 up to n = 1, 4.4 n/(1 + 3.8 n)^2.4 beyond
//!
//! f frequency, z height, U mean speed. Source: J. C. Kaimal et al., Spectral characteristics of
//! surface-layer turbulence, Q. J. R. Meteorol. Soc. 98 (1972) 563–589. Both integrate in closed
//! form. The cut-offs are taken for sharp ones, at the bandwidth and at one period in the interval.

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
            Self::Momentum => 14.0 / (9.6 * 1.4) * (1.0 - (1.0 + 9.6 * n).powf(-1.4)),
            Self::Heat => {
                let low = |n: f64| 11.0 / (13.3 * 0.75) * (1.0 - (1.0 + 13.3 * n).powf(-0.75));
                let high = |n: f64| 4.4 / (3.8 * 1.4) * (4.8_f64.powf(-1.4) - (1.0 + 3.8 * n).powf(-1.4));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_are_the_integrals_of_the_cospectra() {
        let density = |flux, n: f64| match flux {
            TurbulentFlux::Momentum => 14.0 / (1.0 + 9.6 * n).powf(2.4),
            TurbulentFlux::Heat if n <= 1.0 => 11.0 / (1.0 + 13.3 * n).powf(1.75),
            TurbulentFlux::Heat => 4.4 / (1.0 + 3.8 * n).powf(2.4),
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
