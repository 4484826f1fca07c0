//! `anemo head new` and `head check`: from nothing to a head that runs.

use std::path::Path;

use super::process::{anemo, stdout};

#[test]
fn every_kind_is_a_head_that_is_checked_and_held_in_winds_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for kind in ["wire", "cylinder", "sphere", "plate"] {
        let text = stdout(&anemo(folder, &["head", "new", kind, "--kind", kind]));
        assert!(text.contains(&format!("anemo head check {kind}/head.toml --overheat 20")), "{text}");
        let head = format!("{kind}/head.toml");
        let text = stdout(&anemo(folder, &["head", "check", &head, "--overheat", "20", "--plot", "p.svg"]));
        assert!(text.starts_with(&format!("{kind} in ")) && text.contains("\nwinds "), "{text}");
        assert!(!text.contains("warning"), "{text}");
        assert!(std::fs::read_to_string(folder.join("p.svg")).unwrap().contains(&format!("Head {kind}")));
        let experiments: Vec<String> = std::fs::read_dir(folder.join(kind))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| name != "head.toml")
            .collect();
        assert!(experiments.contains(&"held.toml".to_owned()) && experiments.len() >= 2, "{experiments:?}");
        for name in &experiments {
            stdout(&anemo(folder, &["check", &format!("{kind}/{name}")]));
        }
    }
    // A wire takes the least time.
    let text = stdout(&anemo(folder, &["run", "wire/held.toml", "--on", "sim", "-o", "held.csv", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&json["lost"], &json["trips"]), (&0.into(), &serde_json::json!([])));
    assert!(json["elements"]["film"]["mean_power_w"].as_f64().unwrap() > 0.01, "{json}");
}

#[test]
fn experiments_follow_a_head_that_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let heads = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads");
    for (name, overheat, expected) in [
        ("viking", "100", "facing_azimuth_deg = 45"),
        ("meda", "20", "plane = \"upright\""),
        ("metwind", "20", "plane = \"level\""),
    ] {
        let file = heads.join(format!("{name}.toml")).display().to_string();
        stdout(&anemo(folder, &["head", "new", name, "--from", &file, "--overheat", overheat]));
        let tunnel = std::fs::read_to_string(folder.join(name).join("tunnel.toml")).unwrap();
        assert!(tunnel.contains(expected), "{tunnel}");
        assert!(tunnel.starts_with(&format!("title = \"{name}: calibration in a tunnel\"")), "{tunnel}");
        let known = |element: &str| folder.join(name).join(format!("identify-{element}.toml")).exists();
        assert!(!known("junction1") && !known("reference") && !known("cold1") && !known("boom"), "{name}");
        stdout(&anemo(folder, &["check", &format!("{name}/tunnel.toml")]));
    }
    // An element that only senses is not driven.
    let path = folder.join("viking/held.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("[drives]\n", "[drives]\njunction1 = { level = \"high\" }\n", 1)).unwrap();
    let output = anemo(folder, &["check", "viking/held.toml"]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && stderr.contains("drives `junction1`, which only senses"), "{stderr}");
}

#[test]
fn what_is_there_stays_and_what_cannot_be_a_name_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stdout(&anemo(folder, &["head", "new", "tube", "--kind", "cylinder"]));
    let before = std::fs::read_to_string(folder.join("tube/head.toml")).unwrap();
    for (arguments, expected) in [
        (&["head", "new", "tube", "--kind", "wire"][..], "tube: is there already; nothing was written"),
        (
            &["head", "new", "hot", "--kind", "wire", "--overheat", "300"],
            "--overheat is 300: `film` would have 320 °C, and by its limits it trips above 60 °C; ",
        ),
        (&["head", "new", "hot"], "either --kind or --from is needed"),
        (&["head", "new", "a b", "--kind", "wire"], "a folder of letters, digits and hyphens belongs here"),
        (&["head", "check", "tube/head.toml", "--overheat", "-3"], "--overheat is -3: it must be finite and above 0"),
        (&["head", "check", "tube/held.toml"], "unknown key `drives`"),
        (&["head", "check", "tube/head.toml", "--temperature", "500"], "it must be -123.15 to 126.85 °C"),
    ] {
        let output = anemo(folder, arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(expected) && stderr.lines().count() == 1, "{arguments:?}: {stderr}");
    }
    assert_eq!(std::fs::read_to_string(folder.join("tube/head.toml")).unwrap(), before);
}

fn project_head(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads").join(name).display().to_string()
}

