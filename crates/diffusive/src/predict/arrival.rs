//! Ticks of a recorded loop that count: those at which it has arrived at its set-point, as far as
//! its readings tell.
//!
//! A loop on its surface passes its set-point every few ticks, whatever the noise is, as every
//! passage turns the heater. Under one level, on the way there or blown off, it stays on one side
//! of it for long, and further away than a swing. Both together are no chance.

use super::closed::PredictedElement;

/// Ticks on one side of the set-point that a loop on its surface does not stay.
const LONG: usize = 20;
/// Distance at which it is no swing, in units of the most that one tick moves the prediction while
/// it is held.
const FAR: f64 = 3.0;

/// For every tick whether a recorded temperature in °C is at the set-point that the prediction has.
pub fn at_set_point(of: &PredictedElement, recorded_c: &[f64]) -> Vec<bool> {
    let moves = of.sampled_c.windows(2).zip(&of.held).filter(|(_, held)| **held).map(|(c, _)| (c[1] - c[0]).abs());
    let far_k = FAR * moves.fold(0.0, f64::max);
    let ticks = || of.target_c.iter().zip(recorded_c);
    let side = |(target_c, recorded_c): (&f64, &f64)| (target_c.to_bits(), recorded_c < target_c);
    let sides: Vec<(u64, bool)> = ticks().map(side).collect();
    let apart_k: Vec<f64> = ticks().map(|(target_c, recorded_c)| (recorded_c - target_c).abs()).collect();
    let mut at = Vec::with_capacity(sides.len());
    for stretch in sides.chunk_by(|a, b| a == b) {
        let from = at.len();
        let furthest_k = apart_k[from..from + stretch.len()].iter().copied().fold(0.0, f64::max);
        at.resize(from + stretch.len(), stretch.len() <= LONG || furthest_k <= far_k);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Held at 30 °C throughout, by 10 mK a tick.
    fn predicted(ticks: usize) -> PredictedElement {
        PredictedElement {
            regulated: true,
            held: vec![true; ticks],
            sampled_c: (0..ticks).map(|n| 30.0 + 0.005 * if n % 2 == 0 { 1.0 } else { -1.0 }).collect(),
            target_c: vec![30.0; ticks],
            ..PredictedElement::default()
        }
    }

    #[test]
    fn a_way_to_the_set_point_and_away_from_it_does_not_count_and_noise_does() {
        // 100 ticks below, at it with twice its swing in noise, and 60 ticks blown off by 1 K.
        let recorded: Vec<f64> = (0..1000)
            .map(|n| match n {
                0..100 => 25.0 + 0.05 * f64::from(n),
                700..760 => 29.0,
                n => 30.0 + 0.02 * libm::sin(1.7 * f64::from(n * n % 103)),
            })
            .collect();
        let at = at_set_point(&predicted(1000), &recorded);
        assert!(at[..99].iter().all(|at| !at) && at[700..760].iter().all(|at| !at));
        assert!(at[102..680].iter().all(|at| *at) && at[780..].iter().all(|at| *at));
    }

    #[test]
    fn slow_swings_within_a_few_ticks_moves_are_a_loop_near_its_level() {
        // Up for one tick, and down for forty.
        let recorded: Vec<f64> = (0..820).map(|n| 30.0 + 0.015 - 0.02 * f64::from(n % 41) / 40.0).collect();
        assert!(at_set_point(&predicted(820), &recorded).iter().all(|at| *at));
    }
}
