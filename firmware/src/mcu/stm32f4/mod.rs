//! STM32F405: everything that belongs to the processor, whatever board it is on.
//!
//! | file | what |
//! |---|---|
//! | `circle.rs` | where to read in a buffer that a DMA stream fills; tested on the host |
//! | `clocks.rs` | 8 MHz crystal to 168 MHz, waiting by the cycle counter, stopwatch |
//! | `dead_man.rs` | timer 5: heaters low unless their levels are decided anew, and its proof tests |
//! | `dma_link.rs` | frames to the host and bytes from it, both by DMA |
//! | `flash.rs` | three sectors of the flash for the settings |
//! | `memory_check.rs` | proof tests of clock and memories in the idle task |
//! | `memory_protection.rs` | what may be written and executed where |
//! | `port.rs` | output pins that are read back |
//! | `reset_flags.rs` | why the processor started; tested on the host |
//! | `supply.rs` | brown-out level, and heaters low as the supply falls |
//! | `watchdog.rs` | reset unless everybody is well, and its proof test |
//!
//! Nothing of this has run on a board yet. What the emulator cannot show (DMA, EXTI, PLL, watchdog)
//! is argued beside the code from the reference manual RM0090. `HAL.md` compares each register that
//! the HAL touches, too; `ERRATA.md` goes through the chip's errata.

pub mod clocks;
pub mod dead_man;
pub mod dma_link;
pub mod flash;
pub mod memory_check;
pub mod memory_protection;
pub mod port;
pub mod supply;
pub mod watchdog;

use defmt_rtt as _;
use firmware::crash_record::CrashRecord;
use wire::ResetCause;

/// Waits until the last store has reached its peripheral, for handlers that clear their interrupt.
/// In the write buffer it would still be there when the handler returns, and the interrupt would be
/// taken once more (Arm DAI 0321A, "Memory barrier instructions").
fn has_arrived() {
    cortex_m::asm::dsb();
}

/// The number of this processor (RM0090, 39.1).
pub fn unique_id() -> [u32; 3] {
    const ADDRESS: *const [u32; 3] = 0x1fff_7a10 as *const _;
    // SAFETY: three aligned words that ST has programmed and nothing changes.
    unsafe { ADDRESS.read_volatile() }
}

/// Why it started, by its flags. A supply that was away so briefly that RAM has kept the crash
/// record has dipped, and was not switched on, however far it fell.
pub const fn reset_as_remembered(reset: ResetCause, record: &CrashRecord) -> ResetCause {
    match reset {
        ResetCause::PowerOn if record.starts > 1 => ResetCause::BrownOut,
        _ => reset,
    }
}
