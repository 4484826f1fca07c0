//! A conversation with a board: messages out, messages in, and how long to wait for them.

use super::error::InstrumentError;
use dr_core::control::Refusal;
use dr_core::{Command, Reply};
use std::io::{self, ErrorKind};
use std::sync::LazyLock;
use std::time::{Duration, Instant};
use wire::{
    FromBoard, Identity, LinkCounters, MAX_FRAME, Receiver, SettingsAnswer, SettingsReply, SettingsRequest, ToBoard,
    VERSION,
};

/// Time that a board may take to answer. Half a minute of emulation on a busy machine is still not
/// an error.
pub const TIMEOUT: Duration = Duration::from_secs(20);

/// Time to wait for an answer to a hello before asking again: a board drops what comes while it
/// starts.
const HELLO_EVERY: Duration = Duration::from_millis(50);

/// A host that has sent nothing for so long shows that it is still there.
const KEEP_ALIVE: Duration = Duration::from_secs(1);

/// Number of times that a command is sent before its board counts as gone, and how long each
/// attempt waits for an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RetryPolicy {
    /// At least 1.
    pub tries: u32,
    /// Timeout of each.
    pub timeout: Duration,
}

/// Takes messages that are no answer.
pub type Aside<'a> = &'a mut dyn FnMut(FromBoard);

/// A way to a board.
pub trait BoardStream {
    /// The time by the clock that the board lives by, counted from any moment. Timeouts are meant
    /// in it.
    fn now(&self) -> Duration {
        real_time()
    }

    /// The wind that a simulated sensor at the other end has felt last, m/s.
    fn true_wind_m_s(&self) -> Option<[f64; 3]> {
        None
    }

