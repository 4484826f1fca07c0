//! Common parts of the tests that cross crates: where experiments and firmware are, and how a run
//! is made from them.

pub mod calibrated;
pub mod cole_cole;
pub mod fake_board;
pub mod fuzz;
pub mod injection;
pub mod loops;
pub mod records;
pub mod speed;
pub mod studies;
pub mod winds;

use dr_core::sensor::Reading;
use host_sim::experiment::Experiment;
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentPort, LockStep, LockStepController};
use host_sim::run::RunSummary;
use host_sim::run::{RunError, run};
use host_sim::sensor::Sensor;
use recording::toml_file::TomlSource;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A file of this repository.
pub fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// A shipped experiment.
pub fn experiment(name: &str) -> Experiment {
    changed(name, &[])
}

/// A shipped experiment with some of its text replaced. Each text must be there, so that no test
/// runs something else than it says.
pub fn changed(name: &str, replacements: &[(&str, &str)]) -> Experiment {
    let mut source = TomlSource::read(&file("experiments").join(name)).expect("a shipped experiment can be read");
    for (from, to) in replacements {
        assert!(source.text.contains(from), "{name} does not contain `{from}`");
        source.text = source.text.replacen(from, to, 1);
    }
    Experiment::from_source(source).expect("the changed experiment is still one")
}

/// The virtual board's firmware, built by `cargo xtask test` (or `demo`, or `size`).
pub fn firmware() -> PathBuf {
    let path = std::env::var_os("ANEMO_FIRMWARE")
        .map_or_else(|| built().join("thumbv7em-none-eabihf/firmware/firmware-virtual-board.elf"), PathBuf::from);
    assert!(path.exists(), "no firmware at {}: `cargo xtask test` builds it and then runs these tests", path.display());
    path
}

/// The build folder that this test was built into.
fn built() -> PathBuf {
    // A test stands in `release/deps`.
    std::env::current_exe().ok().and_then(|test| test.ancestors().nth(3).map(Path::to_owned)).unwrap_or_default()
}

/// The `anemo` command, built by `cargo xtask test`, or by the same build as this test.
pub fn anemo() -> PathBuf {
    let beside = || std::env::current_exe().ok()?.parent()?.parent().map(|folder| folder.join("anemo"));
    let path = std::env::var_os("ANEMO_BIN").map(PathBuf::from).or_else(beside).unwrap_or_default();
    assert!(path.exists(), "no command at {}: `cargo xtask test` builds it and then runs these tests", path.display());
    path
}

/// A folder in which the `anemo` command is run, with an experiment `e.toml` in it.
pub struct Desk(tempfile::TempDir);

impl Desk {
    /// Lays out a shipped experiment with some of its text replaced, right or wrong.
    pub fn new(name: &str, replacements: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("there is room for temporary files");
        let heads = file("heads").canonicalize().expect("the heads are there");
        let mut text = std::fs::read_to_string(file("experiments").join(name)).expect("a shipped experiment is there");
        for (from, to) in replacements {
            assert!(text.contains(from), "{name} does not contain `{from}`");
            text = text.replacen(from, to, 1);
        }
        let text = text.replace("\"../heads", &format!("\"{}", heads.display()));
        std::fs::write(folder.path().join("e.toml"), text).expect("there is room for temporary files");
        Self(folder)
    }

