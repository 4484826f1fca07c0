//! Chains of commands that take minutes: `cargo xtask ci` runs them.

mod alternation;
mod examples;
#[expect(dead_code, reason = "shared with the quicker tests of the command")]
#[path = "../command/process.rs"]
mod process;
