//! Slow errors of four surfaces, and the one number by which four conductances contradict a wind.
//!
//! A wind has three components, so the four conductances of a head have one combination that no
//! wind changes. Sun, sky, leaks of heat, dust and drifts do:
//!
//! ```text
//! G'_i = (1 + γ_i) (G_i + c_i S_i / θ_i)                      corrected
//! u²(G'_i) = ((1 + γ_i) c_i u(S_i) / θ_i)² + ((G_i + c_i S_i / θ_i) u(γ_i))²
//! n ⊥ W^½ ∂G/∂v,  |n| = 1                                     W = diag(1/σ_i²)
//! z = nᵀ W^½ (G − G(v))  ≈ −Σ_i n_i/σ_i (c_i/θ_i S_i + G_i γ_i) + noise
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | G_i, σ_i² | conductance as measured, its variance by the noise | W/K, W²/K² |
//! | S_i, γ_i | heat that the surface takes up beside the wind, what its gain lacks | W, 1 |
//! | c_i, θ_i | gain of the calibration, overheat | 1, K |
//! | v, G(v) | wind, conductances that follow from it | m/s, W/K |
//! | n | the combination that no wind changes, of noise 1 | 1 |
//!
//! z is one equation in eight unknowns; n turns with the wind, so that varied winds make it many.
//!
//! *Limits.* Linear about v, and of heads with [`SECTORS`] surfaces that determine three
//! components. Uncertainties of corrections count as if each were independent of the others.

use super::sphere::SECTORS;
use super::surface_inverse::{Conductance, MeasuredConductance};
use crate::arithmetic::{cross, dot, scaled, sqrt};
use crate::error::{self, ConfigError, Parameter};

/// Largest heat that a correction may have, W, and γ from the least to the greatest: what is wrong
/// by more is broken.
const MOST_OFFSET_W: f32 = 1.0;
const GAINS: [f32; 2] = [-0.9, 9.0];

/// Offset and gain of a conductance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceCorrection {
    /// S, W.
    pub offset_w: f32,
    /// γ.
    pub gain: f32,
    /// Standard uncertainty of S, W.
    pub offset_u_w: f32,
    /// Standard uncertainty of γ.
    pub gain_u: f32,
}

impl SurfaceCorrection {
    /// G' of a conductance; `share_per_k` is c/θ, 1/K.
    pub fn corrected_w_k(&self, conductance_w_k: f32, share_per_k: f32) -> f32 {
        (1.0 + self.gain) * (conductance_w_k + share_per_k * self.offset_w)
    }

    /// u² of that G', W²/K².
    pub fn variance_w2_k2(&self, conductance_w_k: f32, share_per_k: f32) -> f32 {
        let by_offset = (1.0 + self.gain) * share_per_k * self.offset_u_w;
        let by_gain = (conductance_w_k + share_per_k * self.offset_w) * self.gain_u;
        by_offset * by_offset + by_gain * by_gain
    }

    /// One correction for two: `former`, and this one of what `former` has corrected. An
    /// uncertainty of this one takes the place of the former's, since it is of what both are
    /// together.
    #[must_use]
    pub fn on_top_of(&self, former: &Self) -> Self {
        let own_or = |own: f32, former: f32| if own > 0.0 { own } else { former };
        let factor = 1.0 + former.gain;
        Self {
            offset_w: former.offset_w + self.offset_w / factor,
            gain: former.gain + factor * self.gain,
            offset_u_w: own_or(self.offset_u_w / factor, former.offset_u_w),
            gain_u: own_or(self.gain_u * factor, former.gain_u),
        }
    }

    /// Returns it as it is, if it can be.
    ///
    /// # Errors
    /// A number that is not finite, or larger than those of a sound head.
    pub fn checked(self) -> Result<Self, ConfigError> {
        let parameter = Parameter::SurfaceCorrection;
        let [least, most] = GAINS;
        error::within(parameter, self.offset_w, -MOST_OFFSET_W, MOST_OFFSET_W)?;
        error::within(parameter, self.gain, least, most)?;
        error::within(parameter, self.offset_u_w, 0.0, MOST_OFFSET_W)?;
        error::within(parameter, self.gain_u, 0.0, most)?;
        Ok(self)
    }
}

