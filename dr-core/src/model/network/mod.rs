//! The windless network of a head: what its structure takes of the heat of its elements, and so what is left for the wind.
//!
//! All elements with their cross-heating, as identified in still gas; and the wind as the one thing that is not in it (wind as feedback,
//! for several elements). Beside every tick it is held on the measured temperatures, and what has to be taken away for that is the
//! convective power:
//!
//! ```text
//! e_i  = s_i (T_i − rest_i − Σ_k R_k^ii x_k^ii − Σ_j Σ_k R_k^ij x_k^ij)
//! q_i  ← q_i − ℓ_i e_i
//! x_k^ii ← x_k^ii + g_k (P_i − m_k q_i + c_k e_i − x_k^ii)
//! x_k^ij ← x_k^ij + g_k (P_j − m_k q_j − x_k^ij)
//! Ts_i = rest_i + Σ_k R_k^ii m_k x_k^ii + Σ_j Σ_k R_k^ij x_k^ij
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | q | convective power: what the wind takes beyond still gas | W |
//! | e | innovation, weighted by s: readings at the high level, of a greater voltage, are worth more than those at the low one | K |
//! | ℓ, c_k, s | gains and weights of a steady-state Kalman filter for which q is a random walk; they make the bandwidth | W/K |
//! | m_k | share of heat at the surface in relaxation k | |
//! | Ts | temperature of the surface | °C |
//!
//! P − q is the equivalent control of the windless network: what its structure takes. In a mode k of a network the temperatures of two
//! nodes have a fixed ratio; m_k is that of surface and element. Heat that the surface loses enters the mode by as much, and its
//! temperature is read from it by as much again. Where the element is soldered to the surface m_k is nearly 1 up to the rate of that
//! contact, and without it q would lag by the contact's time constant.
//!
//! **Alarm.** A filter is either quick or quiet. So innovations are watched: smoothed, they are small as long as the wind walks as the
//! filter believes. Beyond a threshold the wind has jumped, and the gains become those of the fastest of several sets; from then on
//! slower sets follow, each as soon as the one before it has settled, until those of the steady wind are back. After a time t the
//! answer is then about as quiet as anything can be that has only t to look at. Its variance says so.
//!
//! Limits: linear; m of the element that becomes warm by cross-heating is taken for 1, which is good for slow modes, and others are
//! small there. A state is corrected by its own element's readings only. `+ − × ÷` on f32 in fixed order.

mod config;

mod gains;

pub use config::{AlarmConfig, CROSS_ORDER, CROSSES, CrossConfig, FASTER, FasterConfig, GainsConfig, OwnConfig, QUICK};
pub use gains::Watch;

use gains::{Adaptive, Sets};

use super::{ORDER, RelaxationState, Relaxations, Symbol};
use crate::error::{self, ConfigError, Parameter, Problem};
use crate::seal::{Seal, sealable};

/// Rounds of correction in which the beginning's convection is found. Four sectors that share a third of their heat gain half a digit a
/// round; what is left is the observer's to find.
const ROUNDS: usize = 12;

/// Powers in W and temperatures in °C whose sizes are more together belong to no head: the observer has run away.
const RUN_AWAY: f32 = 1e6;

/// Own heating, made ready.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Own {
    relaxations: Relaxations<ORDER>,
    symbol: Symbol<ORDER>,
    /// R_k m_k
    surface_k_per_w: Symbol<ORDER>,
    surface: [f32; ORDER],
    rest_c: f32,
    gains: Adaptive,
}

/// Cross-heating, made ready.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cross {
    from: u8,
    to: u8,
    relaxations: Relaxations<CROSS_ORDER>,
    symbol: Symbol<CROSS_ORDER>,
    /// R_k m_k
    surface_k_per_w: Symbol<CROSS_ORDER>,
    surface: [f32; CROSS_ORDER],
}

/// The windless network of N elements at a fixed sample period. Elements that are not part of it have no [`OwnConfig`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Network<const N: usize> {
    own: [Option<Own>; N],
    cross: [Option<Cross>; CROSSES],
    /// Of elements that have faster gains, in the order in which they were told.
    sets: [Sets; QUICK],
    quick: u8,
}

/// What it remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NetworkState<const N: usize> {
    own: [RelaxationState<ORDER>; N],
    cross: [RelaxationState<CROSS_ORDER>; CROSSES],
    /// q, W.
    convection_w: [f32; N],
    watch: [Watch; N],
    /// Elements that have been seen at least once; before that there is nothing to begin with.
    begun: bool,
}

