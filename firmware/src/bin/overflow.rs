//! Runs out of stack, for `cargo xtask safety`: with the fault entry and the fault handler of the
//! application, and a board that remembers the requests of the handler.
//!
//! The emulator's command line selects the way: `call` calls itself without end, `interrupt` has an
//! exception begin where the stack ends. It ends with the fault's code if the heaters were put low
//! and no static has changed, with 1 otherwise.

#![no_std]
#![no_main]

#[path = "../fault_entry.rs"]
mod fault_entry;
#[allow(dead_code, reason = "the crash record is not read here")]
#[path = "../halt.rs"]
mod halt;
#[allow(dead_code, reason = "no file is read here")]
#[path = "../mcu"]
mod mcu {
    pub mod emulated {
        pub mod semihosting;
        mod virtual_log;
    }
}

use core::arch::asm;
use core::hint::black_box;
use core::sync::atomic::AtomicU32;
use cortex_m_rt::entry;
use cortex_m_semihosting::syscall;
use defmt as _;
use mcu::emulated::semihosting::exit;
// For the table of interrupts, of which none is used.
use stm32f4xx_hal as _;

/// What must be found again: as it lies next to the stack in an image without this protection, it
/// would be the first to be lost.
static WITNESS: [AtomicU32; 256] = [const { AtomicU32::new(PATTERN) }; 256];
const PATTERN: u32 = 0x5EED_CAFE;

/// The exit code that says that all was as it should be.
const FAULTED: u32 = 102;

/// The functions of a board that the fault handler calls.
mod board {
    use super::{PATTERN, WITNESS, exit};
    use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
    use firmware::crash_record::CrashRecord;
    use wire::ResetCause;

    static HEATERS_LOW: AtomicBool = AtomicBool::new(false);

    pub fn heaters_low() {
        HEATERS_LOW.store(true, Relaxed);
    }

    pub const fn reset_as_remembered(reset: ResetCause, _: &CrashRecord) -> ResetCause {
        reset
    }

    pub fn restart() -> ! {
        let whole = WITNESS.iter().all(|word| word.load(Relaxed) == PATTERN);
        exit(if whole && HEATERS_LOW.load(Relaxed) { super::FAULTED } else { 1 })
    }
}

#[entry]
fn main() -> ! {
    let mut line = [0_u8; 64];
    let block = [line.as_mut_ptr() as usize, line.len()];
    // SAFETY: SYS_GET_CMDLINE writes at most as many bytes as the block says.
    unsafe { syscall!(GET_CMDLINE, block[0], block[1]) };
    match line.split(|&byte| byte == b' ' || byte == 0).nth(1) {
        Some(b"call") => _ = deeper(black_box(1)),
        Some(b"interrupt") => at_the_end(),
        _ => {}
    }
    exit(2)
}

/// Calls itself for as long as there is a stack.
#[inline(never)]
#[allow(unconditional_recursion, reason = "it is what this is for")]
fn deeper(depth: u32) -> u32 {
    let here = [depth; 16];
    deeper(black_box(&here).iter().sum()).wrapping_add(black_box(here)[3])
}

/// An exception whose frame has no room.
fn at_the_end() {
    // SAFETY: nobody comes back from here.
    unsafe { asm!("msr msp, {end}", "svc 0", end = in(reg) stack_end() + 8) };
}

fn stack_end() -> u32 {
    unsafe extern "C" {
        static _stack_end: u32;
    }
    &raw const _stack_end as u32
}
