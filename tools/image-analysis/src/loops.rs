//! Longest path through the blocks of a function, each loop with a bound.
//!
//! ```text
//! path to a block in a loop = path to the head + (bound − 1) · longest round + path from the head
//! ```
//!
//! Loops are the strongly connected parts of the graph. The head is the first node at which a part
//! is entered; a path that enters elsewhere comes by the head or ends before.

use anyhow::{Result, bail};
use std::collections::{BTreeMap, BTreeSet};

/// A graph with costs, entered at node 0.
#[derive(Debug, Default)]
pub struct CostGraph {
    /// Cost of each node.
    pub costs: Vec<u64>,
    /// Edges of each node, with their costs.
    pub next: Vec<Vec<(usize, u64)>>,
    /// Nodes at which a path may end.
    pub ends: BTreeSet<usize>,
}

/// Limit of a loop each time that it is entered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Limit {
    /// How often its head is executed at most.
    pub rounds: u64,
    /// Cycles on top: of a loop that waits for a time.
    pub cycles: u64,
    /// Loops of one group are one loop of the source with several ways back, which the compiler has
    /// nested: their rounds count together.
    pub group: Option<usize>,
    /// Counts passes through some nodes instead of rounds.
    pub passes: Option<Passes>,
}

/// Passes through some nodes of a loop.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Passes {
    /// Those nodes, in ascending order.
    pub through: Vec<usize>,
    /// How often a path passes through them at most.
    pub times: u64,
    /// Nodes that it does not take after the last pass.
    pub omitted: Vec<usize>,
}

/// A loop of a graph.
pub struct Loop<'a> {
    /// The node at which it is entered.
    pub head: usize,
    /// All nodes of it, in ascending order.
    pub nodes: &'a [usize],
}

impl CostGraph {
    /// The longest path from the entry to an end; none if no path ends. `bound` limits a loop.
    pub fn longest(&self, bound: &mut dyn FnMut(&Loop) -> Result<Limit>) -> Result<Option<u64>> {
        let alive = self.alive();
        if !alive[0] {
            return Ok(None);
        }
        let nodes: Vec<usize> = (0..self.costs.len()).filter(|&node| alive[node]).collect();
        let distances = Walk { graph: self, groups: Vec::new(), bound }.region(&nodes, &Distances::from([(0, 0)]))?;
        Ok(self.ends.iter().filter_map(|end| distances.get(end).copied()).max())
    }

    /// Nodes that are reached and from which an end is.
    fn alive(&self) -> Vec<bool> {
        let mut reached = vec![false; self.costs.len()];
        let mut waiting = vec![0];
        while let Some(node) = waiting.pop() {
            if !std::mem::replace(&mut reached[node], true) {
                waiting.extend(self.next[node].iter().map(|(to, _)| *to));
            }
        }
        let mut alive = vec![false; self.costs.len()];
        for &end in &self.ends {
            alive[end] = reached[end];
        }
        loop {
            let more: Vec<usize> = (0..alive.len())
                .filter(|&node| reached[node] && !alive[node] && self.next[node].iter().any(|(to, _)| alive[*to]))
                .collect();
            if more.is_empty() {
                return alive;
            }
            more.into_iter().for_each(|node| alive[node] = true);
        }
    }
}

struct Walk<'a> {
    graph: &'a CostGraph,
    /// Groups whose loops are being walked, with the longest round of inner ones.
    groups: Vec<(usize, u64)>,
    bound: &'a mut dyn FnMut(&Loop) -> Result<Limit>,
}

/// Longest paths to nodes: up to their beginning, or up to their end.
type Distances = BTreeMap<usize, u64>;

