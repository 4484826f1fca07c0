//! The command from outside: exit codes, sentences, and that nothing half-written is left.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

use super::process::anemo;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn experiment(name: &str) -> String {
    root().join("experiments").join(name).display().to_string()
}

/// The code, and the only line on stderr.
fn refused(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = anemo(folder, arguments);
    assert!(output.stdout.is_empty(), "{arguments:?}");
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    let sentence = stderr.strip_prefix("anemo: ").unwrap_or_else(|| panic!("{stderr}")).trim_end();
    (output.status.code().unwrap(), sentence.to_owned())
}

fn files(folder: &Path) -> Vec<String> {
    let mut files: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    files
}

/// A shipped experiment with a change, in a folder of its own.
fn changed(name: &str, from: &str, to: &str) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(experiment(name)).unwrap();
    assert!(text.contains(from), "{from}");
    let heads = root().join("heads").canonicalize().unwrap();
    let text = text.replacen(from, to, 1).replace("../heads", heads.to_str().unwrap());
    std::fs::write(folder.path().join("e.toml"), text).unwrap();
    (folder, "e.toml".to_owned())
}

#[test]
fn a_run_writes_recording_and_plot_and_prints_its_summary() {
    let (folder, file) = changed("all-drives.toml", "duration_s = 120.0", "duration_s = 65.0");
    let folder = folder.path();
    let output = anemo(folder, &["run", &file, "--on", "sim", "-o", "r.parquet", "--plot", "p.svg"]);
    assert!(output.status.success(), "{output:?}");
    // No terminal, no progress bar.
    assert!(output.stderr.is_empty());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("6500 ticks, 65 s; 0 lost") && text.contains("sector1"), "{text}");
    assert_eq!(files(folder), ["e.toml", "p.svg", "r.parquet"]);

    let output = anemo(folder, &["plot", "r.parquet", "-o", "again.svg", "--json"]);
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()["rows"], 6500);
    let recording = recording::Recording::read(&folder.join("r.parquet")).unwrap();
    assert_eq!(recording.len(), 6500);
    assert!((recording.sample_period_s().unwrap() - 0.01).abs() < 1e-15);
    assert_eq!(recording.events().unwrap().dictionary(), ["breeze", "gust"]);
    assert!(recording.metadata("experiment").unwrap().contains("title = \"All drives\""));
    assert!(recording.metadata("models").unwrap().contains("[kinds.core]"));
}

