//! The report of an identification as a page, from outside.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use super::process::anemo;

fn identify(folder: &Path, arguments: &[&str]) -> Output {
    anemo(folder, &[&["identify"], arguments].concat())
}

/// One relaxation of 10 s after a single step, for hardly longer than that.
fn record(folder: &Path) {
    let mut text = "time_s,power_w_<b>,temperature_c_a\n".to_owned();
    for row in 0..400 {
        let time_s = f64::from(row) * 0.05;
        let noise_k = f64::from(row * 7919 % 101) * 1e-3;
        let rise_k = if row < 100 { 0.0 } else { 5.0 * (1.0 - libm::exp((5.0 - time_s) / 10.0)) };
        let _ = writeln!(text, "{time_s:.2},{},{:.4}", u8::from(row >= 100), 20.0 + rise_k + noise_k);
    }
    std::fs::write(folder.join("step.csv"), text).unwrap();
}

#[test]
fn a_report_says_what_the_next_record_should_be_and_needs_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder);
    let output = identify(folder, &["step.csv", "-o", "m.json", "--report", "r.html"]);
    assert!(output.status.success(), "{output:?}");
    let (page, printed) = (std::fs::read_to_string(folder.join("r.html")).unwrap(), String::from_utf8(output.stdout));
    assert!(page.contains("power_w_&lt;b&gt;") && !page.contains("<b>") && page.contains("<svg "));
    let model = diffusive::model::Model::read(&folder.join("m.json")).unwrap();
    assert!(model.advice.len() >= 2 && !model.supported);
    let printed = printed.unwrap();
    for advice in &model.advice {
        assert!(printed.contains(advice) && page.contains(&recording::text::markup(advice)), "{advice}");
    }
}

#[test]
fn a_report_is_written_over_no_record_and_has_the_name_of_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder);
    for (report, expected) in [
        ("step.csv", "step.csv: is read by this command"),
        ("r.pdf", "r.pdf: the name of a report ends in .html"),
        ("none/r.html", "none/r.html: cannot be written"),
    ] {
        let output = identify(folder, &["step.csv", "--report", report]);
        let sentence = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && sentence.contains(expected), "{sentence}");
    }
}
