//! A record that is identified from sums of its parts, from outside.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use super::process::{anemo, json, refused, stdout};

const ROWS: usize = 9000;

/// Rows of a body of two time constants in a room that drifts; `unit` of the times.
fn record(folder: &Path, name: &str, rows: std::ops::Range<usize>, time: &str, output: &str) {
    let mut seed = 5_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let (mut slow, mut fast, mut room_k, mut power_w) = (0.0, 0.0, 0.0, 0.1);
    let mut text = format!("{time},power_w,{output}\n");
    for row in 0..ROWS {
        if row % 12 == 0 {
            power_w = if random() > 0.0 { 0.5 } else { 0.1 };
        }
        room_k += 0.003 * random();
        let temperature_c = 20.0 + 50.0 * slow + 20.0 * fast + room_k + 0.01 * random();
        if rows.contains(&row) {
            let _ = writeln!(text, "{:.1},{power_w},{temperature_c:.5}", 0.1 * row as f64);
        }
        slow += (1.0 - (-0.1_f64 / 40.0).exp()) * (power_w - slow);
        fast += (1.0 - (-0.1_f64 / 3.0).exp()) * (power_w - fast);
    }
    std::fs::write(folder.join(name), text).unwrap();
}

/// Three parts, their plan and their sums; the borders are no round numbers.
fn summed(folder: &Path) {
    for (name, rows) in [("a.csv", 0..2771), ("b.csv", 2771..2790), ("c.csv", 2790..ROWS)] {
        record(folder, name, rows, "time_s", "temperature_c");
    }
    stdout(&anemo(folder, &["gram", "a.csv", "b.csv", "c.csv", "-o", "r.plan"]));
    for part in ["a", "b", "c"] {
        let (record, sums) = (format!("{part}.csv"), format!("{part}.gram"));
        let report = json(folder, &["gram", &record, "--plan", "r.plan", "-o", &sums, "--json"]);
        assert_eq!(report["record_rows"], ROWS);
    }
}

#[test]
fn sums_of_parts_make_the_model_of_the_whole_in_any_order_and_as_a_tree() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    summed(folder);
    record(folder, "whole.csv", 0..ROWS, "time_s", "temperature_c");
    let whole = json(folder, &["identify", "whole.csv", "--losses", "none", "--json"]);
    assert_eq!(whole["outputs"][0]["drift"]["kind"], "random-walk");
    let flat = json(folder, &["identify", "c.gram", "a.gram", "b.gram", "--json"]);
    stdout(&anemo(folder, &["gram", "c.gram", "b.gram", "-o", "bc.gram"]));
    let tree = json(folder, &["identify", "bc.gram", "a.gram", "--json"]);
    for parts in [flat, tree] {
        // To the last digit: no sum depends on where the record is cut.
        assert_eq!(parts["pairs"], whole["pairs"]);
        assert_eq!(parts["chosen"], whole["chosen"]);
        let rms = |model: &Value| model["outputs"][0]["residual_rms"].as_f64().unwrap();
        assert!((rms(&parts) / rms(&whole) - 1.0).abs() < 1e-6);
    }
}

/// Three recordings of one head, two of them of the same times; the second was cut, and the
/// third has a gap.
#[test]
fn sums_of_recordings_of_one_head_make_the_model_of_them_all() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder, "all.csv", 0..ROWS, "time_s", "temperature_c");
    let all = std::fs::read_to_string(folder.join("all.csv")).unwrap();
    let rows: Vec<&str> = all.lines().skip(1).map(|line| line.split_once(',').unwrap().1).collect();
    let write = |name: &str, first_row: usize, own: std::ops::Range<usize>, gap: std::ops::Range<usize>| {
        let mut text = "time_s,power_w,temperature_c\n".to_owned();
        for row in own.filter(|row| !gap.contains(row)) {
            let _ = writeln!(text, "{:.1},{}", 0.1 * (row - first_row) as f64, rows[row]);
        }
        std::fs::write(folder.join(name), text).unwrap();
    };
    write("a.csv", 0, 0..3000, 0..0);
    write("b.csv", 3100, 3100..6100, 0..0);
    write("b1.csv", 3100, 3100..4177, 0..0);
    write("b2.csv", 3100, 4177..6100, 0..0);
    write("c.csv", 6000, 6000..9000, 7003..7050);
    let whole = json(folder, &["identify", "a.csv", "b.csv", "c.csv", "--losses", "none", "--json"]);
    let cut: &[&str] = &["a.csv", "b1.csv", "b2.csv", "c.csv"];
    for parts in [&["a.csv", "b.csv", "c.csv"][..], cut] {
        stdout(&anemo(folder, &[&["gram"], parts, &["-o", "r.plan"]].concat()));
        for part in parts {
            // Parts are known by their rows, whatever they are called.
            std::fs::copy(folder.join(part), folder.join("some.csv")).unwrap();
            stdout(&anemo(folder, &["gram", "some.csv", "--plan", "r.plan", "-o", &part.replace("csv", "gram")]));
        }
        let sums: Vec<String> = parts.iter().rev().map(|part| part.replace("csv", "gram")).collect();
        let sums: Vec<&str> = sums.iter().map(String::as_str).collect();
        let flat = json(folder, &[&["identify"], &sums[..], &["--json"]].concat());
        stdout(&anemo(folder, &["gram", sums[0], sums[1], "-o", "joined.gram"]));
        let tree = json(folder, &[&["identify", "joined.gram"], &sums[2..], &["--json"]].concat());
        for model in [flat, tree] {
            assert_eq!(model["pairs"], whole["pairs"]);
            assert_eq!(model["chosen"], whole["chosen"]);
            assert_eq!(model["warnings"], whole["warnings"]);
        }
    }
}