/// The number that four conductances have to spare, and what slow errors do to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpareNumber {
    /// z, in standard deviations of the noise.
    pub residual: f32,
    /// −∂z/∂S, 1/W.
    pub per_offset_w: [f32; SECTORS],
    /// −∂z/∂γ.
    pub per_gain: [f32; SECTORS],
    /// n.
    pub null: [f32; SECTORS],
}

impl SpareNumber {
    /// From conductances as they were measured, their c/θ (1/K), and those of a wind near the true
    /// one; none where winds change them alike, or a variance is not positive.
    pub fn of(
        measured: &[MeasuredConductance; SECTORS],
        share_per_k: &[f32; SECTORS],
        expected: &[Conductance; SECTORS],
    ) -> Option<Self> {
        let weight: [f32; SECTORS] = measured.map(|of| 1.0 / sqrt(of.variance_w2_k2));
        let row = |i: usize| scaled(expected[i].gradient_w_s_k_m, weight[i]);
        let rows: [[f32; 3]; SECTORS] = core::array::from_fn(row);
        let [a, b, c, d] = rows;
        // Each is the volume of the three others.
        let null = [dot(b, cross(c, d)), -dot(a, cross(c, d)), dot(a, cross(b, d)), -dot(a, cross(b, c))];
        let size = rows.map(|row| dot(row, row)).iter().sum::<f32>();
        let scale = 1.0 / (size * sqrt(size));
        let square = null.map(|n| n * scale * (n * scale)).iter().sum::<f32>();
        if !(square > LEAST_VOLUME * LEAST_VOLUME && square.is_finite()) {
            return None;
        }
        let null = null.map(|n| n * scale / sqrt(square));
        let off = |i: usize| measured[i].conductance_w_k - expected[i].conductance_w_k;
        let residual = (0..SECTORS).map(|i| null[i] * weight[i] * off(i)).sum();
        Some(Self {
            residual,
            per_offset_w: core::array::from_fn(|i| null[i] * weight[i] * share_per_k[i]),
            per_gain: core::array::from_fn(|i| null[i] * weight[i] * measured[i].conductance_w_k),
            null,
        })
    }
}

/// Least volume of the changes by a wind, relative to their size: less is a wind whose direction or
/// speed the surfaces do not see.
const LEAST_VOLUME: f32 = 1e-6;

#[cfg(test)]
mod tests {
    use super::super::tests::sphere_b;
    use super::*;
    use crate::wind::GasState;

    const SHARE_PER_K: [f32; SECTORS] = [1.0 / 30.0; SECTORS];

    fn gas() -> GasState {
        GasState::new(0.0168, 11.05e-6, 10.84e-3).unwrap()
    }

    fn four(wind_m_s: [f32; 3]) -> [Conductance; SECTORS] {
        let [a, b, c, d, ..] = sphere_b().conductances(&gas(), wind_m_s);
        [a, b, c, d]
    }

    fn with(
        conductances: &[Conductance; SECTORS],
        change: impl Fn(usize, f32) -> f32,
    ) -> [MeasuredConductance; SECTORS] {
        core::array::from_fn(|i| MeasuredConductance {
            conductance_w_k: change(i, conductances[i].conductance_w_k),
            variance_w2_k2: 1e-12,
        })
    }

