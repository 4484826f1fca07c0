//! All registers of the core, to be kept and put back.

use unicorn_engine::{RegisterARM, Unicorn, uc_error};

/// In the order in which they are put back: the program counter last.
const CORE: [RegisterARM; 20] = [
    RegisterARM::R0,
    RegisterARM::R1,
    RegisterARM::R2,
    RegisterARM::R3,
    RegisterARM::R4,
    RegisterARM::R5,
    RegisterARM::R6,
    RegisterARM::R7,
    RegisterARM::R8,
    RegisterARM::R9,
    RegisterARM::R10,
    RegisterARM::R11,
    RegisterARM::R12,
    RegisterARM::LR,
    RegisterARM::FPSCR,
    RegisterARM::PRIMASK,
    RegisterARM::BASEPRI,
    RegisterARM::FAULTMASK,
    RegisterARM::CONTROL,
    RegisterARM::SP,
];

/// Registers of a core that stands between two instructions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CoreRegisters {
    core: [u64; CORE.len()],
    floats: [u64; 32],
    status: u64,
    program_counter: u64,
}

impl CoreRegisters {
    pub(super) fn read<D>(unicorn: &Unicorn<'_, D>) -> Result<Self, uc_error> {
        let mut registers = Self {
            core: [0; CORE.len()],
            floats: [0; 32],
            status: unicorn.reg_read(RegisterARM::XPSR)?,
            program_counter: unicorn.pc_read()?,
        };
        for (value, register) in registers.core.iter_mut().zip(CORE) {
            *value = unicorn.reg_read(register)?;
        }
        for (value, number) in registers.floats.iter_mut().zip(0..) {
            *value = unicorn.reg_read(single(number))?;
        }
        Ok(registers)
    }

    pub(super) fn write<D>(&self, unicorn: &mut Unicorn<'_, D>) -> Result<(), uc_error> {
        for (&value, number) in self.floats.iter().zip(0..) {
            unicorn.reg_write(single(number), value)?;
        }
        unicorn.reg_write(RegisterARM::XPSR, self.status)?;
        unicorn.reg_write(RegisterARM::IPSR, self.status & 0x1ff)?;
        for (&value, register) in self.core.iter().zip(CORE) {
            unicorn.reg_write(register, value)?;
        }
        unicorn.set_pc(self.program_counter | 1)
    }
}

/// The number of a single-precision register.
pub(super) const fn single(number: i32) -> i32 {
    RegisterARM::S0 as i32 + number
}
