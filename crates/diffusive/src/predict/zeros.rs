//! Transmission zeros of H(s) = Σ η_k/(s + ξ_k): the time constants of the closed loop, read off an
//! open-loop model.
//!
//! Sliding, dz/dt = −D z has the eigenvalue 0 and K − 1 others μ_j with H(−μ_j) = 0. Their right
//! and left eigenvectors are v_k = η_k/(ξ_k − μ) and w_k = ξ_k/(ξ_k − μ), scaled so that each has
//! the share 1 in u_eq. So, from any state z on the surface,
//!
//! ```text
//! u_eq(t) = ΔT/ΣR + Σ_j a_j e^(−μ_j t),    a_j = Σ_k w_k z_k / Σ_k w_k v_k
//! ```
//!
//! A pole that this symbol does not heat (η_k = 0) is an eigenvalue by itself, and what is stored
//! in it from another wind decays with a_k = −z_k / H(−ξ_k).
//!
//! For η ≥ 0 the zeros interlace the rates and come from the secular equation, to 1e-15 relative
//! and for any K. Otherwise they are eigenvalues of D on its invariant surface Σz = 0, improved by
//! Newton's steps on H; they may then be complex or, where the loop would run away, have a real
//! part below zero.

use nalgebra::{Complex, ComplexField as _, DMatrix};

use super::decays::Decays;
use super::secular;
use super::sliding_surface::SlidingSurface;

/// Newton's steps that improve an eigenvalue: it doubles digits, and begins with six or more.
const STEPS: usize = 4;

/// One zero, s = −μ.
#[derive(Debug, Clone, PartialEq)]
pub struct Zero {
    /// μ in rad/s: 1/μ is a time constant of the closed loop.
    pub rate_rad_s: Complex<f64>,
    /// ξ_k − μ for the poles that are heated (0 stands for those that are not).
    gaps: Vec<Complex<f64>>,
}

/// The zeros of the poles that this symbol heats, ascending by their real part; one less than there
/// are such poles.
pub fn zeros(surface: &SlidingSurface) -> Vec<Zero> {
    let heated: Vec<usize> = (0..surface.order()).filter(|&k| surface.eta_k_per_j[k] != 0.0).collect();
    let rates: Vec<f64> = heated.iter().map(|&k| surface.rates_rad_s[k]).collect();
    let eta: Vec<f64> = heated.iter().map(|&k| surface.eta_k_per_j[k]).collect();
    let spread = |gap: &dyn Fn(usize) -> Complex<f64>| {
        let mut gaps = vec![Complex::new(0.0, 0.0); surface.order()];
        heated.iter().enumerate().for_each(|(at, &k)| gaps[k] = gap(at));
        gaps
    };
    if eta.iter().all(|eta| *eta > 0.0) {
        let zero = |root: secular::Root| Zero {
            rate_rad_s: root.value(&rates).into(),
            gaps: spread(&|at| root.gap(&rates, at).into()),
        };
        return secular::roots(&rates, &eta, 0.0).into_iter().map(zero).collect();
    }
    let mut all: Vec<Zero> = eigenvalues(&rates, &eta)
        .into_iter()
        .map(|rate| Zero { rate_rad_s: rate, gaps: spread(&|at| Complex::from(rates[at]) - rate) })
        .collect();
    all.sort_by(|a, b| (a.rate_rad_s.re.total_cmp(&b.rate_rad_s.re)).then(a.rate_rad_s.im.total_cmp(&b.rate_rad_s.im)));
    all
}

