//! The sensor board around its core: peripherals, converter, sensor, and the wires between them.
//!
//! ```text
//! PA4 PA5 PA6 PA7 ── converter on SPI1      PB4 ── its data-ready      PB0 ── its reset
//! PA2 PA3 ────────── the host on USART2     PC0 … PC5 ── heaters, pulled down
//! ```

use crate::adc::{Adc, AdcFault};
use crate::complaint::{BrokenRule, Complaints};
use crate::host_line::HostLine;
use crate::plant::SensorPlant;
use crate::processor::SystemControl;
use crate::processor::bus::{BusFault, MemoryJob, ProcessorBus};
use crate::processor::nvic::{NMI, Nvic, SYSTICK};
use crate::soc::access::{Access, Clocks};
use crate::soc::dma::{self, Dma};
use crate::soc::exti::Exti;
use crate::soc::flash::{Flash, SETTINGS};
use crate::soc::gpio::GpioPort;
use crate::soc::rcc::{Rcc, ResetSource};
use crate::soc::spi::Spi;
use crate::soc::timer::{self, Timer};
use crate::soc::usart::{self, Usart};
use crate::soc::watchdog::IndependentWatchdogModel;
use crate::time::CYCLES_PER_SECOND;
use crate::witness::HeaterWitness;
use std::collections::BTreeMap;

const HEATERS: u32 = 0x3f;
const SELECT_PIN: u32 = 4;
const BUS_PINS: [u32; 3] = [5, 6, 7];
const BUS_FUNCTION: u32 = 5;
const LINE_PINS: [u32; 2] = [2, 3];
const LINE_FUNCTION: u32 = 7;
const RESET_PIN: u32 = 0;
const DATA_READY_PIN: u32 = 4;
const PORT_B: u32 = 1;
/// DBGMCU_CR, whose lowest bit keeps the core's clock running in sleep.
const DEBUG_CONTROL: u32 = 0xe004_2004;
const DEBUG_SLEEP: u32 = 1;
/// DBGMCU_APB1_FZ, and in it the watchdog.
const DEBUG_FREEZE: u32 = 0xe004_2008;
const DEBUG_FREEZE_WATCHDOG: u32 = 1 << 12;
/// What an access to a peripheral costs beside the instruction.
const ACCESS_CYCLES: u64 = 2;

/// Levels of the heaters from some time on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinChange {
    /// Since when.
    pub cycle: u64,
    /// Bit i: heater i is high.
    pub levels: u8,
}

/// The board.
#[derive(Clone, Debug)]
pub struct Board {
    now: u64,
    /// What is left of a cycle where the core's are longer than ours.
    remainder: u64,
    clocks: Clocks,
    next_event: u64,
    attention: bool,
    pending_reset: Option<ResetSource>,
    pauses_on_frames: bool,
    jobs: Vec<MemoryJob>,
    /// Bytes of the frame that is being sent, as they were when it began.
    sending: Option<Sending>,
    debug_control: u32,
    debug_sleep_works: bool,
    races_at_watchdog: bool,
    /// Since when a debugger holds the core.
    held_since: Option<u64>,
    /// Registers that only remember what was written.
    remembered: BTreeMap<u32, u32>,
    system: SystemControl,
    rcc: Rcc,
    /// Flash and settings.
    pub flash: Flash,
    ports: [GpioPort; 3],
    exti: Exti,
    spi: Spi,
    usart: Usart,
    dma: Dma,
    timer: Timer,
    /// The watchdog.
    pub watchdog: IndependentWatchdogModel,
    /// The converter.
    pub adc: Adc,
    /// The sensor.
    pub plant: SensorPlant,
    /// The other end of the line.
    pub host: HostLine,
    /// What the firmware did wrong.
    pub complaints: Complaints,
    /// Every change of the heaters.
    pub pins: Vec<PinChange>,
    /// What holds them against the board's reports.
    pub witness: HeaterWitness,
}

