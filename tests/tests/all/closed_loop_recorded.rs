//! A model from an hour of pseudo-random heat in all sectors of the simulated sphere predicts what
//! its closed loops take.

use anemo_tests::{Desk, file};

const HELD: [&str; 4] = [
    "sector1 = { temperature_c = -30.0 }",
    "sector2 = { temperature_c = -30.0 }",
    "sector3 = { temperature_c = -30.0 }",
    "sector4 = { temperature_c = -30.0 }",
];

/// The drives of the experiment with the pseudo-random bits, replaced by set-points, at 100 Hz for
/// 400 s.
fn held() -> Desk {
    let text = std::fs::read_to_string(file("experiments/prbs.toml")).unwrap();
    let drives: Vec<&str> = text.lines().filter(|line| line.starts_with("sector")).collect();
    assert_eq!(drives.len(), 4);
    let mut replacements =
        vec![("duration_s = 3600.0", "duration_s = 400.0"), ("sample_period_s = 0.05", "sample_period_s = 0.01")];
    replacements.extend(drives.into_iter().zip(HELD));
    Desk::new("prbs.toml", &replacements)
}

#[test]
fn loops_of_the_sphere_take_what_an_open_loop_model_says_to_two_percent() {
    let desk = held();
    let done = |arguments: &[&str]| {
        let output = desk.anemo(arguments, &[]);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    done(&["run", &file("experiments/prbs.toml").display().to_string(), "--on", "sim", "-o", "prbs.parquet"]);
    done(&["identify", "prbs.parquet", "--free-poles", "4", "-o", "model.json"]);
    done(&["run", "e.toml", "--on", "sim", "-o", "held.parquet"]);
    let json = done(&["predict", "model.json", "e.toml", "--against", "held.parquet", "--json"]);
    let predicted: serde_json::Value = serde_json::from_str(&json).unwrap();
    let elements = predicted["elements"].as_array().unwrap();
    assert_eq!(elements.len(), 4);
    for element in elements {
        let of = |key: &str| element[key].as_f64().unwrap();
        let (rms, bias) = (of("rms_w") / of("mean_w"), of("bias_w") / of("mean_w"));
        println!("{}: {rms:.4} rms, {bias:.4} bias, of the mean", element["name"]);
        assert!(of("n") > 200.0 && rms < 0.02, "{element}");
    }
    // A recording of another sample period is another experiment's.
    let (code, sentence) = desk.refused(&["predict", "model.json", "e.toml", "--against", "prbs.parquet"], &[]);
    assert_eq!(code, 2, "{sentence}");
    assert!(sentence.contains("is sampled every 0.05 s and the experiment every 0.01 s"), "{sentence}");
}
