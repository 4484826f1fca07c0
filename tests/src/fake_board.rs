//! A sensor board that is not there: the firmware's own inbox, outbox and controller around the
//! simulated sensor, at the end of a pseudo-terminal, a few hundred times faster than real time.
//! And it can have everything that a cable and a board can have.

use crate::{foreign_frame, sensor};
use dr_core::control::{Cause, HardwareLimits, RunState};
use dr_core::sensor::Reading;
use dr_core::{Command, Instrument, Reply};
use firmware::drivers::ads131e06::CHANNELS;
use firmware::inbox::{Exchange, Inbox, Request, SettingsJob, TelemetryRequests, Wake};
use firmware::outbox::{Outbox, Sequence};
use heapless::spsc::Queue;
use host_sim::experiment::Experiment;
use host_sim::sensor::Sensor;
use nix::fcntl::OFlag;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::pty::{PtyMaster, grantpt, posix_openpt, ptsname_r, unlockpt};
use nix::sys::termios::{SetArg, cfmakeraw, tcgetattr, tcsetattr};
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use wire::{
    BoardKind, ControlStatus, FromBoard, Identity, MAX_FRAME, Name, Received, Receiver, ResetCause, Status, ToBoard,
};

/// A tick, in standby and in a run, and what waking up takes beyond. Standby is slower, because
/// nobody may be reading.
const STANDBY_TICK: Duration = Duration::from_millis(2);
const RUNNING_TICK: Duration = Duration::from_micros(100);

/// A second of the board, by which it sends its status.
const SECOND: Duration = Duration::from_millis(20);

/// Faults of the board or its cable. By default, nothing.
#[derive(Clone, Default)]
pub struct Quirks {
    /// Says nothing and hears nothing.
    pub mute: bool,
    /// Speaks the next version of the protocol, and obeys no other.
    pub foreign: bool,
    /// The first command of this kind does not arrive.
    pub lost_command: Option<fn(&Command) -> bool>,
    /// The first reply to a command of this kind does not arrive.
    pub lost_reply: Option<fn(&Command) -> bool>,
    /// Samples of these ticks do not arrive.
    pub lost_samples: Vec<u32>,
    /// Bytes that come before the samples of these ticks.
    pub garbage: Vec<(u32, Vec<u8>)>,
    /// Falls silent before this tick of the run.
    pub silent_from: Option<u32>,
    /// Starts anew, by its watchdog, before this tick of the run.
    pub restarts_at: Option<u32>,
    /// Is unplugged before this tick of the run.
    pub unplugged_at: Option<u32>,
    /// Before this tick of the run the cable is out, for so long; the board goes on.
    pub cable_out: Option<(u32, Duration)>,
}

/// Report of the board afterwards.
#[derive(Debug, Default)]
pub struct Report {
    /// Commands that were carried out.
    pub obeyed: Vec<Command>,
    /// Counters of what arrived.
    pub link: wire::LinkCounters,
    /// The state at the end.
    pub state: RunState,
}

/// A board at the end of a pseudo-terminal.
pub struct FakeBoard {
    /// The port at which it is.
    pub device: String,
    /// Keeps the port open between one host and the next.
    _port: File,
    ended: Arc<AtomicBool>,
    mended: Arc<AtomicBool>,
    running: Arc<AtomicBool>,
    sent: Arc<AtomicU32>,
    thread: JoinHandle<Report>,
}

impl FakeBoard {
    /// Switches it on, with the sphere of an experiment around it.
    pub fn new(experiment: &Experiment, quirks: Quirks) -> Self {
        let (board, port, device) = pseudo_terminal().expect("the system has pseudo-terminals");
        let flag = || Arc::new(AtomicBool::new(false));
        let (ended, mended, running) = (flag(), flag(), flag());
        let sent = Arc::new(AtomicU32::new(0));
        let life = Life {
            experiment: experiment.clone(),
            quirks,
            cable: Cable { port: Some(board), ended: Arc::clone(&ended), out_until: None },
            mended: Arc::clone(&mended),
            running: Arc::clone(&running),
            sent: Arc::clone(&sent),
        };
        let thread = std::thread::spawn(move || life.live());
        Self { device, _port: port, ended, mended, running, sent, thread }
    }

    /// Tells whether a run is under way.
    pub fn is_running(&self) -> bool {
        self.running.load(Relaxed)
    }

    /// Samples of the run that have gone out.
    pub fn sent(&self) -> u32 {
        self.sent.load(Relaxed)
    }

    /// Repairs whatever resistor is broken.
    pub fn mend(&self) {
        self.mended.store(true, Relaxed);
    }

    /// Switches it off.
    pub fn finish(self) -> Report {
        self.ended.store(true, Relaxed);
        self.thread.join().expect("the fake board does not fail")
    }
}

