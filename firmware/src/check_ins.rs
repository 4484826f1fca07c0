//! Check-ins: every task checks in, and the watchdog is fed only when all have.

use crate::flag::Flag;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Beats without a patient member after which the watchdog is not fed: 5 s at 20 a second.
///
/// The settings server searches its sectors for up to a second before it writes, heaters low, and
/// holds the idle loop back meanwhile.
pub const MOST_BEATS: u32 = 100;

/// Who has to check in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Member {
    /// The control task.
    Control,
    /// The estimator.
    Estimate,
    /// The receiver.
    Receive,
    /// The transmitter.
    Transmit,
    /// The settings server.
    Settings,
    /// The idle loop, which tests the memories.
    Idle,
}

/// Who has checked in since the watchdog was last fed.
pub struct CheckIns {
    anew: [Flag; 6],
    /// Beats since the two last members, which are patient, have checked in.
    beats: [AtomicU32; 2],
}

impl CheckIns {
    /// No task yet.
    pub const fn none() -> Self {
        Self { anew: [const { Flag::new(false) }; 6], beats: [const { AtomicU32::new(0) }; 2] }
    }

    /// Records that a task has run.
    pub fn check_in(&self, member: Member) {
        self.anew.get(member as usize).into_iter().for_each(Flag::raise);
    }

    /// Returns true if all have checked in; if so, the record is cleared. To be asked once a beat.
    pub fn all_anew(&self) -> bool {
        let [tasks @ .., settings, idle] = &self.anew;
        let mut all = tasks.iter().all(Flag::is_raised);
        // Both count on, whatever the others do.
        for (member, count) in [settings, idle].into_iter().zip(&self.beats) {
            let beats = if member.take() { 0 } else { count.load(Relaxed).saturating_add(1) };
            count.store(beats, Relaxed);
            all &= beats < MOST_BEATS;
        }
        if all {
            tasks.iter().for_each(|task| task.set(false));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_watchdog_starves_as_soon_as_one_task_is_silent() {
        let members = [Member::Control, Member::Estimate, Member::Receive, Member::Transmit];
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

    #[test]
    fn idle_loop_and_settings_server_may_be_silent_for_some_time() {
        for silent in [Member::Settings, Member::Idle] {
            let check_ins = CheckIns::none();
            let beat = |is_silent: bool| {
                let all = [
                    Member::Control,
                    Member::Estimate,
                    Member::Receive,
                    Member::Transmit,
                    Member::Settings,
                    Member::Idle,
                ];
                all.iter().filter(|&&member| !is_silent || member != silent).for_each(|&it| check_ins.check_in(it));
                check_ins.all_anew()
            };
            for _ in 0..2 {
                assert!(beat(false));
                assert!((1..MOST_BEATS).all(|_| beat(true)));
                assert!((0..10).all(|_| !beat(true)), "{silent:?}");
            }
            assert!(beat(false));
        }
    }
}
