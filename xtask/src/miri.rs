//! The unit tests of what the board runs, in an interpreter that knows what Rust does not define.
//!
//! There is no `unsafe` in these crates; their libraries have some. Long tests are left out, each with its reason.

use crate::{install, shell};
use anyhow::Result;

pub fn run() -> Result<()> {
    install::nightly(&["miri", "rust-src"])?;
    let mut miri = install::on_nightly();
    miri.args(["cargo", "miri", "test", "-p", "dr-core", "-p", "wire", "--lib"]);
    miri.arg("--target-dir").arg(shell::target_directory()?.join("miri"));
    shell::run(&mut miri)
}