/// Eigenvalues of D on the surface Σz = 0, where the coordinate of the largest |η| is minus the sum
/// of the others.
fn eigenvalues(rates: &[f64], eta: &[f64]) -> Vec<Complex<f64>> {
    let order = rates.len();
    if order < 2 {
        return Vec::new();
    }
    let gamma: f64 = eta.iter().sum();
    let left_out = (0..order).max_by(|&a, &b| eta[a].abs().total_cmp(&eta[b].abs())).unwrap_or(0);
    let kept: Vec<usize> = (0..order).filter(|&k| k != left_out).collect();
    let reduced = DMatrix::from_fn(order - 1, order - 1, |i, j| {
        let own = if i == j { rates[kept[i]] } else { 0.0 };
        own - eta[kept[i]] * (rates[kept[j]] - rates[left_out]) / gamma
    });
    let improved = |mut rate: Complex<f64>| {
        for _ in 0..STEPS {
            let gap = |k: usize| Complex::from(rates[k]) - rate;
            let value: Complex<f64> = (0..order).map(|k| Complex::from(eta[k]) / gap(k)).sum();
            let slope: Complex<f64> = (0..order).map(|k| Complex::from(eta[k]) / (gap(k) * gap(k))).sum();
            let step = value / slope;
            // Where two zeros meet the slope is none, and the eigenvalue is what there is.
            let small = step.modulus() < 1e-3 * rate.modulus();
            if !small {
                break;
            }
            rate -= step;
        }
        rate
    };
    reduced.complex_eigenvalues().iter().copied().map(improved).collect()
}

/// Decays of u_eq to its steady value from the states z_k in K: its decays, one for every zero and,
/// if anything is stored in them, for the poles that this symbol does not heat. Weights in W.
pub fn decays_of(surface: &SlidingSurface, weighted_k: &[f64]) -> Decays {
    let (rates, eta) = (&surface.rates_rad_s, &surface.eta_k_per_j);
    let mut decays = Decays::default();
    for zero in zeros(surface) {
        let (mut above, mut below) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        for k in 0..surface.order() {
            let gap = if eta[k] == 0.0 { Complex::from(rates[k]) - zero.rate_rad_s } else { zero.gaps[k] };
            if weighted_k[k] != 0.0 {
                above += Complex::from(rates[k] * weighted_k[k]) / gap;
            }
            below += Complex::from(rates[k] * eta[k]) / (gap * gap);
        }
        decays.push(zero.rate_rad_s, above / below);
    }
    for k in (0..surface.order()).filter(|&k| eta[k] == 0.0 && weighted_k[k] != 0.0) {
        let heated = (0..surface.order()).filter(|&i| eta[i] != 0.0);
        let response: f64 = heated.map(|i| eta[i] / (rates[i] - rates[k])).sum();
        decays.push(rates[k].into(), (-weighted_k[k] / response).into());
    }
    decays
}

/// Decays of u_eq to its steady value after the rise was lifted by 1 K at once, from rest; weights
/// in W/K, one a zero.
///
/// The states are then z_k = η_k/Γ, and a_j = 1/(μ_j Σ η_k/(ξ_k − μ_j)²): all greater than zero for
/// η > 0.
pub fn decays_of_a_lift(surface: &SlidingSurface) -> Decays {
    let lifted: Vec<f64> = surface.eta_k_per_j.iter().map(|eta| eta / surface.gamma_k_per_j).collect();
    decays_of(surface, &lifted)
}

#[cfg(test)]
mod tests {
    use super::super::exponential::exponential;
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

