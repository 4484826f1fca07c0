//! Processors: what belongs to one whatever board it is on.

#[cfg(feature = "emulated")]
pub mod emulated;
#[cfg(feature = "stm32f4")]
pub mod stm32f4;
pub mod ticking;
