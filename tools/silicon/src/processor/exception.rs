//! Exception entry and return (ARMv7-M architecture, "Exception entry behavior", "Exception return
//! behavior").
//!
//! The frame is eight words, and 18 more if floating-point registers are in use. They are stored at
//! once; a core that stacks them lazily leaves the same memory behind, and is earlier by 17 cycles.
//! The stack is aligned to eight bytes, which bit 9 of the stored status remembers. There is the
//! main stack only: the firmware uses no other.

use super::registers::single;
use unicorn_engine::{RegisterARM, Unicorn, uc_error};

/// Cycles of an entry and of a return (technical reference manual, "Exception handling").
pub const ENTRY_CYCLES: u32 = 12;
pub const RETURN_CYCLES: u32 = 10;

const FRAME: [RegisterARM; 8] = [
    RegisterARM::R0,
    RegisterARM::R1,
    RegisterARM::R2,
    RegisterARM::R3,
    RegisterARM::R12,
    RegisterARM::LR,
    RegisterARM::PC,
    RegisterARM::XPSR,
];
const BASIC_BYTES: u32 = 32;
const FLOAT_BYTES: u32 = 104;
/// A floating-point context is active (CONTROL.FPCA).
const FPCA: u64 = 1 << 2;
const EXCEPTION_NUMBER: u32 = 0x1ff;
const STACK_WAS_MISALIGNED: u32 = 1 << 9;
const THUMB: u32 = 1 << 24;
/// Every value of the link register that returns from an exception begins so.
const RETURN_MARK: u32 = 0xffff_ffe1;
const TO_THREAD: u32 = 1 << 3;
const BASIC_FRAME: u32 = 1 << 4;

/// Enters the handler of `exception`, whose address is `handler`. A frame that cannot be stored is
/// an error, with the stack pointer below it as on the chip.
pub fn enter<D>(unicorn: &mut Unicorn<'_, D>, exception: u16, handler: u32) -> Result<(), uc_error> {
    let has_floats = unicorn.reg_read(RegisterARM::CONTROL)? & FPCA != 0;
    let before = unicorn.reg_read(RegisterARM::SP)? as u32;
    let bytes = if has_floats { FLOAT_BYTES } else { BASIC_BYTES };
    let stack = before.wrapping_sub(bytes) & !7;
    let status = unicorn.reg_read(RegisterARM::XPSR)? as u32;

    let mut frame = Vec::with_capacity(bytes as usize);
    for register in FRAME {
        let word = match register {
            RegisterARM::PC => unicorn.pc_read()? as u32 & !1,
            RegisterARM::XPSR => status & !STACK_WAS_MISALIGNED | THUMB | (before & 4) << 7,
            _ => unicorn.reg_read(register)? as u32,
        };
        frame.extend_from_slice(&word.to_le_bytes());
    }
    if has_floats {
        for number in 0..16 {
            frame.extend_from_slice(&(unicorn.reg_read(single(number))? as u32).to_le_bytes());
        }
        frame.extend_from_slice(&(unicorn.reg_read(RegisterARM::FPSCR)? as u32).to_le_bytes());
    }
    let stored = unicorn.mem_write(stack.into(), &frame);

    let from_thread = if status & EXCEPTION_NUMBER == 0 { TO_THREAD } else { 0 };
    let link = RETURN_MARK | from_thread | if has_floats { 0 } else { BASIC_FRAME };
    let control = unicorn.reg_read(RegisterARM::CONTROL)?;
    unicorn.reg_write(RegisterARM::CONTROL, control & !FPCA)?;
    unicorn.reg_write(RegisterARM::SP, stack.into())?;
    unicorn.reg_write(RegisterARM::LR, link.into())?;
    // No handler begins inside an IT block.
    unicorn.reg_write(RegisterARM::XPSR, u64::from(THUMB | u32::from(exception)))?;
    unicorn.reg_write(RegisterARM::IPSR, exception.into())?;
    unicorn.set_pc(u64::from(handler | 1))?;
    stored
}

/// Returns by the value that a handler has jumped to; gives the exception that has ended.
pub fn leave<D>(unicorn: &mut Unicorn<'_, D>, link: u32) -> Result<u16, uc_error> {
    let ended = unicorn.reg_read(RegisterARM::IPSR)? as u16 & EXCEPTION_NUMBER as u16;
    let has_floats = link & BASIC_FRAME == 0;
    let stack = unicorn.reg_read(RegisterARM::SP)? as u32;
    let bytes = if has_floats { FLOAT_BYTES } else { BASIC_BYTES };
    let frame = unicorn.mem_read_as_vec(stack.into(), bytes as usize)?;
    let words: Vec<u32> =
        frame.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect();
    if has_floats {
        for (&word, number) in words[8..24].iter().zip(0..) {
            unicorn.reg_write(single(number), word.into())?;
        }
        unicorn.reg_write(RegisterARM::FPSCR, words[24].into())?;
    }
    let control = unicorn.reg_read(RegisterARM::CONTROL)? & !FPCA;
    unicorn.reg_write(RegisterARM::CONTROL, control | if has_floats { FPCA } else { 0 })?;
    for (&word, register) in words.iter().zip(&FRAME[..6]) {
        unicorn.reg_write(*register, word.into())?;
    }
    let (program_counter, status) = (words[6], words[7]);
    unicorn.reg_write(RegisterARM::XPSR, u64::from(status & !STACK_WAS_MISALIGNED))?;
    unicorn.reg_write(RegisterARM::IPSR, u64::from(status & EXCEPTION_NUMBER))?;
    let misaligned = if status & STACK_WAS_MISALIGNED == 0 { 0 } else { 4 };
    unicorn.reg_write(RegisterARM::SP, u64::from((stack + bytes) | misaligned))?;
    unicorn.set_pc(u64::from(program_counter | 1))?;
    Ok(ended)
}
