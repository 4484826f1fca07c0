//! Addresses of registers, and whether they answer (RM0090, "Memory map").

use super::{BUS_FUNCTION, BUS_PINS, Board, DATA_READY_PIN, DEBUG_CONTROL, LINE_FUNCTION, LINE_PINS, Sending};
use crate::complaint::BrokenRule;
use crate::processor::bus::{BusFault, MemoryJob};
use crate::soc::access::{Access, Clocks};
use crate::soc::dma::{self, Dma};
use crate::soc::gpio::GpioPort;
use crate::soc::rcc::ResetSource;
use crate::soc::spi::Spi;
use crate::soc::timer::Timer;
use crate::soc::usart::Usart;
use crate::time::periods;

/// The core's own registers, and beyond.
const CORE: u32 = 0xe000_0000;

/// The fastest APB2 by the speed of SCK's pin at 30 pF, Hz (ES0182, 2.12.4): the bus takes its own
/// clock back from the pin, and a pin that is slow brings the last bit too late.
const CLOCK_PIN_HZ: [u64; 4] = [25_000_000, 75_000_000, 84_000_000, 84_000_000];

impl Board {
    /// Tells whether a peripheral's clock is on; its complaint if not. A clock that was just
    /// switched on is not there for two cycles of AHB, or one and as many as one of APB has
    /// (ES0182, "Delay after an RCC peripheral clock enabling"). A barrier takes longer than that.
    pub(super) fn is_clocked(&mut self, address: u32) -> bool {
        let (bus, bit, register) = match address & !0x3ff {
            0x4002_0000 => (0, 0, "GPIOA"),
            0x4002_0400 => (0, 1, "GPIOB"),
            0x4002_0800 => (0, 2, "GPIOC"),
            0x4002_6000 => (0, 21, "DMA1"),
            0x4000_4400 => (1, 17, "USART2"),
            0x4000_0000 => (1, 0, "TIM2"),
            0x4000_0c00 => (1, 3, "TIM5"),
            0x4000_7000 => (1, 28, "PWR"),
            0x4001_3000 => (2, 12, "SPI1"),
            0x4001_3800 => (2, 14, "SYSCFG"),
            _ => return true,
        };
        let is_open = self.rcc.gates()[bus] >> bit & 1 == 1;
        if !is_open {
            self.complaints.add(self.now, register, BrokenRule::ClockOff);
            return false;
        }
        if self.opened[bus] >> bit & 1 == 0 {
            return true;
        }
        let Clocks { core_hz, apb1_hz, apb2_hz, .. } = self.clocks;
        let bus_hz = [core_hz, apb1_hz, apb2_hz][bus].max(1);
        let is_on = self.now > self.opened_at + periods(1, core_hz.max(1)) + periods(1, bus_hz);
        if is_on {
            self.opened[bus] &= !(1 << bit);
        } else {
            self.complaints.add(self.now, register, BrokenRule::ClockJustOn);
        }
        is_on
    }

