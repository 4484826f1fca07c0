//! Sweeps as a whole: what is done once, what fails, what is missing.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use crate::plan::{Plan, Shard};
use crate::run_folder::RunFolder;
use recording::Recording;

static NEVER: AtomicBool = AtomicBool::new(false);

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// A sweep over a short run in a steady wind.
fn plan(folder: &Path, rest: &str) -> Plan {
    read(folder, rest).unwrap()
}

fn read(folder: &Path, rest: &str) -> Result<Plan, String> {
    let path = folder.join("sweep.toml");
    let experiment = root().join("experiments/steady.toml");
    let short = "[[vary]]\nkey = \"duration_s\"\nvalues = [1.0]\n";
    fs::write(&path, format!("experiment = \"{}\"\n{rest}{short}", experiment.display())).unwrap();
    Plan::read(&path).map_err(|error| error.to_string())
}

const SEEDS: &str = "[[vary]]\nkey = \"seed\"\nvalues = [1, 2, 3, 4, 5, 6]\n";

/// How often the runs of a sweep were begun, in their order.
fn attempts(plan: &Plan, folder: &Path) -> Vec<usize> {
    let log = |hash: &str| RunFolder::new(folder, hash).path().join("attempts.log");
    let lines = |hash: &str| fs::read_to_string(log(hash)).map_or(0, |text| text.lines().count());
    plan.runs().iter().map(|run| lines(&run.hash)).collect()
}

fn work(plan: &Plan, folder: &Path, shard: Option<Shard>) -> crate::WorkDone {
    plan.work(folder, shard, 2, &NEVER, &|_| ()).unwrap()
}

#[test]
fn every_run_is_done_once_and_a_folder_without_results_is_done_again() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(folder.path(), SEEDS);
    let out = folder.path().join("out");
    assert_eq!(work(&plan, &out, None).done, 6);
    let first = plan.gather(&out).unwrap();
    assert_eq!((first.complete, first.incomplete()), (6, None));
    // As a process leaves it that was killed in the middle.
    let half = RunFolder::new(&out, &plan.runs()[2].hash);
    let result = half.result().unwrap();
    fs::remove_file(half.path().join("result.json")).unwrap();
    fs::create_dir(half.path().join(".attempt-killed")).unwrap();
    let again = work(&plan, &out, None);
    assert_eq!((again.before, again.done), (5, 1));
    assert_eq!(attempts(&plan, &out), [1, 1, 2, 1, 1, 1]);
    assert_eq!(half.result().unwrap(), result, "the same run comes to the same");
    assert!(!half.path().join(".attempt-killed").exists());
}

