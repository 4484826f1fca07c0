use std::path::PathBuf;

use dr_core::sensor::Level;

use super::*;
use crate::sensor::{DirectionSwing, Sine, Spectrum, TemperatureSwing, Turbulence};
use std::path::Path;

use dr_core::control::Drive;
use recording::toml_file::TomlSource;

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
    let mut source = TomlSource { path: path("test.toml"), text: text.replacen(from, to, 1) };
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
    let folders = ["", "thesis"].map(|folder| std::fs::read_dir(path(folder)).unwrap());
    for entry in folders.into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            Experiment::read(&path).unwrap();
            found += 1;
        }
    }
    assert!(found >= 27, "{found}");
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
fn what_blows_on_top_of_a_mean_is_read() {
    let blown = |line: &str| {
        let experiment = with("turbulence = { intensity = 0.15, correlation_time_s = 1.5 }", line)?;
        Ok::<_, String>(experiment.wind[1].clone())
    };
    let entry = blown(
        "turbulence = { spectrum = \"von-karman\", intensity = 0.2, length_m = 6.0 }\n\
         gust = { start_s = 1.0, duration_s = 2.5, rise_m_s = 3.0, elevation_deg = 10.0 }\n\
         sine = { amplitude_m_s = 1.0, frequency_hz = 0.5 }\nswing = { amplitude_deg = 20.0, frequency_hz = 0.1 }\n\
         dust_devil = { time_s = 4.0, miss_m = -3.0, core_radius_m = 5.0, swirl_m_s = 10.0, travel_m_s = 6.0 }",
    )
    .unwrap();
    assert_eq!(entry.turbulence, Some(Turbulence { intensity: 0.2, spectrum: Spectrum::VonKarman { length_m: 6.0 } }));
    let gust = entry.gust.unwrap();
    assert_eq!((gust.start_s, gust.duration_s, gust.rise_m_s), (1.0, 2.5, 3.0));
    assert_eq!((gust.azimuth_deg, gust.elevation_deg), (None, Some(10.0)));
    assert_eq!(entry.sine, Some(Sine { amplitude_m_s: 1.0, frequency_hz: 0.5 }));
    assert_eq!(entry.swing, Some(DirectionSwing { amplitude_deg: 20.0, frequency_hz: 0.1 }));
    let devil = entry.dust_devil.unwrap();
    assert_eq!((devil.time_s, devil.miss_m, devil.core_radius_m, devil.swirl_m_s), (4.0, -3.0, 5.0, 10.0));
    assert_eq!((devil.inflow_m_s, devil.travel_m_s, devil.travel_azimuth_deg), (0.0, Some(6.0), None));
    let kaimal = blown("turbulence = { spectrum = \"kaimal\", intensity = 0.3, height_m = 1.5 }").unwrap();
    assert_eq!(kaimal.turbulence.unwrap().spectrum, Spectrum::Kaimal { height_m: 1.5 });
}

