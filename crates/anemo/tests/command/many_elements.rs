//! Heads of more elements than boards have inputs for: simulated in process, and refused elsewhere.

use std::fmt::Write as _;
use std::path::Path;

use super::process::{anemo, refused, stdout};

/// A sphere of 24 sectors with two cores and a reference, every sector driven by its own bits.
fn sphere(folder: &Path) {
    stdout(&anemo(folder, &["head", "new", "ball", "--kind", "sphere", "--sectors", "24"]));
    let mut text = "title = \"bits\"\nhead = \"ball/head.toml\"\nsample_period_s = 0.01\nduration_s = 3.0\n\n[gas]\nspecies = \"co2\"\n\
                    pressure_pa = 1000.0\ntemperature_c = -53.15\n\n[drives]\ncore1 = { temperature_c = -40.0 }\n"
        .to_owned();
    for sector in 1..=24 {
        writeln!(text, "sector{sector} = {{ prbs = {{ order = 10, bit_time_s = 0.02, seed = {sector} }} }}").unwrap();
    }
    text += "\n[[wind]]\nstart_s = 0.0\nlabel = \"breeze\"\nspeed_m_s = 2.0\nazimuth_deg = 20.0\n";
    std::fs::write(folder.join("bits.toml"), text).unwrap();
}

#[test]
fn all_elements_of_a_large_head_are_driven_and_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    sphere(folder);
    let text = stdout(&anemo(folder, &["run", "bits.toml", "--on", "sim", "-o", "bits.csv"]));
    assert!(text.contains("300 ticks, 3 s; 0 lost"), "{text}");
    let csv = std::fs::read_to_string(folder.join("bits.csv")).unwrap();
    let mut rows = csv.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<&str> = rows.next().unwrap().split(',').collect();
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split(',').collect()).collect();
    assert_eq!(columns.iter().filter(|name| name.starts_with("temperature_c_")).count(), 27);
    let all = |name: &str| -> Vec<f64> {
        let at = columns.iter().position(|column| *column == name).unwrap();
        rows.iter().map(|row| row[at].parse().unwrap()).collect()
    };
    for sector in 1..=24 {
        let levels = all(&format!("heater_sector{sector}"));
        assert!(levels.contains(&0.0) && levels.contains(&1.0), "sector{sector}");
        let temperature_c = all(&format!("temperature_c_sector{sector}"));
        assert!(temperature_c.last() > temperature_c.first(), "sector{sector}");
    }
    assert!(all("heater_reference").iter().all(|level| *level == 0.0));
    stdout(&anemo(folder, &["plot", "bits.csv", "-o", "bits.svg"]));
}

#[test]
fn a_board_refuses_a_head_of_more_elements_than_it_has_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    sphere(folder);
    stdout(&anemo(folder, &["check", "bits.toml"]));
    for (on, most) in [("qemu", 16), ("serial", 6)] {
        let sentence = refused(folder, &["check", "bits.toml", "--on", on], 2);
        let expected = format!("`head` cannot be used: the head has 27 elements, the board can drive {most}");
        assert!(sentence.ends_with(&expected), "{sentence}");
    }
}

#[test]
fn there_are_64_elements_at_most() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    sphere(folder);
    let path = folder.join("ball/head.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let with = |more: usize| {
        let more = (0..more).map(|i| format!("[[elements]]\nname = \"spare{i}\"\nkind = \"reference\"\n\n"));
        std::fs::write(&path, text.replacen("[body]", &(more.collect::<String>() + "[body]"), 1)).unwrap();
    };
    with(38);
    let sentence = refused(folder, &["check", "bits.toml"], 2);
    assert!(
        sentence.contains("head.toml, line ") && sentence.contains("`elements` are 65: a head has 1 to 64"),
        "{sentence}"
    );
    with(37);
    // Its body knows nothing of the spare ones.
    let sentence = refused(folder, &["check", "bits.toml"], 2);
    assert!(!sentence.contains("`elements` are") && sentence.contains("spare0"), "{sentence}");
}
