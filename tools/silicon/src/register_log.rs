//! Uses of registers by the firmware, written down for whoever holds it against descriptions of the
//! chip (`cargo xtask registers`).
//!
//! With `ANEMO_REGISTER_LOG` set, each thread writes a file into that folder as it ends: a line for
//! each register and width, with the bits that were ever written as one and as zero.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

static FOLDER: LazyLock<Option<PathBuf>> = LazyLock::new(|| std::env::var_os("ANEMO_REGISTER_LOG").map(PathBuf::from));
/// Tells files of one process from each other.
static THREADS: AtomicU32 = AtomicU32::new(0);

thread_local! {
    static LOG: RefCell<RegisterLog> = RefCell::default();
}

/// One use of a register.
#[derive(Default)]
struct RegisterUse {
    read: bool,
    /// Bits that were written as one, and as zero.
    ones: u32,
    zeros: u32,
}

#[derive(Default)]
struct RegisterLog {
    /// An image runs in this thread. Registers of a board that a test uses by itself do not count.
    has_image: bool,
    /// By address and width in bytes.
    registers: BTreeMap<(u32, usize), RegisterUse>,
}

/// An image runs in this thread from now on.
pub fn begin() {
    LOG.with_borrow_mut(|log| log.has_image = FOLDER.is_some());
}

/// The firmware reads a register.
pub fn read(address: u32, size: usize) {
    note(address, size, |of| of.read = true);
}

/// The firmware writes bits of a register.
pub fn written(address: u32, size: usize, value: u32, bits: u32) {
    note(address, size, |of| {
        of.ones |= value & bits;
        of.zeros |= !value & bits;
    });
}

fn note(address: u32, size: usize, change: impl FnOnce(&mut RegisterUse)) {
    LOG.with_borrow_mut(|log| {
        if log.has_image {
            change(log.registers.entry((address, size)).or_default());
        }
    });
}

impl Drop for RegisterLog {
    fn drop(&mut self) {
        let Some(folder) = FOLDER.as_ref().filter(|_| self.has_image) else { return };
        let mut lines = String::new();
        for (&(address, size), RegisterUse { read, ones, zeros }) in &self.registers {
            writeln!(lines, "{address:#x} {size} {} {ones:#x} {zeros:#x}", u8::from(*read)).ok();
        }
        let name = format!("{}-{}", std::process::id(), THREADS.fetch_add(1, Relaxed));
        if let Err(error) = std::fs::write(folder.join(name), lines) {
            eprintln!("{} cannot be written into: {error}", folder.display());
        }
    }
}
