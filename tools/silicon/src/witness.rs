//! Judges the pins of the heaters by itself: by what host and board have told each other, and by
//! the codes that have passed from the converter to the processor.
//!
//! **Asked for.** A heater may be high from the moment at which the host has asked for a run or a
//! test, until the board answers a `Stop`, sends the sample of a tick in a state that does not
//! heat, or starts anew. A sample of before may come after the request; only one behind the reply
//! to it counts. Events come between ticks, and end nothing.
//!
//! **Read.** A heater may be high only while a valid code of its element is younger than two ticks.
//! This is judged by the bytes on the converter's bus, whatever the board makes of them: the frame
//! begins with its mark, and the code is not at an end of its range. It is judged at every change
//! of the pins and at every conversion. The length of a tick is the last one to which the board has
//! agreed; before, the longest that it grants. A core that is stopped from outside can lower
//! nothing: its watchdog does, within its slowest period.

use crate::adc::{CHANNELS, FRAME_BYTES};
use crate::complaint::{BrokenRule, Complaints};
use crate::time::{CYCLES_PER_SECOND, ms, us};
use dr_core::Command;
use dr_core::control::RunState;
use wire::{FromBoard, Receiver, ToBoard};

/// Half a millisecond of the dead-man timer, and a conversion with its frame.
const LATE: u64 = us(1_000);
/// Longest tick of what the board grants.
const LONGEST_TICK: u64 = ms(1_000);
/// Half a second of the watchdog by the slow oscillator at its slowest.
const WATCHDOG: u64 = ms(950);
/// The upper half of the first byte of a frame (SBAS561, "Data Retrieval").
const MARK: u8 = 0xc;
/// Both ends of the range of 24 bits.
const ENDS: [[u8; 3]; 2] = [[0x7f, 0xff, 0xff], [0x80, 0, 0]];

const PIN: &str = "PC0 to PC5";

/// Knowledge about host and board.
#[derive(Clone, Debug, Default)]
pub struct HeaterWitness {
    from_host: Option<Receiver>,
    from_board: Option<Receiver>,
    may_heat: bool,
    /// The number of a request to heat that has not been answered yet.
    awaits_reply_to: Option<u16>,
    /// The number of a `Stop` that has not been answered yet.
    stop: Option<u16>,
    /// The last state that was reported.
    state: Option<RunState>,
    levels: u8,
    /// Requests for a length of a tick, s, that have not been answered yet.
    asked_ticks: Vec<(u16, f32)>,
    /// Cycles, if it is known.
    tick: Option<u64>,
    /// When a valid code of each channel was read last.
    read_at: [u64; CHANNELS],
    /// Since when nothing is executed, or no interrupt taken, for which the firmware is not to
    /// blame.
    stopped_at: Option<u64>,
}

impl HeaterWitness {
    /// The last state that the board has reported.
    pub const fn state(&self) -> Option<RunState> {
        self.state
    }

    /// A debugger, or a mask of all interrupts, stops the core: until it reads again, or starts.
    pub const fn core_stops(&mut self, now: u64) {
        self.stopped_at = Some(now);
    }

