//! The switches of the two-level current sources, one pin an element: low pin, low current.
//!
//! The low level is what the hardware falls back to without any program: every pin has an external
//! pull-down, so a board in reset, in its bootloader or with a dead processor heats with the
//! sensing current only (about 1.5 mW an element). This module keeps that direction: a wrong
//! request or a pin that fails ends with everything low that can be put low.
//!
//! Every pin is read back after the writes, and before the next ones: one that a short holds high
//! or low is an error.
//!
//! Limits: what is read is the pin's level. That the current really follows is seen by the guard in
//! the voltage.

use dr_core::control::Heaters;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

/// From the last write to the read-back. A pin takes 100 ns at its slowest speed and 50 pF
/// (STM32F405 data sheet, "I/O AC characteristics").
const SETTLE_NS: u32 = 500;

/// The pins of `N` elements, element 0 first.
///
/// One pin type for all: HAL pins are made alike by erasing their number (`pin.erase()`), which
/// costs no `dyn`.
#[derive(Debug)]
pub struct HeaterPins<P, const N: usize> {
    pins: [P; N],
    /// The levels that they should have.
    written: usize,
}

impl<P: OutputPin + InputPin, const N: usize> HeaterPins<P, N> {
    /// Takes the pins and puts all of them low.
    ///
    /// # Errors
    /// The first pin that failed; the others are low.
    pub fn new(pins: [P; N]) -> Result<Self, HeaterError> {
        let mut heaters = Self { pins, written: 0 };
        heaters.all_low()?;
        Ok(heaters)
    }

    /// Puts bit i of `heaters` on the pin of element i.
    ///
    /// Pins that fall are written before pins that rise, so that the supply never carries more than
    /// the larger of the two patterns.
    ///
    /// # Errors
    /// A bit without an element, a pin that failed, or one that has another level. In all cases all
    /// pins that can be are low afterwards.
    pub fn apply(&mut self, heaters: Heaters, delay: &mut impl DelayNs) -> Result<(), HeaterError> {
        let applied = self.try_apply(heaters.0).and_then(|()| {
            self.written = heaters.0;
            delay.delay_ns(SETTLE_NS);
            self.verify()
        });
        if applied.is_err() {
            // The first error is the one to report; a second one would not change what to do.
            let _ = self.all_low();
        }
        applied
    }

    /// Puts every pin low, whatever fails on the way.
    ///
    /// # Errors
    /// The first pin that failed; the others are low.
    pub fn all_low(&mut self) -> Result<(), HeaterError> {
        self.written = 0;
        let mut first = Ok(());
        for (element, pin) in self.pins.iter_mut().enumerate() {
            let written = pin.set_low().map_err(|_| HeaterError::Pin(element));
            first = first.and(written);
        }
        first
    }

    /// Reads all pins back.
    ///
    /// # Errors
    /// The first pin that has another level than was written last, or cannot be read.
    pub fn verify(&mut self) -> Result<(), HeaterError> {
        for (element, pin) in self.pins.iter_mut().enumerate() {
            let is_high = pin.is_high().map_err(|_| HeaterError::Pin(element))?;
            if is_high != (self.written >> element & 1 == 1) {
                return Err(HeaterError::NotHeld(element));
            }
        }
        Ok(())
    }

    fn try_apply(&mut self, bits: usize) -> Result<(), HeaterError> {
        if bits >> N != 0 {
            return Err(HeaterError::NoSuchElement);
        }
        for high in [false, true] {
            for (element, pin) in self.pins.iter_mut().enumerate() {
                if (bits >> element) & 1 == usize::from(high) {
                    pin.set_state(high.into()).map_err(|_| HeaterError::Pin(element))?;
                }
            }
        }
        Ok(())
    }
}

