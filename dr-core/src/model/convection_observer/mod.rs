//! Observer of the convective power of each element, over the quiescent-gas network of a head.
//!
//! The network has the self-heating of all elements and their cross-heating, as identified in
//! quiescent gas. The wind is the only input that it does not contain (wind as feedback, for
//! several elements). Every tick corrects the states by the measured temperatures; the power that
//! has to be removed for that is the convective power:
//!
//! ```text
//! e_i  = s_i/s̄_i (T_i − rest_i − Σ_k R_k^ii x_k^ii − Σ_j Σ_k R_k^ij x_k^ij)
//! q_i  ← q_i − ℓ_i e_i
//! x_k^ii ← x_k^ii + g_k (P_i − m_k q_i + c_k e_i − x_k^ii)
//! x_k^ij ← x_k^ij + g_k (P_j − m_k q_j + c_k' e_j − x_k^ij)    k' of j, whose rate is nearest
//! Ts_i = rest_i + Σ_k R_k^ii m_k x_k^ii + Σ_j Σ_k R_k^ij x_k^ij
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | q | convective power: convective loss beyond that in quiescent gas; of a core its unknown heat | W |
//! | e | innovation, weighted by s: a reading at the high level has a larger voltage and less noise | K |
//! | s̄ | mean weight of the last readings: it keeps the bandwidth at any duty cycle (`gains`) | |
//! | ℓ, c_k, s | gains and weights of a steady-state Kalman filter for which q is a random walk; they set the bandwidth | W/K |
//! | m_k | share of heat at the surface in relaxation k | |
//! | Ts | temperature of the surface | °C |
//!
//! P − q is the equivalent control of the quiescent-gas network: the conduction into its structure.
//! In a mode k of a network the temperatures of two nodes have a fixed ratio; m_k is the ratio of
//! surface to element. Heat that the surface loses enters the mode with the factor m_k, and the
//! surface temperature is read from it with the same factor. If the element is soldered to the
//! surface, m_k is nearly 1 up to the rate of that contact; without m_k, q would lag by the time
//! constant of the contact.
//!
//! A correction c e_j is heat that the model of element j has missed, and so it warms the others,
//! too. Without it, what q_j was late after a jump stays in their models until it has left the
//! structure, and in q: of a jump 0.6 % for minutes, for three films on a tube at 1 Hz; with it
//! 10⁻⁵ after 3 s. An element with ℓ = 0 is corrected by state and not by heat, and so this is not
//! done for it.
//!
//! q of an element without a surface, a core, is heat that it loses on ways that the identification
//! did not have, as to a support at another temperature.
//!
//! Pairs of one heated element with the same rates and shares have the same x_k^ij, which are kept
//! and stepped once.
//!
//! **Alarm.** A fixed bandwidth is a compromise between noise and delay. The smoothed innovation is
//! small while the wind changes as the filter assumes. Beyond a threshold the wind has changed
//! abruptly, and the gains become those of the fastest of several sets. Slower sets follow, each as
//! soon as the one before it has settled, until the steady gains apply again. A time t after the
//! alarm the noise is then about the least that is possible with data of length t. The reported
//! variance follows the gains.
//!
//! Limits: linear. For cross-heating, m of the heated element is taken as 1, which holds for slow
//! modes; others are small there. `+ − × ÷` on f32 in fixed order.

pub mod config;
mod gains;

use super::relaxation::{RelaxationState, Relaxations};
use super::self_heating::ORDER;
use super::symbol::Symbol;
use crate::checksum::Checksum;
use crate::error::{self, ConfigError, Parameter, ParameterProblem};
use crate::fields::{FieldVisitor, Fields};
use config::{
    CROSS_ORDER, FASTER_ELEMENTS, FasterGainsConfig, MOST_PAIRS, NetworkCrossHeatingConfig, NetworkSelfHeatingConfig,
};
use gains::{AdaptiveGains, GainSets, InnovationMonitor};

/// Rounds of the correction that finds the initial convective power. Four sectors that share a
/// third of their heat gain half a digit per round; the observer corrects the rest.
const ROUNDS: usize = 12;

