//! Any text as a head, and as the models of a head's elements.

use super::sentences::said_of;
use anemometry::head::Head;
use dr_core::control::HardwareLimits;
use dr_core::{Command, Instrument};
use host_sim::experiment::models::Models;
use host_sim::sensor::{Construction, Sensor, SensorConfig};
use host_sim::settings::{Settings, file, rehearse};
use recording::toml_file::TomlSource;
use std::sync::LazyLock;
use wire::MOST_ELEMENTS;

/// The head for which models are tried.
static SPHERE: LazyLock<Head> =
    LazyLock::new(|| Head::read(&crate::file("heads/sphere-b.toml")).expect("a shipped head can be read"));

const NAME: &str = "tried.toml";
const SAMPLE_PERIOD_S: f64 = 0.01;
/// Larger bodies take too long for a target.
const MOST_NODES: usize = 40;

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let source = TomlSource { path: NAME.into(), text: text.to_owned() };
    let models = Models::from_source(source.clone(), &SPHERE);
    match &models {
        Err(error) => said_of(NAME, &error.to_string()),
        Ok(models) => assert_eq!(models.elements.len(), SPHERE.elements.len()),
    }
    match Head::from_source(source) {
        Err(error) => {
            said_of(NAME, &error.to_string());
            models.is_ok()
        }
        Ok(head) => {
            is_taken(&head);
            is_kept(&head);
            is_simulated(&head);
            true
        }
    }
}

/// A head with a body can be simulated, or its gas is refused.
fn is_simulated(head: &Head) {
    let small = head.body.as_ref().is_some_and(|body| body.nodes.len() <= MOST_NODES);
    let Some(construction) = Construction::of(head).filter(|_| small) else { return };
    let sensor = Sensor::new(&SensorConfig {
        construction,
        elements: head.elements.iter().map(|element| element.nominal).collect(),
        volt_per_code: head.volt_per_code,
        ..SensorConfig::default()
    });
    match sensor {
        Err(error) => super::sentences::said(&error.to_string()),
        Ok(mut sensor) => (0..3).for_each(|tick| sensor.advance(tick)),
    }
}

/// A controller takes what the file's check has let through.
fn is_taken(head: &Head) {
    let mut station = Instrument::<MOST_ELEMENTS>::new(&HardwareLimits::SIMULATED);
    station.handle(Command::SamplePeriod { sample_period_s: SAMPLE_PERIOD_S as f32 }).expect("a period as any");
    station.handle(Command::Guard(head.guard_config(SAMPLE_PERIOD_S))).expect("any guard is taken");
    for (element, of) in (0_u8..).zip(&head.elements) {
        let told = station.handle(Command::Element { element, config: of.config });
        told.unwrap_or_else(|refusal| panic!("{}: {refusal}", of.name));
    }
    let mut names = head.names();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), head.elements.len(), "each element has a name of its own");
}

/// The settings that a board would keep of it are written as a file and read as the same.
fn is_kept(head: &Head) {
    let mut settings = Settings::default();
    if let Err(error) = settings.set_head(head, SAMPLE_PERIOD_S) {
        return super::sentences::said(&error.to_string());
    }
    let text = file::to_toml("a firmware", &settings).expect("any setting can be written");
    let read = file::from_source(&TomlSource { path: "settings.toml".into(), text });
    assert_eq!(read.as_ref(), Ok(&settings));
    if let Err(error) = rehearse(&settings, &HardwareLimits::SIMULATED) {
        let sentence = error.to_string();
        super::sentences::said(&sentence);
        assert!(
            head.calibration.is_some(),
            "a head without a calibration has nothing that could be refused: {sentence}"
        );
    }
}
