//! A calibrated sphere B for tests of its answers, and what it is blown at with.
//!
//! The head is one that `studies benchmark wind --heads` wrote. How good it is, is no matter of these
//! tests; that it is made well, the test `wind_chain` asks.

use std::path::{Path, PathBuf};

use crate::{Desk, file};

/// The head file.
pub fn head() -> PathBuf {
    file("tests/fixtures/sphere-b-calibrated.toml").canonicalize().expect("the calibrated head is there")
}

/// The parts of the head without the amplitudes of the Nusselt number, without which it has
/// conductances and no wind.
pub fn uncalibrated() -> String {
    let text = std::fs::read_to_string(head()).expect("the calibrated head can be read");
    let begin = text.find("[calibration.nusselt]").expect("it has amplitudes");
    let end = begin + text[begin..].find("[[calibration.surfaces]]").expect("it has surfaces");
    format!("{}{}", &text[..begin], &text[end..])
}

/// A desk with the calibrated head in 5 m/s for so many seconds at 1 kHz, and some of the
/// experiment's text replaced.
pub fn blown(duration_s: f64, changes: &[(&str, &str)]) -> Desk {
    blown_with(&head(), duration_s, changes)
}

/// The same with another head.
pub fn blown_with(head: &Path, duration_s: f64, changes: &[(&str, &str)]) -> Desk {
    let text = std::fs::read_to_string(file("experiments/wind/sphere-b/turbulence.toml")).expect("it is shipped");
    let steady = text.find("[[wind]]\nstart_s = 150.0").expect("its turbulence follows a steady wind");
    let mut text = text[..steady].to_owned();
    let own = [
        ("\"../../../heads/sphere-b-reference.toml\"", format!("{:?}", head.display().to_string())),
        ("duration_s = 450.0", format!("duration_s = {duration_s:.1}")),
    ];
    let own = own.iter().map(|(from, to)| (*from, to.as_str()));
    for (from, to) in own.chain(changes.iter().copied()) {
        assert!(text.contains(from), "the experiment does not contain `{from}`");
        text = text.replacen(from, to, 1);
    }
    Desk::with(&text)
}
