//! A setting as a board keeps it, its default, and its content without the names of commands.

use dr_core::Command;
use dr_core::wind::WindCommand;
use wire::settings::{KeyNumber, SettingKind, SettingValue};
use wire::{Setting, Unusable};

use crate::self_test::report;

/// A value as a board keeps it.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptSetting {
    /// Number of its key.
    pub number: KeyNumber,
    /// Its bytes.
    pub value: SettingValue,
    /// What it means, or why it is not used.
    pub setting: Result<Setting, Unusable>,
}

/// What holds for a key of which nothing is kept, where that is a value.
pub fn default_of(kind: SettingKind) -> Option<Setting> {
    match kind {
        SettingKind::Name => Some(Setting::Name(wire::Name::new())),
        SettingKind::TelemetryEvery => Some(Setting::TelemetryEvery(1)),
        SettingKind::Guard => Some(Setting::Command(Command::Guard(dr_core::control::GuardConfig::default()))),
        SettingKind::Observe => Some(Setting::Command(Command::Observe { on: false })),
        SettingKind::HostTimeout => Some(Setting::Command(Command::HostTimeout { timeout_s: dr_core::HOST_TIMEOUT_S })),
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
        Setting::Command(Command::HostTimeout { timeout_s }) => of(serde_json::to_value(timeout_s)),
        // Elements that are compared come first.
        Setting::Command(Command::Fingerprint { resistance_ohm }) => {
            resistance_ohm.iter().copied().take_while(|&of_element| of_element > 0.0).collect()
        }
        Setting::Command(Command::Guard(guard)) => of(serde_json::to_value(guard)),
        Setting::Command(Command::Element { config, .. }) => of(serde_json::to_value(config)),
        Setting::Command(Command::Model { model, .. }) => of(serde_json::to_value(model)),
        Setting::Command(Command::Drive { drive, .. }) => of(serde_json::to_value(drive)),
        Setting::Command(Command::Wind(wind)) => match wind {
            WindCommand::SelfHeating { config, .. } => of(serde_json::to_value(config)),
            WindCommand::Surface { config, .. } => of(serde_json::to_value(config)),
            WindCommand::NusseltPoint { amplitudes, .. } => of(serde_json::to_value(amplitudes)),
            other => of(serde_json::to_value(other)
                .map(|value| value.as_object().and_then(|tagged| tagged.values().next()).cloned().unwrap_or(value))),
        },
        // In brief: `anemo self-test --stored` reports all of it.
        Setting::Tested(record) => format!("{}, {}", report::verdict(&record.finding), report::when(record)).into(),
        Setting::Command(other) => of(serde_json::to_value(other)),
    }
}
