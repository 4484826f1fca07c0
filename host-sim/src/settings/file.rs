//! Settings as a file: TOML that people can read and change, with its own version.
//!
//! ```toml
//! version = 2
//! firmware = "anemo 0.2.0+1a2b3c4d"
//! name = "north mast"
//! telemetry_every = 1
//!
//! [[setup]]
//!
//! [setup.Guard]
//! missing_limit_ticks = 5
//! unreachable_limit_ticks = 3000
//! stuck_limit_ticks = 200
//! ```
//!
//! Values are those of the wire protocol by their names there. Numbers are the shortest decimals
//! that lead back to the same bits.

use dr_core::Command;
use serde::{Deserialize, Serialize};
use wire::Name;
use wire::settings::{Preface, sets_up};

use super::edit::{Settings, key};
use recording::toml_file::{FileError, TomlSource};

/// Version of the file. Another one is refused.
pub const VERSION: u32 = 2;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsTable {
    version: u32,
    /// Firmware that it was read from; for people.
    firmware: String,
    name: Name,
    telemetry_every: u16,
    #[serde(default)]
    setup: Vec<Command>,
}

/// Writes settings as text.
///
/// # Errors
/// If it cannot be written as TOML.
pub fn to_toml(firmware: &str, settings: &Settings) -> Result<String, toml::ser::Error> {
    let Preface { name, telemetry_every } = settings.preface.clone();
    let (firmware, setup) = (firmware.to_owned(), settings.commands().to_vec());
    toml::to_string(&SettingsTable { version: VERSION, firmware, name, telemetry_every, setup })
}

/// Reads settings from a file.
///
/// # Errors
/// File, line and what is wrong.
pub fn from_source(source: &TomlSource) -> Result<Settings, FileError> {
    #[derive(Deserialize)]
    struct StoredHead {
        version: u32,
    }
    let StoredHead { version } = source.parse()?;
    if version != VERSION {
        return Err(source.refuse("version", format!("is {version}: this program reads version {VERSION}")));
    }
    let SettingsTable { name, telemetry_every, setup, .. } = source.parse()?;
    let mut settings = Settings::new(Preface { name, telemetry_every });
    for (i, command) in setup.into_iter().enumerate() {
        let (place, key) = (format!("setup[{i}]"), key(&command));
        if !sets_up(&command) {
            return Err(source.refuse(&place, "is a command that sets nothing up"));
        }
        if key != "head" && settings.value(key).is_some() {
            return Err(source.refuse(&place, format!("is `{key}`, which stands there twice")));
        }
        settings.put(command);
    }
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::head::Head;
    use dr_core::control::HardwareLimits;

    fn sphere_b() -> Settings {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/sphere-b-calibrated.toml");
        let mut settings = Settings::default();
        settings.set_head(&Head::read(&path).unwrap(), 0.001).unwrap();
        settings.set("name", "north \"mast\" ° 1", None).unwrap();
        settings
    }

    fn source(text: String) -> TomlSource {
        TomlSource { path: "settings.toml".into(), text }
    }

    #[test]
    fn a_whole_head_comes_back_bit_for_bit() {
        let settings = sphere_b();
        let back = from_source(&source(to_toml("anemo", &settings).unwrap())).unwrap();
        assert_eq!(back.bytes().unwrap(), settings.bytes().unwrap());
    }

    #[test]
    fn what_is_wrong_in_it_is_named() {
        let text = to_toml("anemo", &sphere_b()).unwrap();
        let refused = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            from_source(&source(text.replacen(from, to, 1))).unwrap_err().to_string()
        };
        assert!(refused("version = 2", "version = 1").contains("`version` is 1: this program reads version 2"));
        assert!(refused("missing_limit_ticks", "missing_limit").contains("missing_limit"));
        let more = |more: &str| from_source(&source(format!("{text}\n[[setup]]\n{more}\n"))).unwrap_err().to_string();
        assert!(more("Observe = { on = true }\n[[setup]]\nObserve = { on = true }").contains("stands there twice"));
        assert!(more("Arm = { window_s = 1.0 }").contains("sets nothing up"));
        // Right as a file, but nothing that an instrument would take.
        let rehearsed = |settings: &Settings| crate::settings::rehearse(settings, &HardwareLimits::SIMULATED);
        let mut wrong = sphere_b();
        wrong.set("sample_period_s", "100", None).unwrap();
        assert!(rehearsed(&wrong).unwrap_err().to_string().starts_with("sample_period_s: "));
        let lines = text.replace("element = 0\n", "element = 3\n");
        let wrong = from_source(&source(lines)).unwrap();
        assert!(rehearsed(&wrong).unwrap_err().to_string().starts_with("head: element"));
    }
}
