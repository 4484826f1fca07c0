//! Where messages from a host go: commands and readings to the control task, questions to the transmitter.
//!
//! One place for all links, so that a command means the same whichever way it came.

use crate::queue;
use core::sync::atomic::{AtomicBool, AtomicU16, Ordering::Relaxed};
use dr_core::control::Command;
use heapless::spsc::Producer;
use wire::{Provocation, Readings, Received, SettingsRequest, ToBoard};

/// A command and the sequence number by which its reply refers to it.
pub type Request = (u16, Command);

/// Readings and the sequence number by which their answer refers to them.
pub type Exchange = (u16, Readings);

/// A request that concerns the settings, and the sequence number by which its answer refers to it.
pub type Errand = (u16, SettingsRequest);

/// Questions that the transmitter answers by itself.
pub struct Questions {
    identity: AtomicBool,
    telemetry_every: AtomicU16,
}

impl Questions {
    /// A board says who it is when it starts; a sample every tick.
    pub const fn new() -> Self {
        Self { identity: AtomicBool::new(true), telemetry_every: AtomicU16::new(1) }
    }

    /// Whether somebody wants to know who this is. Answering once is enough however often it was asked.
    pub fn take_identity(&self) -> bool {
        // No read-modify-write: a question that falls between the two is answered by the answer under way.
        let asked = self.identity.load(Relaxed);
        if asked {
            self.identity.store(false, Relaxed);
        }
        asked
    }

    /// A sample every so many ticks.
    pub fn thin(&self, every: u16) {
        self.telemetry_every.store(every, Relaxed);
    }

    /// Whether this tick's sample is wanted.
    pub fn wants_sample(&self, tick: u32) -> bool {
        match self.telemetry_every.load(Relaxed) {
            0 => false,
            every => tick.is_multiple_of(u32::from(every)),
        }
    }
}

impl Default for Questions {
    fn default() -> Self {
        Self::new()
    }
}

/// What has to be woken after a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wake {
    /// The control task: there is a command or a reading.
    Control,
    /// The transmitter: there is a question.
    Transmit,
    /// The host says that the run is over.
    Finish(u8),
    /// The simulated front end has said nothing for a tick; the sequence number by which that is answered.
    Silence(u16),
    /// The clerk of the settings has an errand.
    Clerk,
    /// Something is to go wrong.
    Provoke(Provocation),
    /// Nobody.
    Nobody,
}

/// The inbox of the instrument.
pub struct Inbox<'a> {
    requests: Producer<'a, Request>,
    exchanges: Producer<'a, Exchange>,
    errands: Producer<'a, Errand>,
    questions: &'a Questions,
    is_virtual: bool,
    /// Messages that came when their queue was full, or that this board does not obey.
    pub refused: u32,
}

impl<'a> Inbox<'a> {
    /// An inbox that fills these queues. Only a virtual board takes readings from a link.
    pub const fn new(
        requests: Producer<'a, Request>,
        exchanges: Producer<'a, Exchange>,
        errands: Producer<'a, Errand>,
        questions: &'a Questions,
        is_virtual: bool,
    ) -> Self {
        Self { requests, exchanges, errands, questions, is_virtual, refused: 0 }
    }

    /// Puts a message where it belongs.
    pub fn accept(&mut self, received: &Received<ToBoard>) -> Wake {
        match &received.message {
            // Asking twice does no harm, and a host asks until it is answered.
            ToBoard::Hello => {
                self.questions.identity.store(true, Relaxed);
                Wake::Transmit
            }
            _ if received.repeated => Wake::Nobody,
            ToBoard::Command(command) => {
                let queued = queue::put(&mut self.requests, (received.sequence, *command)).is_ok();
                self.wake_control_if(queued)
            }
            ToBoard::Telemetry { every } => {
                self.questions.thin(*every);
                Wake::Nobody
            }
            ToBoard::Readings(readings) if self.is_virtual => {
                let queued = queue::put(&mut self.exchanges, (received.sequence, readings.clone())).is_ok();
                self.wake_control_if(queued)
            }
            ToBoard::Settings(request) => {
                let queued = queue::put(&mut self.errands, (received.sequence, request.clone())).is_ok();
                if queued { Wake::Clerk } else { self.wake_control_if(false) }
            }
            ToBoard::Finish { code } if self.is_virtual => Wake::Finish(*code),
            ToBoard::Silence if self.is_virtual => Wake::Silence(received.sequence),
            ToBoard::Provoke(what) if self.is_virtual => Wake::Provoke(*what),
            ToBoard::Readings(_) | ToBoard::Finish { .. } | ToBoard::Silence | ToBoard::Provoke(_) => {
                self.wake_control_if(false)
            }
        }
    }

