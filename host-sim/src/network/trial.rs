//! Quick gains on trial: an observer beside the very network that it was made for, before a board gets it.
//!
//! Gains are made element by element, as if the others were known. They are not: what one element's gains do wrong heats the others'
//! models, and whether it dies away is a matter of all of them together. So all elements are simulated in f64, without noise, at the
//! sample period; each part's convective power jumps up and back, some more and some the other way, as when the wind turns:
//!
//! ```text
//! q_i: 0 → a_i J → 0        E_i = Σ (q̂_i − q_i)²
//! ```
//!
//! An element whose E is above that of the steady filters, or not finite, loses its quick gains, and the rest is tried again. What an observer does
//! wrong does not depend on the heating that it knows of, and so there is none. Four dice on a card, which heat each other by a fifth of what
//! they heat themselves within a second, run away with quick gains; the sectors of a sphere do not.
//!
//! Limits: the network is taken for the truth. Where the identification is wrong, quick gains may do harm that is not seen here.

use dr_core::model::{Look, Network, NetworkState, mesh};
use wire::MOST_ELEMENTS;

use super::quickness::{JUMP_W, LAST_PERIODS};
use super::windless::{Observer, Windless};

/// Each jump is followed for so many times as long as the last set of gains lasts.
const FOLLOWED: f64 = 2.0;
/// E over that of the steady filters at most: jumps that raise no alarm differ by what the others' do.
const WORSE: f64 = 1.05;
/// a_i: of the parts in turn.
const SHARES: [f64; 4] = [1.0, -0.5, 0.75, 0.25];

/// Takes away what does not stand the trial; the places in the head of the elements that lose their quick gains.
pub fn on_trial(windless: &Windless, observer: &mut Observer, bandwidth_hz: f64, sample_period_s: f64) -> Vec<usize> {
    let mut lost = Vec::new();
    if observer.faster.is_empty() {
        return lost;
    }
    let steady = Observer { faster: Vec::new(), ..observer.clone() };
    let ticks = (FOLLOWED * LAST_PERIODS / bandwidth_hz / sample_period_s).ceil() as usize;
    let Some(by_steady) = errors(windless, &steady, ticks, sample_period_s) else { return lost };
    // One by one at the worst: there are not more elements than rounds.
    while !observer.faster.is_empty() {
        let Some(by_quick) = errors(windless, observer, ticks, sample_period_s) else { break };
        let fails = |place: usize| by_quick[place].is_nan() || by_quick[place] > WORSE * by_steady[place];
        let places = observer.own.iter().map(|(place, _)| *place);
        let failed: Vec<usize> = places.filter(|&place| observer.is_quick(place) && fails(place)).collect();
        if failed.is_empty() {
            break;
        }
        observer.faster.retain(|of| !failed.contains(&usize::from(of.element)));
        lost.extend(failed);
    }
    lost.sort_unstable();
    lost
}

/// E by element of the head; none if the board refuses the observer, which it says itself.
fn errors(
    windless: &Windless,
    observer: &Observer,
    ticks: usize,
    sample_period_s: f64,
) -> Option<[f64; MOST_ELEMENTS]> {
    let period_s = sample_period_s as f32;
    let mut network = Network::<MOST_ELEMENTS>::default();
    for (place, config) in &observer.own {
        network.set_own(*place, config, period_s).ok()?;
    }
    for config in &observer.faster {
        network.set_faster(config, period_s).ok()?;
    }
    for config in &observer.cross {
        network.set_cross(config, period_s).ok()?;
    }
    let mut truth = Truth::new(windless, sample_period_s);
    let mut state = NetworkState::default();
    let mut errors = [0.0; MOST_ELEMENTS];
    let valid = observer.own.iter().fold(0, |valid, (place, _)| valid | 1_u16 << place);
    for tick in 0..2 * ticks {
        let jump_w = if tick < ticks { JUMP_W } else { 0.0 };
        let mut shares = SHARES.iter().cycle();
        let mut q_w = [0.0; MOST_ELEMENTS];
        for own in windless.own.iter().filter(|own| own.surface.is_some()) {
            q_w[own.element] = if tick == 0 { 0.0 } else { jump_w * shares.next().copied().unwrap_or(1.0) };
        }
        let look = Look {
            temperature_c: &truth.temperature_c(),
            valid,
            read_high: if tick % 2 == 0 { valid } else { 0 },
            power_w: &[0.0; MOST_ELEMENTS],
            standing_w: &[0.0; MOST_ELEMENTS],
        };
        let found = network.step(&mut state, &look);
        for (place, _) in &observer.own {
            let error_w = found.map_or(f64::NAN, |found| f64::from(found.power_w[*place]) - q_w[*place]);
            errors[*place] += error_w * error_w;
        }
        truth.step(&q_w);
    }
    Some(errors)
}

/// The network in f64, with its states.
struct Truth<'a> {
    windless: &'a Windless,
    /// g_k and x_k of own and then of cross-heating, in the order of the network.
    pairs: Vec<Vec<(f64, f64)>>,
}

