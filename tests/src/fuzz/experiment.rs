//! Any text as an experiment with one of the shipped heads.

use super::sentences::{said, said_of};
use dr_core::control::{Heaters, RunState};
use host_sim::experiment::Experiment;
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentPort as _, LockStep};
use recording::toml_file::TomlSource;

/// Ticks of those that can be run at all.
const TICKS: u32 = 5;

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    if !stays_here(text) {
        return false;
    }
    let source = TomlSource { path: crate::file("experiments/tried.toml"), text: text.to_owned() };
    match Experiment::from_source(source) {
        // The head's file may be the one that is meant.
        Err(error) => {
            said_of(".toml", &error.to_string());
            false
        }
        Ok(experiment) => {
            make_use_of(&experiment);
            true
        }
    }
}

/// Files that it names are shipped ones: any other may be a device that never ends.
fn stays_here(text: &str) -> bool {
    let Ok(table) = text.parse::<toml::Table>() else { return true };
    let plain = |path: &str| path.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-/".contains(&byte));
    ["head", "models"]
        .iter()
        .filter_map(|key| table.get(*key)?.as_str())
        .all(|path| path.strip_prefix("../heads/").and_then(|path| path.strip_suffix(".toml")).is_some_and(plain))
}

/// An experiment that was read can be run: set up, and some ticks, or one sentence says why not.
fn make_use_of(experiment: &Experiment) {
    let elements = experiment.head.elements.len();
    assert!(experiment.ticks > 0 && experiment.drives.len() == elements);
    assert!(experiment.changes.windows(2).all(|pair| pair[0].tick <= pair[1].tick));
    for tick in [0, 1, experiment.ticks / 2, experiment.ticks - 1] {
        let event = experiment.event(tick);
        // A real sensor needs no wind.
        let is_still = experiment.wind.is_empty() && event.is_empty();
        assert!(is_still || experiment.wind.iter().any(|wind| wind.label == event), "`{event}` blows nowhere");
    }
    let sensor = match experiment.sensor() {
        Ok(sensor) => sensor,
        Err(error) => return said_of(".toml", &error.to_string()),
    };
    let mut instrument = LockStep::new(InProcess::new(), sensor);
    if let Err(error) = host_sim::run::start(experiment, &mut instrument) {
        return said(&error.to_string());
    }
    for _ in 0..TICKS.min(experiment.ticks) {
        let seen = instrument.observe().expect("it is in this process");
        let sample = seen.sample;
        assert!(sample.state == RunState::Running || sample.heaters == Heaters(0));
        assert_eq!(sample.heaters.0 & !sample.valid, 0, "heated without a valid reading");
        let wind_m_s = seen.true_wind_m_s.unwrap_or_default();
        assert!(wind_m_s.iter().all(|part| part.is_finite()), "{wind_m_s:?}");
        let all_c = instrument.truth().element_temperature_c;
        assert!(all_c.iter().all(|c| c.is_finite()), "{all_c:?}");
    }
}
