//! The most stack that the firmware can take, from the frames of its call graph.
//!
//! ```text
//! worst = way to the idle loop + idle + Σ over priorities (exception frame + deepest task of that priority) + fault
//! ```
//!
//! A task is interrupted by tasks of higher priority only, so of each priority one can be under way. Start-up, when interrupts are off,
//! stands alone. Frames are those of the machine code, whichever way is gone through a function, so the sum is never too small; what the call
//! graph cannot see, this does not either. Recursion has no bound and is an error.

use crate::call_graph::CallGraph;
use crate::panics::{self, IDLE};
use crate::shell;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;

/// What may be needed. A bound of our own, well below what there is: a growth is to be noticed and said.
const BUDGET: u32 = 44 * 1024;
/// What the processor puts on the stack when an exception begins: 8 registers, 17 of the FPU with its status, a word to stay free, and up to 4
/// bytes of alignment (Armv7-M Architecture Reference Manual, B1.5.7).
const EXCEPTION_FRAME: u32 = 26 * 4 + 4;
/// What the fault's entry leaves to its handler: `ROOM` in `firmware/src/fault_entry.rs`.
const FAULT_ROOM: u32 = 1024;
/// Where RAM begins (`memory.x`); below it there is nothing that can be written.
const RAM: u32 = 0x2000_0000;
/// Handlers that come on top of every task.
const FAULT: &str = "HardFault";
const DEFAULT: &str = "DefaultHandler";
const TASKS: &str = "firmware/src/main.rs";

/// What the stack holds at worst.
#[derive(Debug, PartialEq)]
pub struct Worst {
    pub start_up: u32,
    pub idle: u32,
    /// Of each priority, exception frame included.
    pub tasks: BTreeMap<u32, (u32, String)>,
    pub fault: u32,
}

impl Worst {
    pub fn total(&self) -> u32 {
        let running = self.idle + self.tasks.values().map(|(bytes, _)| bytes).sum::<u32>() + self.fault;
        running.max(self.start_up)
    }
}

/// Finds the worst case and compares it with the budget and with what there is.
pub fn check(graph: &CallGraph) -> Result<()> {
    let source =
        std::fs::read_to_string(shell::root().join(TASKS)).with_context(|| format!("{TASKS} cannot be read"))?;
    let worst = worst(graph, &priorities(&source))?;
    let symbol = |name: &str| graph.address(name).with_context(|| format!("the image has no symbol `{name}`"));
    let (top, bottom) = (symbol("_stack_start")?, symbol("_stack_end")?);
    println!("  {:<40} {:>8}", "stack at start-up, interrupts off", worst.start_up);
    println!("  {:<40} {:>8}", "stack of idle", worst.idle);
    for (priority, (bytes, name)) in &worst.tasks {
        println!("  {:<40} {bytes:>8}", format!("and of priority {priority}: {name}"));
    }
    println!("  {:<40} {:>8}", "and of a fault", worst.fault);
    let total = worst.total();
    println!("  {:<40} {total:>8} of {BUDGET} bytes; {} there are", "stack at worst", top - bottom);
    if bottom != RAM || top <= bottom {
        bail!(
            "the stack lies from {bottom:#x} to {top:#x}, not at the bottom of RAM, where running over its end is a fault; is flip-link the linker?"
        );
    }
    if worst.fault > EXCEPTION_FRAME + FAULT_ROOM {
        bail!("the fault handler may need more than the {FAULT_ROOM} bytes that its entry leaves it");
    }
    if total > BUDGET {
        bail!("{total} bytes of stack may be needed, {BUDGET} are allowed");
    }
    if total > top - bottom {
        bail!("{total} bytes of stack may be needed, there are {}", top - bottom);
    }
    Ok(())
}

/// Priority by vector, from the attributes of the tasks.
fn priorities(source: &str) -> BTreeMap<String, u32> {
    let of = |task: &str| {
        let after = |mark: &str| task.split(mark).nth(1).map(str::trim_start);
        let vector = after("binds =")?.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').next()?;
        let priority = after("priority =")?.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()?;
        Some((vector.to_owned(), priority))
    };
    source.split("#[task(").skip(1).filter_map(|task| of(task.split("fn ").next()?)).collect()
}

