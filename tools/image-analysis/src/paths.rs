//! Longest paths of functions, in cycles at worst, functions that they call included.
//!
//! Every loop needs a bound. A loop is known by the functions of the source that it was inlined
//! from ([`crate::source_places`]). A loop that no bound names is an error that names it.

use crate::code::ImageCode;
use crate::flow::{Block, Call, blocks};
use crate::loops::{CostGraph, Limit, Loop, Passes};
use crate::panics;
use crate::source_places::SourcePlaces;
use anyhow::{Context, Result, bail};
use std::collections::{BTreeMap, HashMap};

/// Memory that instructions are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryModel {
    /// No wait states.
    Immediate,
    /// Every line of flash is waited for, as if the accelerator held none of them: 5 wait states at
    /// 168 MHz (RM0090, "Relation between CPU clock frequency and Flash memory read time").
    FlashMisses,
}

/// Wait states of a line of flash.
const WAIT_STATES: u64 = 5;
/// Refill of the pipeline after a jump, at worst.
const REFILL: u64 = 3;

/// Rounds of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounds {
    /// At most so many.
    AtMost(u64),
    /// At most so many in all loops that this bound fits and that are nested: the function has one
    /// loop, with several ways back.
    InAll(u64),
    /// It waits: as many as fit into so many cycles.
    For(u64),
    /// So many and no further test, and cycles on top.
    Both(u64, u64),
    /// A function of the source is passed through at most so many times, and another is not after
    /// that.
    Passes(&'static str, u64, Option<&'static str>),
    /// An argument of its function is a length (0 for the second, 1 for the third); one round for
    /// each step of so many units.
    Length(usize, u32),
}

/// Last part of the names of functions: none is inlined into the one before.
pub const INNERMOST: &str = "";

/// Bound of the loops of some functions of the source.
#[derive(Clone, Copy, Debug)]
pub struct LoopBound {
    /// Parts of the names of functions that the loop was inlined from, the outermost first.
    pub functions: &'static [&'static str],
    /// Rounds each time that the loop is entered.
    pub rounds: Rounds,
    /// Reason.
    pub why: &'static str,
}

/// Functions, the outermost first, and why they are not executed.
pub type Exclusion<'a> = (&'a [&'a str], &'a str);

/// What is known of a path beforehand.
#[derive(Clone, Copy, Debug)]
pub struct PathRules<'a> {
    /// Bounds of this path alone, before the others.
    pub own: &'a [LoopBound],
    /// Bounds; the first that fits counts.
    pub bounds: &'a [LoopBound],
    /// Lengths of copies that no constant gives: the function of the source that calls, and the
    /// most that it copies.
    pub lengths: &'a [(&'a str, u32)],
    /// Functions of the source that the path does not take, each by parts of the names of those
    /// that call it and its own, with the reason.
    pub excluded: &'a [Exclusion<'a>],
    /// The path ends in this function of the source instead of at the return.
    pub ends_in: Option<&'a str>,
}

/// Finds longest paths.
pub struct Paths<'a, 's> {
    code: &'a ImageCode,
    places: &'a SourcePlaces<'s>,
    rules: PathRules<'a>,
    memory: MemoryModel,
    known: HashMap<(usize, [Option<u32>; 2]), Option<u64>>,
    way: Vec<usize>,
    /// Loops without a bound, by their address.
    unbounded: BTreeMap<u32, String>,
}

impl<'a, 's> Paths<'a, 's> {
    /// Paths through an image.
    pub fn new(code: &'a ImageCode, places: &'a SourcePlaces<'s>, rules: PathRules<'a>, memory: MemoryModel) -> Self {
        let (known, way, unbounded) = (HashMap::new(), Vec::new(), BTreeMap::new());
        Self { code, places, rules, memory, known, way, unbounded }
    }

