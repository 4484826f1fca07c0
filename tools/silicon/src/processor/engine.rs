//! Unicorn with the board's memory map, and the loop that runs it from one stop to the next.
//!
//! A hook at the head of every block of instructions charges the block's cycles, and stops where
//! something is due, waits, or has been asked for. It is the only thing that is called often; loads
//! and stores of RAM and code go by no hook at all. A stop is therefore at the head of a block, and
//! an interrupt is late by the rest of one, some ten instructions.
//!
//! The sectors of the settings are registers rather than memory here: loads and stores of them go
//! to the model of the flash. ST's system memory is answered here, address by address, since a
//! region of the memory protection may be smaller than Unicorn's pages.

use super::bus::{BusFault, MemoryJob, ProcessorBus};
use super::cycles::BlockCosts;
use super::exception::{self, ENTRY_CYCLES, RETURN_CYCLES};
use super::fault::{Fault, Purpose};
use super::handler_times::HandlerTimes;
use super::mpu::{ALL_RIGHTS, MemoryRights, Mpu};
use super::nvic::HARD_FAULT;
use std::ops::Range;
use unicorn_engine::{Arch, ArmCpuModel, HookType, MemType, Mode, Prot, RegisterARM, Unicorn, uc_error};

const FLASH: u64 = 0x0800_0000;
/// Sectors 1 to 3.
const SETTINGS: Range<u64> = 0x0800_4000..0x0801_0000;
const FLASH_END: u64 = 0x0810_0000;
/// ST's own memory, of which a number that is unique is read (RM0090, 39.1).
const SYSTEM_MEMORY: Range<u64> = 0x1fff_7000..0x1fff_8000;
const UNIQUE_ID: u64 = 0x1fff_7a10;
const UNIQUE_ID_BYTES: &[u8; 12] = b"anemo-unique";
/// Unicorn gives rights by pages of this size.
const PAGE: u64 = 1024;
/// The smallest region of the memory protection.
const LEAST_REGION: usize = 32;
pub(super) const RAM: u64 = 0x2000_0000;
pub(super) const RAM_BYTES: usize = 128 * 1024;
/// Memory that Unicorn holds itself.
const MEMORIES: [Range<u64>; 3] = [RAM..RAM + RAM_BYTES as u64, FLASH..SETTINGS.start, SETTINGS.end..FLASH_END];
/// Settings; ST's memory; peripherals; their aliases by bits; the core's own.
const REGISTERS: [Range<u64>; 5] =
    [SETTINGS, SYSTEM_MEMORY, 0x4000_0000..0x4010_0000, 0x4200_0000..0x4400_0000, 0xe000_0000..0xe010_0000];
/// Charge for a sleep that ends at once, since something waits that a mask keeps from being
/// handled: an idle task would go round and round.
const FUTILE_SLEEP_CYCLES: u32 = 1_000;
/// Number by which Unicorn names the jump to a value that returns from an exception.
const EXCEPTION_EXIT: u32 = 8;
/// And a breakpoint, a place that is no code, an instruction of a coprocessor.
const BREAKPOINT: u32 = 7;
const PREFETCH_ABORT: u32 = 3;
const NO_COPROCESSOR: u32 = 17;
/// Bit of xPSR.
const THUMB: u64 = 1 << 24;
/// Where no code stands, so that no block is the last. Zero, since Unicorn translates whatever is
/// at another address anew after every stop.
const NOWHERE: u64 = 0;
const WFI: [u8; 2] = [0x30, 0xbf];
/// DSB SY.
const BARRIER: [u8; 4] = [0xbf, 0xf3, 0x4f, 0x8f];

/// Why the emulator could not go on: an error of its own, not of the firmware.
#[derive(Debug, thiserror::Error)]
#[error("the emulated core cannot go on: {0:?}")]
pub struct ProcessorError(uc_error);

impl From<uc_error> for ProcessorError {
    fn from(error: uc_error) -> Self {
        Self(error)
    }
}

/// Why the processor paused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pause {
    /// The time has come.
    Time,
    /// It is to be reset.
    Reset,
    /// Its surroundings have asked for it.
    Asked,
    /// It stands at a breakpoint, and somebody is there who wants to know
    /// ([`Processor::halt_at_breakpoints`]).
    Breakpoint,
}