impl Walk<'_> {
    /// Longest paths to the ends of all nodes of a region that is entered at some nodes.
    fn region(&mut self, nodes: &[usize], entries: &Distances) -> Result<Distances> {
        let next = |from: usize| {
            self.graph.next[from].iter().map(|(to, _)| *to).filter(|to| nodes.binary_search(to).is_ok()).collect()
        };
        let mut ends = Distances::new();
        let parts = components(nodes, &next);
        // Each comes after all that it leads to.
        for part in parts.iter().rev() {
            let mut begins = self.arrivals(&ends, part);
            for (&node, &before) in entries.iter().filter(|(node, _)| part.binary_search(node).is_ok()) {
                raise(&mut begins, node, before);
            }
            let is_loop = part.len() > 1 || self.graph.next[part[0]].iter().any(|(to, _)| *to == part[0]);
            match begins.first_key_value() {
                None => {}
                Some((&node, before)) if !is_loop => drop(ends.insert(node, before + self.graph.costs[node])),
                Some(_) => ends.extend(self.rounds(part, &begins)?),
            }
        }
        Ok(ends)
    }

    /// The same of a loop. Paths that have not come by its head come first, then rounds from it.
    fn rounds(&mut self, part: &[usize], begins: &Distances) -> Result<Distances> {
        let Some((&head, _)) = begins.first_key_value() else { return Ok(Distances::new()) };
        let mut limit = (self.bound)(&Loop { head, nodes: part })?;
        if let Some(passes) = limit.passes {
            return self.passes(head, part, begins, &passes);
        }
        let outer = self.groups.iter().position(|(group, _)| Some(*group) == limit.group);
        if let (Some(group), None) = (limit.group, outer) {
            self.groups.push((group, 0));
        }
        let rest: Vec<usize> = part.iter().copied().filter(|&node| node != head).collect();
        let mut others = begins.clone();
        let direct = others.remove(&head).unwrap_or(0);
        let mut ends = self.region(&rest, &others)?;
        let before = self.arrivals(&ends, &[head]).get(&head).copied().unwrap_or(0).max(direct);
        let mut round = Distances::from([(head, self.graph.costs[head])]);
        let from_head = self.arrivals(&round, &rest);
        round.extend(self.region(&rest, &from_head)?);
        let mut longest = self.arrivals(&round, &[head]).get(&head).copied().unwrap_or(0);
        if let Some(outer) = outer {
            limit.rounds = 1;
            self.groups[outer].1 = longest.max(self.groups[outer].1);
        } else if limit.group.is_some() {
            longest = longest.max(self.groups.pop().map_or(0, |(_, inner)| inner));
        }
        let rounds = limit.rounds.saturating_sub(1) * longest + limit.cycles;
        for (node, distance) in round {
            raise(&mut ends, node, before + rounds + distance);
        }
        Ok(ends)
    }

    /// The same of a loop whose passes through some nodes are counted.
    fn passes(&mut self, head: usize, part: &[usize], begins: &Distances, passes: &Passes) -> Result<Distances> {
        let without = |nodes: &[usize], omitted: &[usize]| -> Vec<usize> {
            nodes.iter().copied().filter(|node| omitted.binary_search(node).is_err()).collect()
        };
        let rest = without(part, &passes.through);
        self.check_whole(head, &rest, &passes.through)?;
        let last = without(&rest, &passes.omitted);
        let begin_in = |nodes: &[usize]| -> Distances {
            begins.iter().filter(|(node, _)| nodes.binary_search(node).is_ok()).map(|(node, at)| (*node, *at)).collect()
        };
        let mut all = self.region(&rest, &begin_in(&rest))?;
        let mut arrivals = self.arrivals(&all, &passes.through);
        begin_in(&passes.through).into_iter().for_each(|(node, at)| raise(&mut arrivals, node, at));
        for time in 1..=passes.times {
            let inside = self.region(&passes.through, &arrivals)?;
            let after = if time == passes.times { &last } else { &rest };
            let outside = self.region(after, &self.arrivals(&inside, after))?;
            arrivals = self.arrivals(&outside, &passes.through);
            inside.into_iter().chain(outside).for_each(|(node, at)| raise(&mut all, node, at));
        }
        Ok(all)
    }

    /// Makes sure that a path that has left some nodes of a loop comes back to them by the head only:
    /// otherwise one round would count as two passes.
    fn check_whole(&self, head: usize, rest: &[usize], through: &[usize]) -> Result<()> {
        let is_in = |nodes: &[usize], node: usize| nodes.binary_search(&node).is_ok();
        let next = |node: usize| self.graph.next[node].iter().map(|(to, _)| *to).filter(|to| *to != head);
        let mut waiting: Vec<usize> =
            through.iter().flat_map(|&node| next(node)).filter(|to| is_in(rest, *to)).collect();
        let mut seen = BTreeSet::new();
        while let Some(node) = waiting.pop() {
            if seen.insert(node) {
                if let Some(back) = next(node).find(|to| is_in(through, *to)) {
                    bail!("a round passes through what is counted more than once: from block {node} to {back}");
                }
                waiting.extend(next(node).filter(|to| is_in(rest, *to)));
            }
        }
        Ok(())
    }

    /// Longest paths to the beginnings of some nodes, from the ends of others.
    fn arrivals(&self, ends: &Distances, nodes: &[usize]) -> Distances {
        let mut arrivals = Distances::new();
        for (&from, &distance) in ends {
            for &(to, cost) in self.graph.next[from].iter().filter(|(to, _)| nodes.binary_search(to).is_ok()) {
                raise(&mut arrivals, to, distance + cost);
            }
        }
        arrivals
    }
}

