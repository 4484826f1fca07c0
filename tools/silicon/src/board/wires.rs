//! Wires between pins, peripherals, converter and heaters.

use super::{Board, DATA_READY_PIN, HEATERS, LED_PIN, PORT_B, PinChange, RESET_PIN, SELECT_PIN, STORE_CYCLES};
use crate::complaint::BrokenRule;
use crate::soc::access::Access;
use crate::soc::dma;
use crate::soc::timer;
use crate::soc::usart;

impl Board {
    /// Bytes that are through on the converter's bus.
    pub(super) fn run_bus(&mut self) {
        while let Some(byte) = self.spi.take_finished(self.now, self.clocks.apb2_hz) {
            let was_low = self.adc.data_ready_low();
            let frames = self.adc.frames_read;
            let answer = self.adc.exchange(byte, &mut self.plant, &mut self.complaints);
            if self.adc.frames_read != frames {
                self.witness.read(byte.at, self.adc.last_frame());
            }
            let mut access = Access { now: byte.at, clocks: self.clocks, complaints: &mut self.complaints };
            self.spi.answer(answer, &mut access);
            if was_low && !self.adc.data_ready_low() {
                self.exti.edge(PORT_B, DATA_READY_PIN, true);
                self.wire_lines();
            }
            // A conversion may have been started, which comes before what was awaited.
            if self.adc.next_event() < self.next_event {
                self.touch();
            }
        }
    }

    /// Pins that the converter listens to.
    pub(super) fn wire_converter(&mut self) {
        let is_selected = self.ports[0].drives_low(SELECT_PIN);
        if self.spi.is_shifting() && is_selected != self.adc.is_selected() {
            self.complaints.add(self.now, "GPIOA_BSRR", BrokenRule::SelectInsideByte);
        }
        self.adc.select(self.now, is_selected, &mut self.complaints);
        self.adc.set_reset(self.now, self.ports[1].drives_low(RESET_PIN), &mut self.complaints);
    }

    /// Pins of the heaters: those that float are pulled down by the board.
    pub(super) fn wire_heaters(&mut self) {
        let port = &self.ports[2];
        let floating = if self.lacks_pull_downs { port.floating() } else { 0 };
        let driven = (port.driven_high() | floating) & HEATERS;
        let (high, low) = self.heater_shorts;
        let levels = (driven & !low | high) as u8;
        if levels != self.plant.levels() {
            self.plant.set_levels(self.now, levels);
            self.pins.push(PinChange { cycle: self.now, levels });
        }
        // Nobody can lower a pin that a short holds high.
        self.witness.pins(self.now, driven as u8, &mut self.complaints);
    }

    /// The LED's pin may have moved, or time has passed.
    pub(super) fn wire_cut_off(&mut self) {
        let is_high = self.ports[1].driven_high() >> LED_PIN & 1 == 1;
        let is_up = self.platinum_supply.pass(self.now, is_high);
        self.next_event = self.next_event.min(self.platinum_supply.next_event());
        if is_up != self.plant.is_supplied() {
            self.plant.set_supply(self.now, is_up);
            self.platinum_cuts += u32::from(!is_up);
        }
    }

    /// The last store has arrived.
    pub(super) fn stores_arrive(&mut self) {
        if self.falling != 0 {
            (self.falling, self.falls_at) = (0, u64::MAX);
            self.wire_lines();
        }
    }

    /// Lines of interrupts, after a store: one that has cleared a flag is still on its way, and the
    /// interrupt controller sees its line high until it has arrived.
    pub(super) fn wire_lines_by_store(&mut self) {
        for (interrupt, high) in self.lines() {
            if high {
                self.system.nvic.set_line(interrupt, true);
            } else if self.system.nvic.line(interrupt) {
                self.falling |= 1 << interrupt;
                self.falls_at = self.now + STORE_CYCLES;
                self.next_event = self.next_event.min(self.falls_at);
            }
        }
    }

    /// Lines of interrupts.
    pub(super) fn wire_lines(&mut self) {
        for (interrupt, high) in self.lines() {
            if high || self.falling >> interrupt & 1 == 0 {
                self.system.nvic.set_line(interrupt, high);
            }
        }
    }

    fn lines(&self) -> [(u16, bool); 6] {
        [
            self.exti.line(DATA_READY_PIN),
            self.exti.supply_line(),
            (timer::INTERRUPT, self.timer.line() && !self.has_dead_timer),
            (usart::INTERRUPT, self.usart.line()),
            self.dma.line(dma::RECEIVING),
            self.dma.line(dma::SENDING),
        ]
    }
}
