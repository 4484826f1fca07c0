//! Files and exit of the emulator's host.

use core::ffi::CStr;
use cortex_m_semihosting::{syscall, syscall1};

/// An open file.
#[derive(Clone, Copy)]
pub struct File(pub usize);

impl File {
    /// Opens a file; the modes are in `cortex_m_semihosting::nr::open`.
    pub fn open(name: &CStr, mode: usize) -> Option<Self> {
        // SAFETY: SYS_OPEN reads a zero-terminated name of the given length.
        let handle = unsafe { syscall!(OPEN, name.as_ptr(), mode, name.count_bytes()) };
        (handle != usize::MAX).then_some(Self(handle))
    }

    /// Reads; returns the number of bytes that have come.
    pub fn read(self, bytes: &mut [u8]) -> usize {
        // SAFETY: SYS_READ writes at most `len` bytes and gives the number that it did not.
        bytes.len().saturating_sub(unsafe { syscall!(READ, self.0, bytes.as_mut_ptr(), bytes.len()) })
    }

    /// Writes; returns whether all bytes were written.
    pub fn write(self, bytes: &[u8]) -> bool {
        // SAFETY: SYS_WRITE reads `len` bytes.
        unsafe { syscall!(WRITE, self.0, bytes.as_ptr(), bytes.len()) == 0 }
    }

    /// Goes to a place; returns whether that succeeded.
    pub fn seek(self, offset: usize) -> bool {
        // SAFETY: SYS_SEEK takes two numbers.
        unsafe { syscall!(SEEK, self.0, offset) == 0 }
    }
}

/// Leaves the emulator with an exit code.
pub fn exit(code: u32) -> ! {
    /// ADP_Stopped_ApplicationExit, the reason that carries a code.
    const APPLICATION_EXIT: u32 = 0x2_0026;
    /// The call that carries it; the crate knows only the one without a code.
    const SYS_EXIT_EXTENDED: usize = 0x20;
    let block = [APPLICATION_EXIT, code];
    // SAFETY: SYS_EXIT_EXTENDED reads the two words of the block and does not come back.
    unsafe { syscall1(SYS_EXIT_EXTENDED, block.as_ptr() as usize) };
    loop {
        cortex_m::asm::nop();
    }
}
