//! Watches the processor's supply of 3.3 V.
//!
//! | at (data sheet, falling) | what happens |
//! |---|---|
//! | 2.95 … 3.09 V | the voltage detector (PVD, level 7) raises an interrupt: heaters low, trip |
//! | 2.75 … 2.88 V | brown-out level 3 holds the processor in reset: all pins float, pulled down |
//! | 2.7 V | below, 168 MHz with 5 wait states and programming by words are out of specification |
//! | 1.60 … 1.76 V | by factory, the only reset |
//!
//! The brown-out level stands in the option bytes (RM0090, "Option bytes", "FLASH_OPTCR"), where
//! the first start sets it, so that it does not matter how the board was programmed.

use super::has_arrived;
use cortex_m::asm;
use cortex_m::peripheral::SCB;
use firmware::mcu::stm32f4::reset_flags;
use stm32f4xx_hal::pac::{EXTI, FLASH, PWR};
use stm32f4xx_hal::rcc::{Enable, Rcc};

/// BOR_LEV in FLASH_OPTCR: 00 is level 3 and 11 is off. The names that the crate of the registers
/// gives to these values are those of another family, the other way round.
const LEVEL: u32 = 0b11 << 2;
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
/// The highest level of the voltage detector.
const DETECTOR_LEVEL: u8 = 7;
/// PWR_CR: the regulator's scale 1, which 168 MHz need and which a reset leaves; the level; the
/// detector. Everything else is zero after a reset (RM0090, "PWR_CR" of STM32F405).
const CONTROL: u32 = 1 << 14 | (DETECTOR_LEVEL as u32) << 5 | 1 << 4;
/// The detector's line of EXTI; it rises as the supply falls.
const LINE: u32 = 1 << 16;
/// Rounds of ten cycles and more at 16 MHz: over 2 s. Programming takes 0.5 s at the most.
const LONGEST_ROUNDS: u32 = 3_200_000;
/// 20 ms at 16 MHz, with which the core starts: the supply has risen by then.
const SETTLING_CYCLES: u32 = 320_000;

/// Starts the voltage detector.
///
/// The HAL waits after it has switched the clock on (ES0182, "Delay after an RCC peripheral clock
/// enabling"): a read before would be 0, and with it written back the core would run at 168 MHz on
/// the lower scale. So nothing is read.
pub fn start_detector(pwr: &PWR, rcc: &mut Rcc) {
    PWR::enable(rcc);
    // SAFETY: the value that the reference manual has.
    pwr.cr().write(|w| unsafe { w.bits(CONTROL) });
}

/// Sets brown-out level 3 if the option bytes have another one. To be called before the watchdog
/// runs and before the flags of the reset in `csr` (RCC_CSR) are cleared.
///
/// It is programmed only after a supply that has risen, and with that supply there; then the board
/// restarts, since option bytes are loaded by a reset. The flags stay, and with the software's own
/// among them it does not restart again: at most two attempts for each time that the supply rises.
pub fn ensure_brown_out_level(flash: &FLASH, csr: u32) {
    // What the reset has loaded; after a write the register holds what was written.
    if flash.optcr().read().bits() & LEVEL == 0 {
        return;
    }
    if reset_flags::supply_has_risen(csr) {
        asm::delay(SETTLING_CYCLES);
        if !is_low() {
            program_brown_out_level(flash);
            if !reset_flags::is_restart(csr) {
                SCB::sys_reset();
            }
        }
    }
    defmt::warn!("brown-out level 3 is not in force: switch the supply off and on");
}

fn program_brown_out_level(flash: &FLASH) {
    for key in OPTION_KEYS {
        flash.optkeyr().write(|w| w.optkeyr().set(key));
    }
    // SAFETY: all other options stay as they are.
    flash.optcr().modify(|r, w| unsafe { w.bits(r.bits() & !LEVEL) });
    flash.optcr().modify(|_, w| w.optstrt().set_bit());
    // The core stands still meanwhile, since its code is in the same flash: 0.5 s at the most.
    for _ in 0..LONGEST_ROUNDS {
        if flash.sr().read().bsy().bit_is_clear() {
            flash.optcr().modify(|_, w| w.optlock().set_bit());
            return;
        }
    }
}

/// Raises the interrupt of the detector from now on.
pub fn listen(exti: &EXTI) {
    exti.rtsr().modify(|_, w| w.tr16().set_bit());
    exti.imr().modify(|_, w| w.mr16().set_bit());
}

/// Whether the supply is below the detector's level now.
pub fn is_low() -> bool {
    // SAFETY: reading has no effect.
    unsafe { (*PWR::ptr()).csr().read().pvdo().bit_is_set() }
}

/// Takes the interrupt back, for the task that it raises.
pub fn acknowledge() {
    // SAFETY: a one clears its own bit, zeros change nothing (RM0090, EXTI_PR).
    unsafe { (*EXTI::ptr()).pr().write(|w| w.bits(LINE)) };
    has_arrived();
}
