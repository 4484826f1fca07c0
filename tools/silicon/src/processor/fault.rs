//! Why the core has faulted (ARMv7-M architecture, "Configurable Fault Status Register", "HardFault
//! Status Register").
//!
//! The firmware enables no handler but the hard fault's, so every fault escalates. A store waits in
//! a buffer on its way to a bus that refuses it: its fault is imprecise and has no address.

use super::mpu::MemoryRights;

/// Bits of CFSR.
const IACCVIOL: u32 = 1;
const DACCVIOL: u32 = 1 << 1;
const MSTKERR: u32 = 1 << 4;
const MMARVALID: u32 = 1 << 7;
const IBUSERR: u32 = 1 << 8;
const PRECISERR: u32 = 1 << 9;
const IMPRECISERR: u32 = 1 << 10;
const STKERR: u32 = 1 << 12;
const BFARVALID: u32 = 1 << 15;
const UNDEFINSTR: u32 = 1 << 16;
const INVSTATE: u32 = 1 << 17;
const NOCP: u32 = 1 << 19;
/// Bit of HFSR: a fault that has escalated.
const FORCED: u32 = 1 << 30;
/// CFSR, and the end of these registers.
pub(super) const FAULTS: u32 = 0xe000_ed28;
pub(super) const FAULTS_END: u32 = 0xe000_ed3c;

/// Access that the core wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A load.
    Load,
    /// A store.
    Store,
    /// An instruction.
    Instruction,
    /// The frame of an exception.
    Frame,
}

/// Cause of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// An address was refused, by protection or bus.
    Access(Purpose, u32),
    /// No such instruction.
    Undefined,
    /// An instruction of a coprocessor that is not there.
    NoCoprocessor,
    /// A jump to an even address, which asks for Arm's other instructions.
    NotThumb,
}

/// The status registers.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaultStatus {
    configurable: u32,
    hard: u32,
    memory_address: u32,
    bus_address: u32,
}

impl FaultStatus {
    /// Notes a fault; `rights` are those of the address that was refused.
    pub fn note(&mut self, fault: Fault, rights: MemoryRights) {
        self.hard |= FORCED;
        self.configurable |= match fault {
            Fault::Access(Purpose::Load, _) if !rights.read => DACCVIOL | MMARVALID,
            Fault::Access(Purpose::Store, _) if !rights.write => DACCVIOL | MMARVALID,
            Fault::Access(Purpose::Frame, _) if !rights.write => MSTKERR,
            Fault::Access(Purpose::Instruction, _) if !rights.execute => IACCVIOL,
            Fault::Access(Purpose::Load, _) => PRECISERR | BFARVALID,
            Fault::Access(Purpose::Store, _) => IMPRECISERR,
            Fault::Access(Purpose::Frame, _) => STKERR,
            Fault::Access(Purpose::Instruction, _) => IBUSERR,
            Fault::Undefined => UNDEFINSTR,
            Fault::NotThumb => INVSTATE,
            Fault::NoCoprocessor => NOCP,
        };
        if let Fault::Access(_, address) = fault {
            if self.configurable & MMARVALID != 0 {
                self.memory_address = address;
            }
            if self.configurable & BFARVALID != 0 {
                self.bus_address = address;
            }
        }
    }

    /// Reads a register, by its offset from CFSR.
    pub const fn load(&self, offset: u32) -> u32 {
        match offset {
            0x00 => self.configurable,
            0x04 => self.hard,
            0x0c => self.memory_address,
            0x10 => self.bus_address,
            _ => 0,
        }
    }

    /// Writes a register: ones clear a status.
    pub const fn store(&mut self, offset: u32, value: u32) {
        match offset {
            0x00 => self.configurable &= !value,
            0x04 => self.hard &= !value,
            0x0c => self.memory_address = value,
            0x10 => self.bus_address = value,
            _ => {}
        }
    }
}
