//! One switch of a heater's level, on port C.
//!
//! The HAL's pin of a number that is known only as it runs checks that number at every write and
//! panics beyond 15, which a pin's number cannot be. Here the bit is made once.

use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use stm32f4xx_hal::gpio::{Output, PartiallyErasedPin, PinExt};
use stm32f4xx_hal::pac::GPIOC;

/// A pin of port C that is an output.
pub struct HeaterPin {
    /// Its bit in IDR and in the lower half of BSRR.
    bit: u32,
    /// Whoever has the pin may write its bit.
    _pin: PartiallyErasedPin<'C', Output>,
}

impl HeaterPin {
    /// Takes a pin.
    pub fn new(pin: PartiallyErasedPin<'C', Output>) -> Self {
        Self { bit: 1 << (pin.pin_id() & 15), _pin: pin }
    }

    fn write(bits: u32) {
        // SAFETY: BSRR is written only, and zeros in it change nothing: one store moves this pin
        // alone (RM0090, GPIOx_BSRR).
        unsafe { (*GPIOC::ptr()).bsrr().write(|w| w.bits(bits)) };
    }
}

impl ErrorType for HeaterPin {
    type Error = Infallible;
}

/// What the pin has, whatever it should have: the input of an output stays connected (RM0090,
/// "Output configuration").
impl InputPin for HeaterPin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        // SAFETY: a read that changes nothing.
        Ok(unsafe { (*GPIOC::ptr()).idr().read().bits() } & self.bit != 0)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|is_high| !is_high)
    }
}

impl OutputPin for HeaterPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Self::write(self.bit << 16);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Self::write(self.bit);
        Ok(())
    }
}
