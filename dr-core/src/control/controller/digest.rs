//! The part of a controller that enters the digest of a run.

use super::{Controller, ElementState};
use crate::control::drive::DriveState;
use crate::control::state::Tick;
use crate::digest::Digest;
use crate::fields::{FieldVisitor, Fields};
use crate::sensor::Level;
use crate::signal::SigmaDelta;

impl<const N: usize> Controller<N> {
    /// Adds the state after `tick` to a digest: temperatures, bits, powers and every state of the
    /// configured elements, so that the room for more elements does not matter. The configuration
    /// does not enter.
    pub fn digest(&self, tick: &Tick<N>, digest: &mut Digest) {
        digest.word(tick.tick);
        for first in (0..self.configured.max(1)).step_by(16) {
            let [heaters, valid] = [tick.heaters.0, tick.valid].map(|mask| mask.checked_shr(first as u32));
            digest.word(heaters.unwrap_or(0) as u32 & 0xffff | (valid.unwrap_or(0) as u32) << 16);
        }
        digest.word(tick.state.word());
        if let Some(equivalent_power_w) = &tick.equivalent_power_w {
            for (state, &equivalent_w) in self.states.iter().zip(equivalent_power_w).take(self.configured) {
                (state.observer, equivalent_w).visit(digest);
            }
        }
        let elements = self.states.iter().zip(&tick.power_w).take(self.configured).enumerate();
        elements.for_each(|(i, (state, &power_w))| state.digest(self.levels.level(i), power_w, digest));
    }
}

impl ElementState {
    fn digest(&self, level: Level, power_w: f32, digest: &mut Digest) {
        let Self {
            drive:
                DriveState {
                    modulator: SigmaDelta { accumulator },
                    register,
                    ticks_left,
                    level: asked,
                    saturated,
                    target_c,
                },
            measured,
            raw,
            absent_ticks,
            saturated_ticks,
            code: _,
            same_ticks: _,
            rise: _,
            model,
            observer: _, // above
        } = *self;
        [measured, raw].visit(digest);
        [absent_ticks, saturated_ticks, ticks_left].visit(digest);
        digest.word(asked as u32 | u32::from(saturated) << 1 | (level as u32) << 2);
        [power_w, accumulator, target_c].visit(digest);
        digest.word(register.map_or(0, |register| register.register()));
        model.visit(digest);
    }
}