/// What is known of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look<'a, const N: usize> {
    /// Temperatures, °C.
    pub temperature_c: &'a [f32; N],
    /// Bit i is set if element i was read.
    pub valid: u16,
    /// Bit i is set if element i was at its high level while it was read.
    pub read_high: u16,
    /// Heating powers from this tick to the next, W.
    pub power_w: &'a [f32; N],
    /// Powers under which the head has stood for long, W. Only looked at to begin with.
    pub standing_w: &'a [f32; N],
}

/// What the network says of the wind at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convection<const N: usize> {
    /// q: what the wind takes beyond still gas, W.
    pub power_w: [f32; N],
    /// Ts: temperatures of the surfaces, °C.
    pub surface_c: [f32; N],
    /// Variances of q by the noise of the readings, W².
    pub variance_w2: [f32; N],
}

impl<const N: usize> Default for Network<N> {
    fn default() -> Self {
        Self { own: [None; N], cross: [None; CROSSES], sets: [Sets::default(); QUICK], quick: 0 }
    }
}

impl<const N: usize> Default for NetworkState<N> {
    /// Nothing seen yet.
    fn default() -> Self {
        Self {
            own: [RelaxationState::default(); N],
            cross: [RelaxationState::default(); CROSSES],
            convection_w: [0.0; N],
            watch: [Watch::default(); N],
            begun: false,
        }
    }
}

impl<const N: usize> Network<N> {
    /// Takes in an element, or puts it in the place of what it was.
    ///
    /// # Errors
    /// Names a number that is not finite, rates that do not ascend, a steady gain or a weight that is not greater than zero, or no such element.
    pub fn set_own(&mut self, element: usize, config: &OwnConfig, sample_period_s: f32) -> Result<(), ConfigError> {
        let mut own = Own::new(config, sample_period_s)?;
        let slot = self.own.get_mut(element).ok_or(NO_SUCH_ELEMENT)?;
        // Its place for quicker gains stays its own, and is empty again.
        own.gains.sets = slot.as_ref().and_then(|known| known.gains.sets);
        if let Some(sets) = own.gains.sets.and_then(|place| self.sets.get_mut(usize::from(place))) {
            *sets = Sets::default();
        }
        *slot = Some(own);
        Ok(())
    }

    /// Takes in gains for the time after an alarm; the element has to be known.
    ///
    /// # Errors
    /// Names a number that makes no sense, a time that does not ascend, or what is not known.
    pub fn set_faster(&mut self, config: &FasterConfig, sample_period_s: f32) -> Result<(), ConfigError> {
        let own = self.own.get_mut(usize::from(config.element)).and_then(Option::as_mut).ok_or(NO_SUCH_ELEMENT)?;
        let place = own.gains.sets.unwrap_or(self.quick);
        let problem = Problem::OutOfRange { least: 0.0, most: QUICK as f32 };
        let sets = self.sets.get_mut(usize::from(place));
        sets.ok_or(ConfigError { parameter: Parameter::Parts, problem })?.set(config, sample_period_s)?;
        if own.gains.sets.replace(place).is_none() {
            self.quick += 1;
        }
        Ok(())
    }

    /// Takes in a pair of elements; both have to be known.
    ///
    /// # Errors
    /// Names a number that is not finite, rates that do not ascend, an element that is not known or the same twice, or one pair too many.
    pub fn set_cross(&mut self, config: &CrossConfig, sample_period_s: f32) -> Result<(), ConfigError> {
        let known = |element: u8| self.own.get(usize::from(element)).is_some_and(Option::is_some);
        if config.from == config.to || !known(config.from) || !known(config.to) {
            return Err(NO_SUCH_ELEMENT);
        }
        let cross = Cross::new(config, sample_period_s)?;
        let same = |slot: &Option<Cross>| slot.is_none_or(|known| (known.from, known.to) == (cross.from, cross.to));
        let most = CROSSES as f32;
        let full =
            ConfigError { parameter: Parameter::CrossHeating, problem: Problem::OutOfRange { least: 0.0, most } };
        *self.cross.iter_mut().find(|slot| same(slot)).ok_or(full)? = Some(cross);
        Ok(())
    }

    /// Whether an element is part of it.
    pub fn knows(&self, element: usize) -> bool {
        self.own.get(element).is_some_and(Option::is_some)
    }

