//! Cost of the hot paths on the Cortex-M4F: instructions counted in QEMU, cycles by the table of
//! the technical reference (`cortex_m4`).
//!
//! The image `firmware/src/bin/cost.rs` calls every kernel of the table below, each an uninlined
//! function of that name, with inputs that cover its paths. QEMU runs it one instruction at a time
//! and logs each; `trace` adds up what lies between call and return. The counts depend on the
//! pinned compiler alone, so they are asserted and stand in `docs/reference/numbers.md` exactly as
//! printed.

use crate::artefacts::{self, FirmwareBoard};
use crate::{emulator, install, response, shell};
use anyhow::{Context, Result, bail};
use image_analysis::code::ImageCode;
use image_analysis::trace::{self, Counter, KernelTally};
use std::fmt::Write;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Stdio;

struct Kernel {
    /// The function's name in the image.
    symbol: &'static str,
    operation: &'static str,
    /// For operations on relaxations: how many.
    poles: Option<u32>,
    /// The most instructions that one call may take.
    budget: u64,
}

const fn kernel(symbol: &'static str, operation: &'static str, budget: u64) -> Kernel {
    Kernel { symbol, operation, poles: None, budget }
}

/// Budgets lie a few per cent above what the pinned compiler makes of the code, so that a change of
/// cost is noticed and said.
const KERNELS: [Kernel; 15] = [
    Kernel { poles: Some(8), ..kernel("relaxations_8_poles", "8 relaxations, compensated, with output", 120) },
    // 3 610 in the mean; one element's drive and model are verified in a tick, and the largest take
    // some 250 more. 150 are for the lock-out, the silence of the host and the head on the plug,
    // whose sixteen words are under the checksum, too; 150 an element for what it has had of energy
    // and whether the high level warms it; 60 for what it is, as not every one is a resistor.
    kernel("control_6_elements", "control tick: 6 elements, all drives, with models", 4_320),
    kernel("control_6_elements_observing", "the same, observing", 5_000),
    kernel("control_6_of_16", "control tick: the 6 elements on a controller of 16", 4_810),
    kernel("control_13_of_16", "13 elements on a controller of 16", 9_000),
    kernel("platinum_linear", "resistance to temperature, linear", 16),
    kernel("platinum_iec60751", "resistance to temperature, IEC 60751", 135),
    kernel("prbs_step", "pseudo-random bit", 20),
    kernel("sigma_delta_step", "sigma-delta modulator", 18),
    kernel("decimator_push", "decimator, one bit in", 85),
    kernel("wind_4_sectors", "wind vector from four sectors, at the decimated rate", 40_000),
    kernel("wind_3_sectors", "the same from three of them, or from four of which one is hardly known", 75_000),
    kernel("handover_6_elements", "handover of a tick to the wind estimate", 400),
    kernel("anemometer_6_elements", "anemometer tick: 6 elements, with the wind of 4 sectors", 90_000),
    // 6 800 in the mean, 1 200 of them so that what an element missed warms the others in all 30
    // pairs; the rest is the checksum of the largest piece, the prepared output, once in
    // 43 ticks.
    kernel("anemometer_between_outputs", "anemometer tick without an answer", 11_000),
];

const CLOCK_HZ: f64 = 168e6;
const TICK_HZ: f64 = 1000.0;
const PAGE: &str = "docs/reference/numbers.md";
/// Tables of that page.
const COST: &str = "cost";
const RESPONSE: &str = "response";
/// The tasks with their priorities.
const TASKS: &str = "firmware/src/main.rs";

#[derive(clap::Args, Default)]
pub struct CostOptions {
    /// Fail when a budget is exceeded or the page of numbers shows others
    #[arg(long, conflicts_with = "write")]
    pub check: bool,
    /// Put the table into the page of numbers, where no budget is exceeded
    #[arg(long)]
    pub write: bool,
    /// Count in this image instead of building one
    #[arg(long, value_name = "ELF")]
    pub image: Option<PathBuf>,
}

