//! The only time there is: a count of core cycles of 168 MHz since power came on.
//!
//! It goes on at this rate whatever the core's clock is: a core that runs on 16 MHz spends 10.5 of
//! these on a cycle of its own.

/// Cycles in a second.
pub const CYCLES_PER_SECOND: u64 = 168_000_000;

/// Cycles in so many microseconds.
pub const fn us(microseconds: u64) -> u64 {
    microseconds * (CYCLES_PER_SECOND / 1_000_000)
}

/// Cycles in so many milliseconds.
pub const fn ms(milliseconds: u64) -> u64 {
    us(1_000 * milliseconds)
}

/// Cycles that so many periods of another clock take.
pub const fn periods(count: u64, clock_hz: u64) -> u64 {
    (count as u128 * CYCLES_PER_SECOND as u128 / clock_hz as u128) as u64
}

/// Seconds in so many cycles.
pub fn seconds(cycles: u64) -> f64 {
    cycles as f64 / CYCLES_PER_SECOND as f64
}