fn worst(graph: &CallGraph, priorities: &BTreeMap<String, u32>) -> Result<Worst> {
    let mut depths = Depths { graph, known: vec![None; graph.functions.len()], way: Vec::new() };
    let named = |name: &str| graph.function(name).with_context(|| format!("the image has no function `{name}`"));
    let (reset, idle) = (named("Reset")?, named(IDLE)?);
    let start_up = depths.of(reset)?;
    let idle = depths.way_to(reset, idle)?.with_context(|| format!("nothing leads from Reset to {IDLE}"))?;
    let mut tasks = BTreeMap::new();
    let mut fault = 0;
    // A vector of unknown priority interrupts everything.
    let mut unknown = priorities.values().max().copied().unwrap_or(0);
    for &vector in &graph.vectors {
        let bytes = EXCEPTION_FRAME + depths.of(vector)?;
        let names = &graph.functions[vector].names;
        if names.iter().any(|name| name == FAULT) {
            fault = bytes;
            continue;
        }
        // Vectors without a task share the default handler, which has all their names.
        let is_default = names.iter().any(|name| name == DEFAULT);
        let of_task = names.iter().filter(|_| !is_default).find_map(|name| Some((*priorities.get(name)?, name)));
        let (priority, name) = match of_task {
            Some((priority, name)) => (priority, name.clone()),
            None => {
                unknown += 1;
                (unknown, if is_default { DEFAULT } else { graph.functions[vector].name() }.to_owned())
            }
        };
        let slot = tasks.entry(priority).or_insert((0, String::new()));
        if bytes > slot.0 {
            *slot = (bytes, name);
        }
    }
    Ok(Worst { start_up, idle, tasks, fault })
}

/// Depths below functions, each found once.
struct Depths<'a> {
    graph: &'a CallGraph,
    known: Vec<Option<u32>>,
    way: Vec<usize>,
}

impl Depths<'_> {
    /// The most stack that a function and all that it calls can take. A panic ends the program and is not followed.
    fn of(&mut self, function: usize) -> Result<u32> {
        if let Some(depth) = self.known[function] {
            return Ok(depth);
        }
        if let Some(at) = self.way.iter().position(|&caller| caller == function) {
            let ring: Vec<&str> = self.way[at..].iter().map(|&f| self.graph.functions[f].name()).collect();
            bail!("functions that call themselves have no bound of their stack: {}", ring.join(" → "));
        }
        self.way.push(function);
        let mut deepest = 0;
        for callee in self.graph.callees(function) {
            if !panics::is_panic(&self.graph.functions[callee]) {
                deepest = deepest.max(self.of(callee)?);
            }
        }
        self.way.pop();
        let depth = self.graph.functions[function].frame + deepest;
        self.known[function] = Some(depth);
        Ok(depth)
    }

    /// The same of those ways only that lead to a function, and on through it.
    fn way_to(&mut self, from: usize, to: usize) -> Result<Option<u32>> {
        if from == to {
            return self.of(to).map(Some);
        }
        let mut deepest = None;
        for callee in self.graph.callees(from) {
            if !panics::is_panic(&self.graph.functions[callee]) {
                deepest = deepest.max(self.way_to(callee, to)?);
            }
        }
        Ok(deepest.map(|bytes| bytes + self.graph.functions[from].frame))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::call_graph::Function;

    fn function(name: &str, frame: u32, calls: &[usize]) -> Function {
        let (names, calls) = (vec![name.to_owned()], calls.iter().copied().collect());
        Function { names, calls, calls_pointers: false, frame }
    }

    /// Reset → start, idle; two tasks of one priority and one of another, a fault.
    fn graph() -> CallGraph {
        let functions = vec![
            function("Reset", 8, &[1, 2]),
            function("start", 500, &[]),
            function(IDLE, 16, &[]),
            function("SLOW", 100, &[6]),
            function("SLOWER", 10, &[]),
            function("QUICK", 50, &[6]),
            function("helper", 24, &[]),
            function(FAULT, 0, &[6]),
        ];
        CallGraph::of(functions, [3, 4, 5, 7])
    }

    const TASKS: &str = "
        #[task(binds = SLOW, priority = 1, local = [a])]
        fn slow() {}
        #[cfg(x)]
        #[task(binds = SLOWER, priority = 1)]
        fn slower() {}
        #[task(binds = QUICK, priority = 4)]
        fn quick() {}";

    #[test]
    fn of_each_priority_the_deepest_task_counts() {
        let worst = worst(&graph(), &priorities(TASKS)).expect("there is no recursion");
        assert_eq!((worst.start_up, worst.idle, worst.fault), (508, 24, 132));
        let tasks: Vec<_> = worst.tasks.iter().map(|(p, (bytes, name))| (*p, *bytes, name.as_str())).collect();
        assert_eq!(tasks, [(1, 232, "SLOW"), (4, 182, "QUICK")]);
        assert_eq!(worst.total(), 24 + 232 + 182 + 132);
    }

    #[test]
    fn a_vector_of_unknown_priority_comes_on_top() {
        let worst =
            worst(&graph(), &priorities("#[task(binds = SLOW, priority = 1)] fn slow() {}")).expect("no recursion");
        assert_eq!(worst.tasks.len(), 3);
        assert_eq!(worst.total(), 24 + 232 + 118 + 182 + 132);
    }

    #[test]
    fn recursion_is_an_error_that_names_it() {
        let mut graph = graph();
        graph.functions[6].calls.insert(5);
        let error = worst(&graph, &priorities(TASKS)).expect_err("helper calls QUICK, which calls helper").to_string();
        assert!(error.contains("helper → QUICK") || error.contains("QUICK → helper"), "{error}");
    }
}
