//! Check-ins: every task checks in, and the watchdog is fed only when all have.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Who has to check in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Member {
    /// The control task.
    Control,
    /// The receiver.
    Receive,
    /// The transmitter.
    Transmit,
}

/// Who has checked in since the watchdog was last fed.
pub struct CheckIns([AtomicBool; 3]);

impl CheckIns {
    /// No task yet.
    pub const fn none() -> Self {
        Self([const { AtomicBool::new(false) }; 3])
    }

    /// Records that a task has run.
    pub fn check_in(&self, member: Member) {
        let Self([control, receive, transmit]) = self;
        match member {
            Member::Control => control,
            Member::Receive => receive,
            Member::Transmit => transmit,
        }
        .store(true, Relaxed);
    }

    /// Whether all have checked in; if so, the record is cleared.
    pub fn all_anew(&self) -> bool {
        let all = self.0.iter().all(|member| member.load(Relaxed));
        if all {
            self.0.iter().for_each(|member| member.store(false, Relaxed));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_watchdog_starves_as_soon_as_one_task_is_silent() {
        let members = [Member::Control, Member::Receive, Member::Transmit];
        for silent in members {
            let check_ins = CheckIns::none();
            for _ in 0..3 {
                members.iter().for_each(|&member| check_ins.check_in(member));
                assert!(check_ins.all_anew());
            }
            for _ in 0..10 {
                members.iter().filter(|&&member| member != silent).for_each(|&member| check_ins.check_in(member));
                assert!(!check_ins.all_anew(), "{silent:?} has not checked in");
            }
            // It was only late: those that have waited for it need not check in again.
            check_ins.check_in(silent);
            assert!(check_ins.all_anew());
        }
    }
}
