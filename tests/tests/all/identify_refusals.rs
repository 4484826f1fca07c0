//! Records that cannot carry a model: one sentence that names row or column and the remedy, or a
//! model that says what it is not.

use std::fmt::Write as _;

use anemo_tests::Desk;
use anemo_tests::records::foster::Foster;
use serde_json::Value;

/// A desk with `r.csv` of these columns.
struct Table {
    desk: Desk,
}

/// A sound record of `rows` rows: time, power, temperature.
fn sound(rows: usize) -> Vec<[f64; 3]> {
    let record = Foster { rows, ..Foster::default() }.simulate();
    (0..rows).map(|n| [n as f64 * record.sample_period_s, record.input_w[n], record.output_c[n]]).collect()
}

fn text(header: &str, rows: &[Vec<String>]) -> String {
    rows.iter().fold(format!("{header}\n"), |mut text, row| {
        let _ = writeln!(text, "{}", row.join(","));
        text
    })
}

fn csv(rows: &[[f64; 3]]) -> String {
    text("time_s,power,temperature", &rows.iter().map(|row| row.map(|v| v.to_string()).to_vec()).collect::<Vec<_>>())
}

impl Table {
    fn new(text: &str) -> Self {
        let desk = Desk::new("prbs.toml", &[]);
        std::fs::write(desk.path().join("r.csv"), text).unwrap();
        Self { desk }
    }

    /// Identification is refused with all of these words.
    fn is_refused(&self, options: &[&str], words: &[&str]) {
        let arguments: Vec<&str> = ["identify", "r.csv", "-o", "m.json"].iter().chain(options).copied().collect();
        let (code, sentence) = self.desk.refused(&arguments, &[]);
        println!("{code}: {sentence}");
        assert!(code == 1 || code == 2, "{code}: {sentence}");
        assert!(!sentence.contains("panicked") && !sentence.contains("NaN"), "{sentence}");
        for word in words {
            assert!(sentence.contains(word), "`{word}` is not in: {sentence}");
        }
    }

