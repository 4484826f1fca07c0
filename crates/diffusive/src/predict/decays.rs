//! Sums of decaying exponentials Σ a_j e^(−μ_j t), and how long they last.

use nalgebra::{Complex, ComplexField};

/// Points of the search for the last moment above a bound.
const POINTS: u32 = 4000;
/// Decades of time that it looks at.
const DECADES: f64 = 12.0;
/// Rest of a sum where the search for its extremes ends, as a share of what it began with.
const ENDED: f64 = 1e-12;
/// Halvings, or nearly, of the stretch in which an extreme lies.
const NARROWINGS: u32 = 100;
/// Points in a period of the fastest swing, where there is one, and how many at most.
const POINTS_A_PERIOD: f64 = 64.0;
const MOST_POINTS: f64 = 4e6;

/// (μ_j in rad/s, a_j).
pub type DecayTerm = (Complex<f64>, Complex<f64>);

/// A sum of exponentials; complex ones come in conjugate pairs, so that it is real.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decays {
    terms: Vec<DecayTerm>,
}

impl Decays {
    /// Adds a e^(−μt).
    pub fn push(&mut self, rate_rad_s: Complex<f64>, weight: Complex<f64>) {
        self.terms.push((rate_rad_s, weight));
    }

    /// (μ_j, a_j), as they were added.
    pub fn terms(&self) -> &[DecayTerm] {
        &self.terms
    }

    /// The sum at a time in s.
    pub fn at(&self, time_s: f64) -> f64 {
        self.terms.iter().map(|(rate, weight)| (weight * ComplexField::exp(-rate * time_s)).re).sum()
    }

