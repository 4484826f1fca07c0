//! The line to a board that lives in another process and in a time of its own.
//!
//! Host and process take turns over a pair of pipes. The host hands over the bytes that it has
//! written and how long it would wait; the process lets its board live until it sends something, or
//! for so long, and hands back its time and what has been sent. So no time passes unless the host
//! waits, and a run is the same whatever the speed of either.
//!
//! ```text
//! host ─► timeout, ns (u64) │ wind, m/s (3 f64) │ length (u32) │ bytes
//! host ◄─ time, ns (u64)    │ wind, m/s (3 f64) │ length (u32) │ bytes   all numbers little-endian
//! ```

use super::error::InstrumentError;
use super::link::BoardStream;
use super::serial::Serial;
use std::collections::VecDeque;
use std::ffi::OsStr;
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// Longest turn that is taken for one: more is another program's.
const MOST_BYTES: u32 = 1 << 20;

/// One turn: a time, a wind, and bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Turn {
    /// Time that the host would wait, or what time it is for the board.
    pub time: Duration,
    /// The wind that the sensor of the board has felt last, m/s; of the host's turns, nothing.
    pub wind_m_s: [f64; 3],
    /// Bytes for the line.
    pub bytes: Vec<u8>,
}

impl Turn {
    /// Writes it.
    ///
    /// # Errors
    /// If the other end is gone.
    pub fn write(&self, to: &mut impl Write) -> io::Result<()> {
        let nanoseconds = u64::try_from(self.time.as_nanos()).unwrap_or(u64::MAX);
        to.write_all(&nanoseconds.to_le_bytes())?;
        to.write_all(self.wind_m_s.map(f64::to_le_bytes).as_flattened())?;
        to.write_all(&(self.bytes.len() as u32).to_le_bytes())?;
        to.write_all(&self.bytes)?;
        to.flush()
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`ErrorKind::UnexpectedEof`] if the other end is gone, [`ErrorKind::InvalidData`] if it is
    /// another program.
    pub fn read(from: &mut impl Read) -> io::Result<Self> {
        let (mut time, mut wind, mut length) = ([0; 8], [[0; 8]; 3], [0; 4]);
        from.read_exact(&mut time)?;
        from.read_exact(wind.as_flattened_mut())?;
        from.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length);
        if length > MOST_BYTES {
            return Err(io::Error::new(ErrorKind::InvalidData, "what came is no turn of a simulated board"));
        }
        let mut bytes = vec![0; length as usize];
        from.read_exact(&mut bytes)?;
        let time = Duration::from_nanos(u64::from_le_bytes(time));
        Ok(Self { time, wind_m_s: wind.map(f64::from_le_bytes), bytes })
    }
}

/// The host's end of the line.
pub struct VirtualLine {
    child: Child,
    to_board: Option<ChildStdin>,
    from_board: ChildStdout,
    now: Duration,
    wind_m_s: [f64; 3],
    written: Vec<u8>,
    unread: VecDeque<u8>,
}

/// Files with which the program of a simulated board is started.
#[derive(Debug, Clone, Copy)]
pub struct VirtualBoardFiles<'a> {
    /// Firmware.
    pub firmware: &'a Path,
    /// The experiment in whose wind tunnel its sensor stands; any sensor without one.
    pub experiment: Option<&'a Path>,
    /// Its settings, made if there is no such file; without one it keeps nothing.
    pub flash: Option<&'a Path>,
}

/// Starts the program of a simulated board, and waits until the board answers.
///
/// # Errors
/// If the program cannot be started, or its board does not answer.
pub fn start(program: &Path, files: &VirtualBoardFiles<'_>) -> Result<Serial<VirtualLine>, InstrumentError> {
    if !files.firmware.is_file() {
        return Err(InstrumentError::Unusable(format!(
            "there is no firmware at {}: `cargo xtask size` builds it",
            files.firmware.display()
        )));
    }
    let mut command = Command::new(program);
    // A Ctrl-C is the host's: it stops the board, and the board then ends.
    command.process_group(0);
    command.arg(files.firmware);
    for (option, file) in [("--experiment", files.experiment), ("--flash", files.flash)] {
        command.args(file.map(|file| [OsStr::new(option), file.as_os_str()]).into_iter().flatten());
    }
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().map_err(|error| {
        InstrumentError::Unusable(format!(
            "the simulated board {} cannot be started: {error}; build it with `cargo build --release -p silicon`",
            program.display()
        ))
    })?;
    let (Some(to_board), Some(from_board)) = (child.stdin.take(), child.stdout.take()) else {
        return Err(InstrumentError::Unusable("the simulated board has no pipes".to_owned()));
    };
    Serial::over(VirtualLine {
        child,
        to_board: Some(to_board),
        from_board,
        now: Duration::ZERO,
        wind_m_s: [0.0; 3],
        written: Vec::new(),
        unread: VecDeque::new(),
    })
}

impl BoardStream for VirtualLine {
    fn now(&self) -> Duration {
        self.now
    }

    fn true_wind_m_s(&self) -> Option<[f64; 3]> {
        Some(self.wind_m_s)
    }

    fn read_within(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        if self.unread.is_empty() {
            let to_board = self.to_board.as_mut().ok_or(ErrorKind::UnexpectedEof)?;
            let bytes = std::mem::take(&mut self.written);
            Turn { time: timeout, wind_m_s: [0.0; 3], bytes }.write(to_board)?;
            let turn = Turn::read(&mut self.from_board).map_err(|error| match error.kind() {
                ErrorKind::UnexpectedEof => io::Error::new(error.kind(), "the simulated board has ended"),
                _ => error,
            })?;
            (self.now, self.wind_m_s) = (turn.time, turn.wind_m_s);
            self.unread.extend(turn.bytes);
        }
        match self.unread.read(buffer)? {
            0 => Err(ErrorKind::TimedOut.into()),
            read => Ok(read),
        }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.written.extend_from_slice(bytes);
        Ok(())
    }
}

impl Drop for VirtualLine {
    fn drop(&mut self) {
        // The end of its input is the end of the program, which says then what it has noticed.
        self.to_board = None;
        self.child.wait().ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_arrives_as_it_was_written_and_what_is_none_is_refused() {
        let turn = Turn { time: Duration::from_micros(377_123), wind_m_s: [1.5, -0.1, 1e-9], bytes: vec![0, 1, 2, 0] };
        let mut bytes = Vec::new();
        turn.write(&mut bytes).unwrap();
        assert_eq!(Turn::read(&mut bytes.as_slice()).unwrap(), turn);
        assert_eq!(Turn::read(&mut &bytes[..39]).unwrap_err().kind(), ErrorKind::UnexpectedEof);
        assert_eq!(Turn::read(&mut [0xff; 64].as_slice()).unwrap_err().kind(), ErrorKind::InvalidData);
    }
}
