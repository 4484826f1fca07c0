//! Measured records of other people's rigs, for tests. They are no part of the repository, but may
//! stand in a folder `shared/data` next to it.

use std::path::{Path, PathBuf};

/// Environment variable that names the folder. `cargo xtask` sets it where the folder exists.
pub const SHARED_DATA: &str = "ANEMO_SHARED_DATA";

/// Path of a file or folder of the measured records. `None`, with a note in the test's output,
/// where this computer has no such records.
///
/// # Panics
/// Where records exist, but not this one.
pub fn shared_data(name: &str) -> Option<PathBuf> {
    let named = std::env::var_os(SHARED_DATA).map(PathBuf::from);
    let Some(folder) = named.or_else(|| beside(Path::new(env!("CARGO_MANIFEST_DIR")))) else {
        println!("skipped: no measured records beside the repository");
        return None;
    };
    let path = folder.join(name);
    assert!(path.exists(), "{} is absent: give the whole folder, or none", path.display());
    Some(path)
}

/// The folder next to the first directory above that has one.
fn beside(start: &Path) -> Option<PathBuf> {
    start.ancestors().map(|above| above.join("shared/data")).find(|folder| folder.is_dir())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_is_found_from_any_depth() {
        let root = tempfile::tempdir().unwrap();
        let deep = root.path().join("repository/crates/one");
        std::fs::create_dir_all(&deep).unwrap();
        assert_eq!(beside(&deep).filter(|found| found.starts_with(root.path())), None);
        let data = root.path().join("shared/data");
        std::fs::create_dir_all(&data).unwrap();
        assert_eq!(beside(&deep), Some(data));
    }
}
