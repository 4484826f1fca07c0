//! Settings as a file: TOML that people can read and change, with its own version.
//!
//! ```toml
//! version = 1
//! firmware = "anemo 0.2.0+1a2b3c4d"
//!
//! [[setting]]
//! key = "name"
//! value.Name = "north mast"
//!
//! [[setting]]
//! key = "guard"
//!
//! [setting.value.Command.Guard]
//! missing_limit_ticks = 5
//! unreachable_limit_ticks = 3000
//! stuck_limit_ticks = 200
//! ```
//!
//! Values are those of the wire protocol by their names there. Numbers are the shortest decimals
//! that lead back to the same bits.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use wire::Setting;
use wire::settings::KeyNumber;

use super::names;
use recording::toml_file::{FileError, TomlSource};

/// Version of the file. Another one is refused.
pub const VERSION: u32 = 1;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsTable {
    version: u32,
    /// What it was read from; for people.
    firmware: String,
    #[serde(default)]
    setting: Vec<SettingEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingEntry {
    key: String,
    value: Setting,
}

/// The file's text.
///
/// # Errors
/// If it cannot be written as TOML.
pub fn to_toml(firmware: &str, settings: &BTreeMap<KeyNumber, Setting>) -> Result<String, toml::ser::Error> {
    let setting = settings.iter().map(|(&key, value)| SettingEntry { key: names::of(key), value: value.clone() });
    toml::to_string(&SettingsTable { version: VERSION, firmware: firmware.to_owned(), setting: setting.collect() })
}

/// Reads it.
///
/// # Errors
/// File, line and what is wrong.
pub fn from_source(source: &TomlSource) -> Result<BTreeMap<KeyNumber, Setting>, FileError> {
    #[derive(Deserialize)]
    struct StoredHead {
        version: u32,
    }
    let StoredHead { version } = source.parse()?;
    if version != VERSION {
        return Err(source.refuse("version", format!("is {version}: this program reads version {VERSION}")));
    }
    let table: SettingsTable = source.parse()?;
    let mut settings = BTreeMap::new();
    for (i, SettingEntry { key, value }) in table.setting.into_iter().enumerate() {
        let place = format!("setting[{i}].key");
        let number = value.key().map(wire::settings::SettingKey::number);
        let Some(number) = number else {
            return Err(source.refuse(&place, "has a command that sets nothing up"));
        };
        if names::is_the_boards(number) {
            return Err(source.refuse(&place, format!("is `{key}`, which a board writes by itself: leave it out")));
        }
        if names::of(number) != key {
            let sentence = format!("is `{key}`, but its value is one of `{}`", names::of(number));
            return Err(source.refuse(&place, sentence));
        }
        if settings.insert(number, value).is_some() {
            return Err(source.refuse(&place, format!("is `{key}`, which stands there twice")));
        }
    }
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::head::Head;
    use dr_core::control::HardwareLimits;

    #[test]
    fn a_head_of_more_elements_than_a_board_has_is_refused() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads/sphere-b.toml");
        let mut head = Head::read(&path).unwrap();
        let first = head.elements[0].clone();
        head.elements.resize(24, first);
        let refused = crate::settings::of_head(&head, 0.01, &mut BTreeMap::new()).unwrap_err();
        assert_eq!(refused.to_string(), "the head has 24 elements, boards have room for 16");
    }

    fn sphere_b() -> BTreeMap<KeyNumber, Setting> {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/sphere-b-calibrated.toml");
        let head = Head::from_source(TomlSource::read(&path).unwrap()).unwrap();
        let mut settings = BTreeMap::new();
        crate::settings::of_head(&head, 0.001, &mut settings).unwrap();
        names::set(&mut settings, "name", "north \"mast\" ° 1").unwrap();
        settings
    }

    fn source(text: String) -> TomlSource {
        TomlSource { path: "settings.toml".into(), text }
    }

    #[test]
    fn a_whole_head_comes_back_bit_for_bit() {
        let settings = sphere_b();
        assert!(settings.len() > 80, "{}", settings.len());
        crate::settings::rehearse(&settings, &HardwareLimits::SIMULATED).unwrap();
        let text = to_toml("anemo", &settings).unwrap();
        let back = from_source(&source(text)).unwrap();
        assert_eq!(back.len(), settings.len());
        for (key, setting) in &settings {
            assert_eq!(back[key].value().unwrap(), setting.value().unwrap(), "{}", names::of(*key));
        }
    }

    #[test]
    fn what_is_wrong_in_it_is_named() {
        let text = to_toml("anemo", &sphere_b()).unwrap();
        let refused = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            from_source(&source(text.replacen(from, to, 1))).unwrap_err().to_string()
        };
        assert!(refused("version = 1", "version = 2").contains("`version` is 2: this program reads version 1"));
        assert!(refused("key = \"guard\"", "key = \"observe\"").contains("but its value is one of `guard`"));
        assert!(refused("key = \"element.1\"", "key = \"element.0\"").contains("is one of `element.1`"));
        assert!(refused("missing_limit_ticks", "missing_limit").contains("missing_limit"));
        let twice = format!("{text}\n[[setting]]\nkey = \"name\"\nvalue.Name = \"x\"\n");
        assert!(from_source(&source(twice)).unwrap_err().to_string().contains("stands there twice"));
        // Right as a file, but nothing that an instrument would take.
        let mut wrong = sphere_b();
        names::set(&mut wrong, "sample_period_s", "100").unwrap();
        assert!(
            crate::settings::rehearse(&wrong, &HardwareLimits::SIMULATED)
                .unwrap_err()
                .to_string()
                .starts_with("sample_period_s: ")
        );
        wrong.retain(|&key, _| key != 0x1000);
        names::set(&mut wrong, "sample_period_s", "0.001").unwrap();
        assert!(
            crate::settings::rehearse(&wrong, &HardwareLimits::SIMULATED)
                .unwrap_err()
                .to_string()
                .starts_with("element.1: element 0 has no configuration")
        );
    }
}
