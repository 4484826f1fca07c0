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
use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap, VecDeque};

/// The idle loop: what runs before it is start-up.
pub const IDLE: &str = "firmware::app::idle";

/// Functions whose panics are known not to happen, and why. Their other calls count.
const ALLOWED: [(&str, &str); 2] = [
    (
        "_defmt_acquire",
        "defmt-rtt panics when a context logs in the middle of its own word. No argument of ours logs while it is written. A fault or another \
     task that logs meanwhile is another context, by the number of its exception: its word is dropped instead (feature drop-on-contention)",
    ),
    (
        "firmware::board::virtual_board::provoke",
        "panics when its host asks for a panic, to see what becomes of it; on the virtual board only",
    ),
];

/// Vectors whose tasks may panic, and why.
const EXEMPT: [(&str, &str); 1] = [(
    "SPI2",
    "the clerk keeps the settings, by a crate that asserts what it has written to the flash. It works in standby only, all heaters low, while the \
     control task carries out no command; a panic there ends as any other, and the next start leaves the settings alone until it is acknowledged",
)];

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
    if !graph.functions.iter().any(is_panic) {
        bail!(
            "the image has no panic at all, not even at start-up: their names must have changed, so nothing is checked"
        );
    }
    let exempt =
        |vector: &usize| EXEMPT.iter().any(|(name, _)| graph.functions[*vector].names.iter().any(|own| own == name));
    let vectors = graph.vectors.iter().copied().filter(|vector| !exempt(vector));
    let ways = ways(graph, vectors.chain([idle]));
    for (name, why) in EXEMPT.iter().filter(|(name, _)| graph.function(name).is_some()) {
        println!("  exempt is {name}: {why}");
    }
    for (name, why) in ALLOWED {
        if graph.function(name).is_some_and(|function| graph.callees(function).any(|f| is_panic(&graph.functions[f]))) {
            println!("  allowed in {name}: {why}");
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
            } else if let Entry::Vacant(new) = from.entry(callee) {
                new.insert(Some(function));
                queue.push_back(callee);
            }
        }
    }
    ways
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(name: &str, calls: &[usize], calls_pointers: bool) -> Function {
        let (names, calls) = (vec![name.to_owned()], calls.iter().copied().collect());
        Function { names, calls, calls_pointers, frame: 0 }
    }

    /// Start-up panics; a task and the idle loop call a helper.
    fn graph() -> CallGraph {
        let functions = vec![
            function("Reset", &[1, 2], false),
            function("firmware::board::init", &[5], false),
            function(IDLE, &[4], false),
            function("EXTI4", &[4], false),
            function("helper", &[], false),
            function("core::option::unwrap_failed", &[6], false),
            function("core::panicking::panic_fmt", &[], false),
        ];
        CallGraph::of(functions, [3])
    }

    #[test]
    fn start_up_may_panic() {
        assert!(check(&graph()).is_ok());
        assert_eq!(reachable(&graph()), 3);
    }

    #[test]
    fn a_panic_behind_a_task_is_named_with_the_way_to_it() {
        let mut graph = graph();
        graph.functions[4].calls.insert(5);
        let error = check(&graph).expect_err("the helper panics").to_string();
        assert!(error.ends_with("firmware::app::idle → helper → core::option::unwrap_failed"), "{error}");
        graph.functions[2].calls.clear();
        let error = check(&graph).expect_err("the helper panics").to_string();
        assert!(error.ends_with(": EXTI4 → helper → core::option::unwrap_failed"), "{error}");
    }

    #[test]
    fn a_call_by_pointer_may_lead_to_whatever_has_its_address_taken() {
        let mut graph = graph();
        graph.functions[4].calls_pointers = true;
        assert!(check(&graph).is_ok());
        graph.pointed.insert(1);
        let error = check(&graph).expect_err("init is pointed at, and panics").to_string();
        assert!(error.ends_with("helper → firmware::board::init → core::option::unwrap_failed"), "{error}");
    }

    #[test]
    fn an_image_whose_panics_have_other_names_is_not_believed() {
        let mut graph = graph();
        for function in &mut graph.functions[5..] {
            function.names = vec!["other".to_owned()];
        }
        assert!(check(&graph).is_err_and(|error| error.to_string().contains("nothing is checked")));
    }
}