    /// Control has something to do if the message is in its queue; otherwise nobody has.
    fn wake_control_if(&mut self, queued: bool) -> Wake {
        if queued {
            return Wake::Control;
        }
        self.refused = self.refused.wrapping_add(1);
        Wake::Nobody
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heapless::spsc::Queue;

    fn with_inbox<R>(is_virtual: bool, test: impl FnOnce(&mut Inbox, &Questions) -> R) -> R {
        let (mut requests, mut exchanges, mut errands) =
            (Queue::<_, 3>::new(), Queue::<_, 3>::new(), Queue::<_, 3>::new());
        let questions = Questions::new();
        let (requests, exchanges, errands) = (requests.split().0, exchanges.split().0, errands.split().0);
        test(&mut Inbox::new(requests, exchanges, errands, &questions, is_virtual), &questions)
    }

    fn received(message: ToBoard) -> Received<ToBoard> {
        Received { sequence: 1, repeated: false, message }
    }

    #[test]
    fn a_sensor_board_takes_neither_readings_nor_trouble_from_a_link() {
        let readings = Readings::new(&[dr_core::sensor::Reading::Code(1); 6]).unwrap();
        with_inbox(false, |inbox, _| {
            assert_eq!(inbox.accept(&received(ToBoard::Readings(readings.clone()))), Wake::Nobody);
            assert_eq!(inbox.accept(&received(ToBoard::Finish { code: 0 })), Wake::Nobody);
            assert_eq!(inbox.accept(&received(ToBoard::Silence)), Wake::Nobody);
            assert_eq!(inbox.accept(&received(ToBoard::Provoke(Provocation::Panic))), Wake::Nobody);
            assert_eq!(inbox.refused, 4);
        });
        with_inbox(true, |inbox, _| {
            assert_eq!(inbox.accept(&received(ToBoard::Readings(readings))), Wake::Control);
            assert_eq!(inbox.accept(&received(ToBoard::Finish { code: 7 })), Wake::Finish(7));
            assert_eq!(inbox.accept(&received(ToBoard::Silence)), Wake::Silence(1));
            let reset = ToBoard::Provoke(Provocation::Reset);
            assert_eq!(inbox.accept(&received(reset)), Wake::Provoke(Provocation::Reset));
        });
    }

    #[test]
    fn a_repeated_command_is_not_carried_out_again() {
        with_inbox(false, |inbox, _| {
            let again = Received { sequence: 1, repeated: true, message: ToBoard::Command(Command::Start) };
            assert_eq!(inbox.accept(&again), Wake::Nobody);
            assert_eq!(
                inbox.accept(&Received { sequence: 1, repeated: true, message: ToBoard::Hello }),
                Wake::Transmit
            );
        });
    }

    #[test]
    fn commands_beyond_the_queue_are_counted() {
        with_inbox(false, |inbox, _| {
            assert_eq!(inbox.accept(&received(ToBoard::Command(Command::Stop))), Wake::Control);
            assert_eq!(inbox.accept(&received(ToBoard::Command(Command::Stop))), Wake::Control);
            assert_eq!(inbox.accept(&received(ToBoard::Command(Command::Stop))), Wake::Nobody);
            assert_eq!(inbox.refused, 1);
        });
    }

    #[test]
    fn errands_are_the_clerks_and_no_more_than_wait_for_him() {
        with_inbox(false, |inbox, _| {
            let errand = || received(ToBoard::Settings(SettingsRequest::Load));
            assert_eq!([(); 3].map(|()| inbox.accept(&errand())), [Wake::Clerk, Wake::Clerk, Wake::Nobody]);
            assert_eq!(inbox.refused, 1);
        });
    }

    #[test]
    fn samples_are_thinned_as_asked() {
        with_inbox(false, |inbox, questions| {
            assert!(questions.wants_sample(7));
            inbox.accept(&received(ToBoard::Telemetry { every: 10 }));
            assert!(questions.wants_sample(20) && !questions.wants_sample(21));
            inbox.accept(&received(ToBoard::Telemetry { every: 0 }));
            assert!(!questions.wants_sample(0));
            inbox.accept(&received(ToBoard::Hello));
            assert!(questions.take_identity() && !questions.take_identity());
        });
    }
}
