//! Check-ins: every task checks in, and the watchdog is fed only when all have.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

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
    tasks: [AtomicBool; 4],
    patient: [PatientMember; 2],
}

/// A member that need not check in with every beat.
struct PatientMember {
    anew: AtomicBool,
    /// Beats since it has checked in.
    beats: AtomicU32,
}

impl PatientMember {
    const fn new() -> Self {
        Self { anew: AtomicBool::new(false), beats: AtomicU32::new(0) }
    }

    /// Counts a beat. Returns true if the member has checked in lately. A check-in between load and
    /// store is lost.
    fn beat(&self) -> bool {
        let beats = if self.anew.load(Relaxed) { 0 } else { self.beats.load(Relaxed).saturating_add(1) };
        self.anew.store(false, Relaxed);
        self.beats.store(beats, Relaxed);
        beats < MOST_BEATS
    }
}

impl CheckIns {
    /// No task yet.
    pub const fn none() -> Self {
        Self { tasks: [const { AtomicBool::new(false) }; 4], patient: [const { PatientMember::new() }; 2] }
    }

    /// Records that a task has run.
    pub fn check_in(&self, member: Member) {
        let Self { tasks: [control, estimate, receive, transmit], patient: [settings, idle] } = self;
        match member {
            Member::Control => control,
            Member::Estimate => estimate,
            Member::Receive => receive,
            Member::Transmit => transmit,
            Member::Settings => &settings.anew,
            Member::Idle => &idle.anew,
        }
        .store(true, Relaxed);
    }

    /// Whether all have checked in; if so, the record is cleared. To be asked once a beat.
    pub fn all_anew(&self) -> bool {
        let [settings, idle] = &self.patient;
        // Both count on, whatever the other one does.
        let (is_settings_well, is_idle_well) = (settings.beat(), idle.beat());
        let all = is_settings_well && is_idle_well && self.tasks.iter().all(|member| member.load(Relaxed));
        if all {
            self.tasks.iter().for_each(|member| member.store(false, Relaxed));
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