    /// The time in s from which the sum stays within ±`bound`: 0 if it always is, `None` if it
    /// never will.
    ///
    /// Right to 1e-9 relative, unless signs differ and the sum leaves the bound for less than 1 %
    /// of the time elapsed; to 1e-3 of a period where it swings.
    pub fn settled_s(&self, bound: f64) -> Option<f64> {
        if self.envelope(0.0) <= bound {
            return Some(0.0);
        }
        if bound.is_nan() || bound <= 0.0 {
            return None;
        }
        let end_s = self.end_s(bound)?;
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

    /// Least and greatest value for t ≥ 0, each as (moment in s, value): 0 for ever after is one of
    /// them, at infinity. `None` if a term does not decay.
    pub fn extremes(&self) -> Option<[(f64, f64); 2]> {
        if self.terms.is_empty() {
            return Some([(0.0, 0.0); 2]);
        }
        let end_s = self.end_s(ENDED * self.envelope(0.0))?;
        let greatest = |sign: f64| {
            let value = |time_s: f64| sign * self.at(time_s);
            let (points, moment) = self.moments(end_s);
            let highest = (0..=points).max_by(|a, b| value(moment(*a)).total_cmp(&value(moment(*b)))).unwrap_or(0);
            let (mut from_s, mut to_s) = (moment(highest.saturating_sub(1)), moment((highest + 1).min(points)));
            for _ in 0..NARROWINGS {
                let third_s = (to_s - from_s) / 3.0;
                let (one_s, other_s) = (from_s + third_s, to_s - third_s);
                if value(one_s) < value(other_s) { from_s = one_s } else { to_s = other_s }
            }
            let near = [moment(highest), from_s].map(|time_s| (time_s, sign * value(time_s)));
            let best = if sign * near[1].1 > sign * near[0].1 { near[1] } else { near[0] };
            if sign * best.1 > 0.0 { best } else { (f64::INFINITY, 0.0) }
        };
        Some([greatest(-1.0), greatest(1.0)])
    }

    fn envelope(&self, time_s: f64) -> f64 {
        self.terms.iter().map(|(rate, weight)| weight.modulus() * libm::exp(-rate.re * time_s)).sum()
    }

    /// A moment from which on all terms together are within `bound`; `None` if a term does not
    /// decay.
    fn end_s(&self, bound: f64) -> Option<f64> {
        if self.terms.iter().any(|(rate, weight)| rate.re <= 0.0 && weight.modulus() > 0.0) {
            return None;
        }
        let rates = self.terms.iter().map(|(rate, _)| rate.re).filter(|rate| *rate > 0.0);
        let mut end_s = rates.reduce(f64::min).map_or(1.0, |slowest| 1.0 / slowest);
        while self.envelope(end_s) > bound {
            end_s *= 2.0;
        }
        Some(end_s)
    }

    /// Moments from 0 to `end_s` by their number up to the last: even ones where the sum swings, by
    /// equal ratios otherwise.
    fn moments(&self, end_s: f64) -> (u32, Box<dyn Fn(u32) -> f64>) {
        let swing = self.terms.iter().map(|(rate, _)| rate.im.abs()).fold(0.0, f64::max);
        let even = (end_s * swing * POINTS_A_PERIOD / std::f64::consts::TAU).ceil();
        if (1.0..MOST_POINTS).contains(&even) {
            return (even as u32, Box::new(move |n| end_s * f64::from(n) / even));
        }
        let decades = |n: u32| DECADES * (f64::from(n) - f64::from(POINTS + 1)) / f64::from(POINTS);
        (POINTS + 1, Box::new(move |n| if n == 0 { 0.0 } else { end_s * libm::pow(10.0, decades(n)) }))
    }

    /// Two neighbouring moments up to `end_s`, of which the first is outside and all from the
    /// second on are inside.
    fn last_outside(&self, end_s: f64, outside: &dyn Fn(f64) -> bool) -> Option<(f64, f64)> {
        let (points, moment) = self.moments(end_s);
        let last = (0..points).rev().find(|&n| outside(moment(n)))?;
        Some((moment(last), moment(last + 1)))
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
            let exact = libm::log(f64::abs(weight) / 0.02) / rate;
            assert!((sum(&[(rate, weight)]).settled_s(0.02).unwrap() / exact - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_last_time_counts_where_the_sum_changes_its_sign() {
        // e^−t − 2 e^−5t: within ±0.5 when it passes through zero, and outside for a last time
        // afterwards.
        let decays = sum(&[(1.0, 1.0), (5.0, -2.0)]);
        let settled_s = decays.settled_s(0.3).unwrap();
        assert!((decays.at(settled_s) - 0.3).abs() < 1e-8);
        assert!(settled_s > 1.0, "{settled_s}");
    }

    #[test]
    fn a_swing_counts_to_its_last_peak() {
        // e^(−t) cos 50t as a conjugate pair: within ±0.1 for good after the last peak above, near
        // ln 10.
        let pair = [Complex::new(1.0, 50.0), Complex::new(1.0, -50.0)];
        let decays = Decays { terms: pair.iter().map(|rate| (*rate, Complex::from(0.5))).collect() };
        let settled_s = decays.settled_s(0.1).unwrap();
        let later = (0..2_000_000).map(|n| settled_s * (1.0 + 1e-9) + 1e-6 * f64::from(n));
        assert!(later.map(|time_s| decays.at(time_s).abs()).fold(0.0, f64::max) < 0.1 * (1.0 + 2e-3));
        assert!(
            settled_s < libm::log(10.0) && settled_s > libm::log(10.0) - std::f64::consts::TAU / 50.0,
            "{settled_s}"
        );
    }

    #[test]
    fn extremes_may_come_later_than_at_once() {
        // e^(−t) − e^(−5t): nothing at once, 5^(−1/4) − 5^(−5/4) at ln 5/4, and nothing again.
        let [(_, least), (at_s, most)] = sum(&[(1.0, 1.0), (5.0, -1.0)]).extremes().unwrap();
        let exact = libm::pow(5.0, -0.25) - libm::pow(5.0, -1.25);
        assert!((most - exact).abs() < 1e-14 && (at_s - libm::log(5.0) / 4.0).abs() < 1e-6, "{at_s} {most} {exact}");
        assert_eq!(least, 0.0);
        // A decay from its greatest value is at that at once, and least in the end.
        assert_eq!(sum(&[(1.0, 2.0)]).extremes(), Some([(f64::INFINITY, 0.0), (0.0, 2.0)]));
        assert_eq!(sum(&[]).extremes(), Some([(0.0, 0.0), (0.0, 0.0)]));
        assert_eq!(sum(&[(0.0, 1.0)]).extremes(), None);
        // e^(−t) cos 50t: its first trough is near π/50.
        let pair = [Complex::new(1.0, 50.0), Complex::new(1.0, -50.0)];
        let swing = Decays { terms: pair.iter().map(|rate| (*rate, Complex::from(0.5))).collect() };
        let [(trough_s, trough), _] = swing.extremes().unwrap();
        assert!((trough_s - std::f64::consts::PI / 50.0).abs() < 1e-3 && (-0.95..-0.93).contains(&trough), "{trough}");
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
