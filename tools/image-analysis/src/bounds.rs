//! Bounds of the loops that the tasks of priority 5 and 6 execute on the sensor board, and their
//! paths.
//!
//! A bound holds while the instrument runs, when a heater may be high: what only standby, a
//! self-test's change of input or an acknowledged trip executes is excluded by name.

use crate::paths::{Exclusion, INNERMOST, LoopBound, PathRules, Rounds};

/// Elements of the sensor board: one a channel of its converter.
const ELEMENTS: u64 = 6;
/// Cycles of a microsecond.
pub const CYCLES_PER_US: u64 = 168;
/// Cycles of a byte on SPI1: 8 bits at 10.5 MHz.
const BYTE_CYCLES: u64 = 8 * 16;

const fn bound(functions: &'static [&'static str], rounds: Rounds, why: &'static str) -> LoopBound {
    LoopBound { functions, rounds, why }
}

/// The first that fits counts.
pub const BOUNDS: &[LoopBound] = &[
    // Waits.
    bound(&["HeaterPins", "CycleDelay"], Rounds::For(CYCLES_PER_US), "the pins settle for 0.5 µs"),
    bound(&["CycleDelay"], Rounds::For(2 * CYCLES_PER_US + 20), "2 µs at most: the converter decodes a byte"),
    bound(&["spi::Inner", "check_send"], Rounds::AtMost(1), "the byte before has been received, so there is room"),
    bound(&["write_nonblocking"], Rounds::AtMost(1), "likewise"),
    bound(&["check_read"], Rounds::For(BYTE_CYCLES), "a byte takes 8 bits"),
    bound(&["read_nonblocking"], Rounds::For(BYTE_CYCLES), "a byte takes 8 bits"),
    bound(&["transfer_in_place"], Rounds::AtMost(21), "a frame has 21 bytes, what is read back fewer"),
    bound(&["spi_write"], Rounds::AtMost(2), "one byte, and one that is received meanwhile"),
    bound(
        &["shared::transaction"],
        Rounds::Both(1, 2 * CYCLES_PER_US + 100),
        "a frame: one transfer and a wait of 2 µs",
    ),
    // Lengths.
    bound(&["__aeabi_memcpy", "copy_forward_bytes"], Rounds::AtMost(4), "up to 15 bytes, four a round"),
    bound(&["__aeabi_memcpy"], Rounds::Length(1, 16), "16 bytes a round"),
    bound(&["mem::memcpy", "copy_forward_bytes"], Rounds::AtMost(4), "up to 15 bytes, four a round"),
    bound(&["mem::memcpy", "copy_forward"], Rounds::Length(1, 16), "16 bytes a round"),
    bound(&["__aeabi_memclr", "set_bytes_bytes"], Rounds::AtMost(4), "up to 15 bytes, four a round"),
    bound(&["__aeabi_memclr"], Rounds::Length(0, 16), "16 bytes a round"),
    bound(&["memcmp"], Rounds::Length(1, 2), "two bytes a round or more"),
    bound(&["f32 as dr_core::fields::Fields>::visit_each"], Rounds::Length(0, 4), "four words a round"),
    bound(&["u64_div_rem"], Rounds::AtMost(8), "32 bits of the quotient, four a round"),
    // Control.
    bound(&["take_stop", "atomic_swap"], Rounds::AtMost(2), "an exclusive store fails once for each interrupt"),
    bound(
        &["carry_out_requests"],
        Rounds::Passes("ControlLoop<B,_>::carry_out$", 1, None),
        "a command is carried out when it comes, and the shortest takes 0.1 ms on the line",
    ),
    bound(&["DataReady::next"], Rounds::AtMost(1), "conversions are lost in standby only"),
    bound(&["ControlBoard<6_usize>>::poll"], Rounds::AtMost(1), "a conversion a run; the second look finds none"),
    bound(&["judge_symbol"], Rounds::AtMost(2), "two readings"),
    bound(&["judge_symbols"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["decide_symbols"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["state_checksum"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["settings_checksum"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["SelfTest<_>::take_temperatures"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["judge_phase"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["Controller<_>::judge_readings"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["Controller<_>::compare_head"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["Controller<_>::decide"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["Controller<_>::update_models"], Rounds::InAll(ELEMENTS), "elements"),
    bound(&["Prbs::step"], Rounds::AtMost(2), "a seed and its first bit"),
    bound(
        &["ControlLoop<B,_>::run", "ControlLoop<B,_>::run", INNERMOST],
        Rounds::Passes("ControlLoop<B,_>::tick", 1, Some("Ads131e06<SPI,RST,D>::read_frame")),
        "a tick a run, and no conversion waits after it",
    ),
];

/// Lengths of copies that no constant gives, bytes.
pub const LENGTHS: &[(&str, u32)] = &[
    ("PendingFindings::put", ELEMENTS as u32 * 68 + 68),
    // What is left of whole words.
    ("__aeabi_memcpy4", 3),
    ("__aeabi_memcpy8", 3),
    ("__aeabi_memset4", 3),
];

/// A path of a task.
pub struct TaskPath {
    /// Name in the table.
    pub name: &'static str,
    /// Function of the image.
    pub vector: &'static str,
    /// What is known of it.
    pub rules: PathRules<'static>,
}

/// Functions that no path takes while a heater may be high.
const NEVER: &[Exclusion] = &[
    (&["SelfHeating::new"], "a model is taken in standby"),
    (&["SelfHeating::observer"], "observers are made in standby"),
    (&["set_sample_period"], "in standby"),
    (&["Controller<_>>::forget"], "in standby, or to acknowledge a bit flip"),
    (&["Controller<_>>::place"], "elements are configured in standby"),
    (&["Controller<_>>::observe"], "in standby"),
    (&["Controller<_>>::start"], "in standby"),
    (&["Controller<_>>::begin_test"], "in standby"),
    (&["Decider<_>::restore_lockout"], "the first run"),
    (&["Decider<_>::expect_host"], "the first run"),
    (&["carry_out_orders", "ControlLoop<B,_>::carry_out$"], "the loader gives its orders in standby"),
    (&["carry_out_orders", "dequeue", "memcpy"], "likewise"),
    (&["ControlLoop<B,_>::stop", "ControlLoop<B,_>::carry_out$"], "afterwards no heater is high"),
    (&["ControlLoop<B,_>::stop", "Outbox::put"], "likewise"),
    (&["FrontEnd::resume"], "flash is erased in standby"),
    (&["halt::acknowledge"], "a crash is acknowledged after a trip"),
    (&["Spi<SPI,_,W>::transfer$"], "the converter's driver transfers in place"),
    (&["Spi<SPI,_,W>::read$"], "likewise"),
];

const RUNNING: [Exclusion; NEVER.len() + 9] = with([
    (&["Ads131e06<SPI,RST,D>::select"], "a self-test changes the input; the tick is longer by that"),
    (&["Ads131e06<SPI,RST,D>::verify"], "after a conversion that ends no tick"),
    (&["Decider<_>::step_test"], "a self-test"),
    (&["SelfTest<_>::findings"], "the end of a self-test"),
    (&["PendingFindings::put"], "the end of a self-test"),
    (&["ControlLoop<B,_>::tick::{{closure}}"], "the end of a self-test"),
    (&["scale_supplies"], "a self-test"),
    (&["judge_symbols"], "a head of resistors: a capacitor takes two places of them"),
    (&["decide_symbols"], "likewise"),
]);
/// Between commands.
const COMMANDLESS: [Exclusion; 2] = [
    (&["carry_out_requests", "ControlLoop<B,_>::carry_out$"], "no command comes meanwhile"),
    (&["carry_out_requests", "dequeue", "memcpy"], "no command comes meanwhile"),
];
const DECIDING: [Exclusion; RUNNING.len() + 2] = with_all(&COMMANDLESS, &RUNNING);
const TESTING: [Exclusion; NEVER.len() + 6] = with([
    COMMANDLESS[0],
    COMMANDLESS[1],
    (&["Ads131e06<SPI,RST,D>::select"], "it changes the input; the tick is longer by that"),
    (&["Ads131e06<SPI,RST,D>::verify"], "after a conversion that ends no tick"),
    (&["Controller<_>::decide$"], "a run"),
    (&["Controller<_>::decide_symbols"], "a run"),
]);
const BETWEEN: [Exclusion; NEVER.len() + 3] =
    with([COMMANDLESS[0], COMMANDLESS[1], (&["ControlLoop<B,_>::tick"], "a conversion that ends no tick")]);
const FRAME: [Exclusion; BETWEEN.len() + 1] =
    with_all(&[(&["Ads131e06<SPI,RST,D>::verify"], "once in 250 conversions")], &BETWEEN);
const ALONE: [Exclusion; NEVER.len() + 2] =
    with([(&["ControlLoop<B,_>::tick"], "no conversion"), (&["Ads131e06<SPI,RST,D>"], "no conversion")]);

/// Exclusions of a path, and those of all.
const fn with<const M: usize, const N: usize>(own: [Exclusion<'static>; M]) -> [Exclusion<'static>; N] {
    with_all(&own, NEVER)
}

const fn with_all<const N: usize>(
    first: &[Exclusion<'static>],
    second: &[Exclusion<'static>],
) -> [Exclusion<'static>; N] {
    let (mut all, mut i) = ([(&[] as &[&str], ""); N], 0);
    while i < N {
        all[i] = if i < first.len() { first[i] } else { second[i - first.len()] };
        i += 1;
    }
    all
}

type Excluded = &'static [Exclusion<'static>];

const fn rules(excluded: Excluded, own: &'static [LoopBound], ends_in: Option<&'static str>) -> PathRules<'static> {
    PathRules { own, bounds: BOUNDS, lengths: LENGTHS, excluded, ends_in }
}

/// Bounds while a tick is decided.
const TICK: &[LoopBound] = &[
    bound(
        &["ControlBoard<6_usize>>::poll"],
        Rounds::Both(1, 200),
        "the conversion that ends the tick, and a look for none",
    ),
    bound(&["u64_div_rem"], Rounds::AtMost(1), "fewer than 65 536 conversions: no loop"),
];
const TO_PINS: &[LoopBound] = &[
    bound(&["ControlLoop<B,_>::run", "ControlLoop<B,_>::run", INNERMOST], Rounds::Both(1, 0), "the pins of this tick"),
    TICK[0],
    TICK[1],
];
const PINS: Option<&str> = Some("HeaterPins<P,_>::apply");

/// Paths of the tasks of priority 5 and 6.
pub const PATHS: &[TaskPath] = &[
    TaskPath { name: "dead_man", vector: "TIM5", rules: rules(&[], &[], None) },
    TaskPath { name: "supply_low", vector: "PVD", rules: rules(&[], &[], None) },
    TaskPath { name: "control: edge to pins", vector: "EXTI4", rules: rules(&DECIDING, TO_PINS, PINS) },
    TaskPath { name: "control: tick", vector: "EXTI4", rules: rules(&DECIDING, TICK, None) },
    TaskPath { name: "control: tick and a command", vector: "EXTI4", rules: rules(&RUNNING, TICK, None) },
    TaskPath { name: "control: tick of a self-test", vector: "EXTI4", rules: rules(&TESTING, TICK, None) },
    TaskPath { name: "control: conversion between", vector: "EXTI4", rules: rules(&BETWEEN, &[], None) },
    TaskPath { name: "control: frame", vector: "EXTI4", rules: rules(&FRAME, &[], None) },
    TaskPath { name: "control: command", vector: "EXTI4", rules: rules(&ALONE, &[], None) },
];