    /// A model comes of it, and these words are said.
    fn is_read(&self, words: &[&str]) {
        let output = self.desk.anemo(&["identify", "r.csv"], &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8(output.stdout).unwrap();
        for word in words {
            assert!(said.contains(word), "`{word}` is not in: {said}");
        }
    }

    /// A model comes of it, but it is marked, and a warning holds these words.
    fn is_doubted(&self, options: &[&str], words: &[&str]) {
        let arguments: Vec<&str> = ["identify", "r.csv", "--json"].iter().chain(options).copied().collect();
        let output = self.desk.anemo(&arguments, &[]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{stderr}");
        let model: Value = serde_json::from_slice(&output.stdout).unwrap();
        println!("{}", model["warnings"]);
        assert_eq!(model["supported"], false, "{}", model["warnings"]);
        let warnings = model["warnings"].to_string();
        for word in words {
            assert!(warnings.contains(word), "`{word}` is not in: {warnings}");
        }
    }
}

#[test]
fn a_record_of_a_few_rows_is_refused() {
    Table::new(&csv(&sound(1))).is_refused(&[], &["r.csv", "row"]);
    Table::new(&csv(&sound(15))).is_refused(&[], &["r.csv", "15 rows", "at least 20"]);
    Table::new("time_s,power,temperature\n").is_refused(&[], &["r.csv"]);
    Table::new("").is_refused(&[], &["r.csv"]);
}

#[test]
fn more_unknowns_than_rows_are_refused() {
    Table::new(&csv(&sound(60))).is_refused(&["--order", "40"], &["60 rows", "81 unknowns", "--order"]);
}

#[test]
fn an_input_that_never_changes_is_refused() {
    let mut rows = sound(400);
    rows.iter_mut().for_each(|row| row[1] = 0.05);
    Table::new(&csv(&rows)).is_refused(&["--input", "power"], &["`power`", "400 rows", "changing input"]);
    // And if it is not named
    Table::new(&csv(&rows)).is_refused(&[], &["input"]);
}

#[test]
fn an_output_that_does_not_answer_is_refused() {
    let mut rows = sound(400);
    rows.iter_mut().for_each(|row| row[2] = 21.5);
    let (code, sentence) = Table::new(&csv(&rows)).desk.refused(&["identify", "r.csv"], &[]);
    assert_eq!(code, 1);
    assert!(
        sentence.contains("`temperature` is 21.5 in all rows") && sentence.contains("sensor connected"),
        "{sentence}"
    );
}

#[test]
fn an_output_of_nothing_but_noise_is_refused() {
    let (mut rows, other) = (sound(1000), Foster { rows: 1000, seed: 99, ..Foster::default() });
    let noise =
        anemo_tests::records::Noise::white(1.0).read(&vec![20.0; other.rows], &mut anemo_tests::records::random(4, 0));
    rows.iter_mut().zip(noise).for_each(|(row, noise)| row[2] = noise);
    let (code, sentence) = Table::new(&csv(&rows)).desk.refused(&["identify", "r.csv"], &[]);
    assert_eq!(code, 1);
    assert!(
        sentence.contains("`temperature`: the inputs explain") && sentence.contains("no more than chance"),
        "{sentence}"
    );
}

#[test]
fn a_record_far_too_short_for_its_slowest_time_constant_is_marked() {
    use anemo_tests::records::{Excitation, Noise, foster::Poles};
    let slow = Foster {
        poles: Poles::Given { rates_rad_s: vec![1e-4, 1.0], resistances_k_per_w: vec![400.0, 5.0] },
        rows: 600,
        excitation: Excitation::Steps { least_rows: 200, most_rows: 300 },
        noise: Noise::white(0.02),
        ..Foster::default()
    };
    let record = slow.simulate();
    let rows: Vec<[f64; 3]> = (0..600).map(|n| [n as f64 * 0.1, record.input_w[n], record.output_c[n]]).collect();
    Table::new(&csv(&rows)).is_doubted(&[], &["too short"]);
}

#[test]
fn an_input_that_is_on_in_a_row_or_two_is_marked() {
    for (seed, noise_k) in [(1, 0.0001), (2, 0.05)] {
        let noise = anemo_tests::records::Noise::white(noise_k);
        let measured_c = noise.read(&vec![20.0; 1000], &mut anemo_tests::records::random(seed, 0));
        let (mut rise_k, gain) = (0.0, 1.0 - libm::exp(-0.1));
        let row = |(n, measured_c): (usize, f64)| {
            let power_w = if (300..302).contains(&n) { 0.05 } else { 0.0 };
            let row = [n as f64 * 0.1, power_w, measured_c + rise_k];
            // One pole of 1 rad/s and 100 K/W.
            rise_k += gain * (100.0 * power_w - rise_k);
            row
        };
        let rows: Vec<[f64; 3]> = measured_c.into_iter().enumerate().map(row).collect();
        Table::new(&csv(&rows)).is_doubted(&[], &["`power` leaves its first value for no more than 2.0 rows"]);
    }
}

#[test]
fn a_model_of_nothing_is_refused() {
    // The output falls as power rises, which resistances that may not be negative leave alone.
    let mut rows = sound(1000);
    rows.iter_mut().for_each(|row| row[2] = 40.0 - row[2]);
    Table::new(&csv(&rows)).is_refused(&["--non-negative", "all"], &["no input explains any of it"]);
}

#[test]
fn a_mesh_far_beyond_what_samples_show_is_marked_and_farther_refused() {
    let table = Table::new(&csv(&sound(400)));
    // π/Ts is 31 rad/s.
    table.is_doubted(&["--mesh", "0.1:1000"], &["samples every 0.1 s show nothing beyond 3.1e1"]);
    table.is_refused(&["--mesh", "0.1:100000"], &["reaches far beyond"]);
    table.is_refused(&["--mesh", "0.1:100000", "--free-poles", "2"], &["reaches far beyond"]);
}

#[test]
fn whose_heat_is_whose_is_told() {
    let rows = |columns: usize| -> Vec<Vec<String>> {
        let (first, second) = (sound(600), Foster { rows: 600, seed: 77, ..Foster::default() }.simulate());
        let of = |n: usize| [first[n][0], first[n][1], second.input_w[n], first[n][2], second.output_c[n]];
        (0..600).map(|n| of(n)[..columns].iter().map(f64::to_string).collect()).collect()
    };
    let table = Table::new(&text("time_s,p,q,x,y", &rows(5)));
    let output = table.desk.anemo(&["identify", "r.csv", "--input", "p,q", "--output", "y,x", "--tie"], &[]);
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(summary.contains("own heat, by the order of the columns: `p` → `y`, `q` → `x`; every other"), "{summary}");
}

#[test]
fn inputs_that_move_together_are_marked() {
    let rows: Vec<Vec<String>> =
        sound(1000).iter().map(|[t, u, y]| [*t, *u, 2.0 * u + 0.01, *y].map(|v| v.to_string()).to_vec()).collect();
    Table::new(&text("time_s,first,second,temperature", &rows))
        .is_doubted(&[], &["`first` and `second`", "cannot be distinguished"]);
}

#[test]
fn an_event_class_without_excitation_is_refused() {
    let rows: Vec<Vec<String>> = sound(1000)
        .iter()
        .enumerate()
        .map(|(n, [t, u, y])| {
            let calm = n % 100 < 50;
            vec![
                t.to_string(),
                if calm { 0.03 } else { *u }.to_string(),
                if calm { "calm" } else { "windy" }.to_owned(),
                y.to_string(),
            ]
        })
        .collect();
    let table = Table::new(&text("time_s,power,wind,temperature", &rows));
    table.is_refused(&["--event", "wind", "--input", "power"], &["class `calm`", "`wind`", "500 rows", "excite"]);
}

#[test]
fn an_infinite_value_is_refused_with_its_row_and_a_missing_one_is_said() {
    let rows = |value: &str| {
        let rows: Vec<Vec<String>> = sound(200)
            .iter()
            .enumerate()
            .map(|(n, [t, u, y])| {
                vec![t.to_string(), u.to_string(), if n == 57 { value.to_owned() } else { y.to_string() }]
            })
            .collect();
        text("time_s,power,temperature", &rows)
    };
    for value in ["inf", "1e999"] {
        Table::new(&rows(value)).is_refused(&[], &["row 58", "`temperature`"]);
    }
    for value in ["NaN", "nan", ""] {
        Table::new(&rows(value)).is_read(&["`temperature` is missing in 1 row,"]);
    }
    Table::new(&rows("twenty")).is_refused(&[], &["`temperature`", "twenty"]);
}

#[test]
fn time_that_runs_backwards_is_refused_with_its_row_and_gaps_are_said() {
    let with = |change: fn(&mut Vec<[f64; 3]>)| {
        let mut rows = sound(200);
        change(&mut rows);
        Table::new(&csv(&rows))
    };
    with(|rows| rows[100..].iter_mut().for_each(|row| row[0] += 3.0)).is_read(&["1 gap in time, of 30 rows of 0.1 s"]);
    with(|rows| rows.swap(80, 81)).is_refused(&[], &["row 8", "time"]);
    with(|rows| rows[100][0] = rows[99][0]).is_refused(&[], &["row 101"]);
    with(|rows| rows[120..].iter_mut().for_each(|row| row[0] += 3.0)).is_read(&["1 gap in time, of 30 rows of 0.1 s"]);
    with(|rows| rows.reverse()).is_refused(&[], &["row 2"]);
}

#[test]
fn columns_that_are_missing_or_double_are_named() {
    let good = csv(&sound(200));
    Table::new(&good).is_refused(&["--input", "powr"], &["powr", "power"]);
    Table::new(&good).is_refused(&["--output", "temprature"], &["temprature", "temperature"]);
    Table::new(&good).is_refused(&["--event", "wind"], &["wind"]);
    Table::new(&good.replacen("power", "temperature", 1)).is_refused(&[], &["temperature"]);
    let (code, sentence) = Table::new(&good).desk.refused(&["identify", "none.csv"], &[]);
    assert!(code == 2 && sentence.contains("none.csv"), "{sentence}");
}

#[test]
fn options_that_cannot_be_are_refused() {
    let table = Table::new(&csv(&sound(200)));
    table.is_refused(&["--order", "0"], &["--order"]);
    for option in ["--order", "--free-poles", "--dead-time"] {
        table.is_refused(&[option, "-1"], &[option, "`-1` is no whole number"]);
    }
    table.is_refused(&["--mesh", "10:1"], &["10:1"]);
    table.is_refused(&["--mesh", "nan:1"], &["nan:1"]);
    table.is_refused(&["--ridge", "-1"], &["--ridge"]);
    table.is_refused(&["--ridge", "nan"], &["ridge"]);
    table.is_refused(&["--dead-time", "500"], &["dead"]);
    table.is_refused(&["--non-negative", "power:nothing"], &["power:nothing"]);
    table.is_refused(&["--gas-temperature", "18"], &["gas-temperature"]);
}

#[test]
fn a_model_that_does_not_fit_is_refused() {
    let table = Table::new(&csv(&sound(400)));
    let path = table.desk.path().join("m.json");
    assert!(table.desk.anemo(&["identify", "r.csv", "-o", "m.json"], &[]).status.success());
    let good = std::fs::read_to_string(&path).unwrap();
    for (from, to, words) in [
        ("\"version\": 1", "\"version\": 7", ["version 7", "identify it again"]),
        ("anemo-model", "other-model", ["is no model", "format"]),
        ("\"sample_period_s\": 0.1", "\"sample_period_s\": -0.1", ["sample_period_s", "greater than zero"]),
    ] {
        assert!(good.contains(from), "{from}");
        std::fs::write(&path, good.replacen(from, to, 1)).unwrap();
        let (code, sentence) = table.desk.refused(&["validate", "m.json", "r.csv"], &[]);
        assert_eq!(code, 2);
        words.iter().for_each(|word| assert!(sentence.contains(word), "{sentence}"));
    }
    std::fs::write(&path, &good[..good.len() / 2]).unwrap();
    assert_eq!(table.desk.refused(&["validate", "m.json", "r.csv"], &[]).0, 2);
    std::fs::write(&path, &good).unwrap();
    // The record that it was made from does not go on where it ended.
    let (code, sentence) = table.desk.refused(&["validate", "m.json", "r.csv", "--start", "continue"], &[]);
    assert!(code == 1 && sentence.contains("goes on at 40 s"), "{sentence}");
}

#[test]
fn a_validation_that_says_nothing_says_so() {
    let table = Table::new(&csv(&sound(400)));
    let path = table.desk.path().join("m.json");
    assert!(table.desk.anemo(&["identify", "r.csv", "-o", "m.json"], &[]).status.success());
    let write = |rows: &[[f64; 3]]| std::fs::write(table.desk.path().join("v.csv"), csv(rows)).unwrap();
    let told = |options: &[&str]| {
        let arguments = [&["validate", "m.json", "v.csv", "--json"], options].concat();
        let output = table.desk.anemo(&arguments, &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let mut constant = sound(100);
    constant.iter_mut().for_each(|row| row[2] = 21.5);
    write(&constant);
    let json = told(&[]);
    assert!(json["fit_percent"].is_null() && json["rmse"].is_f64(), "{json}");
    assert!(json["warnings"][0].as_str().unwrap().contains("is 21.5 in all rows"), "{json}");

    write(&sound(5));
    let (code, sentence) = table.desk.refused(&["validate", "m.json", "v.csv"], &[]);
    assert!(code == 1 && sentence.contains("has 5 rows") && sentence.contains("--start rest"), "{sentence}");
    let json = told(&["--start", "rest"]);
    assert!(json["warnings"].to_string().contains("5 rows say next to nothing"), "{json}");

    let mut huge = sound(100);
    huge.iter_mut().for_each(|row| row[1] *= 1e200);
    write(&huge);
    let (code, sentence) = table.desk.refused(&["validate", "m.json", "v.csv"], &[]);
    assert!(code == 1 && sentence.contains("too large to compute with"), "{sentence}");

    let mut model: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert!(model.as_object_mut().unwrap().remove("end").is_some());
    std::fs::write(&path, model.to_string()).unwrap();
    let (code, sentence) = table.desk.refused(&["validate", "m.json", "r.csv", "--start", "continue"], &[]);
    assert!(code == 1 && sentence.contains("does not hold where its record ended"), "{sentence}");
}
