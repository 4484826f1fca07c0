//! The whole: an image on its board, run from one time to the next.

use crate::board::{Board, PinChange};
use crate::image::{FlashImage, ImageError};
use crate::log::RttLog;
use crate::plant::SensorPlant;
use crate::processor::bus::ProcessorBus;
use crate::processor::{CoreRegisters, Pause, Processor, ProcessorError};
use crate::register_log;
use crate::soc::power::NOMINAL_MV;
use crate::soc::rcc::ResetSource;
use crate::time::ms;
use host_sim::sensor::{SensorConfig, SensorError};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// The log is read so often; its ring holds a kilobyte.
const LOG_EVERY: u64 = ms(10);

/// A period of the watchdog in which nothing but its proof test can run.
const PROOF_PERIOD: u64 = ms(10);

/// RAM after power-on holds anything; this is one such thing, always the same.
const FRESH_RAM: u8 = 0xa5;

/// Nominal frequency of the watchdog's oscillator.
pub const NOMINAL_OSCILLATOR_HZ: u64 = 32_000;

/// Why there is no machine, or why it cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum MachineError {
    /// The image.
    #[error(transparent)]
    FlashImage(#[from] ImageError),
    /// The sensor.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The emulator.
    #[error(transparent)]
    Processor(#[from] ProcessorError),
}

/// Parts that a machine is made from.
#[derive(Clone, Debug, Default)]
pub struct MachineConfig {
    /// The sensor at its pins; the sample period is the machine's own.
    pub sensor: SensorConfig,
    /// Frequency of the watchdog's oscillator, 17 to 47 kHz; `None` is the nominal one.
    pub oscillator_hz: Option<u64>,
}

/// A reset that has happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PastReset {
    /// When.
    pub cycle: u64,
    /// Why.
    pub source: ResetSource,
}

/// An image on its board.
pub struct Machine {
    image: Arc<FlashImage>,
    core: Processor<Board>,
    log: RttLog,
    resets: Vec<PastReset>,
    proofs: usize,
}

/// Everything that a machine is between two instructions.
#[derive(Clone)]
pub struct Snapshot {
    board: Board,
    ram: Vec<u8>,
    core: (bool, bool, CoreRegisters),
    log: RttLog,
    resets: Vec<PastReset>,
    proofs: usize,
}

impl Machine {
    /// Switches an image on.
    ///
    /// # Errors
    /// If the image or the sensor is none.
    pub fn power_on(image: &Path, config: &MachineConfig) -> Result<Self, MachineError> {
        Self::power_on_image(Arc::new(FlashImage::read(image)?), config)
    }

    /// The same with an image that has been read.
    ///
    /// # Errors
    /// If the sensor is none.
    pub fn power_on_image(image: Arc<FlashImage>, config: &MachineConfig) -> Result<Self, MachineError> {
        register_log::begin();
        let oscillator_hz = config.oscillator_hz.unwrap_or(NOMINAL_OSCILLATOR_HZ);
        let board = Board::new(SensorPlant::new(&config.sensor)?, oscillator_hz);
        let mut core = Processor::new(board, &image.flash)?;
        core.set_ram(&vec![FRESH_RAM; core.ram()?.len()])?;
        core.start()?;
        Ok(Self { image, core, log: RttLog::default(), resets: Vec::new(), proofs: 0 })
    }

    /// The time.
    pub fn now(&self) -> u64 {
        self.core.bus().now()
    }

    /// The board.
    pub fn board(&self) -> &Board {
        self.core.bus()
    }

    /// The board, to do something to it.
    pub fn board_mut(&mut self) -> &mut Board {
        self.core.bus_mut()
    }

    /// The core, to do something to it.
    pub const fn core_mut(&mut self) -> &mut Processor<Board> {
        &mut self.core
    }

    /// Longest time of each handler so far, cycles, by its exception; without those that have
    /// interrupted it.
    pub const fn handler_times(&self) -> &BTreeMap<u16, u64> {
        self.core.handler_times().longest()
    }

    /// Resets by which the firmware has proved its watchdog: with a period far below any that lets
    /// it work.
    pub const fn proofs(&self) -> usize {
        self.proofs
    }

