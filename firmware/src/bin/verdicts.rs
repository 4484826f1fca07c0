//! Asks the core for its verdicts: accesses and jumps under the sensor board's protection, faults,
//! priorities with locks and floats, SysTick.
//!
//! A file names the trials, three words each. Another one takes seven words for each: two values,
//! then CFSR, HFSR, MMFAR and BFAR of a fault, and the instruction at which it came. Trials and
//! expected verdicts stand in `tools/silicon/tests/scenarios/verdicts.rs`, where QEMU's core and
//! ours run this image.

#![no_std]
#![no_main]

#[allow(dead_code, reason = "only the frequency is used here")]
#[path = "../mcu/stm32f4/clocks.rs"]
mod clocks;
#[path = "../mcu/stm32f4/memory_protection.rs"]
mod memory_protection;
#[allow(dead_code, reason = "no place of a file is sought here")]
#[path = "../mcu/emulated/semihosting.rs"]
mod semihosting;
#[path = "../mcu/ticking.rs"]
mod ticking;

use core::arch::naked_asm;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::asm::isb;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use cortex_m_rt::{ExceptionFrame, entry, exception};
use cortex_m_semihosting::nr;
use rtic::export::{cortex_logical2hw, lock, run};
use semihosting::{File, exit};
use stm32f4xx_hal::pac::{Interrupt, NVIC_PRIO_BITS, interrupt};

// What is tried.
const LOAD: u32 = 0;
const STORE: u32 = 1;
const JUMP: u32 = 2;
const JUMP_IN_FAULT: u32 = 3;
const EXCHANGE: u32 = 4;
const PRIORITIES: u32 = 5;
const TICK: u32 = 6;
const PROTECT: u32 = 7;
const INSTRUCTION: u32 = 8;

const OUTER: Interrupt = Interrupt::SPI3;
const INNER: Interrupt = Interrupt::EXTI4;
/// NVIC_ISPR0 and what raises an interrupt in it or in the word after it.
const SET_PENDING: u32 = 0xe000_e200;
const COUNTED_TO_ZERO: u32 = 1 << 16;
const TICK_WAITS: u32 = 1 << 26;

/// CFSR, HFSR, MMFAR, BFAR and the place of the last fault.
static FAULT: [AtomicU32; 5] = [const { AtomicU32::new(0) }; 5];
/// Where the fault handler jumps to; 0 is nowhere.
static JUMP_FROM_FAULT: AtomicU32 = AtomicU32::new(0);
/// Digits of what has happened; the lowest one came last.
static ORDER: AtomicU32 = AtomicU32::new(0);
/// Sum of all floating-point registers, each time that a handler has returned.
static FLOATS: AtomicU32 = AtomicU32::new(0);
/// Priority of the outer interrupt, and the ceiling of its lock.
static OUTER_PRIORITY: AtomicU32 = AtomicU32::new(0);
static CEILING: AtomicU32 = AtomicU32::new(0);
/// `bx lr`.
static CODE_IN_RAM: AtomicU32 = AtomicU32::new(0x4770_4770);
static NOWHERE: AtomicU32 = AtomicU32::new(0);

/// Makes a function of a few instructions, which ends where a fault comes.
macro_rules! instructions {
    ($(fn $name:ident($($argument:ident),*) $(-> $result:ty)? { $($line:literal),* })*) => {
        $(#[unsafe(naked)]
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name($($argument: u32),*) $(-> $result)? {
            naked_asm!($($line,)* "bx lr")
        })*
    };
}

instructions! {
    fn load(_address) -> u32 { "ldr r0, [r0]" }
    fn store(_address, _value) { "str r1, [r0]" }
    fn jump(_address) { "bx r0" }
    fn undefined() { "udf #0" }
    fn coprocessor() { "cdp p5, #0, c0, c0, c0, #0" }
    fn unaligned_pair() { "movw r0, #2", "movt r0, #0x2000", "ldrd r0, r1, [r0]" }
    fn unaligned_word() { "movw r0, #2", "movt r0, #0x2000", "ldr r0, [r0]" }
    fn division_by_zero() { "movs r0, #0", "udiv r0, r0, r0" }
    // Fills the floating-point registers, raises an interrupt by a store, and sums them up.
    fn floats(_seed, _set_pending, _bit) -> u32 {
        ".irp n, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15", "adds r0, #3", "vmov s\\n, r0", ".endr",
        "and r3, r0, #0xc00000", "vmsr fpscr, r3",
        "str r2, [r1]", "dsb", "isb",
        "vmrs r0, fpscr",
        ".irp n, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15", "vmov r3, s\\n", "add r0, r3, r0, ror #1", ".endr"
    }
}

/// Those that may fault by themselves.
static INSTRUCTIONS: [unsafe extern "C" fn(); 5] =
    [undefined, coprocessor, unaligned_pair, unaligned_word, division_by_zero];

/// A fault ends the function in which it comes.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn hard_fault() {
    naked_asm!("mrs r0, msp", "b {note}", note = sym note)
}

extern "C" fn note(frame: &mut ExceptionFrame) {
    // SAFETY: the core's own status, which ones clear; and a way back out of the function that the
    // fault has ended.
    unsafe {
        let scb = &*SCB::PTR;
        let (status, hard) = (scb.cfsr.read(), scb.hfsr.read());
        let valid = |bit: u32, address: u32| if status & bit == 0 { 0 } else { address };
        let words = [status, hard, valid(1 << 7, scb.mmfar.read()), valid(1 << 15, scb.bfar.read()), frame.pc()];
        FAULT.iter().zip(words).for_each(|(place, word)| place.store(word, Relaxed));
        scb.cfsr.write(status);
        scb.hfsr.write(hard);
        frame.set_pc(frame.lr() & !1);
        frame.set_xpsr(1 << 24);
        match JUMP_FROM_FAULT.swap(0, Relaxed) {
            0 => {}
            address => jump(address),
        }
    }
}