/// Sum of the magnitudes of powers, W, and temperatures, °C, above which the observer has diverged.
const RUN_AWAY: f32 = 1e6;

/// Self-heating of an element, prepared for one sample period.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
struct NetworkSelfHeating {
    relaxations: Relaxations<ORDER>,
    symbol: Symbol<ORDER>,
    /// R_k m_k
    surface_k_per_w: Symbol<ORDER>,
    surface: [f32; ORDER],
    rest_c: f32,
    gains: AdaptiveGains,
}

/// Cross-heating of a pair, prepared for one sample period.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
struct NetworkCrossHeating {
    from: u8,
    to: u8,
    /// Number of the first pair of the same element with the same rates and shares: its states are
    /// those of this pair, too.
    states: u16,
    relaxations: Relaxations<CROSS_ORDER>,
    symbol: Symbol<CROSS_ORDER>,
    /// R_k m_k
    surface_k_per_w: Symbol<CROSS_ORDER>,
    surface: [f32; CROSS_ORDER],
    /// k': the relaxations of `from` that are nearest.
    nearest: [u8; CROSS_ORDER],
}

/// The observer over N elements at a fixed sample period. Elements without a
/// [`NetworkSelfHeatingConfig`] are not part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvectionObserver<const N: usize> {
    self_heating: [Option<NetworkSelfHeating>; N],
    cross_heating: [Option<NetworkCrossHeating>; MOST_PAIRS],
    /// Faster gains of elements that have them, in the order of their set-up.
    sets: [GainSets; FASTER_ELEMENTS],
    faster_elements: u8,
}

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvectionObserverState<const N: usize> {
    self_heating: [RelaxationState<ORDER>; N],
    cross_heating: [RelaxationState<CROSS_ORDER>; MOST_PAIRS],
    /// q, W.
    convection_w: [f32; N],
    monitor: [InnovationMonitor; N],
    /// All elements have been read at least once, so that the states have been initialised.
    initialised: bool,
}

impl<const N: usize> ConvectionObserverState<N> {
    /// q of an element, W; none before the states have been initialised.
    pub fn convection_w(&self, element: usize) -> Option<f32> {
        self.convection_w.get(element).copied().filter(|_| self.initialised)
    }
}

/// Inputs of the observer at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickInput<'a, const N: usize> {
    /// Temperatures, °C.
    pub temperature_c: &'a [f32; N],
    /// Bit i is set if element i was read.
    pub valid: usize,
    /// Bit i is set if element i was at its high level while it was read.
    pub read_high: usize,
    /// Heating powers from this tick to the next, W.
    pub power_w: &'a [f32; N],
    /// Powers under which the head has stood for long, W. For the initial state only.
    pub standing_w: &'a [f32; N],
}

/// Convective powers and surface temperatures at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvectionEstimate<const N: usize> {
    /// q: convective power beyond that in quiescent gas, W.
    pub power_w: [f32; N],
    /// Ts: temperatures of the surfaces, °C.
    pub surface_c: [f32; N],
    /// Variances of q by the noise of the readings, W².
    pub variance_w2: [f32; N],
}

impl<const N: usize> Default for ConvectionObserver<N> {
    fn default() -> Self {
        Self {
            self_heating: [None; N],
            cross_heating: [None; MOST_PAIRS],
            sets: [GainSets::default(); FASTER_ELEMENTS],
            faster_elements: 0,
        }
    }
}

impl<const N: usize> Default for ConvectionObserverState<N> {
    /// Before the first reading.
    fn default() -> Self {
        Self {
            self_heating: [RelaxationState::default(); N],
            cross_heating: [RelaxationState::default(); MOST_PAIRS],
            convection_w: [0.0; N],
            monitor: [InnovationMonitor::default(); N],
            initialised: false,
        }
    }
}