#[test]
fn what_cannot_blow_is_refused_by_key_value_and_remedy() {
    for (line, expected) in [
        ("turbulence = { intensity = 0.15 }", "`wind[1].turbulence.correlation_time_s` is missing: it is the scale of"),
        ("turbulence = { spectrum = \"kaimal\", intensity = 0.1 }", "`wind[1].turbulence.height_m` is missing"),
        (
            "turbulence = { spectrum = \"kaimal\", intensity = 0.1, height_m = 1.0, length_m = 2.0 }",
            "`wind[1].turbulence.length_m` does not go with spectrum \"kaimal\", whose scale is `height_m`",
        ),
        (
            "turbulence = { intensity = 0.1, length_m = 2.0 }",
            "`wind[1].turbulence.length_m` does not go with turbulence without a `spectrum`, whose scale is \
             `correlation_time_s`",
        ),
        (
            "turbulence = { spectrum = \"von-karmann\", intensity = 0.1, length_m = 2.0 }",
            "unknown choice `von-karmann` for `spectrum`; did you mean `von-karman`?",
        ),
        (
            "turbulence = { spectrum = \"von-karman\", intensity = 0.1, length_m = -2.0 }",
            "`wind[1].turbulence.length_m` is -2: it must be more than 0, and no less than",
        ),
        ("gust = { start_s = 1.0, rise_m_s = 2.0 }", "the key `duration_s` is missing"),
        (
            "gust = { start_s = 5.0, duration_s = 1.0, rise_m_s = 2.0 }",
            "line 28: `wind[1].gust.start_s` is 5 s after the start of a wind that is over after 5 s",
        ),
        (
            "gust = { start_s = 1.0, duration_s = 1.0, rise_m_s = -4.5 }",
            "line 28: `wind[1].gust.rise_m_s` is -4.5: it must be 100 at most, and a lull no more than",
        ),
        ("sine = { amplitude_m_s = 5.0, frequency_hz = 1.0 }", "`wind[1].sine.amplitude_m_s` is 5: it must be 0 to"),
        ("sine = { amplitude_m_s = 1.0, frequency_hz = 60.0 }", "at most half the sample rate"),
        ("swing = { amplitude = 5.0, frequency_hz = 1.0 }", "unknown key `amplitude`; did you mean `amplitude_deg`?"),
        (
            "dust_devil = { time_s = 6.0, miss_m = 0.0, core_radius_m = 5.0, swirl_m_s = 9.0 }",
            "`wind[1].dust_devil.time_s` is 6 s after the start of a wind that is over after 5 s",
        ),
        (
            "dust_devil = { time_s = 2.0, miss_m = 0.0, core_radius_m = 5.0, swirl_m_s = 9.0, travel_m_s = 0.0 }",
            "`wind[1].dust_devil.travel_m_s` is 0: it must be 0.01 to 100",
        ),
    ] {
        let sentence = refused("turbulence = { intensity = 0.15, correlation_time_s = 1.5 }", line);
        assert!(sentence.contains(expected) && !sentence.contains('\n'), "{line}: {sentence}");
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
    let sentence = Experiment::from_source(TomlSource { text, ..source }).unwrap().sensor().unwrap_err().to_string();
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
    let read = |text: String| Experiment::from_source(TomlSource { text, ..source.clone() });
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
        DriveChange { tick: 200, drives: vec![(5, Drive::Passive)] },
        DriveChange { tick: 450, drives: vec![(0, Drive::Temperature { target_c: -30.0 })] },
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

#[test]
fn a_swing_of_the_gas_is_read_and_checked() {
    let gas = "temperature_c = -53.15\n";
    let swing = |keys: &str| with(gas, &format!("{gas}swing = {{ {keys} }}\n"));
    let found = swing("amplitude_k = 5.0, period_s = 600.0").unwrap();
    assert_eq!(found.gas_swing, Some(TemperatureSwing { amplitude_k: 5.0, period_s: 600.0, start_s: 0.0 }));
    assert_eq!(found.sensor_config().unwrap().gas_swing, found.gas_swing);
    // It swings about the value that models and recordings state.
    assert_eq!((found.gas_temperature_c, found.conditions()), (-53.15, with("", "").unwrap().conditions()));
    assert_eq!(swing("amplitude_k = 5.0, period_s = 600.0, start_s = 2.5").unwrap().gas_swing.unwrap().start_s, 2.5);
    for (keys, expected) in [
        (
            "amplitude_k = 71.0, period_s = 600.0",
            "`gas.swing.amplitude_k` is 71: it must be so small that the gas stays",
        ),
        ("amplitude_k = 0.0, period_s = 600.0", "`gas.swing.amplitude_k` is 0: it must be more than 0"),
        ("amplitude_k = 5.0, period_s = 0.1", "`gas.swing.period_s` is 0.1: it must be at least 20 sample periods"),
        ("amplitude_k = 5.0, period_s = 600.0, start_s = -1.0", "`gas.swing.start_s` is -1: it must be zero or more"),
        (
            "amplitude_k = 5.0, period_s = 600.0, start_s = 10.0",
            "`gas.swing.start_s` is 10 s, but the experiment is over",
        ),
        ("amplitude_k = 5.0, period_s = 600.0, start_s = 0.005", "which is not a whole number of sample periods"),
        ("amplitude_k = 5.0", "the key `period_s` is missing"),
        ("amplitude_c = 5.0, period_s = 600.0", "did you mean `amplitude_k`?"),
    ] {
        let sentence = swing(keys).unwrap_err();
        assert!(sentence.starts_with("test.toml, line ") && sentence.contains(expected), "{keys}: {sentence}");
    }
}

#[test]
fn drives_must_do_in_all_of_the_gas_that_swings() {
    let gas = "temperature_c = -53.15\n";
    let swinging = |from: &str, to: &str, amplitude_k: f64| {
        let mut source = with(from, to).unwrap().source;
        source.text = source.text.replacen(
            gas,
            &format!("{gas}swing = {{ amplitude_k = {amplitude_k:?}, period_s = 60.0 }}\n"),
            1,
        );
        Experiment::from_source(source).map_err(|error| error.to_string())
    };
    // The coldest set-point of the experiment is -30 °C.
    assert!(swinging("", "", 23.0).is_ok());
    let sentence = swinging("", "", 24.0).unwrap_err();
    assert!(
        sentence.contains("setpoints.low_c` is -30 °C, but the gas has -77.15 to -29.15 °C and a heater cannot cool"),
        "{sentence}"
    );
    // I²R of 16 mA: 37.4 mW at -53.15 °C and 36.7 mW at -58.15 °C, where the gas is coldest.
    let power = ("power_w = 0.01", "power_w = 0.0372");
    assert!(with(power.0, power.1).is_ok());
    let sentence = swinging(power.0, power.1, 5.0).unwrap_err();
    assert!(sentence.contains("at the gas's -58.15 to -48.15 °C"), "{sentence}");
    let refused = with("power_w = 0.01", "power_w = 0.5").unwrap_err();
    assert!(refused.ends_with("at the gas's -53.15 °C"), "{refused}");
}

#[test]
fn a_swing_on_a_head_that_nothing_simulates_is_checked_too() {
    let swing = TemperatureSwing { amplitude_k: -1.0, period_s: 60.0, start_s: 0.0 };
    let mut experiment = with("", "").unwrap();
    (experiment.construction, experiment.gas_swing) = (None, Some(swing));
    let sentence = experiment.check_conditions().unwrap_err().to_string();
    assert!(sentence.contains("`gas.swing.amplitude_k` is -1"), "{sentence}");
}

#[test]
fn the_wind_output_is_read_and_refused_by_key_and_line() {
    let with = |table: &str| {
        let mut source = TomlSource::read(&path("wind/sphere-b/winds.toml")).unwrap();
        source.text = source.text.replacen("[gas]", &format!("{table}\n\n[gas]"), 1);
        source.text =
            source.text.replacen("head = \"", "head = \"../../../tests/fixtures/sphere-b-calibrated.toml\" # \"", 1);
        Experiment::from_source(source).map_err(|error| error.to_string())
    };
    let output =
        with("[wind_output]\nbandwidth_hz = 5.0\ninterval_s = 0.02\nfixed = true").unwrap().wind_output.unwrap();
    assert_eq!((output.bandwidth_hz, output.fixed), (5.0, true));
    for (table, expected) in [
        ("[wind_output]\ninterval_s = -1.0", "`wind_output.interval_s` is -1 s"),
        ("[wind_output]\nbandwidth_hz = 100.0", "`wind_output.bandwidth_hz` is 100 Hz: it must lie between"),
        ("[wind_output]\nevery_s = 0.02", "unknown key `every_s`"),
        ("[answer]", "unknown key `answer`"),
    ] {
        let sentence = with(table).unwrap_err();
        assert!(sentence.contains(expected) && sentence.contains("winds.toml, line "), "{sentence}");
    }
}

#[test]
fn every_effect_of_the_field_has_an_experiment_that_switches_it_on() {
    for (name, keys) in [
        ("support-swing", &[][..]),
        ("sun", &["sun"]),
        ("surface-heat", &["surface_heat"]),
        ("sky", &["sky"]),
        ("drifts", &["drifts"]),
        ("film", &["gas.properties"]),
        ("buoyancy", &["buoyancy"]),
        ("stem", &["stem"]),
    ] {
        let experiment = Experiment::read(&path(&format!("field/{name}.toml"))).unwrap();
        assert_eq!(experiment.field.keys(), keys, "{name}");
        assert_eq!(experiment.sensor_config().unwrap().field, experiment.field);
    }
}

#[test]
fn effects_that_cannot_be_are_refused_with_their_line() {
    for (table, expected) in [
        ("[sun]\nirradiance_w_m2 = 590.0\nabsorptivity = 2.0\n", "line 9: `sun.absorptivity` is 2: it must be 0 to 1"),
        (
            "[[drifts]]\nelement = \"sector7\"\nquantity = \"gain\"\nchange = -0.05\n",
            "line 8: `drifts[0].element` is `sector7`, which is no element of the head",
        ),
        (
            "[stem.wake]\nangle_deg = 120.0\nfactor = 0.8\n",
            "line 8: `stem.wake.angle_deg` is 120: it must be more than 0",
        ),
        ("[sky]\ncolour = 1\n", "line 8: unknown key `colour`; known are `temperature_c`, `emissivity`"),
    ] {
        let sentence = refused("[gas]\n", &format!("{table}\n[gas]\n"));
        assert!(sentence.contains(expected), "{sentence}");
    }
}
