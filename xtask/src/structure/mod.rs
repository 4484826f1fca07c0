//! What must hold of the shape of the code: no circles of imports between the files of a crate.
//! Tests are left out.

mod circles;
mod modules;
mod parsed;

use crate::{shell, sources};
use anyhow::{Result, bail};
use parsed::ParsedFile;

pub fn run() -> Result<()> {
    shell::announce("circles of imports between the files of a crate");
    let files = sources::rust_files(&shell::root())?;
    let parsed = files.iter().filter(|file| file.is_in_a_crate()).map(ParsedFile::parse).collect::<Result<Vec<_>>>()?;
    let circles = circles::find(&parsed);
    if !circles.is_empty() {
        bail!("{}", circles.join("\n"));
    }
    Ok(())
}