    /// One tick. Before all elements of the network have been read once, there is no answer; nor when its numbers have run away or are none:
    /// then it begins anew.
    pub fn step(&self, state: &mut NetworkState<N>, look: &Look<'_, N>) -> Option<Convection<N>> {
        if !state.begun {
            self.begin(state, look)?;
        }
        let warmed_k = self.cross_heating_k(state);
        let mut convection = Convection { power_w: [0.0; N], surface_c: [0.0; N], variance_w2: [0.0; N] };
        let mut size = 0.0;
        for (i, own) in self.own.iter().enumerate() {
            let Some(own) = own else { continue };
            // There are no more; said for the compiler, which else leaves a panic here.
            if i >= N {
                break;
            }
            let base_c = own.rest_c + warmed_k[i];
            let x = &mut state.own[i];
            let level = usize::from(look.read_high >> i & 1);
            let mut error_k = 0.0;
            if look.valid >> i & 1 == 1 {
                error_k = look.temperature_c[i] - base_c - own.symbol.output(x);
            }
            let sets = own.gains.sets.and_then(|place| self.sets.get(usize::from(place)));
            let gains = own.gains.at(sets, &mut state.watch[i], error_k, level);
            let innovation_k = gains.weights[level] * error_k;
            let q = state.convection_w[i] - gains.convection_w_per_k * innovation_k;
            convection.variance_w2[i] = gains.variance_w2;
            state.convection_w[i] = q;
            convection.power_w[i] = q;
            convection.surface_c[i] = base_c + own.surface_k_per_w.output(x);
            size += q.abs() + convection.surface_c[i].abs();
            let inputs = core::array::from_fn(|k| {
                look.power_w[i] - own.surface[k] * q + gains.correction_w_per_k[k] * innovation_k
            });
            own.relaxations.step_each(x, &inputs);
        }
        for (cross, x) in self.cross.iter().zip(&mut state.cross) {
            let Some(cross) = cross else { break };
            let Some(from) = cross.source::<N>() else { break };
            let (power_w, q) = (look.power_w[from], convection.power_w[from]);
            cross.relaxations.step_each(x, &core::array::from_fn(|k| power_w - cross.surface[k] * q));
        }
        if size.is_nan() || size > RUN_AWAY {
            *state = NetworkState::default();
            return None;
        }
        Some(convection)
    }

    /// What every element is warmer by the heat of the others, K.
    fn cross_heating_k(&self, state: &NetworkState<N>) -> [f32; N] {
        let mut warmed_k = [0.0; N];
        for (cross, x) in self.cross.iter().zip(&state.cross) {
            let Some(cross) = cross else { break };
            if let Some(warmed_k) = warmed_k.get_mut(usize::from(cross.to)) {
                *warmed_k += cross.symbol.output(x);
            }
        }
        warmed_k
    }

    /// Whether it has begun to follow its elements.
    pub const fn has_begun(&self, state: &NetworkState<N>) -> bool {
        state.begun
    }

    /// Ticks in which its slowest relaxation loses all but 1/e of what it was.
    pub fn slowest_ticks(&self) -> f32 {
        let own = self.own.iter().flatten().map(|own| own.relaxations.gain()[0]);
        let cross = self.cross.iter().flatten().map(|cross| cross.relaxations.gain()[0]);
        1.0 / own.chain(cross).fold(1.0, f32::min)
    }

    /// States of a head that has stood for long as it is now: q from T = rest + H(0) P − H(0) m q, after Gauss and Seidel.
    fn begin(&self, state: &mut NetworkState<N>, look: &Look<'_, N>) -> Option<()> {
        let all = self.own.iter().enumerate().all(|(i, own)| own.is_none() || look.valid >> i & 1 == 1);
        if !all || self.own.iter().all(Option::is_none) {
            return None;
        }
        let mut beginning = NetworkState { begun: true, ..NetworkState::default() };
        self.settle(&mut beginning, look);
        let warmed_k = self.cross_heating_k(&beginning);
        // By how much each would be warmer without convection.
        let too_warm_k: [f32; N] = core::array::from_fn(|i| {
            let Some(own) = &self.own[i] else { return 0.0 };
            own.rest_c + warmed_k[i] + own.symbol.output(&beginning.own[i]) - look.temperature_c[i]
        });
        let q = &mut beginning.convection_w;
        for _ in 0..ROUNDS {
            for (i, own) in self.own.iter().enumerate() {
                let Some(own) = own.as_ref().filter(|own| own.gains.convects()) else { continue };
                let mut left_k = too_warm_k[i];
                for cross in self.cross.iter().map_while(Option::as_ref).filter(|cross| usize::from(cross.to) == i) {
                    let Some(from) = cross.source::<N>() else { break };
                    left_k -= cross.surface_k_per_w.steady_gain_k_per_w() * q[from];
                }
                q[i] = left_k / own.surface_k_per_w.steady_gain_k_per_w();
            }
        }
        self.settle(&mut beginning, look);
        *state = beginning;
        Some(())
    }