    /// Cycles of a function, by its whole name, at worst.
    ///
    /// # Errors
    /// A loop without a bound, a call or a branch to an unknown place, recursion.
    pub fn longest(&mut self, name: &str) -> Result<u64> {
        let place = self.code.functions.iter().position(|function| function.names.iter().any(|own| own == name));
        let place = place.with_context(|| format!("the image has no function `{name}`"))?;
        let longest = self.function(place, [None; 2])?;
        if !self.unbounded.is_empty() {
            let loops: Vec<String> =
                self.unbounded.iter().map(|(address, functions)| format!("{address:#x}: {functions}")).collect();
            bail!("{name} has loops without a bound; give each a bound and its reason:\n{}", loops.join("\n"));
        }
        longest.with_context(|| format!("no path of {name} ends"))
    }

    fn function(&mut self, place: usize, arguments: [Option<u32>; 2]) -> Result<Option<u64>> {
        if let Some(known) = self.known.get(&(place, arguments)) {
            return Ok(*known);
        }
        let name = &self.code.functions[place].names[0];
        if self.way.contains(&place) {
            bail!("{name} calls itself, so its path has no bound");
        }
        self.way.push(place);
        let blocks = blocks(&self.code.functions[place]).with_context(|| name.clone())?;
        let chains: Vec<Vec<Vec<String>>> = blocks.iter().map(|block| self.chains(block)).collect();
        let graph = self.graph(&blocks, &chains, arguments).with_context(|| name.clone())?;
        let longest = graph.longest(&mut |of| Ok(self.limit(of, &blocks, &chains, arguments)))?;
        self.way.pop();
        self.known.insert((place, arguments), longest);
        Ok(longest)
    }

    /// Functions of the source in which a block stands: those of its calls, with the functions that
    /// they call, or of all its instructions.
    fn chains(&self, block: &Block) -> Vec<Vec<String>> {
        let chain = |address: u32| self.places.functions(address).iter().map(|(name, _)| name.clone()).collect();
        let of_call = |call: &Call| {
            let mut chain: Vec<String> = chain(call.address);
            chain.extend(self.function_at(call.callee).map(|place| self.code.functions[place].names[0].clone()));
            chain
        };
        match block.calls.is_empty() {
            true => block.addresses.iter().map(|&address| chain(address)).collect(),
            false => block.calls.iter().map(of_call).collect(),
        }
    }

    fn limit(
        &mut self,
        of: &Loop,
        blocks: &[Block],
        chains: &[Vec<Vec<String>>],
        arguments: [Option<u32>; 2],
    ) -> Limit {
        let mut chain = self.places.common(of.nodes.iter().map(|&node| blocks[node].start));
        let callers: Vec<&str> = self.way.iter().map(|&f| self.code.functions[f].names[0].as_str()).collect();
        chain.insert(0, callers.last().map_or(String::new(), |own| (*own).to_owned()));
        let all = self.rules.own.iter().chain(self.rules.bounds).enumerate();
        let found = all.into_iter().find(|(_, bound)| is_in_order(bound.functions, &chain));
        // One that is left before its end has been through its last round by then.
        let mut leaves = of.nodes.iter().filter(|&&node| {
            let next = &blocks[node].next;
            next.iter().all(|(to, _)| *to != of.head) && next.iter().any(|(to, _)| of.nodes.binary_search(to).is_err())
        });
        let once_more = u64::from(leaves.next().is_some());
        let within = |name: &str| -> Vec<usize> {
            let is_within = |&node: &usize| stands_in(&[name], &blocks[node], &chains[node]);
            of.nodes.iter().copied().filter(is_within).collect()
        };
        match found.map(|(place, bound)| (place, bound.rounds)) {
            Some((_, Rounds::AtMost(rounds))) => Limit { rounds: rounds + once_more, ..Limit::default() },
            Some((place, Rounds::InAll(rounds))) => {
                Limit { rounds: rounds + once_more, group: Some(place), ..Limit::default() }
            }
            Some((_, Rounds::For(cycles))) => Limit { rounds: 1 + once_more, cycles, ..Limit::default() },
            Some((_, Rounds::Both(rounds, cycles))) => Limit { rounds, cycles, ..Limit::default() },
            Some((_, Rounds::Length(argument, step))) if let Some(length) = arguments[argument] => {
                Limit { rounds: u64::from(length / step) + 1 + once_more, ..Limit::default() }
            }
            Some((_, Rounds::Passes(name, times, omitted))) if !within(name).is_empty() => {
                let passes = Passes { through: within(name), times, omitted: omitted.map_or(Vec::new(), within) };
                Limit { passes: Some(passes), ..Limit::default() }
            }
            known => {
                let what = if known.is_some() { " (what its bound counts is not known)" } else { "" };
                let sentence = format!("{}{what}, called by {}", chain.join(" → "), callers.join(" → "));
                self.unbounded.insert(blocks[of.head].start, sentence);
                Limit { rounds: 1, ..Limit::default() }
            }
        }
    }