fn raise(distances: &mut Distances, node: usize, distance: u64) {
    let longest = distances.entry(node).or_insert(distance);
    *longest = distance.max(*longest);
}

/// Strongly connected components by Tarjan's algorithm, each sorted, in reverse topological order.
fn components(nodes: &[usize], next: &dyn Fn(usize) -> Vec<usize>) -> Vec<Vec<usize>> {
    let size = nodes.last().map_or(0, |last| last + 1);
    let mut tarjan =
        Tarjan { next, index: vec![0; size], low: vec![0; size], on_stack: vec![false; size], ..Tarjan::new(next) };
    for &node in nodes {
        if tarjan.index[node] == 0 {
            tarjan.visit(node);
        }
    }
    tarjan.components
}

struct Tarjan<'a> {
    next: &'a dyn Fn(usize) -> Vec<usize>,
    index: Vec<usize>,
    low: Vec<usize>,
    on_stack: Vec<bool>,
    stack: Vec<usize>,
    count: usize,
    components: Vec<Vec<usize>>,
}

impl<'a> Tarjan<'a> {
    fn new(next: &'a dyn Fn(usize) -> Vec<usize>) -> Self {
        let (index, low, on_stack) = (Vec::new(), Vec::new(), Vec::new());
        Self { next, index, low, on_stack, stack: Vec::new(), count: 0, components: Vec::new() }
    }

