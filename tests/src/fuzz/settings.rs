//! Fuzzed settings: a record as it comes from flash or over a link, and the same bytes as a file of
//! settings.

use super::sentences::{said, said_of};
use dr_core::control::HardwareLimits;
use host_sim::settings::{Settings, file, rehearse};
use recording::toml_file::TomlSource;

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    let record = match Settings::from_bytes(bytes) {
        Err(why) => {
            said(&why.to_string());
            false
        }
        Ok(settings) => {
            // Bytes are compared, since a number may be NaN.
            let stored = settings.bytes().expect("settings that were read are written");
            let again = Settings::from_bytes(&stored).expect("settings that were written are read");
            assert_eq!(again.bytes().as_ref(), Ok(&stored));
            goes_through_a_file(&settings);
            true
        }
    };
    std::str::from_utf8(bytes).is_ok_and(text) || record
}

/// Written as a file and read again, all bits are as they were; but for NaN, of which nobody keeps
/// the bits. A record may have a key twice, which a file may not.
fn goes_through_a_file(settings: &Settings) {
    let mut once = Settings::new(settings.preface.clone());
    settings.commands().iter().for_each(|command| once.put(*command));
    let text = file::to_toml("a firmware", &once).expect("any settings can be written");
    let read = file::from_source(&TomlSource { path: "settings.toml".into(), text: text.clone() });
    let read = read.unwrap_or_else(|error| panic!("{error}: {text}"));
    assert!(read == once || file::to_toml("a firmware", &read).as_deref() == Ok(&text), "{text}");
    if let Err(error) = rehearse(&once, &HardwareLimits::SIMULATED) {
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