    fn graph(
        &mut self,
        blocks: &[Block],
        chains: &[Vec<Vec<String>>],
        arguments: [Option<u32>; 2],
    ) -> Result<CostGraph> {
        let mut graph = CostGraph::default();
        let is_top = self.way.len() <= 2;
        for ((place, block), chains) in blocks.iter().enumerate().zip(chains) {
            let ends = is_top && self.rules.ends_in.is_some_and(|end| stands_in(&[end], block, chains));
            let is_excluded = self.rules.excluded.iter().any(|(parts, _)| stands_in(parts, block, chains));
            let mut cost = (!is_excluded).then_some(block.cycles);
            if self.memory == MemoryModel::FlashMisses {
                cost = cost.map(|cost| cost + WAIT_STATES * block.lines);
            }
            for call in &block.calls {
                if cost.is_some() {
                    let callee = self.called(call, arguments)?;
                    cost = cost.zip(callee).map(|(cost, callee)| cost + REFILL + callee);
                }
            }
            let next = block.next.iter().map(|&(to, jumps)| (to, if jumps { REFILL } else { 0 })).collect();
            graph.costs.push(cost.unwrap_or(0) + if block.returns { REFILL } else { 0 });
            graph.next.push(if cost.is_some() { next } else { Vec::new() });
            if cost.is_some() && (block.returns || ends) {
                graph.ends.insert(place);
            }
        }
        Ok(graph)
    }

    fn function_at(&self, address: u32) -> Option<usize> {
        self.code.functions.iter().position(|function| function.addresses.contains(&address))
    }

    /// Cycles of a function that is called; none if the call does not come back, or is excluded.
    fn called(&mut self, call: &Call, of_caller: [Option<u32>; 2]) -> Result<Option<u64>> {
        let place = self.function_at(call.callee).context("calls through a register, so its path is not known")?;
        let names = &self.code.functions[place].names;
        if panics::is_named_panic(names) {
            return Ok(None);
        }
        let takes_length = |bound: &LoopBound| {
            matches!(bound.rounds, Rounds::Length(..)) && names.iter().any(|name| name.contains(bound.functions[0]))
        };
        if !self.rules.bounds.iter().any(takes_length) {
            return self.function(place, [None; 2]);
        }
        // One that copies passes on its own length.
        let callers = self.places.functions(call.address);
        let is_caller = |name: &str| callers.iter().any(|(caller, _)| caller.contains(name));
        let longest = self.rules.lengths.iter().find(|(name, _)| is_caller(name)).map(|(_, length)| *length);
        let [a, b] = [0, 1].map(|i| call.arguments[i].or(longest).or(of_caller[i]));
        self.function(place, [a, b])
    }
}

/// Tells whether a block stands in some functions, or calls one: one of its calls, or all of its
/// instructions.
fn stands_in(parts: &[&str], block: &Block, chains: &[Vec<String>]) -> bool {
    match block.calls.is_empty() {
        true => chains.iter().all(|chain| is_in_order(parts, chain)),
        false => chains.iter().any(|chain| is_in_order(parts, chain)),
    }
}