    fn visit(&mut self, node: usize) {
        self.count += 1;
        (self.index[node], self.low[node]) = (self.count, self.count);
        self.stack.push(node);
        self.on_stack[node] = true;
        for to in (self.next)(node) {
            if self.index[to] == 0 {
                self.visit(to);
                self.low[node] = self.low[node].min(self.low[to]);
            } else if self.on_stack[to] {
                self.low[node] = self.low[node].min(self.index[to]);
            }
        }
        if self.low[node] == self.index[node] {
            let at = self.stack.iter().rposition(|&other| other == node).unwrap_or(0);
            let mut component = self.stack.split_off(at);
            component.iter().for_each(|&node| self.on_stack[node] = false);
            component.sort_unstable();
            self.components.push(component);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(costs: &[u64], edges: &[(usize, usize)], end: usize) -> CostGraph {
        let mut next = vec![Vec::new(); costs.len()];
        edges.iter().for_each(|&(from, to)| next[from].push((to, 0)));
        CostGraph { costs: costs.to_vec(), next, ends: BTreeSet::from([end]) }
    }

    fn rounds(rounds: u64) -> impl FnMut(&Loop) -> Result<Limit> {
        move |_| Ok(Limit { rounds, ..Limit::default() })
    }

    #[test]
    fn the_longer_branch_counts_and_a_path_without_an_end_does_not() {
        let graph = graph(&[1, 5, 9, 2, 100], &[(0, 1), (0, 2), (1, 3), (2, 3), (0, 4), (4, 4)], 3);
        assert_eq!(graph.longest(&mut rounds(1)).expect("no loop is entered"), Some(12));
        let stuck = CostGraph { ends: BTreeSet::new(), ..graph };
        assert_eq!(stuck.longest(&mut rounds(1)).expect("no loop is entered"), None);
    }

    #[test]
    fn a_loop_costs_its_rounds_and_the_way_out() {
        // 0 → head 1 → body 2 → 1, and out by 3.
        let graph = graph(&[1, 2, 10, 3], &[(0, 1), (1, 2), (2, 1), (1, 3)], 3);
        assert_eq!(graph.longest(&mut rounds(5)).expect("bounded"), Some(1 + 4 * 12 + 2 + 3));
        let mut waits = |_: &Loop| Ok(Limit { rounds: 1, cycles: 300, ..Limit::default() });
        assert_eq!(graph.longest(&mut waits).expect("bounded"), Some(1 + 300 + 2 + 3));
    }

    #[test]
    fn a_loop_in_a_loop_multiplies_unless_both_are_one_of_the_source() {
        // Head 1 of the outer loop, head 2 of the inner one.
        let graph = graph(&[0, 1, 10, 0], &[(0, 1), (1, 2), (2, 2), (2, 1), (1, 3)], 3);
        assert_eq!(graph.longest(&mut rounds(4)).expect("bounded"), Some(3 * (1 + 40) + 1));
        let mut one = |_: &Loop| Ok(Limit { rounds: 4, group: Some(7), ..Limit::default() });
        assert_eq!(graph.longest(&mut one).expect("bounded"), Some(3 * 11 + 1));
    }

    #[test]
    fn a_loop_that_is_entered_twice_has_a_bound_too() {
        let graph = graph(&[0, 5, 7, 0], &[(0, 1), (0, 2), (1, 2), (2, 1), (1, 3)], 3);
        // By 2 to the head 1, then two more rounds.
        assert_eq!(graph.longest(&mut rounds(3)).expect("bounded"), Some(7 + 2 * 12 + 5));
    }

    #[test]
    fn passes_count_wherever_the_loop_is_turned() {
        // `while test { body }` with the test at the head, and the same with the body at the head.
        let of = |edges: &[(usize, usize)]| graph(&[0, 2, 10, 0], edges, 3);
        let mut once = |_: &Loop| {
            let passes = Passes { through: vec![2], times: 1, omitted: Vec::new() };
            Ok(Limit { passes: Some(passes), ..Limit::default() })
        };
        assert_eq!(of(&[(0, 1), (1, 2), (2, 1), (1, 3)]).longest(&mut once).expect("bounded"), Some(2 + 10 + 2));
        assert_eq!(of(&[(0, 2), (2, 1), (1, 2), (1, 3)]).longest(&mut once).expect("bounded"), Some(10 + 2));
        // What counts is left and entered again within a round.
        let torn = graph(&[0, 1, 1, 1, 1, 0], &[(0, 1), (1, 2), (2, 3), (3, 4), (4, 1), (1, 5)], 5);
        let mut torn_bound = |_: &Loop| {
            let passes = Passes { through: vec![2, 4], times: 1, omitted: Vec::new() };
            Ok(Limit { passes: Some(passes), ..Limit::default() })
        };
        let error = torn.longest(&mut torn_bound).expect_err("3 lies between").to_string();
        assert!(error.contains("more than once: from block 3 to 4"), "{error}");
    }
}
