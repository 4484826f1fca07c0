//! The most stack that the firmware can take, from the frames of its call graph.
//!
//! ```text
//! worst = way to the idle loop + idle + fault
//!         + Σ over priorities (exception frame + deepest task of that priority)
//! ```
//!
//! A task is interrupted by tasks of higher priority only, so of each priority one can be under
//! way. Start-up, when interrupts are off, stands alone. Frames are those of the machine code,
//! whichever way is gone through a function, so the sum is never too small; what the call graph
//! cannot see, this does not either. Recursion has no bound and is an error.

use crate::call_graph::CallGraph;
use crate::panics;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;

/// Bytes that the processor puts on the stack when an exception begins: 8 registers, 17 of the FPU
/// with its status, a word to stay free, and up to 4 bytes of alignment (Armv7-M Architecture
/// Reference Manual, B1.5.7).
pub const EXCEPTION_FRAME: u32 = 26 * 4 + 4;
/// Handlers that come on top of every task.
const FAULT: &str = "HardFault";
const DEFAULT: &str = "DefaultHandler";

/// Stack at worst.
#[derive(Debug, PartialEq)]
pub struct WorstStack {
    /// Before the idle loop, interrupts off.
    pub start_up: u32,
    /// The way to the idle loop, and all that it calls.
    pub idle: u32,
    /// Stack of each priority, exception frame included, with the deepest task's name.
    pub tasks: BTreeMap<u32, (u32, String)>,
    /// Stack of the fault handler, which comes on top of every task.
    pub fault: u32,
}

impl WorstStack {
    /// Bytes of all together.
    pub fn total(&self) -> u32 {
        let running = self.idle + self.tasks.values().map(|(bytes, _)| bytes).sum::<u32>() + self.fault;
        running.max(self.start_up)
    }
}

/// Priority by vector, from the attributes of RTIC's tasks in the application's source.
pub fn priorities(source: &str) -> BTreeMap<String, u32> {
    let of = |task: &str| {
        let after = |mark: &str| task.split(mark).nth(1).map(str::trim_start);
        let vector = after("binds =")?.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').next()?;
        let priority = after("priority =")?.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()?;
        Some((vector.to_owned(), priority))
    };
    source.split("#[task(").skip(1).filter_map(|task| of(task.split("fn ").next()?)).collect()
}

/// Finds the worst case. `idle_name` is the function of the idle loop.
pub fn worst(graph: &CallGraph, priorities: &BTreeMap<String, u32>, idle_name: &str) -> Result<WorstStack> {
    let mut depths = Depths { graph, known: vec![None; graph.functions.len()], way: Vec::new() };
    let named = |name: &str| graph.function(name).with_context(|| format!("the image has no function `{name}`"));
    let (reset, idle) = (named("Reset")?, named(idle_name)?);
    let start_up = depths.of(reset)?;
    let idle = depths.way_to(reset, idle)?.with_context(|| format!("nothing leads from Reset to {idle_name}"))?;
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
    Ok(WorstStack { start_up, idle, tasks, fault })
}

/// Depths below functions, each found once.
struct Depths<'a> {
    graph: &'a CallGraph,
    known: Vec<Option<u32>>,
    way: Vec<usize>,
}

impl Depths<'_> {
    /// The most stack that a function and all that it calls can take. A panic ends the program and
    /// is not followed.
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

    const IDLE: &str = "firmware::app::idle";

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
        let worst = worst(&graph(), &priorities(TASKS), IDLE).expect("there is no recursion");
        assert_eq!((worst.start_up, worst.idle, worst.fault), (508, 24, 132));
        let tasks: Vec<_> = worst.tasks.iter().map(|(p, (bytes, name))| (*p, *bytes, name.as_str())).collect();
        assert_eq!(tasks, [(1, 232, "SLOW"), (4, 182, "QUICK")]);
        assert_eq!(worst.total(), 24 + 232 + 182 + 132);
    }

    #[test]
    fn a_vector_of_unknown_priority_comes_on_top() {
        let worst = worst(&graph(), &priorities("#[task(binds = SLOW, priority = 1)] fn slow() {}"), IDLE)
            .expect("no recursion");
        assert_eq!(worst.tasks.len(), 3);
        assert_eq!(worst.total(), 24 + 232 + 118 + 182 + 132);
    }

    #[test]
    fn recursion_is_an_error_that_names_it() {
        let mut graph = graph();
        graph.functions[6].calls.insert(5);
        let error =
            worst(&graph, &priorities(TASKS), IDLE).expect_err("helper calls QUICK, which calls helper").to_string();
        assert!(error.contains("helper → QUICK") || error.contains("QUICK → helper"), "{error}");
    }
}
