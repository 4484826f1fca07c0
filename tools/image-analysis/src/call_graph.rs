//! Who calls whom in a linked image, and how much stack each function takes, read from its machine
//! code ([`crate::code`]).
//!
//! An edge is a branch, with or without link, conditional or not, to another function. A call
//! through a register may lead to every function whose address is kept anywhere: as a word in
//! `.rodata` or `.data`, as a constant between the code, or put together by `movw` and `movt`.
//!
//! A function's frame is the sum of all that it takes off the stack pointer, whichever way is gone
//! through it: never less than it takes.
//!
//! Formatting (`core::fmt`) is not among them: words of panics refer to it, and the panic handler
//! does not look at those. That nothing else formats is made sure of here.
//!
//! Limits: an address that is computed in another way (no compiler does that with a function), code
//! that is written as the program runs, and exception entries, which are the caller's business. An
//! instruction that changes the stack pointer in an unknown way and a branch to nowhere are errors,
//! not guesses.

use crate::code::{DecodedInstruction, ImageCode};
use crate::thumb::{Effect, Registers, effect};
use anyhow::{Context, Result, bail};
use std::collections::{BTreeSet, HashMap};

/// A function of the image.
pub struct Function {
    /// Demangled. Equal functions may have been made one, that then has the names of all.
    pub names: Vec<String>,
    /// Functions that it branches to, by their index.
    pub calls: BTreeSet<usize>,
    /// It calls through a register.
    pub calls_pointers: bool,
    /// Bytes of stack.
    pub frame: u32,
}

/// Who calls whom.
pub struct CallGraph {
    /// In the order of their addresses.
    pub functions: Vec<Function>,
    /// Functions whose address is kept anywhere but in the vector table.
    pub pointed: BTreeSet<usize>,
    /// Handlers of the vector table, from the entry behind the reset vector on.
    pub vectors: BTreeSet<usize>,
    /// Values of symbols of the linker.
    addresses: HashMap<String, u32>,
}

impl Function {
    /// One of its names.
    pub fn name(&self) -> &str {
        self.names.first().map_or("?", String::as_str)
    }

    /// Tells whether it writes text, by its name.
    fn formats(&self) -> bool {
        self.names.iter().any(|name| name.contains("core::fmt::") || name.contains("core::panicking::panic_display"))
    }
}

impl CallGraph {
    /// Follows all branches of an image.
    pub fn new(code: ImageCode) -> Result<CallGraph> {
        let starts: Vec<u32> = code.functions.iter().map(|function| function.addresses.start).collect();
        let inside = |address: u32| {
            let i = starts.partition_point(|start| *start <= address).checked_sub(1)?;
            code.functions[i].addresses.contains(&address).then_some(i)
        };
        // With the Thumb bit, as addresses of functions are kept.
        let pointer = |word: &u32| starts.binary_search(&(word & !1)).ok().filter(|_| word & 1 == 1);

        let mut pointed: BTreeSet<usize> = code.data.iter().filter_map(pointer).collect();
        let mut functions = Vec::new();
        for own in &code.functions {
            pointed.extend(own.constants().filter_map(|word| pointer(&word)));
            let mut function =
                Function { names: own.names.clone(), calls: BTreeSet::new(), calls_pointers: false, frame: 0 };
            for stretch in &own.stretches {
                let mut registers = Registers::default();
                for DecodedInstruction { address, mnemonic, operands, .. } in stretch {
                    let place = || format!("{} at {address:#x}: `{mnemonic} {operands}`", function.name());
                    match effect(mnemonic, operands, &mut registers).with_context(place)? {
                        Effect::Nothing => {}
                        Effect::Word(word) => pointed.extend(pointer(&word)),
                        Effect::Stack(bytes) => function.frame += bytes,
                        Effect::Pointer => function.calls_pointers = true,
                        // Within the function it is a loop or a decision.
                        Effect::Jump(target) if own.addresses.contains(&target) => {}
                        Effect::Branch(target) | Effect::Jump(target) => {
                            let callee = inside(target).with_context(|| format!("{} leads to no function", place()))?;
                            function.calls.insert(callee);
                        }
                    }
                }
            }
            functions.push(function);
        }
        if let Some(writer) =
            functions.iter().find(|f| !f.formats() && f.calls.iter().any(|&to| functions[to].formats()))
        {
            bail!("{} formats: then calls by pointer may lead to formatting, which is not followed", writer.name());
        }
        pointed.retain(|&function| !functions[function].formats());
        let vectors = code.vectors.iter().skip(2).filter_map(pointer).collect();
        Ok(CallGraph { functions, pointed, vectors, addresses: code.symbols })
    }

    /// A graph made by hand.
    #[cfg(test)]
    pub fn of(functions: Vec<Function>, vectors: impl IntoIterator<Item = usize>) -> CallGraph {
        let (pointed, vectors) = (BTreeSet::new(), vectors.into_iter().collect());
        CallGraph { functions, pointed, vectors, addresses: HashMap::new() }
    }

    /// A function by its whole name.
    pub fn function(&self, name: &str) -> Option<usize> {
        self.functions.iter().position(|function| function.names.iter().any(|own| own == name))
    }

    /// Where the linker has put a symbol that is no function.
    pub fn address(&self, name: &str) -> Option<u32> {
        self.addresses.get(name).copied()
    }

    /// Whatever a function may call.
    pub fn callees(&self, function: usize) -> impl Iterator<Item = usize> + '_ {
        let function = &self.functions[function];
        let pointed = function.calls_pointers.then_some(&self.pointed);
        function.calls.iter().chain(pointed.into_iter().flatten()).copied()
    }
}
