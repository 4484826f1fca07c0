//! The studies of the REMS transducer: every bar is met but those named here, so that one that gets worse, or better, is noticed.

use std::path::{Path, PathBuf};

use host_sim::thesis::{Findings, Lab, STUDIES};

fn study(name: &str) -> Findings {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/thesis");
    let study = STUDIES.iter().find(|study| study.name == name).unwrap_or_else(|| panic!("no study {name}"));
    study.run(&Lab::new(folder, &|_| {})).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Runs a study, which must have so many bars and miss those of these beginnings only.
fn misses(name: &str, bars: usize, expected: &[&str]) {
    let found = study(name);
    let missed: Vec<&str> =
        found.findings.iter().filter(|of| of.met == Some(false)).map(|of| of.what.as_str()).collect();
    assert_eq!(missed, expected, "{name}: {:#?}", found.findings);
    assert_eq!(found.score().0, bars, "{name}: {:#?}", found.findings);
    assert!(found.svg.starts_with("<svg") && !found.caption.is_empty() && !found.words.is_empty(), "{name}");
}

#[test]
fn self_heating_has_one_peak_which_is_not_alone_in_changing_with_the_wind() {
    // In a passive network no pole can be alone in changing: the card is in the wind as well.
    misses("rems-self", 8, &["largest change of another pole with wind, of this one's"]);
}

#[test]
fn cross_heating_peaks_at_a_tenth_of_a_hertz_and_less_across() {
    // Heat that reaches a neighbour has passed two surfaces that the wind cools: no passive network is without dependence.
    let missed =
        ["an adjacent die", "the diagonal die"].map(|die| format!("peak of {die} in wind from ahead, 7.5 m/min"));
    misses("rems-cross", 5, &[&missed[0], &missed[1]]);
}

#[test]
fn four_dice_at_once_are_the_sum_of_models_of_one_each() {
    misses("rems-dice", 2, &[]);
}

#[test]
fn the_boom_has_two_poles_and_rises_as_published() {
    misses("rems-boom", 6, &[]);
}
