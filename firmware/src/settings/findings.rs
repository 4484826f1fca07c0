//! Findings of a self-test on their way from the control task to the settings server.

use dr_core::control::SelfTestFinding;
use wire::settings::TestRecord;
use wire::{Identity, List, Name};

/// The findings of the last self-test that are not kept yet.
#[derive(Debug, Clone, PartialEq)]
pub struct PendingFindings {
    firmware: Name,
    starts: u32,
    unix_s: Option<u32>,
    waiting: List<SelfTestFinding>,
}

impl PendingFindings {
    /// None yet, of this board.
    pub fn of(identity: &Identity) -> Self {
        Self { firmware: identity.firmware.clone(), starts: identity.starts, unix_s: None, waiting: List::new() }
    }

    /// Those of a test that is over, in place of what is left of an earlier one.
    pub fn take(&mut self, unix_s: Option<u32>, findings: &[SelfTestFinding]) {
        self.unix_s = unix_s;
        self.waiting.clear();
        // There is room for as many as any instrument has elements.
        self.waiting.extend_from_slice(findings).ok();
    }

    /// The next one to be kept.
    pub fn take_one(&mut self) -> Option<TestRecord> {
        let finding = self.waiting.pop()?;
        Some(TestRecord { unix_s: self.unix_s, firmware: self.firmware.clone(), starts: self.starts, finding })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::{BoardKind, ResetCause};

    #[test]
    fn each_is_given_once_and_a_newer_test_replaces_what_waits() {
        let firmware = Name::try_from("anemo 1").unwrap();
        let (board, reset) = (BoardKind::Sensor, ResetCause::PowerOn);
        let (crash, unique_id) = (None, [0; 3]);
        let identity =
            Identity { firmware: firmware.clone(), board, elements: 6, order: 8, reset, starts: 3, crash, unique_id };
        let mut findings = PendingFindings::of(&identity);
        assert_eq!(findings.take_one(), None);
        let of = |element| SelfTestFinding { element, of: 2, ..SelfTestFinding::default() };
        findings.take(None, &[of(0), of(1)]);
        findings.take(Some(7), &[of(1), of(0)]);
        let next =
            |element| Some(TestRecord { unix_s: Some(7), firmware: firmware.clone(), starts: 3, finding: of(element) });
        assert_eq!([findings.take_one(), findings.take_one(), findings.take_one()], [next(0), next(1), None]);
    }
}
