//! Holds the pins of the heaters against what host and board have told each other.
//!
//! A heater may be high from the moment at which the host has asked for a run or a test, until the
//! board sends the sample of a tick in a state that does not heat, or starts anew. A sample of
//! before may come after the request; only one behind the reply to it counts. Events come between
//! ticks, and levels follow a command at the next one: they end nothing.

use crate::complaint::{BrokenRule, Complaints};
use dr_core::Command;
use dr_core::control::RunState;
use wire::{FromBoard, Receiver, ToBoard};

const PIN: &str = "PC0 to PC5";

/// What is known of host and board.
#[derive(Clone, Debug, Default)]
pub struct HeaterWitness {
    from_host: Option<Receiver>,
    from_board: Option<Receiver>,
    may_heat: bool,
    /// The number of a request to heat that has not been answered yet.
    awaits_reply_to: Option<u16>,
    /// The last state that was reported.
    state: Option<RunState>,
    levels: u8,
}

impl HeaterWitness {
    /// The last state that the board has reported.
    pub const fn state(&self) -> Option<RunState> {
        self.state
    }

    /// The host sends bytes.
    pub fn sent(&mut self, bytes: &[u8]) {
        let receiver = self.from_host.get_or_insert_with(Receiver::new);
        for message in bytes.iter().filter_map(|&byte| receiver.push::<ToBoard>(byte)) {
            if let ToBoard::Command(Command::Start | Command::SelfTest(_)) = message.message {
                (self.may_heat, self.awaits_reply_to) = (true, Some(message.sequence));
            }
        }
    }

    /// The board has sent bytes.
    pub fn heard(&mut self, now: u64, bytes: &[u8], complaints: &mut Complaints) {
        let receiver = self.from_board.get_or_insert_with(Receiver::new);
        let messages: Vec<_> = bytes
            .iter()
            .filter_map(|&byte| receiver.push::<FromBoard>(byte))
            .map(|received| received.message)
            .collect();
        for message in messages {
            match message {
                FromBoard::Sample(sample) => self.reported(sample.state),
                FromBoard::Observed(observed) => self.reported(observed.sample.state),
                FromBoard::Event(event) => self.state = Some(event.state),
                FromBoard::Reply { to, .. } if self.awaits_reply_to == Some(to) => self.awaits_reply_to = None,
                _ => {}
            }
            self.check(now, complaints);
        }
    }

    fn reported(&mut self, state: RunState) {
        self.state = Some(state);
        if self.awaits_reply_to.is_none() && matches!(state, RunState::Standby | RunState::Tripped(_)) {
            self.may_heat = false;
        }
    }

    /// The pins change.
    pub fn pins(&mut self, now: u64, levels: u8, complaints: &mut Complaints) {
        self.levels = levels;
        self.check(now, complaints);
    }

    /// The board starts anew.
    pub fn restarted(&mut self) {
        (self.may_heat, self.awaits_reply_to, self.state, self.from_board) = (false, None, None, None);
    }

    fn check(&self, now: u64, complaints: &mut Complaints) {
        if self.levels != 0 && !self.may_heat {
            complaints.add(now, PIN, BrokenRule::HeaterHigh);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::Reply;
    use dr_core::control::{Cause, Heaters, Trip};
    use wire::{Event, List, Sample};

    fn sample(state: RunState) -> FromBoard {
        let (temperature_c, power_w) = (List::new(), List::new());
        FromBoard::Sample(Sample { tick: 0, heaters: Heaters(0), valid: 0, state, temperature_c, power_w })
    }

    fn told(witness: &mut HeaterWitness, number: u16, message: &FromBoard, complaints: &mut Complaints) {
        let mut buffer = [0; wire::MAX_FRAME];
        witness.heard(1, wire::encode(number, message, &mut buffer).unwrap(), complaints);
    }

    #[test]
    fn a_heater_may_be_high_from_the_request_to_the_report_of_a_trip() {
        let (mut witness, mut complaints) = (HeaterWitness::default(), Complaints::default());
        let mut buffer = [0; wire::MAX_FRAME];
        witness.sent(wire::encode(1, &ToBoard::Command(Command::Start), &mut buffer).unwrap());
        // Sent before the request arrived.
        told(&mut witness, 1, &sample(RunState::Standby), &mut complaints);
        told(&mut witness, 2, &FromBoard::Reply { to: 1, result: Ok(Reply::Done) }, &mut complaints);
        witness.pins(2, 0b1, &mut complaints);
        assert_eq!(complaints.all(), []);
        let state = RunState::Tripped(Trip { cause: Cause::Deadline, element: None });
        told(&mut witness, 3, &FromBoard::Event(Event { tick: 9, state }), &mut complaints);
        assert_eq!(complaints.all(), []);
        told(&mut witness, 4, &sample(state), &mut complaints);
        assert_eq!(complaints.all()[0].rule, BrokenRule::HeaterHigh);
    }

    #[test]
    fn a_heater_that_is_high_unasked_or_after_a_restart_is_noticed() {
        let (mut witness, mut complaints) = (HeaterWitness::default(), Complaints::default());
        witness.pins(1, 0b10, &mut complaints);
        assert_eq!(complaints.all()[0].times, 1);
        let mut buffer = [0; wire::MAX_FRAME];
        witness.sent(wire::encode(1, &ToBoard::Command(Command::Start), &mut buffer).unwrap());
        witness.restarted();
        witness.pins(2, 0b10, &mut complaints);
        assert_eq!(complaints.all()[0].times, 2);
    }
}
