//! What is kept of settings: a value behind its key's number (two bytes, little-endian), as it
//! comes from a flash or over a link; and the same bytes as a file of settings.

use super::bytes::Bytes;
use super::sentences::{said, said_of};
use dr_core::control::HardwareLimits;
use host_sim::settings::{content, file, names, rehearse};
use recording::toml_file::TomlSource;
use std::collections::BTreeMap;
use wire::Setting;

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    let value = value(bytes);
    std::str::from_utf8(bytes).is_ok_and(text) || value
}

fn value(bytes: &[u8]) -> bool {
    let mut bytes = Bytes(bytes);
    let Some(number) = bytes.u16() else { return false };
    match Setting::read(number, bytes.0) {
        Err(why) => {
            said(&why.to_string());
            false
        }
        Ok(setting) => {
            assert_eq!(setting.key().map(wire::settings::SettingKey::number), Some(number));
            assert_eq!(names::number(&names::of(number)), Some(number), "{setting:?}");
            // Its bytes are compared, since a number may be none.
            let kept = setting.value().expect("no setting is longer than a value");
            let again = Setting::read(number, &kept).expect("what was kept is read");
            assert_eq!(again.value().as_ref(), Ok(&kept));
            content(&setting);
            goes_through_a_file(&BTreeMap::from([(number, setting)]));
            true
        }
    }
}

/// Written as a file and read again, all bits are as they were; but for numbers that are none, of
/// which nobody keeps the bits.
fn goes_through_a_file(settings: &BTreeMap<u16, Setting>) {
    let text = file::to_toml("a firmware", settings).expect("any setting can be written");
    let read = file::from_source(&TomlSource { path: "settings.toml".into(), text: text.clone() });
    let read = read.unwrap_or_else(|error| panic!("{error}: {text}"));
    assert!(&read == settings || file::to_toml("a firmware", &read).as_deref() == Ok(&text), "{text}");
    if let Err(error) = rehearse(settings, &HardwareLimits::SIMULATED) {
        said(&error.to_string());
    }
}

fn text(text: &str) -> bool {
    match file::from_source(&TomlSource { path: "settings.toml".into(), text: text.to_owned() }) {
        Err(error) => {
            said_of("settings.toml", &error.to_string());
            false
        }
        Ok(settings) => {
            goes_through_a_file(&settings);
            true
        }
    }
}
