//! Bit flips in the memory of a controller, as a particle causes them: for fault injection only, in
//! no image.

use super::{Controller, ElementState};
use crate::control::drive::Drive;
use crate::control::guard::Limits;
use crate::control::state::RunState;
use crate::model::SelfHeating;
use crate::sensor::{Channel, Level};

/// Number of values in which a bit can be flipped.
pub const FLIPPABLE: usize = 22;

fn flip(number: &mut f32, bit: u32) {
    *number = f32::from_bits(number.to_bits() ^ 1 << (bit % 32));
}

impl<const N: usize> Controller<N> {
    /// Flips a bit of one of [`FLIPPABLE`] values of an element or of the controller. Returns the
    /// name of the value, or none if the element does not exist or does not have this value. The
    /// value always changes.
    pub fn flip_bit(&mut self, which: usize, element: usize, bit: u32) -> Option<&'static str> {
        let word = 1_u32 << (bit % 32);
        let state = self.states.get_mut(element)?;
        let of = self.elements.get_mut(element)?.as_mut()?;
        let Limits { resistance_min_ohm, resistance_max_ohm, temperature_max_c, code_max } = &mut of.config.limits;
        let ElementState { drive: driven, absent_ticks, saturated_ticks, .. } = state;
        Some(match which {
            0 => {
                flip(self.sample_period_s.as_mut()?, bit);
                "sample period"
            }
            1 => {
                self.guard.missing_limit_ticks ^= word;
                "limit of missing readings"
            }
            2 => {
                self.guard.unreachable_limit_ticks ^= word;
                "limit of unreachable set-points"
            }
            3 => {
                self.configured ^= 1 << (bit % 8);
                "number of elements"
            }
            4 => {
                self.observing ^= true;
                "observers on or off"
            }
            5 => {
                flip(resistance_min_ohm, bit);
                "least resistance"
            }
            6 => {
                flip(resistance_max_ohm, bit);
                "greatest resistance"
            }
            7 => {
                flip(temperature_max_c, bit);
                "greatest temperature"
            }
            8 => {
                *code_max ^= word.cast_signed();
                "greatest code"
            }
            9 => match &mut of.drive {
                Drive::Temperature { target_c } => {
                    flip(target_c, bit);
                    "set-point"
                }
                Drive::Power { power_w } => {
                    flip(power_w, bit);
                    "wanted power"
                }
                Drive::Prbs { seed, .. } | Drive::Setpoints { seed, .. } => {
                    *seed ^= word;
                    "seed"
                }
                Drive::Passive | Drive::Level(_) => return None,
            },
            10 if of.drive == Drive::Level(Level::High) => return None,
            10 => {
                of.drive = Drive::Level(Level::High);
                "which drive"
            }
            11 => {
                let [mut high_a, low_a] = [Level::High, Level::Low].map(|level| of.config.channel.current_a(level));
                flip(&mut high_a, bit % 16);
                of.config.channel = Channel::new(*of.config.channel.platinum(), 1e-6, low_a, high_a).ok()?;
                "wiring"
            }
            12 => {
                self.state = if self.state == RunState::Running { RunState::Standby } else { RunState::Running };
                "run state"
            }
            13 => {
                self.tick ^= word;
                "number of the tick"
            }
            14 => {
                self.armed_ticks ^= word;
                "time armed"
            }
            15 => {
                self.levels.0 ^= 1 << (element % 16);
                "level"
            }
            16 => {
                *absent_ticks ^= word;
                "ticks without a reading"
            }
            17 => {
                *saturated_ticks ^= word;
                "ticks saturated"
            }
            18 => {
                flip(&mut driven.modulator.accumulator, bit);
                "modulator"
            }
            19 => {
                flip(&mut driven.target_c, bit);
                "set-point in force"
            }
            20 => {
                driven.ticks_left ^= word;
                "ticks left"
            }
            21 => {
                let model: &mut SelfHeating = of.model.as_mut()?;
                model.flip_bit(bit);
                "model"
            }
            _ => return None,
        })
    }
}
