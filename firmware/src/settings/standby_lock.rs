//! The standby lock: settings are written and loaded in standby only, and the instrument must not
//! start meanwhile.
//!
//! Two tasks of one processor use it: the control task, of high priority, and the settings server,
//! of low priority. Each writes its own word first and then reads the other's.
//!
//! | | writes | reads |
//! |---|---|---|
//! | settings server | [`try_take`](StandbyLock::try_take): *taken* | then whether it is standby; if not it releases the lock and refuses |
//! | control | [`standby`](StandbyLock::standby): at the end of each run of the task | [`is_taken`](StandbyLock::is_taken) before each of the host's commands: while it is taken, they stay in their queue |
//!
//! The settings server never interrupts the control task, so it sees a command and the new state as
//! one step. If control runs before *taken* is written, the server sees the new state; if it runs
//! after, the command stays in its queue. So nothing starts while flash is written or a head is
//! loaded in part, and nothing is written during a run. A host needs no knowledge of this: a
//! command that has to wait is answered later, by a second at most. A trip can happen at any time;
//! heaters are then low, as in standby.

use core::sync::atomic::{AtomicBool, Ordering::SeqCst};

/// The two words. Their order matters, so they are sequentially consistent.
pub struct StandbyLock {
    taken: AtomicBool,
    standby: AtomicBool,
}

impl StandbyLock {
    /// State after a start: taken, since the instrument is set up before anything else.
    pub const fn starting() -> Self {
        Self { taken: AtomicBool::new(true), standby: AtomicBool::new(true) }
    }

    /// For the settings server: takes the lock if the instrument is in standby; returns whether it
    /// did.
    pub fn try_take(&self) -> bool {
        self.taken.store(true, SeqCst);
        if !self.is_standby() {
            self.give_back();
            return false;
        }
        true
    }

    /// For the settings server: releases the lock. Control must be woken afterwards.
    pub fn give_back(&self) {
        self.taken.store(false, SeqCst);
    }

    /// For control: takes the lock before a new set-up.
    pub fn take(&self) {
        self.taken.store(true, SeqCst);
    }

    /// For control: whether commands have to wait.
    pub fn is_taken(&self) -> bool {
        self.taken.load(SeqCst)
    }

    /// For control: publishes whether the instrument is in standby.
    pub fn standby(&self, is: bool) {
        self.standby.store(is, SeqCst);
    }

    /// Returns true if the instrument was in standby at the end of the last run of control.
    pub fn is_standby(&self) -> bool {
        self.standby.load(SeqCst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Control may interrupt between any two steps of the server: at none of them do a run and a
    /// write overlap.
    #[test]
    fn a_start_at_any_moment_and_a_write_exclude_each_other() {
        let steps = 4;
        for start_before in 0..=steps {
            let lock = StandbyLock::starting();
            lock.give_back();
            let (mut running, mut wrote) = (false, false);
            let mut control = |step: u32, lock: &StandbyLock| {
                if step == start_before && !lock.is_taken() {
                    running = true;
                    lock.standby(false);
                }
                running
            };
            // `try_take`, step by step.
            control(0, &lock);
            lock.taken.store(true, SeqCst);
            control(1, &lock);
            let standby = lock.is_standby();
            control(2, &lock);
            if standby {
                assert!(!control(3, &lock), "start before step {start_before}");
                wrote = true;
            }
            lock.give_back();
            let runs = control(4, &lock);
            assert_eq!(wrote, start_before > 0, "the write goes first, or the start does");
            assert_eq!(runs, start_before == 0 || start_before == steps, "a start in between waits");
        }
        let lock = StandbyLock::starting();
        lock.standby(false);
        assert!(!lock.try_take() && !lock.is_taken());
        lock.standby(true);
        assert!(lock.try_take() && lock.is_taken());
    }
}
