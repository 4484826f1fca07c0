//! Longest time that each handler has taken, without those that have interrupted it.

use std::collections::BTreeMap;

/// Times of handlers, cycles, entry and return included.
#[derive(Clone, Debug, Default)]
pub struct HandlerTimes {
    /// Handlers under way: exception, when it was entered, time of others since.
    active: Vec<(u16, u64, u64)>,
    longest: BTreeMap<u16, u64>,
}

impl HandlerTimes {
    /// A handler is entered.
    pub fn enter(&mut self, exception: u16, now: u64) {
        self.active.push((exception, now, 0));
    }

    /// A handler has returned.
    pub fn leave(&mut self, exception: u16, now: u64) {
        let Some((left, entered, of_others)) = self.active.pop() else { return };
        // A handler of faults may abandon what it has interrupted.
        if left != exception {
            self.active.clear();
            return;
        }
        let took = now - entered;
        let longest = self.longest.entry(exception).or_default();
        *longest = (took - of_others).max(*longest);
        if let Some((_, _, of_others)) = self.active.last_mut() {
            *of_others += took;
        }
    }

    /// No handler is under way any more: a reset, or another state of the machine.
    pub fn abandon(&mut self) {
        self.active.clear();
    }

    /// The longest time of each exception that has been handled.
    pub const fn longest(&self) -> &BTreeMap<u16, u64> {
        &self.longest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_handler_is_not_charged_for_one_that_interrupts_it() {
        let mut times = HandlerTimes::default();
        times.enter(26, 100);
        times.enter(66, 150);
        times.leave(66, 180);
        times.leave(26, 300);
        times.enter(26, 400);
        times.leave(26, 450);
        assert_eq!(times.longest(), &BTreeMap::from([(26, 170), (66, 30)]));
    }
}
