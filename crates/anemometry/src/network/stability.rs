//! Observers that are stable, of one bandwidth or of one that rises for a while after the wind has
//! jumped: an observer is simulated against the network that it was made for,
//! before a board gets it.
//!
//! Gains are designed element by element, as if the others were known. They are not: an error of
//! one element's gains heats the others' models, and whether it dies away depends on all of them
//! together. So all elements are simulated in f64, without noise, at the sample period; the
//! convective power of each surface jumps up and back, some more and some the other way, as when
//! the wind turns:
//!
//! ```text
//! q_i: 0 → a_i J → 0        E_i = Σ (q̂_i − q_i)²
//! ```
//!
//! Gains that stay as they are must not let the error grow after a jump, whether they are those of
//! the requested bandwidth or one of the sets for the time after an alarm. A bandwidth for which
//! they do not is refused.
//!
//! Where the E of one surface is above that of the steady filters, or not finite, none gets quick
//! gains. Nor do they where the error runs away at a small duty cycle: gains that are right for a
//! reading at the high level in every other tick are no longer so where the next one comes after 16
//! of them. Three films on a tube run away from every fourth, 10⁴ times the steady E and more; the
//! sectors of sphere B stay within 5, hemispheres of sphere A within 12. The error of an observer
//! does not depend on the heating that it knows of, and so there is none. Four dice on a card,
//! which heat each other by a fifth of what they heat themselves within a second, are unstable with
//! quick gains; the sectors of a sphere are not.
//!
//! Limits: the network is taken for the truth. Where the identification is wrong, quick gains may
//! do harm that is not seen here.

use dr_core::control::MOST_ELEMENTS;
use dr_core::model::{ConvectionObserverState, TickInput, mesh};
use recording::text::short;

use super::gain_schedule::{JUMP_W, LAST_PERIODS, gain_schedule};
use super::kalman::Plant;
use super::observer::NetworkObserver;
use super::parameters::{NetworkError, QuiescentNetwork};

/// Each jump is followed for so many times as long as the last set of gains lasts.
const FOLLOWED: f64 = 2.0;
/// E over that of the steady filters at most: jumps that raise no alarm differ by what the others'
/// do.
const WORSE: f64 = 1.05;
/// E over that of the steady filters from which quick gains have run away.
const RUNS_AWAY: f64 = 50.0;
/// Ticks by which an element is read at the high level before the next one.
const SKEW: usize = 5;
/// a_i: of the surfaces in turn.
const SHARES: [f64; 4] = [1.0, -0.5, 0.75, 0.25];
/// Fewest ticks of a third.
const LEAST_TICKS: usize = 30;

/// A set of gains is followed for so many times as long as it lasts.
const FOLLOWED_SET: f64 = 10.0;
/// Steps in which a stable bandwidth is sought, and where that ends, Hz.
const SLOWER: f64 = 1.25;
const LEAST_BANDWIDTH_HZ: f64 = 0.05;
/// Growth of E from one third of the time to the next from which it is an instability: filters that
/// hold have 1.6 at most, as the first readings after a jump still teach them, others 3.7 and more.
const GROWS: f64 = 2.0;
/// Error that counts as none, over the jump: roundings of f32 temperatures make it.
const ROUNDING: f64 = 1e-2;

impl QuiescentNetwork {
    /// Like [`observer`](Self::observer), with filters that must be stable beside each other.
    ///
    /// # Errors
    /// As `observer`, or the greatest bandwidth that is stable.
    pub fn stable_observer(&self, bandwidth_hz: f64, sample_period_s: f64) -> Result<NetworkObserver, NetworkError> {
        let stable = |hz: f64| {
            let observer = self.observer(hz, sample_period_s)?;
            Ok(settles(self, &observer, hz, sample_period_s).then_some(observer))
        };
        if let Some(observer) = stable(bandwidth_hz)? {
            return Ok(observer);
        }
        let mut slower_hz = bandwidth_hz;
        while slower_hz > LEAST_BANDWIDTH_HZ {
            slower_hz /= SLOWER;
            if let Ok(Some(_)) = stable(slower_hz) {
                let slower = short(slower_hz, 2);
                return Err(NetworkError::new(format!(
                    "a bandwidth of {bandwidth_hz} Hz cannot be had: the filters are unstable at it, because elements heat each other or \
                     because readings at the high level weigh so much more than at the low one; {slower} Hz is stable, or a lower \
                     current_high_a"
                )));
            }
        }
        Err(NetworkError::new("the filters of its elements are unstable at any bandwidth: is the network right?"))
    }