#[derive(Clone, Debug)]
struct Sending {
    address: u32,
    length: u32,
    ends_at: u64,
    bytes: Vec<u8>,
    has_begun: bool,
}

impl Board {
    /// A board whose supply rises now, with this sensor. `oscillator_hz` is the watchdog's.
    pub fn new(plant: SensorPlant, oscillator_hz: u64) -> Self {
        let rcc = Rcc::after(ResetSource::PowerOn, 0);
        Self {
            now: 0,
            remainder: 0,
            clocks: rcc.clocks(),
            next_event: 0,
            attention: true,
            pending_reset: None,
            pauses_on_frames: false,
            jobs: Vec::new(),
            sending: None,
            debug_control: 0,
            debug_sleep_works: true,
            races_at_watchdog: false,
            held_since: None,
            remembered: BTreeMap::new(),
            system: SystemControl::default(),
            rcc,
            flash: Flash::default(),
            ports: [GpioPort::PORT_A, GpioPort::PORT_B, GpioPort::default()],
            exti: Exti::default(),
            spi: Spi::default(),
            usart: Usart::default(),
            dma: Dma::default(),
            timer: Timer::default(),
            watchdog: IndependentWatchdogModel::new(oscillator_hz),
            adc: Adc::powered_at(0),
            plant,
            host: HostLine::default(),
            complaints: Complaints::default(),
            pins: vec![PinChange { cycle: 0, levels: 0 }],
            witness: HeaterWitness::default(),
        }
    }

    /// Peripherals as after a reset. RAM, flash, sensor, host and, unless the supply was away, the
    /// converter stay what they are.
    pub fn reset(&mut self, source: ResetSource) {
        let mut fresh = Self::new(self.plant.clone(), self.watchdog.oscillator_hz);
        (fresh.now, fresh.next_event) = (self.now, self.now);
        fresh.rcc = Rcc::after(source, self.rcc.status());
        fresh.clocks = fresh.rcc.clocks();
        fresh.host = std::mem::take(&mut self.host);
        fresh.complaints = std::mem::take(&mut self.complaints);
        fresh.pins = std::mem::take(&mut self.pins);
        fresh.witness = std::mem::take(&mut self.witness);
        fresh.witness.restarted();
        let lost_supply = matches!(source, ResetSource::PowerOn | ResetSource::BrownOut);
        if lost_supply {
            self.flash.cut_supply(self.now);
        }
        fresh.flash = std::mem::take(&mut self.flash);
        fresh.flash.reset();
        if lost_supply {
            fresh.adc = Adc::powered_at(self.now);
        } else {
            fresh.adc = self.adc.clone();
            // A debugger's settings outlast a reset of the system.
            fresh.debug_control = self.debug_control;
        }
        fresh.adc.release(self.now);
        *self = fresh;
        self.wire_heaters();
        self.wire_converter();
    }

    /// What wants a reset.
    pub const fn pending_reset(&self) -> Option<ResetSource> {
        self.pending_reset
    }

    /// The processor is to be reset from outside.
    pub const fn request_reset(&mut self, source: ResetSource) {
        self.pending_reset = Some(source);
        self.attention = true;
    }

    /// Levels of the heaters.
    pub const fn heaters(&self) -> u8 {
        self.plant.levels()
    }

    /// The crystal stops.
    pub fn fail_crystal(&mut self) {
        if self.rcc.fail_crystal() {
            self.system.nvic.pend(NMI);
        }
        self.set_clocks();
        self.touch();
    }

    /// Connects another sensor.
    pub fn connect(&mut self, mut plant: SensorPlant) {
        plant.follow(&self.plant);
        self.plant = plant;
    }

