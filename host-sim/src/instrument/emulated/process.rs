//! The emulator's process: its folder, its links, its log and its end.

use super::super::InstrumentError;
use super::stream::Pipe;
use defmt_decoder::{DecodeError, Table};
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::sys::stat::Mode;
use nix::unistd::{Pid, mkfifo};
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The emulator; another can be named in the environment.
const EMULATOR: &str = "qemu-system-arm";
const EMULATOR_VARIABLE: &str = "ANEMO_QEMU";

/// How long the emulator may take to connect, and to leave.
const PATIENCE: Duration = Duration::from_secs(20);

/// Lines of log that an error quotes.
const LAST_WORDS: usize = 3;

/// An emulator that is about to run, or runs.
pub struct Process {
    firmware: PathBuf,
    folder: TempDir,
    child: Option<Child>,
}

impl Process {
    /// Makes a folder for an emulator of this firmware.
    pub fn prepare(firmware: &Path) -> Result<Self, InstrumentError> {
        // The emulator runs in its own folder, so that the path must not depend on ours.
        let firmware = firmware.canonicalize().map_err(|_| InstrumentError::NoFirmware(firmware.to_owned()))?;
        let folder = tempfile::Builder::new().prefix("anemo-qemu-").tempdir()?;
        Ok(Self { firmware, folder, child: None })
    }

    /// Starts it with a pair of named pipes for the fast link.
    pub fn start_with_fifos(&mut self) -> Result<Pipe, InstrumentError> {
        let pipe = self.pipe("to-board.fifo", "from-board.fifo")?;
        self.spawn(&[])?;
        Ok(pipe)
    }

    /// Starts it with two USARTs, host link and front end, each on a pair of named pipes.
    pub fn start_with_usarts(&mut self) -> Result<(Pipe, Pipe), InstrumentError> {
        // The emulator adds the endings itself; `in` is what it takes in.
        let (host, bench) = (self.pipe("host.in", "host.out")?, self.pipe("bench.in", "bench.out")?);
        let bench_link = ["-chardev", "pipe,id=bench,path=bench", "-serial", "chardev:bench"];
        let host_link = ["-chardev", "pipe,id=host,path=host", "-serial", "chardev:host"];
        self.spawn(&[bench_link, host_link].concat())?;
        Ok((host, bench))
    }

    /// A pair of named pipes. Opened for both directions, so that opening waits for nobody; the emulator still sees the
    /// end of the pipe when this process closes it.
    fn pipe(&self, to_board: &str, from_board: &str) -> io::Result<Pipe> {
        let open = |name| {
            let path = self.folder.path().join(name);
            mkfifo(&path, Mode::S_IRUSR | Mode::S_IWUSR)?;
            OpenOptions::new().read(true).write(true).open(path)
        };
        Ok(Pipe { to_board: open(to_board)?, from_board: open(from_board)? })
    }

    fn spawn(&mut self, links: &[&str]) -> Result<(), InstrumentError> {
        stay_on_one_core();
        let emulator = std::env::var(EMULATOR_VARIABLE).unwrap_or_else(|_| EMULATOR.to_owned());
        let child = Command::new(&emulator)
            .args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-nodefaults"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(links)
            .arg("-kernel")
            .arg(&self.firmware)
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .stdout(File::create(self.folder.path().join("log.defmt"))?)
            .stderr(File::create(self.folder.path().join("errors.txt"))?)
            .spawn()
            .map_err(|error| match error.kind() {
                ErrorKind::NotFound => InstrumentError::NoEmulator(emulator),
                _ => InstrumentError::Link(error),
            })?;
        self.child = Some(child);
        Ok(())
    }

    /// An error if the emulator has ended.
    fn has_stopped(&mut self) -> Result<(), InstrumentError> {
        let Some(child) = &mut self.child else { return Ok(()) };
        match child.try_wait()? {
            None => Ok(()),
            Some(status) => {
                Err(InstrumentError::EmulatorStopped { status: status.to_string(), words: self.last_words() })
            }
        }
    }

    /// What is behind an error on a link: an emulator that has ended, if it has.
    pub fn explain(&mut self, error: InstrumentError) -> InstrumentError {
        match error {
            InstrumentError::Silent(_) | InstrumentError::Link(_) => {
                // A broken link shows before the process can be waited for.
                std::thread::sleep(Duration::from_millis(50));
                self.has_stopped().err().unwrap_or(error)
            }
            other => other,
        }
    }

    /// Waits for the emulator to leave by itself; gives its log.
    pub fn wait(&mut self) -> Result<Vec<String>, InstrumentError> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            match &mut self.child {
                None => return Ok(self.log()),
                Some(child) => match child.try_wait()? {
                    Some(status) if status.success() => return Ok(self.log()),
                    Some(_) => self.has_stopped()?,
                    None if Instant::now() > deadline => return Err(InstrumentError::Silent(PATIENCE)),
                    None => std::thread::sleep(Duration::from_millis(2)),
                },
            }
        }
    }

    fn last_words(&self) -> String {
        let mut lines = self.log();
        let errors = std::fs::read_to_string(self.folder.path().join("errors.txt")).unwrap_or_default();
        lines.extend(errors.lines().map(str::to_owned));
        let last = lines.split_off(lines.len().saturating_sub(LAST_WORDS));
        if last.is_empty() { "none".to_owned() } else { last.join(" | ") }
    }

    /// What the board has logged. A log that cannot be decoded is no reason for a run to fail: it is then one line.
    fn log(&self) -> Vec<String> {
        decode(&self.firmware, &self.folder.path().join("log.defmt"))
            .unwrap_or_else(|reason| vec![format!("(the board's log cannot be read: {reason})")])
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            // It may have ended by itself; either way none is left behind.
            child.kill().ok();
            child.wait().ok();
        }
    }
}

fn decode(firmware: &Path, log: &Path) -> Result<Vec<String>, String> {
    let elf = std::fs::read(firmware).map_err(|error| error.to_string())?;
    let table = Table::parse(&elf).map_err(|error| error.to_string())?.ok_or("the firmware has no defmt section")?;
    let bytes = std::fs::read(log).map_err(|error| error.to_string())?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(&bytes);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => lines.push(frame.display(false).to_string()),
            Err(DecodeError::UnexpectedEof) => return Ok(lines),
            Err(DecodeError::Malformed) if !table.encoding().can_recover() => return Err("it is damaged".to_owned()),
            Err(DecodeError::Malformed) => {}
        }
    }
}

/// Keeps this thread, and the emulator it is about to start, on one core: on the last one that it may use.
/// Where that is not to be had the run is slower, and the same.
fn stay_on_one_core() {
    let Ok(allowed) = sched_getaffinity(Pid::from_raw(0)) else { return };
    let Some(core) = (0..CpuSet::count()).rfind(|&core| allowed.is_set(core).unwrap_or(false)) else { return };
    let mut only = CpuSet::new();
    if only.set(core).is_ok() {
        sched_setaffinity(Pid::from_raw(0), &only).ok();
    }
}
