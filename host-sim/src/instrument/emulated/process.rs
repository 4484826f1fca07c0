//! The emulator's process: its folder, its links, its log and its end.
//!
//! Two named pipes are the stream to the emulated board.
//!
//! Programs that were killed leave folders and emulators, which the next program clears. Each folder
//! has a file that its owner holds locked. The system frees the lock as the owner ends.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use defmt_decoder::{DecodeError, Table};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::sys::signal::{Signal, kill};
use nix::sys::stat::Mode;
use nix::unistd::{Pid, mkfifo};
use tempfile::TempDir;

use crate::instrument::error::InstrumentError;
use crate::instrument::link;
use crate::instrument::link::BoardStream;

/// The emulator; another can be named in the environment.
const EMULATOR: &str = "qemu-system-arm";
const EMULATOR_VARIABLE: &str = "ANEMO_QEMU";

/// Time that the emulator may take to connect, and to leave.
const TIMEOUT: Duration = Duration::from_secs(20);

/// Interval of looking whether the emulator still runs while it says nothing.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// Three sectors of 16 KiB.
const SETTINGS_BYTES: u64 = 48 * 1024;

/// Lines of log that an error quotes.
const LAST_WORDS: usize = 3;

/// An emulator that is about to run, or runs.
pub struct Process {
    firmware: PathBuf,
    folder: TempDir,
    /// Says that somebody still needs the folder.
    _lock: File,
    child: Option<Child>,
    /// Time that the board may take to answer.
    pub timeout: Duration,
}

impl Process {
    /// Makes a folder for an emulator of this firmware.
    pub fn prepare(firmware: &Path) -> Result<Self, InstrumentError> {
        let name = firmware.display();
        // The emulator runs in its own folder, so that the path must not depend on ours.
        let path = firmware.canonicalize().map_err(|_| {
            InstrumentError::Unusable(format!(
                "there is no firmware at {name}; build it with `cargo xtask demo`, or name another with --firmware"
            ))
        })?;
        // The emulator would run anything, as far as it goes.
        if !is_arm_elf(&path) {
            return Err(InstrumentError::Unusable(format!(
                "{name} is no firmware: an ELF image for ARM belongs here, such as `cargo xtask demo` builds"
            )));
        }
        clear_left_over();
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir()?;
        let lock = own(folder.path())?;
        Ok(Self { firmware: path, folder, _lock: lock, child: None, timeout: link::TIMEOUT })
    }

