//! Sentences of refusals.

extern crate std;

use super::*;
use crate::control::guard::Cause;
use crate::error::{Parameter, ParameterProblem};
use std::collections::BTreeSet;
use std::string::ToString;

#[test]
fn every_refusal_has_words_of_its_own_and_its_numbers_in_them() {
    let error = ConfigError { parameter: Parameter::PowerW, problem: ParameterProblem::NotPositive };
    let trip = Trip::of(3, Cause::OverTemperature);
    let unreachable = |verdict| Refusal::Unreachable { element: 2, target_c: -31.5, verdict };
    // Words that have to be in the sentence, beside what else it says.
    let all: [(Refusal, &[&str]); 16] = [
        (Refusal::NotInStandby, &["standby", "stop"]),
        (Refusal::Tripped(trip), &["over-temperature", "element 3", "acknowledge"]),
        (Refusal::NotTripped, &["no trip"]),
        (Refusal::NoSuchElement { element: 7 }, &["no element 7"]),
        (Refusal::NotConfigured { element: 5 }, &["element 5", "configuration"]),
        (Refusal::NoSamplePeriod, &["sample period"]),
        (Refusal::Invalid { element: Some(4), error }, &["element 4", "`power_w`"]),
        (Refusal::Invalid { element: None, error }, &["`power_w`"]),
        (
            unreachable(Reachability::LowLevelTooWarm { least_rise_k: 21.25 }),
            &["element 2", "-31.5 °C", "low", "21.25 K"],
        ),
        (
            unreachable(Reachability::HighLevelTooCold { most_rise_k: 8.75 }),
            &["element 2", "-31.5 °C", "high", "8.75 K"],
        ),
        (Refusal::NoAnemometer, &["anemometer"]),
        (Refusal::NotArmed, &["arm"]),
        (Refusal::OtherHead { element: 7 }, &["element 7", "fingerprint", "cool"]),
        (Refusal::NoResistor { element: 6 }, &["place 6", "capacitor"]),
        (Refusal::Stopped, &["stop", "again"]),
        (Refusal::LockedOut, &["3 trips in 10 minutes", "supply", "reset pin"]),
    ];
    let mut said = BTreeSet::new();
    for (refusal, parts) in all {
        let sentence = refusal.to_string();
        for part in parts {
            assert!(sentence.contains(part), "{part:?} is not in {sentence:?}");
        }
        assert!(said.insert(sentence), "{refusal:?}");
    }
    // A number of the whole instrument is nobody's element.
    assert!(!Refusal::Invalid { element: None, error }.to_string().contains("element"));
    let can = unreachable(Reachability::Reachable { steady_power_w: 0.02 }).to_string();
    assert!(can.contains("can be held at -31.5 °C"), "{can}");
}
