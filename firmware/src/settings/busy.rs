//! Who may write when: settings are written, and an instrument is set up by them, in standby only, and it must not start meanwhile.
//!
//! Two sides of one processor: the control task, of high priority, and the clerk, of low. Each says something and then looks at what the
//! other has said.
//!
//! | | says | looks |
//! |---|---|---|
//! | clerk | [`try_take`](Busy::try_take): *busy* | then whether it is standby; if not it takes *busy* back, and refuses |
//! | control | [`standby`](Busy::standby): each time it is through | [`is_taken`](Busy::is_taken) before each of the host's commands: while it is, they stay in their queue |
//!
//! Control is never interrupted by the clerk, so a command is carried out and its new state said in one piece as far as the clerk can see. If control
//! runs before *busy* is said, the clerk sees the new state; if it runs after, it leaves the command where it is. So nothing starts while flash
//! is written or a head half told, nothing is written while it runs, and a host has to know nothing of it: a command that has to wait is
//! answered later, by a second at the most. A trip can happen at any time; heaters are low then as they are in standby.

use core::sync::atomic::{AtomicBool, Ordering::SeqCst};

/// The two words. Their order matters, so they are sequentially consistent.
pub struct Busy {
    taken: AtomicBool,
    standby: AtomicBool,
}

impl Busy {
    /// As at a start: taken, since the instrument is to be set up before anything else.
    pub const fn starting() -> Self {
        Self { taken: AtomicBool::new(true), standby: AtomicBool::new(true) }
    }

    /// The clerk's: from now on no command is carried out, if it is standby; says whether it is.
    pub fn try_take(&self) -> bool {
        self.taken.store(true, SeqCst);
        if !self.is_standby() {
            self.give_back();
            return false;
        }
        true
    }

    /// The clerk's: commands go on. Control has to be woken then.
    pub fn give_back(&self) {
        self.taken.store(false, SeqCst);
    }

    /// Control's: before it lets the clerk set the instrument up anew.
    pub fn take(&self) {
        self.taken.store(true, SeqCst);
    }

    /// Control's: whether commands have to wait.
    pub fn is_taken(&self) -> bool {
        self.taken.load(SeqCst)
    }

    /// Control's: what the state has become.
    pub fn standby(&self, is: bool) {
        self.standby.store(is, SeqCst);
    }

    /// Whether it was standby when control was last through.
    pub fn is_standby(&self) -> bool {
        self.standby.load(SeqCst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Control may come between any two steps of the clerk's: none of these places lets a run and a write meet.
    #[test]
    fn a_start_at_any_moment_and_a_write_exclude_each_other() {
        let steps = 4;
        for start_before in 0..=steps {
            let busy = Busy::starting();
            busy.give_back();
            let (mut running, mut wrote) = (false, false);
            let mut control = |step: u32, busy: &Busy| {
                if step == start_before && !busy.is_taken() {
                    running = true;
                    busy.standby(false);
                }
                running
            };
            // `try_take`, step by step.
            control(0, &busy);
            busy.taken.store(true, SeqCst);
            control(1, &busy);
            let standby = busy.is_standby();
            control(2, &busy);
            if standby {
                assert!(!control(3, &busy), "start before step {start_before}");
                wrote = true;
            }
            busy.give_back();
            let runs = control(4, &busy);
            assert_eq!(wrote, start_before > 0, "the write goes first, or the start does");
            assert_eq!(runs, start_before == 0 || start_before == steps, "a start in between waits");
        }
        let busy = Busy::starting();
        busy.standby(false);
        assert!(!busy.try_take() && !busy.is_taken());
        busy.standby(true);
        assert!(busy.try_take() && busy.is_taken());
    }
}
