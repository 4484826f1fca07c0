//! Why the processor started, from the flags of its reset controller.
//!
//! Several flags are set at a time: every reset pulls the reset pin and so sets the pin's flag, and
//! a rising supply sets that of the brown-out detector too (RM0090, "RCC clock control & status
//! register"). The flags outlast a reset and are cleared by the firmware, so they speak of the last
//! one only.

use wire::ResetCause;

const PIN: u32 = 1 << 26;
const POWER_ON: u32 = 1 << 27;
const SOFTWARE: u32 = 1 << 28;
const INDEPENDENT_WATCHDOG: u32 = 1 << 29;
const WINDOW_WATCHDOG: u32 = 1 << 30;
const BROWN_OUT: u32 = 1 << 25;

/// The most particular first.
const CAUSES: [(u32, ResetCause); 5] = [
    (INDEPENDENT_WATCHDOG | WINDOW_WATCHDOG, ResetCause::Watchdog),
    (SOFTWARE, ResetCause::Software),
    (POWER_ON, ResetCause::PowerOn),
    (BROWN_OUT, ResetCause::BrownOut),
    (PIN, ResetCause::Pin),
];

/// The reset cause in RCC_CSR.
pub fn cause(csr: u32) -> ResetCause {
    CAUSES.into_iter().find(|(flags, _)| csr & flags != 0).map_or(ResetCause::Unknown, |(_, cause)| cause)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_particular_flag_decides() {
        // After a rising supply; its value is the register's reset value in the reference manual.
        assert_eq!(cause(0x0E00_0000), ResetCause::PowerOn);
        assert_eq!(cause(BROWN_OUT | PIN), ResetCause::BrownOut);
        assert_eq!(cause(INDEPENDENT_WATCHDOG | PIN), ResetCause::Watchdog);
        assert_eq!(cause(WINDOW_WATCHDOG | PIN), ResetCause::Watchdog);
        assert_eq!(cause(SOFTWARE | PIN), ResetCause::Software);
        assert_eq!(cause(PIN), ResetCause::Pin);
    }

    #[test]
    fn other_bits_of_the_register_say_nothing() {
        // The slow oscillator is on and ready, and the flag of the low-power reset, which is not in
        // use.
        assert_eq!(cause(0x8000_0003), ResetCause::Unknown);
    }
}