    /// Lays out an experiment of these words; its head is named by a whole path.
    pub fn with(text: &str) -> Self {
        let folder = tempfile::tempdir().expect("there is room for temporary files");
        std::fs::write(folder.path().join("e.toml"), text).expect("there is room for temporary files");
        Self(folder)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The experiment on it.
    pub fn experiment(&self) -> Experiment {
        Experiment::read(&self.path().join("e.toml")).expect("the changed experiment is still one")
    }

    /// The command, with nothing of the environment that would lead it elsewhere.
    pub fn command(&self, arguments: &[&str], environment: &[(&str, &str)]) -> Command {
        let mut command = Command::new(anemo());
        command.env_remove("ANEMO_FIRMWARE").env_remove("ANEMO_QEMU").envs(environment.iter().copied());
        command.args(arguments).current_dir(self.path());
        command
    }

    /// Runs it to its end.
    pub fn anemo(&self, arguments: &[&str], environment: &[(&str, &str)]) -> Output {
        self.command(arguments, environment).output().expect("the command can be started")
    }

    /// Runs it for its refusal: the exit code and the one sentence.
    ///
    /// # Panics
    /// If there is anything but that sentence, on stdout, on stderr or in the folder.
    pub fn refused(&self, arguments: &[&str], environment: &[(&str, &str)]) -> (i32, String) {
        let before = self.files();
        let output = self.anemo(arguments, environment);
        let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert_eq!(stdout, "", "{arguments:?}");
        assert_eq!(stderr.lines().count(), 1, "{arguments:?}: {stderr}");
        let sentence = stderr.strip_prefix("anemo: ").unwrap_or_else(|| panic!("{arguments:?}: {stderr}"));
        assert_eq!(self.files(), before, "{arguments:?} left something behind");
        (output.status.code().expect("the command was not killed"), sentence.trim_end().to_owned())
    }

    /// Names of all that is in the folder.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).expect("the folder is there");
        let mut names: Vec<String> = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
        names.sort();
        names
    }
}

/// A frame in order, with the right checksum, of the next version of the protocol. Made without the
/// code under test.
pub fn foreign_frame(message: &[u8]) -> Vec<u8> {
    let mut content = vec![wire::VERSION + 1, 0, 0];
    content.extend(message);
    let crc = crc_of(&content);
    content.extend(crc.to_le_bytes());
    cobs_of(&content)
}

/// CRC-16/IBM-SDLC bit by bit.
fn crc_of(bytes: &[u8]) -> u16 {
    !bytes.iter().fold(0xffff, |crc, &byte| {
        (0..8).fold(crc ^ u16::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0x8408 } else { crc >> 1 })
    })
}

/// COBS, terminator included.
fn cobs_of(bytes: &[u8]) -> Vec<u8> {
    let mut frame = Vec::new();
    for block in bytes.split(|&byte| byte == 0) {
        // Behind a full run there is no zero; what follows it says whether there is one.
        let runs = block.chunks_exact(254);
        let last = runs.remainder();
        runs.for_each(|run| frame.extend([255].iter().chain(run)));
        frame.push(last.len() as u8 + 1);
        frame.extend(last);
    }
    frame.push(0);
    frame
}

/// The simulated sensor of an experiment.
pub fn sensor(experiment: &Experiment) -> Sensor {
    experiment.sensor().expect("a shipped experiment can be simulated")
}

/// Readings of the sensor's front end now.
pub fn readings(sensor: &Sensor) -> Vec<Reading> {
    sensor.codes().iter().map(|&code| Reading::Code(code)).collect()
}

/// The controller in this process, with the experiment's sensor around it.
pub fn in_process(experiment: &Experiment) -> Box<LockStep<InProcess>> {
    Box::new(LockStep::new(InProcess::new(), sensor(experiment)))
}

/// The firmware in the emulator, with the experiment's sensor around it.
pub fn emulated(experiment: &Experiment, way: Way) -> Box<LockStep<Emulated>> {
    let board = Emulated::start(&firmware(), way).expect("the emulated board starts");
    Box::new(LockStep::new(board, sensor(experiment)))
}

/// Sets an instrument up for an experiment and starts it.
pub fn start(experiment: &Experiment, instrument: &mut dyn InstrumentPort) {
    host_sim::run::start(experiment, instrument).expect("a shipped experiment is not refused");
}

/// A body alone, set up and started.
pub fn started<B: LockStepController>(experiment: &Experiment, body: B) -> LockStep<B> {
    let mut instrument = LockStep::new(body, sensor(experiment));
    start(experiment, &mut instrument);
    instrument
}

/// Runs an experiment to its end without keeping rows.
pub fn summary(experiment: &Experiment, instrument: Box<dyn InstrumentPort>) -> RunSummary {
    run(experiment, instrument, &mut |_| Ok::<(), RunError>(())).expect("the run comes to its end")
}
