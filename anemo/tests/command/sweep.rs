//! `anemo sweep`: what it prints, how it ends, what its steps find, how it is killed and goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use crate::process::{anemo, json, refused, stdout, words};
use recording::Recording;

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// Writes `sweep.toml`: runs of so many seconds, one a seed.
pub fn write_sweep(folder: &Path, duration_s: f64, seeds: usize, rest: &str) {
    let experiment = root().join("experiments/steady.toml");
    let text = format!(
        "experiment = {experiment:?}\n{rest}[[vary]]\nkey = \"duration_s\"\nvalues = [{duration_s:?}]\n[[vary]]\nkey = \"seed\"\nrange = [1, {seeds}]\nsteps = {seeds}\nwhole = true\n"
    );
    fs::write(folder.join("sweep.toml"), text).unwrap();
}

/// Run, result and how often the run was begun, of all folders of runs, in the order of their
/// names.
pub fn outcomes(folder: &Path) -> Vec<(String, String, usize)> {
    let mut found = Vec::new();
    for run in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = run.file_name().unwrap().to_string_lossy().into_owned();
        if let Some(hash) = name.strip_prefix("run=") {
            // A run that begins has a folder first.
            let attempts = fs::read_to_string(run.join("attempts.log")).map_or(0, |log| log.lines().count());
            let result = fs::read(run.join("result.json")).ok();
            let result = result.map(|text| serde_json::from_slice::<serde_json::Value>(&text).unwrap());
            let result = result.map_or(String::new(), |result| result["result_hash"].as_str().unwrap().to_owned());
            found.push((hash.to_owned(), result, attempts));
        }
    }
    found.sort();
    found
}

#[test]
fn a_sweep_is_listed_run_gathered_and_found_done() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_sweep(folder, 1.0, 5, "title = \"Five seeds\"\n");
    let listed = stdout(&anemo(folder, &words("sweep sweep.toml --dry-run")));
    assert!(listed.ends_with("5 runs\n") && listed.contains("  duration_s = 1.0, seed = 3\n"), "{listed}");
    assert!(!folder.join("sweep").exists(), "nothing is run");
    let done = stdout(&anemo(folder, &words("sweep sweep.toml")));
    assert_eq!(done, "Five seeds · 5 runs: 5 complete, 0 failed, 0 missing\nresults: sweep/results.parquet\n");
    let again = json(folder, &words("sweep sweep.toml --json"));
    assert_eq!((&again["complete"], &again["runs"]), (&5.into(), &5.into()));
    assert!(outcomes(&folder.join("sweep")).iter().all(|(.., attempts)| *attempts == 1));
    // The same elsewhere, in parts.
    for shard in ["1/2", "2/2"] {
        stdout(&anemo(folder, &["sweep", "sweep.toml", "-o", "parts", "--shard", shard, "--jobs", "1"]));
    }
    assert_eq!(outcomes(&folder.join("parts")), outcomes(&folder.join("sweep")));
    assert!(!folder.join("parts/results.parquet").exists());
    stdout(&anemo(folder, &words("sweep sweep.toml -o parts --gather")));
    let tables = ["parts", "sweep"].map(|name| Recording::read(&folder.join(name).join("results.parquet")).unwrap());
    assert_eq!(tables[0].columns, tables[1].columns);
}

#[test]
fn what_fails_or_is_missing_or_wrong_has_its_exit_code_and_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_sweep(folder, 1.0, 2, "[[vary]]\nkey = \"wind.speed_m_s\"\nvalues = [1.0, -1.0]\n");
    let failed = refused(folder, &words("sweep sweep.toml"), 1);
    assert_eq!(failed, "anemo: 2 of 4 runs failed");
    let of_shard = refused(folder, &words("sweep sweep.toml -o parts --shard 1/2"), 1);
    assert_eq!(of_shard, "anemo: 1 of 2 runs failed; --gather lists them");
    let missing = refused(folder, &words("sweep sweep.toml -o parts --gather"), 4);
    assert!(missing.starts_with("anemo: runs are missing: 2 of 2 in shard 2/2; the others are kept"), "{missing}");
    assert_eq!(Recording::read(&folder.join("parts/results.parquet")).unwrap().len(), 2);
    let nothing = refused(folder, &words("sweep sweep.toml -o none --gather"), 2);
    assert!(nothing.contains("none: there is no such folder"), "{nothing}");
    let no_experiment = refused(folder, &words("run sweep.toml --on sim"), 2);
    assert!(no_experiment.contains("sweep.toml: is a sweep, which `anemo sweep` runs"), "{no_experiment}");
    refused(folder, &words("sweep sweep.toml --shard 3/2"), 2);
    refused(folder, &words("sweep sweep.toml --jobs 0"), 2);
    write_sweep(folder, 1.0, 2, "then = [\"identify {recording} --ordr 3\"]\n");
    let step = refused(folder, &words("sweep sweep.toml"), 2);
    assert!(step.contains("`then[0]` is refused: unexpected argument '--ordr'"), "{step}");
}