impl<const N: usize> ConvectionObserver<N> {
    /// Sets the self-heating of an element.
    ///
    /// # Errors
    /// Names a number that is not finite, rates that do not ascend, a steady gain or a weight that
    /// is not greater than zero, or no such element.
    pub fn set_self_heating(
        &mut self,
        element: usize,
        config: &NetworkSelfHeatingConfig,
        sample_period_s: f32,
    ) -> Result<(), ConfigError> {
        let mut own = NetworkSelfHeating::new(config, sample_period_s)?;
        let slot = self.self_heating.get_mut(element).ok_or(NO_SUCH_ELEMENT)?;
        // The element keeps its place for faster gains, which is cleared.
        own.gains.sets = slot.as_ref().and_then(|known| known.gains.sets);
        if let Some(sets) = own.gains.sets.and_then(|place| self.sets.get_mut(usize::from(place))) {
            *sets = GainSets::default();
        }
        *slot = Some(own);
        for cross in self.cross_heating.iter_mut().flatten().filter(|cross| usize::from(cross.from) == element) {
            cross.nearest = own.nearest(&cross.relaxations);
        }
        Ok(())
    }

    /// Sets faster gains for the time after an alarm; the element must have been set.
    ///
    /// # Errors
    /// Names a number that makes no sense, a time that does not ascend, or what is not known.
    pub fn set_faster_gains(&mut self, config: &FasterGainsConfig, sample_period_s: f32) -> Result<(), ConfigError> {
        let own =
            self.self_heating.get_mut(usize::from(config.element)).and_then(Option::as_mut).ok_or(NO_SUCH_ELEMENT)?;
        let place = own.gains.sets.unwrap_or(self.faster_elements);
        let full = error::out_of_range(Parameter::Parts, 0.0, FASTER_ELEMENTS as f32);
        let seen_k_per_w = seen_k_per_w(&own.symbol, &own.relaxations);
        self.sets.get_mut(usize::from(place)).ok_or(full)?.set(config, &seen_k_per_w, sample_period_s)?;
        if own.gains.sets.replace(place).is_none() {
            self.faster_elements += 1;
        }
        Ok(())
    }

    /// Sets the cross-heating of a pair of elements; both must have been set.
    ///
    /// # Errors
    /// Names a number that is not finite, rates that do not ascend, an element that is not known or
    /// the same twice, or one pair too many.
    pub fn set_cross_heating(
        &mut self,
        config: &NetworkCrossHeatingConfig,
        sample_period_s: f32,
    ) -> Result<(), ConfigError> {
        if config.from == config.to || ![config.from, config.to].iter().all(|&element| self.knows(element.into())) {
            return Err(NO_SUCH_ELEMENT);
        }
        let mut cross = NetworkCrossHeating::new(config, sample_period_s)?;
        if let Some(Some(from)) = self.self_heating.get(usize::from(config.from)) {
            cross.nearest = from.nearest(&cross.relaxations);
        }
        let same = |slot: &Option<NetworkCrossHeating>| {
            slot.is_none_or(|known| (known.from, known.to) == (cross.from, cross.to))
        };
        let full = error::out_of_range(Parameter::CrossHeating, 0.0, MOST_PAIRS as f32);
        *self.cross_heating.iter_mut().find(|slot| same(slot)).ok_or(full)? = Some(cross);
        self.share_states(cross.from);
        Ok(())
    }

    /// Finds out anew which pairs of an element share their states.
    fn share_states(&mut self, from: u8) {
        for place in 0..MOST_PAIRS {
            let Some(cross) = self.cross_heating[place].filter(|cross| cross.from == from) else { continue };
            let first = self.cross_heating.iter().position(|slot| {
                slot.is_some_and(|known| {
                    known.from == from && known.relaxations == cross.relaxations && known.surface == cross.surface
                })
            });
            // It finds itself at least; there are fewer pairs than 65 536.
            self.cross_heating[place] = Some(NetworkCrossHeating { states: first.unwrap_or(place) as u16, ..cross });
        }
    }

    /// Tells whether an element is part of the network.
    pub fn knows(&self, element: usize) -> bool {
        self.self_heating.get(element).is_some_and(Option::is_some)
    }

