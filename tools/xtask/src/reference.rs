//! The pages of the command-line reference and the functions of the Python package, written by
//! `anemo`'s example `interface` from the definition that the help is printed from; and whether
//! those of the project are the same.

use crate::{artefacts, shell};
use anyhow::{Context, Result, bail};
use std::path::Path;

const PAGES: &str = "docs/reference";
const FUNCTIONS: &str = "python/anemo/_commands.py";

#[derive(clap::Args)]
pub struct ReferenceOptions {
    /// Only say whether the pages are up to date
    #[arg(long)]
    check: bool,
}

pub fn run(options: &ReferenceOptions) -> Result<()> {
    let interface = artefacts::interface()?;
    if options.check { check(&interface) } else { each_page(&interface, |page, text| Ok(std::fs::write(page, text)?)) }
}

/// Refuses pages that are not what the example writes now.
pub fn check(interface: &Path) -> Result<()> {
    each_page(interface, |page, text| {
        if std::fs::read_to_string(page).ok().as_deref() != Some(text) {
            bail!("{} is out of date; type: cargo xtask reference", page.display());
        }
        Ok(())
    })
}

fn each_page(interface: &Path, mut with: impl FnMut(&Path, &str) -> Result<()>) -> Result<()> {
    let written = shell::target_directory()?.join("interface");
    shell::run(shell::program(interface).arg(&written))?;
    let functions = std::fs::read_to_string(written.join("_commands.py")).context("_commands.py cannot be read")?;
    with(&shell::root().join(FUNCTIONS), &functions)?;
    let (written, pages) = (written.join("reference"), shell::root().join(PAGES));
    std::fs::create_dir_all(&pages)?;
    for entry in std::fs::read_dir(&written).with_context(|| format!("{} cannot be read", written.display()))? {
        let entry = entry?;
        with(&pages.join(entry.file_name()), &std::fs::read_to_string(entry.path())?)?;
    }
    Ok(())
}
