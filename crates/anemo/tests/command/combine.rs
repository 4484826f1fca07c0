//! `anemo combine`: instruments that each see a part of the wind, by files as of `anemo wind`.

use std::fmt::Write as _;
use std::path::Path;

use recording::Recording;
use serde_json::Value;

use super::process::{self, json, stdout, words};

/// Rows of a wind, a second apart.
const ROWS: usize = 6;
/// Columns of `anemo wind`, what is read.
const COLUMNS: &str = "time_s,event,true_wind_x_m_s,true_wind_y_m_s,true_wind_z_m_s,wind_x_m_s,wind_y_m_s,wind_z_m_s,wind_speed_m_s,\
                       wind_speed_u_m_s,wind_direction_u_deg";

fn done(folder: &Path, line: &str) -> String {
    stdout(&process::anemo(folder, &words(line)))
}

fn printed(folder: &Path, line: &str) -> Value {
    json(folder, &words(line))
}

fn refused(folder: &Path, line: &str, code: i32) -> String {
    process::refused(folder, &words(line), code)
}

/// The n-th wind of the plane of x and y, after still gas; `seed` turns all of them.
fn wind(n: usize, seed: f64) -> [f64; 2] {
    let speed_m_s = if n == 0 { 0.0 } else { 0.5 * libm::pow(16.0, (0.618 * n as f64 + seed).fract()) };
    let (sine, cosine) = libm::sincos(2.4 * n as f64 + seed);
    [speed_m_s * cosine, speed_m_s * sine]
}

/// Needles that see a wind mirrored into a quadrant, 2 % fast, a film that only knows the speed,
/// and junctions round a core.
fn write(folder: &Path, name: &str, winds: usize, seed: f64) {
    let [mut needles, mut film] = [0, 1].map(|_| format!("{COLUMNS}\n"));
    let mut junctions = "time_s,event,temperature_c_a,temperature_c_b,temperature_c_c\n".to_owned();
    for row in 0..winds * ROWS {
        let [x, y] = wind(row / ROWS, seed);
        let (speed, noise) = (libm::hypot(x, y), 1e-3 * ((7919 * row % 1000) as f64 / 500.0 - 1.0));
        let start = format!("{row},wind {},{x},{y},0", row / ROWS);
        let (seen_x, seen_y) = (x.abs() * (1.02 + noise), y.abs() * (1.02 - noise));
        writeln!(needles, "{start},{seen_x},{seen_y},0,{},{},0.2", libm::hypot(seen_x, seen_y), 2e-3 * speed).unwrap();
        // Faster where it comes from x.
        let seen = speed * (1.0 - 0.05 * x / speed.max(1e-9)) * (1.0 + noise);
        writeln!(film, "{start},0,0,0,{seen},{},180", 5e-3 * speed).unwrap();
        let warm = |turn: f64| {
            let angle = libm::atan2(y, x) - turn.to_radians();
            20.0 + if speed > 0.0 { 8.0 * libm::cos(angle) } else { 0.0 } + 0.05 * (noise / 1e-3)
        };
        writeln!(junctions, "{row},wind {},{},{},{}", row / ROWS, warm(0.0), warm(120.0), warm(240.0)).unwrap();
    }
    for (instrument, text) in [("needles", needles), ("film", film), ("junctions", junctions)] {
        std::fs::write(folder.join(format!("{instrument}-{name}.csv")), text).unwrap();
    }
}

