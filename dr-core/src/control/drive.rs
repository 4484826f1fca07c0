//! Drives of one element's heater, tick by tick.
//!
//! | drive | decision at t_n | experiment of the thesis |
//! |---|---|---|
//! | `Passive` | low: it only senses | passive dice, reference element |
//! | `Level` | constant current | CCA, constant-current anemometry |
//! | `Power` | first-order sigma-delta on the wanted mean power | CPA, constant power |
//! | `Temperature` | high if T_n < target, else low (thermal sigma-delta) | CTA, constant temperature |
//! | `Prbs` | next bit of a pseudo-random sequence | open-loop identification |
//! | `Setpoints` | as `Temperature`, the target drawn anew every dwell | identification of the boom |
//! | `Alternation` | as `Temperature`, the target one of two in turn | none: heat beside the wind shows by it |
//! | `SecondOrder` | high if the error and `gain_per_tick` times its sum are above zero | second-order charge control |
//!
//! In `Temperature` the thermal structure itself is the integrator, and the mean of the bits is the
//! power it takes. `SecondOrder` adds an integrator that leaks nothing, so that the mean error goes
//! to zero where a loop of first order locks to a periodic stream of bits.
//!
//! An element is a heated resistor, whose temperature is held, or a MEMS capacitor, whose voltage
//! shift is: set-points are in °C or in V, mean powers in W or in symbols of −1 and +1.

use crate::error::{self, ConfigError, Parameter};
use crate::fields::{FieldVisitor, Fields};
use crate::sensor::Level;
use crate::signal::{Prbs, SigmaDelta};

/// Length of the register that draws random set-points. 2³¹ − 1 draws do not repeat in an
/// instrument's life.
const SETPOINT_REGISTER: u8 = 31;

/// Bits drawn for one set-point: a range of 17 °C comes in steps of 0.26 mK, under any reading's
/// noise.
const SETPOINT_BITS: u32 = 16;

/// Steps of that register before the first draw.
const WARM_UP_STEPS: u32 = 8 * SETPOINT_REGISTER as u32;

/// An element's drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Drive {
    /// Senses at the low current.
    #[default]
    Passive,
    /// Holds one level.
    Level(Level),
    /// Constant mean power by an open-loop sigma-delta between the levels.
    Power {
        /// Mean power, W; of a capacitor, mean symbol.
        power_w: f32,
    },
    /// Constant temperature by the thermal sigma-delta loop.
    Temperature {
        /// Set-point, °C; of a capacitor, V.
        target_c: f32,
    },
    /// Pseudo-random levels.
    Prbs {
        /// Register length n, 2 … 32.
        order: u8,
        /// Where the register starts; not all ones.
        seed: u32,
        /// Ticks that one bit lasts, at least 1.
        ticks_per_bit: u32,
    },
    /// Random set-points of constant temperature.
    Setpoints {
        /// Lowest set-point, °C.
        low_c: f32,
        /// Highest set-point, °C.
        high_c: f32,
        /// Ticks that one set-point lasts, at least 1.
        dwell_ticks: u32,
        /// Where the drawing register starts.
        seed: u32,
    },
    /// Two set-points of constant temperature in turn, the highest first: the overheat alternates.
    Alternation {
        /// Lowest set-point, °C.
        low_c: f32,
        /// Highest set-point, °C.
        high_c: f32,
        /// Ticks that each lasts, at least 1.
        half_ticks: u32,
    },
    /// A set-point by a loop of second order. It begins to integrate when it has first crossed the
    /// set-point, so that the way there adds nothing.
    SecondOrder {
        /// Set-point, °C; of a capacitor, V.
        target: f32,
        /// Weight of the sum of the errors, one a tick, beside the error itself.
        gain_per_tick: f32,
    },
}

/// Inputs of a drive in one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveInput {
    /// The element's temperature, °C; of a capacitor its voltage shift, V.
    pub measured: f32,
    /// Power that the low level would put in now, W; of a capacitor −1.
    pub low: f32,
    /// Power that the high level would put in now, W; of a capacitor +1.
    pub high: f32,
}

