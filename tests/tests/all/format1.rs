//! Files of before 0.2, as that command wrote them: columns with a colon, the simulation's wind as
//! `wind_x_m_s`.

use anemo_tests::{Desk, calibrated, file};

fn told(desk: &Desk, arguments: &[&str]) -> serde_json::Value {
    let output = desk.anemo(arguments, &[]);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A heated body of one rate, 1 rad/s, in a record of format 1.
fn record() -> String {
    let mut text =
        "time_s,temperature_c_die_1,power_w_die_1,heater_die_1,event,state,wind_x_m_s,wind_y_m_s,wind_z_m_s\n"
            .to_owned();
    let (mut x, mut register) = (0.0_f64, 1_u32);
    for n in 0..2000 {
        register = register >> 1 ^ if register & 1 == 1 { 0xb400 } else { 0 };
        let bit = f64::from(register & 1);
        let celsius = 20.0 + 100.0 * x;
        text += &format!("{},{celsius},{},{bit},,running,3,0,0\n", f64::from(n) * 0.1, 0.01 * bit);
        x += (1.0 - (-0.1_f64).exp()) * (0.01 * bit - x);
    }
    text
}

#[test]
fn a_record_is_identified_and_answered_in_the_names_of_today() {
    let desk = Desk::with("");
    std::fs::write(desk.path().join("r.csv"), record()).unwrap();
    let arguments = ["--order", "3", "--json"];
    let mut all = Vec::new();
    for named in [&[][..], &["--input", "power_w_die_1", "--output", "temperature_c_die_1"], &["--input", "die-1"]] {
        all.push(
            told(&desk, &[&["identify", "r.csv", "-o", "m.json"][..], named, &arguments].concat())["pairs"].clone(),
        );
    }
    assert_eq!(all[0][0]["input"], "power_w_die_1");
    assert_eq!(all[0][0]["output"], "temperature_c_die_1");
    assert!(all.iter().all(|pairs| *pairs == all[0]));
    let fit = told(&desk, &["validate", "m.json", "r.csv", "--json"])["fit_percent"].as_f64().unwrap();
    assert!(fit > 99.0, "{fit}");
}

#[test]
fn a_model_is_read_and_its_pair_found_by_either_name() {
    let desk = Desk::with("");
    let model = file("tests/fixtures/format1/model.json").canonicalize().unwrap();
    let model = model.to_str().unwrap();
    let mut texts = Vec::new();
    for pair in ["power_w_sector1:temperature_c_sector1", "power_w_sector1:temperature_c_sector1", "sector1:sector1"] {
        let output = desk.anemo(&["export", model, "--as", "spice", "--pair", pair], &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        texts.push(String::from_utf8(output.stdout).unwrap());
    }
    // What was said in words when it was identified stays as it was said.
    assert!(texts[0].starts_with("* power_w_sector1 -> temperature_c_sector1, class light air"), "{}", texts[0]);
    assert!(texts.iter().all(|text| *text == texts[0]));
}

#[test]
fn recordings_of_a_calibrated_head_are_worked_off_again_against_the_truth() {
    let desk = Desk::with("");
    let head = calibrated::head();
    for name in ["recording.csv", "recording.parquet"] {
        let recording = file("tests/fixtures/format1").canonicalize().unwrap().join(name);
        let arguments =
            ["wind", recording.to_str().unwrap(), "--head", head.to_str().unwrap(), "-o", "w.csv", "--json"];
        let of = told(&desk, &arguments);
        assert!(of.get("speed_rms_error").is_some(), "{of}");
        let text = std::fs::read_to_string(desk.path().join("w.csv")).unwrap();
        let header = text.lines().find(|line| line.starts_with("time_s,")).unwrap();
        assert!(text.starts_with("# format: 2\n") && !header.contains(':'), "{header}");
        assert!(header.contains(",true_wind_x_m_s,") && header.contains(",wind_x_m_s,"), "{header}");
        assert!(header.ends_with(",quality_flags,unknown_heat_w_core1,unknown_heat_w_core2"), "{header}");
    }
}
