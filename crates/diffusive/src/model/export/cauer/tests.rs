use dr_core::model::mesh;
use nalgebra::{Complex, ComplexField as _, DMatrix};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, Uniform};

use super::*;

/// Z(jω) of a ladder, from its far end: a continued fraction with positive parts only.
fn impedance(ladder: &[LadderSection], omega_rad_s: f64) -> Complex<f64> {
    let mut beyond = Complex::new(0.0, 0.0);
    for section in ladder.iter().rev() {
        let through = (beyond + section.resistance_k_per_w).inv();
        beyond = (Complex::new(0.0, omega_rad_s * section.capacitance_j_per_k) + through).inv();
    }
    beyond
}

fn foster(rates: &[f64], r: &[f64], omega_rad_s: f64) -> Complex<f64> {
    rates.iter().zip(r).map(|(rate, r)| *r / Complex::new(1.0, omega_rad_s / rate)).sum()
}

/// The greatest relative difference of the two networks' impedances over all frequencies.
fn difference(rates: &[f64], r: &[f64]) -> f64 {
    let ladder = cauer(rates, r).unwrap();
    let (first, last) = (rates[0] / 100.0, rates[rates.len() - 1] * 100.0);
    let at = |n: usize| {
        let omega = mesh::rate_rad_s(first, last, n, 600);
        let exact = foster(rates, r, omega);
        ((impedance(&ladder, omega) - exact) / exact).modulus()
    };
    (0..600).map(at).fold(0.0, f64::max)
}

#[test]
fn two_poles_have_the_ladder_of_school_books() {
    // Z = (s + 2)/(s² + 4 s + 3) = ½/(s + 1) + ½/(s + 3): divided out by hand, C_1 = 1, R_1 = ½,
    // C_2 = 4, R_2 = 1/6
    let ladder = cauer(&[1.0, 3.0], &[0.5, 0.5 / 3.0]).unwrap();
    let values: Vec<f64> =
        ladder.iter().flat_map(|section| [section.capacitance_j_per_k, section.resistance_k_per_w]).collect();
    for (value, expected) in values.iter().zip([1.0, 0.5, 4.0, 1.0 / 6.0]) {
        // some roundings
        assert!((value / expected - 1.0).abs() < 1e-14, "{values:?}");
    }
}

#[test]
fn thirty_random_poles_over_eight_decades_keep_their_impedance() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let exponent = Uniform::new(-4.0, 3.0).unwrap();
    let mut worst = 0.0_f64;
    for _ in 0..50 {
        let rates: Vec<f64> = (0..30).map(|k| mesh::rate_rad_s(1e-4, 1e4, k, 30)).collect();
        let r: Vec<f64> = rates.iter().map(|_| libm::pow(10.0, exponent.sample(&mut random))).collect();
        worst = worst.max(difference(&rates, &r));
    }
    println!("largest relative difference of impedances, 30 poles, 8 decades: {worst:.1e}");
    // Wanted: 1e-9. Componentwise stable: 30² steps of a few roundings each, which mostly cancel
    // out.
    assert!(worst < 1e-13, "{worst}");
}

#[test]
fn rates_that_nearly_meet_keep_their_impedance() {
    let rates = [1e-4, 1.000_001e-4, 0.1, 0.100_000_1, 50.0, 1e4];
    assert!(difference(&rates, &[3.0, 1.0, 1e-3, 20.0, 1e3, 1e-2]) < 1e-13);
}

#[test]
fn a_known_ladder_comes_back_from_its_poles() {
    // A ladder's states √C_i T_i have a symmetric tridiagonal matrix; its eigenvalues are the
    // rates, and the squares of the eigenvectors' first entries over C_1 the symbol.
    let resistance = [0.2, 3.0, 0.7, 5.0, 11.0];
    let capacitance = [0.01, 0.4, 2.0, 0.6, 30.0];
    let conductance = |i: usize| 1.0 / resistance[i];
    let matrix = DMatrix::from_fn(5, 5, |i, j| match (i, j) {
        (0, 0) => conductance(0) / capacitance[0],
        _ if i == j => (conductance(i - 1) + conductance(i)) / capacitance[i],
        _ if i.abs_diff(j) == 1 => -conductance(i.min(j)) / f64::sqrt(capacitance[i] * capacitance[j]),
        _ => 0.0,
    });
    let eigen = matrix.symmetric_eigen();
    let mut poles: Vec<(f64, f64)> = (0..5)
        .map(|k| {
            let rate = eigen.eigenvalues[k];
            (rate, eigen.eigenvectors[(0, k)].powi(2) / capacitance[0] / rate)
        })
        .collect();
    poles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (rates, r): (Vec<f64>, Vec<f64>) = poles.into_iter().unzip();
    let ladder = cauer(&rates, &r).unwrap();
    for i in 0..5 {
        // The eigenvalues are right to 1e-16 of the greatest (500 rad/s), the slowest (2e-3 rad/s)
        // so to 1e-11.
        assert!((ladder[i].resistance_k_per_w / resistance[i] - 1.0).abs() < 1e-9, "{ladder:?}");
        assert!((ladder[i].capacitance_j_per_k / capacitance[i] - 1.0).abs() < 1e-9, "{ladder:?}");
    }
    let structure = structure_function(&rates, &r).unwrap();
    // Σ R = 19.9 and Σ C = 33.01, with 3.2 and 0.41 behind the second section
    for (at, expected) in [(1, (3.2, 0.41)), (4, (19.9, 33.01))] {
        assert!((structure[at].0 / expected.0 - 1.0).abs() < 1e-9 && (structure[at].1 / expected.1 - 1.0).abs() < 1e-9);
    }
}

#[test]
fn zeros_are_left_out_and_negative_resistances_refused() {
    assert_eq!(cauer(&[1.0, 2.0, 3.0], &[0.5, 0.0, 0.5 / 3.0]), cauer(&[1.0, 3.0], &[0.5, 0.5 / 3.0]));
    let refused = cauer(&[1.0, 2.0], &[1.0, -0.25]).unwrap_err().to_string();
    assert!(refused.contains("R_2 = -0.25 K/W is negative") && refused.contains("non-negative"));
    assert!(cauer(&[1.0], &[0.0]).unwrap_err().to_string().contains("all resistances are zero"));
}
