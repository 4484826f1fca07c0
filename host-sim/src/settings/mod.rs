//! Settings of a board, from the host: read, checked, changed, put aside and brought back.
//!
//! Whatever is to be stored is rehearsed first: a controller of this process is told all of it in the board's order, and what it refuses is
//! never written. So a board holds only what it can be set up by, unless another firmware wrote it.

pub mod file;
pub mod names;

use std::collections::BTreeMap;

use dr_core::control::{Command, Refusal, Station, WindCommand};
use wire::settings::{KeyNumber, Kind, Value};
use wire::{MOST_ELEMENTS, Setting, SettingsRefusal, SettingsReply, SettingsRequest, Unusable};

use crate::head::Head;
use crate::head::calibration::Answering;
use crate::instrument::{InstrumentError, Keeper};
use crate::self_test::report;

/// A value as a board keeps it.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    pub number: KeyNumber,
    pub value: Value,
    /// What it says, or why it is not used.
    pub setting: Result<Setting, Unusable>,
}

/// All that a board keeps, and whether it is what was written to it.
///
/// # Errors
/// If the board cannot be reached, or cannot read its flash.
pub fn read_all(board: &mut dyn Keeper) -> Result<(Vec<Kept>, bool), InstrumentError> {
    let whole = match board.ask_settings(&SettingsRequest::Check) {
        Ok(_) => true,
        Err(InstrumentError::Settings(SettingsRefusal::NotWhole)) => false,
        Err(error) => return Err(error),
    };
    let (mut all, mut after) = (Vec::new(), None);
    while let SettingsReply::Value { key, value, unusable } = board.ask_settings(&SettingsRequest::Next { after })? {
        if after.is_some_and(|after| key <= after) {
            return Err(InstrumentError::Protocol(format!("key {key:#06x} came after {after:#06x?}")));
        }
        after = Some(key);
        let setting = unusable.map_or_else(|| Setting::read(key, &value), Err);
        all.push(Kept { number: key, value, setting });
    }
    Ok((all, whole))
}

/// The settings that can be used, by their keys.
pub fn usable(kept: &[Kept]) -> BTreeMap<KeyNumber, Setting> {
    kept.iter().filter_map(|kept| Some((kept.number, kept.setting.clone().ok()?))).collect()
}

/// Tells a controller of this process all of it, as a board would be told.
///
/// # Errors
/// A sentence: what it does not take.
pub fn rehearse(settings: &BTreeMap<KeyNumber, Setting>) -> Result<(), String> {
    let mut station = Station::<MOST_ELEMENTS>::new();
    for (&number, setting) in settings {
        let Setting::Command(command) = setting else { continue };
        station.handle(*command).map_err(|refusal| {
            let hint = match refusal {
                Refusal::NoSamplePeriod => "; set sample_period_s first",
                _ => "",
            };
            format!("{}: {refusal}{hint}", names::of(number))
        })?;
    }
    Ok(())
}

/// Changes what a board keeps from one set to another, and sets it up by that. Says how many values were written and forgotten. What the board writes by
/// itself stays.
///
/// Each value changes by itself: should the supply fail meanwhile, each is the old one or the new one, and doing it again goes on.
///
/// # Errors
/// If the board cannot be reached, or refuses.
pub fn change(
    board: &mut dyn Keeper,
    from: &[Kept],
    to: &BTreeMap<KeyNumber, Setting>,
) -> Result<(usize, usize), InstrumentError> {
    let (mut written, mut forgotten) = (0, 0);
    for kept in from.iter().filter(|kept| !to.contains_key(&kept.number) && !names::is_the_boards(kept.number)) {
        board.ask_settings(&SettingsRequest::Forget { key: kept.number })?;
        forgotten += 1;
    }
    for (&key, setting) in to {
        if names::is_the_boards(key) {
            continue;
        }
        let value = setting.value().map_err(|error| InstrumentError::Protocol(error.to_string()))?;
        if from.iter().any(|kept| kept.number == key && kept.value == value) {
            continue;
        }
        board.ask_settings(&SettingsRequest::Store { key, value })?;
        written += 1;
    }
    board.ask_settings(&SettingsRequest::Load)?;
    Ok((written, forgotten))
}

