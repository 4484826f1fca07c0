//! The board as its core sees it.

use super::address_map::bit_alias;
use super::waiting::WaitingLoop;
use super::{ACCESS_CYCLES, Board, DEBUG_SLEEP};
use crate::complaint::BrokenRule;
use crate::processor::bus::{BusFault, MemoryJob, ProcessorBus};
use crate::processor::fault::FaultStatus;
use crate::processor::mpu::Mpu;
use crate::processor::nvic::Nvic;
use crate::register_log;
use crate::soc::access::Access;
use crate::soc::flash::SETTINGS;
use crate::time::CYCLES_PER_SECOND;

impl ProcessorBus for Board {
    fn load(&mut self, address: u32, size: usize) -> Result<u32, BusFault> {
        self.now += ACCESS_CYCLES;
        let (now, due) = (self.now, self.next_event.saturating_sub(self.now));
        self.now += WaitingLoop::left_out(&mut self.waiting, address, now, due, self.spi.ends_at());
        if SETTINGS.contains(&address) {
            self.now = self.now.max(self.flash.busy_until());
            let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
            return Ok(self.flash.load_settings((address - SETTINGS.start) as usize, size, &mut access));
        }
        if let Some((word, bit)) = bit_alias(address) {
            register_log::read(word, 4);
            return Ok(self.load_word(word)? >> bit & 1);
        }
        register_log::read(address, size);
        let word = self.load_word(address & !3)?;
        let shifted = word >> (8 * (address & 3));
        Ok(if size == 4 { shifted } else { shifted & ((1 << (8 * size)) - 1) })
    }

    fn holds_back(&mut self, all: bool) {
        self.holds_back = all;
    }

    fn store(&mut self, address: u32, size: usize, value: u32) -> Result<(), BusFault> {
        self.now += ACCESS_CYCLES;
        self.waiting = None;
        if SETTINGS.contains(&address) {
            self.now = self.now.max(self.flash.busy_until());
            let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
            self.flash.program((address - SETTINGS.start) as usize, size, value, &mut access);
            self.check_programming();
            self.attention = true;
            return Ok(());
        }
        if let Some((word, bit)) = bit_alias(address) {
            register_log::written(word, 4, value << bit, 1 << bit);
            let before = self.load_word(word)?;
            return self.store_word(word, 4, before & !(1 << bit) | (value & 1) << bit);
        }
        register_log::written(address, size, value, u32::MAX >> (32 - 8 * size));
        self.store_word(address, size, value)
    }

    fn barrier(&mut self) {
        self.stores_arrive();
        self.opened = [0; 3];
    }

    fn nvic(&mut self) -> &mut Nvic {
        &mut self.system.nvic
    }

    fn faults(&mut self) -> &mut FaultStatus {
        &mut self.system.faults
    }

    fn mpu(&self) -> &Mpu {
        &self.system.mpu
    }

    fn vector_table(&self) -> u32 {
        self.system.vector_table()
    }

    fn now(&self) -> u64 {
        self.now
    }

    fn spend(&mut self, core_cycles: u32) {
        let core_hz = self.clocks.core_hz;
        if core_hz == CYCLES_PER_SECOND {
            self.now += u64::from(core_cycles);
            return;
        }
        let parts = u64::from(core_cycles) * CYCLES_PER_SECOND + self.remainder;
        // A core without a clock spends nothing.
        if let Some(whole) = parts.checked_div(core_hz) {
            self.now += whole;
            self.remainder = parts % core_hz;
        }
    }

    fn pass(&mut self, until: u64, asleep: bool) {
        let passed = until.saturating_sub(self.now);
        self.now += passed;
        let clock_runs = self.debug_sleep_works && self.debug_control & DEBUG_SLEEP != 0;
        if asleep && !clock_runs {
            self.system.cycle_counter.rebase(self.now, self.clocks.core_hz, passed);
        }
    }

    fn settle(&mut self) {
        self.settle_now();
    }

    fn next_event(&self) -> u64 {
        self.next_event
    }

    fn needs_attention(&self) -> bool {
        self.attention
    }

    fn attended(&mut self) {
        self.attention = false;
    }

    fn stalled_until(&self) -> Option<u64> {
        if self.clocks.core_hz == 0 || self.held_since.is_some() || self.power.holds_reset() {
            return Some(u64::MAX);
        }
        let busy_until = self.flash.busy_until();
        (busy_until > self.now).then_some(busy_until)
    }

    fn wants_reset(&self) -> bool {
        self.pending_reset.is_some()
    }

    fn wants_pause(&self) -> bool {
        self.pauses_on_frames && self.host.has_frames()
    }

    fn memory_jobs(&mut self) -> Vec<MemoryJob> {
        std::mem::take(&mut self.jobs)
    }

    fn fetched(&mut self, bytes: &[u8]) {
        let Some(sending) = &mut self.sending else { return };
        if !sending.has_begun {
            sending.has_begun = true;
            sending.bytes = bytes.to_vec();
            return;
        }
        if sending.bytes != bytes {
            self.complaints.add(self.now, "DMA_S6M0AR", BrokenRule::DmaMemoryChanged);
        }
        self.sending = None;
        self.dma.sent();
        self.usart.sent();
        self.witness.heard(self.now, bytes, &mut self.complaints);
        self.host.take(self.now, bytes);
        self.wire_lines();
        self.touch();
    }
}
