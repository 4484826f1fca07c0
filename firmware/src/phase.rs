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

use crate::flag::Flag;
use crate::settings::StandbyLock;

/// The flags, with the standby lock.
pub struct Phase {
    /// Excludes runs while settings are written or loaded.
    pub lock: StandbyLock,
    /// A set-up is due.
    pub set_up_due: Flag,
    /// The set-up has come to its end.
    pub set_up: Flag,
    /// The dead-man timer is to be proved, as soon as all heaters are low.
    pub proof_due: Flag,
    /// A trip has been acknowledged since the start.
    pub acknowledged: Flag,
    /// The host has sent a frame.
    pub host_heard: Flag,
}

impl Phase {
    /// After a start: the dead-man timer is to be proved, the instrument to be set up.
    pub const fn starting() -> Self {
        Self {
            lock: StandbyLock::starting(),
            set_up_due: Flag::new(true),
            set_up: Flag::new(false),
            proof_due: Flag::new(true),
            acknowledged: Flag::new(false),
            host_heard: Flag::new(false),
        }
    }

    /// A trip has been acknowledged. Returns whether a set-up is due, for which the settings server
    /// must be woken: of a board that has not been set up, or has forgotten its settings.
    pub fn acknowledge(&self, has_forgotten: bool) -> bool {
        self.acknowledged.raise();
        let is_due = has_forgotten || !self.set_up.is_raised();
        if is_due {
            self.lock.take();
            self.set_up_due.raise();
        }
        is_due
    }

    /// Proves the dead-man timer if that is due; it stays due if `test` could not be made.
    pub fn prove(&self, test: impl FnOnce() -> bool) {
        if self.proof_due.is_raised() {
            self.proof_due.set(!test());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_the_host_is_carried_out_while_a_set_up_is_due() {
        let phase = Phase::starting();
        assert!(phase.lock.is_taken() && phase.set_up_due.take() && !phase.set_up_due.take());
        phase.set_up.raise();
        phase.lock.give_back();
        assert!(!phase.acknowledge(false) && !phase.lock.is_taken() && phase.acknowledged.is_raised());
        // It has cleared its settings.
        assert!(phase.acknowledge(true) && phase.lock.is_taken() && phase.set_up_due.take());
        phase.set_up.set(false);
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
        phase.proof_due.raise();
        phase.prove(|| true);
        phase.host_heard.raise();
        assert!(phase.host_heard.take() && !phase.host_heard.take());
    }
}