/// Surroundings that the hooks share with the loop.
pub struct Surroundings<B> {
    bus: B,
    costs: BlockCosts,
    /// When the block hook stops at the latest.
    stop_at: u64,
    /// Something waits that only a mask keeps from being handled.
    pub(super) is_masked: bool,
    /// The last stop was asked for by a hook.
    stopped: bool,
    pub(super) exception: Option<u32>,
    pub(super) refused: Option<Fault>,
    emulated_blocks: u64,
}

/// A processor with what is around it.
pub struct Processor<B: ProcessorBus + 'static> {
    pub(super) unicorn: Unicorn<'static, Surroundings<B>>,
    pub(super) is_asleep: bool,
    pub(super) is_locked: bool,
    pub(super) halts: bool,
    at_breakpoint: bool,
    pub(super) handler_times: HandlerTimes,
    /// Protection of the memories now.
    protected_by: Mpu,
}

impl<B: ProcessorBus + 'static> Processor<B> {
    /// A processor with this flash, not started yet.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn new(bus: B, flash: &[u8]) -> Result<Self, ProcessorError> {
        let surroundings = Surroundings {
            bus,
            costs: BlockCosts::default(),
            stop_at: 0,
            is_masked: false,
            stopped: false,
            exception: None,
            refused: None,
            emulated_blocks: 0,
        };
        let mut unicorn = Unicorn::new_with_data(Arch::ARM, Mode::MCLASS, surroundings)?;
        unicorn.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
        // The first of all: Unicorn may give later ones overlapping places in its own books, and a
        // store to RAM would then throw away translated code. Code is never stored to.
        unicorn.mem_map(RAM, RAM_BYTES as u64, Prot::ALL)?;
        for code in [FLASH..SETTINGS.start, SETTINGS.end..FLASH_END] {
            unicorn.mem_map(code.start, code.end - code.start, Prot::READ | Prot::EXEC)?;
            let bytes = &flash[(code.start - FLASH) as usize..(code.end - FLASH) as usize];
            unicorn.mem_write(code.start, bytes)?;
        }
        for Range { start, end } in REGISTERS {
            unicorn.mmio_map(
                start,
                end - start,
                Some(move |unicorn: &mut Unicorn<'_, Surroundings<B>>, offset: u64, size: usize| {
                    let address = (start + offset) as u32;
                    let around = unicorn.get_data_mut();
                    let may_read = is_core(address) || rights(&mut around.bus, address).read;
                    let is_system_memory = SYSTEM_MEMORY.contains(&u64::from(address));
                    let loaded = match may_read {
                        true if is_system_memory => Ok(system_memory(address, size)),
                        true => around.bus.load(address, size),
                        false => Err(BusFault(address)),
                    };
                    match loaded {
                        Ok(value) => u64::from(value),
                        Err(_) => {
                            around.refused = Some(Fault::Access(Purpose::Load, address));
                            0
                        }
                    }
                }),
                Some(move |unicorn: &mut Unicorn<'_, Surroundings<B>>, offset: u64, size: usize, value: u64| {
                    let address = (start + offset) as u32;
                    let is_masked = unicorn.reg_read(RegisterARM::PRIMASK).is_ok_and(|mask| mask & 1 == 1);
                    let around = unicorn.get_data_mut();
                    around.bus.holds_back(is_masked);
                    let is_system_memory = SYSTEM_MEMORY.contains(&u64::from(address));
                    let may_write = is_core(address) || !is_system_memory && rights(&mut around.bus, address).write;
                    if !may_write || around.bus.store(address, size, value as u32).is_err() {
                        around.refused = Some(Fault::Access(Purpose::Store, address));
                    }
                    do_memory_jobs(unicorn);
                }),
            )?;
        }
        unicorn.add_mem_hook(HookType::MEM_INVALID, 1, 0, |unicorn, kind, address, _, _| {
            let purpose = match kind {
                MemType::READ_UNMAPPED | MemType::READ_PROT => Purpose::Load,
                MemType::WRITE_UNMAPPED | MemType::WRITE_PROT => Purpose::Store,
                _ => Purpose::Instruction,
            };
            unicorn.get_data_mut().refused = Some(Fault::Access(purpose, address as u32));
            false
        })?;
        unicorn.add_block_hook(1, 0, at_block)?;
        for (place, _) in flash.windows(4).enumerate().step_by(2).filter(|(_, code)| *code == BARRIER) {
            let address = FLASH + place as u64;
            unicorn.add_code_hook(address, address, |unicorn, _, _| unicorn.get_data_mut().bus.barrier())?;
        }
        unicorn.add_intr_hook(|unicorn, number| {
            unicorn.get_data_mut().exception = Some(number);
            unicorn.emu_stop().ok();
        })?;
        let protected_by = Mpu::default();
        let handler_times = HandlerTimes::default();
        Ok(Self {
            unicorn,
            is_asleep: false,
            is_locked: false,
            halts: false,
            at_breakpoint: false,
            handler_times,
            protected_by,
        })
    }

    /// Bus around it.
    pub fn bus(&self) -> &B {
        &self.unicorn.get_data().bus
    }

    /// Bus around it.
    pub fn bus_mut(&mut self) -> &mut B {
        &mut self.unicorn.get_data_mut().bus
    }

    /// Blocks of instructions so far.
    pub fn emulated_blocks(&self) -> u64 {
        self.unicorn.get_data().emulated_blocks
    }

    /// Starts at the reset vector.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn start(&mut self) -> Result<(), ProcessorError> {
        (self.is_asleep, self.is_locked) = (false, false);
        self.handler_times.abandon();
        for register in [RegisterARM::PRIMASK, RegisterARM::BASEPRI, RegisterARM::FAULTMASK, RegisterARM::CONTROL] {
            self.unicorn.reg_write(register, 0)?;
        }
        self.unicorn.reg_write(RegisterARM::XPSR, 1 << 24)?;
        self.unicorn.reg_write(RegisterARM::IPSR, 0)?;
        self.unicorn.reg_write(RegisterARM::LR, 0xffff_ffff)?;
        let table = self.bus().vector_table();
        let (stack, entry) = (self.word(table)?, self.word(table + 4)?);
        self.unicorn.reg_write(RegisterARM::SP, stack.into())?;
        Ok(self.unicorn.set_pc(u64::from(entry | 1))?)
    }

    /// Runs until this time, or until it is to be reset.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn run(&mut self, until: u64) -> Result<Pause, ProcessorError> {
        loop {
            self.bus_mut().settle();
            do_memory_jobs(&mut self.unicorn);
            let is_locked = self.is_locked;
            let bus = self.bus_mut();
            if bus.wants_reset() {
                return Ok(Pause::Reset);
            }
            let (now, next) = (bus.now(), bus.next_event().min(until));
            if now >= until {
                return Ok(Pause::Time);
            }
            if bus.wants_pause() {
                return Ok(Pause::Asked);
            }
            // A core that has given up waits for its watchdog.
            let stalled_until = bus.stalled_until().filter(|&end| end > now);
            if is_locked || stalled_until.is_some() {
                bus.pass(next.min(stalled_until.unwrap_or(u64::MAX)), false);
                continue;
            }
            bus.attended();
            self.take_exceptions()?;
            self.protect()?;
            if self.is_asleep {
                if self.bus_mut().nvic().wakes() {
                    self.is_asleep = false;
                    if self.unicorn.get_data().is_masked {
                        self.bus_mut().spend(FUTILE_SLEEP_CYCLES);
                    }
                } else {
                    self.bus_mut().pass(next, true);
                }
                continue;
            }
            self.emulate(next)?;
            if std::mem::take(&mut self.at_breakpoint) {
                return Ok(Pause::Breakpoint);
            }
        }
    }

    /// Gives the memories the rights that the memory protection unit says, if it has changed.
    fn protect(&mut self) -> Result<(), ProcessorError> {
        let mpu = effective_mpu(self.bus_mut());
        if mpu == self.protected_by {
            return Ok(());
        }
        self.protected_by = mpu;
        for Range { start, end } in MEMORIES {
            let mut from = start;
            while from < end {
                let allowed = page_rights(&mpu, from);
                let pages = (from..end).step_by(PAGE as usize);
                let to = pages.clone().find(|&page| page_rights(&mpu, page) != allowed).unwrap_or(end);
                self.unicorn.mem_protect(from, to - from, allowed)?;
                from = to;
            }
        }
        Ok(())
    }

    /// Emulates instructions until something asks for a stop.
    fn emulate(&mut self, stop_at: u64) -> Result<(), ProcessorError> {
        let around = self.unicorn.get_data_mut();
        (around.stop_at, around.stopped) = (stop_at, false);
        let start = self.unicorn.pc_read()?;
        // A core that is asked to sleep while something waits goes on, and Unicorn would not.
        let mut code = [0; 2];
        if self.unicorn.mem_read(start & !1, &mut code).is_ok() && code == WFI {
            self.unicorn.get_data_mut().bus.spend(1);
            self.unicorn.set_pc(((start & !1) + 2) | 1)?;
            self.is_asleep = true;
            return Ok(());
        }
        let ended = self.unicorn.emu_start(start | 1, NOWHERE, 0, 0);
        let around = self.unicorn.get_data_mut();
        if let Some(number) = around.exception.take() {
            return self.unicorn_exception(number);
        }
        if let Some(refused) = around.refused.take() {
            return self.fault(refused);
        }
        if ended.is_err() {
            let is_thumb = self.unicorn.reg_read(RegisterARM::XPSR)? & THUMB != 0;
            return self.fault(if is_thumb { Fault::Undefined } else { Fault::NotThumb });
        }
        if !around.stopped {
            self.is_asleep = true;
        }
        Ok(())
    }

    /// Exceptions that Unicorn leaves to us: returns from exceptions, and instructions that are
    /// faults here.
    fn unicorn_exception(&mut self, number: u32) -> Result<(), ProcessorError> {
        if number == BREAKPOINT && self.halts {
            self.at_breakpoint = true;
            return Ok(());
        }
        if number != EXCEPTION_EXIT {
            return self.fault(match number {
                PREFETCH_ABORT => Fault::Access(Purpose::Instruction, self.unicorn.pc_read()? as u32),
                NO_COPROCESSOR => Fault::NoCoprocessor,
                _ => Fault::Undefined,
            });
        }
        let counter = self.unicorn.reg_read(RegisterARM::PC)? as u32;
        let link = if counter >> 28 == 0xf { counter } else { self.unicorn.reg_read(RegisterARM::LR)? as u32 };
        match exception::leave(&mut self.unicorn, link) {
            Ok(ended) => {
                let bus = self.bus_mut();
                bus.settle();
                bus.nvic().leave(ended);
                bus.spend(RETURN_CYCLES);
                let now = bus.now();
                self.handler_times.leave(ended, now);
                Ok(())
            }
            Err(_) => self.frame_fault(),
        }
    }

    /// Handles what waits and goes before what runs.
    fn take_exceptions(&mut self) -> Result<(), ProcessorError> {
        loop {
            let running = self.bus_mut().nvic().running_priority();
            let Some(exception) = self.bus_mut().nvic().next_before(running) else {
                self.unicorn.get_data_mut().is_masked = false;
                return Ok(());
            };
            let masked = mask(&self.unicorn)?;
            let is_masked = self.bus_mut().nvic().next_before(running.min(masked)) != Some(exception);
            self.unicorn.get_data_mut().is_masked = is_masked;
            if is_masked {
                return Ok(());
            }
            self.is_asleep = false;
            self.enter(exception)?;
        }
    }

    fn enter(&mut self, exception: u16) -> Result<(), ProcessorError> {
        let handler = self.word(self.bus().vector_table() + 4 * u32::from(exception))?;
        let entered = exception::enter(&mut self.unicorn, exception, handler);
        let now = self.bus().now();
        self.handler_times.enter(exception, now);
        let bus = self.bus_mut();
        bus.nvic().enter(exception);
        bus.spend(ENTRY_CYCLES);
        // A frame that could not be stored.
        if entered.is_err() { self.frame_fault() } else { Ok(()) }
    }

    fn frame_fault(&mut self) -> Result<(), ProcessorError> {
        let stack = self.unicorn.reg_read(RegisterARM::SP)? as u32;
        self.fault(Fault::Access(Purpose::Frame, stack))
    }

    /// A fault: there is but the hard fault, and inside it the core gives up.
    fn fault(&mut self, fault: Fault) -> Result<(), ProcessorError> {
        let bus = self.bus_mut();
        let rights = match fault {
            Fault::Access(_, address) => rights(bus, address),
            _ => ALL_RIGHTS,
        };
        bus.faults().note(fault, rights);
        let is_in_fault = self.bus_mut().nvic().running_priority() <= -1;
        if is_in_fault {
            self.is_locked = true;
            return Ok(());
        }
        let handler = self.word(self.bus().vector_table() + 4 * u32::from(HARD_FAULT))?;
        // The hard fault's handler copes with a frame that is none.
        exception::enter(&mut self.unicorn, HARD_FAULT, handler).ok();
        let bus = self.bus_mut();
        bus.nvic().enter(HARD_FAULT);
        bus.spend(ENTRY_CYCLES);
        Ok(())
    }

    fn word(&self, address: u32) -> Result<u32, ProcessorError> {
        let mut bytes = [0; 4];
        self.unicorn.mem_read(address.into(), &mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }
}

