//! The ADS131E06 as the processor sees it: a device on SPI with data-ready and reset (SBAS561).
//!
//! | file | what |
//! |---|---|
//! | `registers` | what can be set |
//! | `converter` | when conversions come, and what the filter makes of a step |
//! | `port` | commands and frames, byte by byte |
//! | `fault` | what can go wrong with it |

mod converter;
mod fault;
mod port;
mod registers;

pub use converter::OFFSET_CODES;
pub use fault::AdcFault;
pub use port::{Adc, FRAME_BYTES};

/// Channels of the chip.
pub const CHANNELS: usize = 6;

/// Core cycles that so many periods of its clock of 2.048 MHz take.
pub const fn t_clk(count: u64) -> u64 {
    crate::time::periods(count, 2_048_000)
}
