//! Words for people, on the emulator's standard output.
//!
//! As `defmt-semihosting`, without its panics. Interrupts are off while a word is written. What can
//! still come between is a fault or a panic, and neither comes back: it begins a word of its own,
//! and the decoder drops the broken one.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use cortex_m::{interrupt, register::primask};
use cortex_m_semihosting::{nr, syscall};

#[defmt::global_logger]
struct Log;

/// The encoder of the word that is being written.
struct Encoder(UnsafeCell<defmt::Encoder>);

// SAFETY: it is used between `acquire` and `release` only, when interrupts are off.
unsafe impl Sync for Encoder {}

static ENCODER: Encoder = Encoder(UnsafeCell::new(defmt::Encoder::new()));
/// Interrupts were on before this word.
static WERE_ON: AtomicBool = AtomicBool::new(false);
/// Not opened yet. A file that cannot be opened has the same number, and is tried again with the
/// next word.
const CLOSED: usize = usize::MAX;
static FILE: AtomicUsize = AtomicUsize::new(CLOSED);

// SAFETY: `acquire` keeps all others away until `release`, apart from those behind which nobody
// comes back.
unsafe impl defmt::Logger for Log {
    fn acquire() {
        let were_on = primask::read().is_active();
        interrupt::disable();
        WERE_ON.store(were_on, Relaxed);
        if FILE.load(Relaxed) == CLOSED {
            let name = c":tt";
            // SAFETY: SYS_OPEN reads a zero-terminated name of the given length; this one is the
            // standard output.
            FILE.store(unsafe { syscall!(OPEN, name.as_ptr(), nr::open::W_TRUNC, name.count_bytes()) }, Relaxed);
        }
        // SAFETY: interrupts are off.
        unsafe { (*ENCODER.0.get()).start_frame(write) };
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: as in `acquire`.
        unsafe { (*ENCODER.0.get()).end_frame(write) };
        if WERE_ON.load(Relaxed) {
            // SAFETY: they were on.
            unsafe { interrupt::enable() };
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: as in `acquire`.
        unsafe { (*ENCODER.0.get()).write(bytes, write) };
    }
}

fn write(bytes: &[u8]) {
    // SAFETY: SYS_WRITE reads `len` bytes.
    unsafe { syscall!(WRITE, FILE.load(Relaxed), bytes.as_ptr(), bytes.len()) };
}