    /// The host sends bytes.
    pub fn sent(&mut self, bytes: &[u8]) {
        let receiver = self.from_host.get_or_insert_with(Receiver::new);
        for message in bytes.iter().filter_map(|&byte| receiver.push::<ToBoard>(byte)) {
            match message.message {
                ToBoard::Command(Command::Start | Command::SelfTest(_)) => {
                    (self.may_heat, self.awaits_reply_to) = (true, Some(message.sequence));
                }
                ToBoard::Command(Command::Stop) => self.stop = Some(message.sequence),
                ToBoard::Command(Command::SamplePeriod { sample_period_s }) => {
                    self.asked_ticks.push((message.sequence, sample_period_s));
                }
                _ => {}
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
                FromBoard::Reply { to, result } => {
                    if self.awaits_reply_to == Some(to) {
                        self.awaits_reply_to = None;
                    }
                    if self.stop.take_if(|stop| *stop == to).is_some() && self.awaits_reply_to.is_none() {
                        self.may_heat = false;
                    }
                    self.asked_ticks.retain(|&(sequence, tick_s)| {
                        if sequence == to && result.is_ok() {
                            self.tick = Some((f64::from(tick_s) * CYCLES_PER_SECOND as f64) as u64);
                        }
                        sequence != to
                    });
                }
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

    /// The processor has read a frame of the converter.
    pub fn read(&mut self, now: u64, frame: &[u8; FRAME_BYTES]) {
        // A frame that was being read comes to its end.
        self.stopped_at.take_if(|at| now > *at + LATE);
        let (status, codes) = frame.split_at(3);
        if status[0] >> 4 != MARK {
            return;
        }
        for (code, read_at) in codes.chunks_exact(3).zip(&mut self.read_at) {
            if ENDS.iter().all(|end| code != end) {
                *read_at = now;
            }
        }
    }

    /// Time has passed.
    pub fn passed(&self, now: u64, complaints: &mut Complaints) {
        if self.levels == 0 {
            return;
        }
        let tick = self.tick.unwrap_or(LONGEST_TICK);
        let oldest = LATE + if self.stopped_at.is_some() { WATCHDOG.max(2 * tick) } else { 2 * tick };
        let is_old = |&(channel, read_at): &(usize, u64)| self.levels >> channel & 1 == 1 && now > read_at + oldest;
        if (0..).zip(self.read_at).any(|of| is_old(&of)) {
            complaints.add(now, PIN, BrokenRule::HeaterUnread);
        }
    }

    /// The pins change.
    pub fn pins(&mut self, now: u64, levels: u8, complaints: &mut Complaints) {
        // Heaters that were high until now, and those that become so.
        self.passed(now, complaints);
        self.levels = levels;
        self.passed(now, complaints);
        self.check(now, complaints);
    }

    /// The board starts anew.
    pub fn restarted(&mut self) {
        *self =
            Self { from_host: self.from_host.take(), levels: self.levels, read_at: self.read_at, ..Self::default() };
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
    use crate::time::ms;
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
    fn a_heater_that_is_high_behind_the_reply_to_a_stop_is_noticed() {
        let (mut witness, mut complaints) = (HeaterWitness::default(), Complaints::default());
        for (number, command) in [(1, Command::Start), (2, Command::Stop)] {
            let mut buffer = [0; wire::MAX_FRAME];
            witness.sent(wire::encode(number, &ToBoard::Command(command), &mut buffer).unwrap());
        }
        witness.pins(2, 0b1, &mut complaints);
        told(&mut witness, 1, &FromBoard::Reply { to: 1, result: Ok(Reply::Done) }, &mut complaints);
        assert_eq!(complaints.all(), []);
        told(&mut witness, 2, &FromBoard::Reply { to: 2, result: Ok(Reply::Done) }, &mut complaints);
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

    #[test]
    fn a_heater_without_a_valid_code_of_its_element_is_noticed_after_two_ticks() {
        let (mut witness, mut complaints) = (HeaterWitness::default(), Complaints::default());
        let mut buffer = [0; wire::MAX_FRAME];
        for (number, command) in [(1, Command::SamplePeriod { sample_period_s: 0.01 }), (2, Command::Start)] {
            witness.sent(wire::encode(number, &ToBoard::Command(command), &mut buffer).unwrap());
            told(&mut witness, number, &FromBoard::Reply { to: number, result: Ok(Reply::Done) }, &mut complaints);
        }
        let mut frame = [1; FRAME_BYTES];
        frame[0] = 0xc0;
        witness.read(ms(100), &frame);
        witness.pins(ms(101), 0b10, &mut complaints);
        // No mark; and the end of the range where the heater is high.
        frame[0] = 0x40;
        witness.read(ms(110), &frame);
        frame[0] = 0xc0;
        frame[6..9].copy_from_slice(&ENDS[1]);
        witness.read(ms(115), &frame);
        witness.passed(ms(120), &mut complaints);
        assert_eq!(complaints.all(), []);
        witness.passed(ms(122), &mut complaints);
        assert_eq!(complaints.all()[0].rule, BrokenRule::HeaterUnread);
        // It is noticed, too, if nobody has looked before the pin falls.
        complaints.clear();
        witness.pins(ms(122), 0, &mut complaints);
        assert_eq!(complaints.all()[0].rule, BrokenRule::HeaterUnread);
    }
}
