use std::path::PathBuf;

use dr_core::sensor::Level;

use super::*;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments").join(name)
}

/// An experiment that is right, until `change` has been at it.
fn with(from: &str, to: &str) -> Result<Experiment, String> {
    let text = r#"title = "Test"
head = "../heads/sphere-b.toml"
sample_period_s = 0.01
duration_s = 10.0
seed = 7

[gas]
species = "co2"
pressure_pa = 1000.0
temperature_c = -53.15

[drives]
sector1 = { temperature_c = -23.15 }
sector2 = { prbs = { order = 10, bit_time_s = 0.02, seed = 1 } }
sector3 = { setpoints = { low_c = -30.0, high_c = -20.0, dwell_s = 1.5, seed = 3 } }
core1 = { power_w = 0.01 }
core2 = { level = "high" }

[[wind]]
start_s = 0.0
label = "calm"
speed_m_s = 2.0

[[wind]]
start_s = 5.0
speed_m_s = 4.0
azimuth_deg = 90.0
turbulence = { intensity = 0.15, correlation_time_s = 1.5 }
"#;
    assert!(text.contains(from), "{from}");
    let mut source = Source { path: path("test.toml"), text: text.replacen(from, to, 1) };
    source.text.push('\n');
    Experiment::from_source(source).map_err(|error| {
        let text = error.to_string();
        text[text.find("test.toml").unwrap_or(0)..].to_owned()
    })
}

fn refused(from: &str, to: &str) -> String {
    with(from, to).unwrap_err()
}

#[test]
fn every_drive_is_read_in_ticks() {
    let experiment = with("", "").unwrap();
    assert_eq!(experiment.ticks, 1000);
    assert_eq!(
        experiment.drives,
        [
            Drive::Temperature { target_c: -23.15 },
            Drive::Prbs { order: 10, seed: 1, ticks_per_bit: 2 },
            Drive::Setpoints { low_c: -30.0, high_c: -20.0, dwell_ticks: 150, seed: 3 },
            Drive::Passive,
            Drive::Power { power_w: 0.01 },
            Drive::Level(Level::High),
        ]
    );
    assert_eq!(experiment.support_temperature_c, experiment.gas_temperature_c);
}

#[test]
fn the_label_changes_with_the_tick_at_which_the_wind_does() {
    let experiment = with("", "").unwrap();
    assert_eq!([0, 499, 500, 999].map(|tick| experiment.event(tick)), ["calm", "calm", "wind 2", "wind 2"]);
}

#[test]
fn times_have_no_rounding_tails() {
    let experiment = with("", "").unwrap();
    assert_eq!(experiment.time_s(29).to_string(), "0.29");
    assert!((0..1000).all(|tick| experiment.time_s(tick).to_string().len() <= 4));
}

#[test]
fn the_experiments_that_come_with_the_project_are_right() {
    let mut found = 0;
    for entry in std::fs::read_dir(path("")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            Experiment::read(&path).unwrap();
            found += 1;
        }
    }
    assert!(found >= 5, "{found}");
    assert_eq!(Experiment::read(&path("gusts.toml")).unwrap().ticks, 100_000);
}

#[test]
fn records_of_a_network_are_of_one_specimen_and_drive_one_element_each() {
    for (folder, elements) in [("wind/sphere-a", 4), ("wind/sphere-b", 6)] {
        let mut driven = Vec::new();
        for entry in std::fs::read_dir(path(folder)).unwrap() {
            let path = entry.unwrap().path();
            if !path.file_name().unwrap().to_string_lossy().starts_with("identify-") {
                continue;
            }
            let experiment = Experiment::read(&path).unwrap();
            let config = experiment.sensor_config().unwrap();
            // Resistors are drawn from a stream of the seed that nothing else draws from.
            assert_eq!((config.seed, config.imperfections.resistance_error_percent), (41, 0.06));
            driven.push(experiment.changes.iter().map(|change| change.drives.len()).sum::<usize>());
        }
        assert_eq!(driven, vec![1; elements], "{folder}");
    }
}

#[test]
fn unknown_keys_and_names_are_answered_with_the_nearest() {
    assert_eq!(
        refused("speed_m_s = 2.0", "speed_ms = 2.0"),
        "test.toml, line 22: unknown key `speed_ms`; did you mean `speed_m_s`?"
    );
    assert_eq!(
        refused("temperature_c = -23.15", "temprature_c = -23.15"),
        "test.toml, line 13: unknown choice `temprature_c` for `sector1`; did you mean `temperature_c`?"
    );
    assert_eq!(
        refused("core2 =", "cor2 ="),
        "test.toml, line 17: `drives.cor2` is no element of head `sphere-b`; did you mean `core2`?"
    );
    assert!(refused("species = \"co2\"", "species = \"CO_2\"").contains("did you mean `co2`?"));
    assert!(refused("{ level = \"high\" }", "{ level = \"hihg\" }").contains("did you mean `high`?"));
    assert!(refused("bit_time_s = 0.02, ", "").contains("line 14: the key `bit_time_s` is missing"));
}

