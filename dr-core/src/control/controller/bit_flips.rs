//! Bit flips in the memory of a controller, as a particle causes them: for fault injection only, in
//! no image.

use super::Controller;
use crate::control::drive::Drive;
use crate::control::guard::Limits;
use crate::control::state::{ElementConfig, MOST_ELEMENTS, RunState};
use crate::control::transducer::Transducer;
use crate::model::SelfHeating;
use crate::sensor::{Channel, Level};

/// Number of values in which a bit can be flipped.
pub const FLIPPABLE: usize = 24;

/// A value in the memory of a controller, by what it is kept as.
enum Place<'a> {
    Number(&'a mut f32),
    Count(&'a mut u32),
    Code(&'a mut i32),
    Levels(&'a mut usize),
    Elements(&'a mut usize),
    Yes(&'a mut bool),
    RunState(&'a mut RunState),
    Drive(&'a mut Drive),
    Wiring(&'a mut Channel),
    Model(&'a mut SelfHeating),
}

impl Place<'_> {
    /// Flips a bit; none where this changed nothing.
    fn flip(self, bit: u32, element: usize) -> Option<()> {
        let word = 1_u32 << (bit % 32);
        match self {
            Self::Number(number) => *number = f32::from_bits(number.to_bits() ^ word),
            Self::Count(count) => *count ^= word,
            Self::Code(code) => *code ^= word.cast_signed(),
            Self::Levels(levels) => *levels ^= 1 << (element % MOST_ELEMENTS),
            Self::Elements(elements) => *elements ^= 1 << (bit % 8),
            Self::Yes(yes) => *yes ^= true,
            Self::RunState(state @ RunState::Running) => *state = RunState::Standby,
            Self::RunState(state) => *state = RunState::Running,
            Self::Drive(Drive::Level(Level::High)) => return None,
            Self::Drive(drive) => *drive = Drive::Level(Level::High),
            Self::Wiring(channel) => {
                let [mut high_a, low_a] = [Level::High, Level::Low].map(|level| channel.current_a(level));
                Place::Number(&mut high_a).flip(bit % 16, element)?;
                *channel = Channel::new(*channel.platinum(), 1e-6, low_a, high_a).ok()?;
            }
            Self::Model(model) => model.flip_bit(bit),
        }
        Some(())
    }
}

impl<const N: usize> Controller<N> {
    /// Flips a bit of one of [`FLIPPABLE`] values of an element or of the controller. Returns the
    /// name of the value, or none if the element does not exist or does not have this value. The
    /// value always changes.
    pub fn flip_bit(&mut self, which: usize, element: usize, bit: u32) -> Option<&'static str> {
        let state = self.states.get_mut(element)?;
        let of = self.elements.get_mut(element)?.as_mut()?;
        let Transducer::Resistor(ElementConfig { channel, limits }) = &mut of.transducer else { return None };
        let Limits { resistance_min_ohm, resistance_max_ohm, temperature_max_c, code_max, energy: bears } = limits;
        let (name, place) = match which {
            0 => ("sample period", Place::Number(self.sample_period_s.as_mut()?)),
            1 => ("limit of missing readings", Place::Count(&mut self.guard.missing_limit_ticks)),
            2 => ("limit of unreachable set-points", Place::Count(&mut self.guard.unreachable_limit_ticks)),
            3 => ("number of elements", Place::Elements(&mut self.configured)),
            4 => ("observers on or off", Place::Yes(&mut self.observing)),
            5 => ("least resistance", Place::Number(resistance_min_ohm)),
            6 => ("greatest resistance", Place::Number(resistance_max_ohm)),
            7 => ("greatest temperature", Place::Number(temperature_max_c)),
            8 => ("greatest code", Place::Code(code_max)),
            9 => match &mut of.drive {
                Drive::Temperature { target_c: target } | Drive::SecondOrder { target, .. } => {
                    ("set-point", Place::Number(target))
                }
                Drive::Power { power_w } => ("wanted power", Place::Number(power_w)),
                Drive::Prbs { seed, .. } | Drive::Setpoints { seed, .. } => ("seed", Place::Count(seed)),
                Drive::Alternation { half_ticks, .. } => ("length of a half", Place::Count(half_ticks)),
                Drive::Passive | Drive::Level(_) => return None,
            },
            10 => ("which drive", Place::Drive(&mut of.drive)),
            11 => ("wiring", Place::Wiring(channel)),
            12 => ("run state", Place::RunState(&mut self.state)),
            13 => ("number of the tick", Place::Count(&mut self.tick)),
            14 => ("time armed", Place::Count(&mut self.armed_ticks)),
            15 => ("level", Place::Levels(&mut self.levels.0)),
            16 => ("ticks without a reading", Place::Count(&mut state.absent_ticks)),
            17 => ("ticks saturated", Place::Count(&mut state.saturated_ticks)),
            18 => ("modulator", Place::Number(&mut state.drive.modulator.accumulator)),
            19 => ("set-point in force", Place::Number(&mut state.drive.target_c)),
            20 => ("ticks left", Place::Count(&mut state.drive.ticks_left)),
            21 => ("model", Place::Model(of.model.as_mut()?)),
            22 => ("sustained power", Place::Number(&mut bears.as_mut()?.sustained_power_w)),
            23 => ("energy", Place::Number(&mut bears.as_mut()?.energy_j)),
            _ => return None,
        };
        place.flip(bit, element)?;
        Some(name)
    }
}