    /// One tick. Returns nothing before all elements of the network have been read once, and when
    /// the observer has diverged: then it is initialised anew.
    pub fn step(
        &self,
        state: &mut ConvectionObserverState<N>,
        input: &TickInput<'_, N>,
    ) -> Option<ConvectionEstimate<N>> {
        if !state.initialised {
            self.initialise(state, input)?;
        }
        let warmed_k = self.cross_heating_k(state);
        let mut convection = ConvectionEstimate { power_w: [0.0; N], surface_c: [0.0; N], variance_w2: [0.0; N] };
        let mut missed_w = [[0.0; ORDER]; N];
        let mut size = 0.0;
        for (i, own) in self.self_heating.iter().enumerate() {
            let Some(own) = own else { continue };
            // Never true. The check lets the compiler drop a panic.
            if i >= N {
                break;
            }
            let base_c = own.rest_c + warmed_k[i];
            let x = &mut state.self_heating[i];
            let level = input.read_high >> i & 1;
            let mut error_k = 0.0;
            if input.valid >> i & 1 == 1 {
                error_k = input.temperature_c[i] - base_c - own.symbol.output(x);
                own.gains.weigh(&mut state.monitor[i], level);
            }
            let sets = own.gains.sets.and_then(|place| self.sets.get(usize::from(place)));
            let gains = own.gains.at(sets, &mut state.monitor[i], error_k, level);
            let mean_weight = state.monitor[i].mean_weight;
            let innovation_k = gains.weight(mean_weight, level) * error_k;
            let gains = &gains.of;
            let q = state.convection_w[i] - gains.convection_w_per_k * innovation_k;
            convection.variance_w2[i] = gains.variance_w2 / mean_weight;
            state.convection_w[i] = q;
            convection.power_w[i] = q;
            convection.surface_c[i] = base_c + own.surface_k_per_w.output(x);
            size += q.abs() + convection.surface_c[i].abs();
            let correction_w = gains.correction_w_per_k.map(|c| c * innovation_k);
            let inputs = core::array::from_fn(|k| input.power_w[i] - own.surface[k] * q + correction_w[k]);
            own.relaxations.step_each(x, &inputs);
            if own.gains.convects() {
                missed_w[i] = correction_w;
            }
        }
        for (place, (cross, x)) in self.cross_heating.iter().zip(&mut state.cross_heating).enumerate() {
            let Some(cross) = cross else { break };
            if usize::from(cross.states) != place {
                continue;
            }
            let Some(from) = cross.source::<N>() else { break };
            let (power_w, q, missed_w) = (input.power_w[from], convection.power_w[from], &missed_w[from]);
            let missed = |k: usize| missed_w.get(usize::from(cross.nearest[k])).copied().unwrap_or(0.0);
            cross.relaxations.step_each(x, &core::array::from_fn(|k| power_w - cross.surface[k] * q + missed(k)));
        }
        if size.is_nan() || size > RUN_AWAY {
            *state = ConvectionObserverState::default();
            return None;
        }
        Some(convection)
    }

    /// Temperature rise of every element by cross-heating, K.
    fn cross_heating_k(&self, state: &ConvectionObserverState<N>) -> [f32; N] {
        let mut warmed_k = [0.0; N];
        for cross in self.cross_heating.iter().map_while(Option::as_ref) {
            if let (Some(warmed_k), Some(x)) = (warmed_k.get_mut(usize::from(cross.to)), cross.states(state)) {
                *warmed_k += cross.symbol.output(x);
            }
        }
        warmed_k
    }

    /// Tells whether the states have been initialised.
    pub const fn is_initialised(&self, state: &ConvectionObserverState<N>) -> bool {
        state.initialised
    }

    /// Ticks in which its slowest relaxation loses all but 1/e of what it was.
    pub fn slowest_ticks(&self) -> f32 {
        let own = self.self_heating.iter().flatten().map(|own| own.relaxations.gain()[0]);
        let cross = self.cross_heating.iter().flatten().map(|cross| cross.relaxations.gain()[0]);
        1.0 / own.chain(cross).fold(1.0, f32::min)
    }

