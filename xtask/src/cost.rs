//! Cost of the hot paths on the Cortex-M4F: instructions counted in QEMU, cycles by the table of
//! the technical reference (`cortex_m4`).
//!
//! The image `firmware/src/bin/cost.rs` calls every kernel of the table below, each an uninlined
//! function of that name, with inputs that cover its paths. QEMU runs it one instruction at a time
//! and logs each; `trace` adds up what lies between call and return. The counts depend on the
//! pinned compiler alone, so they are asserted and stand in the README exactly as printed.

use crate::{artefacts, install, shell};
use anyhow::{Context, Result, bail};
use image_analysis::symbols::Image;
use image_analysis::trace::{Counter, KernelTally};
use std::fmt::Write;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, mpsc};
use std::time::Duration;

struct Kernel {
    /// The function's name in the image.
    symbol: &'static str,
    operation: &'static str,
    /// For operations on relaxations: how many.
    poles: Option<u32>,
    /// The most instructions that one call may take.
    budget: u64,
}

/// Budgets lie a few per cent above what the pinned compiler makes of the code, so that a change of
/// cost is noticed and said.
const KERNELS: [Kernel; 14] = [
    Kernel {
        symbol: "relaxations_8_poles",
        operation: "8 relaxations, compensated, with output",
        poles: Some(8),
        budget: 120,
    },
    Kernel {
        symbol: "control_6_elements",
        operation: "control tick: 6 elements, all drives, with models",
        poles: None,
        // 2 500 in the mean; one element's drive and model are verified in a tick, and the largest
        // take some 200 more.
        budget: 2860,
    },
    Kernel { symbol: "control_6_elements_observing", operation: "the same, observing", poles: None, budget: 3500 },
    Kernel {
        symbol: "control_6_of_16",
        operation: "control tick: the 6 elements on a controller of 16",
        poles: None,
        budget: 3170,
    },
    Kernel { symbol: "control_13_of_16", operation: "13 elements on a controller of 16", poles: None, budget: 5960 },
    Kernel { symbol: "platinum_linear", operation: "resistance to temperature, linear", poles: None, budget: 16 },
    Kernel { symbol: "platinum_iec60751", operation: "resistance to temperature, IEC 60751", poles: None, budget: 135 },
    Kernel { symbol: "prbs_step", operation: "pseudo-random bit", poles: None, budget: 20 },
    Kernel { symbol: "sigma_delta_step", operation: "sigma-delta modulator", poles: None, budget: 18 },
    Kernel { symbol: "decimator_push", operation: "decimator, one bit in", poles: None, budget: 85 },
    Kernel {
        symbol: "wind_4_sectors",
        operation: "wind vector from four sectors, at the decimated rate",
        poles: None,
        budget: 38_500,
    },
    Kernel {
        symbol: "wind_3_sectors",
        operation: "the same from three of them, or from four of which one is hardly known",
        poles: None,
        budget: 75_000,
    },
    Kernel {
        symbol: "anemometer_6_elements",
        operation: "anemometer tick: 6 elements, with the wind of 4 sectors",
        poles: None,
        budget: 90_000,
    },
    Kernel {
        symbol: "anemometer_between_outputs",
        operation: "anemometer tick without an answer",
        poles: None,
        // 6 700 in the mean; the rest is the checksum of the largest piece, the prepared output,
        // once in 43 ticks.
        budget: 9_500,
    },
];

const CLOCK_HZ: f64 = 168e6;
const TICK_HZ: f64 = 1000.0;
const README: &str = "README.md";
const BEGIN: &str = "<!-- cost:begin -->";
const END: &str = "<!-- cost:end -->";
/// A run takes some seconds; an image that never ends is stopped.
const TIME_LIMIT: Duration = Duration::from_secs(180);

