//! A change of the wind under a sliding loop: what the power answers at once, and what is left for
//! the slow poles (thesis 2.56–2.58).
//!
//! When class A gives way to class B, the power u that held the rise is injected by η^B instead of
//! η^A. Seen from A that is a disturbance Ξ_k = (η^B_k − η^A_k) u on pole k, in K/s. Power acts by
//! η^B from now on, so that with χ = Σ Ξ_k the part (η^B_k/Γ^B)χ is matched: a change of the power
//! by −χ/Γ^B undoes it at once. The rest, Ξ_k − (η^B_k/Γ^B)χ, is the drift that is left: it adds up
//! to zero and only moves heat between poles, which u_eq then follows with the zeros of B.

use super::decays::Decays;
use super::limited::{self, Limited};
use super::sliding_surface::SlidingSurface;
use super::zeros::decays_of;

/// A change from a steady state.
#[derive(Debug, Clone, PartialEq)]
pub struct WindChange {
    /// Mean power before the change, W.
    pub before_w: f64,
    /// Right after it, W.
    pub at_once_w: f64,
    /// In the end, W.
    pub finally_w: f64,
    /// (η_k/Γ)χ, K/s.
    pub matched_k_per_s: Vec<f64>,
    /// Ξ_k − (η_k/Γ)χ, K/s.
    pub mismatched_k_per_s: Vec<f64>,
    /// Excess of u_eq over its final value, W, if no level is in its way.
    pub decays: Decays,
    /// The symbol after the change and the states that it begins with; none where the wind acts on
    /// the heated surface alone.
    slides: Option<(SlidingSurface, Vec<f64>)>,
}

impl WindChange {
    /// Share of the mismatched part in Σ|Ξ_k| of matched and mismatched, 0 to 1; 0 if nothing
    /// changes.
    pub fn mismatched_share(&self) -> f64 {
        let size = |parts: &[f64]| parts.iter().map(|part| part.abs()).sum::<f64>();
        let (matched, mismatched) = (size(&self.matched_k_per_s), size(&self.mismatched_k_per_s));
        if matched + mismatched > 0.0 { mismatched / (matched + mismatched) } else { 0.0 }
    }

    /// Time in s after which the power is within a share of its whole change if no level is in its
    /// way; `None` if it never is, as when nothing changes in the end.
    pub fn settled_s(&self, share: f64) -> Option<f64> {
        if self.is_none() {
            return Some(0.0);
        }
        self.decays.settled_s(share * self.step_w())
    }

    /// The same between a low and a high level in W.
    pub fn between(&self, share: f64, levels_w: (f64, f64)) -> Limited {
        match &self.slides {
            Some((surface, z)) if !self.is_none() => {
                limited::settle(surface, z, self.finally_w, share * self.step_w(), levels_w)
            }
            _ if levels_w.0 < self.finally_w && self.finally_w < levels_w.1 => Limited::AT_ONCE,
            _ => Limited::NEVER,
        }
    }

    /// Least and greatest power in W that is needed at any time after the change, each with the
    /// moment in s: 0 is at once, infinity in the end. `None` if the states run away.
    pub fn extremes_w(&self) -> Option<[(f64, f64); 2]> {
        let extremes = self.decays.extremes()?;
        Some(extremes.map(|(time_s, beyond_w)| (time_s, self.finally_w + beyond_w)))
    }

    fn step_w(&self) -> f64 {
        (self.finally_w - self.before_w).abs()
    }

    /// The rounding of a steady state is no change.
    fn is_none(&self) -> bool {
        let none = self.before_w.abs() * 1e-9;
        self.step_w() <= none && self.decays.at(0.0).abs() <= none
    }
}

/// From a steady state that holds `rise_k` in one class to another on the same rates.
pub fn change(from: &SlidingSurface, to: &SlidingSurface, rise_k: f64) -> WindChange {
    let before_w = rise_k / from.steady_gain_k_per_w;
    let z = from.steady_state_k(before_w);
    let disturbance: Vec<f64> =
        from.eta_k_per_j.iter().zip(&to.eta_k_per_j).map(|(from, to)| (to - from) * before_w).collect();
    let chi: f64 = disturbance.iter().sum();
    let matched: Vec<f64> = to.eta_k_per_j.iter().map(|eta| eta / to.gamma_k_per_j * chi).collect();
    WindChange {
        before_w,
        at_once_w: to.equivalent_control_w(&z),
        finally_w: rise_k / to.steady_gain_k_per_w,
        mismatched_k_per_s: disturbance.iter().zip(&matched).map(|(all, matched)| all - matched).collect(),
        matched_k_per_s: matched,
        decays: decays_of(to, &z),
        slides: Some((to.clone(), z)),
    }
}

