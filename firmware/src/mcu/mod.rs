//! Processors: what belongs to one whatever board it is on.

#[cfg(feature = "virtual-board")]
pub mod emulated;
#[cfg(feature = "sensor-board")]
pub mod stm32f4;
pub mod ticking;