impl<'a> Truth<'a> {
    /// Without any heating.
    fn new(windless: &'a Windless, sample_period_s: f64) -> Self {
        let own = windless.own.iter().map(|own| &own.mesh_rad_s);
        let all = own.chain(windless.cross.iter().map(|cross| &cross.mesh_rad_s));
        let gains = |mesh: &Vec<f64>| mesh.iter().map(|&rate| (mesh::gain(rate, sample_period_s), 0.0)).collect();
        Self { windless, pairs: all.map(gains).collect() }
    }

    fn temperature_c(&self) -> [f32; MOST_ELEMENTS] {
        let mut temperature_c = [0.0; MOST_ELEMENTS];
        for own in &self.windless.own {
            temperature_c[own.element] = own.rest_c;
        }
        let own = self.windless.own.iter().map(|own| (own.element, &own.r_k_per_w));
        let to = own.chain(self.windless.cross.iter().map(|cross| (cross.to, &cross.r_k_per_w)));
        for ((to, r_k_per_w), states) in to.zip(&self.pairs) {
            temperature_c[to] += r_k_per_w.iter().zip(states).map(|(r, (_, x))| r * x).sum::<f64>();
        }
        temperature_c.map(|celsius| celsius as f32)
    }

    fn step(&mut self, q_w: &[f64; MOST_ELEMENTS]) {
        let own = self.windless.own.iter().map(|own| (own.element, own.surface.as_deref().unwrap_or_default()));
        let from = own.chain(self.windless.cross.iter().map(|cross| (cross.from, &cross.surface[..])));
        for ((from, surface), states) in from.zip(&mut self.pairs) {
            for ((gain, x), m) in states.iter_mut().zip(surface) {
                *x += *gain * (-m * q_w[from] - *x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::answer::off_line::OffLine;
    use crate::head::{Answering, Head};
    use crate::network::ReadingNoise;
    use crate::network::windless::{Cross, Own};

    fn sphere_b() -> Head {
        Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/sphere-b-calibrated.toml")).unwrap()
    }

    /// Four dice that share a card: the simulated REMS, as identified at 40 Hz.
    fn card() -> (Windless, [ReadingNoise; 4]) {
        let own = (0..4).map(|element| Own {
            element,
            name: format!("die{}", element + 1),
            rest_c: 21.0,
            mesh_rad_s: vec![0.0113784, 1.21035, 1.74034, 25.4283],
            r_k_per_w: vec![69.731, 264.114, 340.10, 6.38035],
            layers: Vec::new(),
            surface: Some(vec![1.0; 4]),
        });
        let mut cross = Vec::new();
        for (from, to) in (0..4).flat_map(|from| (0..4).map(move |to| (from, to))).filter(|(from, to)| from != to) {
            let (mesh_rad_s, r_k_per_w) = match (from ^ to) == 2 {
                true => (vec![0.01472, 20.0], vec![84.8, -0.0537]),
                false => (vec![0.0113823, 1.38577, 1.48868], vec![69.75, 1047.0, -979.9]),
            };
            cross.push(Cross { from, to, surface: vec![1.0; mesh_rad_s.len()], mesh_rad_s, r_k_per_w });
        }
        (Windless { own: own.collect(), cross }, [ReadingNoise { low_k: 0.03125, high_k: 0.00781 }; 4])
    }

    #[test]
    fn quick_gains_of_dice_that_share_a_card_do_not_hold_and_are_left_out() {
        let (windless, noise) = card();
        for bandwidth_hz in [0.5, 1.0, 2.0] {
            let observer = windless.adaptive_observer(bandwidth_hz, 0.005, &noise).unwrap();
            assert!(observer.faster.is_empty(), "{bandwidth_hz} Hz");
            assert!(observer.own.iter().all(|(_, config)| config.alarm.is_none()), "{bandwidth_hz} Hz");
            let [sentence] = &observer.not_quick[..] else { panic!("{:?}", observer.not_quick) };
            assert!(sentence.starts_with("die1, die2, die3, die4: "), "{sentence}");
        }
    }

    #[test]
    fn quick_gains_of_a_sphere_hold() {
        let calibration = sphere_b().calibration.unwrap();
        for bandwidth_hz in [0.5, 1.0, 2.0, 5.0] {
            let observer = calibration.windless.adaptive_observer(bandwidth_hz, 1e-3, &calibration.noise).unwrap();
            assert_eq!(observer.not_quick, Vec::<String>::new(), "{bandwidth_hz} Hz");
            assert!((0..4).all(|place| observer.is_quick(place)), "{bandwidth_hz} Hz");
        }
    }

    #[test]
    fn the_board_takes_the_sets_of_any_rate_and_bandwidth() {
        let head = sphere_b();
        let calibration = head.calibration.as_ref().unwrap();
        for (rate_hz, bandwidth_hz) in [(100.0, 2.0), (100.0, 3.0), (100.0, 5.0), (250.0, 5.0), (20.0, 1.0)] {
            let answering = Answering { bandwidth_hz, every_s: 0.1, fixed: false };
            let made = OffLine::new(&head, calibration, &answering, 1.0 / rate_hz);
            assert!(made.is_ok(), "{rate_hz} Hz, {bandwidth_hz} Hz: {:?}", made.err());
        }
    }
}
