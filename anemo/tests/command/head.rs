//! `anemo head new` and `head check`: from nothing to a head that runs.

use std::path::Path;
use std::process::{Command, Output};

fn anemo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_anemo")).args(arguments).current_dir(folder).output().unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

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
    let heads = Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads");
    for (name, overheat, expected) in [
        ("viking", "100", "facing_azimuth_deg = 45"),
        ("meda", "20", "plane = \"upright\""),
        ("metwind", "20", "plane = \"level\""),
    ] {
        let file = heads.join(format!("{name}.toml")).display().to_string();
        stdout(&anemo(folder, &["head", "new", name, "--from", &file, "--overheat", overheat]));
        let tunnel = std::fs::read_to_string(folder.join(name).join("tunnel.toml")).unwrap();
        assert!(tunnel.contains(expected), "{tunnel}");
        let known = |element: &str| folder.join(name).join(format!("identify-{element}.toml")).exists();
        assert!(!known("junction1") && !known("reference") && !known("cold1") && !known("boom"), "{name}");
        stdout(&anemo(folder, &["check", &format!("{name}/tunnel.toml")]));
    }
    // What only senses is not driven.
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
            "--overheat is 300: it makes `film` 320 °C warm, and by its limits it trips above",
        ),
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