/// Tells whether a name contains a part, or ends with it if that has a `$`.
fn is_named(name: &str, part: &str) -> bool {
    part.strip_suffix('$').map_or_else(|| name.contains(part), |end| name.ends_with(end))
}

/// Tells whether names contain some parts in their order.
fn is_in_order(parts: &[&str], names: &[String]) -> bool {
    let mut names = names.iter();
    let mut is_next = |part: &str| match part {
        INNERMOST => names.next().is_none(),
        part => names.any(|name| is_named(name, part)),
    };
    parts.iter().all(|part| is_next(part))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::tests::function;

    const BOUNDS: &[LoopBound] = &[
        LoopBound { functions: &["counts"], rounds: Rounds::AtMost(4), why: "a test" },
        LoopBound { functions: &["copies"], rounds: Rounds::Length(1, 4), why: "a test" },
    ];

    /// `counts` has a loop, `copies` another by a length; `main` calls both.
    fn code(counter: &str) -> ImageCode {
        let body = |start: u32| {
            vec![
                (start, 2, "subs", "r0, #1"),
                (start + 2, 2, "bne", if start == 0x100 { "#0x100" } else { "#0x200" }),
                (start + 4, 2, "bx", "lr"),
            ]
        };
        let main = [
            (0x300, 2, "push", "{r7, lr}"),
            (0x302, 4, "bl", "#0x100"),
            (0x306, 2, "movs", "r2, #8"),
            (0x308, 4, "bl", "#0x200"),
            (0x30c, 2, "pop", "{r7, pc}"),
        ];
        let functions = vec![
            function(counter, 0x100..0x106, &body(0x100), Vec::new()),
            function("copies", 0x200..0x206, &body(0x200), Vec::new()),
            function("main", 0x300..0x30e, &main, Vec::new()),
        ];
        ImageCode { functions, data: Vec::new(), vectors: Vec::new(), symbols: HashMap::new() }
    }

    fn longest(code: &ImageCode, excluded: &[Exclusion], memory: MemoryModel) -> Result<u64> {
        let places = SourcePlaces::empty();
        let rules = PathRules { own: &[], bounds: BOUNDS, lengths: &[], excluded, ends_in: None };
        Paths::new(code, &places, rules, memory).longest("main")
    }

    #[test]
    fn a_path_has_its_loops_calls_and_refills() {
        // A round: subs 1, bne 1, refill 3. Four rounds, the last one without refill; bx 1 and refill.
        let counts = 3 * 5 + 2 + 4;
        // Eight units, four a round, and one more for what is left.
        let copies = 2 * 5 + 2 + 4;
        // push 3, two bl of 1 with refill, movs 1, pop 3 with refill.
        let main = 3 + 2 * 4 + 1 + 3 + 3;
        let code = code("counts");
        assert_eq!(longest(&code, &[], MemoryModel::Immediate).expect("bounded"), main + counts + copies);
        // A line for each block: two a round and two after it, and one of `main`.
        let lines = |rounds: u64| rounds + 1;
        let waits = 5 * (lines(4) + lines(3) + 1);
        assert_eq!(longest(&code, &[], MemoryModel::FlashMisses).expect("bounded"), main + counts + copies + waits);
    }

    #[test]
    fn a_loop_without_a_bound_is_an_error_that_names_it() {
        let error = longest(&code("other"), &[], MemoryModel::Immediate).expect_err("it has no bound").to_string();
        assert!(error.contains("0x100: other, called by main → other"), "{error}");
    }

    #[test]
    fn a_path_that_is_excluded_everywhere_does_not_end() {
        let excluded: &[Exclusion] = &[(&["copies"], "a test")];
        let error = longest(&code("counts"), excluded, MemoryModel::Immediate).expect_err("it is called").to_string();
        assert!(error.contains("no path of main ends"), "{error}");
    }
}
