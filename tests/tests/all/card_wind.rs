//! Card 1 of the simulated REMS transducer, from records of still air to the wind in its plane: all
//! by the command.
//!
//! The shipped experiments at reduced length: half an hour an element instead of two hours, 80
//! winds in the tunnel instead of 120, 40 unseen ones instead of 200. Published for REMS on Mars
//! are 0.5 m/s or so and 30°.

use std::path::Path;
use std::process::Command;

use anemo_tests::{anemo, file};

const DICE: [&str; 4] = ["card1-die1", "card1-die2", "card1-die3", "card1-die4"];

/// The command in a folder: its standard output, or its one sentence.
fn command(folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(anemo()).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    if output.status.success() { Ok(text(output.stdout)) } else { Err(text(output.stderr)) }
}

/// Runs a shipped experiment, changed, and records it as NAME.parquet.
fn record(folder: &Path, name: &str, changes: &[(&str, &str)]) {
    let heads = file("heads").canonicalize().unwrap();
    let mut text = std::fs::read_to_string(file("experiments/wind/rems").join(format!("{name}.toml"))).unwrap();
    for (from, to) in [("../../../heads", heads.to_str().unwrap())].iter().chain(changes) {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    std::fs::write(folder.join(format!("{name}.toml")), text).unwrap();
    let (experiment, recording) = (format!("{name}.toml"), format!("{name}.parquet"));
    command(folder, &["run", &experiment, "--on", "sim", "-o", &recording]).unwrap();
}

#[test]
fn four_dice_of_a_card_tell_speed_and_direction_in_its_plane() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for die in 1..=4 {
        record(folder, &format!("identify-die{die}"), &[("duration_s = 7200.0", "duration_s = 1800.0")]);
    }
    record(folder, "tunnel", &[("duration_s = 7800.0", "duration_s = 5400.0"), ("winds = 120", "winds = 80")]);
    record(folder, "winds", &[("duration_s = 6600.0", "duration_s = 1800.0"), ("winds = 200", "winds = 40")]);

    let elements = DICE.join(",");
    let records = [1, 2, 3, 4].map(|die| format!("identify-die{die}.parquet"));
    let mut network = vec!["head", "identify", "--elements", &elements, "--cross-poles", "3", "-o", "network.json"];
    network.extend(records.iter().map(String::as_str));
    command(folder, &network).unwrap();

    let calibrate = |elements: &str, more: &[&str]| {
        let mut all = vec!["calibrate", "tunnel.parquet", "--network", "network.json", "--elements", elements];
        all.extend(more);
        command(folder, &all)
    };
    let sentence = calibrate("card1-die1,card1-die2,card1-die3,card2-die4", &[]).unwrap_err();
    assert!(sentence.contains("have the same outward `normal`"), "{sentence}");
    let sentence = calibrate("card1-die1,card1-die2", &[]).unwrap_err();
    assert!(sentence.contains("--elements names 2"), "{sentence}");
    println!("{}", calibrate(&elements, &["-o", "head.toml"]).unwrap());

    let wind = ["wind", "winds.parquet", "--head", "head.toml", "--from", "600", "--settle", "10", "--json"];
    let json: serde_json::Value = serde_json::from_str(&command(folder, &wind).unwrap()).unwrap();
    let number = |key: &str| json[key].as_f64().unwrap();
    let (speed, direction_deg) = (number("speed_rms_error"), number("direction_rms_error_deg"));
    println!(
        "unseen winds: speed {:.1} % rms, direction {direction_deg:.1}° rms, {} of {} without one",
        100.0 * speed,
        json["without_direction"],
        json["compared"]
    );
    assert_eq!(json["failed"], 0);
    assert!(number("without_direction") < 0.2 * number("compared"));
    // Half of what is published, of a sensor that knows its own simulation.
    assert!(direction_deg < 15.0 && speed < 0.25, "{direction_deg}° {speed}");

    // The instrument answers by the same head while it runs.
    let text = std::fs::read_to_string(folder.join("winds.toml")).unwrap();
    let heads = file("heads").canonicalize().unwrap().join("rems.toml");
    assert!(text.contains(heads.to_str().unwrap()));
    let text = text.replace(heads.to_str().unwrap(), "head.toml");
    std::fs::write(folder.join("answered.toml"), text).unwrap();
    let told = command(folder, &["run", "answered.toml", "--on", "sim", "-o", "answered.parquet"]).unwrap();
    println!("{told}");
    let answered = recording::Recording::read(&folder.join("answered.parquet")).unwrap();
    assert!(answered.columns.iter().any(|column| column.name.starts_with("conductance_w_k_card1_die1")));
}
