//! What a sweep costs beside its runs, and what a second core saves.
//!
//! `cargo bench -p sweep`. Pairs are measured one after the other, five times, and the median
//! counts. Other work on the machine disturbs: the load before each pair stands beside it, and the
//! processor time, which other work changes less.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use host_sim::experiment::Experiment;
use host_sim::instrument::in_process;
use host_sim::run::run;
use sweep::Plan;

const PAIRS: usize = 5;
static NEVER: AtomicBool = AtomicBool::new(false);

/// A sweep over seeds of a run of so many seconds.
fn plan(folder: &Path, runs: usize, duration_s: f64) -> Plan {
    let experiment = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/steady.toml");
    let file = folder.join(format!("{runs}.toml"));
    let text = format!(
        "experiment = {experiment:?}\n[[vary]]\nkey = \"duration_s\"\nvalues = [{duration_s:?}]\n[[vary]]\nkey = \"seed\"\nrange = [1, {runs}]\nsteps = {runs}\nwhole = true\n"
    );
    std::fs::write(&file, text).expect("a folder to write to");
    Plan::read(&file).expect("a sweep")
}

/// Time of a whole sweep into a fresh folder, s: reading it, its runs, and gathering them.
fn sweep_s(folder: &Path, runs: usize, duration_s: f64, jobs: usize) -> f64 {
    let out = tempfile::tempdir_in(folder).expect("a folder");
    let start = Instant::now();
    let plan = plan(folder, runs, duration_s);
    plan.work(out.path(), None, jobs, &NEVER, &|_| ()).expect("it works");
    let report = plan.gather(out.path()).expect("it gathers");
    let taken_s = start.elapsed().as_secs_f64();
    assert_eq!(report.complete, runs, "{report}");
    taken_s
}

/// Time of the same runs by themselves, s.
fn plain_s(folder: &Path, runs: usize, duration_s: f64) -> f64 {
    let file = folder.join("plain.toml");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = std::fs::read_to_string(root.join("experiments/steady.toml")).expect("an experiment");
    let text = text.replace("../heads", &root.join("heads").to_string_lossy());
    std::fs::write(&file, text.replace("= 300.0", &format!("= {duration_s:?}"))).expect("a folder to write to");
    let start = Instant::now();
    for _ in 0..runs {
        let experiment = Experiment::read(&file).expect("an experiment");
        let sensor = experiment.sensor().expect("a sensor");
        let instrument = in_process::of_head(experiment.head.elements.len(), sensor);
        let summary = run(&experiment, instrument, &mut |_| Ok(())).expect("a run");
        assert_eq!(summary.duration_s, duration_s);
    }
    start.elapsed().as_secs_f64()
}

/// Processor time of this process so far, s. The clock of Linux has ticks of 10 ms.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name in brackets, user and system time are the 12th and 13th.
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    0.01 * fields.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>()
}

fn load() -> String {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    load.split(' ').next().unwrap_or_default().to_owned()
}

/// Prints five pairs, their ratios and the median ratio.
fn pairs(what: &str, mut one: impl FnMut() -> f64, mut other: impl FnMut() -> f64) {
    println!("{what}");
    let mut ratios: Vec<f64> = (0..PAIRS)
        .map(|_| {
            let (load, begin_s) = (load(), processor_s());
            let (one_s, between_s) = (one(), processor_s());
            let (other_s, end_s) = (other(), processor_s());
            let (one_cpu_s, other_cpu_s) = (between_s - begin_s, end_s - between_s);
            println!(
                "  {one_s:.3} s and {other_s:.3} s: {:.3}; processor time {one_cpu_s:.2} s and {other_cpu_s:.2} s: {:.3}  (load {load})",
                one_s / other_s,
                one_cpu_s / other_cpu_s
            );
            one_s / other_s
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    println!("  median {:.3}", ratios[PAIRS / 2]);
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    pairs("1000 runs of 10 s, one core and two", || sweep_s(folder, 1000, 10.0, 1), || sweep_s(folder, 1000, 10.0, 2));
    // About 1 s of computing each.
    pairs(
        "3 runs of 2400 s, as a sweep and by themselves",
        || sweep_s(folder, 3, 2400.0, 1),
        || plain_s(folder, 3, 2400.0),
    );
    let (runs, short_s) = (1000, 0.01);
    let by_sweep_s = sweep_s(folder, runs, short_s, 1);
    println!("1000 runs of one sample: {:.2} ms each, all that a sweep does for a run", by_sweep_s);
}