/// A pseudo-terminal that carries bytes as they are: the board's end, the host's end and its name.
/// Programs that are started meanwhile inherit neither, so that closing the board's end is what
/// pulling its plug is.
fn pseudo_terminal() -> nix::Result<(PtyMaster, File, String)> {
    let board = posix_openpt(OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_NONBLOCK | OFlag::O_CLOEXEC)?;
    grantpt(&board)?;
    unlockpt(&board)?;
    let device = ptsname_r(&board)?;
    let port = OpenOptions::new().read(true).write(true).open(&device).map_err(|_| nix::Error::ENOENT)?;
    let mut settings = tcgetattr(&port)?;
    cfmakeraw(&mut settings);
    tcsetattr(&port, SetArg::TCSANOW, &settings)?;
    Ok((board, port, device))
}

/// The board's end of it.
struct Cable {
    port: Option<PtyMaster>,
    ended: Arc<AtomicBool>,
    out_until: Option<Instant>,
}

impl Cable {
    fn is_alive(&self) -> bool {
        self.port.is_some() && !self.ended.load(Relaxed)
    }

    /// Reads what has come, after a tick.
    fn read(&mut self, buffer: &mut [u8], tick: Duration) -> usize {
        std::thread::sleep(tick);
        let read = self.port.as_mut().map_or(0, |port| port.read(buffer).unwrap_or(0));
        if self.is_out() { 0 } else { read }
    }

    fn is_out(&self) -> bool {
        self.out_until.is_some_and(|until| Instant::now() < until)
    }

    /// Waits for a host that is slow, until the board is switched off.
    fn write(&mut self, mut bytes: &[u8]) {
        if self.is_out() {
            return;
        }
        let Some(port) = &mut self.port else { return };
        while !bytes.is_empty() && !self.ended.load(Relaxed) {
            match port.write(bytes) {
                Ok(written) => bytes = &bytes[written..],
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    let _ = poll(&mut [PollFd::new(port.as_fd(), PollFlags::POLLOUT)], PollTimeout::from(20_u8));
                }
                Err(error) => panic!("the pseudo-terminal broke: {error}"),
            }
        }
    }
}

/// Sensor, controller and counters: what the firmware has in its resources.
struct Life {
    experiment: Experiment,
    quirks: Quirks,
    cable: Cable,
    mended: Arc<AtomicBool>,
    running: Arc<AtomicBool>,
    sent: Arc<AtomicU32>,
}

