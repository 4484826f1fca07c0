//! Pins, vectors and limits of the virtual board.

use dr_core::control::HardwareLimits;
use stm32f4xx_hal::pac::Interrupt;
use wire::BoardKind;

/// For the log.
pub const NAME: &str = "virtual";
/// For the host.
pub const KIND: BoardKind = BoardKind::Virtual;
/// This board's front end is a link.
pub const IS_VIRTUAL: bool = true;

// Pins: PA2 and PA3 are the host's line, PA9 and PA10 the front end's.

// Vectors, as `main.rs` binds them, all raised by software but that of `receive`.
/// The vector of `control`.
pub const CONTROL: Interrupt = Interrupt::EXTI4;
/// The vector of `receive`.
pub const RECEIVE: Interrupt = Interrupt::USART2;
/// The vector of `transmit`.
pub const TRANSMIT: Interrupt = Interrupt::SPI3;
/// The vector of `estimate`.
pub const ESTIMATE: Interrupt = Interrupt::UART5;
/// The vector of `serve_settings`.
pub const SETTINGS: Interrupt = Interrupt::SPI2;
/// The vector of the dead-man timer.
pub const DEAD_MAN: Interrupt = Interrupt::TIM5;

/// Elements that it can drive: as many as a message has room for.
pub const ELEMENTS: usize = wire::MOST_ELEMENTS;
/// Limits that no message can lift.
pub static HARDWARE_LIMITS: HardwareLimits = HardwareLimits::SIMULATED;
/// The emulator's core clock.
pub const CLOCK_HZ: u32 = 168_000_000;
/// Baud rate of both lines.
pub const BAUD: u32 = 921_600;
