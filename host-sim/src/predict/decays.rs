//! Sums of decaying exponentials Σ a_j e^(−μ_j t), and how long they last.

use nalgebra::Complex;

/// Points of the search for the last moment above a bound.
const POINTS: u32 = 4000;
/// Decades of time that it looks at.
const DECADES: f64 = 12.0;
/// Points in a period of the fastest swing, where there is one, and how many at most.
const POINTS_A_PERIOD: f64 = 64.0;
const MOST_POINTS: f64 = 4e6;

/// (μ_j in rad/s, a_j).
pub type Term = (Complex<f64>, Complex<f64>);

/// A sum of exponentials; complex ones come in conjugate pairs, so that it is real.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decays {
    terms: Vec<Term>,
}

impl Decays {
    /// Adds a e^(−μt).
    pub fn push(&mut self, rate_rad_s: Complex<f64>, weight: Complex<f64>) {
        self.terms.push((rate_rad_s, weight));
    }

    /// (μ_j, a_j), as they were added.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    pub fn at(&self, time_s: f64) -> f64 {
        self.terms.iter().map(|(rate, weight)| (weight * (-rate * time_s).exp()).re).sum()
    }

    /// The time in s from which the sum stays within ±`bound`: 0 if it always is, `None` if it never will.
    ///
    /// Right to 1e-9 relative, unless signs differ and the sum leaves the bound for less than 1 % of the time elapsed; to 1e-3 of a period
    /// where it swings.
    pub fn settled_s(&self, bound: f64) -> Option<f64> {
        let envelope = |time_s: f64| -> f64 {
            self.terms.iter().map(|(rate, weight)| weight.norm() * (-rate.re * time_s).exp()).sum()
        };
        if envelope(0.0) <= bound {
            return Some(0.0);
        }
        let live = |(rate, weight): &&Term| rate.re <= 0.0 && weight.norm() > 0.0;
        if bound.is_nan() || bound <= 0.0 || self.terms.iter().any(|term| live(&term)) {
            return None;
        }
        let slowest =
            self.terms.iter().map(|(rate, _)| rate.re).filter(|rate| *rate > 0.0).fold(f64::INFINITY, f64::min);
        let mut end_s = 1.0 / slowest;
        while envelope(end_s) > bound {
            end_s *= 2.0;
        }
        let outside = |time_s: f64| self.at(time_s).abs() > bound;
        let (mut from_s, mut to_s) = match self.last_outside(end_s, &outside) {
            Some(bracket) => bracket,
            None => return Some(0.0),
        };
        while to_s - from_s > 1e-10 * to_s {
            let middle_s = f64::midpoint(from_s, to_s);
            if outside(middle_s) { from_s = middle_s } else { to_s = middle_s }
        }
        Some(to_s)
    }

    /// Two neighbouring moments up to `end_s`, of which the first is outside and all from the second on are inside.
    fn last_outside(&self, end_s: f64, outside: &dyn Fn(f64) -> bool) -> Option<(f64, f64)> {
        let swing = self.terms.iter().map(|(rate, _)| rate.im.abs()).fold(0.0, f64::max);
        let even = (end_s * swing * POINTS_A_PERIOD / std::f64::consts::TAU).ceil();
        if (1.0..MOST_POINTS).contains(&even) {
            let moment = |n: f64| end_s * n / even;
            let last = (0..even as u32).rev().map(f64::from).find(|&n| outside(moment(n)))?;
            return Some((moment(last), moment(last + 1.0)));
        }
        let moment = |n: u32| end_s * 10_f64.powf(-DECADES * f64::from(n) / f64::from(POINTS));
        match (1..=POINTS).find(|&n| outside(moment(n))) {
            Some(n) => Some((moment(n), moment(n - 1))),
            None => outside(0.0).then(|| (0.0, moment(POINTS))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(terms: &[(f64, f64)]) -> Decays {
        Decays { terms: terms.iter().map(|&(rate, weight)| (rate.into(), weight.into())).collect() }
    }

    #[test]
    fn one_exponential_is_settled_after_its_logarithm() {
        for (rate, weight) in [(0.1, 3.0), (40.0, -0.5), (1e-5, 1.0)] {
            let exact = (f64::abs(weight) / 0.02).ln() / rate;
            assert!((sum(&[(rate, weight)]).settled_s(0.02).unwrap() / exact - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_last_time_counts_where_the_sum_changes_its_sign() {
        // e^−t − 2 e^−5t: within ±0.5 when it passes through zero, and outside for a last time afterwards.
        let decays = sum(&[(1.0, 1.0), (5.0, -2.0)]);
        let settled_s = decays.settled_s(0.3).unwrap();
        assert!((decays.at(settled_s) - 0.3).abs() < 1e-8);
        assert!(settled_s > 1.0, "{settled_s}");
    }

    #[test]
    fn a_swing_counts_to_its_last_peak() {
        // e^(−t) cos 50t as a conjugate pair: within ±0.1 for good after the last peak above, near ln 10.
        let pair = [Complex::new(1.0, 50.0), Complex::new(1.0, -50.0)];
        let decays = Decays { terms: pair.iter().map(|rate| (*rate, Complex::from(0.5))).collect() };
        let settled_s = decays.settled_s(0.1).unwrap();
        let later = (0..2_000_000).map(|n| settled_s * (1.0 + 1e-9) + 1e-6 * f64::from(n));
        assert!(later.map(|time_s| decays.at(time_s).abs()).fold(0.0, f64::max) < 0.1 * (1.0 + 2e-3));
        assert!(settled_s < 10_f64.ln() && settled_s > 10_f64.ln() - std::f64::consts::TAU / 50.0, "{settled_s}");
    }

    #[test]
    fn what_grows_or_stays_never_settles_and_nothing_is_settled_at_once() {
        assert_eq!(sum(&[(-1.0, 1.0)]).settled_s(0.5), None);
        assert_eq!(sum(&[(0.0, 1.0)]).settled_s(0.5), None);
        assert_eq!(sum(&[(1.0, 1.0)]).settled_s(0.0), None);
        assert_eq!(sum(&[(1.0, 0.4)]).settled_s(0.5), Some(0.0));
        assert_eq!(sum(&[]).settled_s(0.0), Some(0.0));
    }
}