#[derive(clap::Args)]
pub struct CostOptions {
    /// Fail when a budget is exceeded or the README shows other numbers
    #[arg(long, conflicts_with = "write")]
    check: bool,
    /// Put the table into the README, where no budget is exceeded
    #[arg(long)]
    write: bool,
    /// Count in this image instead of building one
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
}

impl CostOptions {
    /// What `test` does.
    pub fn check() -> CostOptions {
        CostOptions { check: true, write: false, image: None }
    }
}

pub fn run(options: &CostOptions) -> Result<()> {
    install::thumb_target()?;
    install::qemu()?;
    let elf = options.image.clone().map_or_else(artefacts::cost_image, Ok)?;
    let image = Image::read(&elf)?;
    let entries = KERNELS
        .iter()
        .map(|kernel| {
            image.function(kernel.symbol).with_context(|| format!("the cost image has no function `{}`", kernel.symbol))
        })
        .collect::<Result<Vec<u32>>>()?;
    let tallies = measure(&elf, &entries)?;
    if let Some((kernel, _)) = KERNELS.iter().zip(&tallies).find(|(_, tally)| tally.calls == 0) {
        bail!("the cost image never calls `{}`", kernel.symbol);
    }
    let table = table(&tallies);
    print!("{table}");
    if options.check || options.write {
        check_budgets(&tallies)?;
    }
    if options.write {
        update_readme(&table)?;
    }
    if options.check {
        check_readme(&table)?;
    }
    Ok(())
}

/// Runs an image to its end, one instruction at a time, and counts what each kernel takes.
fn measure(elf: &Path, entries: &[u32]) -> Result<Vec<KernelTally>> {
    let version = shell::output_of(install::QEMU, &["--version"]).unwrap_or_default();
    let mut qemu = Command::new(install::QEMU);
    qemu.args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "null"]);
    qemu.args(["-semihosting-config", "enable=on,target=native"]);
    qemu.args(single_step(&version)).args(["-d", "in_asm,exec,nochain", "-kernel"]).arg(elf);
    let mut child =
        qemu.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().context("qemu-system-arm cannot be started")?;
    let log = child.stderr.take().context("the emulator's log cannot be read")?;

    let child = Mutex::new(child);
    let (finished, wait) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let child = &child;
        scope.spawn(move || {
            if wait.recv_timeout(TIME_LIMIT) == Err(mpsc::RecvTimeoutError::Timeout)
                && let Ok(mut child) = child.lock()
            {
                let _ = child.kill();
            }
        });
        let tallies = Counter::new(entries).read(BufReader::with_capacity(1 << 20, log));
        drop(finished);
        let status = child.lock().map_err(|_| anyhow::anyhow!("the emulator was lost"))?.wait()?;
        let tallies = tallies?;
        if !status.success() {
            bail!("the cost image did not end well in the emulator ({status}) within {} s", TIME_LIMIT.as_secs());
        }
        Ok(tallies)
    })
}

/// QEMU 8.1 renamed the option, QEMU 10 removed the old one.
fn single_step(version: &str) -> &'static [&'static str] {
    let number = version.split("version ").nth(1).unwrap_or_default();
    let mut parts = number.split(|c: char| !c.is_ascii_digit()).map(|part| part.parse::<u32>().unwrap_or(0));
    let (major, minor) = (parts.next().unwrap_or(0), parts.next().unwrap_or(0));
    if (major, minor) >= (8, 1) { &["-accel", "tcg,one-insn-per-tb=on"] } else { &["-singlestep"] }
}