#[test]
fn a_step_of_every_run_makes_columns_and_its_failure_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let experiment = root().join("experiments/prbs.toml");
    let text = format!(
        "experiment = {experiment:?}\nthen = [\"identify {{recording}} --output sector1 --order 3 --mesh 0.001:1 -o model.json --json\", \"validate model.json {{recording}} --json\"]\n[[vary]]\nkey = \"duration_s\"\nvalues = [0.1, 120.0]\n"
    );
    fs::write(folder.join("fleet.toml"), text).unwrap();
    let failed = refused(folder, &words("sweep fleet.toml"), 1);
    assert_eq!(failed, "anemo: 1 of 2 runs failed");
    let table = Recording::read(&folder.join("fleet/results.parquet")).unwrap();
    let of = |name: &str| table.numbers(name).unwrap();
    assert!(of("identify_pairs_0_mesh_rad_s_2")[1] == 1.0, "{:?}", table.columns);
    assert!(of("validate_fit_percent")[1].is_finite() && of("validate_fit_percent")[0].is_nan());
    let sentence = table.words("failed").unwrap();
    assert!(sentence.word(0).starts_with("`identify {recording} --output sector1"), "{}", sentence.word(0));
    assert_eq!(sentence.word(1), "");
    for (hash, result, _) in outcomes(&folder.join("fleet")) {
        let has = |name: &str| folder.join(format!("fleet/run={hash}")).join(name).exists();
        assert_eq!([has("model.json"), has("validate.summary.json")], [!result.is_empty(); 2], "{hash}");
        assert!(!has("prbs.parquet") || result.is_empty(), "recordings are not kept unless asked for");
    }
}

#[test]
fn a_step_that_writes_the_results_of_the_sweep_fails_with_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let experiment = root().join("experiments/prbs.toml");
    let text = format!(
        "experiment = {experiment:?}\nthen = [\"identify {{recording}} --output sector1 --order 3 --mesh 0.001:1 -o result.json\"]\n[[vary]]\nkey = \"duration_s\"\nvalues = [60.0]\n"
    );
    fs::write(folder.path().join("one.toml"), text).unwrap();
    refused(folder.path(), &words("sweep one.toml"), 1);
    let table = Recording::read(&folder.path().join("one/results.parquet")).unwrap();
    let sentence = table.words("failed").unwrap();
    assert!(sentence.word(0).ends_with("writes result.json, which is the sweep's: name another file"), "{sentence:?}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_ends_soon_keeps_what_is_done_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // About 0.3 s each.
    write_sweep(folder, 600.0, 8, "");
    let mut sweep = Command::new(env!("CARGO_BIN_EXE_anemo"))
        .args(words("sweep sweep.toml --jobs 1"))
        .current_dir(folder)
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    let done = || {
        folder.join("sweep").exists() && outcomes(&folder.join("sweep")).iter().any(|(_, result, _)| !result.is_empty())
    };
    while !done() {
        assert!(Instant::now() < deadline);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &sweep.id().to_string()]).status().unwrap().success());
    let asked = Instant::now();
    assert_eq!(sweep.wait().unwrap().code(), Some(4));
    assert!(asked.elapsed() < Duration::from_secs(20), "{:?}", asked.elapsed());
    let kept = outcomes(&folder.join("sweep")).iter().filter(|(_, result, _)| !result.is_empty()).count();
    assert!((1..8).contains(&kept), "{kept}");
    stdout(&anemo(folder, &words("sweep sweep.toml")));
    let all = outcomes(&folder.join("sweep"));
    assert_eq!(all.len(), 8);
    // But the one that was interrupted, each was begun once.
    assert!(all.iter().map(|(.., attempts)| attempts).sum::<usize>() <= 9, "{all:?}");
}