/// Rights that hold in all of a page of Unicorn.
fn page_rights(mpu: &Mpu, page: u64) -> Prot {
    let all = (page..page + PAGE).step_by(LEAST_REGION).map(|address| mpu.rights(address as u32));
    // Code is never stored to: that is a fault with or without protection.
    let first = MemoryRights { read: true, write: page >= RAM, execute: true };
    let rights = all.fold(first, |rights, of| MemoryRights {
        read: rights.read && of.read,
        write: rights.write && of.write,
        execute: rights.execute && of.execute,
    });
    let mut allowed = Prot::NONE;
    for (is_allowed, right) in [(rights.read, Prot::READ), (rights.write, Prot::WRITE), (rights.execute, Prot::EXEC)] {
        if is_allowed {
            allowed |= right;
        }
    }
    allowed
}

/// Bytes of ST's memory: the number that is unique, and what flash holds that is erased.
fn system_memory(address: u32, size: usize) -> u32 {
    let byte = |i: u64| {
        let place = (u64::from(address) + i).checked_sub(UNIQUE_ID);
        place.and_then(|place| UNIQUE_ID_BYTES.get(place as usize)).copied().unwrap_or(0xff)
    };
    (0..size as u64).rev().fold(0, |word, i| word << 8 | u32::from(byte(i)))
}