#[test]
fn csv_and_parquet_hold_the_same_run() {
    let (folder, file) = changed("steady.toml", "duration_s = 300.0", "duration_s = 2.0");
    let hash = |name: &str| {
        let output = anemo(folder.path(), &["run", &file, "--on", "sim", "-o", name, "--json"]);
        assert!(output.status.success());
        recording::Recording::read(&folder.path().join(name)).unwrap()
    };
    let (csv, parquet) = (hash("r.csv"), hash("r.parquet"));
    assert_eq!(csv.metadata("hash"), parquet.metadata("hash"));
    let names = |recording: &recording::Recording| {
        recording.columns.iter().map(|column| column.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(names(&csv), names(&parquet));
    for name in names(&csv).iter().filter(|name| *name != "event" && *name != "state") {
        let rounded = |recording: &recording::Recording| {
            recording.numbers(name).unwrap().iter().map(|x| *x as f32).collect::<Vec<_>>()
        };
        assert_eq!(rounded(&csv), rounded(&parquet), "{name}");
    }
}

#[test]
fn json_is_one_object_with_the_promised_keys() {
    let (folder, file) = changed("steady.toml", "duration_s = 300.0", "duration_s = 2.0");
    let output = anemo(folder.path(), &["run", &file, "--on", "sim", "--json"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&json["ticks"], &json["lost"], &json["trips"]), (&200.into(), &0.into(), &serde_json::json!([])));
    assert!(u64::from_str_radix(json["hash"].as_str().unwrap(), 16).is_ok());
    assert!(
        json["elements"]["sector3"]["mean_temperature_c"].is_f64()
            && json["elements"]["core2"]["mean_power_w"].is_f64()
    );

    let output = anemo(folder.path(), &["check", &file, "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["ticks"], &json["head"]), (&200.into(), &"sphere-b".into()));
}

#[test]
fn a_gas_that_swings_is_told_recorded_drawn_and_remarked_upon() {
    let (folder, file) = changed("gas-swing.toml", "duration_s = 1300.0", "duration_s = 20.0");
    let folder = folder.path();
    let text = String::from_utf8(anemo(folder, &["check", &file]).stdout).unwrap();
    assert!(text.contains("in CO2 of 1000 Pa at -53.15 °C ± 5 K in 600 s, support at -43.15 °C"), "{text}");
    let json: serde_json::Value = serde_json::from_slice(&anemo(folder, &["check", &file, "--json"]).stdout).unwrap();
    assert_eq!(json["gas_swing"], serde_json::json!({ "amplitude_k": 5.0, "period_s": 600.0, "start_s": 0.0 }));

    let output = anemo(folder, &["run", &file, "--on", "sim", "-o", "r.csv", "--plot", "p.svg"]);
    assert!(output.status.success(), "{output:?}");
    let csv = std::fs::read_to_string(folder.join("r.csv")).unwrap();
    let mut rows = csv.lines().filter(|line| !line.starts_with('#'));
    assert!(rows.next().unwrap().ends_with(",true_wind_z_m_s,gas_temperature_c"));
    let gas_c = |row: &str| row.rsplit(',').next().unwrap().parse::<f64>().unwrap();
    let all: Vec<f64> = rows.map(gas_c).collect();
    assert_eq!(all.len(), 2000);
    // f32, so 4e-6 K.
    for (tick, gas_c) in all.iter().enumerate() {
        let expected = -53.15 + 5.0 * libm::sin(std::f64::consts::TAU * tick as f64 * 0.01 / 600.0);
        assert!((gas_c - expected).abs() < 5e-6, "{tick}: {gas_c} for {expected}");
    }
    // It swings about the value of the metadata.
    assert!(csv.contains("\n# gas_temperature_c: -53.15\n"));

    let output = anemo(folder, &["identify", "r.csv", "--input", "sector1", "--output", "sector1"]);
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).join("");
    assert!(text.contains("the gas temperature oscillated while this was recorded"), "{text}");
}

#[test]
fn check_tells_what_changes_and_whose_currents_are_the_experiment_s() {
    let folder = tempfile::tempdir().unwrap();
    let file = experiment("thesis/rems-boom-held.toml");
    let text = String::from_utf8(anemo(folder.path(), &["check", &file]).stdout).unwrap();
    for line in [
        "boom        constant temperature, 28.5 °C",
        "from   7200 s  boom: passive: only senses",
        "from  14400 s  boom: constant temperature, 28.5 °C",
        "boom: 10 mA low and 19.9 mA high, in place of the head's",
    ] {
        assert!(text.lines().any(|own| own == line), "{line}\n{text}");
    }
    let output = anemo(folder.path(), &["check", &file, "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["changes"].as_array().unwrap().len(), 3);
    assert_eq!(
        json["changes"][0],
        serde_json::json!({ "start_s": 7200.0, "drives": { "boom": "passive: only senses" } })
    );
    assert_eq!(json["currents"], serde_json::json!({ "boom": { "low_a": 0.01, "high_a": 0.0199 } }));

    let output = anemo(folder.path(), &["check", &experiment("gusts.toml")]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(!text.contains("in place of the head's") && !text.contains("passive: only senses;"), "{text}");
}

#[test]
fn what_a_board_cannot_do_is_refused_before_it_begins() {
    let (boom, other) = (experiment("thesis/rems-boom-held.toml"), experiment("sphere-a.toml"));
    let (hot, _) = changed("steady.toml", "temperature_c = -23.15 }", "temperature_c = 69.0 }");
    let (fast, slow) = changed("steady.toml", "sample_period_s = 0.01", "sample_period_s = 2.0");
    let head = std::fs::read_to_string(root().join("heads/sphere-b.toml")).unwrap();
    let with_head = |from: &str, to: &str| {
        assert!(head.contains(from));
        std::fs::write(hot.path().join("head.toml"), head.replace(from, to)).unwrap();
        let text = std::fs::read_to_string(hot.path().join("e.toml")).unwrap();
        let of_head =
            |line: &str| if line.starts_with("head = ") { "head = \"head.toml\"".into() } else { line.to_owned() };
        let lines = text.lines().filter(|line| !line.starts_with("models")).map(of_head);
        std::fs::write(hot.path().join("own.toml"), lines.collect::<Vec<_>>().join("\n")).unwrap();
        refused(hot.path(), &["check", "own.toml"]).1
    };
    let (code, sentence) = refused(hot.path(), &["check", &boom, "--on", "serial"]);
    assert_eq!(code, 2);
    assert!(sentence.ends_with("`head` cannot be used: the head has 13 elements, the board can drive 6"), "{sentence}");
    // The port is not looked at before.
    for arguments in [vec!["check"], vec!["run", "-o", "r"], vec!["log", "-o", "r"]] {
        let arguments = [arguments.as_slice(), &[other.as_str(), "--on", "serial:/no"]].concat();
        let (code, sentence) = refused(hot.path(), &arguments);
        let reason = "asks for what this board does not grant: hemisphere1: `current_low_a` must lie between";
        assert!(code == 2 && sentence.contains(reason), "{arguments:?}: {sentence}");
    }
    assert!(anemo(hot.path(), &["check", &other]).status.success());
    assert!(refused(fast.path(), &["check", &slow]).1.contains("`sample_period_s` is 2 s: it must lie between"));
    let open = with_head("resistance_max_ohm = 260.0", "resistance_max_ohm = 205.0");
    assert!(open.contains("`drives.sector1.temperature_c` is 69 °C: the element counts as open above 5"), "{open}");
    let range = with_head("full_scale_v = 4.0", "full_scale_v = 3.2");
    assert!(range.contains("is 69 °C: the converter's range ends at 4"), "{range}");
    assert_eq!(files(hot.path()), ["e.toml", "head.toml", "own.toml"]);
}

#[test]
fn wrong_usage_is_code_2_and_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let gusts = experiment("gusts.toml");
    for (arguments, expected) in [
        (vec!["rum"], "unrecognized subcommand 'rum'"),
        (
            vec!["run", &gusts],
            "the following required arguments were not provided: --on <sim|qemu|serial:DEVICE|scpi:HOST>",
        ),
        (vec!["run", &gusts, "--on", "simulator"], "it is sim, qemu, serial:DEVICE or scpi:HOST"),
        (vec!["run", &gusts, "--on", "serial:"], "a serial port is named too"),
        (
            vec!["log", &gusts, "--on", "sim", "-o", "r", "--publish", "nmea+udp://127.0.0.1:9"],
            "nmea+udp://127.0.0.1:9: head `sphere-b` has no calibration, so that there is no wind to send",
        ),
        (vec!["log", &gusts, "--on", "sim", "-o", "r", "--keep", "0d"], "`0d`: a time from 1 s to 100 years (30s"),
        (vec!["run", &gusts, "--on", "sim", "--plto", "a.svg"], "a similar argument exists: '--plot'"),
        (vec!["run", "no.toml", "--on", "sim"], "no.toml: there is no such file"),
        (vec!["check", "."], ".: is a folder: an experiment, a .toml file, belongs here"),
        (vec!["run", &gusts, "--on", "sim", "-o", "a.xlsx"], "a.xlsx: a recording's name ends in .parquet or .csv"),
        (vec!["run", &gusts, "--on", "sim", "-o", "no/a.csv"], "there is no folder `no`"),
        (
            vec!["run", &gusts, "--on", "sim", "-o", "a.csv", "--plot", "a.gif"],
            "a.gif: a picture's name ends in .svg, .pdf or .png",
        ),
        (
            vec!["calibrate", "no.parquet", "--network", "no.json", "--diameter-mm", "0"],
            "--diameter-mm is 0: it must lie between 0.001 and 1000 mm",
        ),
        (
            vec!["calibrate", "no.parquet", "--network", "no.json", "--die-mm", "nan"],
            "--die-mm is NaN: it must lie between 0.001 and 1000 mm",
        ),
        (vec!["plot", "no.parquet", "-o", "a.svg"], "no.parquet: there is no such file"),
        (vec!["recover", "no.parquet"], "no.parquet: there is no such recording, and no journal of one"),
        (vec!["run", &gusts, "--on", "silicon", "--link", "usart"], "--link: only qemu has a choice of links"),
        (
            vec!["board", "settings", "show", "--on", "silicon", "--link", "fifo"],
            "--link: only qemu has a choice of links",
        ),
        (vec!["run", &gusts, "--on", "sim", "--flash", "a.flash"], "name --on qemu or --on silicon"),
        (vec!["board", "status", "--on", "silicon"], "silicon begin with the command and end with it"),
    ] {
        let (code, sentence) = refused(folder.path(), &arguments);
        assert_eq!(code, 2, "{sentence}");
        assert!(sentence.contains(expected), "{sentence}");
    }
    assert!(files(folder.path()).is_empty());
}

#[test]
fn bad_experiments_are_wrong_usage_and_start_nothing() {
    for (from, to, expected) in [
        ("speed_m_s = 3.0", "speed_ms = 3.0", "e.toml, line 35: unknown key `speed_ms`; did you mean `speed_m_s`?"),
        ("bit_time_s = 0.02", "bit_time_s = 0.013", "0.01 s or 0.02 s would be"),
        ("duration_s = 120.0", "duration_s = nan", "`duration_s` is NaN s"),
        (
            "temperature_c = -30.0",
            "temperature_c = 300.0",
            "`drives.sector1.temperature_c` is 300 °C: the head's limit is 70 °C",
        ),
    ] {
        let (folder, file) = changed("all-drives.toml", from, to);
        let (code, sentence) = refused(folder.path(), &["run", &file, "--on", "sim", "-o", "r.csv", "--plot", "p.svg"]);
        assert_eq!(code, 2, "{sentence}");
        assert!(sentence.contains(expected), "{sentence}");
        assert_eq!(files(folder.path()), ["e.toml"]);
    }
}

#[test]
fn a_set_point_that_the_model_calls_out_of_reach_is_refused_at_its_line() {
    // Levels of 1.4 and 43 mW at 1309 K/W end at -42.9 and some 12 °C; the gas has -53.15 °C, the
    // head's limit is 70 °C.
    for (target, expected) in [
        ("{ temperature_c = 30.0 }", "asks for 30 °C, which cannot be held: at the high level it ends at "),
        (
            "{ temperature_c = -43.5 }",
            "asks for -43.5 °C, which cannot be held: even at the low level it ends at -43.0 °C",
        ),
        (
            "{ setpoints = { low_c = -30.0, high_c = 40.0, dwell_s = 10.0, seed = 1 } }",
            "asks for 40 °C, which cannot be held: at the high level it ends at ",
        ),
    ] {
        let (folder, file) =
            changed("steady.toml", "sector1 = { temperature_c = -23.15 }", &format!("sector1 = {target}"));
        for arguments in [vec!["check", &file], vec!["run", &file, "--on", "sim", "-o", "r.csv", "--plot", "p.svg"]] {
            let (code, sentence) = refused(folder.path(), &arguments);
            assert_eq!(code, 2);
            assert!(
                sentence.starts_with(&format!("e.toml, line 20: `drives.sector1` {expected}"))
                    && sentence.ends_with(
                        "sphere-b-mars-still.toml (for still CO2 of 1000 Pa at -53.15 °C, support at -43.15 °C)"
                    ),
                "{sentence}"
            );
        }
        assert_eq!(files(folder.path()), ["e.toml"]);
    }
}

#[test]
fn what_fails_to_start_is_code_1_and_leaves_nothing() {
    let (folder, file) = changed("steady.toml", "duration_s = 300.0", "duration_s = 2.0");
    for (on, extra, expected) in
        [("serial:/dev/no-such-port", vec![], "/dev/no-such-port"), ("qemu", vec!["--firmware", "no.elf"], "no.elf")]
    {
        let mut arguments = vec!["run", &file, "--on", on, "-o", "r.parquet", "--plot", "p.svg"];
        arguments.extend(extra);
        let (code, sentence) = refused(folder.path(), &arguments);
        assert_eq!(code, 1, "{sentence}");
        assert!(sentence.contains(expected), "{sentence}");
        assert_eq!(files(folder.path()), ["e.toml"]);
    }
}

#[test]
fn a_cut_recording_is_refused_and_the_old_picture_stays() {
    let (folder, file) = changed("steady.toml", "duration_s = 300.0", "duration_s = 2.0");
    let folder = folder.path();
    assert!(anemo(folder, &["run", &file, "--on", "sim", "-o", "r.parquet"]).status.success());
    let whole = std::fs::read(folder.join("r.parquet")).unwrap();
    std::fs::write(folder.join("r.parquet"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(folder.join("p.svg"), "old").unwrap();
    let (code, sentence) = refused(folder, &["plot", "r.parquet", "-o", "p.svg"]);
    assert_eq!(code, 2);
    assert!(sentence.contains("r.parquet: is damaged or cut short"), "{sentence}");
    assert_eq!(std::fs::read_to_string(folder.join("p.svg")).unwrap(), "old");
}

#[test]
fn a_self_test_without_simulated_noise_names_the_key_of_the_noise() {
    let (folder, file) = changed("gusts.toml", "noise_v_rms = 1.5e-6", "noise_v_rms = 0.0");
    let output = anemo(folder.path(), &["self-test", &file, "--on", "sim", "--no-heat"]);
    assert_eq!(output.status.code(), Some(1));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains(" of 6 elements; `frozen`: ") && stderr.contains("`front_end.noise_v_rms`"), "{stderr}");
}

#[test]
fn a_result_that_cannot_be_printed_is_a_failure() {
    for argument in ["--version", "--help"] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let status =
            Command::new(env!("CARGO_BIN_EXE_anemo")).arg(argument).stdout(full).stderr(Stdio::null()).status();
        assert_eq!(status.unwrap().code(), Some(1), "{argument}");
    }
}

#[test]
fn help_is_no_error_and_gives_examples() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [vec!["--help"], vec!["run", "--help"], vec!["check", "--help"], vec!["plot", "--help"]] {
        let output = anemo(folder.path(), &arguments);
        assert!(output.status.success() && output.stderr.is_empty());
        assert!(String::from_utf8(output.stdout).unwrap().contains("Example"));
    }
    assert_eq!(anemo(folder.path(), &[]).status.code(), Some(2));
}