#[test]
fn the_hash_is_of_what_is_run_and_not_of_where_or_how_it_is_written() {
    let (one, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let hashes = |plan: &Plan| plan.runs().iter().map(|run| run.hash.clone()).collect::<Vec<_>>();
    let whole = hashes(&plan(one.path(), SEEDS));
    // The same experiment elsewhere, with comments and in another order.
    fs::create_dir(other.path().join("heads")).unwrap();
    let text = fs::read_to_string(root().join("experiments/steady.toml")).unwrap();
    let moved = text.replace("../heads", "heads").replace("title = ", "# A remark.\ntitle  = ");
    for file in ["sphere-b.toml", "models/sphere-b-mars-still.toml"] {
        let to = other.path().join("heads").join(file);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(root().join("heads").join(file), to).unwrap();
    }
    fs::write(other.path().join("steady.toml"), moved).unwrap();
    let sweep = format!("experiment = \"steady.toml\"\n{SEEDS}[[vary]]\nkey = \"duration_s\"\nvalues = [1.0]\n");
    fs::write(other.path().join("again.toml"), sweep).unwrap();
    let again = Plan::read(&other.path().join("again.toml")).unwrap();
    assert_eq!(hashes(&again), whole);
    let head = other.path().join("heads/sphere-b.toml");
    fs::write(&head, fs::read_to_string(&head).unwrap().replace("energy_j = 12.0", "energy_j = 12.5")).unwrap();
    let changed = hashes(&Plan::read(&other.path().join("again.toml")).unwrap());
    assert!(changed.iter().zip(&whole).all(|(changed, before)| changed != before));
    // What a step reads beside the sweep file counts, as its words do.
    let with_step = |text: &str| {
        fs::write(one.path().join("network.json"), text).unwrap();
        hashes(&plan(
            one.path(),
            &format!("then = [\"calibrate {{recording}} --network {{sweep}}/network.json\"]\n{SEEDS}"),
        ))
    };
    let (first, second) = (with_step("{}"), with_step("{} "));
    assert!(first[0] != second[0] && first == with_step("{}"));
}

#[test]
fn a_run_that_fails_is_listed_with_its_sentence_and_does_not_stop_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let speeds = "[[vary]]\nkey = \"wind.speed_m_s\"\nvalues = [1.0, -3.0, 4.0]\n";
    let plan = plan(folder.path(), speeds);
    let out = folder.path().join("out");
    let done = work(&plan, &out, None);
    assert_eq!((done.done, done.failed), (2, 1));
    let report = plan.gather(&out).unwrap();
    assert_eq!((report.complete, report.failed.len(), report.incomplete()), (2, 1, None));
    let failed = &report.failed[0];
    assert!(failed.keys.contains("wind.speed_m_s = -3"), "{failed:?}");
    assert!(failed.sentence.contains("steady.toml, line") && failed.sentence.contains("speed_m_s"), "{failed:?}");
    // The file that the sentence names is there.
    let named = failed.sentence.split(", line").next().unwrap();
    assert!(Path::new(named).is_file(), "{named}");
    let table = Recording::read(&report.results).unwrap();
    assert_eq!(table.len(), 3);
    assert!(table.words("failed").unwrap().word(1).contains("speed_m_s"));
    let power_w = table.numbers("steady_power_w_sector1").unwrap();
    assert!(power_w[1].is_nan() && power_w[0].is_finite() && power_w[2].is_finite());
    assert_eq!(table.numbers("wind_speed_m_s").unwrap(), [1.0, -3.0, 4.0]);
}

#[test]
fn what_is_damaged_in_a_folder_is_done_again_and_what_cannot_be_written_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(folder.path(), &format!("recordings = true\n{SEEDS}"));
    let out = folder.path().join("out");
    assert_eq!(work(&plan, &out, None).done, 6);
    let own = |run: usize, name: &str| out.join(format!("run={}", plan.runs()[run].hash)).join(name);
    // A recording that was cut, the results of another run, and results that somebody changed.
    fs::write(own(0, "steady.parquet"), b"PAR1").unwrap();
    fs::copy(own(2, "result.json"), own(1, "result.json")).unwrap();
    let result = fs::read_to_string(own(3, "result.json")).unwrap();
    let changed = result.replacen("\"results\":{", "\"results\":{\"more\":1,", 1);
    fs::write(own(3, "result.json"), changed).unwrap();
    let done = work(&plan, &out, None);
    assert_eq!((done.before, done.done), (3, 3));

    let file = folder.path().join("file");
    fs::create_dir(&file).unwrap();
    // A file stands where the folder of a run belongs.
    fs::write(file.join(format!("run={}", plan.runs()[0].hash)), "").unwrap();
    let never = AtomicBool::new(false);
    let sentence = plan.work(&file, None, 1, &never, &|_| ()).unwrap_err().to_string();
    assert!(sentence.contains("cannot be written"), "{sentence}");
}

#[test]
fn a_shard_that_is_missing_is_named_and_what_is_there_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(folder.path(), SEEDS);
    let out = folder.path().join("out");
    for number in [1, 3] {
        assert_eq!(work(&plan, &out, Some(Shard { number, of: 3 })).done, 2);
    }
    let report = plan.gather(&out).unwrap();
    let sentence = report.incomplete().unwrap();
    assert!(sentence.starts_with("runs are missing: 2 of 2 in shard 2/3; the others are kept"), "{sentence}");
    assert_eq!(Recording::read(&report.results).unwrap().len(), 4);
    work(&plan, &out, Some(Shard { number: 2, of: 3 }));
    let whole = plan.gather(&out).unwrap();
    assert_eq!((whole.complete, whole.incomplete()), (6, None));
    assert_eq!(attempts(&plan, &out), [1; 6]);
}

