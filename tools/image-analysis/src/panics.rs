//! No panic in what runs after start-up, shown on the linked image.
//!
//! Source that does not panic proves little: indices, divisions and whole libraries bring panics
//! that no one has written. In the image they are calls of functions of `core::panicking`. From
//! everything that an interrupt, an exception or the idle loop can reach there must be no way to
//! one of them. Start-up may panic: no heater has been raised yet, and the board starts anew.
//!
//! Limits: whatever [`crate::call_graph`] does not, and code that stops without a panic (an endless
//! loop, a fault; the watchdog and the fault handler are for those).

use crate::call_graph::{CallGraph, Function};
use anyhow::{Result, bail};
use std::collections::BTreeSet;

/// Rules that are known of an image beforehand.
pub struct Rules<'a> {
    /// The idle loop: what runs before it is start-up.
    pub idle: &'a str,
    /// Functions whose panics are known not to happen, and why. Their other calls count.
    pub allowed: &'a [(&'a str, &'a str)],
}

/// Findings on panics.
#[derive(Debug, Default)]
pub struct PanicFindings {
    /// Exceptions that were made use of, with their reasons.
    pub exceptions: Vec<String>,
    /// Every way from what runs after start-up to a panic, one for each function that panics.
    pub ways: Vec<String>,
    /// Number of functions that can run after start-up.
    pub reachable: usize,
}

/// Where a panic begins.
pub fn is_panic(function: &Function) -> bool {
    is_named_panic(&function.names)
}

/// The same by the function's names.
pub fn is_named_panic(names: &[String]) -> bool {
    names.iter().any(|name| {
        name.starts_with("core::panicking::")
            || name.contains("rust_begin_unwind")
            || name.contains("defmt_panic")
            || name.starts_with("core::") && (name.ends_with("_failed") || name.ends_with("_fail"))
    })
}

/// Looks for panics in what runs after start-up. An image in which nothing could be found is an
/// error.
pub fn find(graph: &CallGraph, rules: &Rules) -> Result<PanicFindings> {
    let Some(idle) = graph.function(rules.idle) else { bail!("the image has no function `{}`", rules.idle) };
    if !graph.functions.iter().any(is_panic) {
        bail!(
            "the image has no panic at all, not even at start-up: their names must have changed, so nothing is checked"
        );
    }
    let starts = || graph.vectors.iter().copied().chain([idle]);
    let ways = ways(graph, starts(), rules.allowed);
    let mut exceptions = Vec::new();
    for (name, why) in rules.allowed {
        if graph.function(name).is_some_and(|function| graph.callees(function).any(|f| is_panic(&graph.functions[f]))) {
            exceptions.push(format!("allowed in {name}: {why}"));
        }
    }
    let reachable = reached(graph, starts(), |_| true).len();
    Ok(PanicFindings { exceptions, ways, reachable })
}

/// Every function that some can reach, in the order of its distance, and the place in this list of
/// one that calls it. Only those callees are followed that `follow` accepts.
fn reached(
    graph: &CallGraph,
    roots: impl Iterator<Item = usize>,
    follow: impl Fn(&usize) -> bool,
) -> Vec<(usize, Option<usize>)> {
    let mut seen: BTreeSet<usize> = roots.collect();
    let mut reached: Vec<_> = seen.iter().map(|&root| (root, None)).collect();
    let mut at = 0;
    while at < reached.len() {
        let new = graph.callees(reached[at].0).filter(&follow).filter(|callee| seen.insert(*callee));
        reached.extend(new.map(|callee| (callee, Some(at))).collect::<Vec<_>>());
        at += 1;
    }
    reached
}

fn ways(graph: &CallGraph, roots: impl Iterator<Item = usize>, allowed: &[(&str, &str)]) -> Vec<String> {
    let name = |function: usize| graph.functions[function].name();
    let panics = |function: &usize| is_panic(&graph.functions[*function]);
    let reached = reached(graph, roots, |callee| !panics(callee));
    let way_to = |&(function, caller): &(usize, Option<usize>)| {
        let panic = graph.callees(function).find(panics)?;
        let mut way = vec![name(panic), name(function)];
        let mut at = caller;
        while let Some((function, caller)) = at.map(|at| reached[at]) {
            way.push(name(function));
            at = caller;
        }
        way.reverse();
        Some(way.join(" → "))
    };
    let is_allowed = |function: usize| allowed.iter().any(|(allowed, _)| *allowed == name(function));
    reached.iter().filter(|(function, _)| !is_allowed(*function)).filter_map(way_to).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDLE: &str = "firmware::app::idle";

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

    fn found(graph: &CallGraph) -> PanicFindings {
        find(graph, &Rules { idle: IDLE, allowed: &[] }).expect("there are panics, and an idle loop")
    }

    #[test]
    fn start_up_may_panic() {
        let found = found(&graph());
        assert!(found.ways.is_empty());
        assert_eq!(found.reachable, 3);
    }

    #[test]
    fn a_panic_behind_a_task_is_named_with_the_way_to_it() {
        let mut graph = graph();
        graph.functions[4].calls.insert(5);
        assert_eq!(found(&graph).ways, ["firmware::app::idle → helper → core::option::unwrap_failed"]);
        graph.functions[2].calls.clear();
        assert_eq!(found(&graph).ways, ["EXTI4 → helper → core::option::unwrap_failed"]);
    }

    #[test]
    fn an_exception_is_reported_with_its_reason_and_counts_for_what_it_names_only() {
        let mut graph = graph();
        graph.functions[4].calls.insert(5);
        let rules = Rules { idle: IDLE, allowed: &[("helper", "it is known")] };
        let allowed = find(&graph, &rules).expect("there are panics, and an idle loop");
        assert!(allowed.ways.is_empty());
        assert_eq!(allowed.exceptions, ["allowed in helper: it is known"]);
    }

    #[test]
    fn a_call_by_pointer_may_lead_to_whatever_has_its_address_taken() {
        let mut graph = graph();
        graph.functions[4].calls_pointers = true;
        assert!(found(&graph).ways.is_empty());
        graph.pointed.insert(1);
        let ways = found(&graph).ways;
        assert!(ways[0].ends_with("helper → firmware::board::init → core::option::unwrap_failed"), "{ways:?}");
    }

    #[test]
    fn an_image_whose_panics_have_other_names_is_not_believed() {
        let mut graph = graph();
        for function in &mut graph.functions[5..] {
            function.names = vec!["other".to_owned()];
        }
        let outcome = find(&graph, &Rules { idle: IDLE, allowed: &[] });
        assert!(outcome.is_err_and(|error| error.to_string().contains("nothing is checked")));
    }
}
