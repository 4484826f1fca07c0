//! Studies of the thesis, run and judged.

use std::time::Instant;

use studies::thesis::{STUDIES, StudyFindings, StudyLab};

use crate::file;

/// Runs a study, which must have so many bars and miss exactly those that are named, so that one
/// that gets worse, or better, is noticed.
pub fn study(name: &str, bars: usize, missed: &[&str]) -> StudyFindings {
    let study = STUDIES.iter().find(|study| study.name == name).unwrap_or_else(|| panic!("no study {name}"));
    let begun = Instant::now();
    let lab = StudyLab::new(file("experiments/thesis"), &|_| ());
    let found = study.run(&lab).unwrap_or_else(|error| panic!("{name}: {error}"));
    println!("{name}, {:.1} s", begun.elapsed().as_secs_f64());
    for finding in &found.findings {
        println!("  {:?} {}: {} ({})", finding.met, finding.what, finding.ours, finding.bar);
    }
    let own: Vec<&str> = found.findings.iter().filter(|of| of.met == Some(false)).map(|of| of.what.as_str()).collect();
    assert_eq!(own, missed, "{name}");
    assert_eq!(found.score().0, bars, "{name}");
    assert!(found.figure.svg().starts_with("<svg"), "{name}");
    found
}