/// State of a drive between ticks. Which fields are in use depends on the drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveState {
    /// Modulator of `Power`; sum of the errors of `SecondOrder`.
    pub modulator: SigmaDelta,
    /// Register of `Prbs` and `Setpoints`.
    pub register: Option<Prbs>,
    /// Ticks left of the bit, the dwell or the half; of `SecondOrder` 0 once it integrates.
    pub ticks_left: u32,
    /// The last requested level.
    pub level: Level,
    /// A drive that controls a mean has requested the same level throughout: if this continues, the
    /// mean is out of reach.
    pub saturated: bool,
    /// The set-point in force, °C or V.
    pub target_c: f32,
}

crate::fields::fields!(enum Drive {
    0 Passive,
    1 Level(level),
    2 Power { power_w },
    3 Temperature { target_c },
    4 Prbs { order, seed, ticks_per_bit },
    5 Setpoints { low_c, high_c, dwell_ticks, seed },
    6 Alternation { low_c, high_c, half_ticks },
    7 SecondOrder { target, gain_per_tick },
});

impl Drive {
    /// Tells whether it can request the high level.
    pub const fn can_heat(&self) -> bool {
        !matches!(self, Self::Passive | Self::Level(Level::Low))
    }

    /// Checks the drive's numbers against the least and greatest set-point of the element that it
    /// is for and gives the state it starts from.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn start(&self, range: (f32, f32)) -> Result<DriveState, ConfigError> {
        let (coldest_c, hottest_c) = range;
        let state = DriveState::default();
        Ok(match *self {
            Self::Passive | Self::Level(_) => state,
            Self::Power { power_w } => {
                error::finite(Parameter::PowerW, power_w)?;
                state
            }
            Self::Temperature { target_c } => {
                DriveState { target_c: error::within(Parameter::TargetC, target_c, coldest_c, hottest_c)?, ..state }
            }
            Self::SecondOrder { target, gain_per_tick } => {
                error::positive(Parameter::GainPerTick, gain_per_tick)?;
                error::within(Parameter::GainPerTick, gain_per_tick, 0.0, 1.0)?;
                let target_c = error::within(Parameter::TargetC, target, coldest_c, hottest_c)?;
                // A first level, and then another one.
                DriveState { target_c, ticks_left: 2, ..state }
            }
            Self::Prbs { order, seed, ticks_per_bit } => {
                at_least_one(Parameter::TicksPerBit, ticks_per_bit)?;
                DriveState { register: Some(Prbs::new(order, seed)?), ..state }
            }
            Self::Alternation { low_c, high_c, half_ticks } => {
                check_pair(low_c, high_c, range)?;
                at_least_one(Parameter::DwellTicks, half_ticks)?;
                // The first tick begins the first half, at the other one.
                DriveState { target_c: low_c, ..state }
            }
            Self::Setpoints { low_c, high_c, dwell_ticks, seed } => {
                check_pair(low_c, high_c, range)?;
                at_least_one(Parameter::DwellTicks, dwell_ticks)?;
                let mut register = Prbs::new(SETPOINT_REGISTER, seed)?;
                // A seed of few ones begins with many: they are let pass.
                for _ in 0..WARM_UP_STEPS {
                    register.step();
                }
                DriveState { register: Some(register), target_c: low_c, ..state }
            }
        })
    }

    /// The state that this drive goes on from in place of another that is in `state`, if it does
    /// not begin with its own: two alternations of one length share their halves, so that
    /// set-points can follow a gas.
    pub fn goes_on(&self, former: &Self, state: &DriveState) -> Option<DriveState> {
        let Self::Alternation { low_c, high_c, half_ticks } = *self else { return None };
        let Self::Alternation { high_c: former_c, half_ticks: former_ticks, .. } = *former else { return None };
        let target_c = if state.target_c == former_c { high_c } else { low_c };
        (half_ticks == former_ticks && state.ticks_left > 0).then_some(DriveState { target_c, ..*state })
    }

    /// The level to hold until the next tick.
    #[inline(always)] // there is one caller; where several controllers are built, that is not seen by itself
    pub fn step(&self, state: &mut DriveState, input: &DriveInput) -> Level {
        let before = state.level;
        state.saturated = false;
        state.level = match *self {
            Self::Passive => Level::Low,
            Self::Level(level) => level,
            Self::Power { power_w } => {
                let share = (power_w - input.low) / (input.high - input.low);
                // R(T) moves the levels: a power that was in reach may leave it. Then the nearest
                // level is all there is.
                state.saturated = !(0.0..=1.0).contains(&share);
                if share <= 0.0 {
                    Level::Low
                } else if share >= 1.0 {
                    Level::High
                } else {
                    level(state.modulator.step(share))
                }
            }
            Self::Temperature { target_c } => {
                let level = level(input.measured < target_c);
                state.saturated = level == before;
                level
            }
            Self::SecondOrder { target, gain_per_tick } => {
                let (error, sum) = (target - input.measured, &mut state.modulator.accumulator);
                let level = level(error + gain_per_tick * *sum > 0.0);
                if state.ticks_left == 0 {
                    *sum += error;
                } else if state.ticks_left > 1 || level != before {
                    state.ticks_left -= 1;
                }
                state.saturated = level == before;
                level
            }
            Self::Prbs { ticks_per_bit, .. } => {
                let mut bit = before;
                if let (0, Some(register)) = (state.ticks_left, &mut state.register) {
                    bit = level(register.step());
                    state.ticks_left = ticks_per_bit;
                }
                state.ticks_left -= u32::from(state.ticks_left > 0);
                bit
            }
            Self::Alternation { low_c, high_c, half_ticks } => {
                if state.ticks_left == 0 {
                    state.target_c = if state.target_c == high_c { low_c } else { high_c };
                    state.ticks_left = half_ticks;
                }
                state.ticks_left -= u32::from(state.ticks_left > 0);
                let level = level(input.measured < state.target_c);
                state.saturated = level == before;
                level
            }
            Self::Setpoints { low_c, high_c, dwell_ticks, .. } => {
                if let (0, Some(register)) = (state.ticks_left, &mut state.register) {
                    let word = (0..SETPOINT_BITS).fold(0_u32, |word, _| word << 1 | u32::from(register.step()));
                    let share = word as f32 / ((1_u32 << SETPOINT_BITS) - 1) as f32;
                    state.target_c = low_c + share * (high_c - low_c);
                    state.ticks_left = dwell_ticks;
                }
                state.ticks_left -= u32::from(state.ticks_left > 0);
                let level = level(input.measured < state.target_c);
                state.saturated = level == before;
                level
            }
        };
        state.level
    }

    /// Passes to a visitor what this drive remembers and decides by.
    pub(crate) fn visit_state(&self, state: &DriveState, visitor: &mut impl FieldVisitor) {
        let DriveState { modulator, register, ticks_left, level, saturated: _, target_c } = state;
        match self {
            Self::Passive | Self::Level(_) | Self::Temperature { .. } => {}
            Self::Power { .. } => modulator.accumulator.visit(visitor),
            Self::SecondOrder { .. } => (modulator.accumulator, *ticks_left).visit(visitor),
            Self::Prbs { .. } => ((register, ticks_left), level).visit(visitor),
            Self::Setpoints { .. } => ((register, ticks_left), target_c).visit(visitor),
            Self::Alternation { .. } => (*ticks_left, *target_c).visit(visitor),
        }
    }

    /// The lowest and highest set-point that the drive will request, °C or V, if it holds any.
    pub const fn target_range_c(&self) -> Option<(f32, f32)> {
        match *self {
            Self::Temperature { target_c: target } | Self::SecondOrder { target, .. } => Some((target, target)),
            Self::Setpoints { low_c, high_c, .. } | Self::Alternation { low_c, high_c, .. } => Some((low_c, high_c)),
            _ => None,
        }
    }
}

