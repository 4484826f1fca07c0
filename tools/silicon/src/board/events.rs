//! Events that are due by themselves: conversions, timers, bytes, the watchdog.

use super::{Board, DATA_READY_PIN, PORT_B};
use crate::processor::bus::MemoryJob;
use crate::processor::nvic::SYSTICK;
use crate::soc::access::Access;
use crate::soc::rcc::ResetSource;

impl Board {
    /// Carries out what is due by now.
    pub(super) fn settle_now(&mut self) {
        if self.next_event > self.now {
            return;
        }
        let (now, clocks) = (self.now, self.clocks);
        while self.adc.next_event() <= now {
            let at = self.adc.next_event();
            let was_low = self.adc.data_ready_low();
            self.witness.passed(at, &mut self.complaints);
            if self.adc.convert(at, &mut self.plant, &mut self.complaints) {
                if was_low {
                    self.exti.edge(PORT_B, DATA_READY_PIN, true);
                }
                self.exti.edge(PORT_B, DATA_READY_PIN, false);
            }
        }
        if self.system.systick.settle(now, clocks.core_hz) {
            self.system.nvic.pend(SYSTICK);
        }
        self.timer.settle(now, clocks.timers1_hz);
        self.receive_due();
        self.usart.settle(now);
        if let Some(sending) = self.sending.as_mut().filter(|sending| sending.has_begun && sending.ends_at <= now) {
            // Once more, at the end: was it left alone?
            let (address, length) = (sending.address, sending.length);
            self.jobs.push(MemoryJob::Fetch { address, length });
            sending.ends_at = u64::MAX;
        }
        if self.watchdog_ends_at() <= now {
            self.request_reset(ResetSource::Watchdog);
        }
        self.wire_cut_off();
        if self.falls_at <= now {
            self.stores_arrive();
        }
        self.wire_lines();
        self.next_event = self.find_next_event();
        self.attention = true;
    }

    pub(super) fn find_next_event(&self) -> u64 {
        let sending = self.sending.as_ref().filter(|sending| sending.has_begun).map_or(u64::MAX, |s| s.ends_at);
        let times = [
            self.adc.next_event(),
            self.system.systick.next_event(self.clocks.core_hz),
            self.timer.next_event(self.clocks.timers1_hz),
            self.host.next_arrival(),
            self.usart.next_event(),
            sending,
            self.watchdog_ends_at(),
            self.platinum_supply.next_event(),
            self.falls_at,
        ];
        times.into_iter().min().unwrap_or(u64::MAX)
    }

    pub(super) fn receive_due(&mut self) {
        while let Some((at, byte)) = self.host.take_arrived(self.now) {
            let mut access = Access { now: at, clocks: self.clocks, complaints: &mut self.complaints };
            if !self.usart.receive(byte, &mut access) {
                continue;
            }
            match self.dma.receive() {
                Some(address) => self.jobs.push(MemoryJob::Store { address, byte }),
                None => self.usart.lose(&mut access),
            }
        }
    }
}
