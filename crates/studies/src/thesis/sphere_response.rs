//! The same step of the wind on both spheres: how long until the front part tells, in closed loop
//! and in open loop.

use super::findings::StudyFindings;
use super::lab::{StudyLab, alternating};
use super::settling::{SHARES, StepResponse, Window};
use anyhow::{Context as _, Result};
use host_sim::experiment::Experiment;
use plot::{Chart, Scale, Trace, brief};

/// Repetitions of the step for times below a second.
const REPEATED: usize = 100;
/// Each wind of a repetition, s.
const EACH_S: f64 = 2.5;
/// Until cores and stem have come to rest, s.
const WARM_S: f64 = 400.0;
pub const FAST_PERIOD_S: f64 = 1e-3;
/// Half of a moving average over such steps.
const SMOOTHED_S: f64 = 0.015;
/// Greatest part that is left for later, %.
const MOST_LEFT: f64 = 2.0;
/// Less is noise in any of the runs, %.
const LEAST_SHOWN: f64 = 0.05;
/// A tail worth the name, s.
const TAIL_S: f64 = 20.0;

/// One line of the table.
struct StepCase {
    what: &'static str,
    response: StepResponse,
    /// Where it is drawn from, s after the step.
    from_s: f64,
}

pub fn run(lab: &StudyLab, findings: &mut StudyFindings) -> Result<()> {
    let (b_closed, b_long) = of_b(lab, "sphere-b-step")?;
    let (b_off, b_off_long) = of_b(lab, "sphere-b-cores-off")?;
    let b_slow = lab.experiment("sphere-b-step")?;
    let b_slow = of_b_repeated(lab, &b_slow, b_slow.sample_period_s)?;
    let (power, current) = (open(lab, "sphere-b-power")?, open(lab, "sphere-b-current")?);
    let cases = [
        StepCase { what: "A, closed loop", response: of_a(lab)?, from_s: 0.5 },
        StepCase { what: "B, closed loop", response: b_closed, from_s: 0.01 },
        StepCase { what: "B, closed loop at 100 Hz", response: b_slow, from_s: 0.01 },
        StepCase { what: "B, closed loop, cores passive", response: b_off, from_s: 0.01 },
        StepCase { what: "B, constant power", response: power, from_s: 1.0 },
        StepCase { what: "B, constant current, cores passive", response: current, from_s: 1.0 },
    ];
    findings.fill("times", table(&cases));
    let [a, b, b_slow, b_off, power, current] = &cases;
    findings.fill("repeated", REPEATED.to_string());
    for (name, case) in
        [("resolution_b_s", b), ("resolution_a_s", a), ("resolution_open_s", power), ("resolution_slow_s", b_slow)]
    {
        findings.fill(name, brief(case.response.resolution_s));
    }
    judge(findings, [a, b, b_off, power, current], (b_long, b_off_long))?;
    let chart = |caption: &str, of: fn(f64) -> f64| {
        let lines = cases.iter().map(|case| {
            let points = case.response.points(case.from_s, 1e4).into_iter();
            Trace::line(case.what, points.map(|(time_s, missing)| (time_s, of(missing))).collect())
        });
        Chart::new(caption, "% of the change").x(Scale::Log, "s").traces(lines)
    };
    let answered = chart("Answered after the step", |missing| 100.0 - missing).height(38.0);
    let missing = chart("Missing after the step", absolute)
        .y(Scale::Log)
        .height(50.0)
        .note("below the noise of each, lines mean nothing")
        .limit(10.0)
        .limit(5.0)
        .limit(2.0);
    findings.picture("Spheres A and B: a step of the wind from 2 to 6 m/s", [vec![answered], vec![missing]]);
    Ok(())
}

fn absolute(missing: f64) -> f64 {
    if missing.abs() < LEAST_SHOWN { f64::NAN } else { missing.abs() }
}