#[test]
fn what_does_not_belong_together_is_refused_with_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    summed(folder);
    let identify = |files: &[&str]| refused(folder, &[&["identify"], files].concat(), 2);
    let gram =
        |arguments: &[&str], code: i32| refused(folder, &[&["gram"], arguments, &["-o", "out.gram"]].concat(), code);

    assert!(identify(&["a.gram", "b.gram"]).ends_with("only rows 1 to 2790 of 9000 are here: sum c.csv as well"));
    let gap = identify(&["a.gram", "c.gram"]);
    assert!(gap.contains("begins with row 2791, and a.gram ends with row 2771: sum b.csv as well"), "{gap}");
    stdout(&anemo(folder, &["gram", "a.gram", "b.gram", "-o", "ab.gram"]));
    let twice = identify(&["ab.gram", "b.gram", "c.gram"]);
    assert!(twice.contains("has row 2772 of the record, as ab.gram has: name each row once"), "{twice}");
    assert!(identify(&["r.plan.gram"]).contains("cannot be read"));
    assert!(identify(&["a.gram", "c.csv"]).contains("name sums or records, not both"));
    assert!(identify(&["a.gram", "--order", "5"]).contains("belong to the plan"));
    assert!(identify(&["a.gram", "--plot", "m.svg"]).contains("leave out --plot and --report"));

    // Of another record; of another column, unit or length; no sums at all; broken off.
    stdout(&anemo(folder, &["gram", "a.csv", "b.csv", "-o", "other.plan"]));
    stdout(&anemo(folder, &["gram", "b.csv", "--plan", "other.plan", "-o", "other.gram"]));
    let other = identify(&["a.gram", "other.gram", "c.gram"]);
    assert!(other.contains("of another record or plan") && other.contains("sum all parts with one plan"), "{other}");
    record(folder, "named.csv", 0..2771, "time_s", "t_c");
    assert!(gram(&["named.csv", "--plan", "r.plan"], 1).contains("temperature_c"));
    record(folder, "hours.csv", 0..2771, "time_h", "temperature_c");
    assert!(gram(&["hours.csv", "--plan", "r.plan"], 1).contains("has its times in `time_h`"));
    record(folder, "short.csv", 0..2700, "time_s", "temperature_c");
    assert!(gram(&["short.csv", "--plan", "r.plan"], 1).contains("as none of the 3 parts of the plan"));
    assert!(gram(&["a.csv", "--plan", "a.csv"], 2).contains("is no file of sums"));
    // The last part, of which no other knows anything, with one number that is another.
    let last = std::fs::read_to_string(folder.join("c.csv")).unwrap();
    let at = last.rfind(',').unwrap();
    std::fs::write(folder.join("c.csv"), format!("{},99.0\n", &last[..at])).unwrap();
    assert!(gram(&["c.csv", "--plan", "r.plan"], 1).contains("was changed since the plan was made"));
    let sums = std::fs::read(folder.join("b.gram")).unwrap();
    // One bit anywhere, in what record it is of as in the sums.
    for at in (0..sums.len()).step_by(151) {
        let mut flipped = sums.clone();
        flipped[at] ^= 1;
        std::fs::write(folder.join("b.gram"), flipped).unwrap();
        identify(&["a.gram", "b.gram", "c.gram"]);
    }
    for damaged in [&sums[..sums.len() - 9], &sums[..sums.len() - 1], &[&sums[..], &[0]].concat()] {
        std::fs::write(folder.join("b.gram"), damaged).unwrap();
        let sentence = identify(&["a.gram", "b.gram", "c.gram"]);
        assert!(sentence.contains("is broken off or damaged"), "{} bytes: {sentence}", damaged.len());
    }

    // What is in rows only; a value that is missing.
    let plan = |arguments: &[&str]| refused(folder, &[&["gram"], arguments, &["-o", "out.plan"]].concat(), 1);
    assert!(plan(&["a.csv", "--free-poles", "2"]).contains("identify the record as a whole"));
    let lacking = std::fs::read_to_string(folder.join("a.csv")).unwrap();
    let lacking: Vec<&str> = lacking.lines().collect();
    let row = &lacking[101][..lacking[101].rfind(',').unwrap() + 1];
    let lacking = [&lacking[..101], &[row], &lacking[102..]].concat().join("\n");
    std::fs::write(folder.join("lacking.csv"), lacking).unwrap();
    let sentence = plan(&["lacking.csv", "b.csv"]);
    assert!(sentence.contains("lacks an output in row 101: fill it, or identify the record as a whole"), "{sentence}");
    // Nothing was written of what was refused.
    assert!(!folder.join("out.gram").exists() && !folder.join("out.plan").exists());
}