fn table(tallies: &[KernelTally]) -> String {
    let mut table = String::from(
        "| operation | instructions, mean | at most | cycles, at most | a pole | share of a 1 ms tick at 168 MHz |\n|---|--:|--:|--:|--:|--:|\n",
    );
    for (kernel, tally) in KERNELS.iter().zip(tallies) {
        let cycles = tally.worst.cycles;
        let each = kernel.poles.map_or(String::new(), |poles| {
            format!("{:.1}–{:.1}", cycles.low as f64 / f64::from(poles), cycles.high as f64 / f64::from(poles))
        });
        let share = 100.0 * cycles.high as f64 * TICK_HZ / CLOCK_HZ;
        // Writing to a String cannot fail.
        let _ = writeln!(
            table,
            "| {} | {:.0} | {} | {}–{} | {each} | {share:.2} % |",
            kernel.operation,
            tally.mean_instructions(),
            tally.worst.instructions,
            cycles.low,
            cycles.high
        );
    }
    table
}

fn check_budgets(tallies: &[KernelTally]) -> Result<()> {
    let over: Vec<String> = KERNELS
        .iter()
        .zip(tallies)
        .filter(|(kernel, tally)| tally.worst.instructions > kernel.budget)
        .map(|(kernel, tally)| {
            format!("{} takes {} instructions, {} are allowed", kernel.symbol, tally.worst.instructions, kernel.budget)
        })
        .collect();
    if !over.is_empty() {
        bail!("{}; make it cheaper, or raise its budget in xtask/src/cost.rs and say why", over.join("; "));
    }
    Ok(())
}

/// The README's three parts: up to and including the begin mark, the table, from the end mark on.
fn parts(readme: &str) -> Result<(&str, &str, &str)> {
    let begin = readme.find(BEGIN).map(|at| at + BEGIN.len());
    let end = readme.find(END);
    match (begin, end) {
        (Some(begin), Some(end)) if begin <= end => Ok((&readme[..begin], &readme[begin..end], &readme[end..])),
        _ => bail!("{README} has no place for the cost table; put {BEGIN} and {END} on lines of their own"),
    }
}

fn read_readme() -> Result<String> {
    std::fs::read_to_string(shell::root().join(README)).with_context(|| format!("{README} cannot be read"))
}

fn check_readme(table: &str) -> Result<()> {
    let readme = read_readme()?;
    let (_, shown, _) = parts(&readme)?;
    if shown.trim() != table.trim() {
        bail!("the cost table of {README} is not what was measured; type: cargo xtask cost --write");
    }
    Ok(())
}

fn update_readme(table: &str) -> Result<()> {
    let readme = read_readme()?;
    let (before, _, after) = parts(&readme)?;
    std::fs::write(shell::root().join(README), format!("{before}\n{table}{after}"))
        .with_context(|| format!("{README} cannot be written"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_single_step_option_follows_the_version() {
        assert_eq!(single_step("QEMU emulator version 7.2.22 (Debian 1:7.2+dfsg-7)"), ["-singlestep"]);
        assert_eq!(single_step("QEMU emulator version 8.0.5"), ["-singlestep"]);
        assert_eq!(single_step("QEMU emulator version 8.2.2 (Debian)"), ["-accel", "tcg,one-insn-per-tb=on"]);
        assert_eq!(single_step("QEMU emulator version 10.0.3"), ["-accel", "tcg,one-insn-per-tb=on"]);
    }

    #[test]
    fn the_table_is_found_between_its_marks() {
        let readme = format!("before\n{BEGIN}\n| x |\n{END}\nafter\n");
        let (before, table, after) = parts(&readme).expect("both marks are there");
        assert!(before.starts_with("before") && after.ends_with("after\n"));
        assert_eq!(table.trim(), "| x |");
        assert!(parts(&format!("{END} {BEGIN}")).is_err());
    }

    #[test]
    fn a_kernel_beyond_its_budget_is_named_with_both_numbers() {
        let mut tallies = [KernelTally::default(); KERNELS.len()];
        assert!(check_budgets(&tallies).is_ok());
        tallies[0].worst.instructions = 121;
        let error = check_budgets(&tallies).expect_err("120 are allowed").to_string();
        assert!(error.starts_with("relaxations_8_poles takes 121 instructions, 120 are allowed"), "{error}");
    }
}
