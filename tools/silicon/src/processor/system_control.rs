//! The core's own registers: interrupt controller, SysTick, control block, memory protection, cycle
//! counter (ARMv7-M, "System Control Space").

use super::bus::BusFault;
use super::cycle_counter::CycleCounter;
use super::fault::{FAULTS, FAULTS_END, FaultStatus};
use super::mpu::Mpu;
use super::nvic::{FIRST_INTERRUPT, Nvic, PENDSV, SYSTICK};
use super::systick::SysTick;
use std::collections::BTreeMap;

/// Writing this to the upper half of AIRCR makes the write count.
const AIRCR_KEY: u32 = 0x05fa;
const SYSRESETREQ: u32 = 1 << 2;
/// Value that AIRCR reads as: the key's opposite number.
const AIRCR: u32 = 0xfa05_0000;
/// CP10 and CP11 in CPACR, the floating-point unit; there are no other coprocessors.
const CPACR_FPU: u32 = 0xf << 20;
/// Where the flash stands besides at zero.
const FLASH: u32 = 0x0800_0000;
/// MPU_TYPE, and the end of its registers.
pub const MPU: u32 = 0xe000_ed90;
pub const MPU_END: u32 = 0xe000_eda4;
/// Cortex-M4 r0p1.
const CPUID: u32 = 0x410f_c241;

/// Registers of the core.
#[derive(Clone, Debug, Default)]
pub struct SystemControl {
    /// Exceptions.
    pub nvic: Nvic,
    /// Why the core has faulted.
    pub faults: FaultStatus,
    /// Rights to read, write and execute.
    pub mpu: Mpu,
    /// Its timer.
    pub systick: SysTick,
    /// Its cycle counter.
    pub cycle_counter: CycleCounter,
    /// The firmware has asked for a reset.
    pub reset_requested: bool,
    vector_table: u32,
    /// Registers that only remember what was written.
    remembered: BTreeMap<u32, u32>,
}

impl SystemControl {
    /// Where the vectors stand: at zero, which is the flash, unless moved.
    pub const fn vector_table(&self) -> u32 {
        if self.vector_table < FLASH { self.vector_table + FLASH } else { self.vector_table }
    }

    /// Reads a word; `core_hz` is the core's clock.
    ///
    /// # Errors
    /// Where the core has no register.
    pub fn load(&mut self, address: u32, now: u64, core_hz: u64) -> Result<u32, BusFault> {
        Ok(match address {
            0xe000_1000..0xe000_1008 => self.cycle_counter.load(address & 0xf, now, core_hz),
            0xe000_e010..0xe000_e020 => self.systick.load(address & 0xf, now, core_hz),
            0xe000_e100..0xe000_e110 | 0xe000_e180..0xe000_e190 => self.nvic.read_word(address >> 2 & 3, false),
            0xe000_e200..0xe000_e210 | 0xe000_e280..0xe000_e290 => self.nvic.read_word(address >> 2 & 3, true),
            0xe000_e400..0xe000_e4f0 => self.priorities(FIRST_INTERRUPT + (address - 0xe000_e400) as u16),
            0xe000_ed00 => CPUID,
            // ICSR: PENDSTSET, PENDSVSET, VECTACTIVE.
            0xe000_ed04 => {
                self.nvic.waits(SYSTICK) << 26 | self.nvic.waits(PENDSV) << 28 | u32::from(self.nvic.handled())
            }
            0xe000_ed08 => self.vector_table,
            0xe000_ed0c => AIRCR,
            0xe000_ed18..0xe000_ed24 => self.priorities(4 + (address - 0xe000_ed18) as u16),
            FAULTS..FAULTS_END => self.faults.load(address - FAULTS),
            MPU..MPU_END => self.mpu.load(address - MPU),
            0xe000_0000..0xe004_0000 => self.remembered.get(&address).copied().unwrap_or(0),
            _ => return Err(BusFault(address)),
        })
    }

    /// Writes `size` bytes.
    ///
    /// # Errors
    /// Where the core has no register.
    pub fn store(&mut self, address: u32, size: usize, value: u32, now: u64, core_hz: u64) -> Result<(), BusFault> {
        let word = address >> 2 & 3;
        match address {
            0xe000_1000..0xe000_1008 => self.cycle_counter.store(address & 0xf, value, now, core_hz),
            0xe000_e010..0xe000_e020 => self.systick.store(address & 0xf, value, now),
            0xe000_e100..0xe000_e110 => self.nvic.write_enable(word, value, true),
            0xe000_e180..0xe000_e190 => self.nvic.write_enable(word, value, false),
            0xe000_e200..0xe000_e210 => self.nvic.write_pending(word, value, true),
            0xe000_e280..0xe000_e290 => self.nvic.write_pending(word, value, false),
            0xe000_e400..0xe000_e4f0 => {
                self.set_priorities(FIRST_INTERRUPT + (address - 0xe000_e400) as u16, size, value);
            }
            0xe000_ed18..0xe000_ed24 => self.set_priorities(4 + (address - 0xe000_ed18) as u16, size, value),
            // ICSR: PENDSVSET and PENDSTSET.
            0xe000_ed04 => {
                if value >> 28 & 1 == 1 {
                    self.nvic.pend(PENDSV);
                }
                if value >> 26 & 1 == 1 {
                    self.nvic.pend(SYSTICK);
                }
            }
            0xe000_ed08 => self.vector_table = value,
            0xe000_ed0c => self.reset_requested |= value >> 16 == AIRCR_KEY && value & SYSRESETREQ != 0,
            // STIR.
            0xe000_ef00 => self.nvic.pend(FIRST_INTERRUPT + (value & 0x1ff) as u16),
            FAULTS..FAULTS_END => self.faults.store(address - FAULTS, value),
            0xe000_ed88 => drop(self.remembered.insert(address, value & CPACR_FPU)),
            MPU..MPU_END => self.mpu.store(address - MPU, value),
            0xe000_0000..0xe004_0000 => drop(self.remembered.insert(address, value)),
            _ => return Err(BusFault(address)),
        }
        Ok(())
    }

    fn priorities(&self, first: u16) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|i| self.nvic.priority_byte(first + i as u16)))
    }

    fn set_priorities(&mut self, first: u16, size: usize, value: u32) {
        for (exception, &priority) in (first..).zip(&value.to_le_bytes()[..size]) {
            self.nvic.set_priority_byte(exception, priority);
        }
    }
}