    /// Initial state: a head in steady state at the present temperatures, q from T = rest + H(0) P
    /// − H(0) m q, after Gauss and Seidel.
    fn initialise(&self, state: &mut ConvectionObserverState<N>, input: &TickInput<'_, N>) -> Option<()> {
        let all = self.self_heating.iter().enumerate().all(|(i, own)| own.is_none() || input.valid >> i & 1 == 1);
        if !all || self.self_heating.iter().all(Option::is_none) {
            return None;
        }
        let mut initial = ConvectionObserverState { initialised: true, ..ConvectionObserverState::default() };
        self.settle(&mut initial, input);
        let warmed_k = self.cross_heating_k(&initial);
        // Excess temperature of each element without convection.
        let too_warm_k: [f32; N] = core::array::from_fn(|i| {
            let Some(own) = &self.self_heating[i] else { return 0.0 };
            own.rest_c + warmed_k[i] + own.symbol.output(&initial.self_heating[i]) - input.temperature_c[i]
        });
        // Rise of the element of each row by heat at the surface of each column, K/W.
        let mut steady_k_per_w = [[0.0; N]; N];
        for (i, own) in self.self_heating.iter().enumerate() {
            steady_k_per_w[i][i] = own.as_ref().map_or(0.0, |own| own.surface_k_per_w.steady_gain_k_per_w());
        }
        for cross in self.cross_heating.iter().map_while(Option::as_ref) {
            if let (Some(row), Some(from)) = (steady_k_per_w.get_mut(usize::from(cross.to)), cross.source::<N>()) {
                row[from] = cross.surface_k_per_w.steady_gain_k_per_w();
            }
        }
        let q = &mut initial.convection_w;
        for _ in 0..ROUNDS {
            for (i, own) in self.self_heating.iter().enumerate() {
                if own.as_ref().is_none_or(|own| !own.gains.convects()) {
                    continue;
                }
                let others = steady_k_per_w[i].iter().zip(&*q).enumerate().filter(|(j, _)| *j != i);
                let left_k = others.fold(too_warm_k[i], |left_k, (_, (k_per_w, q))| left_k - k_per_w * q);
                q[i] = left_k / steady_k_per_w[i][i];
            }
        }
        self.settle(&mut initial, input);
        *state = initial;
        Some(())
    }

    /// Sets the states to the steady state of standing powers and convection.
    fn settle(&self, state: &mut ConvectionObserverState<N>, input: &TickInput<'_, N>) {
        for (i, own) in self.self_heating.iter().enumerate() {
            let Some(own) = own else { continue };
            state.self_heating[i].x = own.surface.map(|m| input.standing_w[i] - m * state.convection_w[i]);
        }
        for (cross, x) in self.cross_heating.iter().zip(&mut state.cross_heating) {
            let Some(cross) = cross else { break };
            let Some(from) = cross.source::<N>() else { break };
            x.x = cross.surface.map(|m| input.standing_w[from] - m * state.convection_w[from]);
        }
    }

    /// Number of pieces for the integrity check: elements, pairs two by two, faster gains.
    pub(crate) const PIECES: usize = N + MOST_PAIRS.div_ceil(2) + FASTER_ELEMENTS;

    /// The checksum of one piece.
    pub(crate) fn piece_checksum(&self, piece: usize) -> Checksum {
        let checksum = |of: &dyn Fn() -> Option<Checksum>| of().unwrap_or_default();
        match piece {
            own if own < N => checksum(&|| Some(Checksum::of(self.self_heating.get(own)?))),
            cross if cross < N + MOST_PAIRS.div_ceil(2) => checksum(&|| {
                let first = 2 * (cross - N);
                Some(Checksum::of(&(self.cross_heating.get(first)?, self.cross_heating.get(first + 1))))
            }),
            sets => checksum(&|| Some(Checksum::of(self.sets.get(sets - N - MOST_PAIRS.div_ceil(2))?))),
        }
    }