    /// A debugger holds the core, or lets it go. The watchdog stands still meanwhile if the
    /// firmware has asked for that; all other timers go on.
    pub fn hold_core(&mut self, hold: bool) {
        match (self.held_since, hold) {
            (None, true) => self.held_since = Some(self.now),
            (Some(since), false) => {
                if self.watchdog_stands_still() {
                    self.watchdog.postpone(self.now - since);
                }
                self.held_since = None;
            }
            _ => {}
        }
        self.touch();
    }

    fn watchdog_stands_still(&self) -> bool {
        let frozen = self.remembered.get(&DEBUG_FREEZE).copied().unwrap_or(0);
        self.held_since.is_some() && frozen & DEBUG_FREEZE_WATCHDOG != 0
    }

    fn watchdog_ends_at(&self) -> u64 {
        if self.watchdog_stands_still() { u64::MAX } else { self.watchdog.ends_at() }
    }

    /// From now on the watchdog is fed right after it was unlocked, as the health task does if it
    /// comes at that moment. The core is interrupted between blocks of instructions only, and
    /// unlocking and writing are one block.
    pub const fn race_at_watchdog(&mut self) {
        self.races_at_watchdog = true;
    }

    /// The core's clock stands still in every sleep from now on, whatever the firmware asks of the
    /// debugger's registers.
    pub const fn forbid_debug_sleep(&mut self) {
        self.debug_sleep_works = false;
    }

    /// From now on the converter has this fault, or none.
    pub const fn set_adc_fault(&mut self, fault: Option<AdcFault>) {
        self.adc.set_fault(fault);
    }

    /// Whether the processor pauses as soon as a frame has come for the host.
    pub const fn pause_on_frames(&mut self, pauses: bool) {
        self.pauses_on_frames = pauses;
    }

    /// Bytes of the host, from now on one after the other.
    pub fn receive(&mut self, bytes: &[u8]) {
        self.witness.sent(bytes);
        self.host.queue(self.now, bytes);
        self.touch();
    }

    /// Time of the next event may have changed.
    const fn touch(&mut self) {
        self.next_event = self.now;
        self.attention = true;
    }

    fn set_clocks(&mut self) {
        let clocks = self.rcc.clocks();
        if clocks != self.clocks {
            self.system.cycle_counter.rebase(self.now, self.clocks.core_hz, 0);
            self.clocks = clocks;
        }
    }

    /// Whether a peripheral's clock is on; its complaint if not.
    fn is_clocked(&mut self, address: u32) -> bool {
        let (bus, bit, register) = match address & !0x3ff {
            0x4002_0000 => (0, 0, "GPIOA"),
            0x4002_0400 => (0, 1, "GPIOB"),
            0x4002_0800 => (0, 2, "GPIOC"),
            0x4002_6000 => (0, 21, "DMA1"),
            0x4000_4400 => (1, 17, "USART2"),
            0x4000_0c00 => (1, 3, "TIM5"),
            0x4000_7000 => (1, 28, "PWR"),
            0x4001_3000 => (2, 12, "SPI1"),
            0x4001_3800 => (2, 14, "SYSCFG"),
            _ => return true,
        };
        let is_on = self.rcc.gates()[bus] >> bit & 1 == 1;
        if !is_on {
            self.complaints.add(self.now, register, BrokenRule::ClockOff);
        }
        is_on
    }

