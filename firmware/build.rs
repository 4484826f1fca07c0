//! Hands the memory map to the linker, and the name of this build to the firmware.

use std::process::Command;
use std::{env, fs, path::PathBuf};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo:rerun-if-changed=memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        fs::copy("memory.x", out.join("memory.x")).expect("memory.x is in the firmware's folder");
        println!("cargo:rustc-link-search={}", out.display());
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }

    // Said here, because the compiler only says that there is no such program.
    println!("cargo:rerun-if-env-changed=RUSTC_LINKER");
    if let Ok(linker) = env::var("RUSTC_LINKER")
        && linker.contains("flip-link")
        && Command::new(&linker).arg("--help").output().is_err()
    {
        println!(
            "cargo:warning={linker} is missing: build by cargo xtask, or type: cargo install flip-link --locked --version 0.1.12"
        );
    }

    // An archive without history still builds; it then goes by its version alone.
    let commit = Command::new("git").args(["rev-parse", "--short=8", "HEAD"]).output();
    let commit = commit.ok().filter(|o| o.status.success()).and_then(|o| String::from_utf8(o.stdout).ok());
    println!("cargo:rerun-if-changed=../.git/logs/HEAD");
    let version = env::var("CARGO_PKG_VERSION").expect("cargo sets CARGO_PKG_VERSION");
    let suffix = commit.map(|c| format!("+{}", c.trim())).unwrap_or_default();
    println!("cargo:rustc-env=ANEMO_FIRMWARE_NAME=anemo {version}{suffix}");
}