    pub(super) fn load_word(&mut self, address: u32) -> Result<u32, BusFault> {
        if !self.is_clocked(address) {
            return Ok(0);
        }
        let offset = address & 0x3ff;
        let core_hz = self.clocks.core_hz;
        // A load from a peripheral comes after all stores to peripherals.
        if address < CORE {
            self.stores_arrive();
        }
        match address {
            0x4001_3000..0x4001_3400 => self.run_bus(),
            0x4000_4400..0x4000_4800 | 0x4002_6000..0x4002_6400 | 0x4000_0c00..0x4000_1000 => self.settle_now(),
            _ => {}
        }
        let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
        let value = match address {
            0x4002_3800..0x4002_3c00 => self.rcc.load(offset, &mut access),
            0x4002_3c00..0x4002_4000 => self.flash.load(offset, &access),
            0x4002_0000..0x4002_0400 => self.ports[0].load(offset, 0, 0),
            0x4002_0400..0x4002_0800 => {
                let data_ready = u32::from(!self.adc.data_ready_low()) << DATA_READY_PIN;
                self.ports[1].load(offset, data_ready, !data_ready & 1 << DATA_READY_PIN)
            }
            0x4002_0800..0x4002_0c00 => {
                let (high, low) = self.heater_shorts;
                self.ports[2].load(offset, 0, low) | if offset == GpioPort::INPUT { high } else { 0 }
            }
            0x4001_3c00..0x4001_4000 => self.exti.load(offset),
            0x4001_3800..0x4001_3c00 => self.exti.load_config(offset),
            0x4001_3000..0x4001_3400 => self.spi.load(offset),
            0x4000_4400..0x4000_4800 => self.usart.load(offset),
            0x4002_6000..0x4002_6400 => self.dma.load(offset),
            0x4000_0000..0x4000_0400 => self.stopwatch.load(offset, &access),
            0x4000_0c00..0x4000_1000 => self.timer.load(offset, &access),
            0x4000_3000..0x4000_3400 => self.watchdog.load(offset, &access),
            DEBUG_CONTROL => self.debug_control,
            0x4000_7000..0x4000_7400 => self.power.load(offset),
            0xe004_2000..0xe004_2400 => self.remembered.get(&address).copied().unwrap_or(0),
            0xe000_0000..0xe010_0000 => self.system.load(address, self.now, core_hz)?,
            _ => return Err(self.unmodelled(address)),
        };
        if matches!(address, 0x4000_4400..0x4000_4800) {
            self.wire_lines();
        }
        Ok(value)
    }

