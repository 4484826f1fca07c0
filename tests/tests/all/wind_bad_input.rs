//! A fault of the input stands in every answer that it touches, and in the summaries of `anemo run`
//! and `anemo wind`.

use anemo_tests::Desk;
use anemo_tests::calibrated::{blown, blown_with, uncalibrated};
use dr_core::wind::QualityFlags;
use recording::wind::{QUALITY_FLAGS, WIND_ESTIMATE, WIND_SPEED};
use recording::{ColumnValues, Recording, RecordingColumn, RecordingRow, RecordingWriter};
use serde_json::Value;

/// By then all loops hold their set-points: until then the sphere is warmed at the high level.
const HELD_S: f64 = 150.0;

/// Rows of `quality_flags` from a time on.
struct Told(Recording);

impl Told {
    fn read(desk: &Desk, name: &str) -> Self {
        Self(Recording::read(&desk.path().join(name)).unwrap())
    }

    /// Doubts of all answers between two times, s.
    fn quality_flags(&self, from_s: f64, to_s: f64) -> Vec<QualityFlags> {
        let quality_flags = self.0.numbers(QUALITY_FLAGS).unwrap();
        self.rows(from_s, to_s).map(|row| QualityFlags(quality_flags[row] as u16)).collect()
    }

    /// Rows with an answer.
    fn rows(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = usize> {
        let (time_s, quality_flags) = (self.0.numbers("time_s").unwrap(), self.0.numbers(QUALITY_FLAGS).unwrap());
        (0..time_s.len()).filter(move |&row| (from_s..to_s).contains(&time_s[row]) && quality_flags[row].is_finite())
    }

    fn mean(&self, column: &str, from_s: f64, to_s: f64) -> f64 {
        let values = self.0.numbers(column).unwrap();
        let rows: Vec<usize> = self.rows(from_s, to_s).collect();
        rows.iter().map(|&row| values[row]).sum::<f64>() / rows.len() as f64
    }

    /// Tells whether every answer between two times has all of these doubts, and there is one.
    fn all_have(&self, from_s: f64, to_s: f64, quality_flags: &[QualityFlags]) -> bool {
        let told = self.quality_flags(from_s, to_s);
        !told.is_empty() && told.iter().all(|of| quality_flags.iter().all(|doubt| of.has(*doubt)))
    }

    fn none_has(&self, from_s: f64, to_s: f64, doubt: QualityFlags) -> bool {
        let told = self.quality_flags(from_s, to_s);
        !told.is_empty() && told.iter().all(|of| !of.has(doubt))
    }
}

/// JSON that a command prints; a run may have tripped.
fn json(desk: &Desk, arguments: &[&str]) -> Value {
    let output = desk.anemo(arguments, &[]);
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Runs the experiment, and looks at its recording off line: both summaries.
fn told(desk: &Desk) -> (Told, Value, Value) {
    let run = json(desk, &["run", "e.toml", "--on", "sim", "-o", "r.parquet", "--json"]);
    let wind = json(desk, &["wind", "r.parquet", "-o", "w.parquet", "--json"]);
    for key in ["estimates", "quality_flags", "mean_speed_m_s", "speed_error_m_s"] {
        assert_eq!(run["wind"][key], wind[key], "{key}");
    }
    let text = String::from_utf8(desk.anemo(&["wind", "r.parquet"], &[]).stdout).unwrap();
    for doubt in wind["quality_flags"].as_object().unwrap().keys() {
        assert!(text.contains(doubt.as_str()), "{doubt}: {text}");
    }
    (Told::read(desk, "r.parquet"), run, wind)
}

#[test]
fn a_good_run_is_doubted_only_while_it_begins() {
    let desk = blown(HELD_S + 10.0, &[]);
    let (told, run, _) = told(&desk);
    let doubted = told
        .quality_flags(HELD_S, HELD_S + 10.0)
        .into_iter()
        .find(|quality_flags| *quality_flags != QualityFlags::default());
    assert_eq!(doubted, None);
    assert!(told.all_have(0.0, 0.5, &[QualityFlags::STARTING]));
    let speed_m_s = told.mean(WIND_SPEED, HELD_S, HELD_S + 10.0);
    println!("{speed_m_s:.3} m/s of 5; {run}");
    assert!((speed_m_s / 5.0 - 1.0).abs() < 0.01, "{speed_m_s}");
    assert_eq!(run["wind"]["estimates"], 16_000);
    let text = String::from_utf8(desk.anemo(&["run", "e.toml", "--on", "sim"], &[]).stdout).unwrap();
    assert!(text.contains("wind: 16000 wind estimates, mean speed ") && text.contains("  starting "), "{text}");
}

#[test]
fn a_reference_that_breaks_leaves_no_gas_and_no_wind() {
    let fault = "[[faults]]\nstart_s = 2.0\nelement = \"reference\"\nkind = \"open\"\n\n[[wind]]";
    let desk = blown(5.0, &[("[[wind]]", fault)]);
    let (told, run, _) = told(&desk);
    assert_eq!(run["trips"][0]["element"], "reference");
    // It trips the instrument at once, and its last reading is believed for a second.
    assert!(told.none_has(0.0, 1.99, QualityFlags::NO_GAS) && told.none_has(0.0, 1.99, QualityFlags::NOT_RUNNING));
    assert!(told.all_have(2.01, 5.0, &[QualityFlags::NOT_RUNNING]));
    assert!(told.all_have(3.02, 5.0, &[QualityFlags::NO_GAS, QualityFlags::FAILED]));
    assert!(told.mean(WIND_SPEED, 3.02, 5.0).is_nan(), "no speed is made up");
    assert!(run["wind"]["quality_flags"]["no-gas"].as_u64().unwrap() > 190, "{run}");
}

#[test]
fn a_loop_that_is_too_weak_or_a_wind_beyond_the_calibration_is_flagged() {
    let weak = "[currents]\nsector4 = { low_a = 0.003, high_a = 0.009 }\n\n[drives]";
    let (weak, run, _) = told(&blown(HELD_S + 10.0, &[("[drives]", weak)]));
    println!("{run}");
    assert!(weak.all_have(HELD_S, HELD_S + 10.0, &[QualityFlags::SATURATED]));
    assert!(run["wind"]["quality_flags"]["saturated"].as_u64().unwrap() > 1000, "{run}");
    // Not held, it is still measured: the network knows that the sector is colder.
    let speed_m_s = weak.mean(WIND_SPEED, HELD_S, HELD_S + 10.0);
    println!("with a weak sector {speed_m_s:.3} m/s of 5");
    assert!((speed_m_s / 5.0 - 1.0).abs() < 0.05, "{speed_m_s}");

    let (strong, run, _) = told(&blown(HELD_S + 10.0, &[("speed_m_s = 5.0", "speed_m_s = 20.0")]));
    println!("{run}");
    assert!(strong.all_have(HELD_S, HELD_S + 10.0, &[QualityFlags::SATURATED, QualityFlags::EXTRAPOLATED]));
}

#[test]
fn a_tripped_instrument_says_so_in_every_answer() {
    let fault = "[[faults]]\nstart_s = 60.0\nelement = \"sector2\"\nkind = \"open\"\n\n[[wind]]";
    let (told, run, _) = told(&blown(70.0, &[("[[wind]]", fault)]));
    assert_eq!(run["trips"][0]["element"], "sector2");
    assert!(
        told.none_has(50.0, 59.99, QualityFlags::NOT_RUNNING) && told.none_has(50.0, 59.99, QualityFlags::DEGRADED)
    );
    assert!(told.all_have(60.01, 70.0, &[QualityFlags::NOT_RUNNING]));
    assert!(told.all_have(60.2, 70.0, &[QualityFlags::DEGRADED]), "{run}");
}

#[test]
fn three_sectors_answer_with_a_wider_error_that_holds() {
    let desk = blown(160.0, &[]);
    let all = json(&desk, &["run", "e.toml", "--on", "sim", "-o", "r.parquet", "--json"]);
    assert_eq!(all["trips"].as_array().unwrap().len(), 0);
    without(&desk, "temperature_c_sector2", 100.0);
    let wind = json(&desk, &["wind", "three.parquet", "-o", "w.parquet", "--json"]);
    let (whole, three) = (Told::read(&desk, "r.parquet"), Told::read(&desk, "w.parquet"));
    assert!(three.none_has(80.0, 99.9, QualityFlags::DEGRADED));
    assert!(three.all_have(100.1, 160.0, &[QualityFlags::DEGRADED]));
    assert!(wind["quality_flags"]["degraded"].as_u64().unwrap() > 5900, "{wind}");
    let error = "wind_speed_u_m_s";
    let (before, after) = (whole.mean(error, 120.0, 160.0), three.mean(error, 120.0, 160.0));
    let truth = [-5.0 * 0.5_f64.sqrt(), -5.0 * 0.5_f64.sqrt(), 0.0];
    let told = WIND_ESTIMATE.map(|name| three.mean(name, 120.0, 160.0));
    let angle_deg = anemometry::vector::angle_deg(told, truth);
    let speed_m_s = three.mean(WIND_SPEED, 120.0, 160.0);
    let stated_deg = three.mean("wind_direction_u_deg", 120.0, 160.0);
    println!(
        "three sectors: {speed_m_s:.3} ± {after:.3} m/s of 5 (four: ± {before:.3}), {angle_deg:.2}° off, stated {stated_deg:.2}°"
    );
    assert!(after > before, "{after} {before}");
    assert!((speed_m_s - 5.0).abs() < 4.0 * after, "{speed_m_s} ± {after}");
    assert!(angle_deg < 4.0 * stated_deg, "{angle_deg}° off, {stated_deg}° stated");
}

/// Writes `r.parquet` as `three.parquet`, without the readings of a column from a time on.
fn without(desk: &Desk, column: &str, from_s: f64) {
    rewritten(desk, "three.parquet", column, from_s, &|_| Some(0.0));
}

/// Writes `r.parquet` anew: without the readings of a column from a time on, and with only those
/// rows whose time is moved by something.
fn rewritten(desk: &Desk, name: &str, column: &str, from_s: f64, moved_s: &dyn Fn(f64) -> Option<f64>) {
    let mut recording = Recording::read(&desk.path().join("r.parquet")).unwrap();
    let from = recording.numbers("time_s").unwrap().partition_point(|&time_s| time_s < from_s);
    let Some(RecordingColumn { values: ColumnValues::Numbers(values), .. }) =
        recording.columns.iter_mut().find(|own| own.name == column)
    else {
        panic!("no column {column}")
    };
    values[from..].fill(f64::NAN);
    let of = |prefix: &str, element: &str| recording.numbers(&recording::column_name(prefix, element)).unwrap();
    let elements: Vec<String> = recording.elements().iter().map(|name| (*name).to_owned()).collect();
    let layout = recording::RecordingLayout {
        elements: elements.clone(),
        true_wind: true,
        gas: false,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
    };
    let columns = |prefix: &str| elements.iter().map(|element| of(prefix, element)).collect::<Vec<_>>();
    let (temperature, power, heater) = (columns("temperature_c_"), columns("power_w_"), columns("heater_"));
    let wind = ["true_wind_x_m_s", "true_wind_y_m_s", "true_wind_z_m_s"].map(|name| recording.numbers(name).unwrap());
    let path = desk.path().join(name);
    let mut writer = RecordingWriter::create(&path, layout, &recording.metadata).unwrap();
    for row in 0..recording.len() {
        let time_s = recording.numbers("time_s").unwrap()[row];
        let Some(by_s) = moved_s(time_s) else { continue };
        let narrow = |columns: &[&[f64]]| columns.iter().map(|values| values[row] as f32).collect::<Vec<_>>();
        let heaters = heater.iter().enumerate().map(|(i, values)| usize::from(values[row] != 0.0) << i).sum();
        writer
            .push(&RecordingRow {
                time_s: time_s + by_s,
                temperature_c: &narrow(&temperature),
                power_w: &narrow(&power),
                equivalent_power_w: &[],
                heaters,
                event: "steady",
                state: "running",
                true_wind_m_s: Some(wind.map(|values| values[row])),
                gas_temperature_c: None,
                estimate: &[],
            })
            .unwrap();
    }
    writer.finish(&Vec::new()).unwrap();
}

#[test]
fn rows_that_are_missing_are_gone_through_and_doubted_after() {
    let desk = blown(HELD_S + 40.0, &[]);
    json(&desk, &["run", "e.toml", "--on", "sim", "-o", "r.parquet", "--json"]);
    // 3 s are lost, of a recording that begins at 200 s.
    let (lost_s, back_s) = (HELD_S + 1.0, HELD_S + 4.0);
    let none = f64::INFINITY;
    let moved = |time_s: f64| (!(lost_s..back_s).contains(&time_s)).then_some(200.0);
    rewritten(&desk, "gap.parquet", "temperature_c_sector1", none, &moved);
    let wind = json(&desk, &["wind", "gap.parquet", "-o", "w.parquet", "--every", "0.02", "--json"]);
    assert_eq!((wind["gaps"].as_u64(), wind["output_interval_s"].as_f64()), (Some(1), Some(0.02)), "{wind}");
    assert!((wind["missing_s"].as_f64().unwrap() - 3.0).abs() < 1e-6, "{wind}");
    let told = Told::read(&desk, "w.parquet");
    // Answers stand at the times of their rows, and none where there was no row.
    let time_s = told.0.numbers("time_s").unwrap();
    assert_eq!((time_s[0], time_s[1]), (200.0, 200.02));
    assert_eq!(told.rows(200.0 + lost_s + 0.01, 200.0 + back_s).count(), 0);
    assert_eq!(told.0.words("event").unwrap().dictionary(), ["steady"]);
    // Counted as one tick, the gap would take what the silver did meanwhile for wind: half of it.
    let speed_m_s = told.mean(WIND_SPEED, 200.0 + back_s + 1.0, 200.0 + back_s + 30.0);
    println!("after the gap {speed_m_s:.3} m/s of 5");
    assert!((speed_m_s / 5.0 - 1.0).abs() < 0.01, "{speed_m_s}");
    // For ten times as long as it lasted.
    assert!(told.all_have(200.0 + back_s, 200.0 + back_s + 29.9, &[QualityFlags::STARTING]));
    assert!(told.none_has(200.0 + back_s + 30.0, 400.0, QualityFlags::STARTING));
    let text = String::from_utf8(desk.anemo(&["wind", "gap.parquet"], &[]).stdout).unwrap();
    assert!(text.contains("1 gap in the recording, 3 s in all"), "{text}");

    rewritten(&desk, "back.parquet", "temperature_c_sector1", none, &|time_s| {
        Some(if time_s < 1.0 { 0.0 } else { -0.5 })
    });
    let (code, sentence) = desk.refused(&["wind", "back.parquet", "-o", "none.parquet"], &[]);
    assert!(code == 1 && sentence.contains("row 1001: `time_s` goes from 0.999 s to 0.5 s"), "{sentence}");
    rewritten(&desk, "empty.parquet", "temperature_c_sector1", none, &|_| None);
    let (code, sentence) = desk.refused(&["wind", "empty.parquet"], &[]);
    assert_eq!((code, sentence.as_str()), (2, "empty.parquet: has columns but no rows"));
}

#[test]
fn options_of_wind_that_cannot_be_are_refused_before_anything_is_computed() {
    let desk = blown(3.0, &[]);
    json(&desk, &["run", "e.toml", "--on", "sim", "-o", "r.parquet", "--json"]);
    for (arguments, expected) in [
        (
            ["--every", "0.0015"],
            "--every 0.0015 is not a whole number of sample periods of 0.001 s: 0.001 s or 0.002 s would be",
        ),
        (["--every", "0"], "--every 0 is not a whole number of sample periods of 0.001 s: 0.001 s would be"),
        (["-o", "none/w.csv"], "none/w.csv: cannot be written: there is no folder `none`"),
        (["--plot", "w.gif"], "w.gif: a picture's name ends in .svg, .pdf or .png"),
        (["--bandwidth", "fast"], "(see `anemo wind --help`)"),
    ] {
        let (code, sentence) = desk.refused(&["wind", "r.parquet", arguments[0], arguments[1]], &[]);
        assert!(code == 2 && sentence.ends_with(expected), "{sentence}");
    }
    // Nothing that counts is no perfect answer.
    let none = json(&desk, &["wind", "r.parquet", "--from", "9999", "--json"]);
    assert_eq!((&none["counted"], &none["compared"]), (&Value::from(0), &Value::from(0)));
    assert!(none["speed_worst_error"].is_null() && none["direction_worst_error_deg"].is_null(), "{none}");
    let text = String::from_utf8(desk.anemo(&["wind", "r.parquet", "--from", "9999"], &[]).stdout).unwrap();
    assert!(text.contains("none of them counts: from 9999 s on") && text.contains("no estimates to compare"), "{text}");
    // A pressure of another unit is taken, and said to contradict.
    let text = String::from_utf8(desk.anemo(&["wind", "r.parquet", "--pressure", "10"], &[]).stdout).unwrap();
    assert!(text.contains("gas: co2 of 10 Pa, its temperature by element `reference`"), "{text}");
    assert!(text.contains("warning: --pressure is 10 Pa, but the recording says 1000 Pa"), "{text}");
}

#[test]
fn a_head_of_another_gas_or_with_a_wrong_number_is_refused_by_its_file() {
    let air = blown(3.0, &[("species = \"co2\"", "species = \"air\"")]);
    let (code, sentence) = air.refused(&["check", "e.toml"], &[]);
    assert_eq!(code, 2);
    let expected = "`gas.species` is `air`, but head `sphere-b-reference` is calibrated for co2: another gas is another calibration";
    assert!(sentence.starts_with("e.toml, line ") && sentence.ends_with(expected), "{sentence}");
    // A recording that says so of itself.
    let desk = blown(3.0, &[]);
    json(&desk, &["run", "e.toml", "--on", "sim", "-o", "r.csv", "--json"]);
    let text = std::fs::read_to_string(desk.path().join("r.csv")).unwrap();
    std::fs::write(desk.path().join("air.csv"), text.replace("# gas_species: co2", "# gas_species: air")).unwrap();
    let (code, sentence) = desk.refused(&["wind", "air.csv"], &[]);
    assert!(code == 2 && sentence.starts_with("air.csv: was taken in air, but head"), "{sentence}");

    let text = std::fs::read_to_string(anemo_tests::calibrated::head()).unwrap();
    let at = text.find("\ngain = ").unwrap() + 1;
    let end = at + text[at..].find('\n').unwrap();
    let wrong = desk.path().join("wrong.toml");
    std::fs::write(&wrong, format!("{}gain = 0.0{}", &text[..at], &text[end..])).unwrap();
    let place = 1 + text[..at].matches('\n').count();
    let expected =
        format!("wrong.toml, line {place}: `calibration.surfaces[0].gain` is 0: it must lie between 0.1 and 10");
    let (code, sentence) = desk.refused(&["wind", "r.csv", "--head", "wrong.toml"], &[]);
    assert_eq!((code, sentence.as_str()), (2, expected.as_str()));
    let desk = blown_with(&wrong, 3.0, &[]);
    let (code, sentence) = desk.refused(&["check", "e.toml"], &[]);
    assert!(code == 2 && sentence.ends_with(&expected), "{sentence}");
}

#[test]
fn a_head_without_amplitudes_has_conductances_and_no_wind() {
    let folder = tempfile::tempdir().unwrap();
    let head = folder.path().join("head.toml");
    std::fs::write(&head, uncalibrated()).unwrap();
    let (told, run, _) = told(&blown_with(&head, 60.0, &[]));
    assert!(told.all_have(0.0, 60.0, &[QualityFlags::UNCALIBRATED, QualityFlags::FAILED]));
    assert!(told.mean(WIND_SPEED, 0.0, 60.0).is_nan());
    assert!(told.mean("conductance_w_k_sector1", 50.0, 60.0) > 1e-4);
    assert_eq!(run["wind"]["quality_flags"]["uncalibrated"], run["wind"]["estimates"]);
    assert_eq!(run["wind"]["mean_speed_m_s"], Value::Null);
}