fn happened(digit: u32) {
    ORDER.store(ORDER.load(Relaxed) << 4 | digit, Relaxed);
}

/// Holds floats while an interrupt is raised.
fn hold_floats(seed: u32, interrupt: Option<Interrupt>) {
    let number = interrupt.map(|interrupt| interrupt as u32);
    let [address, bit] = match number {
        Some(number) => [SET_PENDING + number / 32 * 4, 1 << (number % 32)],
        None => [NOWHERE.as_ptr() as u32, 0],
    };
    // SAFETY: it changes registers that any function may change, and stores where it is told.
    let sum = unsafe { floats(seed, address, bit) };
    FLOATS.store(FLOATS.load(Relaxed).rotate_left(1) ^ sum, Relaxed);
}

#[interrupt]
fn SPI3() {
    run(OUTER_PRIORITY.load(Relaxed) as u8, || {
        happened(1);
        // SAFETY: nobody looks at what is locked.
        unsafe {
            lock(NOWHERE.as_ptr(), CEILING.load(Relaxed) as u8, NVIC_PRIO_BITS, |_| {
                hold_floats(0x3f80_0000, Some(INNER));
                happened(2);
            });
        }
        isb();
        happened(3);
    });
}

#[interrupt]
fn EXTI4() {
    happened(4);
    hold_floats(0x40e0_0000, None);
}

#[exception]
fn SysTick() {
    happened(6);
}

/// One interrupt inside another: priorities of both, and the ceiling of the outer one's lock.
fn preempt(nvic: &mut NVIC, outer: u8, inner: u8, ceiling: u8) {
    OUTER_PRIORITY.store(outer.into(), Relaxed);
    CEILING.store(ceiling.into(), Relaxed);
    for (interrupt, priority) in [(OUTER, outer), (INNER, inner)] {
        // SAFETY: nothing depends on interrupts that do not come.
        unsafe {
            nvic.set_priority(interrupt, cortex_logical2hw(priority, NVIC_PRIO_BITS));
            NVIC::unmask(interrupt);
        }
    }
    hold_floats(0x3f00_0000, Some(OUTER));
}

/// From the start of SysTick to its first exception; gives its reload value.
fn tick(syst: &mut SYST) -> u32 {
    cortex_m::interrupt::disable();
    ticking::start(syst, clocks::CLOCK_HZ);
    // SAFETY: reading it has no effect.
    let does_wait = || unsafe { (*SCB::PTR).icsr.read() } & TICK_WAITS != 0;
    happened(syst.csr.read());
    happened(does_wait().into());
    while syst.csr.read() & COUNTED_TO_ZERO == 0 {}
    happened(syst.csr.read());
    happened(does_wait().into());
    // SAFETY: nothing else waits.
    unsafe { cortex_m::interrupt::enable() };
    isb();
    happened(does_wait().into());
    syst.disable_counter();
    syst.rvr.read()
}

#[entry]
fn main() -> ! {
    // SAFETY: nobody else has them.
    let mut core = unsafe { cortex_m::Peripherals::steal() };
    let trials = File::open(c"to-board.fifo", nr::open::R_BINARY);
    let verdicts = File::open(c"from-board.fifo", nr::open::W_TRUNC_BINARY);
    let (Some(trials), Some(verdicts)) = (trials, verdicts) else { exit(1) };
    let mut words = [[0; 4]; 3];
    while trials.read(words.as_flattened_mut()) == size_of_val(&words) {
        let [trial, first, second] = words.map(u32::from_le_bytes);
        [&ORDER, &FLOATS].into_iter().chain(&FAULT).for_each(|word| word.store(0, Relaxed));
        // SAFETY: a fault ends the function that is called, and what is stored was there before or
        // is put back.
        let mut values = [0; 2];
        unsafe {
            match trial {
                LOAD => values[0] = load(first),
                STORE => {
                    let before = load(first);
                    FAULT.iter().for_each(|word| word.store(0, Relaxed));
                    store(first, before);
                }
                JUMP => jump(first),
                INSTRUCTION => INSTRUCTIONS.get(first as usize).into_iter().for_each(|function| function()),
                JUMP_IN_FAULT => {
                    JUMP_FROM_FAULT.store(CODE_IN_RAM.as_ptr() as u32 | 1, Relaxed);
                    undefined();
                }
                EXCHANGE => {
                    let before = load(first);
                    store(first, second);
                    values = [load(first), before];
                    store(first, before);
                }
                PRIORITIES => {
                    let [outer, inner, ceiling, _] = first.to_le_bytes();
                    preempt(&mut core.NVIC, outer, inner, ceiling);
                    values = [ORDER.load(Relaxed), FLOATS.load(Relaxed)];
                }
                TICK => {
                    let reload = tick(&mut core.SYST);
                    values = [ORDER.load(Relaxed), reload];
                }
                PROTECT => memory_protection::start(&core.MPU),
                _ => values = [u32::MAX; 2],
            }
        }
        let [value, other] = values;
        let [status, hard, memory, bus, place] = FAULT.each_ref().map(|word| word.load(Relaxed));
        let verdict = [value, other, status, hard, memory, bus, place].map(u32::to_le_bytes);
        verdicts.write(verdict.as_flattened());
    }
    exit(0)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    exit(1)
}
