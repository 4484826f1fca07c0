//! Why the processor started, from the flags of its reset controller.
//!
//! RM0090, "RCC clock control & status register":
//!
//! - Every reset pulls the reset pin, and so sets the pin's flag.
//! - A supply that was below 1.7 V sets the flags of power-on and of brown-out, one that fell below
//!   the brown-out level and no further that of brown-out alone.
//! - A rising supply clears all other flags. They outlast any other reset until the firmware clears
//!   them, so that a power-on goes first: what came after it came before this firmware ran.

use wire::ResetCause;

const PIN: u32 = 1 << 26;
const POWER_ON: u32 = 1 << 27;
const SOFTWARE: u32 = 1 << 28;
const INDEPENDENT_WATCHDOG: u32 = 1 << 29;
const WINDOW_WATCHDOG: u32 = 1 << 30;
const BROWN_OUT: u32 = 1 << 25;

/// The first that is set decides.
const CAUSES: [(u32, ResetCause); 5] = [
    (POWER_ON, ResetCause::PowerOn),
    (BROWN_OUT, ResetCause::BrownOut),
    (INDEPENDENT_WATCHDOG | WINDOW_WATCHDOG, ResetCause::Watchdog),
    (SOFTWARE, ResetCause::Software),
    (PIN, ResetCause::Pin),
];

/// The reset cause in RCC_CSR.
pub fn cause(csr: u32) -> ResetCause {
    CAUSES.into_iter().find(|(flags, _)| csr & flags != 0).map_or(ResetCause::Unknown, |(_, cause)| cause)
}

/// Whether the supply has risen since the flags were cleared.
pub const fn supply_has_risen(csr: u32) -> bool {
    csr & (POWER_ON | BROWN_OUT) != 0
}

/// Whether software, a probe's included, has restarted the processor since the flags were cleared.
pub const fn is_restart(csr: u32) -> bool {
    csr & SOFTWARE != 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_reset_decides() {
        // After a rising supply; its value is the register's reset value in the reference manual.
        assert_eq!(cause(0x0E00_0000), ResetCause::PowerOn);
        assert_eq!(cause(BROWN_OUT | PIN), ResetCause::BrownOut);
        assert_eq!(cause(INDEPENDENT_WATCHDOG | PIN), ResetCause::Watchdog);
        assert_eq!(cause(WINDOW_WATCHDOG | PIN), ResetCause::Watchdog);
        assert_eq!(cause(SOFTWARE | PIN), ResetCause::Software);
        assert_eq!(cause(PIN), ResetCause::Pin);
        // Restarted before the flags were cleared, by the firmware or a probe.
        assert_eq!(cause(0x0E00_0000 | SOFTWARE), ResetCause::PowerOn);
        assert_eq!(cause(BROWN_OUT | SOFTWARE | PIN), ResetCause::BrownOut);
    }

    #[test]
    fn a_supply_rises_by_power_on_and_after_a_brown_out_only() {
        assert!(supply_has_risen(0x0E00_0000) && supply_has_risen(BROWN_OUT | PIN | SOFTWARE));
        assert!(!supply_has_risen(PIN | SOFTWARE | INDEPENDENT_WATCHDOG | WINDOW_WATCHDOG));
        assert!(is_restart(PIN | SOFTWARE) && !is_restart(!SOFTWARE));
    }

    #[test]
    fn other_bits_of_the_register_say_nothing() {
        // The slow oscillator is on and ready, and the flag of the low-power reset, which is not in
        // use.
        assert_eq!(cause(0x8000_0003), ResetCause::Unknown);
    }
}