    /// Configurations as those of [`stable_observer`](Self::stable_observer), with a gain schedule
    /// for every surface, or for none: one wind is estimated from all surfaces, and just after its
    /// alarm a surface that is quicker than the others counts as missing. There are none if one of
    /// them is too noisy or worse beside the other elements (above).
    ///
    /// # Errors
    /// As [`stable_observer`](Self::stable_observer).
    pub fn adaptive_observer(&self, bandwidth_hz: f64, sample_period_s: f64) -> Result<NetworkObserver, NetworkError> {
        let steady = self.stable_observer(bandwidth_hz, sample_period_s)?;
        let mut quick = steady.clone();
        let mut too_noisy = Vec::new();
        for (i, own) in self.own.iter().enumerate().filter(|(_, own)| own.surface.is_some()) {
            match gain_schedule(&Plant { own, sample_period_s }, &steady.filters[i]) {
                Some(schedule) => {
                    quick.own[i].1.alarm = Some(schedule.alarm);
                    quick.faster.extend(schedule.sets);
                }
                None => too_noisy.push(own.name.as_str()),
            }
        }
        let (mut names, mut why) = (too_noisy, "nothing quicker is quiet enough");
        if names.is_empty() {
            names = worse_when_quick(self, &steady, &quick, bandwidth_hz, sample_period_s);
            why = "beside their own network quick gains do worse after a jump";
        }
        if names.is_empty() && !quick_sets_settle(self, &quick, sample_period_s) {
            let surfaces = self.own.iter().filter(|own| own.surface.is_some());
            names = surfaces.map(|own| own.name.as_str()).collect();
            why = "beside each other quick gains are unstable";
        }
        if names.is_empty() {
            return Ok(quick);
        }
        Ok(NetworkObserver { fixed: Some(format!("{}: {why}", names.join(", "))), ..steady })
    }
}

/// Levels at which the elements are read: a reading weighs the more the less noise it has.
#[derive(Clone, Copy)]
enum ReadLevels {
    Low,
    Turns,
    High,
    /// High in one tick of so many, one element after the other.
    OneOf(usize),
}

impl ReadLevels {
    const ALL: [Self; 3] = [Self::Low, Self::Turns, Self::High];
    const SELDOM: [Self; 6] =
        [Self::OneOf(3), Self::OneOf(6), Self::OneOf(12), Self::OneOf(24), Self::OneOf(48), Self::OneOf(96)];

    /// Elements of `valid` that are read at the high level at a tick.
    fn read_high(self, valid: usize, tick: usize) -> usize {
        let turn = |element: usize, ticks: usize| (tick + SKEW * element).is_multiple_of(ticks);
        match self {
            Self::Low => 0,
            Self::Turns => valid * usize::from(tick.is_multiple_of(2)),
            Self::High => valid,
            Self::OneOf(ticks) => {
                let high = (0..MOST_ELEMENTS).filter(|&element| turn(element, ticks));
                high.fold(0, |high, element| high | 1_usize << element) & valid
            }
        }
    }
}

/// Tells whether the error of steady gains dies away after a jump.
fn settles(network: &QuiescentNetwork, observer: &NetworkObserver, bandwidth_hz: f64, sample_period_s: f64) -> bool {
    settles_within(network, observer, FOLLOWED_SET * LAST_PERIODS / bandwidth_hz, sample_period_s)
}

/// Tells whether it does with each set of quick gains, used by all surfaces at once.
fn quick_sets_settle(network: &QuiescentNetwork, quick: &NetworkObserver, sample_period_s: f64) -> bool {
    let sets = quick.faster.iter().map(|of| of.set).max().map_or(0, |most| most + 1);
    (0..sets).all(|set| {
        let mut held = NetworkObserver { faster: Vec::new(), ..quick.clone() };
        let mut lasts_s: f64 = 0.0;
        for of in quick.faster.iter().filter(|of| of.set == set) {
            if let Some((_, config)) = held.own.iter_mut().find(|(place, _)| *place == usize::from(of.element)) {
                config.gains = of.gains;
            }
            lasts_s = lasts_s.max(f64::from(of.until_s));
        }
        held.own.iter_mut().for_each(|(_, config)| config.alarm = None);
        settles_within(network, &held, FOLLOWED_SET * lasts_s, sample_period_s)
    })
}

fn settles_within(network: &QuiescentNetwork, observer: &NetworkObserver, time_s: f64, sample_period_s: f64) -> bool {
    let ticks = (time_s / sample_period_s).ceil() as usize;
    let third = ticks.div_ceil(3).max(LEAST_TICKS);
    let none = (ROUNDING * JUMP_W).powi(2) * third as f64;
    // In still gas nearly all readings are at the low level, in a storm at the high one.
    ReadLevels::ALL.into_iter().all(|levels| {
        let courses = courses(network, observer, &[third; 3], |_| JUMP_W, levels, sample_period_s);
        let Some([_, before, after]) = courses.map(|of| of.map(|squares| squares.iter().sum::<f64>())) else {
            return true;
        };
        after.is_finite() && (after <= none || after < GROWS * before)
    })
}

