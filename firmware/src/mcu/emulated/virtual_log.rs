//! Words for people, on the emulator's standard output.
//!
//! As `defmt-semihosting`, without its panics. Interrupts are off while a word is written. What can
//! still come between is a fault or a panic, and neither comes back: it begins a word of its own,
//! and the decoder drops the broken one.

use super::semihosting::File;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use cortex_m::{interrupt, register::primask};
use cortex_m_semihosting::nr;
use firmware::flag::Flag;

#[defmt::global_logger]
struct Log;

/// The encoder of the word that is being written.
struct Encoder(UnsafeCell<defmt::Encoder>);

// SAFETY: it is used between `acquire` and `release` only, when interrupts are off.
unsafe impl Sync for Encoder {}

static ENCODER: Encoder = Encoder(UnsafeCell::new(defmt::Encoder::new()));
/// Interrupts were on before this word.
static WERE_ON: Flag = Flag::new(false);
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
        WERE_ON.set(were_on);
        if FILE.load(Relaxed) == CLOSED {
            // The standard output.
            FILE.store(File::open(c":tt", nr::open::W_TRUNC).map_or(CLOSED, |file| file.0), Relaxed);
        }
        // SAFETY: interrupts are off.
        unsafe { (*ENCODER.0.get()).start_frame(write) };
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: as in `acquire`.
        unsafe { (*ENCODER.0.get()).end_frame(write) };
        if WERE_ON.is_raised() {
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
    File(FILE.load(Relaxed)).write(bytes);
}
