//! Access of a debug probe: look into memory and registers, and change them.

use super::bus::ProcessorBus;
use super::engine::{Processor, ProcessorError, RAM, RAM_BYTES};
use super::handler_times::HandlerTimes;
use super::registers::CoreRegisters;
use unicorn_engine::{HookType, RegisterARM};

impl<B: ProcessorBus + 'static> Processor<B> {
    /// Bytes of RAM or code.
    ///
    /// # Errors
    /// Where there is no memory.
    pub fn read_memory(&self, address: u32, bytes: &mut [u8]) -> Result<(), ProcessorError> {
        Ok(self.unicorn.mem_read(address.into(), bytes)?)
    }

    /// Puts bytes into RAM.
    ///
    /// # Errors
    /// Where there is no memory.
    pub fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<(), ProcessorError> {
        Ok(self.unicorn.mem_write(address.into(), bytes)?)
    }

    /// The whole RAM.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn ram(&self) -> Result<Vec<u8>, ProcessorError> {
        Ok(self.unicorn.mem_read_as_vec(RAM, RAM_BYTES)?)
    }

    /// Puts the whole RAM back.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn set_ram(&mut self, bytes: &[u8]) -> Result<(), ProcessorError> {
        Ok(self.unicorn.mem_write(RAM, bytes)?)
    }

    /// Tells whether it sleeps, whether it has given up, and all registers.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn state(&self) -> Result<(bool, bool, CoreRegisters), ProcessorError> {
        Ok((self.is_asleep, self.is_locked, CoreRegisters::read(&self.unicorn)?))
    }

    /// Puts that back.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn set_state(&mut self, state: &(bool, bool, CoreRegisters)) -> Result<(), ProcessorError> {
        (self.is_asleep, self.is_locked) = (state.0, state.1);
        self.handler_times.abandon();
        let around = self.unicorn.get_data_mut();
        (around.exception, around.refused, around.is_masked) = (None, None, false);
        Ok(state.2.write(&mut self.unicorn)?)
    }

    /// Masks all interrupts.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn mask_interrupts(&mut self) -> Result<(), ProcessorError> {
        Ok(self.unicorn.reg_write(RegisterARM::PRIMASK, 1)?)
    }

    /// Puts the stack pointer somewhere else, as a stack would that has run over.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn set_stack_pointer(&mut self, address: u32) -> Result<(), ProcessorError> {
        Ok(self.unicorn.reg_write(RegisterARM::SP, address.into())?)
    }

    /// From now on a bit of a word of RAM reads as a one, or as a zero, whatever is written.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn stick_bit(&mut self, word: u32, bit: u32, high: bool) -> Result<(), ProcessorError> {
        let (start, mask) = (u64::from(word & !3), 1_u32 << bit);
        self.unicorn.add_mem_hook(HookType::MEM_READ, start, start + 3, move |unicorn, _, _, _, _| {
            let mut bytes = [0; 4];
            let is_read = unicorn.mem_read(start, &mut bytes).is_ok();
            let word = u32::from_le_bytes(bytes);
            let stuck = if high { word | mask } else { word & !mask };
            is_read && unicorn.mem_write(start, &stuck.to_le_bytes()).is_ok()
        })?;
        // Code that was translated before asks no hook.
        Ok(self.unicorn.ctl_flush_tb()?)
    }

    /// Longest times of the handlers so far.
    pub const fn handler_times(&self) -> &HandlerTimes {
        &self.handler_times
    }

    /// Measures the handlers anew.
    pub fn forget_handler_times(&mut self) {
        self.handler_times = HandlerTimes::default();
    }

    /// Number of the exception that is handled; 0 outside of all handlers.
    pub fn handled(&mut self) -> u16 {
        self.bus_mut().nvic().handled()
    }

    /// A breakpoint is no fault from now on, but a pause.
    pub const fn halt_at_breakpoints(&mut self) {
        self.halts = true;
    }

    /// Where it stands, and what is in r0 and r1.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn arguments(&self) -> Result<(u32, [u32; 2]), ProcessorError> {
        let register = |register| Ok::<_, ProcessorError>(self.unicorn.reg_read(register)? as u32);
        let place = self.unicorn.pc_read()? as u32 & !1;
        Ok((place, [register(RegisterARM::R0)?, register(RegisterARM::R1)?]))
    }

    /// Goes on at `address`, with this in r0, as code would that has gone astray.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn jump(&mut self, address: u32, argument: u32) -> Result<(), ProcessorError> {
        self.is_asleep = false;
        self.unicorn.reg_write(RegisterARM::R0, argument.into())?;
        Ok(self.unicorn.set_pc(u64::from(address | 1))?)
    }
}