/// Why the heaters are off instead of as decided. Elements count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeaterError {
    /// A bit is set beyond the last element.
    NoSuchElement,
    /// A pin could not be written.
    Pin(usize),
    /// A pin has another level than was written.
    NotHeld(usize),
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::delay::NoopDelay;
    use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};

    fn pins(expected: [&[Transaction]; 3]) -> [Mock; 3] {
        expected.map(Mock::new)
    }

    fn done(mut heaters: HeaterPins<Mock, 3>) {
        for pin in &mut heaters.pins {
            pin.done();
        }
    }

    fn apply(heaters: &mut HeaterPins<Mock, 3>, bits: usize) -> Result<(), HeaterError> {
        heaters.apply(Heaters(bits), &mut NoopDelay::new())
    }

    fn low() -> Transaction {
        Transaction::set(State::Low)
    }

    fn high() -> Transaction {
        Transaction::set(State::High)
    }

    fn reads(state: State) -> Transaction {
        Transaction::get(state)
    }

    fn broken(transaction: Transaction) -> Transaction {
        transaction.with_error(MockError::Io(std::io::ErrorKind::NotConnected))
    }

    #[test]
    fn starts_low_and_follows_the_bits() {
        let mut heaters = HeaterPins::new(pins([
            &[low(), high(), reads(State::High), low(), reads(State::Low)],
            &[low(), low(), reads(State::Low), high(), reads(State::High)],
            &[low(), high(), reads(State::High), high(), reads(State::High)],
        ]))
        .unwrap();
        apply(&mut heaters, 0b101).unwrap();
        apply(&mut heaters, 0b110).unwrap();
        done(heaters);
    }

    #[test]
    fn falls_before_it_rises() {
        use std::cell::RefCell;
        use std::rc::Rc;

        struct Logged(usize, Rc<RefCell<Vec<(usize, bool)>>>);
        impl embedded_hal::digital::ErrorType for Logged {
            type Error = core::convert::Infallible;
        }
        impl OutputPin for Logged {
            fn set_low(&mut self) -> Result<(), Self::Error> {
                self.1.borrow_mut().push((self.0, false));
                Ok(())
            }
            fn set_high(&mut self) -> Result<(), Self::Error> {
                self.1.borrow_mut().push((self.0, true));
                Ok(())
            }
        }

        impl InputPin for Logged {
            fn is_high(&mut self) -> Result<bool, Self::Error> {
                Ok(self.1.borrow().iter().rev().find(|entry| entry.0 == self.0).is_some_and(|entry| entry.1))
            }
            fn is_low(&mut self) -> Result<bool, Self::Error> {
                self.is_high().map(|high| !high)
            }
        }

        let log = Rc::new(RefCell::new(Vec::new()));
        let mut heaters = HeaterPins::new([0, 1, 2].map(|element| Logged(element, log.clone()))).unwrap();
        log.borrow_mut().clear();
        heaters.apply(Heaters(0b011), &mut NoopDelay::new()).unwrap();
        assert_eq!(*log.borrow(), [(2, false), (0, true), (1, true)]);
    }

    #[test]
    fn all_low_reaches_every_pin_past_a_broken_one() {
        let mut heaters = HeaterPins::new(pins([&[low(), low()], &[low(), broken(low())], &[low(), low()]])).unwrap();
        assert!(matches!(heaters.all_low(), Err(HeaterError::Pin(1))));
        done(heaters);
    }

    #[test]
    fn a_pin_that_fails_takes_the_others_down() {
        let mut heaters =
            HeaterPins::new(pins([&[low(), high(), low()], &[low(), broken(high()), low()], &[low(), low()]])).unwrap();
        assert!(matches!(apply(&mut heaters, 0b111), Err(HeaterError::Pin(1))));
        done(heaters);
    }

    #[test]
    fn a_pin_that_is_held_by_a_short_takes_all_down() {
        let (held_low, held_high) = (reads(State::Low), reads(State::High));
        let mut heaters = HeaterPins::new(pins([
            &[low(), high(), reads(State::High), low()],
            &[low(), high(), held_low, low()],
            &[low(), low(), low()],
        ]))
        .unwrap();
        assert_eq!(apply(&mut heaters, 0b011), Err(HeaterError::NotHeld(1)));
        done(heaters);
        let mut heaters =
            HeaterPins::new(pins([&[low(), low(), held_high, low()], &[low(), low(), low()], &[low(), low(), low()]]))
                .unwrap();
        assert_eq!(apply(&mut heaters, 0), Err(HeaterError::NotHeld(0)));
        done(heaters);
    }

    #[test]
    fn a_bit_without_an_element_heats_nothing() {
        let mut heaters = HeaterPins::new(pins([&[low(), low()], &[low(), low()], &[low(), low()]])).unwrap();
        assert_eq!(apply(&mut heaters, 0b1001), Err(HeaterError::NoSuchElement));
        done(heaters);
    }

    #[test]
    fn a_broken_pin_is_named_at_the_start() {
        let broken_pins = pins([&[low()], &[low()], &[broken(low())]]);
        let mut handles = broken_pins.clone();
        assert!(matches!(HeaterPins::new(broken_pins), Err(HeaterError::Pin(2))));
        for pin in &mut handles {
            pin.done();
        }
    }
}
