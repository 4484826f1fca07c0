//! The sensor board around its core: peripherals, converter, sensor, and the wires between them.
//!
//! ```text
//! PA4 PA5 PA6 PA7 ── converter on SPI1      PB4 ── its data-ready      PB0 ── its reset
//! PA2 PA3 ────────── the host on USART2     PC0 … PC5 ── heaters, pulled down
//! ```
//!
//! | file | what |
//! |---|---|
//! | `address_map` | which register stands where |
//! | `wires` | pins, lines of interrupts, the converter's bus |
//! | `events` | what is due by itself |
//! | `supply` | the supply, as it falls and rises |
//! | `cut_off` | the platinum's supply, which the LED's pin holds up |
//! | `waiting` | loops that wait, of which most rounds are left out |
//! | `core_bus` | the board as its core sees it |

mod address_map;
mod core_bus;
mod cut_off;
mod events;
mod supply;
mod waiting;
mod wires;

pub use cut_off::HOLDS;

use crate::adc::{Adc, AdcFault};
use crate::complaint::Complaints;
use crate::host_line::HostLine;
use crate::plant::SensorPlant;
use crate::processor::SystemControl;
use crate::processor::bus::MemoryJob;
use crate::processor::nvic::NMI;
use crate::soc::access::{Access, Clocks};
use crate::soc::dma::Dma;
use crate::soc::exti::Exti;
use crate::soc::flash::Flash;
use crate::soc::gpio::GpioPort;
use crate::soc::power::Power;
use crate::soc::rcc::{Rcc, ResetSource};
use crate::soc::spi::Spi;
use crate::soc::timer::Timer;
use crate::soc::usart::Usart;
use crate::soc::watchdog::IndependentWatchdogModel;
use crate::witness::HeaterWitness;
use cut_off::PlatinumSupply;
use std::collections::BTreeMap;
use waiting::WaitingLoop;