    /// Lets the board keep its settings in this file, erased flash if there is none.
    pub fn keep_settings_in(&self, flash: &Path) -> Result<(), InstrumentError> {
        let failed = |reason: io::Error| {
            let file = flash.display();
            InstrumentError::Unusable(format!("{file}: cannot be the flash of an emulated board: {reason}"))
        };
        let wrong = || io::Error::other(format!("it has another length than {SETTINGS_BYTES} bytes"));
        match std::fs::metadata(flash) {
            Ok(known) if known.len() == SETTINGS_BYTES => {}
            Ok(_) => return Err(failed(wrong())),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                std::fs::write(flash, vec![0xff; SETTINGS_BYTES as usize]).map_err(failed)?;
            }
            Err(error) => return Err(failed(error)),
        }
        let whole = flash.canonicalize().map_err(failed)?;
        std::os::unix::fs::symlink(whole, self.folder.path().join("settings.flash")).map_err(failed)
    }

    /// Starts it with one pair of named pipes for everything.
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

    /// A pair of named pipes. Opened for both directions, so that opening waits for nobody; the
    /// emulator still sees the end of the pipe when this process closes it.
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
            // Ctrl-C is for this process, which then ends the emulator in good order.
            .process_group(0)
            .stdin(Stdio::null())
            .stdout(File::create(self.folder.path().join("log.defmt"))?)
            .stderr(File::create(self.folder.path().join("errors.txt"))?)
            .spawn()
            .map_err(|error| match error.kind() {
                ErrorKind::NotFound => InstrumentError::Unusable(format!(
                    "`{emulator}` is not installed; install it with `apt-get install qemu-system-arm` (Debian, Ubuntu) or your system's equivalent, or run `cargo xtask demo`, which does so where it may"
                )),
                _ => InstrumentError::Unusable(format!("the emulator `{emulator}` cannot be started: {error}")),
            })?;
        note_emulator(self.folder.path(), self.child.insert(child).id())?;
        Ok(())
    }

    /// An error if the emulator has ended.
    fn has_stopped(&mut self) -> Result<(), InstrumentError> {
        let Some(child) = &mut self.child else { return Ok(()) };
        match child.try_wait()? {
            None => Ok(()),
            Some(status) => {
                let words = self.last_words();
                Err(InstrumentError::Unusable(format!(
                    "the emulated board stopped with {status}; its last words: {words}"
                )))
            }
        }
    }

    /// Waits on a link for as long as the emulator runs and the timeout has not passed. A dead
    /// emulator does not close it.
    pub fn until_timeout<T>(
        &mut self,
        mut wait: impl FnMut(Duration) -> Result<T, InstrumentError>,
    ) -> Result<T, InstrumentError> {
        let mut deadline = None;
        loop {
            match wait(LOOK_EVERY) {
                Err(InstrumentError::Silent(_)) => {
                    self.has_stopped()?;
                    let deadline = *deadline.get_or_insert_with(|| Instant::now() + self.timeout);
                    if Instant::now() >= deadline {
                        return Err(InstrumentError::Silent(self.timeout));
                    }
                }
                other => return other.map_err(|error| self.explain(error)),
            }
        }
    }

    /// Cause of an error on a link: an emulator that has ended, if it has.
    pub fn explain(&mut self, error: InstrumentError) -> InstrumentError {
        match error {
            InstrumentError::Silent(_) | InstrumentError::BoardLink(_) => {
                // A broken link shows before the process can be waited for.
                std::thread::sleep(Duration::from_millis(50));
                self.has_stopped().err().unwrap_or(error)
            }
            other => other,
        }
    }

    /// Waits for the emulator to leave by itself; gives its log.
    pub fn wait(&mut self) -> Result<Vec<String>, InstrumentError> {
        let deadline = Instant::now() + TIMEOUT;
        loop {
            match &mut self.child {
                None => return Ok(self.log()),
                Some(child) => match child.try_wait()? {
                    Some(status) if status.success() => return Ok(self.log()),
                    Some(_) => self.has_stopped()?,
                    None if Instant::now() > deadline => return Err(InstrumentError::Silent(TIMEOUT)),
                    None => std::thread::sleep(Duration::from_millis(2)),
                },
            }
        }
    }

    /// Best explanation of an end: the emulator's own complaint, or else what the board logged
    /// last.
    fn last_words(&self) -> String {
        let errors = std::fs::read_to_string(self.folder.path().join("errors.txt")).unwrap_or_default();
        // A complaint may be followed by pages of registers.
        let complaint = errors.lines().find(|line| line.starts_with("qemu")).or(errors.lines().next());
        let mut lines = decode(&self.firmware, &self.folder.path().join("log.defmt")).unwrap_or_default();
        lines.extend(complaint.map(str::to_owned));
        let last = lines.split_off(lines.len().saturating_sub(LAST_WORDS));
        if last.is_empty() { "none".to_owned() } else { last.join(" | ") }
    }

    /// Log of the board. A log that cannot be decoded is no reason for a run to fail: it is then
    /// one line.
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

/// Tells whether a file begins as a 32-bit little-endian ELF for ARM does.
fn is_arm_elf(path: &Path) -> bool {
    const MACHINE: std::ops::Range<usize> = 18..20;
    const ARM: [u8; 2] = [40, 0];
    let mut header = [0; 20];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut header));
    read.is_ok() && header.starts_with(b"\x7fELF\x01\x01") && header[MACHINE] == ARM
}

/// The lines of a log.
fn decode(firmware: &Path, log: &Path) -> io::Result<Vec<String>> {
    let elf = std::fs::read(firmware)?;
    let table = Table::parse(&elf).map_err(|error| io::Error::other(error.to_string()))?;
    let table = table.ok_or_else(|| io::Error::other("the firmware has no defmt section"))?;
    let bytes = std::fs::read(log)?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(&bytes);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => lines.push(frame.display(false).to_string()),
            Err(DecodeError::UnexpectedEof) => return Ok(lines),
            Err(DecodeError::Malformed) if !table.encoding().can_recover() => {
                return Err(io::Error::other("it is damaged"));
            }
            Err(DecodeError::Malformed) => {}
        }
    }
}