fn judge(
    findings: &mut StudyFindings,
    [a, b, b_off, power, current]: [&StepCase; 5],
    (b_long, b_off_long): (f64, f64),
) -> Result<()> {
    let settled = |case: &StepCase| -> Result<f64> {
        let never = || format!("{}: the run is too short for its 2 %", case.what);
        case.response.settled_s(2.0).with_context(never)
    };
    let tail = "tail of tens of seconds or more";
    findings.between("A: time to 2 % of the change", tail, (settled(a)?, "s"), (TAIL_S, f64::INFINITY));
    for (case, long) in [(b, b_long), (b_off, b_off_long)] {
        let most = case.response.most_missing_after(1.0);
        let what = format!("{}: most missing after 1 s", case.what);
        findings.between(what, "no tail", (most, "%"), (f64::NEG_INFINITY, MOST_LEFT));
        let what = format!("{}: missing from 1 to 11 s, of what comes in 15 min", case.what);
        findings.between(what, "no tail", (long.abs(), "%"), (f64::NEG_INFINITY, MOST_LEFT));
    }
    for (open, closed) in [(power, b), (current, b_off)] {
        let factor = settled(open)? / settled(closed)?;
        let what = format!("{} against closed loop, times to 2 %", open.what);
        findings.between(what, "over 100 expected", (factor, ""), (100.0, f64::INFINITY));
    }
    let watts = |case: &StepCase| format!("{:.2} to {:.2} mW", 1e3 * case.response.before, 1e3 * case.response.finally);
    for case in [a, b, b_off] {
        findings.reported(format!("{}: power", case.what), watts(case));
    }
    for case in [power, current] {
        let celsius = format!("{:.2} to {:.2} °C", case.response.before, case.response.finally);
        findings.reported(format!("{}: temperature", case.what), celsius);
    }
    Ok(())
}

fn table(cases: &[StepCase]) -> String {
    let mut text = String::new();
    for case in cases {
        let times = SHARES.map(|share| match case.response.settled_s(share) {
            Some(time_s) => brief(time_s),
            None => "not in this run".to_owned(),
        });
        text += &format!("| {} | {} | {:.2} |\n", case.what, times.join(" | "), case.response.noise);
    }
    text.trim_end().to_owned()
}

/// Sphere A in closed loop: one step and its end minutes later.
pub fn of_a(lab: &StudyLab) -> Result<StepResponse> {
    let (experiment, record) = lab.run("sphere-a-step")?;
    let (step, after) = step(&experiment)?;
    let window = Window { before: after / 3, after, end: after / 3, half: 100 };
    Ok(StepResponse::of(record.power_w("hemisphere1")?, &[step], window, experiment.sample_period_s))
}

/// Sphere B in closed loop: its repeated step, and what the long one lacks from 1 to 11 s, % of its
/// change.
fn of_b(lab: &StudyLab, name: &str) -> Result<(StepResponse, f64)> {
    let base = lab.experiment(name)?;
    let record = lab.record(&base)?;
    let (_, after) = step(&base)?;
    let at_s = base.wind[1].start_s;
    let end_s = at_s + after as f64 * base.sample_period_s;
    let before = record.mean_power_w("sector1", at_s - 300.0, at_s)?;
    let soon = record.mean_power_w("sector1", at_s + 1.0, at_s + 11.0)?;
    let finally = record.mean_power_w("sector1", end_s - 300.0, end_s)?;
    let left = 100.0 * (finally - soon) / (finally - before);
    Ok((of_b_repeated(lab, &base, FAST_PERIOD_S)?, left))
}

/// Sphere B's repeated step, sampled every so often.
pub fn of_b_repeated(lab: &StudyLab, base: &Experiment, period_s: f64) -> Result<StepResponse> {
    let mut experiment = alternating(base, WARM_S, EACH_S, 2 * REPEATED, period_s)?;
    experiment.title = format!("{}, repeated, {} ms", base.title, 1e3 * period_s);
    let record = lab.record(&experiment)?;
    let tick = |time_s: f64| (time_s / period_s).round() as usize;
    let steps: Vec<usize> = (0..REPEATED).map(|n| tick(WARM_S + 2.0 * EACH_S * n as f64)).collect();
    let window = Window { before: tick(1.0), after: tick(EACH_S), end: tick(1.0), half: tick(SMOOTHED_S).max(5) };
    Ok(StepResponse::of(record.power_w("sector1")?, &steps, window, period_s))
}

/// The temperature of a sector under what it is given.
fn open(lab: &StudyLab, name: &str) -> Result<StepResponse> {
    let (experiment, record) = lab.run(name)?;
    let (step, after) = step(&experiment)?;
    let window = Window { before: 2000, after, end: after / 6, half: 10 };
    Ok(StepResponse::of(record.temperature_c("sector1")?, &[step], window, experiment.sample_period_s))
}

/// Tick of an experiment's first change of the wind, and ticks until the next.
fn step(experiment: &Experiment) -> Result<(usize, usize)> {
    let tick = |time_s: f64| (time_s / experiment.sample_period_s).round() as usize;
    let none = || format!("{}: its wind does not step", experiment.title);
    let first = tick(experiment.wind.get(1).with_context(none)?.start_s);
    let next = experiment.wind.get(2).map_or(experiment.ticks as usize, |wind| tick(wind.start_s));
    Ok((first, next - first))
}
