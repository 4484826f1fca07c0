//! Inputs of every reader of foreign bytes, and what has to hold whatever they are.
//!
//! | target | bytes are | holds |
//! |---|---|---|
//! | [`frame`] | what comes over a link | each frame is taken or counted; what is taken comes out again, and fits into a frame |
//! | [`command`] | commands and readings, one after the other | the invariant of the heaters after every tick; what is refused changes nothing |
//! | [`settings`] | a record or a file of settings | settings that are read are stored and read as the same |
//! | [`flash`] | records that are written, then damage to the flash | settings are found that were stored, or it is named why not |
//! | [`record`] | a recording as CSV or Parquet | numbers that agree with the survey |
//! | [`model`] | a model's JSON | what is read is written and read as the same; it can be run, drawn, exported |
//! | [`head`] | a head, or the models of its elements | a controller takes its elements; what is kept of it is read as the same |
//! | [`experiment`] | an experiment | it can be set up, or one sentence says why not |
//!
//! And whatever is refused is refused in one sentence. Each target says whether it has taken
//! anything at all.
//!
//! The same functions serve twice. `--test all fuzz::` gives them the corpus (`tools/fuzz/corpus/`), a
//! fixed number of damaged copies of it, and what libFuzzer once found (`tools/fuzz/found/`), in a few
//! seconds; `cargo xtask fuzz` lets libFuzzer look for new inputs for as long as one likes, and
//! keeps them there.

mod bytes;
pub mod command;
pub mod damage;
pub mod experiment;
pub mod flash;
pub mod frame;
pub mod head;
pub mod model;
pub mod record;
mod sentences;
pub mod settings;
pub mod watched;

/// One of the targets.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// The name of its corpus, and of its program in `tools/fuzz/fuzz_targets/`.
    pub name: &'static str,
    /// Panics if something does not hold; says whether anything was taken.
    pub run: fn(&[u8]) -> bool,
}

/// All of them.
pub const TARGETS: [Target; 8] = [
    Target { name: "command", run: command::run },
    Target { name: "experiment", run: experiment::run },
    Target { name: "flash", run: flash::run },
    Target { name: "frame", run: frame::run },
    Target { name: "head", run: head::run },
    Target { name: "model", run: model::run },
    Target { name: "record", run: record::run },
    Target { name: "settings", run: settings::run },
];