impl Life {
    fn live(mut self) -> Report {
        if self.quirks.mute || self.quirks.foreign {
            return self.stay_away();
        }
        // It keeps no settings: nobody takes these.
        let mut errands = Queue::<SettingsJob, 2>::new();
        let (mut requests, mut exchanges, mut messages) =
            (Queue::<Request, 8>::new(), Queue::<Exchange, 4>::new(), Queue::<FromBoard, 32>::new());
        let ((request_in, mut requests), (exchange_in, _), (message_in, mut messages)) =
            (requests.split(), exchanges.split(), messages.split());
        let questions = TelemetryRequests::starting();
        let mut inbox = Inbox::new(request_in, exchange_in, errands.split().0, &questions, false);
        let mut outbox = Outbox::new(message_in);
        let (mut receiver, mut sequence) = (Receiver::new(), Sequence::new());
        let mut station = Instrument::<CHANNELS>::new(&HardwareLimits::SIMULATED);
        let mut sensor = self.new_sensor();
        let (mut obeyed, mut unheard, mut stop) = (Vec::new(), None, None);
        let (mut reset, mut starts, mut uptime_s, mut last_status) = (ResetCause::PowerOn, 1, 0, Instant::now());
        let mut buffer = [0; 256];
        let mut between_frames = receiver.clone();
        while self.cable.is_alive() {
            let is_running = station.controller().state() == RunState::Running;
            self.running.store(is_running, Relaxed);
            let read = self.cable.read(&mut buffer, if is_running { RUNNING_TICK } else { STANDBY_TICK });
            for &byte in &buffer[..read] {
                match receiver.push::<ToBoard>(byte) {
                    Some(Received { message: ToBoard::Command(command), .. })
                        if is_first(&mut self.quirks.lost_command, &command) =>
                    {
                        receiver = between_frames.clone();
                    }
                    Some(received) => {
                        if let Wake::Stop(to) = inbox.accept(&received) {
                            stop = Some((to, Command::Stop));
                        }
                    }
                    None => {}
                }
                if byte == 0 {
                    between_frames = receiver.clone();
                }
            }
            while let Some((to, command)) = requests.dequeue().or_else(|| stop.take()) {
                let result = station.handle(command);
                if is_first(&mut self.quirks.lost_reply, &command) {
                    unheard = Some(to);
                }
                if result.is_ok() {
                    obeyed.push(command);
                }
                if let Ok(Reply::Started { .. }) = result {
                    // The run that the simulated instruments make, from its very beginning.
                    sensor = self.new_sensor();
                }
                outbox.put(FromBoard::Reply { to, result });
            }

            let (tick, is_running) = (station.controller().ticks(), station.controller().state() == RunState::Running);
            let due = |at: Option<u32>| is_running && at == Some(tick);
            if due(self.quirks.unplugged_at) {
                self.cable.port = None;
                break;
            }
            if let Some((at, out)) = self.quirks.cable_out
                && due(Some(at))
            {
                self.cable.out_until = Some(Instant::now() + out);
            }
            if due(self.quirks.silent_from) {
                return self.stay_away();
            }
            if due(self.quirks.restarts_at) {
                (station, receiver, sequence) =
                    (Instrument::new(&HardwareLimits::SIMULATED), Receiver::new(), Sequence::new());
                (reset, starts, uptime_s) = (ResetCause::Watchdog, starts + 1, 0);
                station.trip(Cause::Watchdog);
            }
            if self.mended.swap(false, Relaxed) {
                self.experiment.faults.clear();
                sensor = self.new_sensor();
            }
            // Without a sample period there are no ticks.
            if station.controller().sample_period_s().is_some() {
                let mut read = [Reading::Missing; CHANNELS];
                for (read, code) in read.iter_mut().zip(sensor.codes_of(station.input())) {
                    *read = Reading::Code(code);
                }
                let tick = station.tick(&read);
                sensor.advance(tick.heaters.0);
                if let Some(test) = station.take_self_test() {
                    test.findings().iter().for_each(|finding| outbox.put(FromBoard::Tested(*finding)));
                }
                if questions.wants_sample(tick.tick) {
                    outbox.put(FromBoard::of_tick(&tick));
                }
            }

            let unsent = outbox.unsent;
            let mut send = |message: &FromBoard| {
                let mut frame = [0; MAX_FRAME];
                let frame = wire::encode(sequence.next(unsent), message, &mut frame).expect("it fits a frame");
                self.send(message, frame, &mut unheard);
            };
            if questions.identity.take() {
                let firmware = Name::try_from("fake board").expect("it is short");
                let (board, elements, order) = (BoardKind::Sensor, CHANNELS as u8, dr_core::model::ORDER as u8);
                let (crash, unique_id) = (None, [0; 3]);
                send(&FromBoard::Identity(Identity {
                    firmware,
                    board,
                    elements,
                    order,
                    reset,
                    starts,
                    crash,
                    unique_id,
                }));
            }
            while let Some(message) = messages.dequeue() {
                send(&message);
            }
            if last_status.elapsed() >= SECOND {
                (last_status, uptime_s) = (Instant::now(), uptime_s + 1);
                let controller = station.controller();
                let control = ControlStatus {
                    state: controller.state(),
                    bit_flips: controller.bit_flips(),
                    history: controller.lockout().history(),
                    armed: controller.is_armed(),
                    margins: controller.margins().collect(),
                    ..ControlStatus::default()
                };
                let (link, refused, unsent) = (receiver.counters(), inbox.refused, outbox.unsent);
                send(&FromBoard::Status(Status { uptime_s, link, refused, unsent, deadlines: 0, control }));
            }
        }
        Report { obeyed, link: receiver.counters(), state: station.controller().state() }
    }

    fn new_sensor(&self) -> Sensor {
        sensor(&self.experiment)
    }

    /// Puts a frame on the cable, or what becomes of it.
    fn send(&mut self, message: &FromBoard, frame: &[u8], unheard: &mut Option<u16>) {
        match message {
            FromBoard::Reply { to, .. } if *unheard == Some(*to) => return *unheard = None,
            FromBoard::Sample(sample) if sample.state == RunState::Running => {
                if self.quirks.lost_samples.contains(&sample.tick) {
                    return;
                }
                let Self { quirks, cable, .. } = self;
                let garbage = quirks.garbage.iter().filter(|(tick, _)| *tick == sample.tick);
                garbage.for_each(|(_, bytes)| cable.write(bytes));
                self.cable.write(frame);
                return self.sent.store(sample.tick + 1, Relaxed);
            }
            _ => {}
        }
        self.cable.write(frame);
    }

    /// Says nothing, or nothing that this version understands.
    fn stay_away(mut self) -> Report {
        while self.cable.is_alive() {
            self.cable.read(&mut [0; 256], SECOND);
            if self.quirks.foreign {
                // A status, as far as anybody knows.
                self.cable.write(&foreign_frame(&[3, 1, 2, 3]));
            }
        }
        Report::default()
    }
}

/// Tells whether this is the first command of its kind.
fn is_first(kind: &mut Option<fn(&Command) -> bool>, command: &Command) -> bool {
    let is_one = kind.is_some_and(|is_one| is_one(command));
    if is_one {
        *kind = None;
    }
    is_one
}