    /// The states that the standing powers and the convection lead to in the end.
    fn settle(&self, state: &mut NetworkState<N>, look: &Look<'_, N>) {
        for (i, own) in self.own.iter().enumerate() {
            let Some(own) = own else { continue };
            state.own[i].x = own.surface.map(|m| look.standing_w[i] - m * state.convection_w[i]);
        }
        for (cross, x) in self.cross.iter().zip(&mut state.cross) {
            let Some(cross) = cross else { break };
            let Some(from) = cross.source::<N>() else { break };
            x.x = cross.surface.map(|m| look.standing_w[from] - m * state.convection_w[from]);
        }
    }

    /// Of how many pieces its tables are: elements, pairs, quicker gains.
    pub(crate) const PIECES: usize = N + CROSSES + QUICK;

    /// The seal of one piece of its tables.
    pub(crate) fn seal_of(&self, piece: usize) -> Seal {
        let seal = |of: &dyn Fn() -> Option<Seal>| of().unwrap_or_default();
        match piece {
            own if own < N => seal(&|| Some(Seal::of(self.own.get(own)?))),
            cross if cross < N + CROSSES => seal(&|| Some(Seal::of(self.cross.get(cross - N)?))),
            sets => seal(&|| Some(Seal::of(self.sets.get(sets - N - CROSSES)?))),
        }
    }

    /// Hands every number of a state to `take`, in a fixed order.
    pub(crate) fn each(&self, state: &NetworkState<N>, take: &mut impl FnMut(f32)) {
        for (i, own) in self.own.iter().enumerate() {
            if own.is_some() {
                let x = &state.own[i];
                x.x.iter().chain(&x.excess).for_each(|&number| take(number));
                take(state.convection_w[i]);
                take(state.watch[i].smoothed_k);
            }
        }
        for (cross, x) in self.cross.iter().zip(&state.cross) {
            if cross.is_some() {
                x.x.iter().chain(&x.excess).for_each(|&number| take(number));
            }
        }
    }
}

const NO_SUCH_ELEMENT: ConfigError = ConfigError { parameter: Parameter::PartElement, problem: Problem::Missing };

impl Own {
    fn new(config: &OwnConfig, sample_period_s: f32) -> Result<Self, ConfigError> {
        for share in config.surface {
            error::within(Parameter::SurfaceShare, share, -10.0, 10.0)?;
        }
        let symbol = Symbol::new(config.r_k_per_w)?;
        let surface_k_per_w = Symbol::new(core::array::from_fn(|k| config.r_k_per_w[k] * config.surface[k]))?;
        error::positive(Parameter::ResistanceKPerW, surface_k_per_w.steady_gain_k_per_w())?;
        Ok(Self {
            relaxations: Relaxations::new(&config.mesh_rad_s, sample_period_s)?,
            surface_k_per_w,
            symbol,
            surface: config.surface,
            rest_c: error::finite(Parameter::ReferenceC, config.rest_c)?,
            gains: Adaptive::new(&config.gains, config.alarm.as_ref(), sample_period_s)?,
        })
    }
}

impl Cross {
    /// The element that heats. Always one of N, as it is known to the network; the compiler cannot see that, and would leave a panic here.
    fn source<const N: usize>(&self) -> Option<usize> {
        Some(usize::from(self.from)).filter(|&from| from < N)
    }

    fn new(config: &CrossConfig, sample_period_s: f32) -> Result<Self, ConfigError> {
        for share in config.surface {
            error::within(Parameter::SurfaceShare, share, -10.0, 10.0)?;
        }
        Ok(Self {
            from: config.from,
            to: config.to,
            relaxations: Relaxations::new(&config.mesh_rad_s, sample_period_s)?,
            symbol: Symbol::new(config.r_k_per_w)?,
            surface_k_per_w: Symbol::new(core::array::from_fn(|k| config.r_k_per_w[k] * config.surface[k]))?,
            surface: config.surface,
        })
    }
}

sealable!(Own { relaxations, symbol, surface_k_per_w, surface, rest_c, gains });
sealable!(Cross { from, to, relaxations, symbol, surface_k_per_w, surface });

#[cfg(test)]
mod tests;
