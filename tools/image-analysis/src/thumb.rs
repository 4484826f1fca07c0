//! Meaning of an instruction for the call graph and for the stack, by the decoder's words for it.

use anyhow::{Context, Result, bail};
use std::collections::HashMap;

/// Effect of an instruction, as far as it matters here.
#[derive(Debug, PartialEq)]
pub enum Effect {
    /// Neither leads elsewhere nor takes stack.
    Nothing,
    /// Goes to an address and comes back.
    Branch(u32),
    /// Goes to an address for good.
    Jump(u32),
    /// Goes where a register says.
    Pointer,
    /// Takes so many bytes of stack.
    Stack(u32),
    /// Puts this constant into a register.
    Word(u32),
}

/// Constants that are known to be in registers.
pub type Registers = HashMap<String, u32>;

const CONDITIONS: [&str; 16] =
    ["eq", "ne", "hs", "cs", "lo", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le"];

/// Tells whether a mnemonic is this one, under whatever condition and in whatever width.
fn is(mnemonic: &str, base: &str) -> bool {
    let plain = mnemonic.strip_suffix(".w").or(mnemonic.strip_suffix(".n")).unwrap_or(mnemonic);
    plain.strip_prefix(base).is_some_and(|rest| rest.is_empty() || CONDITIONS.contains(&rest))
}

/// Tells whether a mnemonic is one of these, under whatever condition and in whatever width.
pub fn is_any(mnemonic: &str, bases: &[&str]) -> bool {
    bases.iter().any(|base| is(mnemonic, base))
}

/// Tells whether an instruction that may branch does so under a condition only.
pub fn is_conditional(mnemonic: &str) -> bool {
    let plain = mnemonic.split('.').next().unwrap_or(mnemonic);
    ["b", "bx", "pop", "ldr", "ldm"]
        .iter()
        .any(|base| plain.strip_prefix(base).is_some_and(|rest| CONDITIONS.contains(&rest)))
}

/// Reads one instruction. `registers` carries what earlier ones have put into registers.
pub fn effect(mnemonic: &str, operands: &str, registers: &mut Registers) -> Result<Effect> {
    if is_any(mnemonic, &["bl", "b", "blx", "bx"]) {
        return Ok(match (immediate(operands), is_any(mnemonic, &["bl", "blx"])) {
            (Some(target), true) => Effect::Branch(target),
            (Some(target), false) => Effect::Jump(target),
            // The way back.
            (None, _) if operands == "lr" && is(mnemonic, "bx") => Effect::Nothing,
            (None, _) => Effect::Pointer,
        });
    }
    if is_any(mnemonic, &["movw", "mov", "movs"])
        && let Some((register, value)) = operands.split_once(", ")
    {
        match immediate(value) {
            Some(value) => drop(registers.insert(register.to_owned(), value)),
            None => drop(registers.remove(register)),
        }
    }
    if is(mnemonic, "movt") {
        let (register, high) = operands.split_once(", ").context("two operands are expected")?;
        let high = immediate(high).context("a number is expected")?;
        // Without the lower half it may be any word of this upper one; such code has not been seen.
        let low = registers.get(register).copied().context("the lower half is not known")?;
        let word = high << 16 | low & 0xffff;
        registers.insert(register.to_owned(), word);
        return Ok(Effect::Word(word));
    }
    if operands.starts_with("pc, ") && !operands.ends_with("[sp], #4") {
        return Ok(Effect::Pointer);
    }
    stack(mnemonic, operands, registers)
}

/// Bytes that an instruction takes of the stack.
fn stack(mnemonic: &str, operands: &str, registers: &Registers) -> Result<Effect> {
    if is_any(mnemonic, &["push", "vpush"]) {
        return Ok(Effect::Stack(list(operands)?));
    }
    if let Some(registers) = operands.strip_prefix("sp!, ") {
        return Ok(match is_any(mnemonic, &["stmdb", "vstmdb"]) {
            true => Effect::Stack(list(registers)?),
            false if is_any(mnemonic, &["ldm", "vldmia", "pop"]) => Effect::Nothing,
            false => bail!("changes the stack pointer in an unknown way"),
        });
    }
    if operands.ends_with("]!") && operands.contains("[sp") {
        let taken = operands.split("#-").nth(1).and_then(|number| number.strip_suffix("]!")).and_then(number);
        return Ok(Effect::Stack(taken.context("changes the stack pointer in an unknown way")?));
    }
    let Some(rest) = operands.strip_prefix("sp, ") else { return Ok(Effect::Nothing) };
    let rest = rest.strip_prefix("sp, ").unwrap_or(rest);
    if is_any(mnemonic, &["sub", "subw", "subs"]) {
        // `sub sp, r7, #n` goes back to a frame that has been counted.
        if rest.starts_with('r') && rest.contains(", #") {
            return Ok(Effect::Nothing);
        }
        let taken = immediate(rest).or_else(|| registers.get(rest).copied());
        return Ok(Effect::Stack(taken.context("takes an unknown number of bytes of the stack")?));
    }
    // Back to what has been counted, a comparison, or a use of it as an address (with `sp!` it
    // would move).
    if is_any(mnemonic, &["add", "addw", "mov", "cmp", "stm", "ldm"]) {
        return Ok(Effect::Nothing);
    }
    bail!("changes the stack pointer in an unknown way")
}

/// Bytes of the registers in a list such as `{r4, r5-r7, lr}` or `{d8, d9}`.
pub fn list(operands: &str) -> Result<u32> {
    let (_, inner) = operands.split_once('{').context("a list is expected")?;
    inner.trim_end_matches('}').split(',').map(str::trim).try_fold(0, |sum, entry| {
        let width = if entry.starts_with('d') { 8 } else { 4 };
        let number = |register: &str| register[1..].parse::<u32>().context("a range of numbers is expected");
        let count = match entry.split_once('-') {
            Some((first, last)) => number(last)? - number(first)? + 1,
            None => 1,
        };
        Ok(sum + width * count)
    })
}

fn immediate(operand: &str) -> Option<u32> {
    number(operand.strip_prefix('#')?)
}

fn number(digits: &str) -> Option<u32> {
    match digits.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok(),
        None => digits.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(mnemonic: &str, operands: &str) -> Effect {
        effect(mnemonic, operands, &mut Registers::default()).expect("this one is known")
    }

    #[test]
    fn branches_are_told_from_returns_and_from_calls_by_pointer() {
        assert_eq!(of("bl", "#0x8000100"), Effect::Branch(0x800_0100));
        assert_eq!(of("blne", "#0x8000100"), Effect::Branch(0x800_0100));
        for jump in ["b", "b.w", "bls", "blt", "ble.w", "beq"] {
            assert_eq!(of(jump, "#0x8000100"), Effect::Jump(0x800_0100), "{jump}");
        }
        assert_eq!(of("bx", "lr"), Effect::Nothing);
        assert_eq!(of("pop", "{r4, pc}"), Effect::Nothing);
        assert_eq!(of("ldr", "pc, [sp], #4"), Effect::Nothing);
        for (mnemonic, operands) in [("bx", "r3"), ("blx", "r2"), ("ldr", "pc, [r0]"), ("mov", "pc, r1"), ("blx", "lr")]
        {
            assert_eq!(of(mnemonic, operands), Effect::Pointer, "{mnemonic} {operands}");
        }
        assert_eq!(of("bic", "r0, r1, #1"), Effect::Nothing);
        assert_eq!(of("bfc", "r0, #0, #3"), Effect::Nothing);
    }

    #[test]
    fn a_frame_is_all_that_is_taken_off_the_stack_pointer() {
        assert_eq!(of("push", "{r4, r5, r7, lr}"), Effect::Stack(16));
        assert_eq!(of("push.w", "{r8, sb, sl, fp}"), Effect::Stack(16));
        assert_eq!(of("vpush", "{d8, d9}"), Effect::Stack(16));
        assert_eq!(of("vpush", "{d8-d15}"), Effect::Stack(64));
        assert_eq!(of("sub", "sp, #0x48"), Effect::Stack(72));
        assert_eq!(of("sub.w", "sp, sp, #0x880"), Effect::Stack(0x880));
        assert_eq!(of("str", "r7, [sp, #-4]!"), Effect::Stack(4));
        assert_eq!(of("str", "fp, [sp, #-0x10]!"), Effect::Stack(16));
        assert_eq!(of("add", "sp, #0x48"), Effect::Nothing);
        assert_eq!(of("str", "r7, [sp, #4]"), Effect::Nothing);
        assert_eq!(of("stm.w", "sp, {r0, r1, r2, r3}"), Effect::Nothing);
        let error = effect("sub.w", "sp, sp, r4", &mut Registers::default()).expect_err("r4 is not known");
        assert!(error.to_string().contains("unknown number of bytes"));
        let mut registers = Registers::default();
        effect("movw", "r4, #0x1234", &mut registers).expect("a constant");
        assert_eq!(effect("sub.w", "sp, sp, r4", &mut registers).expect("r4 is known"), Effect::Stack(0x1234));
    }

    #[test]
    fn addresses_are_put_together_of_two_halves() {
        let mut registers = Registers::default();
        effect("movw", "r0, #0x101", &mut registers).expect("the lower half");
        assert_eq!(effect("movt", "r0, #0x800", &mut registers).expect("the upper half"), Effect::Word(0x800_0101));
    }
}