    /// Reads what has come, waiting for it at most so long.
    ///
    /// # Errors
    /// [`ErrorKind::TimedOut`] if nothing has come, [`ErrorKind::UnexpectedEof`] if the other end
    /// is gone.
    fn read_within(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize>;

    /// Writes all of it.
    ///
    /// # Errors
    /// If the other end is gone.
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// The clock of this computer, counted from its first use.
fn real_time() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

/// A conversation over a stream.
pub struct BoardLink<S> {
    stream: S,
    sequence: u16,
    /// When the last message was sent.
    sent: Duration,
    receiver: Receiver,
    buffer: Box<[u8; 4096]>,
    read: usize,
    taken: usize,
}

impl<S: BoardStream> BoardLink<S> {
    /// A conversation that has not begun.
    pub fn new(stream: S) -> Self {
        let (sent, receiver, buffer) = (Duration::ZERO, Receiver::new(), Box::new([0; 4096]));
        Self { stream, sequence: 0, sent, receiver, buffer, read: 0, taken: 0 }
    }

    /// Counters of what has come so far.
    pub fn counters(&self) -> LinkCounters {
        self.receiver.counters()
    }

    /// The time by the stream's clock.
    pub fn now(&self) -> Duration {
        self.stream.now()
    }

    /// The stream itself, for tests that put something else on it.
    pub fn stream_mut(&mut self) -> &mut S {
        &mut self.stream
    }

    /// Sends a message; gives its sequence number.
    ///
    /// # Errors
    /// If the other end is gone.
    pub fn send(&mut self, message: &ToBoard) -> Result<u16, InstrumentError> {
        let mut buffer = [0; MAX_FRAME];
        let sequence = self.sequence;
        let frame = wire::encode(sequence, message, &mut buffer)
            .map_err(|error| InstrumentError::Protocol(format!("a message does not fit a frame: {error}")))?;
        self.stream.write_all(frame)?;
        self.sequence = sequence.wrapping_add(1);
        self.sent = self.now();
        Ok(sequence)
    }

    /// Shows a board that its host is still there, where nothing else has been said for a second: a
    /// board that heats and hears nothing for its `host_timeout_s` trips.
    ///
    /// # Errors
    /// If the other end is gone.
    pub fn keep_alive(&mut self) -> Result<(), InstrumentError> {
        if self.now().saturating_sub(self.sent) >= KEEP_ALIVE {
            self.send(&ToBoard::Hello)?;
        }
        Ok(())
    }

    /// The next message, waiting for it at most so long.
    ///
    /// # Errors
    /// [`InstrumentError::Silent`] if there is none, [`InstrumentError::Unusable`] if the board
    /// speaks another version.
    pub fn receive(&mut self, timeout: Duration) -> Result<FromBoard, InstrumentError> {
        let deadline = self.now() + timeout;
        loop {
            while self.taken < self.read {
                let byte = self.buffer[self.taken];
                self.taken += 1;
                if let Some(received) = self.receiver.push::<FromBoard>(byte)
                    && !received.repeated
                {
                    return Ok(received.message);
                }
            }
            if let Some(theirs) = self.receiver.foreign_version() {
                return Err(InstrumentError::Unusable(other_version(theirs)));
            }
            let left = deadline.saturating_sub(self.now());
            self.taken = 0;
            self.read = 0;
            self.read = match self.stream.read_within(&mut self.buffer[..], left) {
                Err(error) if error.kind() == ErrorKind::TimedOut => return Err(InstrumentError::Silent(timeout)),
                // A signal, such as Ctrl-C: whoever asked for the run looks after it.
                Err(error) if error.kind() == ErrorKind::Interrupted => 0,
                other => other?,
            };
        }
    }

    /// Sends hello until the board answers.
    ///
    /// # Errors
    /// As [`receive`](Self::receive).
    pub fn hello(&mut self, timeout: Duration) -> Result<Identity, InstrumentError> {
        let deadline = self.now() + timeout;
        loop {
            self.send(&ToBoard::Hello)?;
            let next = self.now() + HELLO_EVERY;
            loop {
                match self.receive(next.saturating_sub(self.now())) {
                    Ok(FromBoard::Identity(identity)) => return Ok(identity),
                    // A board that is running talks all the time.
                    Ok(_) if self.now() < next => {}
                    Ok(_) | Err(InstrumentError::Silent(_)) => break,
                    Err(error) => return Err(error),
                }
            }
            if self.now() >= deadline {
                return Err(InstrumentError::Silent(timeout));
            }
        }
    }

    /// Sends a command and waits for its reply; what else comes meanwhile goes to `aside`.
    ///
    /// A command whose reply does not come is sent again, under a new number: under the old one the
    /// board would drop it, if it was only the reply that got lost. Doing a command twice leaves
    /// the board as doing it once; a second `Start` or `Acknowledge` is refused, which then says
    /// that the first one was carried out, and is answered `Done`.
    ///
    /// # Errors
    /// If the command is refused, or the board does not answer.
    pub fn command(&mut self, command: Command, retries: RetryPolicy, aside: Aside) -> Result<Reply, InstrumentError> {
        self.converse(&ToBoard::Command(command), retries, aside, |message, again| match message {
            FromBoard::Reply { to, result } => Some((
                *to,
                match *result {
                    Err(refusal) if again && shows_it_done(command, &refusal) => Ok(Reply::Done),
                    result => result.map_err(InstrumentError::Refused),
                },
            )),
            _ => None,
        })
    }

    /// Sends a request about settings and waits for the answer, as [`command`](Self::command) does:
    /// a repeated request does no harm.
    ///
    /// # Errors
    /// If it is refused, or the board does not answer.
    pub fn ask(
        &mut self,
        request: &SettingsRequest,
        retries: RetryPolicy,
        aside: Aside,
    ) -> Result<SettingsReply, InstrumentError> {
        self.converse(&ToBoard::Settings(request.clone()), retries, aside, |message, _| match message {
            FromBoard::Setting(SettingsAnswer { to, result }) => {
                Some((*to, result.clone().map_err(InstrumentError::Settings)))
            }
            _ => None,
        })
    }

    /// Sends a message until it is answered. `answer` gives the number that a message answers and
    /// what it says, if it is an answer of this kind; it is told whether the message was sent more
    /// than once.
    fn converse<T>(
        &mut self,
        message: &ToBoard,
        retries: RetryPolicy,
        aside: Aside,
        answer: impl Fn(&FromBoard, bool) -> Option<(u16, Result<T, InstrumentError>)>,
    ) -> Result<T, InstrumentError> {
        let mut first = None;
        for _ in 0..retries.tries {
            let last = self.send(message)?;
            let first = *first.get_or_insert(last);
            let deadline = self.now() + retries.timeout;
            loop {
                match self.receive(deadline.saturating_sub(self.now())) {
                    Ok(message) => match answer(&message, last != first) {
                        // The answer to any of the tries: one may only have been late.
                        Some((to, result)) if to.wrapping_sub(first) <= last.wrapping_sub(first) => return result,
                        // An answer to something else, which nobody waits for any more.
                        Some(_) => {}
                        None => aside(message),
                    },
                    Err(InstrumentError::Silent(_)) => break,
                    Err(error) => return Err(error),
                }
                // A board that is running talks all the time.
                if self.now() >= deadline {
                    break;
                }
            }
        }
        Err(InstrumentError::Silent(retries.timeout * retries.tries))
    }
}

/// Advice on a board of another version.
fn other_version(theirs: u8) -> String {
    let way_out = if theirs < VERSION {
        "flash the firmware of this program's release (`cargo xtask flash`), or use the older program of the board's release"
    } else {
        "use the newer program of the board's release, or flash the firmware of this program's release (`cargo xtask flash`)"
    };
    format!("the board speaks version {theirs} of the wire protocol, this program version {VERSION}; {way_out}")
}

/// Tells whether a command that was sent more than once was refused because it had been carried out
/// already.
fn shows_it_done(command: Command, refusal: &Refusal) -> bool {
    matches!(
        (command, refusal),
        (Command::Start | Command::SelfTest(_), Refusal::NotInStandby) | (Command::Acknowledge, Refusal::NotTripped)
    )
}
