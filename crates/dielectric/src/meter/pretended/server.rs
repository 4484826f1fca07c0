//! The connections of the pretended meter: a thread each, all to one meter.

use super::commands::{Reaction, react};
use super::state::Misbehaviour;
use super::state::{BiasStep, MeterState, PretendedDevice};
use publish::listen::{ListenError, Listener, Listening, Token};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// From one look at the listener to the next.
const LOOK: Duration = Duration::from_millis(5);
/// From one look at the end of the meter to the next.
const WAIT: Duration = Duration::from_millis(50);
/// A longer line is nobody's command.
const LONGEST_LINE: usize = 4_096;

/// Where a pretended meter listens, and what it is.
#[derive(Debug, Clone, PartialEq)]
pub struct PretendedSettings {
    /// On the loopback; port 0 lets the system choose.
    pub at: SocketAddr,
    /// Its answer to `*IDN?`.
    pub identity: String,
    /// Misbehaviour.
    pub misbehaviour: Option<Misbehaviour>,
}

impl Default for PretendedSettings {
    /// A well-behaved E4980A at a port of 127.0.0.1 that the system chooses.
    fn default() -> Self {
        Self {
            at: (Ipv4Addr::LOCALHOST, 0).into(),
            identity: "Keysight Technologies,E4980A,pretended,0".to_owned(),
            misbehaviour: None,
        }
    }
}

/// A meter that is none, until it is dropped.
pub struct PretendedMeter {
    address: SocketAddr,
    state: Arc<Mutex<MeterState>>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl PretendedMeter {
    /// Switches it on.
    ///
    /// # Errors
    /// If the address is not on the loopback, or is in use.
    pub fn start(settings: PretendedSettings, device: PretendedDevice) -> Result<Self, ListenError> {
        let PretendedSettings { at, identity, misbehaviour } = settings;
        let bind_error = |source| ListenError::Bind { address: at, source };
        // The token is of no use here: SCPI has none, and nothing real obeys.
        let listener = Listening::new(None, Token::random().map_err(bind_error)?).bind(at)?;
        let address = listener.address();
        let state = Arc::new(Mutex::new(MeterState::new(identity, misbehaviour, device)));
        let ends = Arc::new(AtomicBool::new(false));
        let (shared, end) = (state.clone(), ends.clone());
        let thread = std::thread::Builder::new().name("pretended meter".to_owned());
        let thread = thread.spawn(move || listen(&listener, &shared, &end)).map_err(bind_error)?;
        Ok(Self { address, state, ends, thread: Some(thread) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// All changes of the applied bias, the first being 0 V when it was switched on.
    pub fn bias_history(&self) -> Vec<BiasStep> {
        lock(&self.state).history.clone()
    }

    /// The bias that is applied now, V.
    pub fn bias_v(&self) -> f64 {
        lock(&self.state).applied_v()
    }

    /// The commands that have come: the latest thousand.
    pub fn commands(&self) -> Vec<String> {
        lock(&self.state).latest_commands.iter().cloned().collect()
    }
}

impl Drop for PretendedMeter {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A device that panicked has said so already.
            thread.join().ok();
        }
    }
}

fn lock(state: &Mutex<MeterState>) -> MutexGuard<'_, MeterState> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

fn listen(listener: &Listener, state: &Arc<Mutex<MeterState>>, ends: &Arc<AtomicBool>) {
    while !ends.load(Ordering::Relaxed) {
        match listener.accept() {
            Ok(Some(_)) if lock(state).is_gone() => {}
            Ok(Some(stream)) => {
                let (state, ends) = (state.clone(), ends.clone());
                // Whoever left has no use for an error.
                let serve = move || {
                    serve(stream, &state, &ends).ok();
                };
                std::thread::Builder::new().name("pretended connection".to_owned()).spawn(serve).ok();
            }
            Ok(None) | Err(_) => std::thread::sleep(LOOK),
        }
    }
}

fn serve(mut stream: TcpStream, state: &Mutex<MeterState>, ends: &AtomicBool) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(WAIT))?;
    stream.set_write_timeout(Some(WAIT))?;
    let (mut received, mut buffer) = (Vec::new(), [0; 512]);
    while !ends.load(Ordering::Relaxed) {
        match stream.read(&mut buffer) {
            Ok(0) => break,
            Ok(read) => received.extend_from_slice(&buffer[..read]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
        while let Some(end) = received.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = received.drain(..=end).collect();
            let reaction = react(&mut lock(state), &String::from_utf8_lossy(&line));
            match reaction {
                Reaction::Bytes(bytes) => stream.write_all(&bytes)?,
                Reaction::Close => return Ok(()),
            }
        }
        if received.len() > LONGEST_LINE {
            break;
        }
    }
    Ok(())
}
