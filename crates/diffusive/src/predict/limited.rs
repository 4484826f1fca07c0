//! A change of the wind answered between two levels: the power is free only where it lies between
//! them.
//!
//! Where u_eq passes a level (thesis 2.47), the loop stays at that level, the temperature leaves
//! its set-point, and the answer waits until it is met again: open-loop motion under a constant
//! power, in closed form. Between, the states slide with exp(−D t).

use dr_core::model::mesh;
use dr_core::sensor::Level;
use nalgebra::DVector;

use super::exponential::exponential;
use super::reaching::meeting_s;
use super::sliding_surface::SlidingSurface;
use super::zeros::decays_of;

/// Times on and off the surface that are followed before it is called endless.
const PIECES: u32 = 20;
/// Points of the search for the moment at which u_eq passes a level, and the decades of time that
/// it looks at.
const POINTS: u32 = 2000;
const DECADES: f64 = 9.0;

/// Answer under the levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limited {
    /// For how long in all the temperature is off its set-point, s; `None`: for ever.
    pub off_s: Option<f64>,
    /// Until the power stays within the bound of its final value, and the temperature at its
    /// set-point; `None`: never.
    pub settled_s: Option<f64>,
}

impl Limited {
    /// The set-point is never left.
    pub const AT_ONCE: Self = Self { off_s: Some(0.0), settled_s: Some(0.0) };
    /// The set-point is left for good.
    pub const NEVER: Self = Self { off_s: None, settled_s: None };
}

/// From states z_k in K that lie on the set-point, until the power is within ±`bound_w` of
/// `finally_w`, between levels in W.
pub fn settle(
    surface: &SlidingSurface,
    weighted_k: &[f64],
    finally_w: f64,
    bound_w: f64,
    levels_w: (f64, f64),
) -> Limited {
    let (low_w, high_w) = levels_w;
    if !(low_w < finally_w && finally_w < high_w) {
        return Limited::NEVER;
    }
    let mut z = weighted_k.to_vec();
    let (mut off_s, mut now_s) = (0.0, 0.0);
    for _ in 0..PIECES {
        let power_w = surface.equivalent_control_w(&z);
        let level = if power_w > high_w {
            (Level::High, high_w)
        } else if power_w < low_w {
            (Level::Low, low_w)
        } else {
            let decays = decays_of(surface, &z);
            let Some(leaves_s) = leaves_s(surface, &|time_s| finally_w + decays.at(time_s), levels_w) else {
                let settled_s = decays.settled_s(bound_w).map(|rest_s| now_s + rest_s);
                return Limited { off_s: Some(off_s), settled_s };
            };
            let slid = exponential(&(surface.sliding_matrix() * -leaves_s)) * DVector::from_column_slice(&z);
            z.copy_from_slice(slid.as_slice());
            now_s += leaves_s;
            continue;
        };
        let Some(away_s) = meeting_s(surface, &z, 0.0, level) else { return Limited::NEVER };
        for ((z, rate), r) in z.iter_mut().zip(&surface.rates_rad_s).zip(&surface.r_k_per_w) {
            *z += mesh::gain(*rate, away_s) * (r * level.1 - *z);
        }
        off_s += away_s;
        now_s += away_s;
    }
    Limited::NEVER
}

/// The first moment of a search at which a power that begins between the levels is beyond one.
fn leaves_s(surface: &SlidingSurface, power_w: &dyn Fn(f64) -> f64, (low_w, high_w): (f64, f64)) -> Option<f64> {
    let end_s = 40.0 / surface.rates_rad_s[0];
    let moment = |n: u32| end_s * libm::pow(10.0, -DECADES * (1.0 - f64::from(n) / f64::from(POINTS)));
    (0..=POINTS).map(moment).find(|time_s| !(low_w..=high_w).contains(&power_w(*time_s)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATES: [f64; 3] = [0.05, 0.4, 3.0];

    /// From R = 30, 8, 2.5 K/W to half the fast ones, held 10 K up.
    fn change() -> (SlidingSurface, Vec<f64>, f64) {
        let from = SlidingSurface::new(&RATES, &[30.0, 8.0, 2.5]).unwrap();
        let to = SlidingSurface::new(&RATES, &[30.0, 4.0, 1.0]).unwrap();
        let z = from.steady_state_k(10.0 / from.steady_gain_k_per_w);
        let finally_w = 10.0 / to.steady_gain_k_per_w;
        (to, z, finally_w)
    }

    #[test]
    fn wide_levels_leave_the_answer_as_it_is() {
        let (to, z, finally_w) = change();
        let free = decays_of(&to, &z).settled_s(0.001);
        assert_eq!(settle(&to, &z, finally_w, 0.001, (0.0, 10.0)), Limited { off_s: Some(0.0), settled_s: free });
    }

    #[test]
    fn a_level_in_the_way_costs_what_a_simulation_of_the_loop_takes() {
        let (to, z, finally_w) = change();
        let at_once_w = to.equivalent_control_w(&z);
        let high_w = f64::midpoint(finally_w, at_once_w);
        assert!(at_once_w > 1.1 * finally_w, "{at_once_w} {finally_w}");
        let found = settle(&to, &z, finally_w, 0.002, (0.0, high_w));
        let (off_s, settled_s) = (found.off_s.unwrap(), found.settled_s.unwrap());
        assert!(settled_s > decays_of(&to, &z).settled_s(0.002).unwrap());
        // One bit every millisecond.
        let (period_s, mut z, mut back_s) = (1e-3, z, None);
        for tick in 0..60_000 {
            let y: f64 = z.iter().sum();
            if tick > 10 && y >= 10.0 && back_s.is_none() {
                back_s = Some(period_s * f64::from(tick));
            }
            let power_w = if y < 10.0 { high_w } else { 0.0 };
            for ((z, rate), r) in z.iter_mut().zip(RATES).zip(&to.r_k_per_w) {
                *z += mesh::gain(rate, period_s) * (r * power_w - *z);
            }
        }
        assert!((back_s.unwrap() - off_s).abs() < 5e-3, "{back_s:?} {off_s}");
        assert!((to.equivalent_control_w(&z) - finally_w).abs() < 0.02 * finally_w);
    }

    #[test]
    fn a_wind_beyond_the_levels_is_never_settled() {
        let (to, z, finally_w) = change();
        assert_eq!(settle(&to, &z, finally_w, 0.001, (0.0, finally_w)), Limited::NEVER);
        assert_eq!(settle(&to, &z, finally_w, 0.001, (finally_w, 10.0)), Limited::NEVER);
    }
}
