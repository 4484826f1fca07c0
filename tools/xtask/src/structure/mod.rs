//! What must hold of the shape of the code, checked by reading it: no circles of imports, no type
//! name twice, typed errors, each dependency where it belongs, comments that fit a page.
//!
//! Tests are left out of the first three. Whatever is allowed stands as a list, with its reasons,
//! on top of the check's own file.

mod circles;
mod comments;
mod dependencies;
mod error_types;
mod modules;
mod parsed;
mod type_names;

use crate::shell;
use crate::sources;
use anyhow::{Result, bail};
use parsed::ParsedFile;

pub fn run() -> Result<()> {
    let files = sources::rust_files(&shell::root())?;
    let parsed = files.iter().filter(|file| file.is_in_a_crate()).map(ParsedFile::parse).collect::<Result<Vec<_>>>()?;
    let mut faults = 0;
    let mut report = |what: &str, found: Vec<String>| {
        println!("  {what:<64} {:>5}", found.len());
        found.iter().for_each(|fault| println!("    {fault}"));
        faults += found.len();
    };
    shell::announce("structure");
    report("circles of imports between the files of a crate", circles::find(&parsed));
    report("type names that stand in more than one file", type_names::find(&parsed));
    report("errors of libraries that are texts", error_types::find(&parsed));
    report("crates and dependencies that are not as listed", dependencies::find()?);
    report("comment lines that are too long", comments::find(&files));
    if faults > 0 {
        bail!("{faults} faults of structure; what to do stands above");
    }
    Ok(())
}
