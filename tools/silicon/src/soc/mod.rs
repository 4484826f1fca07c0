//! The peripherals of the STM32F405 that the sensor board uses, each by itself: registers in, lines
//! and times out. The board puts them together.
//!
//! Source: reference manual RM0090; times from the data sheet.

pub mod access;
pub mod dma;
pub mod exti;
pub mod flash;
pub mod gpio;
pub mod power;
pub mod rcc;
pub mod spi;
pub mod timer;
pub mod usart;
pub mod watchdog;