    fn load_word(&mut self, address: u32) -> Result<u32, BusFault> {
        if !self.is_clocked(address) {
            return Ok(0);
        }
        let offset = address & 0x3ff;
        let core_hz = self.clocks.core_hz;
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
            0x4002_0800..0x4002_0c00 => self.ports[2].load(offset, 0, 0),
            0x4001_3c00..0x4001_4000 => self.exti.load(offset),
            0x4001_3800..0x4001_3c00 => self.exti.load_config(offset),
            0x4001_3000..0x4001_3400 => self.spi.load(offset),
            0x4000_4400..0x4000_4800 => self.usart.load(offset),
            0x4002_6000..0x4002_6400 => self.dma.load(offset),
            0x4000_0c00..0x4000_1000 => self.timer.load(offset, &access),
            0x4000_3000..0x4000_3400 => self.watchdog.load(offset, &access),
            DEBUG_CONTROL => self.debug_control,
            0x4000_7000..0x4000_7400 | 0xe004_2000..0xe004_2400 => self.remembered.get(&address).copied().unwrap_or(0),
            0xe000_0000..0xe010_0000 => self.system.load(address, self.now, core_hz)?,
            _ => return Err(self.unmodelled(address)),
        };
        if matches!(address, 0x4000_4400..0x4000_4800) {
            self.wire_lines();
        }
        Ok(value)
    }

    fn store_word(&mut self, address: u32, size: usize, value: u32) -> Result<(), BusFault> {
        if !self.is_clocked(address) {
            return Ok(());
        }
        let offset = address & 0x3ff;
        let core_hz = self.clocks.core_hz;
        let wait_states = self.flash.wait_states();
        match address {
            0x4001_3000..0x4001_3400 | 0x4002_0000..0x4002_0800 => self.run_bus(),
            0x4002_6000..0x4002_6400 | 0x4000_0c00..0x4000_1000 => self.settle_now(),
            _ => {}
        }
        let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
        match address {
            0x4002_3800..0x4002_3c00 => {
                self.rcc.store(offset, value, wait_states, &mut access);
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
            0x4000_0c00..0x4000_1000 => self.timer.store(offset, value, &access),
            0x4000_3000..0x4000_3400 => {
                self.watchdog.store(offset, value, &mut access);
                if self.races_at_watchdog && self.watchdog.is_unlocked() {
                    self.watchdog.feed(&mut access);
                }
            }
            DEBUG_CONTROL => self.debug_control = value,
            0x4000_7000..0x4000_7400 | 0xe004_2000..0xe004_2400 => drop(self.remembered.insert(address, value)),
            0xe000_0000..0xe010_0000 => {
                self.system.store(address, size, value, self.now, core_hz)?;
                if self.system.reset_requested {
                    self.request_reset(ResetSource::Software);
                }
            }
            _ => return Err(self.unmodelled(address)),
        }
        match address {
            0x4002_0000..0x4002_0800 => self.wire_converter(),
            0x4002_0800..0x4002_0c00 => self.wire_heaters(),
            // These pins and lines are written thousands of times a second: only what waits
            // afterwards is a reason to stop.
            0x4001_3c00..0x4001_4000 => {
                self.wire_lines();
                self.attention |= self.exti.line(DATA_READY_PIN).1;
            }
            _ => {
                self.wire_lines();
                self.touch();
            }
        }
        Ok(())
    }

    fn unmodelled(&mut self, address: u32) -> BusFault {
        self.complaints.add(self.now, "bus", BrokenRule::Unmodelled(address));
        BusFault(address)
    }

    /// Peripherals that the clock controller holds in reset.
    fn hold_in_reset(&mut self) {
        let [ahb1, apb1, apb2] = self.rcc.resets();
        if ahb1 >> 21 & 1 == 1 {
            (self.dma, self.sending) = (Dma::default(), None);
        }
        if apb1 >> 17 & 1 == 1 {
            self.usart = Usart::default();
        }
        if apb1 >> 3 & 1 == 1 {
            self.timer = Timer::default();
        }
        if apb2 >> 12 & 1 == 1 {
            self.spi = Spi::default();
        }
    }

    /// Bytes that are through on the converter's bus.
    fn run_bus(&mut self) {
        while let Some(byte) = self.spi.take_finished(self.now, self.clocks.apb2_hz) {
            let was_low = self.adc.data_ready_low();
            let answer = self.adc.exchange(byte, &mut self.plant, &mut self.complaints);
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
    fn wire_converter(&mut self) {
        let is_selected = self.ports[0].drives_low(SELECT_PIN);
        if self.spi.is_shifting() && is_selected != self.adc.is_selected() {
            self.complaints.add(self.now, "GPIOA_BSRR", BrokenRule::SelectInsideByte);
        }
        self.adc.select(self.now, is_selected, &mut self.complaints);
        self.adc.set_reset(self.now, self.ports[1].drives_low(RESET_PIN), &mut self.complaints);
    }

    /// Pins of the heaters: those that float are pulled down by the board.
    fn wire_heaters(&mut self) {
        let levels = (self.ports[2].driven_high() & HEATERS) as u8;
        if levels != self.plant.levels() {
            self.plant.set_levels(self.now, levels);
            self.pins.push(PinChange { cycle: self.now, levels });
            self.witness.pins(self.now, levels, &mut self.complaints);
        }
    }

    /// Lines of interrupts.
    fn wire_lines(&mut self) {
        let lines = [
            self.exti.line(DATA_READY_PIN),
            (timer::INTERRUPT, self.timer.line()),
            (usart::INTERRUPT, self.usart.line()),
            self.dma.line(dma::RECEIVING),
            self.dma.line(dma::SENDING),
        ];
        for (interrupt, high) in lines {
            self.system.nvic.set_line(interrupt, high);
        }
    }

    /// Carries out what is due by now.
    fn settle_now(&mut self) {
        if self.next_event > self.now {
            return;
        }
        let (now, clocks) = (self.now, self.clocks);
        while self.adc.next_event() <= now {
            let at = self.adc.next_event();
            let was_low = self.adc.data_ready_low();
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
        self.wire_lines();
        self.next_event = self.find_next_event();
        self.attention = true;
    }

    fn find_next_event(&self) -> u64 {
        let sending = self.sending.as_ref().filter(|sending| sending.has_begun).map_or(u64::MAX, |s| s.ends_at);
        let times = [
            self.adc.next_event(),
            self.system.systick.next_event(self.clocks.core_hz),
            self.timer.next_event(self.clocks.timers1_hz),
            self.host.next_arrival(),
            self.usart.next_event(),
            sending,
            self.watchdog_ends_at(),
        ];
        times.into_iter().min().unwrap_or(u64::MAX)
    }

    fn receive_due(&mut self) {
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

impl ProcessorBus for Board {
    fn load(&mut self, address: u32, size: usize) -> Result<u32, BusFault> {
        self.now += ACCESS_CYCLES;
        if SETTINGS.contains(&address) {
            self.now = self.now.max(self.flash.busy_until());
            let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
            return Ok(self.flash.load_settings((address - SETTINGS.start) as usize, size, &mut access));
        }
        if let Some((word, bit)) = bit_alias(address) {
            return Ok(self.load_word(word)? >> bit & 1);
        }
        let word = self.load_word(address & !3)?;
        let shifted = word >> (8 * (address & 3));
        Ok(if size == 4 { shifted } else { shifted & ((1 << (8 * size)) - 1) })
    }

    fn store(&mut self, address: u32, size: usize, value: u32) -> Result<(), BusFault> {
        self.now += ACCESS_CYCLES;
        if SETTINGS.contains(&address) {
            self.now = self.now.max(self.flash.busy_until());
            let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
            self.flash.program((address - SETTINGS.start) as usize, size, value, &mut access);
            self.attention = true;
            return Ok(());
        }
        if let Some((word, bit)) = bit_alias(address) {
            let before = self.load_word(word)?;
            return self.store_word(word, 4, before & !(1 << bit) | (value & 1) << bit);
        }
        self.store_word(address, size, value)
    }

    fn nvic(&mut self) -> &mut Nvic {
        &mut self.system.nvic
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
        if self.clocks.core_hz == 0 || self.held_since.is_some() {
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

/// The word and the bit that an address in the alias of bits stands for.
const fn bit_alias(address: u32) -> Option<(u32, u32)> {
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