/// Tells whether it is a register of the core, which is outside of the memory protection.
const fn is_core(address: u32) -> bool {
    address >> 20 == 0xe00
}

/// The memory protection that is in force: none in the handlers of NMI and hard fault, unless
/// HFNMIENA is set (ARMv7-M architecture, "MPU Control Register").
fn effective_mpu<B: ProcessorBus>(bus: &mut B) -> Mpu {
    if bus.nvic().running_priority() < 0 && !bus.mpu().protects_faults() { Mpu::default() } else { *bus.mpu() }
}

fn rights<B: ProcessorBus>(bus: &mut B, address: u32) -> MemoryRights {
    effective_mpu(bus).rights(address)
}

/// The priority before which nothing is handled, by the mask registers.
fn mask<D>(unicorn: &Unicorn<'_, D>) -> Result<i32, uc_error> {
    if unicorn.reg_read(RegisterARM::FAULTMASK)? & 1 == 1 {
        return Ok(-1);
    }
    if unicorn.reg_read(RegisterARM::PRIMASK)? & 1 == 1 {
        return Ok(0);
    }
    let base = unicorn.reg_read(RegisterARM::BASEPRI)? as i32 & 0xf0;
    Ok(if base == 0 { i32::MAX } else { base })
}

/// At the head of every block.
fn at_block<B: ProcessorBus>(unicorn: &mut Unicorn<'_, Surroundings<B>>, address: u64, length: u32) {
    let around = unicorn.get_data_mut();
    let mut stops = around.bus.now() >= around.stop_at || around.bus.needs_attention() || around.refused.is_some();
    if !stops && around.is_masked {
        stops = mask(unicorn).is_ok_and(|mask| {
            let nvic = unicorn.get_data_mut().bus.nvic();
            let running = nvic.running_priority();
            nvic.next_before(running.min(mask)).is_some()
        });
    }
    if stops {
        unicorn.get_data_mut().stopped = true;
        unicorn.emu_stop().ok();
        return;
    }
    let cycles = match unicorn.get_data().costs.known(address, length) {
        Some(cycles) => cycles,
        // Code that runs can be read.
        None => {
            let code = unicorn.mem_read_as_vec(address, length as usize).unwrap_or_default();
            unicorn.get_data_mut().costs.learn(address, &code)
        }
    };
    let around = unicorn.get_data_mut();
    around.emulated_blocks += 1;
    around.bus.spend(cycles);
}

/// Does what peripherals want done with the memory.
fn do_memory_jobs<B: ProcessorBus>(unicorn: &mut Unicorn<'_, Surroundings<B>>) {
    for job in unicorn.get_data_mut().bus.memory_jobs() {
        // A stream that is set to a place without memory moves nothing.
        match job {
            MemoryJob::Store { address, byte } => drop(unicorn.mem_write(address.into(), &[byte])),
            MemoryJob::Fetch { address, length } => {
                let bytes = unicorn.mem_read_as_vec(address.into(), length as usize).unwrap_or_default();
                unicorn.get_data_mut().bus.fetched(&bytes);
            }
        }
    }
}
