//! Integrity check of the controller: which values are verified, and when.
//!
//! | values | checksum updated | verified |
//! |---|---|---|
//! | what trips an element, for all of them: wiring, limits, guard, timeout of the host, fingerprint, sample period, number of elements | by each command that is carried out | every tick, before any decision |
//! | run state, levels, armed time, number of the tick, energy budgets, what each drive remembers and decides by | at the end of each tick, and by each command | every tick, before any decision |
//! | an element's drive, model and observer | by each command that is carried out | one element per tick, in turn |
//!
//! So no reading is judged by a wrong number, and a wrong drive decides for N ticks at most, N
//! being the number of configured elements. Not verified are counters of ticks, which are cleared,
//! or trip early, or trip later by their own limit at most; and temperatures, which the next
//! reading replaces.
//!
//! A failed check trips the instrument. The flipped bit cannot be located, so acknowledging such a
//! trip clears everything except the count of bit flips; the host must set the instrument up again.

use super::{ControlledElement, Controller};
use crate::checksum::Checksum;
use crate::control::guard::{Cause, Trip};
use crate::control::state::RunState;
use crate::fields::{FieldVisitor, Fields};
use core::ops::Range;

impl<const N: usize> Controller<N> {
    /// Updates all checksums after a command whose values have been checked.
    pub(crate) fn update_checksums(&mut self) {
        self.sealed_settings = self.settings_checksum();
        for (checksum, element) in self.sealed_elements.iter_mut().zip(&self.elements) {
            *checksum = ControlledElement::turn_checksum(element.as_ref());
        }
        self.update_state_checksum();
    }

    /// Updates the checksum of the states, which a tick changes.
    pub(crate) fn update_state_checksum(&mut self) {
        self.sealed_states = self.state_checksum();
    }

    /// Verifies what a tick verifies; returns the trip if something has flipped.
    pub(crate) fn verify_integrity(&mut self) -> Option<Trip> {
        // Without an element there is no turn.
        let turn = self.tick.checked_rem(self.configured as u32).unwrap_or(0) as usize;
        self.verify_with_elements(turn..turn + 1)
    }

    /// Verifies everything, before a command updates the checksums.
    pub(crate) fn verify_everything(&mut self) -> Option<Trip> {
        self.verify_with_elements(0..N)
    }

    /// Verifies settings, states and some elements; nothing once it has tripped for a bit flip.
    fn verify_with_elements(&mut self, turns: Range<usize>) -> Option<Trip> {
        if let RunState::Tripped(Trip { cause: Cause::BitFlip, .. }) = self.state {
            return None;
        }
        let trip = if self.settings_checksum() != self.sealed_settings || self.state_checksum() != self.sealed_states {
            Trip::whole(Cause::BitFlip)
        } else {
            let all = self.elements.iter().zip(&self.sealed_elements).enumerate();
            let mut some = all.skip(turns.start).take(turns.len());
            let broken =
                some.find(|(_, (element, checksum))| ControlledElement::turn_checksum(element.as_ref()) != **checksum);
            Trip::of(broken?.0, Cause::BitFlip)
        };
        self.bit_flips = self.bit_flips.saturating_add(1);
        Some(trip)
    }

    fn settings_checksum(&self) -> Checksum {
        // A field that is neither here nor in `state_checksum`, nor said to be left out, does not
        // compile.
        let Self {
            hardware,
            energy: _,
            sample_period_s,
            guard,
            observing,
            configured,
            elements,
            state: _,
            tick: _,
            levels: _,
            armed_ticks: _,
            states: _,
            sealed_settings: _, // a flipped one fails by itself
            sealed_states: _,
            sealed_elements: _,
            bit_flips: _, // decides nothing
            lockout: _,   // has a checksum of its own
            host_timeout_s,
            host_silence,
            fingerprint_ohm,
            head: _,
        } = self;
        let mut checksum = Checksum::of(&(*sample_period_s, *guard));
        checksum.word(host_timeout_s.to_bits());
        f32::visit_each(fingerprint_ohm, &mut checksum);
        let switches = u32::from(*observing) | u32::from(host_silence.is_some()) << 1;
        checksum.word(*configured as u32 | switches << 8);
        // Rules that a tick judges by, in flash: so a flipped reference shows.
        (hardware.no_rise_s, hardware.energy).visit(&mut checksum);
        elements.iter().map_while(Option::as_ref).for_each(|element| element.transducer.visit(&mut checksum));
        checksum
    }

    fn state_checksum(&self) -> Checksum {
        let mut checksum = Checksum::of(&[self.state.word(), self.tick, self.armed_ticks, self.levels.0 as u32]);
        if N > 32 {
            checksum.word((self.levels.0 as u64 >> 32) as u32);
        }
        checksum.word(self.head.word());
        let states = self.states.iter().zip(&self.energy);
        for (element, (state, energy)) in self.elements.iter().map_while(Option::as_ref).zip(states) {
            element.drive.visit_state(&state.drive, &mut checksum);
            energy.visit(&mut checksum);
        }
        checksum
    }
}

impl ControlledElement {
    fn turn_checksum(element: Option<&Self>) -> Checksum {
        let mut checksum = Checksum::default();
        if let Some(Self { transducer: _, model, observer, drive }) = element {
            drive.visit(&mut checksum);
            model.visit(&mut checksum);
            observer.visit(&mut checksum);
        }
        checksum
    }
}
