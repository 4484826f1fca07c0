//! The peak gust: the greatest mean of 3 s within an interval (WMO-No. 8, part I, 5.1.1 and 5.8.3).

use std::collections::VecDeque;

/// Duration of a gust, s.
pub const GUST_S: f64 = 3.0;
/// Least number of estimates in a gust: fewer are single values, not a mean.
const LEAST: f64 = 3.0;
/// Share of a gust's estimates that must count.
const LEAST_SHARE: f64 = 0.9;

/// The greatest mean of 3 s among speeds at rising times, one each `step_s` where none is missing,
/// of an interval that begins at `begin_s`; none where estimates are too rare.
pub fn peak_gust_m_s(begin_s: f64, step_s: f64, speeds: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let whole = (GUST_S / step_s).round();
    if whole.is_nan() || whole < LEAST {
        return None;
    }
    let least = (LEAST_SHARE * whole).ceil() as usize;
    let mut window = VecDeque::new();
    let mut sum = 0.0;
    let mut peak: Option<f64> = None;
    for (time_s, speed_m_s) in speeds {
        window.push_back((time_s, speed_m_s));
        sum += speed_m_s;
        // Half a step: the estimate of 3 s ago belongs to the window before.
        while let Some((first_s, first)) = window.front().copied()
            && first_s < time_s - GUST_S + 0.5 * step_s
        {
            window.pop_front();
            sum -= first;
        }
        if window.len() >= least && time_s >= begin_s + GUST_S - 1.5 * step_s {
            let mean = sum / window.len() as f64;
            peak = Some(peak.map_or(mean, |peak| peak.max(mean)));
        }
    }
    peak
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(speed: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..6000).map(|n| 0.01 * f64::from(n)).map(|time_s| (time_s, speed(time_s))).collect()
    }

    #[test]
    fn a_gust_of_a_second_and_a_half_counts_by_half() {
        let speeds = series(|time_s| if (20.0..21.5).contains(&time_s) { 9.0 } else { 5.0 });
        let peak = peak_gust_m_s(0.0, 0.01, speeds.into_iter()).unwrap();
        assert!((peak - 7.0).abs() < 1e-9, "{peak}");
    }

    #[test]
    fn a_sine_of_ten_seconds_is_smoothed_by_its_mean_of_three() {
        let speeds = series(|time_s| 5.0 + (std::f64::consts::TAU * time_s / 10.0).sin());
        let peak = peak_gust_m_s(0.0, 0.01, speeds.into_iter()).unwrap();
        // sin(π 3/10)/(π 3/10).
        let half = std::f64::consts::PI * 0.3;
        assert!((peak - 5.0 - half.sin() / half).abs() < 1e-5, "{peak}");
    }

    #[test]
    fn a_window_with_missing_estimates_and_rare_ones_are_no_gust() {
        // More than half of the gust is missing: the first window that counts has 1.4 s of it, in
        // 2.7 s.
        let speeds = series(|time_s| if (20.0..23.0).contains(&time_s) { 9.0 } else { 5.0 });
        let kept = speeds.into_iter().filter(|(time_s, _)| !(20.0..21.6).contains(time_s));
        let peak = peak_gust_m_s(0.0, 0.01, kept).unwrap();
        assert!((peak - 5.0 - 4.0 * 1.4 / 2.7).abs() < 0.03, "{peak}");
        assert_eq!(peak_gust_m_s(0.0, 2.0, (0..50).map(|n| (2.0 * f64::from(n), 5.0))), None);
        assert_eq!(peak_gust_m_s(0.0, f64::NAN, std::iter::empty()), None);
    }
}