/// Two set-points must be some that the element knows, the lowest first.
fn check_pair(low_c: f32, high_c: f32, (coldest_c, hottest_c): (f32, f32)) -> Result<(), ConfigError> {
    error::within(Parameter::LowC, low_c, coldest_c, hottest_c)?;
    error::within(Parameter::HighC, high_c, coldest_c, hottest_c)?;
    error::ascending((Parameter::LowC, low_c), (Parameter::HighC, high_c)).map(drop)
}

const fn level(high: bool) -> Level {
    if high { Level::High } else { Level::Low }
}

fn at_least_one(parameter: Parameter, value: u32) -> Result<(), ConfigError> {
    if value > 0 {
        Ok(())
    } else {
        Err(ConfigError { parameter, problem: crate::error::ParameterProblem::NotPositive })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::checksum::Checksum;
    use std::vec::Vec;

    fn range() -> (f32, f32) {
        crate::sensor::Platinum::linear(175.0, 0.0031).unwrap().range_c()
    }

    fn at(measured: f32) -> DriveInput {
        DriveInput { measured, low: 0.0015, high: 0.0415 }
    }

    fn levels(drive: Drive, ticks: usize) -> Vec<bool> {
        let mut state = drive.start(range()).unwrap();
        (0..ticks).map(|_| drive.step(&mut state, &at(0.0)) == Level::High).collect()
    }

    #[test]
    fn set_points_alternate_from_the_highest_on_and_go_on_where_they_are_moved() {
        let drive = Drive::Alternation { low_c: 20.0, high_c: 30.0, half_ticks: 3 };
        let mut state = drive.start(range()).unwrap();
        let mut step = |drive: &Drive| {
            let level = drive.step(&mut state, &at(25.0));
            (state.target_c, level == Level::High)
        };
        let first: Vec<_> = (0..7).map(|_| step(&drive)).collect();
        let (high, low) = ((30.0, true), (20.0, false));
        assert_eq!(first, [high, high, high, low, low, low, high]);
        // One degree warmer, in the middle of a half.
        let warmer = Drive::Alternation { low_c: 21.0, high_c: 31.0, half_ticks: 3 };
        state = warmer.goes_on(&drive, &state).unwrap();
        let targets: Vec<f32> = (0..4)
            .map(|_| {
                warmer.step(&mut state, &at(25.0));
                state.target_c
            })
            .collect();
        assert_eq!(targets, [31.0, 31.0, 21.0, 21.0]);
        let longer = Drive::Alternation { low_c: 21.0, high_c: 31.0, half_ticks: 4 };
        assert_eq!(longer.goes_on(&warmer, &state), None);
        assert_eq!(warmer.goes_on(&Drive::Temperature { target_c: 31.0 }, &state), None);
        let refused = |drive: Drive| drive.start(range()).unwrap_err().parameter;
        assert_eq!(refused(Drive::Alternation { low_c: 30.0, high_c: 30.0, half_ticks: 3 }), Parameter::HighC);
        assert_eq!(refused(Drive::Alternation { low_c: 20.0, high_c: 1e4, half_ticks: 3 }), Parameter::HighC);
        assert_eq!(refused(Drive::Alternation { low_c: 20.0, high_c: 30.0, half_ticks: 0 }), Parameter::DwellTicks);
    }

    #[test]
    fn power_has_the_wanted_mean() {
        let bits = levels(Drive::Power { power_w: 0.0115 }, 1000);
        // a quarter of the way between the levels, within one bit
        assert!(bits.iter().filter(|&&high| high).count().abs_diff(250) <= 1);
    }

    #[test]
    fn power_out_of_reach_keeps_the_nearest_level() {
        assert!(levels(Drive::Power { power_w: 0.05 }, 100).iter().all(|&high| high));
        assert!(!levels(Drive::Power { power_w: 0.001 }, 100).iter().any(|&high| high));
    }

    #[test]
    fn temperature_heats_only_below_its_target() {
        let drive = Drive::Temperature { target_c: -20.0 };
        let mut state = drive.start(range()).unwrap();
        assert_eq!(drive.step(&mut state, &at(-20.001)), Level::High);
        // on the target counts as warm enough, thesis section 2.3
        assert_eq!(drive.step(&mut state, &at(-20.0)), Level::Low);
    }

    #[test]
    fn prbs_holds_each_bit_for_its_ticks() {
        let bits = levels(Drive::Prbs { order: 5, seed: 3, ticks_per_bit: 4 }, 31 * 4 * 2);
        let mut reference = Prbs::new(5, 3).unwrap();
        for chunk in bits.chunks(4) {
            let bit = reference.step();
            assert!(chunk.iter().all(|&high| high == bit));
        }
        assert_eq!(bits[..124], bits[124..]);
    }

    #[test]
    fn set_points_dwell_and_fill_their_range() {
        let drive = Drive::Setpoints { low_c: 10.0, high_c: 30.0, dwell_ticks: 3, seed: 99 };
        let mut state = drive.start(range()).unwrap();
        let targets: Vec<f32> = (0..3000)
            .map(|_| {
                // The draw comes with the step; what it decides is shown by a second look within
                // the same dwell.
                let level = drive.step(&mut state, &at(20.0));
                assert_eq!(level == Level::High, 20.0 < state.target_c);
                state.target_c
            })
            .collect();
        assert!(targets.chunks(3).all(|dwell| dwell.iter().all(|target| target == &dwell[0])));
        let mean = targets.iter().sum::<f32>() / 3000.0;
        // 1000 uniform draws over 20 K: the mean has a standard error of 0.18 K
        assert!((mean - 20.0).abs() < 0.7, "{mean}");
        let (least, most) = targets.iter().fold((f32::MAX, f32::MIN), |(a, b), &t| (a.min(t), b.max(t)));
        assert!((10.0..10.2).contains(&least) && (29.8..=30.0).contains(&most));
    }

    #[test]
    fn set_points_begin_at_random_whatever_the_seed() {
        let drive = |seed| Drive::Setpoints { low_c: 0.0, high_c: 1.0, dwell_ticks: 1, seed };
        for seed in [0, 1, 2, 0x7fff_fffe] {
            let mut state = drive(seed).start(range()).unwrap();
            drive(seed).step(&mut state, &at(0.0));
            assert!((0.001..0.999).contains(&state.target_c), "seed {seed}: {}", state.target_c);
        }
    }

    #[test]
    fn only_a_promise_out_of_reach_saturates() {
        let saturated = |drive: Drive, temperature_c| {
            let mut state = drive.start(range()).unwrap();
            (0..10).fold((0, 0), |(count, ticks), _| {
                drive.step(&mut state, &at(temperature_c));
                (count + u32::from(state.saturated), ticks + 1)
            })
        };
        // A mean close to a level asks for that level nearly always, and is met.
        assert_eq!(saturated(Drive::Power { power_w: 0.001_500_01 }, 0.0), (0, 10));
        assert_eq!(saturated(Drive::Power { power_w: 0.0416 }, 0.0), (10, 10));
        assert_eq!(saturated(Drive::Power { power_w: 0.0014 }, 0.0), (10, 10));
        // The first tick changes the level.
        assert_eq!(saturated(Drive::Temperature { target_c: 1.0 }, 0.0), (9, 10));
        assert_eq!(saturated(Drive::Setpoints { low_c: 1.0, high_c: 2.0, dwell_ticks: 1, seed: 3 }, 0.0), (9, 10));
        assert_eq!(saturated(Drive::Passive, 0.0), (0, 10));
        assert_eq!(saturated(Drive::Level(Level::High), 0.0), (0, 10));
    }

    #[test]
    fn refuses_numbers_that_mean_nothing() {
        let refused = |drive: Drive| drive.start(range()).unwrap_err().parameter;
        assert_eq!(refused(Drive::Power { power_w: f32::NAN }), Parameter::PowerW);
        assert_eq!(refused(Drive::Temperature { target_c: f32::NAN }), Parameter::TargetC);
        assert_eq!(refused(Drive::Temperature { target_c: 1e4 }), Parameter::TargetC);
        assert_eq!(refused(Drive::Prbs { order: 10, seed: 1, ticks_per_bit: 0 }), Parameter::TicksPerBit);
        assert_eq!(refused(Drive::Prbs { order: 10, seed: 1023, ticks_per_bit: 1 }), Parameter::PrbsSeed);
        assert_eq!(refused(Drive::Setpoints { low_c: 5.0, high_c: 5.0, dwell_ticks: 1, seed: 0 }), Parameter::HighC);
        assert_eq!(
            refused(Drive::Setpoints { low_c: 5.0, high_c: 6.0, dwell_ticks: 0, seed: 0 }),
            Parameter::DwellTicks
        );
    }

    #[test]
    fn set_points_are_drawn_of_sixteen_bits_after_a_warm_up() {
        let drive = Drive::Setpoints { low_c: 10.0, high_c: 30.0, dwell_ticks: 2, seed: 99 };
        let mut state = drive.start(range()).unwrap();
        assert_eq!(state.target_c, 10.0, "the lowest before the first is drawn");
        let mut register = Prbs::new(31, 99).unwrap();
        (0..8 * 31).for_each(|_| _ = register.step());
        for n in 0..1000 {
            let word = (0..16).fold(0.0, |word, _| 2.0 * word + f64::from(u8::from(register.step())));
            drive.step(&mut state, &at(0.0));
            drive.step(&mut state, &at(0.0));
            // Two roundings of a number under 32 °C.
            assert!((f64::from(state.target_c) - (10.0 + 20.0 * word / 65535.0)).abs() < 4e-6, "draw {n}");
        }
    }

    #[test]
    fn on_its_drawn_target_it_is_warm_enough() {
        let drive = Drive::Setpoints { low_c: 10.0, high_c: 30.0, dwell_ticks: 10, seed: 7 };
        let mut state = drive.start(range()).unwrap();
        assert_eq!(drive.step(&mut state, &at(0.0)), Level::High);
        let target_c = state.target_c;
        assert_eq!(drive.step(&mut state, &at(target_c)), Level::Low);
        assert_eq!(drive.step(&mut state, &at(f32::from_bits(target_c.to_bits() - 1))), Level::High);
    }

    #[test]
    fn a_state_that_was_never_started_stays_as_it_is() {
        let drives = [
            Drive::Prbs { order: 5, seed: 3, ticks_per_bit: 4 },
            Drive::Setpoints { low_c: 1.0, high_c: 2.0, dwell_ticks: 3, seed: 1 },
        ];
        for drive in drives {
            let mut state = DriveState::default();
            for _ in 0..3 {
                // Its target is 0 °C as long as none was drawn.
                assert_eq!(drive.step(&mut state, &at(10.0)), Level::Low);
                assert_eq!((state.ticks_left, state.target_c), (0, 0.0), "{drive:?}");
            }
        }
    }

    #[test]
    fn a_checksum_covers_every_number_of_a_drive() {
        let prbs = |order, seed, ticks_per_bit| Drive::Prbs { order, seed, ticks_per_bit };
        let setpoints = |low_c, high_c, dwell_ticks, seed| Drive::Setpoints { low_c, high_c, dwell_ticks, seed };
        let drives = [
            Drive::Passive,
            Drive::Level(Level::Low),
            Drive::Level(Level::High),
            Drive::Power { power_w: 0.02 },
            Drive::Power { power_w: 0.03 },
            Drive::Temperature { target_c: 0.02 },
            Drive::Temperature { target_c: 1.0 },
            prbs(9, 5, 3),
            prbs(8, 5, 3),
            prbs(9, 4, 3),
            prbs(9, 5, 2),
            setpoints(1.0, 2.0, 3, 4),
            setpoints(0.5, 2.0, 3, 4),
            setpoints(1.0, 2.5, 3, 4),
            setpoints(1.0, 2.0, 2, 4),
            setpoints(1.0, 2.0, 3, 5),
        ];
        for (place, drive) in drives.iter().enumerate() {
            for other in &drives[..place] {
                assert_ne!(Checksum::of(drive), Checksum::of(other), "{drive:?} {other:?}");
            }
        }
    }

    #[test]
    fn a_checksum_covers_what_a_drive_remembers_and_decides_by() {
        let of = |drive: &Drive, state: &DriveState| {
            let mut checksum = Checksum::default();
            drive.visit_state(state, &mut checksum);
            checksum
        };
        let prbs = Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 };
        let setpoints = Drive::Setpoints { low_c: -45.3, high_c: 12.1, dwell_ticks: 3, seed: 4 };
        let power = Drive::Power { power_w: 0.0115 };
        for drive in [Drive::Passive, Drive::Level(Level::High), power, prbs, setpoints] {
            let (is_prbs, is_setpoints) = (drive == prbs, drive == setpoints);
            let state = drive.start(range()).unwrap();
            let changes = [
                (drive == power, DriveState { modulator: SigmaDelta { accumulator: 0.5 }, ..state }),
                (is_prbs || is_setpoints, DriveState { register: Some(Prbs::new(9, 6).unwrap()), ..state }),
                (is_prbs || is_setpoints, DriveState { ticks_left: 1, ..state }),
                (is_prbs, DriveState { level: Level::High, ..state }),
                (is_setpoints, DriveState { target_c: 1.0, ..state }),
                (false, DriveState { saturated: true, ..state }),
            ];
            for (is_covered, changed) in changes {
                assert_eq!(of(&drive, &changed) != of(&drive, &state), is_covered, "{drive:?} {changed:?}");
            }
        }
    }
}