#[test]
fn the_same_run_in_many_threads_at_once_leaves_one_result() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(folder.path(), &format!("recordings = true\n{SEEDS}"));
    let out = folder.path().join("out");
    // Often, since they must not meet at any moment.
    for place in 0..6 {
        let results: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..6).map(|_| scope.spawn(|| plan.run(place, &out, &NEVER))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap().unwrap()).collect()
        });
        assert!(results.iter().all(|result| *result == results[0]));
    }
    let own = RunFolder::new(&out, &plan.runs()[0].hash);
    let mut files: Vec<_> = fs::read_dir(own.path()).unwrap().map(|file| file.unwrap().file_name()).collect();
    files.sort();
    let expected =
        ["attempts.log", "result.json", "steady.head.toml", "steady.models.toml", "steady.parquet", "steady.toml"];
    assert_eq!(files, expected);
    assert_eq!(Recording::read(&own.recording("steady")).unwrap().len(), 100);
}

#[test]
fn an_interrupted_sweep_keeps_what_is_done_and_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(folder.path(), SEEDS);
    let out = folder.path().join("out");
    let interrupted = AtomicBool::new(false);
    let stop = |settled: usize| {
        if settled == 2 {
            interrupted.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    };
    let done = plan.work(&out, None, 1, &interrupted, &stop).unwrap();
    assert_eq!((done.done, done.failed, done.interrupted), (2, 0, true));
    assert!(plan.gather(&out).unwrap().incomplete().unwrap().contains("4 of 6"));
    let rest = work(&plan, &out, None);
    assert_eq!((rest.before, rest.done, rest.interrupted), (2, 4, false));
    assert_eq!(attempts(&plan, &out), [1; 6]);
}

#[test]
fn an_outlier_is_named_with_its_head_among_equal_winds() {
    let folder = tempfile::tempdir().unwrap();
    // Seven heads, of which one has a platinum film of another kind, in two winds.
    let rest = "[[vary]]\nkey = \"wind.speed_m_s\"\nvalues = [1.0, 9.0]\n[[vary]]\nkey = \"head.kinds.sector.platinum.coefficient_per_c\"\nvalues = [0.0031, 0.003101, 0.003102, 0.003103, 0.003104, 0.003105, 0.0037]\n[outliers]\ncolumns = [\"steady_temperature_c_sector1\"]\nby = [\"wind.speed_m_s\"]\n";
    let plan = plan(folder.path(), rest);
    let out = folder.path().join("out");
    work(&plan, &out, None);
    let report = plan.gather(&out).unwrap();
    assert!(report.failed.is_empty(), "{:?}", report.failed);
    let keys: Vec<&str> = report.outliers.iter().map(|found| found.keys.as_str()).collect();
    assert_eq!(keys.len(), 2, "{report}");
    assert!(keys.iter().all(|keys| keys.contains("coefficient_per_c = 0.0037")), "{keys:?}");
}

#[test]
fn what_is_wrong_in_every_run_is_refused_before_any_with_the_key_of_the_sweep_file() {
    let folder = tempfile::tempdir().unwrap();
    let refused =
        |key: &str| read(folder.path(), &format!("[[vary]]\nkey = \"{key}\"\nvalues = [1.0, 2.0]\n")).unwrap_err();
    let unknown = refused("wind.speed_ms");
    assert!(unknown.contains("sweep.toml, line 3: `vary[0].key` makes no run that can be read"), "{unknown}");
    assert!(unknown.ends_with("unknown key `speed_ms`; did you mean `speed_m_s`?"), "{unknown}");
    let of_head = refused("head.kinds.sector.energy");
    assert!(of_head.contains("steady.head.toml of the first: unknown key `energy`"), "{of_head}");
    let no_table = refused("title.x");
    assert!(no_table.contains("is `title.x`: `title` is no table that could have a key `x`"), "{no_table}");
    fs::write(folder.path().join("s.toml"), "experiment = \"none.toml\"\n[[vary]]\nkey = \"a\"\nvalues = [1]\n")
        .unwrap();
    let none = Plan::read(&folder.path().join("s.toml")).unwrap_err().to_string();
    assert!(
        none.contains("s.toml, line 1: `experiment` cannot be used") && none.ends_with("there is no such file"),
        "{none}"
    );
}