pub fn run(options: &CostOptions) -> Result<()> {
    install::thumb_target()?;
    install::qemu()?;
    let source =
        std::fs::read_to_string(shell::root().join(TASKS)).with_context(|| format!("{TASKS} cannot be read"))?;
    response::check_priorities(&source)?;
    let (responses, deadlines) = response::table()?;
    println!("{responses}");
    deadlines.context("a deadline is broken")?;
    let build = || artefacts::image("cost", FirmwareBoard::Virtual);
    let elf = options.image.clone().map_or_else(build, Ok)?;
    let code = ImageCode::read(&elf)?;
    let entry = |kernel: &Kernel| {
        code.entry(kernel.symbol).with_context(|| format!("the cost image has no function `{}`", kernel.symbol))
    };
    let entries = KERNELS.iter().map(entry).collect::<Result<Vec<u32>>>()?;
    let tallies = measure(&elf, Counter::new(&entries, trace::instructions(&code)))?;
    if let Some((kernel, _)) = KERNELS.iter().zip(&tallies).find(|(_, tally)| tally.calls == 0) {
        bail!("the cost image never calls `{}`", kernel.symbol);
    }
    let table = table(&tallies);
    print!("{table}");
    if options.check || options.write {
        check_budgets(&tallies)?;
        let path = shell::root().join(PAGE);
        let page = std::fs::read_to_string(&path).with_context(|| format!("{PAGE} cannot be read"))?;
        let updated = with_table(&with_table(&page, COST, &table)?, RESPONSE, &responses)?;
        if options.write {
            std::fs::write(path, updated).with_context(|| format!("{PAGE} cannot be written"))?;
        } else if updated != page {
            bail!("a table of {PAGE} is not what was measured; type: cargo xtask cost --write");
        }
    }
    Ok(())
}

/// Runs an image to its end, one instruction at a time, and counts what each kernel takes.
fn measure(elf: &Path, counter: Counter) -> Result<Vec<KernelTally>> {
    let version = shell::output_of(install::QEMU, &["--version"]).unwrap_or_default();
    let mut qemu = emulator::command(&[]);
    qemu.args(single_step(&version)).args(["-d", "exec,nochain", "-kernel"]).arg(elf);
    let mut child = emulator::start(qemu.stderr(Stdio::piped()))?;
    let log = child.stderr.take().context("the emulator's log cannot be read")?;
    std::thread::scope(|scope| {
        let counting = scope.spawn(|| counter.read(BufReader::with_capacity(1 << 20, log)));
        let status = emulator::wait(&mut child).context("the cost image");
        let tallies = counting.join().unwrap_or_else(|_| bail!("the thread that counts has ended early"))?;
        let status = status?;
        if !status.success() {
            bail!("the cost image did not end well in the emulator ({status})");
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
        bail!("{}; make it cheaper, or raise its budget in tools/xtask/src/cost.rs and say why", over.join("; "));
    }
    Ok(())
}

/// The page of numbers with this table between the marks of its name.
fn with_table(page: &str, name: &str, table: &str) -> Result<String> {
    let [begin, end] = ["begin", "end"].map(|place| format!("<!-- {name}:{place} -->"));
    let marked = page.split_once(&begin).and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = marked.with_context(|| {
        format!("{PAGE} has no place for the {name} table; put {begin} and {end} on lines of their own")
    })?;
    Ok(format!("{before}{begin}\n{table}{end}{after}"))
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
    fn the_table_is_put_between_its_marks() {
        let page = |table: &str| format!("before\n<!-- cost:begin -->\n{table}<!-- cost:end -->\nafter\n");
        let updated = with_table(&page("| x |\n"), COST, "| y |\n").expect("both marks are there");
        assert_eq!(updated, page("| y |\n"));
        assert!(with_table(&page(""), RESPONSE, "").is_err());
        assert!(with_table("<!-- cost:end --> <!-- cost:begin -->", COST, "").is_err());
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