#[test]
fn what_would_come_to_nothing_is_refused_with_the_limit_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A gas colder than the limits of a kind, and a body that takes months.
    stdout(&anemo(folder, &["head", "new", "tube", "--kind", "cylinder"]));
    let text = std::fs::read_to_string(folder.join("tube/head.toml")).unwrap();
    let changed = |file: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        std::fs::write(folder.join(file), text.replace(from, to)).unwrap();
    };
    let air = "species = \"air\", pressure_pa = 101325.0, temperature_c = 20.0";
    changed("cold.toml", air, "species = \"co2\", pressure_pa = 700.0, temperature_c = -53.15");
    changed("huge.toml", "\"tube\", capacity_j_k = 0.2", "\"tube\", capacity_j_k = 2e3");
    let (rems, pathfinder) = (project_head("rems.toml"), project_head("pathfinder.toml"));
    let (sphere, bench) = (project_head("sphere-a.toml"), project_head("bench-cylinder.toml"));
    let shorted = "`film1` has 790.55 Ω at -53.15 °C, below its `resistance_min_ohm` of 850 Ω";
    for (arguments, expected) in [
        (&["--from", &rems, "--overheat", "60"][..], "52 mW; 3.1 to 9.6 and 11 to 33 K are possible"),
        (&["--from", &pathfinder, "--overheat", "60"], "--overheat is 60: `wire"),
        (&["--kind", "wire", "--overheat", "1000"], "--overheat is 1000: `film` would have 1020 °C"),
        (&["--from", &sphere, "--overheat", "60"], "more than its `sustained_power_w` of 0.05 W"),
        (&["--from", &bench, "--overheat", "5"], "less than its low level gives, 4.39 mW"),
        (&["--from", "cold.toml"], shorted),
        (&["--from", "huge.toml"], "huge.toml: `body` has a slowest time constant of "),
    ] {
        let output = anemo(folder, &[&["head", "new", "none"], arguments].concat());
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), stderr.lines().count()), (Some(2), 1), "{arguments:?}: {stderr}");
        assert!(stderr.contains(expected), "{arguments:?}: {stderr}");
        assert!(!stderr.contains("--overheat is") || stderr.contains(" K are possible"), "{stderr}");
        assert!(output.stdout.is_empty() && !folder.join("none").exists(), "{arguments:?}");
    }
    let text = stdout(&anemo(folder, &["head", "check", "cold.toml"]));
    assert!(text.contains(&shorted[9..]), "{text}");
}

#[test]
fn printed_commands_identify_what_is_held_and_only_that() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Its cores can give less than the stem takes.
    let sphere = project_head("sphere-a.toml");
    let text = std::fs::read_to_string(&sphere).unwrap();
    let weak = text.replace("current_high_a = 0.025", "current_high_a = 0.010");
    assert_ne!(weak, text);
    std::fs::write(folder.join("weak.toml"), weak).unwrap();
    let text = stdout(&anemo(folder, &["head", "new", "ball", "--from", "weak.toml", "--overheat", "40"]));
    let names = "hemisphere1,hemisphere2";
    assert!(text.contains(&format!("-o ball/network.json \\\n  --elements {names}\n")), "{text}");
    for name in names.split(',') {
        let path = folder.join(format!("ball/identify-{name}.toml"));
        let text = std::fs::read_to_string(&path).unwrap();
        let at = text.find("duration_s = ").unwrap();
        let (line, _) = text[at..].split_once('\n').unwrap();
        std::fs::write(&path, text.replacen(line, "duration_s = 900.0", 1)).unwrap();
        let (path, record) = (format!("ball/identify-{name}.toml"), format!("ball/id-{name}.parquet"));
        stdout(&anemo(folder, &["run", &path, "--on", "sim", "-o", &record]));
    }
    let records = ["ball/id-hemisphere1.parquet", "ball/id-hemisphere2.parquet"];
    let identify = ["head", "identify", records[0], records[1], "-o", "ball/network.json"];
    stdout(&anemo(folder, &[&identify[..], &["--elements", names]].concat()));
    // All that may be driven are: nothing is to be named.
    let text = stdout(&anemo(folder, &["head", "new", "all", "--from", &sphere]));
    assert!(text.contains("for e in hemisphere1 hemisphere2 core1 core2\n") && !text.contains("--elements"), "{text}");
    // Winds that are too much are named.
    let pathfinder = project_head("pathfinder.toml");
    let output = anemo(folder, &["head", "new", "mars", "--from", &pathfinder, "--overheat", "20"]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    let expected = "warning: winds of the experiments reach 10 m/s, but `wire4` can be held up to 3.55 m/s: ";
    assert!(stderr.starts_with(expected) && stderr.lines().count() == 1, "{stderr}");
    // So is a head that `anemo calibrate` refuses; the commands end before it.
    let output = anemo(folder, &["head", "new", "boom", "--from", &project_head("rems.toml")]);
    let stderr = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(stderr.contains("no `anemo calibrate` follows: head `boom` has 12 elements"), "{stderr}");
    assert!(stdout(&output).ends_with("card3-die3,card3-die4\n"), "{output:?}");
    // Little overheat takes currents so near each other that a board would refuse them.
    let bench = project_head("bench-cylinder.toml");
    stdout(&anemo(folder, &["head", "new", "bench", "--from", &bench, "--overheat", "8"]));
    stdout(&anemo(folder, &["check", "bench/identify-film1.toml"]));
}