/// What a head's file says, as settings: guard, elements and calibration. In place of all that is kept of another head.
///
/// # Errors
/// A sentence: what cannot be had at this sample period.
pub fn of_head(head: &Head, sample_period_s: f64, settings: &mut BTreeMap<KeyNumber, Setting>) -> Result<(), String> {
    settings.retain(|&number, _| !names::is_of_head(number));
    let mut commands = vec![
        Command::SamplePeriod { sample_period_s: sample_period_s as f32 },
        Command::Guard(head.guard_config(sample_period_s)),
    ];
    for (element, of) in (0_u8..).zip(&head.elements) {
        commands.push(Command::Element { element, config: of.config });
    }
    if let Some(calibration) = &head.calibration {
        let answering = Answering::new(None, None, false, sample_period_s);
        let (wind, _) = calibration.commands(&answering, sample_period_s)?;
        commands.extend(wind.into_iter().map(Command::Wind));
    }
    for command in commands {
        let setting = Setting::Command(command);
        if let Some(key) = setting.key() {
            settings.insert(key.number(), setting);
        }
    }
    Ok(())
}

/// The sample period among some settings, s.
pub fn sample_period_s(settings: &BTreeMap<KeyNumber, Setting>) -> Option<f32> {
    settings.values().find_map(|setting| match setting {
        Setting::Command(Command::SamplePeriod { sample_period_s }) => Some(*sample_period_s),
        _ => None,
    })
}

/// What holds for a key of which nothing is kept, where that is a value.
pub fn default_of(kind: Kind) -> Option<Setting> {
    match kind {
        Kind::Name => Some(Setting::Name(wire::Name::new())),
        Kind::TelemetryEvery => Some(Setting::TelemetryEvery(1)),
        Kind::Guard => Some(Setting::Command(Command::Guard(dr_core::control::GuardConfig::default()))),
        Kind::Observe => Some(Setting::Command(Command::Observe { on: false })),
        _ => None,
    }
}

/// What is inside a setting, without the names of commands.
pub fn content(setting: &Setting) -> serde_json::Value {
    let of = |value: Result<serde_json::Value, serde_json::Error>| value.unwrap_or_default();
    match setting {
        Setting::Name(name) => name.as_str().into(),
        Setting::TelemetryEvery(every) => (*every).into(),
        Setting::Command(Command::SamplePeriod { sample_period_s }) => of(serde_json::to_value(sample_period_s)),
        Setting::Command(Command::Observe { on }) => (*on).into(),
        Setting::Command(Command::Guard(guard)) => of(serde_json::to_value(guard)),
        Setting::Command(Command::Element { config, .. }) => of(serde_json::to_value(config)),
        Setting::Command(Command::Model { model, .. }) => of(serde_json::to_value(model)),
        Setting::Command(Command::Drive { drive, .. }) => of(serde_json::to_value(drive)),
        Setting::Command(Command::Wind(wind)) => match wind {
            WindCommand::Own { config, .. } => of(serde_json::to_value(config)),
            WindCommand::Part { config, .. } => of(serde_json::to_value(config)),
            WindCommand::Point { amplitudes, .. } => of(serde_json::to_value(amplitudes)),
            other => of(serde_json::to_value(other)
                .map(|value| value.as_object().and_then(|tagged| tagged.values().next()).cloned().unwrap_or(value))),
        },
        // In brief: `anemo self-test --stored` tells all of it.
        Setting::Tested(record) => format!("{}, {}", report::verdict(&record.finding), report::when(record)).into(),
        Setting::Command(other) => of(serde_json::to_value(other)),
    }
}