#[test]
fn a_bit_time_between_two_samples_is_refused_with_its_neighbours() {
    assert_eq!(
        refused("bit_time_s = 0.02", "bit_time_s = 0.025"),
        "test.toml, line 14: `drives.sector2.prbs.bit_time_s` is 0.025 s, which is not a whole number of sample periods of 0.01 s: \
         0.02 s or 0.03 s would be"
    );
    assert!(refused("bit_time_s = 0.02", "bit_time_s = 0.004").contains("at least one sample period, 0.01 s"));
    assert!(refused("bit_time_s = 0.02", "bit_time_s = 0.007").contains("sample periods of 0.01 s: 0.01 s would be"));
}

#[test]
fn impossible_values_are_refused_by_key_value_and_remedy() {
    for (from, to, expected) in [
        ("duration_s = 10.0", "duration_s = -1.0", "line 4: `duration_s` is -1 s: it must be finite and above 0 s"),
        ("duration_s = 10.0", "duration_s = nan", "`duration_s` is NaN s"),
        ("duration_s = 10.0", "duration_s = inf", "`duration_s` is inf s"),
        ("duration_s = 10.0", "duration_s = 0.001", "at least one sample period"),
        ("duration_s = 10.0", "duration_s = 1e12", "it can be 42949673 s at most"),
        (
            "sample_period_s = 0.01",
            "sample_period_s = 2.0",
            "`sample_period_s` is 2 s: it must lie between 0.001 and 1 s",
        ),
        ("sample_period_s = 0.01", "sample_period_s = nan", "`sample_period_s` is NaN s"),
        ("order = 10", "order = 40", "`drives.sector2.prbs.order` is 40: it must lie between 2 and 32"),
        ("order = 10", "order = 1", "`drives.sector2.prbs.order` is 1"),
        ("seed = 1 }", "seed = 1023 }", "`drives.sector2.prbs.seed` is 1023: it must not be all ones"),
        ("start_s = 0.0", "start_s = 1.0", "`wind[0].start_s` is 1: it must be 0 for the first entry"),
        ("start_s = 5.0", "start_s = 0.0", "`wind[1].start_s` is 0: it must be later"),
        ("start_s = 5.0", "start_s = 12.0", "but the experiment is over at 10 s"),
        (
            "speed_m_s = 2.0",
            "speed_m_s = -2.0",
            "line 22: `wind[0].speed_m_s` is -2 m/s: it must lie between 0 and 100 m/s",
        ),
        ("speed_m_s = 2.0", "speed_m_s = 101.0", "`wind[0].speed_m_s` is 101 m/s"),
        ("speed_m_s = 2.0", "speed_m_s = nan", "`wind[0].speed_m_s` is NaN m/s"),
        ("azimuth_deg = 90.0", "azimuth_deg = inf", "`wind[1].azimuth_deg` is inf: it must be a finite angle"),
        ("intensity = 0.15", "intensity = -0.15", "`wind[1].turbulence.intensity` is -0.15"),
        ("pressure_pa = 1000.0", "pressure_pa = -1.0", "`gas.pressure_pa` is -1: it must be 1 to 200000 Pa"),
        ("pressure_pa = 1000.0", "pressure_pa = 2.0", "line 9: `gas.pressure_pa` is 2: the gas is no continuum"),
        ("pressure_pa = 1000.0", "pressure_pa = nan", "`gas.pressure_pa` is NaN"),
        ("temperature_c = -53.15", "temperature_c = -300.0", "`gas.temperature_c` is -300"),
        ("temperature_c = -53.15", "temperature_c = -123.2", "`gas.temperature_c` is -123.2"),
        (
            "temperature_c = -23.15",
            "temperature_c = 90.0",
            "`drives.sector1.temperature_c` is 90 °C: the head's limit is 70 °C",
        ),
        ("temperature_c = -23.15", "temperature_c = nan", "`drives.sector1.temperature_c` is NaN °C"),
        ("temperature_c = -23.15", "temperature_c = -60.0", "but the gas has -53.15 °C and a heater cannot cool"),
        (
            "power_w = 0.01",
            "power_w = 0.1",
            "`drives.core1.power_w` is 0.1 W: the levels of core1 reach from 0.00132 to 0.03742 W",
        ),
        ("power_w = 0.01", "power_w = nan", "`drives.core1.power_w` is NaN W"),
        ("high_c = -20.0", "high_c = -30.0", "`drives.sector3.setpoints.high_c` is -30 °C: it must lie above `low_c`"),
        ("dwell_s = 1.5", "dwell_s = 1.505", "1.5 s or 1.51 s would be"),
        ("head = \"../heads/sphere-b.toml\"", "head = \"nowhere.toml\"", "line 2: `head` cannot be used:"),
        ("seed = 7", "seed = 7\nmodels = \"nowhere.toml\"", "line 6: `models` cannot be used:"),
        ("seed = 7", "seed = -7", "`seed`: invalid value: integer `-7`"),
    ] {
        let sentence = refused(from, to);
        assert!(sentence.contains(expected), "{to}: {sentence}");
        assert!(!sentence.contains('\n'));
    }
}

