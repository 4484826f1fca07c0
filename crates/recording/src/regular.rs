//! Opening files whose end is known: neither a pipe, which would be waited for, nor a device such
//! as `/dev/zero`, which would fill the memory.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Text files that the project reads have some kilobytes; what is larger is another file.
const MOST_TEXT_BYTES: u64 = 64 << 20;

/// Opens a regular file to be read.
///
/// # Errors
/// If there is none, or it is of another kind.
pub fn open(path: &Path) -> io::Result<File> {
    // Asked before it is opened, for which a pipe without a writer would wait.
    let metadata = path.metadata()?;
    if metadata.is_dir() {
        return Err(io::Error::other("it is a folder"));
    }
    if !metadata.is_file() {
        return Err(io::Error::other("it is a pipe or a device, and only regular files are read"));
    }
    File::open(path)
}

/// Reads the text of a regular file, or of one in memory.
///
/// # Errors
/// As [`open`]; `InvalidData` for what is no text in UTF-8; or if it has more than 64 MiB.
pub fn read_text(path: &Path) -> io::Result<String> {
    if let Some(text) = crate::in_memory::text(path) {
        return Ok(text);
    }
    let mut text = String::new();
    open(path)?.take(MOST_TEXT_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MOST_TEXT_BYTES {
        return Err(io::Error::other(format!("it has more than {} MiB, too many for a text", MOST_TEXT_BYTES >> 20)));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_regular_file_is_named_and_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |path: &Path| read_text(path).unwrap_err().to_string();
        assert_eq!(refused(folder.path()), "it is a folder");
        assert_eq!(read_text(&folder.path().join("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
        let path = folder.path().join("text");
        std::fs::write(&path, "a").unwrap();
        assert_eq!(read_text(&path).unwrap(), "a");
        std::fs::write(&path, [0xff]).unwrap();
        assert_eq!(read_text(&path).unwrap_err().kind(), io::ErrorKind::InvalidData);
        // A hole takes no room on the disk.
        File::create(&path).unwrap().set_len(MOST_TEXT_BYTES + 1).unwrap();
        assert!(refused(&path).contains("more than 64 MiB"));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_not_read() {
        assert!(read_text(Path::new("/dev/zero")).unwrap_err().to_string().contains("a pipe or a device"));
    }
}