const HEATERS: u32 = 0x3f;
const SELECT_PIN: u32 = 4;
const BUS_PINS: [u32; 3] = [5, 6, 7];
const BUS_FUNCTION: u32 = 5;
const LINE_PINS: [u32; 2] = [2, 3];
const LINE_FUNCTION: u32 = 7;
const RESET_PIN: u32 = 0;
const DATA_READY_PIN: u32 = 4;
const LED_PIN: u32 = 1;
const PORT_B: u32 = 1;
/// DBGMCU_CR, whose lowest bit keeps the core's clock running in sleep.
const DEBUG_CONTROL: u32 = 0xe004_2004;
const DEBUG_SLEEP: u32 = 1;
/// DBGMCU_APB1_FZ, and in it the watchdog.
const DEBUG_FREEZE: u32 = 0xe004_2008;
const DEBUG_FREEZE_WATCHDOG: u32 = 1 << 12;
/// Cost of an access to a peripheral beside the instruction.
const ACCESS_CYCLES: u64 = 2;
/// Longest way of a store to a peripheral of APB1, which runs at a quarter of the core's clock: two
/// of its cycles, and the bridge. The core goes on meanwhile.
const STORE_CYCLES: u64 = 12;

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
    /// Rest of a cycle where the core's are longer than ours.
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
    holds_back: bool,
    /// Interrupts whose lines fall as soon as the last store has arrived, and when that is.
    falling: u128,
    falls_at: u64,
    /// Clock gates that were opened by the last stores, and since when.
    opened: [u32; 3],
    opened_at: u64,
    /// The dead-man timer's interrupt never comes.
    has_dead_timer: bool,
    /// Nothing pulls the heaters down: a pin that floats may be high.
    lacks_pull_downs: bool,
    waiting: Option<WaitingLoop>,
    /// Since when a debugger holds the core.
    held_since: Option<u64>,
    /// Registers that only remember what was written.
    remembered: BTreeMap<u32, u32>,
    system: SystemControl,
    rcc: Rcc,
    power: Power,
    /// Flash and settings.
    pub flash: Flash,
    ports: [GpioPort; 3],
    exti: Exti,
    spi: Spi,
    usart: Usart,
    dma: Dma,
    timer: Timer,
    stopwatch: Timer,
    /// Heaters whose pins a short holds high, and low.
    heater_shorts: (u32, u32),
    /// The watchdog.
    pub watchdog: IndependentWatchdogModel,
    /// The converter.
    pub adc: Adc,
    /// The sensor.
    pub plant: SensorPlant,
    /// The other end of the line.
    pub host: HostLine,
    /// Complaints about the firmware.
    pub complaints: Complaints,
    /// Every change of the heaters.
    pub pins: Vec<PinChange>,
    /// Witness that holds them against the board's reports.
    pub witness: HeaterWitness,
    platinum_supply: PlatinumSupply,
    /// Number of times that the platinum has been without its supply; once before the start.
    pub platinum_cuts: u32,
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
        let flash = Flash::default();
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
            holds_back: false,
            falling: 0,
            falls_at: u64::MAX,
            opened: [0; 3],
            opened_at: 0,
            has_dead_timer: false,
            lacks_pull_downs: false,
            waiting: None,
            held_since: None,
            remembered: BTreeMap::new(),
            system: SystemControl::default(),
            rcc,
            power: Power::new(flash.options),
            flash,
            ports: [GpioPort::PORT_A, GpioPort::PORT_B, GpioPort::default()],
            exti: Exti::default(),
            spi: Spi::default(),
            usart: Usart::default(),
            dma: Dma::default(),
            timer: Timer::new(oscillator_hz),
            stopwatch: Timer::new(oscillator_hz),
            heater_shorts: (0, 0),
            watchdog: IndependentWatchdogModel::new(oscillator_hz),
            adc: Adc::powered_at(0),
            plant,
            host: HostLine::default(),
            complaints: Complaints::default(),
            pins: vec![PinChange { cycle: 0, levels: 0 }],
            witness: HeaterWitness::default(),
            platinum_supply: PlatinumSupply::default(),
            platinum_cuts: 0,
        }
    }

    /// Peripherals as after a reset. RAM, flash, sensor, host and, unless the supply was away, the
    /// converter stay what they are.
    pub fn reset(&mut self, source: ResetSource) {
        let mut fresh = Self::new(self.plant.clone(), self.watchdog.oscillator_hz);
        (fresh.now, fresh.next_event) = (self.now, self.now);
        fresh.rcc = Rcc::after(source, self.rcc.status());
        fresh.clocks = fresh.rcc.clocks();
        fresh.watchdog.is_dead = self.watchdog.is_dead;
        fresh.has_dead_timer = self.has_dead_timer;
        fresh.timer.slow_hz = self.timer.slow_hz;
        fresh.rcc.fit_crystal(self.rcc.crystal_hz());
        fresh.heater_shorts = self.heater_shorts;
        fresh.lacks_pull_downs = self.lacks_pull_downs;
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
        fresh.power = self.power.reset(fresh.flash.options);
        if lost_supply {
            fresh.adc = Adc::powered_at(self.now);
        } else {
            fresh.adc = self.adc.clone();
            // A debugger's settings outlast a reset of the system.
            fresh.debug_control = self.debug_control;
        }
        fresh.adc.release(self.now);
        (fresh.platinum_supply, fresh.platinum_cuts) = (self.platinum_supply, self.platinum_cuts);
        *self = fresh;
        self.wire_heaters();
        self.wire_cut_off();
        self.wire_converter();
    }

    /// Reset that is pending.
    pub const fn pending_reset(&self) -> Option<ResetSource> {
        self.pending_reset
    }

    /// The processor is to be reset from outside.
    pub const fn request_reset(&mut self, source: ResetSource) {
        self.pending_reset = Some(source);
        self.attention = true;
    }

    /// Share of the bytes of RAM that the pending reset destroys, %.
    pub const fn ram_lost_percent(&self) -> u32 {
        let keeps_ram = !matches!(self.pending_reset, Some(ResetSource::PowerOn)) || self.power.keeps_ram();
        if keeps_ram { 0 } else { self.power.ram_lost_percent }
    }

    /// From now on gaps of the supply cost so many bytes of RAM, %.
    pub const fn set_ram_lost(&mut self, percent: u32) {
        self.power.ram_lost_percent = percent;
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

    /// A crystal of this frequency, Hz, is fitted.
    pub fn fit_crystal(&mut self, crystal_hz: u64) {
        self.rcc.fit_crystal(crystal_hz);
        self.set_clocks();
        self.touch();
    }

    /// The crystal runs again.
    pub fn mend_crystal(&mut self) {
        self.rcc.mend_crystal();
        self.set_clocks();
        self.touch();
    }

    /// The slow oscillator stops, and the watchdog with it.
    pub const fn fail_slow_oscillator(&mut self) {
        self.watchdog.is_dead = true;
        self.timer.slow_hz = 0;
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
            (None, true) => {
                self.held_since = Some(self.now);
                self.witness.core_stops(self.now);
            }
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

    /// The probe has the watchdog stand still while it holds the core.
    pub fn freeze_watchdog(&mut self) {
        self.remembered.insert(DEBUG_FREEZE, DEBUG_FREEZE_WATCHDOG);
    }

    /// From now on the watchdog is fed right after it was unlocked, as the health task does if it
    /// comes at that moment, unless interrupts are held back. The core is interrupted between
    /// blocks of instructions only, and unlocking and writing are one block.
    pub const fn race_at_watchdog(&mut self) {
        self.races_at_watchdog = true;
    }

    /// The core's clock stands still in every sleep from now on, whatever the firmware asks of the
    /// debugger's registers.
    pub const fn forbid_debug_sleep(&mut self) {
        self.debug_sleep_works = false;
    }

    /// The interrupt of the dead-man timer never comes from now on.
    pub const fn break_timer(&mut self) {
        self.has_dead_timer = true;
    }

    /// The dead-man timer does not count any more, and captures nothing.
    pub fn stop_timer(&mut self) {
        self.timer.slow_hz = 0;
        let mut access = Access { now: self.now, clocks: self.clocks, complaints: &mut self.complaints };
        self.timer.store(0, 0, &mut access);
        self.touch();
    }

    /// The next frame to the host does not leave, since the line asks for no byte. `for_ever`: nor
    /// does the stream obey, until the next reset.
    pub const fn stick_transmitter(&mut self, for_ever: bool) {
        self.dma.stick(for_ever);
    }

    /// The pull-downs of the heaters are missing from now on.
    pub const fn lift_pull_downs(&mut self) {
        self.lacks_pull_downs = true;
    }

    /// From now on the converter has this fault, or none.
    pub const fn set_adc_fault(&mut self, fault: Option<AdcFault>) {
        self.adc.set_fault(fault);
    }

    /// From now on shorts hold these heaters' pins high, and those low.
    pub fn short_heaters(&mut self, high: u32, low: u32) {
        self.heater_shorts = (high, low);
        self.wire_heaters();
    }

    /// A register of the converter takes another value by itself.
    pub fn disturb_adc(&mut self, address: usize, value: u8) {
        self.adc.disturb_register(address, value);
    }

    /// Tells whether the processor pauses as soon as a frame has come for the host.
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
            self.check_scale();
        }
    }
}
