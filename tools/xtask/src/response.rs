//! Response times of the firmware's tasks on the sensor board, each against its deadline.

use crate::artefacts::{self, FirmwareBoard};
use anyhow::{Context, Result, bail};
use image_analysis::bounds::{BOUNDS, CYCLES_PER_US, LENGTHS, PATHS};
use image_analysis::code::ImageCode;
use image_analysis::paths::{MemoryModel, PathRules, Paths};
use image_analysis::response::{Interference, response};
use image_analysis::source_places::SourcePlaces;
use image_analysis::tasks::{EXCEPTION_CYCLES, LONGEST_LOCK, MEASURED_RAISED, TASKS, Takes, Work};
use std::fmt::Write;

const MODELS: [MemoryModel; 2] = [MemoryModel::Immediate, MemoryModel::FlashMisses];
/// The path by whose growth measured times are raised where flash has wait states.
const TYPICAL_PATH: &str = "control: tick";
/// Longer than any deadline, µs.
const LIMIT_US: u64 = 1_000_000;

/// Times of some work with one model of the memory, cycles.
struct Times {
    takes: u64,
    /// None if there is no bound.
    response: Option<u64>,
}

/// Analyses the sensor board's image; returns the table, and an error for each broken deadline.
pub fn table() -> Result<(String, Result<()>)> {
    let elf = artefacts::firmware(FirmwareBoard::Sensor)?;
    let bytes = std::fs::read(&elf).with_context(|| format!("{} cannot be read", elf.display()))?;
    let (code, places) = (ImageCode::read(&elf)?, SourcePlaces::read(&bytes)?);
    let all = [times(&code, &places, 0)?, times(&code, &places, 1)?];
    let mut table = String::from(
        "| task | priority | longest path or 1.5 times the measured, µs | response, µs | deadline, µs | with every line of flash missed: path, µs | response, µs | deadline, µs |\n|---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    let mut broken = Vec::new();
    for (i, work) in TASKS.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = write!(table, "| {} | {} ", work.name, work.priority);
        for (times, deadline_us) in all.iter().map(|times| &times[i]).zip(work.deadline_us) {
            let _ = write!(table, "| {} | {} | {deadline_us} ", shown(Some(times.takes)), shown(times.response));
            if times.response.is_none_or(|response| response > deadline_us * CYCLES_PER_US) {
                broken.push(format!(
                    "{} responds in {} µs, {deadline_us} µs are allowed ({})",
                    work.name,
                    shown(times.response),
                    work.why
                ));
            }
        }
        table.push_str("|\n");
    }
    let judged = if broken.is_empty() { Ok(()) } else { Err(anyhow::anyhow!("{}", broken.join("; "))) };
    Ok((table, judged))
}

fn shown(cycles: Option<u64>) -> String {
    cycles.map_or("∞".to_owned(), |cycles| format!("{:.1}", cycles as f64 / CYCLES_PER_US as f64))
}

/// Times of all work.
fn times(code: &ImageCode, places: &SourcePlaces, model: usize) -> Result<Vec<Times>> {
    let memory = MODELS[model];
    let path_with = |name: &str, memory| {
        let path = PATHS.iter().find(|path| path.name == name).with_context(|| format!("no path `{name}`"))?;
        Paths::new(code, places, path.rules, memory).longest(path.vector)
    };
    let lock_rules = PathRules { own: &[], bounds: BOUNDS, lengths: LENGTHS, excluded: &[], ends_in: None };
    let lock = Paths::new(code, places, lock_rules, memory).longest(LONGEST_LOCK)?;
    let (typical, without) = (path_with(TYPICAL_PATH, memory)?, path_with(TYPICAL_PATH, MemoryModel::Immediate)?);
    let [numerator, denominator] = MEASURED_RAISED;
    let takes = |work: &Work| match work.takes {
        Takes::Path(name) => Ok(path_with(name, memory)? + EXCEPTION_CYCLES),
        Takes::Measured { cycles, .. } => Ok((cycles * numerator).div_ceil(denominator) * typical / without),
    };
    let takes = TASKS.iter().map(takes).collect::<Result<Vec<u64>>>()?;
    let of = |(i, work): (usize, &Work)| {
        let others: Vec<Interference> = TASKS
            .iter()
            .enumerate()
            .filter(|(j, other)| goes_before(other, work) && *j != i)
            .map(|(j, other)| Interference { takes: takes[j], period: other.period_us[model] * CYCLES_PER_US })
            .collect();
        // Priority 6 shares nothing.
        let blocked = if work.priority > 5 { 0 } else { lock };
        Times { takes: takes[i], response: response(takes[i], blocked, &others, LIMIT_US * CYCLES_PER_US) }
    };
    Ok(TASKS.iter().enumerate().map(of).collect())
}

/// Tells whether other work may run first. Of one task, `control`, the runs come one after another.
fn goes_before(other: &Work, work: &Work) -> bool {
    let task = |work: &Work| work.name.split(':').next();
    other.interferes && other.priority >= work.priority && task(other) != task(work)
}

/// Fails where the table of tasks and the application's source disagree.
pub fn check_priorities(source: &str) -> Result<()> {
    for work in TASKS {
        let name = work.name.split(':').next().unwrap_or(work.name);
        let before = source.split(&format!("fn {name}(")).next().filter(|before| before.len() < source.len());
        let attribute = before.and_then(|before| before.rsplit("#[task(").next());
        let expected = format!("priority = {}", work.priority);
        if !attribute.is_some_and(|attribute| attribute.contains(&expected)) {
            bail!(
                "task `{name}` is not of priority {} in the firmware; mend tools/image-analysis/src/tasks.rs",
                work.priority
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_of_the_table_of_tasks_is_known() {
        for work in TASKS {
            if let Takes::Path(name) = work.takes {
                assert!(PATHS.iter().any(|path| path.name == name), "{name}");
            }
        }
        assert!(PATHS.iter().any(|path| path.name == TYPICAL_PATH));
    }

    #[test]
    fn a_task_of_another_priority_is_named() {
        let source: String = TASKS
            .iter()
            .map(|work| format!("#[task(priority = {})]\nfn {}(", work.priority, work.name.split(':').next().unwrap()))
            .collect();
        assert!(check_priorities(&source).is_ok());
        let error = check_priorities(&source.replace("priority = 3", "priority = 1")).unwrap_err().to_string();
        assert!(error.starts_with("task `transmit` is not of priority 3"), "{error}");
    }
}
