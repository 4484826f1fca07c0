//! What of a controller goes into a run's digest.

use super::super::digest::Digest;
use super::{Controller, Tick};

impl<const N: usize> Controller<N> {
    /// Folds all that the controller knows after `tick` into a digest: temperatures, bits, powers and every state of the elements that
    /// are configured, so that it does not matter how many more there could be. Of the configuration it says nothing.
    pub fn fold(&self, tick: &Tick<N>, digest: &mut Digest) {
        digest.word(tick.tick);
        digest.word(u32::from(tick.heaters.0) | u32::from(tick.valid) << 16);
        digest.word(tick.state.word());
        if let Some(equivalent_power_w) = &tick.equivalent_power_w {
            for (state, &equivalent_w) in self.states.iter().zip(equivalent_power_w).take(self.configured) {
                digest.number(state.observer.added_w);
                digest.number(equivalent_w);
            }
        }
        for (state, &power_w) in self.states.iter().zip(&tick.power_w).take(self.configured) {
            digest.number(state.temperature_c);
            digest.number(state.resistance_ohm);
            digest.word(state.absent_ticks);
            digest.word(state.saturated_ticks);
            digest.word(state.drive.ticks_left);
            digest.word(state.drive.level as u32 | (state.drive.saturated as u32) << 1 | (state.level as u32) << 2);
            digest.number(power_w);
            digest.number(state.drive.modulator.accumulator);
            digest.number(state.drive.target_c);
            digest.word(state.drive.register.map_or(0, |register| register.register()));
            state.model.x.iter().chain(&state.model.excess).for_each(|&number| digest.number(number));
        }
    }
}
