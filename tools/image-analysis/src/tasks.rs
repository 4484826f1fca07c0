//! Tasks of the firmware on the sensor board: how often each runs, until when, and what it takes.
//!
//! Priorities 5 and 6 go by their longest paths ([`crate::paths`]), all others by the longest time
//! that was measured, times 1.5. `serve_settings` waits for the flash and has no deadline, `idle`
//! neither.

/// Time that some work takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// A path of [`crate::bounds::PATHS`], by its name.
    Path(&'static str),
    /// The longest run of an exception's handler that `tools/silicon` has measured, cycles.
    Measured {
        /// Number of the exception.
        exception: u16,
        /// Cycles.
        cycles: u64,
    },
}

/// Work of a task.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// Name in the table.
    pub name: &'static str,
    /// Priority of its task.
    pub priority: u32,
    /// What it takes.
    pub takes: Takes,
    /// Shortest time from one beginning to the next, µs: with ticks of 1 ms, and with those of 10 ms
    /// where every line of flash is missed.
    pub period_us: [u64; 2],
    /// Longest response, µs: without wait states, and with every line of flash missed.
    pub deadline_us: [u64; 2],
    /// It goes before other work. What is a part of other work does not do so again.
    pub interferes: bool,
    /// Reasons for period and deadline.
    pub why: &'static str,
}

/// Cycles of entry and return of an exception, with the registers of the FPU, which a path does not
/// hold.
pub const EXCEPTION_CYCLES: u64 = 29 + 27;
/// Share by which a measured time is raised, as numerator and denominator.
pub const MEASURED_RAISED: [u64; 2] = [3, 2];
/// The longest lock of a resource of `control` by a lower priority: a message is put into its queue.
pub const LONGEST_LOCK: &str = "firmware::outbox::Outbox::put";

const fn measured(exception: u16, cycles: u64) -> Takes {
    Takes::Measured { exception, cycles }
}

/// Work of the tasks of the sensor board, by priority.
pub const TASKS: &[Work] = &[
    Work {
        name: "dead_man",
        priority: 6,
        takes: Takes::Path("dead_man"),
        period_us: [2_000, 20_000],
        deadline_us: [20, 20],
        interferes: true,
        why: "two ticks after the last decision; 1 % of that for the pins",
    },
    Work {
        name: "supply_low",
        priority: 6,
        takes: Takes::Path("supply_low"),
        period_us: [1_000, 1_000],
        deadline_us: [20, 20],
        interferes: true,
        why: "the supply falls from the warning to brown-out in 100 µs or more",
    },
    Work {
        name: "control: edge to pins",
        priority: 5,
        takes: Takes::Path("control: edge to pins"),
        period_us: [1_000, 10_000],
        deadline_us: [200, 1_000],
        interferes: false,
        why: "of a conversion's 250 µs; beyond that the tick is late, and is counted",
    },
    Work {
        name: "control: tick",
        priority: 5,
        takes: Takes::Path("control: tick"),
        period_us: [1_000, 10_000],
        deadline_us: [250, 1_000],
        interferes: true,
        why: "the next conversion; then the next tick",
    },
    Work {
        name: "control: tick and a command",
        priority: 5,
        takes: Takes::Path("control: tick and a command"),
        period_us: [1_000, 10_000],
        deadline_us: [1_000, 1_000],
        interferes: false,
        why: "the next tick: a command may make this one late",
    },
    Work {
        name: "control: tick of a self-test",
        priority: 5,
        takes: Takes::Path("control: tick of a self-test"),
        period_us: [1_000, 10_000],
        deadline_us: [1_000, 1_000],
        interferes: false,
        why: "the next tick; a self-test takes the place of a run",
    },
    Work {
        name: "control: conversion between",
        priority: 5,
        takes: Takes::Path("control: conversion between"),
        period_us: [250, 250],
        deadline_us: [250, 1_000],
        interferes: false,
        why: "the next conversion; with the converter's registers, once in 250",
    },
    Work {
        name: "control: frame",
        priority: 5,
        takes: Takes::Path("control: frame"),
        period_us: [333, 250],
        deadline_us: [250, 250],
        interferes: true,
        why: "the next conversion; three of the four of a tick of 1 ms",
    },
    Work {
        name: "control: command",
        priority: 5,
        takes: Takes::Path("control: command"),
        period_us: [5_000, 5_000],
        deadline_us: [1_000, 1_000],
        interferes: true,
        why: "a tick; a host waits for each reply",
    },
    Work {
        name: "receive",
        priority: 4,
        takes: measured(54, 5_200),
        period_us: [1_000, 10_000],
        deadline_us: [2_700; 2],
        interferes: true,
        why: "half of the receive buffer; a host waits for its replies",
    },
    Work {
        name: "filled",
        priority: 4,
        takes: measured(32, 60),
        period_us: [2_700, 2_700],
        deadline_us: [2_700; 2],
        interferes: true,
        why: "half of the receive buffer",
    },
    Work {
        name: "transmit",
        priority: 3,
        takes: measured(67, 8_500),
        period_us: [1_000, 10_000],
        deadline_us: [31_000; 2],
        interferes: true,
        why: "31 messages of a tick each may wait",
    },
    Work {
        name: "sent",
        priority: 3,
        takes: measured(33, 60),
        period_us: [700, 700],
        deadline_us: [31_000; 2],
        interferes: true,
        why: "a sample takes 0.7 ms on the line",
    },
    Work {
        name: "health",
        priority: 3,
        takes: measured(15, 2_500),
        period_us: [50_000, 50_000],
        deadline_us: [500_000; 2],
        interferes: true,
        why: "twenty times a second; the watchdog's half second",
    },
    Work {
        name: "estimate",
        priority: 2,
        takes: measured(69, 540_000),
        period_us: [10_000, 10_000],
        deadline_us: [20_000, 100_000],
        interferes: true,
        why: "a run takes all ticks that have waited; one that finds the queue full is lost and counted",
    },
];