/// Names of the elements that are unstable or worse with quick gains for all surfaces.
fn worse_when_quick<'a>(
    network: &'a QuiescentNetwork,
    steady: &NetworkObserver,
    quick: &NetworkObserver,
    bandwidth_hz: f64,
    sample_period_s: f64,
) -> Vec<&'a str> {
    let ticks = (FOLLOWED * LAST_PERIODS / bandwidth_hz / sample_period_s).ceil() as usize;
    let jump_w = |stretch: usize| if stretch == 0 { JUMP_W } else { 0.0 };
    let errors = |observer, levels| {
        let [up, back] = courses(network, observer, &[ticks; 2], jump_w, levels, sample_period_s)?;
        Some(std::array::from_fn::<f64, MOST_ELEMENTS, _>(|place| up[place] + back[place]))
    };
    let mut worse = [false; MOST_ELEMENTS];
    let seldom = ReadLevels::SELDOM.map(|levels| (levels, RUNS_AWAY));
    for (levels, most) in [(ReadLevels::Turns, WORSE)].into_iter().chain(seldom) {
        let (Some(by_steady), Some(by_quick)) = (errors(steady, levels), errors(quick, levels)) else { continue };
        for (worse, (quick, steady)) in worse.iter_mut().zip(by_quick.iter().zip(by_steady)) {
            *worse = quick.is_nan() || *quick > most * steady;
        }
        if worse.contains(&true) {
            break;
        }
    }
    let own = network.own.iter().filter(|own| own.surface.is_some() && worse[own.element]);
    own.map(|own| own.name.as_str()).collect()
}

/// E by element of the head over stretches of so many ticks, with the J of each; none if the board
/// refuses the observer, which it says itself.
fn courses<const S: usize>(
    network: &QuiescentNetwork,
    observer: &NetworkObserver,
    stretches: &[usize; S],
    jump_w: impl Fn(usize) -> f64,
    levels: ReadLevels,
    sample_period_s: f64,
) -> Option<[[f64; MOST_ELEMENTS]; S]> {
    let board = observer.board(sample_period_s as f32).ok()?;
    let mut truth = SimulatedNetwork::new(network, sample_period_s);
    let mut state = ConvectionObserverState::default();
    let mut errors = [[0.0; MOST_ELEMENTS]; S];
    let valid = observer.own.iter().fold(0, |valid, (place, _)| valid | 1_usize << place);
    let all = stretches.iter().enumerate().flat_map(|(stretch, &ticks)| (0..ticks).map(move |_| stretch));
    for (tick, stretch) in all.enumerate() {
        let jump_w = jump_w(stretch);
        let mut shares = SHARES.iter().cycle();
        let mut q_w = [0.0; MOST_ELEMENTS];
        for own in network.own.iter().filter(|own| own.surface.is_some()) {
            q_w[own.element] = if tick == 0 { 0.0 } else { jump_w * shares.next().copied().unwrap_or(1.0) };
        }
        let look = TickInput {
            temperature_c: &truth.temperature_c(),
            valid,
            read_high: levels.read_high(valid, tick),
            power_w: &[0.0; MOST_ELEMENTS],
            standing_w: &[0.0; MOST_ELEMENTS],
        };
        let found = board.step(&mut state, &look);
        for (place, _) in &observer.own {
            let error_w = found.map_or(f64::NAN, |found| f64::from(found.power_w[*place]) - q_w[*place]);
            errors[stretch][*place] += error_w * error_w;
        }
        truth.step(&q_w);
    }
    Some(errors)
}

/// The network in f64, with its states.
struct SimulatedNetwork<'a> {
    network: &'a QuiescentNetwork,
    /// g_k and x_k of own and then of cross-heating, in the order of the network.
    pairs: Vec<Vec<(f64, f64)>>,
}

impl<'a> SimulatedNetwork<'a> {
    /// Without any heating.
    fn new(network: &'a QuiescentNetwork, sample_period_s: f64) -> Self {
        let own = network.own.iter().map(|own| &own.mesh_rad_s);
        let all = own.chain(network.cross.iter().map(|cross| &cross.mesh_rad_s));
        let gains = |mesh: &Vec<f64>| mesh.iter().map(|&rate| (mesh::gain(rate, sample_period_s), 0.0)).collect();
        Self { network, pairs: all.map(gains).collect() }
    }

