//! Phase of the board's life, from its start over the set-up to standby and runs: what the tasks
//! below priority 6 tell each other of it.
//!
//! | flag | set by | taken or read by |
//! |---|---|---|
//! | set-up is due | start, acknowledgement of a trip before the set-up | settings server |
//! | is set up | settings server | control, at an acknowledgement |
//! | proof is due | start, self-test | idle, which proves the dead-man timer |
//! | acknowledged | control | transmitter: the identity has no crash any more |
//! | host heard | receiver | control |
//!
//! While a set-up is due the standby lock is taken: no command of the host is carried out before
//! it.

use crate::settings::StandbyLock;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// The flags, with the standby lock.
pub struct Phase {
    /// Excludes runs while settings are written or loaded.
    pub lock: StandbyLock,
    set_up_is_due: AtomicBool,
    is_set_up: AtomicBool,
    proof_is_due: AtomicBool,
    is_acknowledged: AtomicBool,
    is_host_heard: AtomicBool,
}

impl Phase {
    /// After a start: the dead-man timer is to be proved, the instrument to be set up.
    pub const fn starting() -> Self {
        Self {
            lock: StandbyLock::starting(),
            set_up_is_due: AtomicBool::new(true),
            is_set_up: AtomicBool::new(false),
            proof_is_due: AtomicBool::new(true),
            is_acknowledged: AtomicBool::new(false),
            is_host_heard: AtomicBool::new(false),
        }
    }

    /// Whether a set-up is due; said once.
    pub fn take_set_up(&self) -> bool {
        take(&self.set_up_is_due)
    }

    /// The set-up has come to its end, or was not possible.
    pub fn set_up(&self, is_done: bool) {
        self.is_set_up.store(is_done, Relaxed);
    }

    /// Whether the instrument has been set up.
    pub fn is_set_up(&self) -> bool {
        self.is_set_up.load(Relaxed)
    }

    /// A trip has been acknowledged. Returns whether a set-up is due, for which the settings server
    /// must be woken: of a board that has not been set up, or has forgotten its settings.
    pub fn acknowledge(&self, has_forgotten: bool) -> bool {
        self.is_acknowledged.store(true, Relaxed);
        let is_due = has_forgotten || !self.is_set_up();
        if is_due {
            self.lock.take();
            self.set_up_is_due.store(true, Relaxed);
        }
        is_due
    }

    /// Whether a trip has been acknowledged since the start.
    pub fn is_acknowledged(&self) -> bool {
        self.is_acknowledged.load(Relaxed)
    }

    /// The dead-man timer is to be proved, as soon as all heaters are low.
    pub fn ask_proof(&self) {
        self.proof_is_due.store(true, Relaxed);
    }

    /// Proves the dead-man timer if that is due; it stays due if `test` could not be made.
    pub fn prove(&self, test: impl FnOnce() -> bool) {
        if self.proof_is_due.load(Relaxed) {
            self.proof_is_due.store(!test(), Relaxed);
        }
    }

    /// The host has sent a frame.
    pub fn hear_host(&self) {
        self.is_host_heard.store(true, Relaxed);
    }

    /// Whether the host has sent a frame since the last call.
    pub fn take_host(&self) -> bool {
        take(&self.is_host_heard)
    }
}

/// Takes a flag; no read-modify-write, since what sets it in between is served all the same.
fn take(flag: &AtomicBool) -> bool {
    let is_set = flag.load(Relaxed);
    if is_set {
        flag.store(false, Relaxed);
    }
    is_set
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_the_host_is_carried_out_while_a_set_up_is_due() {
        let phase = Phase::starting();
        assert!(phase.lock.is_taken() && phase.take_set_up() && !phase.take_set_up());
        phase.set_up(true);
        phase.lock.give_back();
        assert!(!phase.acknowledge(false) && !phase.lock.is_taken() && phase.is_acknowledged());
        // It has cleared its settings.
        assert!(phase.acknowledge(true) && phase.lock.is_taken() && phase.take_set_up());
        phase.set_up(false);
        phase.lock.give_back();
        assert!(phase.acknowledge(false) && phase.lock.is_taken(), "a set-up that was not possible is tried again");
    }

    #[test]
    fn a_proof_that_could_not_be_made_stays_due() {
        let phase = Phase::starting();
        let mut tests = 0;
        for can in [false, true, true] {
            phase.prove(|| {
                tests += 1;
                can
            });
        }
        assert_eq!(tests, 2);
        phase.ask_proof();
        phase.prove(|| true);
        phase.hear_host();
        assert!(phase.take_host() && !phase.take_host());
    }
}