#[test]
fn needles_a_film_and_a_vane_know_together_what_none_knows_alone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "known", 101, 0.0);
    write(folder, "new", 41, 0.3);
    let vane = |name: &str| format!("--vane junctions-{name}.csv=a,b,c --settle 2");
    let made =
        printed(folder, &format!("combine needles-known.csv film-known.csv {} -o all.json --json", vane("known")));
    assert_eq!(made["winds"], 100);
    let instruments: Vec<_> =
        made["instruments"].as_array().unwrap().iter().map(|of| (&of["name"], &of["components"])).collect();
    assert_eq!(
        serde_json::json!(instruments).to_string(),
        r#"[["needles-known",2],["film-known",1],["junctions-known",2]]"#
    );
    assert_eq!(made["cross_validated"]["failed"], 0);

    let by = format!("combine needles-new.csv film-new.csv {} --by all.json", vane("new"));
    let report = printed(folder, &format!("{by} -o wind.parquet --plot wind.svg --json"));
    let errors = &report["comparison"];
    assert_eq!((&errors["compared"], &errors["failed"], &report["ambiguous"]), (&160.into(), &0.into(), &0.into()));
    let error = |name: &str| errors[name].as_f64().unwrap();
    assert!(error("direction_rms_error_deg") < 1.0 && error("direction_worst_error_deg") < 4.0, "{errors}");
    assert!(error("speed_rms_error") < 0.01 && error("speed_worst_error") < 0.04, "{errors}");
    let turned =
        refused(folder, "combine needles-new.csv film-new.csv --vane junctions-new.csv=b,c,a --by all.json", 2);
    let order = "its order is needles-known; film-known; a, b, c";
    assert_eq!(turned, format!("anemo: junctions-new is of b, c, a, where the combination has a, b, c; {order}"));
    let picture = std::fs::read_to_string(folder.join("wind.svg")).unwrap();
    assert!(picture.contains("wind by needles-new, film-new, junctions-new") && !picture.contains("0 elements"));
    let wind = Recording::read(&folder.join("wind.parquet")).unwrap();
    assert_eq!(wind.len(), 41 * ROWS);
    // Its file is an instrument again.
    let again = printed(folder, "combine wind.parquet film-new.csv --settle 2 --json");
    assert_eq!(again["instruments"][0]["components"], 2);

    // Without the vane four winds look alike.
    let text = done(folder, "combine needles-known.csv --settle 2");
    assert!(text.contains("1 instrument in 100 known winds across (0, 0, "), "{text}");
    printed(folder, "combine needles-known.csv film-known.csv --settle 2 -o two.json --json");
    let two = printed(folder, "combine needles-new.csv film-new.csv --settle 2 --by two.json --json");
    assert!(two["ambiguous"].as_u64().unwrap() > 80, "{two}");
}

#[test]
fn what_cannot_be_combined_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "known", 31, 0.0);
    write(folder, "few", 3, 0.0);
    let refusals = [
        (
            "combine junctions-known.csv",
            2,
            "anemo: junctions-known.csv: has no wind estimates, which `anemo wind … -o` writes; a table of one's own has time_s, event, \
             and wind_x_m_s, wind_y_m_s, wind_z_m_s or wind_speed_m_s, and here wind_x_m_s, wind_y_m_s, wind_z_m_s is missing",
        ),
        ("combine film-known.csv", 1, "anemo: all instruments together have 1 component, and these winds have 2"),
        (
            "combine needles-few.csv",
            1,
            "anemo: 2 of 2 known winds have estimates of all instruments (needles-few: 2), in 2 directions; 5 directions are the least, \
             and 100 winds from everywhere or all around a plane do well",
        ),
        (
            "combine needles-known.csv --vane junctions-known.csv=a,b,d",
            2,
            "anemo: junctions-known.csv: has no element `d`; known are `a`, `b`, `c`",
        ),
        ("combine needles-known.csv --plot wind.svg", 2, "anemo: --plot is of winds, with --by"),
        (
            "combine needles-known.csv film-known.csv --by one.json",
            2,
            "anemo: one.json: is of 1 file and 0 vanes, and 2 files and 0 vanes are given",
        ),
    ];
    done(folder, "combine needles-known.csv -o one.json");
    for (line, code, sentence) in refusals {
        assert_eq!(refused(folder, line, code), sentence, "{line}");
    }
    let two = refused(folder, "combine needles-known.csv --vane junctions-known.csv=a,b", 2);
    assert!(two.contains("names 2 of its junctions, and it takes three to know a direction"), "{two}");
}

