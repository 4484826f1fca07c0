//! The pictures of `docs/images`: the gallery's commands make them anew, to the byte.

use crate::shell;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

pub const PAGE: &str = "docs/gallery.md";

fn kept(name: &str) -> PathBuf {
    shell::root().join("docs/images").join(name)
}

/// Pictures in the page's folder that are not those of `docs/images`. Pictures that the page shows
/// and does not make are faults.
pub fn compare(text: &str, folder: &Path, faults: &mut Vec<String>) -> Result<Vec<PathBuf>> {
    for name in text.split("](images/").skip(1).filter_map(|rest| rest.split(')').next()) {
        if !folder.join(name).is_file() {
            faults.push(format!("{PAGE}: no command makes {name}, which is shown"));
        }
    }
    let mut changed = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| format!("{} cannot be listed", folder.display()))? {
        let made = entry?.path();
        if made.extension().is_some_and(|extension| extension == "svg") {
            let name = made.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if std::fs::read(kept(&name)).ok() != Some(std::fs::read(&made)?) {
                changed.push(made);
            }
        }
    }
    Ok(changed)
}

/// Puts pictures in the place of those of `docs/images`.
pub fn replace(pictures: &[PathBuf]) -> Result<()> {
    for made in pictures {
        let name = made.file_name().unwrap_or_default().to_string_lossy().into_owned();
        std::fs::copy(made, kept(&name)).with_context(|| format!("docs/images/{name} cannot be written"))?;
    }
    Ok(())
}
