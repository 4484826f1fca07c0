//! Conditions on the firmware before it may heat anything: no task panics, the stack suffices, and
//! an overflow ends as a fault.
//!
//! The findings in an image are the work of `image-analysis`; what of it is allowed stands here.

use crate::artefacts::{self, FirmwareBoard};
use crate::{emulator, install, shell, stated};
use anyhow::{Context, Result, bail};
use image_analysis::call_graph::CallGraph;
use image_analysis::code::ImageCode;
use image_analysis::panics::{self, Rules};
use image_analysis::stack::{self, EXCEPTION_FRAME};
use std::process::Stdio;

const RULES: Rules = Rules {
    idle: "firmware::app::idle",
    allowed: &[
        (
            "_defmt_acquire",
            "defmt-rtt panics when a context logs in the middle of its own word. No argument of ours logs while it is written. A fault or another \
     task that logs meanwhile is another context, by the number of its exception: its word is dropped instead (feature drop-on-contention)",
        ),
        (
            "firmware::board::virtual_board::provoke",
            "panics when its host asks for a panic, to see what becomes of it; on the virtual board only",
        ),
    ],
};
/// Stack that may be needed. A bound of our own, well below what there is: a growth is to be
/// noticed and said.
const STACK_BUDGET: u32 = 63 * 1024;
/// Stack that the fault's entry leaves to its handler: `ROOM` in `firmware/src/fault_entry.rs`.
const FAULT_ROOM: u32 = 1024;
/// Where RAM begins (`memory.x`); below it there is nothing that can be written.
const RAM_START: u32 = 0x2000_0000;
const NUMBERS: &str = "docs/reference/numbers.md";
/// Text there before the stack of the boards.
const STACK_CELL: &str = "[in the logger](../explanation/safety-campaigns.md#panics); ";
/// The tasks with their priorities.
const TASKS: &str = "firmware/src/main.rs";

/// Exit code of `firmware/src/bin/overflow.rs` when the overflow became a fault, the heaters were
/// put low and its statics are whole.
const FAULTED: i32 = 102;

/// The ways in which it overflows.
const WAYS: [(&str, &str); 2] =
    [("call", "a function that calls itself"), ("interrupt", "an interrupt at the end of the stack")];

pub fn run() -> Result<()> {
    install::thumb_target()?;
    install::flip_link()?;
    install::qemu()?;
    let (mut faults, mut stacks_kib) = (Vec::new(), Vec::new());
    for board in FirmwareBoard::ALL {
        let graph = CallGraph::new(ImageCode::read(&artefacts::firmware(board)?)?)?;
        println!("\n{}", board.feature());
        let found = panics::find(&graph, &RULES).context("panics");
        let reachable = found.as_ref().map_or(0, |found| found.reachable);
        let stack = check_stack(&graph).context("stack").map(|bytes| stacks_kib.push(f64::from(bytes) / 1024.0));
        let checked = [found.and_then(|found| check_panics(&found).context("panics")), stack];
        faults
            .extend(checked.into_iter().filter_map(Result::err).map(|fault| format!("{}: {fault:#}", board.feature())));
        println!("  {:<40} {reachable:>8} of {}", "functions that run after start-up", graph.functions.len());
    }
    faults.extend(overflow().context("overflow").err().map(|fault| format!("{fault:#}")));
    faults.extend(stated::check(NUMBERS, STACK_CELL, &stacks_kib).err().map(|fault| format!("{fault:#}")));
    if !faults.is_empty() {
        bail!("{}", faults.join("\n"));
    }
    Ok(())
}

fn check_panics(found: &panics::PanicFindings) -> Result<()> {
    for exception in &found.exceptions {
        println!("  {exception}");
    }
    if !found.ways.is_empty() {
        bail!("a panic can be reached after start-up: {}", found.ways.join("; "));
    }
    Ok(())
}

/// Compares the worst case of the stack with the budget and with what there is; gives it.
fn check_stack(graph: &CallGraph) -> Result<u32> {
    let source =
        std::fs::read_to_string(shell::root().join(TASKS)).with_context(|| format!("{TASKS} cannot be read"))?;
    let worst = stack::worst(graph, &stack::priorities(&source), RULES.idle)?;
    let symbol = |name: &str| graph.address(name).with_context(|| format!("the image has no symbol `{name}`"));
    let (top, bottom) = (symbol("_stack_start")?, symbol("_stack_end")?);
    println!("  {:<40} {:>8}", "stack at start-up, interrupts off", worst.start_up);
    println!("  {:<40} {:>8}", "stack of idle", worst.idle);
    for (priority, (bytes, name)) in &worst.tasks {
        println!("  {:<40} {bytes:>8}", format!("and of priority {priority}: {name}"));
    }
    println!("  {:<40} {:>8}", "and of a fault", worst.fault);
    let total = worst.total();
    println!("  {:<40} {total:>8} of {STACK_BUDGET} bytes; {} there are", "stack at worst", top - bottom);
    if bottom != RAM_START || top <= bottom {
        bail!(
            "the stack lies from {bottom:#x} to {top:#x}, not at the bottom of RAM, where running over its end is a fault; is flip-link the linker?"
        );
    }
    if worst.fault > EXCEPTION_FRAME + FAULT_ROOM {
        bail!("the fault handler may need more than the {FAULT_ROOM} bytes that its entry leaves it");
    }
    if total > STACK_BUDGET {
        bail!("{total} bytes of stack may be needed, {STACK_BUDGET} are allowed");
    }
    if total > top - bottom {
        bail!("{total} bytes of stack may be needed, there are {}", top - bottom);
    }
    Ok(total)
}

/// Runs the image that overflows its stack, and expects the fault handler's exit code.
fn overflow() -> Result<()> {
    let elf = artefacts::image("overflow", FirmwareBoard::Virtual)?;
    println!();
    for (way, what) in WAYS {
        let mut qemu = emulator::command(&["overflow", way]);
        let mut child = emulator::start(qemu.stdout(Stdio::null()).arg("-kernel").arg(&elf))?;
        let status = emulator::wait(&mut child).context(what)?;
        if status.code() != Some(FAULTED) {
            bail!("{what} ended with {status} instead of a fault ({FAULTED})");
        }
        println!("  {what}: a fault, heaters low, statics whole");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_to_a_panic_is_refused() {
        assert!(check_panics(&panics::PanicFindings::default()).is_ok());
        let ways = vec!["idle → helper → core::panicking::panic".to_owned()];
        let error =
            check_panics(&panics::PanicFindings { ways, ..Default::default() }).expect_err("a panic").to_string();
        assert_eq!(error, "a panic can be reached after start-up: idle → helper → core::panicking::panic");
    }
}