/// Keeps this thread, and the emulator it is about to start, on one core. Which one, the process
/// number decides, so that several runs spread. Where that is not to be had the run is slower, and
/// the same.
fn stay_on_one_core() {
    let Ok(allowed) = sched_getaffinity(Pid::from_raw(0)) else { return };
    let cores: Vec<usize> = (0..CpuSet::count()).filter(|&core| allowed.is_set(core).unwrap_or(false)).collect();
    let turn = std::process::id() as usize % cores.len().max(1);
    let Some(&core) = cores.get(turn) else { return };
    let mut only = CpuSet::new();
    if only.set(core).is_ok() {
        sched_setaffinity(Pid::from_raw(0), &only).ok();
    }
}

/// One link of an emulated board: a pipe each way.
pub struct Pipe {
    from_board: File,
    to_board: File,
}

impl BoardStream for Pipe {
    fn read_within(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let timeout = PollTimeout::try_from(timeout).unwrap_or(PollTimeout::MAX);
        if poll(&mut [PollFd::new(self.from_board.as_fd(), PollFlags::POLLIN)], timeout)? == 0 {
            return Err(ErrorKind::TimedOut.into());
        }
        match self.from_board.read(buffer)? {
            0 => Err(ErrorKind::UnexpectedEof.into()),
            read => Ok(read),
        }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to_board.write_all(bytes)
    }
}

/// Beginning of the folders' names.
const PREFIX: &str = "anemo-qemu-";
const OWNER: &str = "owner.lock";
const EMULATOR_NUMBER: &str = "emulator.pid";

/// Makes a folder one's own, for as long as the file is kept open.
fn own(folder: &Path) -> io::Result<File> {
    // Under its name it is locked from the first moment.
    let hidden = folder.join("owner.new");
    let lock = File::create(&hidden)?;
    lock.try_lock().map_err(io::Error::other)?;
    std::fs::rename(hidden, folder.join(OWNER))?;
    Ok(lock)
}

/// Notes which process is the folder's emulator.
fn note_emulator(folder: &Path, process: u32) -> io::Result<()> {
    std::fs::write(folder.join(EMULATOR_NUMBER), process.to_string())
}

/// Ends emulators and removes folders whose owners have ended.
fn clear_left_over() {
    for entry in std::fs::read_dir(std::env::temp_dir()).into_iter().flatten().flatten() {
        let folder = entry.path();
        if !entry.file_name().to_string_lossy().starts_with(PREFIX) {
            continue;
        }
        let Ok(lock) = File::open(folder.join(OWNER)) else { continue };
        if lock.try_lock().is_err() {
            continue;
        }
        let process =
            std::fs::read_to_string(folder.join(EMULATOR_NUMBER)).ok().and_then(|text| text.parse::<i32>().ok());
        // Its number may be another's by now, which works elsewhere.
        if let Some(process) = process
            && std::fs::read_link(format!("/proc/{process}/cwd")).is_ok_and(|works_in| works_in == folder)
        {
            let _ = kill(Pid::from_raw(process), Signal::SIGKILL);
        }
        let _ = std::fs::remove_dir_all(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};
    use std::time::Duration;

    #[test]
    fn a_folder_is_cleared_with_its_emulator_once_its_owner_has_ended() {
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir().unwrap();
        let path = folder.path().canonicalize().unwrap();
        let lock = own(&path).unwrap();
        let mut emulator = Command::new("sleep").arg("600").current_dir(&path).stdin(Stdio::null()).spawn().unwrap();
        note_emulator(&path, emulator.id()).unwrap();
        clear_left_over();
        assert!(path.is_dir() && emulator.try_wait().unwrap().is_none());
        drop(lock);
        // A process that another test starts just now shares the lock until it has become its
        // program.
        for _ in 0..100 {
            clear_left_over();
            if !path.exists() {
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        assert!(!path.exists());
        assert!(!emulator.wait().unwrap().success());
    }
}