    fn fraction(random: &mut ChaCha8Rng) -> f64 {
        (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn random_plane(order: usize, decades: f64, random: &mut ChaCha8Rng) -> SlidingSurface {
        let part = decades / order as f64;
        let rate =
            |k: usize, random: &mut ChaCha8Rng| libm::pow(10.0, part * (k as f64 + 0.2 + 0.6 * fraction(random)) - 2.0);
        let rates: Vec<f64> = (0..order).map(|k| rate(k, random)).collect();
        let r: Vec<f64> = (0..order).map(|_| libm::pow(10.0, 2.0 * fraction(random))).collect();
        SlidingSurface::new(&rates, &r).unwrap()
    }

    #[test]
    fn zeros_are_the_eigenvalues_of_the_sliding_motion() {
        let random = &mut ChaCha8Rng::seed_from_u64(1);
        let mut worst = 0.0_f64;
        for n in 0..1100 {
            let surface = random_plane(2 + n % 11, 4.0, random);
            // D is similar to a symmetric matrix, whose eigenvalues are right to 1e-16 of the
            // largest rate: 1e-12 of the least.
            let (rates, eta) = (&surface.rates_rad_s, &surface.eta_k_per_j);
            let scale: Vec<f64> = rates.iter().zip(eta).map(|(rate, eta)| (rate / eta).sqrt()).collect();
            let d = surface.sliding_matrix();
            let symmetric = DMatrix::from_fn(surface.order(), surface.order(), |i, j| scale[i] * d[(i, j)] / scale[j]);
            let mut eigenvalues: Vec<f64> = symmetric.symmetric_eigenvalues().iter().copied().collect();
            eigenvalues.sort_by(f64::total_cmp);
            assert!(eigenvalues[0].abs() < 1e-12 * rates[surface.order() - 1]);
            for (zero, eigenvalue) in zeros(&surface).iter().zip(&eigenvalues[1..]) {
                worst = worst.max((zero.rate_rad_s.re / eigenvalue - 1.0).abs());
            }
        }
        println!("zeros against eigenvalues, 1100 symbols of K = 2 … 12: largest relative difference {worst:.1e}");
        assert!(worst < 1e-9, "{worst:e}");
    }

    #[test]
    fn forty_poles_over_eight_decades_interlace() {
        let random = &mut ChaCha8Rng::seed_from_u64(2);
        for _ in 0..50 {
            let surface = random_plane(40, 8.0, random);
            let zeros = zeros(&surface);
            assert_eq!(zeros.len(), 39);
            for (zero, edges) in zeros.iter().zip(surface.rates_rad_s.windows(2)) {
                assert!(edges[0] < zero.rate_rad_s.re && zero.rate_rad_s.re < edges[1]);
            }
        }
    }

    #[test]
    fn both_ways_to_the_zeros_agree() {
        let random = &mut ChaCha8Rng::seed_from_u64(3);
        for n in 0..200 {
            let surface = random_plane(2 + n % 11, 4.0, random);
            let mut general = eigenvalues(&surface.rates_rad_s, &surface.eta_k_per_j);
            general.sort_by(|a, b| a.re.total_cmp(&b.re));
            for (zero, general) in zeros(&surface).iter().zip(general) {
                assert!((zero.rate_rad_s - general).modulus() < 1e-12 * general.modulus(), "{zero:?} {general}");
            }
        }
    }

    #[test]
    fn symbols_of_both_signs_have_their_zeros_too() {
        // H = (1(s+3)(s+4) − 2(s+2)(s+4) + 3(s+2)(s+3)) / …: numerator 2s² + 10s + 14, s = −2.5 ±
        // i√3/2
        let surface = SlidingSurface::new(&[2.0, 3.0, 4.0], &[0.5, -2.0 / 3.0, 0.75]).unwrap();
        let found: Vec<_> = zeros(&surface).iter().map(|zero| zero.rate_rad_s).collect();
        assert!((found[0] - Complex::new(2.5, -0.75_f64.sqrt())).modulus() < 1e-13, "{found:?}");
        assert!((found[1] - Complex::new(2.5, 0.75_f64.sqrt())).modulus() < 1e-13);
    }

    #[test]
    fn decays_add_up_to_the_equivalent_control_at_once_and_later() {
        let random = &mut ChaCha8Rng::seed_from_u64(4);
        for n in 0..100 {
            let full = random_plane(3 + n % 10, 3.0, random);
            // One pole that the wind of this class does not reach, but that is warm.
            let mut r = full.r_k_per_w.to_vec();
            r[n % 3] = 0.0;
            let surface = SlidingSurface::new(&full.rates_rad_s, &r).unwrap();
            let z: Vec<f64> = (0..surface.order()).map(|_| fraction(random)).collect();
            let steady = z.iter().sum::<f64>() / surface.steady_gain_k_per_w;
            let decays = decays_of(&surface, &z);
            for time_s in [0.0, 0.03, 1.0, 20.0] {
                let later = exponential(&(surface.sliding_matrix() * -time_s)) * nalgebra::DVector::from_vec(z.clone());
                let exact = surface.equivalent_control_w(later.as_slice());
                let found = steady + decays.at(time_s);
                let scale = steady + surface.equivalent_control_w(&z).abs();
                assert!((found - exact).abs() < 1e-10 * scale, "{n} {time_s}: {found} {exact}");
            }
        }
    }

    #[test]
    fn one_pole_has_no_zero_and_nothing_decays() {
        let surface = SlidingSurface::new(&[0.5], &[10.0]).unwrap();
        assert!(zeros(&surface).is_empty());
        assert_eq!(decays_of_a_lift(&surface).at(0.0), 0.0);
    }
}