#[test]
fn a_gas_may_be_as_cold_as_the_manual_says() {
    assert_eq!(with("temperature_c = -53.15", "temperature_c = -123.15").unwrap().gas_temperature_c, -123.15);
}

#[test]
fn an_experiment_without_wind_is_told_how_to_ask_for_still_gas() {
    let source = with("", "").unwrap().source;
    let text = source.text[..source.text.find("[[wind]]").unwrap()].to_owned();
    let sentence = Experiment::from_source(Source { text, ..source }).unwrap_err().to_string();
    assert!(
        sentence
            .contains("`wind` is missing: write one [[wind]] with start_s = 0.0, and speed_m_s = 0.0 for still gas"),
        "{sentence}"
    );
}

#[test]
fn faults_name_their_element() {
    let fault = |element: &str| {
        with("[[wind]]", &format!("[[faults]]\nstart_s = 1.0\nelement = \"{element}\"\nkind = \"open\"\n\n[[wind]]"))
    };
    assert_eq!(fault("core1").unwrap().faults[0].element, 4);
    assert!(
        fault("core9")
            .unwrap_err()
            .contains("`faults[0].element` is `core9`, which is no element of head `sphere-b`; did you mean `core")
    );
}

#[test]
fn a_damaged_file_is_refused_or_read_but_never_panics() {
    let source = with("", "").unwrap().source;
    let read = |text: String| Experiment::from_source(Source { text, ..source.clone() });
    for at in (0..source.text.len()).step_by(7) {
        let _ = read(source.text[..at].to_owned());
        for junk in ["=", "\"", "[", "-", "nan ", "ü"] {
            let (before, after) = source.text.split_at(at);
            if let Err(error) = read(format!("{before}{junk}{after}")) {
                assert!(!error.to_string().contains('\n'));
            }
        }
    }
}

#[test]
fn changes_and_currents_are_read_and_checked() {
    let changed = |text: &str| with("[[wind]]\nstart_s = 0.0", &format!("{text}\n\n[[wind]]\nstart_s = 0.0"));
    let change = |start_s: f64, drives: &str| format!("[[changes]]\nstart_s = {start_s:?}\ndrives = {{ {drives} }}\n");
    let found =
        changed(&(change(2.0, "core2 = \"passive\"") + &change(4.5, "sector1 = { temperature_c = -30.0 }"))).unwrap();
    let exact = [
        Change { tick: 200, drives: vec![(5, Drive::Passive)] },
        Change { tick: 450, drives: vec![(0, Drive::Temperature { target_c: -30.0 })] },
    ];
    assert_eq!(found.changes, exact);
    let refused = |text: String| changed(&text).unwrap_err();
    let hint = refused(change(2.0, "core9 = \"passive\""));
    assert!(hint.contains("`changes[0].drives.core9` is no element of head `sphere-b`; did you mean"), "{hint}");
    assert!(refused(change(10.0, "core1 = \"passive\"")).contains("is 10 s, but the experiment is over at 10 s"));
    assert!(refused(change(1.005, "core1 = \"passive\"")).contains("whole number of sample periods"));
    let back = change(3.0, "core1 = \"passive\"") + &change(2.0, "core2 = \"passive\"");
    let late = refused(back);
    assert!(late.contains("`changes[1].start_s` is 2 s: changes must come in the order of their start"), "{late}");
    assert!(late.ends_with("the one before starts at 3 s, so that 3.01 s or later would do"), "{late}");
    assert!(refused(change(3.0, "")).contains("changes nothing"));
    assert!(
        refused(change(3.0, "core1 = { temperature_c = 200.0 }")).contains("changes[0].drives.core1.temperature_c")
    );

    let with_currents = |line: &str| with("[drives]", &format!("[currents]\n{line}\n\n[drives]"));
    let found = with_currents("core1 = { low_a = 0.005, high_a = 0.0199 }").unwrap();
    assert_eq!(found.head.elements[4].nominal.current_high_a, 0.0199);
    let power_w = found.head.elements[4].power_w(0.0, Level::High);
    assert!((power_w / (175.0 * 0.0199 * 0.0199) - 1.0).abs() < 1e-6, "{power_w}");
    assert!(
        with_currents("core1 = { low_a = 0.02, high_a = 0.01 }")
            .unwrap_err()
            .contains("`currents.core1` is { low_a = 0.02, high_a = 0.01 }: high_a must be above low_a")
    );
    assert!(with_currents("core9 = { low_a = 0.01, high_a = 0.02 }").unwrap_err().contains("is no element of head"));
}
