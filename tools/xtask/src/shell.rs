//! Running other programs: where, with what announced, and what is said when they fail.

use anyhow::{Context, Result, bail};
use std::ffi::OsStr;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, ExitStatus, Stdio};

/// The workspace's root directory, where every program is started.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).map(Path::to_path_buf).unwrap_or_default()
}

/// A program that starts in the workspace's root.
pub fn program(name: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(name);
    command.current_dir(root());
    command
}

/// Exit code of [`limited`] for a program that it has stopped.
pub const TIMED_OUT: i32 = 124;

/// A program that is stopped, with all that it has started, after so many seconds.
pub fn limited(limit_s: u32, name: impl AsRef<OsStr>) -> Command {
    let mut command = program("timeout");
    command.args(["--kill-after=10", &limit_s.to_string()]).arg(name);
    command
}

/// The cargo that runs this crate.
///
/// `RUSTFLAGS` are taken away: they would replace the flags of `.cargo/config.toml`, and with them
/// the firmware's core and linker script.
pub fn cargo() -> Command {
    let mut command = program(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
    // Cargo has described this crate: build scripts that look at it would take a job for another
    // than the same by hand, and build anew.
    let said = std::env::vars_os().map(|(name, _)| name);
    for name in
        said.filter(|name| ["CARGO_PKG_", "CARGO_MANIFEST_"].iter().any(|of| name.to_string_lossy().starts_with(of)))
    {
        command.env_remove(name);
    }
    command
}

/// A job of cargo for the whole workspace, so that nothing is compiled twice. Without the Python
/// package, which has Python's tests.
pub fn cargo_of_all(job: &str) -> Command {
    let mut cargo = cargo();
    cargo.args([job, "--release", "--workspace", "--exclude", "anemo-python"]);
    cargo
}

/// Where cargo puts what it builds.
pub fn target_directory() -> Result<PathBuf> {
    // Cargo puts this program into a folder named by its profile, in there.
    let own = std::env::current_exe().context("this program's own path is not known")?;
    let target = own.ancestors().nth(2).context("this program does not lie in a target directory")?;
    Ok(target.to_path_buf())
}

/// Says in one line what is done next.
pub fn announce(what: &str) {
    eprintln!("── {what}");
}

/// Runs to the end with this terminal's output; a failure names the command line.
pub fn run(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| no_start(command))?;
    judge(command, status)
}

/// Runs to the end and hands back what it prints, but its messages; a failure names the command
/// line.
pub fn captured(command: &mut Command) -> Result<String> {
    let output = command.stderr(Stdio::inherit()).output().with_context(|| no_start(command))?;
    judge(command, output.status)?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Runs to the end and hands what it prints to `reader`; a failure names the command line.
pub fn run_through(command: &mut Command, reader: impl FnOnce(BufReader<ChildStdout>) -> Result<()>) -> Result<()> {
    let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| no_start(command))?;
    if let Some(output) = child.stdout.take() {
        reader(BufReader::new(output))?;
    }
    judge(command, child.wait()?)
}

/// Does two things at once: one waits for the network or for a linker while the other computes.
pub fn both<A: Send, B>(aside: impl FnOnce() -> Result<A> + Send, work: impl FnOnce() -> Result<B>) -> Result<(A, B)> {
    std::thread::scope(|scope| {
        let aside = scope.spawn(aside);
        let done = work();
        let aside = aside.join().unwrap_or_else(|_| bail!("a thread of this program has ended early"));
        Ok((aside?, done?))
    })
}

/// Packs entries of a folder in the order of their names, without dates and owners: the same files
/// are the same bytes.
pub fn pack(folder: &Path, entries: &[impl AsRef<OsStr>], archive: &Path) -> Result<()> {
    let mut tar = Command::new("tar");
    tar.args(["--sort=name", "--mtime=@0", "--owner=0", "--group=0", "--numeric-owner", "--mode=go=rX,u+rw,a-s"]);
    // Without its own name and date.
    tar.args(["--use-compress-program=gzip -9n", "-cf"]).arg(archive).arg("-C").arg(folder);
    // An archive of nothing is wanted, too.
    run(tar.args(["--files-from", "/dev/null"]).args(entries))
}

/// Unpacks an archive into a folder.
pub fn unpack(archive: &Path, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    run(Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(folder))
}

fn no_start(command: &Command) -> String {
    format!("`{}` cannot be started", line(command))
}

fn judge(command: &Command, status: ExitStatus) -> Result<()> {
    if !status.success() {
        bail!("`{}` failed ({status}); its messages stand above", line(command));
    }
    Ok(())
}

/// Does `program --version` (or the given arguments) run without complaint?
pub fn answers(name: &str, arguments: &[&str]) -> bool {
    let status =
        Command::new(name).args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}

/// Output of a program, trimmed, or nothing if it cannot be run or fails.
pub fn output_of(name: &str, arguments: &[&str]) -> Option<String> {
    let output = program(name).args(arguments).stdin(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// The command as one would type it.
fn line(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem().unwrap_or(command.get_program());
    std::iter::once(program).chain(command.get_args()).map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_program_is_named_with_its_arguments() {
        let error = run(Command::new("/nonexistent/probe-rs").arg("list")).expect_err("there is no such program");
        assert!(format!("{error:#}").starts_with("`probe-rs list` cannot be started"), "{error:#}");
    }

    #[test]
    fn a_folder_is_packed_alike_to_the_byte_whatever_its_dates() -> Result<()> {
        let own = std::env::temp_dir().join(format!("anemo-packed-{}", std::process::id()));
        let packed = |name: &str, order: [&str; 2]| -> Result<Vec<u8>> {
            let folder = own.join("from");
            std::fs::create_dir_all(&folder)?;
            order.iter().try_for_each(|file| std::fs::write(folder.join(file), format!("\0{file}")))?;
            std::thread::sleep(std::time::Duration::from_millis(20));
            pack(&own, &["from"], &own.join(name))?;
            std::fs::remove_dir_all(folder)?;
            Ok(std::fs::read(own.join(name))?)
        };
        assert_eq!(packed("first.tar.gz", ["b", "a"])?, packed("second.tar.gz", ["a", "b"])?);
        unpack(&own.join("first.tar.gz"), &own.join("to"))?;
        assert_eq!(std::fs::read(own.join("to/from/b"))?, b"\0b");
        Ok(std::fs::remove_dir_all(own)?)
    }

    #[test]
    fn what_never_ends_is_stopped_and_what_ends_tells_how() {
        let code = |command: &mut Command| command.status().expect("every system has it").code();
        assert_eq!(code(limited(1, "sleep").arg("60")), Some(TIMED_OUT));
        assert_eq!(code(&mut limited(60, "false")), Some(1));
    }

    #[test]
    fn the_root_is_the_workspace() {
        assert!(root().join("rust-toolchain.toml").is_file());
    }
}
