//! No panic in what runs after start-up, shown on the linked image.
//!
//! Source that does not panic proves little: indices, divisions and whole libraries bring panics that no one has written. In the image they
//! are calls of functions of `core::panicking`. From everything that an interrupt, an exception or the idle loop can reach there must be
//! no way to one of them. Start-up may panic: no heater has been raised yet, and the board starts anew.
//!
//! What this does not see: whatever [`crate::call_graph`] does not, and code that stops without a panic (an endless loop, a fault; the
//! watchdog and the fault handler are for those).

use crate::call_graph::{CallGraph, Function};
use anyhow::{Result, bail};
use std::collections::{BTreeSet, HashMap, VecDeque};

/// The idle loop: what runs before it is start-up.
pub const IDLE: &str = "firmware::app::idle";

/// Functions whose panics are known not to happen, and why. Their other calls count.
const ALLOWED: [(&str, &str); 0] = [];

/// Where a panic begins.
pub fn is_panic(function: &Function) -> bool {
    function.names.iter().any(|name| {
        name.starts_with("core::panicking::")
            || name.contains("rust_begin_unwind")
            || name.contains("defmt_panic")
            || name.starts_with("core::") && (name.ends_with("_failed") || name.ends_with("_fail"))
    })
}

/// Every way from what runs after start-up to a panic, one for each function that panics.
pub fn check(graph: &CallGraph) -> Result<()> {
    let Some(idle) = graph.function(IDLE) else { bail!("the image has no function `{IDLE}`") };
    if !graph.functions.iter().any(|function| is_panic(function)) {
        bail!("the image has no panic at all, not even at start-up: their names must have changed, so nothing is checked");
    }
    let ways = ways(graph, graph.vectors.iter().copied().chain([idle]));
    for (name, _) in ALLOWED {
        if graph.function(name).is_none() {
            println!("  {name} is not in this image, its allowance is not needed");
        }
    }
    if !ways.is_empty() {
        bail!("a panic can be reached after start-up: {}", ways.join("; "));
    }
    Ok(())
}

/// How many functions can run after start-up.
pub fn reachable(graph: &CallGraph) -> usize {
    let mut seen: BTreeSet<usize> = graph.vectors.iter().copied().chain(graph.function(IDLE)).collect();
    let mut queue: Vec<usize> = seen.iter().copied().collect();
    while let Some(function) = queue.pop() {
        queue.extend(graph.callees(function).filter(|callee| seen.insert(*callee)));
    }
    seen.len()
}

fn ways(graph: &CallGraph, roots: impl Iterator<Item = usize>) -> Vec<String> {
    let name = |function: usize| graph.functions[function].name();
    let mut from: HashMap<usize, Option<usize>> = roots.map(|root| (root, None)).collect();
    let mut queue: VecDeque<usize> = from.keys().copied().collect();
    queue.make_contiguous().sort_unstable();
    let mut ways = Vec::new();
    while let Some(function) = queue.pop_front() {
        let mut panics = false;
        for callee in graph.callees(function) {
            if is_panic(&graph.functions[callee]) {
                if panics || ALLOWED.iter().any(|(allowed, _)| *allowed == name(function)) {
                    continue;
                }
                panics = true;
                let mut way = vec![name(callee)];
                let mut at = Some(function);
                while let Some(function) = at {
                    way.push(name(function));
                    at = from.get(&function).copied().flatten();
                }
                way.reverse();
                ways.push(way.join(" → "));
            } else if !from.contains_key(&callee) {
                from.insert(callee, Some(function));
                queue.push_back(callee);
            }
        }
    }
    ways
}