    fn temperature_c(&self) -> [f32; MOST_ELEMENTS] {
        let mut temperature_c = [0.0; MOST_ELEMENTS];
        for own in &self.network.own {
            temperature_c[own.element] = own.rest_c;
        }
        let own = self.network.own.iter().map(|own| (own.element, &own.r_k_per_w));
        let to = own.chain(self.network.cross.iter().map(|cross| (cross.to, &cross.r_k_per_w)));
        for ((to, r_k_per_w), states) in to.zip(&self.pairs) {
            temperature_c[to] += r_k_per_w.iter().zip(states).map(|(r, (_, x))| r * x).sum::<f64>();
        }
        temperature_c.map(|celsius| celsius as f32)
    }

    fn step(&mut self, q_w: &[f64; MOST_ELEMENTS]) {
        let own = self.network.own.iter().map(|own| (own.element, own.surface.as_deref().unwrap_or_default()));
        let from = own.chain(self.network.cross.iter().map(|cross| (cross.from, &cross.surface[..])));
        for ((from, surface), states) in from.zip(&mut self.pairs) {
            for ((gain, x), m) in states.iter_mut().zip(surface) {
                *x += *gain * (-m * q_w[from] - *x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::{CrossHeatingParameters, ReadingNoise, SelfHeatingParameters};
    use super::*;

    /// Four dice that share a card: the simulated REMS, as identified at 40 Hz.
    fn card() -> QuiescentNetwork {
        let name = |element: usize| format!("die{}", element + 1);
        let own = (0..4).map(|element| SelfHeatingParameters {
            element,
            name: name(element),
            rest_c: 21.0,
            noise: ReadingNoise { low_k: 0.03125, high_k: 0.00781 },
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
            cross.push(CrossHeatingParameters {
                from,
                to,
                from_name: name(from),
                to_name: name(to),
                surface: vec![1.0; mesh_rad_s.len()],
                mesh_rad_s,
                r_k_per_w,
            });
        }
        QuiescentNetwork { own: own.collect(), cross }
    }

    /// Three films on a tube, in thin CO₂.
    fn tube() -> QuiescentNetwork {
        let name = |element: usize| format!("film{}", element + 1);
        let own = (0..3).map(|element| SelfHeatingParameters {
            element,
            name: name(element),
            rest_c: 20.0,
            noise: ReadingNoise { low_k: 1e-3, high_k: 1.5e-4 },
            mesh_rad_s: vec![2.67e-3, 0.029, 0.1223, 3.42],
            r_k_per_w: vec![697.2, 40.0, 160.0, 66.4],
            layers: Vec::new(),
            surface: Some(vec![0.999, 0.991, 0.961, -0.096]),
        });
        let pairs = (0..3).flat_map(|from| (0..3).map(move |to| (from, to))).filter(|(from, to)| from != to);
        let cross = pairs.map(|(from, to)| CrossHeatingParameters {
            from,
            to,
            from_name: name(from),
            to_name: name(to),
            mesh_rad_s: vec![2.67e-3, 5.96e-3, 0.027, 0.1054],
            r_k_per_w: vec![700.7, -4.9, 40.3, -29.9],
            surface: vec![0.999, 0.998, 0.991, 0.966],
        });
        QuiescentNetwork { own: own.collect(), cross: cross.collect() }
    }

    #[test]
    fn what_a_surface_is_late_after_a_jump_does_not_stay_in_the_others() {
        const TICKS: usize = 300;
        let (network, sample_period_s) = (tube(), 0.01);
        for bandwidth_hz in [1.0, 2.0] {
            let observer = network.stable_observer(bandwidth_hz, sample_period_s).unwrap();
            for levels in ReadLevels::ALL {
                let courses = courses(&network, &observer, &[TICKS; 2], |_| JUMP_W, levels, sample_period_s).unwrap();
                for squares in &courses[1][..3] {
                    let left_w = (squares / TICKS as f64).sqrt();
                    assert!(left_w < 1e-3 * JUMP_W, "{bandwidth_hz} Hz: {left_w} W from 3 s to 6 s");
                }
            }
        }
    }

    #[test]
    fn quick_gains_that_run_away_at_small_duty_cycles_are_left_out() {
        let network = tube();
        let observer = network.adaptive_observer(1.0, 0.01).unwrap();
        assert!(observer.faster.is_empty() && observer.fixed.is_some());
    }

    #[test]
    fn quick_gains_of_dice_that_share_a_card_do_not_hold_and_are_left_out() {
        let network = card();
        for bandwidth_hz in [0.5, 1.0, 2.0] {
            let observer = network.adaptive_observer(bandwidth_hz, 0.005).unwrap();
            assert!(observer.faster.is_empty(), "{bandwidth_hz} Hz");
            assert!(observer.own.iter().all(|(_, config)| config.alarm.is_none()), "{bandwidth_hz} Hz");
            let why = observer.fixed.unwrap_or_default();
            assert!(why.starts_with("die1, die2, die3, die4: "), "{why}");
        }
    }
}
