//! A head whose answers are known: one film that obeys King's law, on a rod.

use super::{GivenConditions, HeadCheckReport, check};
use anemometry::head::Head;
use recording::toml_file::TomlSource;

const A_W_K: f64 = 1e-3;
const B_W_K: f64 = 1e-3;
const ROD_W_K: f64 = 5e-4;
const OVERHEAT_K: f64 = 30.0;

const TEXT: &str = "name = \"king\"
[adc]
full_scale_v = 4.0
bits = 24
compliance_v = 6.0
[guard]
missing_limit_ticks = 1
unreachable_limit_s = 10.0
[[elements]]
name = \"film\"
platinum = { characteristic = \"linear\", resistance_0c_ohm = 100.0, coefficient_per_c = 0.004 }
current_low_a = 0.003
current_high_a = 0.03
resistance_min_ohm = 50.0
resistance_max_ohm = 130.0
temperature_max_c = 70.0
[body]
nodes = [ { name = \"film\", capacity_j_k = 0.01 } ]
links = [ { from = \"film\", to = \"support\", conductance_w_k = 5e-4 } ]
[[body.convection]]
correlation = { kind = \"king\", a_w_k = 1e-3, b_w_k = 1e-3, exponent = 0.5 }
surfaces = [ { name = \"film\" } ]
";

fn checked(changes: &[(&str, &str)]) -> HeadCheckReport {
    checked_at(OVERHEAT_K, changes)
}

fn checked_at(overheat_k: f64, changes: &[(&str, &str)]) -> HeadCheckReport {
    let mut text = TEXT.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let head = Head::from_source(TomlSource { path: "h.toml".into(), text }).unwrap();
    check(&head, GivenConditions::default(), |conditions| conditions.overheat_k = overheat_k).unwrap()
}

#[test]
fn powers_gains_and_time_constants_are_those_by_hand() {
    let report = checked(&[]);
    let at = |speed: f64| A_W_K + B_W_K * speed.sqrt() + ROD_W_K;
    assert!((report.elements[0].own_gain_k_per_w * at(0.0) - 1.0).abs() < 1e-6);
    assert!((report.elements[0].own_gain_in_wind_k_per_w * at(3.0) - 1.0).abs() < 1e-6);
    assert!((report.time_constants_s[0] * at(0.0) / 0.01 - 1.0).abs() < 1e-9);
    assert!((report.time_constants_in_wind_s[0] * at(3.0) / 0.01 - 1.0).abs() < 1e-9);
    assert!((report.range.at_rest_w[0] - at(0.0) * OVERHEAT_K).abs() < 1e-9);
    for needs in &report.range.winds {
        let expected = at(needs.speed_m_s) * OVERHEAT_K;
        assert!((needs.power_w[0][0] - expected).abs() < 1e-9 && (needs.power_w[0][1] - expected).abs() < 1e-9);
    }
    // 30 mA through 120 Ω are 108 mW: 1.5 + √U = 3.6 mW/K, U 4.41 m/s; the last step of the survey
    // below that is within its 12 %.
    let greatest = report.range.greatest_m_s.unwrap();
    assert!((4.41 / 1.123..=4.41).contains(&greatest) && report.range.limited_by == Some(0), "{greatest}");
    assert_eq!((report.warnings.as_slice(), &report.fault), (&[][..], &None));
    assert!(report.to_string().contains(" 1 node, 1 link, 1 surface in the wind\n"), "{report}");
}

#[test]
fn the_resolution_is_that_of_the_formula() {
    let report = checked(&[]);
    // A step of 108 − 1.08 mW rounded at 100 bits a second: 2/12 of (1.069 mW)², so 0.436 mW. Noise
    // of a code, 0.48 µV, is 0.04 mK and adds nothing. dP/dU at 1 m/s is b ΔT / 2 = 15 mW/(m/s).
    let needs = report.range.near(1.0).unwrap();
    let expected = 1.069e-3 / 6.0_f64.sqrt() / 15e-3;
    assert!((needs.resolution_m_s / expected - 1.0).abs() < 0.02, "{} for {expected}", needs.resolution_m_s);
    // Three of these above quiescent gas: b ΔT √U = 1.31 mW, U = 1.9 mm/s, to the next step.
    let least = report.range.least_m_s.unwrap();
    assert!((1.9e-3..1.9e-3 * 1.13).contains(&least), "{least}");
}

#[test]
fn what_would_go_wrong_is_named_with_its_numbers() {
    for (from, to, expected) in [
        (
            "full_scale_v = 4.0",
            "full_scale_v = 3.5",
            "film: has 3.6 V at 50 °C, above the converter's `full_scale_v` of 3.5 V",
        ),
        ("compliance_v = 6.0", "compliance_v = 3.0", "above the `compliance_v` of its current source, 3 V"),
        (
            "resistance_max_ohm = 130.0",
            "resistance_max_ohm = 110.0",
            "has 120 Ω at 50 °C, above its `resistance_max_ohm` of 110 Ω",
        ),
        (
            "temperature_max_c = 70.0",
            "temperature_max_c = 45.0",
            "its `temperature_max_c` of 45 °C is below the set-point of 50 °C",
        ),
        (
            "capacity_j_k = 0.01",
            "capacity_j_k = 1.3e-4",
            // 108 − 1.08 mW for 10 ms.
            "film: a single tick of 10 ms at the high level heats it by 8.2 K",
        ),
        (
            "current_low_a = 0.003",
            "current_low_a = 0.025",
            "film: needs 45 mW in quiescent gas, less than its low level gives, 75 mW",
        ),
        (
            "current_high_a = 0.03",
            "current_high_a = 0.012",
            "no element can be held 30 K above this gas: `film` needs 45 mW in quiescent gas, more than its high level gives, 17.3 mW",
        ),
        (
            "resistance_min_ohm = 50.0",
            "resistance_min_ohm = 110.0",
            // The set-point has 120 Ω.
            "film: has 108 Ω at 20 °C, below its `resistance_min_ohm` of 110 Ω: it trips as shorted",
        ),
        (
            "temperature_max_c = 70.0",
            "temperature_max_c = 70.0\nsustained_power_w = 0.05\nenergy_j = 1.0",
            // 1.5 + √U = 50/30 mW/K at 0.028 m/s, and the next step of the survey.
            "`sustained_power_w` is 0.05 W, and 0.028 m/s takes up to 0.05 W",
        ),
    ] {
        let report = checked(&[(from, to)]);
        let found = report.warnings.iter().any(|warning| warning.contains(expected));
        assert!(found, "{to}: {:?}", report.warnings);
        assert!(report.to_string().contains("\nwarning: "));
    }
}

#[test]
fn an_overheat_that_cannot_be_is_answered_with_those_that_can() {
    // 1.5 mW/K in quiescent gas; of the levels 0.9 and 90 mW at 0 °C, 0.4 % more a kelvin.
    for (overheat_k, change, expected) in [
        (
            100.0,
            ("name", "name"),
            "`film` would have 120 °C, and by its limits it trips above 70 °C; 0.65 to 50 K are possible",
        ),
        (
            0.3,
            ("name", "name"),
            "`film` needs 0.45 mW in quiescent gas, less than its low level gives, 0.973 mW: it stays above the set-point there; \
             0.65 to 50 K are possible",
        ),
        (
            OVERHEAT_K,
            ("current_high_a = 0.03", "current_high_a = 0.012"),
            "`film` needs 45 mW in quiescent gas, more than its high level gives, 17.3 mW; 0.65 to 10 K are possible",
        ),
        (
            OVERHEAT_K,
            ("temperature_max_c = 70.0", "temperature_max_c = 70.0\nsustained_power_w = 0.0302\nenergy_j = 1.0"),
            "`film` needs 45 mW in quiescent gas, more than its `sustained_power_w` of 0.0302 W: it trips once `energy_j` is used up; \
             0.65 to 20 K are possible",
        ),
        (
            OVERHEAT_K,
            ("temperature_max_c = 70.0", "temperature_max_c = 70.0\nonly_senses = true"),
            "`film` only senses, as all others do",
        ),
    ] {
        let report = checked_at(overheat_k, &[change]);
        assert_eq!(report.fault.map(|fault| fault.to_string()).as_deref(), Some(expected));
    }
    // Element of the second sentence.
    assert_eq!((checked_at(0.65, &[]).fault, checked_at(50.0, &[]).fault), (None, None));
}

#[test]
fn a_head_without_a_body_is_refused() {
    let (text, _) = TEXT.split_once("[body]").unwrap();
    let head = Head::from_source(TomlSource { path: "h.toml".into(), text: text.to_owned() }).unwrap();
    let refused = check(&head, GivenConditions::default(), |_| {}).unwrap_err().to_string();
    assert_eq!(
        refused,
        "h.toml: `body` is missing: it says what the head is made of (or a `sensor`, one of \"sphere-a\", \"sphere-b\", \"rems\")"
    );
}

#[test]
fn every_head_of_the_project_is_held_without_a_fault_in_its_file() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut count = 0;
    for path in files.filter(|path| path.extension().is_some_and(|end| end == "toml")) {
        let head = Head::read(&path).unwrap();
        // The wires of Pathfinder, made for a constant current, can be held a little above the gas.
        let overheat_k = if head.name == "pathfinder" { 8.0 } else { OVERHEAT_K };
        let report = check(&head, GivenConditions::default(), |conditions| conditions.overheat_k = overheat_k).unwrap();
        let name = path.display();
        assert!(report.range.greatest_m_s.is_some_and(|most| most > 2.0), "{name}");
        // Strong winds take more than an element bears for long; nothing else is wrong.
        assert!(report.warnings.iter().all(|warning| warning.contains("sustained_power_w")), "{:?}", report.warnings);
        // The ranges of unknown numbers make heads.
        let unknown = head.body.as_ref().map_or(&[][..], |body| &body.unknown);
        head.with_unknown(&unknown.iter().map(|of| of.least).collect::<Vec<_>>()).unwrap();
        count += 1;
    }
    assert!(count >= 10, "{count}");
}
