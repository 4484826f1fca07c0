//! Processors: what belongs to one whatever board it is on.

#[cfg(feature = "virtual-board")]
pub mod semihosting;
#[cfg(feature = "sensor-board")]
pub mod stm32f4;
pub mod ticking;
