//! Pins, vectors and limits of the sensor board. Its circuit is in `docs/reference/board.md`.

use crate::mcu::stm32f4::port::PortPin;
use dr_core::control::HardwareLimits;
use firmware::drivers::ads131e06;
use stm32f4xx_hal::gpio::{self, Output, PA4, PB0, PB1, PB4};
use stm32f4xx_hal::pac::Interrupt;
use wire::BoardKind;

/// For the log.
pub const NAME: &str = "sensor";
/// For the host.
pub const KIND: BoardKind = BoardKind::Sensor;
/// This board reads for itself.
pub const IS_VIRTUAL: bool = false;

// Pins beside these: PA2 and PA3 are the host's line, PA5 to PA7 the converter's SCK, MISO, MOSI.
/// Port of the heaters' pins, element 0 first: PC0 … PC5.
pub const HEATER_PORT: char = 'C';
/// The heaters' pins in their port.
pub const HEATER_MASK: u32 = (1 << ELEMENTS) - 1;
/// A heater's pin.
pub type HeaterPin = PortPin<HEATER_PORT>;
/// Status LED, whose changes keep the platinum's supply up.
pub type LedPin = PB1<Output>;
/// Chip select of the converter, low when it is selected.
pub type SelectPin = PA4<Output>;
/// Reset of the converter, low resets.
pub type ResetPin = PB0<Output>;
/// Falls when a conversion is ready; EXTI line 4.
pub type DataReadyPin = PB4<gpio::Input>;

// Vectors, as `main.rs` binds them. Those of peripherals that the board does not use are raised by
// software alone.
/// The vector of `control`, which the data-ready line raises.
pub const CONTROL: Interrupt = Interrupt::EXTI4;
/// The vector of `receive`.
pub const RECEIVE: Interrupt = Interrupt::USART2;
/// The vector of `transmit`.
pub const TRANSMIT: Interrupt = Interrupt::SPI3;
/// The vector of `estimate`.
pub const ESTIMATE: Interrupt = Interrupt::UART5;
/// The vector of `serve_settings`.
pub const SETTINGS: Interrupt = Interrupt::SPI2;
/// The vector of the dead-man timer, which raises it.
pub const DEAD_MAN: Interrupt = Interrupt::TIM5;

/// The vector of `supply_low`, which the voltage detector raises.
pub const SUPPLY: Interrupt = Interrupt::PVD;

/// Elements that it can drive, one a channel of its converter.
pub const ELEMENTS: usize = ads131e06::CHANNELS;
/// Limits that no message can lift.
pub static HARDWARE_LIMITS: HardwareLimits = HardwareLimits::SENSOR_BOARD;
/// Ticks until the host sets other ones, µs.
pub const FIRST_PERIOD_US: u32 = 10_000;
/// Baud rate of the host's line.
pub const HOST_BAUD: u32 = 921_600;
/// SCK of the converter, which bears 20 MHz.
pub const ADC_CLOCK_KHZ: u32 = 10_500;
