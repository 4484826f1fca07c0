//! Where a hard fault begins: with a stack that can be used, whatever has become of the one that
//! was.
//!
//! The stack lies at the bottom of RAM, so running over its end is a fault (flip-link; `cargo xtask
//! safety` looks). But then the stack pointer stands below RAM, and a handler in Rust would fault
//! with its first push. A fault in the handler of a fault locks the processor up: heaters stay as
//! they are until the watchdog comes. So here, before anything is pushed, a stack pointer with too
//! little room below is set back to the top. What lay there is lost, and nobody comes back to it.
//!
//! The processor's own frame cannot be stored either when the stack is at its end. That does not
//! keep the handler from running: "if a corrupted stack causes a fault, the fault handler still
//! executes even though the stack pushes for the handler failed" (Arm DDI 0337E, 5.12.1). There is
//! then no frame, and `halt::fault` gets none.

use crate::halt;
use core::arch::naked_asm;
use cortex_m_rt::ExceptionFrame;

/// What the handler may need, generously; `cargo xtask safety` shows what it does.
const ROOM: u32 = 1024;
/// r0 … r3, r12, lr, pc and xPSR; those of the FPU lie above and are not looked at.
const FRAME: u32 = 32;

/// The vector. Only the main stack is used in this firmware.
///
/// # Safety
/// For the processor to enter.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
pub unsafe extern "C" fn hard_fault() -> ! {
    naked_asm!(
        "mrs r0, msp",
        "ldr r1, =_stack_end",
        "ldr r3, =_stack_start",
        // A frame that does not lie within the stack is none.
        "subs r2, r3, #{frame}",
        "cmp r0, r2",
        "bhi 1f",
        "cmp r0, r1",
        "blo 1f",
        // One that does can be read; is there room below it?
        "subs r2, r0, r1",
        "cmp r2, #{room}",
        "bhs 3f",
        "b 2f",
        "1:",
        "movs r0, #0",
        "2:",
        "msr msp, r3",
        "3:",
        "b {fault}",
        ".ltorg",
        room = const ROOM,
        frame = const FRAME,
        fault = sym fault,
    )
}

/// With a stack again. The frame is there if the processor could store it.
extern "C" fn fault(frame: Option<&ExceptionFrame>) -> ! {
    halt::fault(frame)
}