#[test]
fn instruments_that_do_not_say_the_same_are_flagged_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "known", 101, 0.0);
    write(folder, "new", 41, 0.3);
    write(folder, "other", 41, 0.7);
    printed(
        folder,
        "combine needles-known.csv film-known.csv --vane junctions-known.csv=a,b,c --settle 2 -o all.json --json",
    );
    let by = |needles: &str, junctions: &str| {
        format!("combine {needles} film-new.csv --vane {junctions}=a,b,c --settle 2 --by all.json --json")
    };
    let of = |report: &Value, name: &str| report[name].as_u64().unwrap();
    let usual = printed(folder, &by("needles-new.csv", "junctions-new.csv"));
    // One in a hundred is beyond the 99th percentile by chance.
    assert!(of(&usual, "inconsistent") <= 8, "{usual}");
    assert!(usual["comparison"]["direction_within_2u"].as_f64().unwrap() > 0.9, "{usual}");
    let against = printed(folder, &by("needles-new.csv", "junctions-other.csv"));
    assert!(of(&against, "inconsistent") > of(&against, "rows") / 2, "{against}");

    // Another clock, by the labels; another kind of instrument; a file that was edited.
    let text = std::fs::read_to_string(folder.join("needles-new.csv")).unwrap();
    let shifted: String = text
        .lines()
        .map(|line| match line.split_once(',').and_then(|(time, rest)| Some((time.parse::<f64>().ok()?, rest))) {
            Some((time_s, rest)) => format!("{},{rest}\n", time_s + 3.0),
            None => format!("{line}\n"),
        })
        .collect();
    std::fs::write(folder.join("shifted.csv"), shifted).unwrap();
    let line = "combine film-new.csv shifted.csv --by all.json --vane junctions-new.csv=a,b,c";
    let sentence = refused(folder, line, 2);
    assert!(
        sentence.contains("has label `wind ") && sentence.ends_with("are they of one run, with one clock?"),
        "{sentence}"
    );
    let kinds = refused(folder, "combine film-new.csv film-new.csv --by all.json --vane junctions-new.csv=a,b,c", 2);
    assert_eq!(kinds, "anemo: film-new has estimates of speed only, where the combination has vector");
    let mut edited: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("all.json")).unwrap()).unwrap();
    edited["instruments"][0]["coefficients"].as_array_mut().unwrap().pop();
    std::fs::write(folder.join("edited.json"), edited.to_string()).unwrap();
    let line = "combine needles-new.csv film-new.csv --vane junctions-new.csv=a,b,c --by edited.json";
    let sentence = refused(folder, line, 2);
    assert!(sentence.ends_with("coefficients for each of one to three axes of `needles-known`"), "{sentence}");
}

/// A table of one's own has speeds or vectors, and need not state uncertainties.
#[test]
fn a_table_of_ones_own_is_an_instrument() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let table = |seed: f64| {
        let row = |row: usize| {
            let ([x, y], n) = (wind(row / ROWS, seed), row / ROWS);
            format!("{row},wind {n},{x},{y},0,{},{},0\n", 0.98 * x, 1.01 * y)
        };
        let head = "time_s,event,true_wind_x_m_s,true_wind_y_m_s,true_wind_z_m_s,wind_x_m_s,wind_y_m_s,wind_z_m_s\n";
        head.to_owned() + &(0..61 * ROWS).map(row).collect::<String>()
    };
    std::fs::write(folder.join("known.csv"), table(0.0)).unwrap();
    std::fs::write(folder.join("new.csv"), table(0.3)).unwrap();
    printed(folder, "combine known.csv -o own.json --json");
    let report = printed(folder, "combine new.csv --by own.json --json");
    assert!(report["comparison"]["speed_rms_error"].as_f64().unwrap() < 1e-3, "{report}");
}