    /// All other resets so far.
    pub fn resets(&self) -> &[PastReset] {
        &self.resets
    }

    /// Changes of the heaters so far.
    pub fn pins(&self) -> &[PinChange] {
        &self.board().pins
    }

    /// The lines of the firmware's log.
    pub fn log(&self) -> Vec<String> {
        self.log.lines(&self.image)
    }

    /// Runs until this time.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn run_until(&mut self, until: u64) -> Result<(), MachineError> {
        self.run(until, false)
    }

    /// Runs for so many cycles.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn run_for(&mut self, cycles: u64) -> Result<(), MachineError> {
        self.run_until(self.now() + cycles)
    }

    /// Runs until this time, or until something has come for the host.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn run_until_frame(&mut self, until: u64) -> Result<(), MachineError> {
        self.run(until, true)
    }

    fn run(&mut self, until: u64, pauses_on_frames: bool) -> Result<(), MachineError> {
        while self.now() < until && !(pauses_on_frames && self.board().host.has_frames()) {
            let slice = until.min(self.now() + LOG_EVERY);
            // A reset forgets it.
            self.board_mut().pause_on_frames(pauses_on_frames);
            if self.core.run(slice)? == Pause::Reset {
                self.reset()?;
            }
            self.log.collect(&self.image, &mut self.core)?;
        }
        Ok(())
    }

    /// The supply falls to a voltage, mV, stays there for so many cycles, and comes back.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn dip(&mut self, supply_mv: u32, cycles: u64) -> Result<(), MachineError> {
        self.board_mut().set_supply(supply_mv);
        self.run_for(cycles)?;
        self.board_mut().set_supply(NOMINAL_MV);
        Ok(())
    }

    /// Masks all interrupts, as a task would that never ends.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn mask_interrupts(&mut self) -> Result<(), MachineError> {
        let now = self.now();
        self.board_mut().witness.core_stops(now);
        Ok(self.core.mask_interrupts()?)
    }

    /// Resets the processor from outside: the pin, or the supply.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn reset_by(&mut self, source: ResetSource) -> Result<(), MachineError> {
        self.board_mut().request_reset(source);
        self.reset()
    }

    fn reset(&mut self) -> Result<(), MachineError> {
        self.log.collect(&self.image, &mut self.core)?;
        let Some(source) = self.board().pending_reset() else { return Ok(()) };
        if source == ResetSource::Watchdog && self.board().watchdog.period() < PROOF_PERIOD {
            self.proofs += 1;
        } else {
            self.resets.push(PastReset { cycle: self.now(), source });
        }
        let lost_percent = self.board().ram_lost_percent();
        self.board_mut().reset(source);
        if lost_percent > 0 {
            let mut bytes = self.core.ram()?;
            decay(&mut bytes, lost_percent, self.now());
            self.core.set_ram(&bytes)?;
        }
        Ok(self.core.start()?)
    }

    /// Everything as it is now.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn snapshot(&self) -> Result<Snapshot, MachineError> {
        Ok(Snapshot {
            board: self.board().clone(),
            ram: self.core.ram()?,
            core: self.core.state()?,
            log: self.log.clone(),
            resets: self.resets.clone(),
            proofs: self.proofs,
        })
    }

    /// Everything as it was then.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), MachineError> {
        *self.board_mut() = snapshot.board.clone();
        self.core.set_ram(&snapshot.ram)?;
        self.core.set_state(&snapshot.core)?;
        self.log = snapshot.log.clone();
        (self.resets, self.proofs) = (snapshot.resets.clone(), snapshot.proofs);
        Ok(())
    }
}

/// A share of the bytes becomes another one: by the time, so that it is the same again.
fn decay(bytes: &mut [u8], percent: u32, now: u64) {
    let mut chance = now | 1;
    for byte in bytes {
        chance ^= chance << 13;
        chance ^= chance >> 7;
        chance ^= chance << 17;
        if percent >= 100 {
            *byte = FRESH_RAM;
        } else if chance as u32 % 100 < percent {
            *byte = (chance >> 32) as u8;
        }
    }
}
