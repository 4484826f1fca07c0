//! What libFuzzer has found of a target, hundreds of small inputs, as one file that a clone brings
//! along.

use crate::shell;
use anyhow::{Context, Result};
use flate2::read::GzDecoder;
use flate2::{Compression, GzBuilder};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Where it is.
pub fn archive(target: &str) -> PathBuf {
    shell::root().join("tools/fuzz/found").join(format!("{target}.tar.gz"))
}

/// Adds what an archive holds to a folder; nothing if there is no archive yet.
pub fn unpack(archive: &Path, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    if !archive.exists() {
        return Ok(());
    }
    let file = File::open(archive).with_context(|| archive.display().to_string())?;
    tar::Archive::new(GzDecoder::new(file)).unpack(folder).with_context(|| archive.display().to_string())
}

/// Packs inputs in the order of their names, without times or owners: the same inputs are the same
/// bytes. Gives how many those are.
pub fn pack(inputs: &[PathBuf], archive: &Path) -> Result<u64> {
    let folder = archive.parent().context("an archive lies in a folder")?;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let beside = archive.with_extension("part");
    let write = || -> Result<()> {
        let file = File::create(&beside)?;
        let mut builder = tar::Builder::new(GzBuilder::new().write(file, Compression::best()));
        builder.mode(tar::HeaderMode::Deterministic);
        for path in inputs {
            builder.append_path_with_name(path, path.file_name().context("an input has a name")?)?;
        }
        builder.into_inner()?.finish()?.sync_all()?;
        Ok(())
    };
    write().with_context(|| beside.display().to_string())?;
    std::fs::rename(&beside, archive).with_context(|| archive.display().to_string())?;
    Ok(std::fs::metadata(archive)?.len())
}

#[cfg(test)]
mod tests {
    use super::super::files;
    use super::*;

    #[test]
    fn what_is_packed_is_unpacked_and_the_same_inputs_are_the_same_bytes() {
        let folder = std::env::temp_dir().join(format!("anemo-found-{}", std::process::id()));
        let (from, to) = (folder.join("from"), folder.join("to"));
        std::fs::create_dir_all(&from).expect("there is room for temporary files");
        for (name, input) in [("b", &b"\x00\xff"[..]), ("a", b"")] {
            std::fs::write(from.join(name), input).expect("there is room for temporary files");
        }
        let inputs = files(&from).expect("they have been written");
        let archive = folder.join("packed/t.tar.gz");
        pack(&inputs, &archive).expect("they can be packed");
        let first = std::fs::read(&archive).expect("it has been written");
        pack(&inputs, &archive).expect("they can be packed");
        assert_eq!(std::fs::read(&archive).expect("it has been written"), first);

        unpack(&archive, &to).expect("it can be unpacked");
        unpack(&folder.join("none"), &to).expect("nothing is nothing");
        assert_eq!(files(&to).expect("they are there").len(), 2);
        assert_eq!(std::fs::read(to.join("b")).expect("it is there"), b"\x00\xff");
        assert!(!archive.with_extension("part").exists());
        std::fs::remove_dir_all(folder).expect("it is ours");
    }
}