/// From a steady state that holds `rise_k` in one wind to another where the wind takes power from
/// the heated surface itself (structure `conductance`): `taken_w` in W before and after.
///
/// Such a disturbance Ξ = −η·Δ(taken) enters where the power does: all of it is matched, no pole
/// notices it, and the power answers at once.
pub fn change_of_conductance(structure: &SlidingSurface, rise_k: f64, taken_w: (f64, f64)) -> WindChange {
    let into_the_structure_w = rise_k / structure.steady_gain_k_per_w;
    let matched = structure.eta_k_per_j.iter().map(|eta| -eta * (taken_w.1 - taken_w.0)).collect();
    WindChange {
        before_w: into_the_structure_w + taken_w.0,
        at_once_w: into_the_structure_w + taken_w.1,
        finally_w: into_the_structure_w + taken_w.1,
        matched_k_per_s: matched,
        mismatched_k_per_s: vec![0.0; structure.order()],
        decays: Decays::default(),
        slides: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_all_resistances_alike_is_matched_and_answered_at_once() {
        let from = SlidingSurface::new(&[0.05, 0.4, 3.0], &[30.0, 8.0, 2.5]).unwrap();
        let to = SlidingSurface::new(&[0.05, 0.4, 3.0], &[15.0, 4.0, 1.25]).unwrap();
        let change = change(&from, &to, 10.0);
        assert!(change.mismatched_share() < 1e-15);
        assert!((change.at_once_w / change.finally_w - 1.0).abs() < 1e-14);
        assert_eq!(change.settled_s(0.02), Some(0.0));
    }

    #[test]
    fn one_pole_answers_any_change_at_once() {
        let change = change(
            &SlidingSurface::new(&[0.5], &[30.0]).unwrap(),
            &SlidingSurface::new(&[0.5], &[20.0]).unwrap(),
            10.0,
        );
        assert_eq!((change.mismatched_share(), change.settled_s(0.02)), (0.0, Some(0.0)));
    }

    #[test]
    fn a_change_of_one_pole_among_others_leaves_a_tail_that_ends_in_the_new_steady_state() {
        let from = SlidingSurface::new(&[0.05, 0.4, 3.0], &[30.0, 8.0, 2.5]).unwrap();
        let to = SlidingSurface::new(&[0.05, 0.4, 3.0], &[30.0, 4.0, 2.5]).unwrap();
        let change = change(&from, &to, 10.0);
        assert!(change.mismatched_share() > 0.3);
        assert!((change.finally_w + change.decays.at(0.0) - change.at_once_w).abs() < 1e-15);
        assert!(change.mismatched_k_per_s.iter().sum::<f64>().abs() < 1e-15);
        // The matched part is what the power changes by at once, and the mismatched one the drift
        // that is left.
        let gamma = to.gamma_k_per_j;
        let chi: f64 = change.matched_k_per_s.iter().sum();
        assert!((change.at_once_w - change.before_w + chi / gamma).abs() < 1e-12);
        for k in 0..3 {
            let z_k = from.r_k_per_w[k] * change.before_w;
            let drift = to.eta_k_per_j[k] * change.at_once_w - to.rates_rad_s[k] * z_k;
            assert!((change.mismatched_k_per_s[k] - drift).abs() < 1e-12, "{k}");
        }
        assert!(change.settled_s(0.02).unwrap() > 1.0);
        let wide = change.between(0.02, (0.0, 10.0));
        assert_eq!((wide.off_s, wide.settled_s), (Some(0.0), change.settled_s(0.02)));
    }

    #[test]
    fn no_change_is_settled() {
        let surface = SlidingSurface::new(&[0.05, 0.4, 3.0], &[30.0, 8.0, 2.5]).unwrap();
        assert_eq!(change(&surface, &surface, 10.0).settled_s(0.02), Some(0.0));
    }
}
