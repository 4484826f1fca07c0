//! The studies of the REMS transducer: every bar is met but those named here, so that one that gets
//! worse, or better, is noticed.

use anemo_tests::studies::study;

#[test]
fn self_heating_has_one_peak_which_is_not_alone_in_changing_with_the_wind() {
    // In a passive network no pole can be alone in changing: the card is in the wind as well.
    study("rems-self", 8, &["largest change of another pole with wind, of this one's"]);
}

#[test]
fn cross_heating_peaks_at_a_tenth_of_a_hertz_and_less_across() {
    // Heat that reaches a neighbour has passed two surfaces that the wind cools: no passive network
    // is without dependence.
    let missed =
        ["an adjacent die", "the diagonal die"].map(|die| format!("peak of {die} in wind from ahead, 7.5 m/min"));
    study("rems-cross", 5, &[&missed[0], &missed[1]]);
}

#[test]
fn four_dice_at_once_are_the_sum_of_models_of_one_each() {
    study("rems-dice", 2, &[]);
}

#[test]
fn the_boom_has_two_poles_and_rises_as_published() {
    study("rems-boom", 6, &[]);
}