    /// Passes every number of a state that is in use to a visitor, in a fixed order.
    pub(crate) fn visit_state(&self, state: &ConvectionObserverState<N>, visitor: &mut impl FieldVisitor) {
        let ConvectionObserverState { self_heating, convection_w, monitor, .. } = state;
        let each = self_heating.iter().zip(convection_w).zip(monitor).zip(&self.self_heating);
        for (((own, convection_w), InnovationMonitor { smoothed_k, calm_ticks: _, mean_weight }), config) in each {
            if config.is_some() {
                own.visit(visitor);
                [*convection_w, *smoothed_k, *mean_weight].visit(visitor);
            }
        }
        let pairs = self.cross_heating.iter().map_while(Option::as_ref);
        pairs.filter_map(|cross| cross.states(state)).for_each(|states| states.visit(visitor));
    }
}

/// An element that the network does not have.
pub(crate) const NO_SUCH_ELEMENT: ConfigError =
    ConfigError { parameter: Parameter::PartElement, problem: ParameterProblem::Missing };

/// Effect of a power of one tick on the temperature by each relaxation, K/W.
fn seen_k_per_w(symbol: &Symbol<ORDER>, relaxations: &Relaxations<ORDER>) -> [f32; ORDER] {
    core::array::from_fn(|k| symbol.r_k_per_w()[k] * relaxations.gain()[k])
}

impl NetworkSelfHeating {
    fn new(config: &NetworkSelfHeatingConfig, sample_period_s: f32) -> Result<Self, ConfigError> {
        for share in config.surface {
            error::within(Parameter::SurfaceShare, share, -10.0, 10.0)?;
        }
        let symbol = Symbol::new(config.r_k_per_w)?;
        let surface_k_per_w = Symbol::new(core::array::from_fn(|k| config.r_k_per_w[k] * config.surface[k]))?;
        error::positive(Parameter::ResistanceKPerW, surface_k_per_w.steady_gain_k_per_w())?;
        let relaxations = Relaxations::new(&config.mesh_rad_s, sample_period_s)?;
        let seen_k_per_w = seen_k_per_w(&symbol, &relaxations);
        Ok(Self {
            relaxations,
            surface_k_per_w,
            symbol,
            surface: config.surface,
            rest_c: error::finite(Parameter::ReferenceC, config.rest_c)?,
            gains: AdaptiveGains::new(&config.gains, config.alarm.as_ref(), &seen_k_per_w, sample_period_s)?,
        })
    }

    /// By relaxation of a pair, the one of this element whose rate is nearest; those without a
    /// resistance only fill places.
    fn nearest(&self, of_pair: &Relaxations<CROSS_ORDER>) -> [u8; CROSS_ORDER] {
        of_pair.gain().map(|gain| {
            let (mut nearest, mut least) = (0, f32::INFINITY);
            for (k, (own, r)) in self.relaxations.gain().iter().zip(self.symbol.r_k_per_w()).enumerate() {
                let apart = if *own > gain { own / gain } else { gain / own };
                if *r != 0.0 && apart < least {
                    // K is 8.
                    (nearest, least) = (k as u8, apart);
                }
            }
            nearest
        })
    }
}

impl NetworkCrossHeating {
    /// The element that heats. Always one of N; the check lets the compiler drop a panic.
    fn source<const N: usize>(&self) -> Option<usize> {
        Some(usize::from(self.from)).filter(|&from| from < N)
    }

    /// The states of this pair.
    fn states<'a, const N: usize>(
        &self,
        of: &'a ConvectionObserverState<N>,
    ) -> Option<&'a RelaxationState<CROSS_ORDER>> {
        of.cross_heating.get(usize::from(self.states))
    }

    fn new(config: &NetworkCrossHeatingConfig, sample_period_s: f32) -> Result<Self, ConfigError> {
        for share in config.surface {
            error::within(Parameter::SurfaceShare, share, -10.0, 10.0)?;
        }
        Ok(Self {
            from: config.from,
            to: config.to,
            states: 0,
            relaxations: Relaxations::new(&config.mesh_rad_s, sample_period_s)?,
            symbol: Symbol::new(config.r_k_per_w)?,
            surface_k_per_w: Symbol::new(core::array::from_fn(|k| config.r_k_per_w[k] * config.surface[k]))?,
            surface: config.surface,
            nearest: [0; CROSS_ORDER],
        })
    }
}

#[cfg(test)]
mod tests;
