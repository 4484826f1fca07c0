//! Folders and emulators that programs have left which were killed. The next one clears them.
//!
//! Each folder has a file that its owner holds locked; the system lets go of the lock as the owner
//! ends, however it does.

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::fs::File;
use std::io;
use std::path::Path;

/// How the folders' names begin.
pub(super) const PREFIX: &str = "anemo-qemu-";
const OWNER: &str = "owner.lock";
const EMULATOR: &str = "emulator.pid";

/// Makes a folder one's own, for as long as the file is kept open.
pub(super) fn own(folder: &Path) -> io::Result<File> {
    // Under its name it is locked from the first moment.
    let hidden = folder.join("owner.new");
    let lock = File::create(&hidden)?;
    lock.try_lock().map_err(io::Error::other)?;
    std::fs::rename(hidden, folder.join(OWNER))?;
    Ok(lock)
}

/// Notes which process is the folder's emulator.
pub(super) fn note_emulator(folder: &Path, process: u32) -> io::Result<()> {
    std::fs::write(folder.join(EMULATOR), process.to_string())
}

/// Ends emulators and removes folders whose owners have ended.
pub(super) fn clear() {
    for entry in std::fs::read_dir(std::env::temp_dir()).into_iter().flatten().flatten() {
        let folder = entry.path();
        if !entry.file_name().to_string_lossy().starts_with(PREFIX) {
            continue;
        }
        let Ok(lock) = File::open(folder.join(OWNER)) else { continue };
        if lock.try_lock().is_err() {
            continue;
        }
        let process = std::fs::read_to_string(folder.join(EMULATOR)).ok().and_then(|text| text.parse::<i32>().ok());
        // Its number may be another's by now, which works elsewhere.
        if let Some(process) = process
            && std::fs::read_link(format!("/proc/{process}/cwd")).is_ok_and(|works_in| works_in == folder)
        {
            let _ = kill(Pid::from_raw(process), Signal::SIGKILL);
        }
        let _ = std::fs::remove_dir_all(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};
    use std::time::Duration;

    #[test]
    fn a_folder_is_cleared_with_its_emulator_once_its_owner_has_ended() {
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir().unwrap();
        let path = folder.path().canonicalize().unwrap();
        let lock = own(&path).unwrap();
        let mut emulator = Command::new("sleep").arg("600").current_dir(&path).stdin(Stdio::null()).spawn().unwrap();
        note_emulator(&path, emulator.id()).unwrap();
        clear();
        assert!(path.is_dir() && emulator.try_wait().unwrap().is_none());
        drop(lock);
        // A process that another test starts just now shares the lock until it has become its
        // program.
        for _ in 0..100 {
            clear();
            if !path.exists() {
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        assert!(!path.exists());
        assert!(!emulator.wait().unwrap().success());
    }
}
