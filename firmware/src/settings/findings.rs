//! Findings of a self-test on their way from the control task to the settings server.

use dr_core::control::SelfTestFinding;
use wire::settings::TestRecord;
use wire::{Identity, List};

/// Findings of the last self-test, until the settings server takes them.
#[derive(Debug, Clone, PartialEq)]
pub struct PendingFindings(TestRecord);

impl PendingFindings {
    /// No findings yet, of this board.
    pub fn of(identity: &Identity) -> Self {
        let (firmware, starts) = (identity.firmware.clone(), identity.starts);
        Self(TestRecord { unix_s: None, firmware, starts, findings: List::new() })
    }

    /// Puts the findings of a test in the place of those that wait.
    pub fn put(&mut self, unix_s: Option<u32>, findings: &[SelfTestFinding]) {
        self.0.unix_s = unix_s;
        self.0.findings.clear();
        // There is room for as many as any instrument has elements.
        self.0.findings.extend_from_slice(findings).ok();
    }

    /// Takes the findings, if there are any.
    pub fn take(&mut self) -> Option<TestRecord> {
        let waiting = (!self.0.findings.is_empty()).then(|| self.0.clone());
        self.0.findings.clear();
        waiting
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::{BoardKind, Name, ResetCause};

    #[test]
    fn they_are_given_once_and_a_newer_test_replaces_what_waits() {
        let firmware = Name::try_from("anemo 1").unwrap();
        let (board, reset) = (BoardKind::Sensor, ResetCause::PowerOn);
        let (crash, unique_id) = (None, [0; 3]);
        let identity =
            Identity { firmware: firmware.clone(), board, elements: 6, order: 8, reset, starts: 3, crash, unique_id };
        let mut pending = PendingFindings::of(&identity);
        assert_eq!(pending.take(), None);
        let of = |element| SelfTestFinding { element, of: 2, ..SelfTestFinding::default() };
        pending.put(None, &[of(1), of(0)]);
        pending.put(Some(7), &[of(0), of(1)]);
        let findings = [of(0), of(1)].into_iter().collect();
        assert_eq!(pending.take(), Some(TestRecord { unix_s: Some(7), firmware, starts: 3, findings }));
        assert_eq!(pending.take(), None);
    }
}