    pub(super) fn store_word(&mut self, address: u32, size: usize, value: u32) -> Result<(), BusFault> {
        if !self.is_clocked(address) {
            return Ok(());
        }
        let offset = address & 0x3ff;
        let core_hz = self.clocks.core_hz;
        let wait_states = self.flash.wait_states();
        if address < CORE {
            self.stores_arrive();
        }
        match address {
            0x4001_3000..0x4001_3400 | 0x4002_0000..0x4002_0800 => self.run_bus(),
            0x4002_6000..0x4002_6400 | 0x4000_0c00..0x4000_1000 => self.settle_now(),
            _ => {}
        }
        let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
        match address {
            0x4002_3800..0x4002_3c00 => {
                let before = self.rcc.gates();
                self.rcc.store(offset, value, wait_states, &mut access);
                let gates = self.rcc.gates();
                if gates != before {
                    self.opened = std::array::from_fn(|bus| self.opened[bus] | gates[bus] & !before[bus]);
                    self.opened_at = self.now;
                }
                self.set_clocks();
                self.hold_in_reset();
            }
            0x4002_3c00..0x4002_4000 => self.flash.store(offset, value, &mut access),
            0x4002_0000..0x4002_0400 => self.ports[0].store(offset, value),
            0x4002_0400..0x4002_0800 => self.ports[1].store(offset, value),
            0x4002_0800..0x4002_0c00 => self.ports[2].store(offset, value),
            0x4001_3c00..0x4001_4000 => self.exti.store(offset, value),
            0x4001_3800..0x4001_3c00 => self.exti.store_config(offset, value),
            0x4001_3000..0x4001_3400 => {
                if offset == 0x0c && !BUS_PINS.iter().all(|&pin| self.ports[0].has_function(pin, BUS_FUNCTION)) {
                    access.complain("GPIOA_AFRL", BrokenRule::SpiPins);
                }
                if offset == 0x0c && access.clocks.apb2_hz > CLOCK_PIN_HZ[self.ports[0].speed(BUS_PINS[0])] {
                    access.complain("GPIOA_OSPEEDR", BrokenRule::SpiClockPin);
                }
                self.spi.store(offset, value, &mut access);
                return Ok(());
            }
            0x4000_4400..0x4000_4800 => self.usart.store(offset, value),
            0x4002_6000..0x4002_6400 => {
                let begins = self.dma.store(offset, value, self.usart.transmits(), &mut access);
                if let Some(dma::SendingBegins { address, length }) = begins {
                    if !LINE_PINS.iter().all(|&pin| self.ports[0].has_function(pin, LINE_FUNCTION)) {
                        access.complain("GPIOA_AFRL", BrokenRule::UsartPins);
                    }
                    let ends_at = self.now + u64::from(length) * self.usart.byte_time(self.clocks.apb1_hz);
                    self.jobs.push(MemoryJob::Fetch { address, length });
                    self.sending = Some(Sending { address, length, ends_at, bytes: Vec::new(), has_begun: false });
                }
            }
            0x4000_0000..0x4000_0400 => self.stopwatch.store(offset, value, &mut access),
            0x4000_0c00..0x4000_1000 => self.timer.store(offset, value, &mut access),
            0x4000_3000..0x4000_3400 => {
                self.watchdog.store(offset, value, &mut access);
                if self.races_at_watchdog && !self.holds_back && self.watchdog.is_unlocked() {
                    self.watchdog.feed(&mut access);
                }
            }
            DEBUG_CONTROL => self.debug_control = value,
            0x4000_7000..0x4000_7400 => {
                let was_low = self.power.is_low();
                self.power.store(offset, value);
                self.wire_detector(was_low);
                self.check_scale();
            }
            0xe004_2000..0xe004_2400 => drop(self.remembered.insert(address, value)),
            0xe000_0000..0xe010_0000 => {
                self.system.store(address, size, value, self.now, core_hz)?;
                if !self.system.mpu.is_valid() {
                    self.complaints.add(self.now, "MPU_RASR", BrokenRule::MpuRegion);
                }
                if self.system.reset_requested {
                    self.request_reset(ResetSource::Software);
                }
            }
            _ => return Err(self.unmodelled(address)),
        }
        match address {
            0x4002_0000..0x4002_0800 => {
                self.wire_converter();
                self.wire_cut_off();
            }
            0x4002_0800..0x4002_0c00 => self.wire_heaters(),
            // These pins and lines are written thousands of times a second: only what waits
            // afterwards is a reason to stop.
            0x4001_3c00..0x4001_4000 => {
                self.wire_lines_by_store();
                self.attention |= self.exti.line(DATA_READY_PIN).1 || self.exti.supply_line().1;
            }
            0x4002_3c00..0x4002_4000 => {
                self.check_programming();
                self.touch();
            }
            _ => {
                self.wire_lines_by_store();
                self.touch();
            }
        }
        Ok(())
    }

    pub(super) fn unmodelled(&mut self, address: u32) -> BusFault {
        self.complaints.add(self.now, "bus", BrokenRule::Unmodelled(address));
        BusFault(address)
    }

    /// Peripherals that the clock controller holds in reset.
    pub(super) fn hold_in_reset(&mut self) {
        let [ahb1, apb1, apb2] = self.rcc.resets();
        if ahb1 >> 21 & 1 == 1 {
            (self.dma, self.sending) = (Dma::default(), None);
        }
        if apb1 >> 17 & 1 == 1 {
            self.usart = Usart::default();
        }
        if apb1 >> 3 & 1 == 1 {
            self.timer = Timer::new(self.timer.slow_hz);
        }
        if apb2 >> 12 & 1 == 1 {
            self.spi = Spi::default();
        }
    }
}

/// The word and the bit that an address in the alias of bits stands for.
pub(super) const fn bit_alias(address: u32) -> Option<(u32, u32)> {
    if address >> 25 != 0x21 {
        return None;
    }
    Some((0x4000_0000 + (address >> 5 & 0xf_fffc), address >> 2 & 31))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_alias_names_word_and_bit() {
        // Bit 3 of RCC_AHB1ENR, 0x40023830.
        let alias = 0x4200_0000 + 0x2_3830 * 32 + 3 * 4;
        assert_eq!(bit_alias(alias), Some((0x4002_3830, 3)));
        assert_eq!(bit_alias(0x4002_3830), None);
    }
}