    #[test]
    fn a_slightly_other_wind_does_not_change_the_spare_number_but_heat_does() {
        let (wind, other) = ([3.0, -4.0, 1.0], [3.01, -3.99, 1.02]);
        let of_wind = SpareNumber::of(&with(&four(other), |_, g| g), &SHARE_PER_K, &four(wind)).unwrap();
        // The other wind changes conductances by some micro-watts per kelvin, which are standard
        // deviations; of second order is less than a tenth of one.
        assert!(of_wind.residual.abs() < 0.1, "{}", of_wind.residual);
        let heated = |i: usize, g: f32| if i == 1 { g - 1e-3 / 30.0 } else { g };
        let of_heat = SpareNumber::of(&with(&four(wind), heated), &SHARE_PER_K, &four(wind)).unwrap();
        let expected = -1e-3 * of_heat.per_offset_w[1];
        assert!(expected.abs() > 5.0 && (of_heat.residual / expected - 1.0).abs() < 1e-2, "{of_heat:?}");
        let norm: f32 = of_heat.null.iter().map(|n| n * n).sum();
        assert!((norm - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_correction_takes_back_what_sun_and_dust_did() {
        let correction = SurfaceCorrection { offset_w: 3e-3, gain: 1.0 / 0.95 - 1.0, ..Default::default() };
        let dusty = 0.95 * 1e-3 - 3e-3 / 30.0;
        assert!((correction.corrected_w_k(dusty, 1.0 / 30.0) - 1e-3).abs() < 1e-9);
    }

    #[test]
    fn two_corrections_one_after_the_other_are_the_one_that_they_make_together() {
        let former = SurfaceCorrection { offset_w: 2e-3, gain: 0.05, offset_u_w: 1e-4, gain_u: 0.01 };
        let anew = SurfaceCorrection { offset_w: -5e-4, gain: 0.02, offset_u_w: 2e-5, gain_u: 0.0 };
        let both = anew.on_top_of(&former);
        let (g, share) = (1e-3, 1.0 / 30.0);
        let one_by_one = anew.corrected_w_k(former.corrected_w_k(g, share), share);
        assert!((both.corrected_w_k(g, share) / one_by_one - 1.0).abs() < 1e-6, "{both:?}");
        // An error that was sought anew is as certain as that; another stays as it was.
        assert_eq!((both.offset_u_w, both.gain_u), (2e-5 / 1.05, 0.01));
        assert_eq!(SurfaceCorrection::default().on_top_of(&former), former);
    }

    #[test]
    fn uncertainties_of_a_correction_are_those_of_small_changes() {
        let of = SurfaceCorrection { offset_w: 1e-3, gain: 0.1, offset_u_w: 1e-4, gain_u: 1e-2 };
        let (g, share) = (1e-3, 1.0 / 30.0);
        let more = SurfaceCorrection { offset_w: of.offset_w + of.offset_u_w, ..of };
        let steeper = SurfaceCorrection { gain: of.gain + of.gain_u, ..of };
        let step = |other: SurfaceCorrection| other.corrected_w_k(g, share) - of.corrected_w_k(g, share);
        let expected = step(more) * step(more) + step(steeper) * step(steeper);
        assert!((of.variance_w2_k2(g, share) / expected - 1.0).abs() < 1e-3);
    }

    #[test]
    fn corrections_that_no_sound_head_needs_are_refused() {
        let good = SurfaceCorrection { offset_w: 3e-3, gain: 0.05, offset_u_w: 1e-4, gain_u: 0.01 };
        assert_eq!(good.checked(), Ok(good));
        for bad in [
            SurfaceCorrection { offset_w: f32::NAN, ..good },
            SurfaceCorrection { offset_w: 1.5, ..good },
            SurfaceCorrection { gain: -1.0, ..good },
            SurfaceCorrection { offset_u_w: -1e-4, ..good },
            SurfaceCorrection { gain_u: f32::INFINITY, ..good },
        ] {
            assert_eq!(bad.checked().map_err(|error| error.parameter), Err(Parameter::SurfaceCorrection), "{bad:?}");
        }
    }

    #[test]
    fn surfaces_that_no_wind_changes_have_no_spare_number() {
        let none = [Conductance { conductance_w_k: 1e-3, ..Conductance::default() }; SECTORS];
        assert_eq!(SpareNumber::of(&with(&none, |_, g| g), &SHARE_PER_K, &none), None);
    }
}
