//! Routes messages from a host: commands and readings to the control task, requests to the
//! transmitter.
//!
//! One place for all links, so that a command means the same whichever way it came.

use crate::flag::Flag;
use crate::queue;
use core::sync::atomic::{AtomicU16, Ordering::Relaxed};
use dr_core::Command;
use dr_core::control::Refusal;
use heapless::spsc::Producer;
use wire::{Provocation, Readings, Received, SettingsRequest, ToBoard};

/// A command and the sequence number by which its reply refers to it.
pub type Request = (u16, Command);

/// Result of a command of the settings loader.
pub type Outcome = Result<(), Refusal>;

/// Readings and the sequence number by which the reply refers to them.
pub type Exchange = (u16, Readings);

/// A request to the settings server, and the sequence number by which the reply refers to it.
pub type SettingsJob = (u16, SettingsRequest);

/// Requests that the transmitter carries out by itself.
pub struct TelemetryRequests {
    /// The identity is requested. One reply serves several requests.
    pub identity: Flag,
    telemetry_every: AtomicU16,
}

impl TelemetryRequests {
    /// After a start: the identity is requested, and a sample every tick.
    pub const fn starting() -> Self {
        Self { identity: Flag::new(true), telemetry_every: AtomicU16::new(1) }
    }

    /// A sample every so many ticks.
    pub fn thin(&self, every: u16) {
        self.telemetry_every.store(every, Relaxed);
    }

    /// Returns true if the sample of this tick is requested.
    pub fn wants_sample(&self, tick: u32) -> bool {
        match self.telemetry_every.load(Relaxed) {
            0 => false,
            every => tick.is_multiple_of(u32::from(every)),
        }
    }
}

/// Task to wake after a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wake {
    /// The control task: there is a command or a reading.
    Control,
    /// The control task: the host stops it. The sequence number for the reply.
    Stop(u16),
    /// The transmitter: there is a request.
    Transmit,
    /// The host ends the run.
    Finish(u8),
    /// The simulated front end was silent for a tick; the sequence number for the reply.
    Silence(u16),
    /// The settings server: there is a job.
    SettingsServer,
    /// A fault is to be provoked.
    Provoke(Provocation),
    /// Nobody.
    Nobody,
}

/// The inbox of the instrument.
pub struct Inbox<'a> {
    requests: Producer<'a, Request>,
    exchanges: Producer<'a, Exchange>,
    jobs: Producer<'a, SettingsJob>,
    telemetry_requests: &'a TelemetryRequests,
    is_virtual: bool,
    /// Messages that found their queue full, or that this board does not accept.
    pub refused: u32,
}

impl<'a> Inbox<'a> {
    /// An inbox that fills these queues. Only a virtual board takes readings from a link.
    pub const fn new(
        requests: Producer<'a, Request>,
        exchanges: Producer<'a, Exchange>,
        jobs: Producer<'a, SettingsJob>,
        telemetry_requests: &'a TelemetryRequests,
        is_virtual: bool,
    ) -> Self {
        Self { requests, exchanges, jobs, telemetry_requests, is_virtual, refused: 0 }
    }

    /// Routes a message.
    pub fn accept(&mut self, received: &Received<ToBoard>) -> Wake {
        let to = received.sequence;
        // Where the message has its place in a queue, if there is room.
        let (queued, wake) = match &received.message {
            // Repeated requests do no harm: a host repeats them until it gets a reply.
            ToBoard::Hello => {
                self.telemetry_requests.identity.raise();
                return Wake::Transmit;
            }
            _ if received.repeated => return Wake::Nobody,
            // Ahead of the queue, which may be full.
            ToBoard::Command(Command::Stop) => return Wake::Stop(to),
            ToBoard::Command(command) => (queue::put(&mut self.requests, (to, *command)).is_ok(), Wake::Control),
            ToBoard::Telemetry { every } => {
                self.telemetry_requests.thin(*every);
                return Wake::Nobody;
            }
            ToBoard::Settings(request) => {
                (queue::put(&mut self.jobs, (to, request.clone())).is_ok(), Wake::SettingsServer)
            }
            ToBoard::Readings(readings) if self.is_virtual => {
                (queue::put(&mut self.exchanges, (to, readings.clone())).is_ok(), Wake::Control)
            }
            ToBoard::Finish { code } if self.is_virtual => return Wake::Finish(*code),
            ToBoard::Silence if self.is_virtual => return Wake::Silence(to),
            ToBoard::Provoke(what) if self.is_virtual => return Wake::Provoke(*what),
            ToBoard::Readings(_) | ToBoard::Finish { .. } | ToBoard::Silence | ToBoard::Provoke(_) => {
                (false, Wake::Nobody)
            }
        };
        self.refused = self.refused.wrapping_add((!queued).into());
        if queued { wake } else { Wake::Nobody }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heapless::spsc::Queue;

    fn with_inbox<R>(is_virtual: bool, test: impl FnOnce(&mut Inbox, &TelemetryRequests) -> R) -> R {
        let (mut requests, mut exchanges, mut jobs) =
            (Queue::<_, 3>::new(), Queue::<_, 3>::new(), Queue::<_, 3>::new());
        let telemetry_requests = TelemetryRequests::starting();
        let (requests, exchanges, jobs) = (requests.split().0, exchanges.split().0, jobs.split().0);
        test(&mut Inbox::new(requests, exchanges, jobs, &telemetry_requests, is_virtual), &telemetry_requests)
    }

    fn received(message: ToBoard) -> Received<ToBoard> {
        Received { sequence: 1, repeated: false, message }
    }

    #[test]
    fn a_sensor_board_takes_neither_readings_nor_provocations_from_a_link() {
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
            assert_eq!(inbox.accept(&received(ToBoard::Command(Command::Start))), Wake::Control);
            assert_eq!(inbox.accept(&received(ToBoard::Command(Command::Start))), Wake::Control);
            assert_eq!(inbox.accept(&received(ToBoard::Command(Command::Start))), Wake::Nobody);
            assert_eq!(inbox.refused, 1);
            // But for the one that must not wait.
            assert_eq!(inbox.accept(&received(ToBoard::Command(Command::Stop))), Wake::Stop(1));
            assert_eq!(inbox.refused, 1);
        });
    }

    #[test]
    fn jobs_go_to_the_settings_server_and_beyond_its_queue_are_counted() {
        with_inbox(false, |inbox, _| {
            let job = || received(ToBoard::Settings(SettingsRequest::Load));
            assert_eq!(
                [(); 3].map(|()| inbox.accept(&job())),
                [Wake::SettingsServer, Wake::SettingsServer, Wake::Nobody]
            );
            assert_eq!(inbox.refused, 1);
        });
    }

    #[test]
    fn samples_are_thinned_as_requested() {
        with_inbox(false, |inbox, telemetry_requests| {
            assert!(telemetry_requests.wants_sample(7));
            inbox.accept(&received(ToBoard::Telemetry { every: 10 }));
            assert!(telemetry_requests.wants_sample(20) && !telemetry_requests.wants_sample(21));
            inbox.accept(&received(ToBoard::Telemetry { every: 0 }));
            assert!(!telemetry_requests.wants_sample(0));
            inbox.accept(&received(ToBoard::Hello));
            assert!(telemetry_requests.identity.take() && !telemetry_requests.identity.take());
        });
    }
}
