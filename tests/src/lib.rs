//! What the tests that cross crates share: where experiments and firmware are, and how a run is made from them.

use host_sim::experiment::Experiment;
use host_sim::instrument::emulated::{Emulated, Path as Way};
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{Body, Instrument, LockStep};
use host_sim::run::{RunError, run};
use host_sim::sensor::Sphere;
use host_sim::summary::RunSummary;
use host_sim::toml_file::Source;
use std::path::{Path, PathBuf};

/// A file of this repository.
pub fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// A shipped experiment.
pub fn experiment(name: &str) -> Experiment {
    changed(name, &[])
}

/// A shipped experiment with some of its text replaced. Each text must be there, so that no test runs something else
/// than it says.
pub fn changed(name: &str, replacements: &[(&str, &str)]) -> Experiment {
    let mut source = Source::read(&file("experiments").join(name)).expect("a shipped experiment can be read");
    for (from, to) in replacements {
        assert!(source.text.contains(from), "{name} does not contain `{from}`");
        source.text = source.text.replacen(from, to, 1);
    }
    Experiment::from_source(source).expect("the changed experiment is still one")
}

/// The virtual board's firmware, built by `cargo xtask test` (or `demo`, or `size`).
pub fn firmware() -> PathBuf {
    let path = std::env::var_os("ANEMO_FIRMWARE")
        .map_or_else(|| file("target/thumbv7em-none-eabihf/firmware/firmware-virtual-board.elf"), PathBuf::from);
    assert!(path.exists(), "no firmware at {}: `cargo xtask test` builds it and then runs these tests", path.display());
    path
}

/// The simulated sensor of an experiment.
pub fn sphere(experiment: &Experiment) -> Sphere {
    let config = experiment.sphere_config().expect("a shipped experiment can be simulated");
    Sphere::new(&config).expect("a shipped experiment can be simulated")
}

/// The controller in this process, with the experiment's sensor around it.
pub fn in_process(experiment: &Experiment) -> Box<LockStep<InProcess>> {
    Box::new(LockStep::new(InProcess::new(), sphere(experiment)))
}

/// The firmware in the emulator, with the experiment's sensor around it.
pub fn emulated(experiment: &Experiment, way: Way) -> Box<LockStep<Emulated>> {
    let board = Emulated::start(&firmware(), way).expect("the emulated board starts");
    Box::new(LockStep::new(board, sphere(experiment)))
}

/// Sets an instrument up for an experiment and starts it.
pub fn start(experiment: &Experiment, instrument: &mut dyn Instrument) {
    host_sim::run::start(experiment, instrument).expect("a shipped experiment is not refused");
}

/// A body alone, set up and started.
pub fn started<B: Body>(experiment: &Experiment, body: B) -> LockStep<B> {
    let mut instrument = LockStep::new(body, sphere(experiment));
    start(experiment, &mut instrument);
    instrument
}

/// Runs an experiment to its end without keeping rows.
pub fn summary(experiment: &Experiment, instrument: Box<dyn Instrument>) -> RunSummary {
    run(experiment, instrument, &mut |_| Ok::<(), RunError>(())).expect("the run comes to its end")
}
