//! Output pins of one port, whose levels can be read back.
//!
//! The HAL's pin of a number that is known only as it runs checks that number at every write and
//! panics beyond 15, which a pin's number cannot be. Here the bit is made once.

use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use stm32f4xx_hal::gpio::{Input, Output, PartiallyErasedPin, PinExt};
use stm32f4xx_hal::pac::{GPIOA, gpioa::RegisterBlock};

/// Registers of a port.
pub fn registers<const PORT: char>() -> &'static RegisterBlock {
    let address = GPIOA::ptr() as usize + (PORT as usize - 'A' as usize) * 0x400;
    // SAFETY: ports lie 1 KiB apart and are alike but for reset values (RM0090, "Memory map").
    unsafe { &*(address as *const RegisterBlock) }
}

/// Writes BSRR: its lower half raises pins, its upper half lowers them.
pub fn write<const PORT: char>(bits: u32) {
    // SAFETY: BSRR is written only, and zeros in it change nothing: one store moves these pins and
    // no other, so that no context can be disturbed half-way (RM0090, GPIOx_BSRR).
    unsafe { registers::<PORT>().bsrr().write(|w| w.bits(bits)) };
}

/// A pin that is an output.
pub struct PortPin<const PORT: char> {
    /// Its bit in IDR and in the lower half of BSRR.
    bit: u32,
    /// Whoever has the pin may write its bit.
    _pin: PartiallyErasedPin<PORT, Output>,
}

impl<const PORT: char> PortPin<PORT> {
    /// Makes a pin an output.
    pub fn new(pin: PartiallyErasedPin<PORT, Input>) -> Self {
        Self { bit: 1 << (pin.pin_id() & 15), _pin: pin.into_mode() }
    }
}

impl<const PORT: char> ErrorType for PortPin<PORT> {
    type Error = Infallible;
}

/// What the pin has, whatever it should have: the input of an output stays connected (RM0090,
/// "Output configuration").
impl<const PORT: char> InputPin for PortPin<PORT> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(registers::<PORT>().idr().read().bits() & self.bit != 0)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|is_high| !is_high)
    }
}

impl<const PORT: char> OutputPin for PortPin<PORT> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        write::<PORT>(self.bit << 16);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        write::<PORT>(self.bit);
        Ok(())
    }
}
