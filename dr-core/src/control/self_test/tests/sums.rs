//! Sums, against what is known of it in closed form.

use super::*;

fn quiet(values: impl IntoIterator<Item = f32>) -> Quiet {
    let mut quiet = Quiet::default();
    values.into_iter().for_each(|value| quiet.take(value));
    quiet
}

#[test]
fn a_mean_is_that_of_all() {
    assert_eq!((quiet([]).mean(), quiet([]).count()), (None, 0));
    assert_eq!(quiet([7.5]).mean(), Some(7.5));
    // 100 + 1 … 100 + 9: all exact.
    let nine = quiet((1..=9).map(|n| 100.0 + n as f32));
    assert_eq!((nine.mean(), nine.count()), (Some(105.0), 9));
    // Small changes of a great number: 2²³ and every other time one more.
    assert_eq!(quiet((0..8).map(|n| 8_388_608.0 + (n % 2 * 2) as f32)).mean(), Some(8_388_609.0));
}

#[test]
fn noise_is_of_second_differences_over_their_own_number() {
    assert_eq!((quiet([1.0]).noise(), quiet([1.0, 2.0]).noise()), (None, None));
    // The second difference of 1, 2, 6 is 6 − 4 + 1 = 3: σ² = 9/6.
    assert!((quiet([1.0, 2.0, 6.0]).noise().unwrap() - 1.5_f32.sqrt()).abs() < 1e-6);
    // ±a in turn has second differences of 4a, each of N − 2: σ = a √(16/6), whatever N.
    for count in [3, 4, 10, 64] {
        let noise = quiet((0..count).map(|n| 5.0 + if n % 2 == 0 { 0.25 } else { -0.25 })).noise().unwrap();
        assert!((noise - 0.25 * (16.0_f32 / 6.0).sqrt()).abs() < 1e-6, "{count}: {noise}");
    }
    // Neither a level nor a steady cooling is noise.
    assert_eq!(quiet((0..64).map(|n| 300.0 - 0.25 * n as f32)).noise(), Some(0.0));
}

/// A pulse of which the readings follow the model `m` by a ratio, beyond what was read before by a
/// gap.
fn pulse(before_c: f32, gap_k: f32, ratio: f32, models: &[f32]) -> Pulse {
    let mut pulse = Pulse::starting(before_c);
    models.iter().for_each(|m| pulse.take(before_c + gap_k + ratio * m, *m));
    pulse
}

#[test]
fn a_response_that_is_a_multiple_of_the_models_is_found_with_its_gap() {
    // Multiples of powers of two: every sum is exact.
    let models = [0.5, 0.75, 1.5, 2.0, 2.25, 4.0, 4.5, 8.0];
    for (gap_k, ratio) in [(0.0, 1.0), (0.5, 1.0), (-0.25, 0.5), (0.125, 1.5), (0.0, -0.5)] {
        let pulse = pulse(-40.0, gap_k, ratio, &models);
        assert_eq!(pulse.rise_k(), 7.5 * ratio);
        assert_eq!(pulse.expected_k(), 7.5);
        let (found, gap) = pulse.against_model().unwrap();
        assert!((found - ratio).abs() < 1e-6 && (gap - gap_k).abs() < 1e-5, "{found} for {ratio}, {gap} for {gap_k}");
    }
}

#[test]
fn a_response_that_is_none_of_the_models_is_fitted_by_least_squares() {
    // m = 0, 1, 2 and T = 10, 13, 13 °C: slope 3/2, at the start 12 − 3/2 = 10.5; 10 °C before.
    let mut pulse = Pulse::starting(10.0);
    for (temperature_c, model_k) in [(10.0, 0.0), (13.0, 1.0), (13.0, 2.0)] {
        pulse.take(temperature_c, model_k);
    }
    assert_eq!(pulse.against_model(), Some((1.5, 0.5)));
    // The same with a model that had come by 4 K before the first reading: 4 · 3/2 less at its
    // start.
    let mut later = Pulse::starting(10.0);
    for (temperature_c, model_k) in [(10.0, 4.0), (13.0, 5.0), (13.0, 6.0)] {
        later.take(temperature_c, model_k);
    }
    assert_eq!(later.against_model(), Some((1.5, -5.5)));
}

#[test]
fn a_model_that_expects_nothing_is_nothing_to_compare_with() {
    assert_eq!(pulse(-40.0, 0.0, 1.0, &[2.0; 8]).against_model(), None);
}
