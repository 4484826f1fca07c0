//! How much of the stack has been in use: it is painted at the start (cortex-m-rt, `paint-stack`),
//! and what has lost its paint was used.
//!
//! Beside the bound from the call graph (`cargo xtask safety`) this is what really happened; never
//! more, and a hole in a frame that nobody wrote into at the deepest point can hide a few bytes.

use cortex_m_rt::STACK_PAINT_VALUE;

/// Bytes that have been in use since the start, and bytes that there are.
pub fn used() -> (u32, u32) {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    let (top, end) = (&raw const _stack_start, &raw const _stack_end);
    let mut at = end;
    // SAFETY: from the end to the top all is RAM. Others write above, and a word that changes
    // meanwhile has no paint either way.
    while at < top && unsafe { at.read_volatile() } == STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    (top as u32 - at as u32, top as u32 - end as u32)
}
