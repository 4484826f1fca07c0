//! An LCR meter with bias as the device port: SCPI over TCP, in the language of the Keysight (or
//! Agilent) E4980A.
//!
//! Commands are those of the E4980A/AL User's Guide, Keysight part E4980-90230 (chapter "SCPI
//! Command Reference"; statuses are those of "Data Transfer", ASCII format). Biases other than 0,
//! 1.5 and 2 V need its Option 001, which goes to ±40 V. The sequence has been tried against
//! a simulated meter (`pretended`), not against a real one.
//!
//! | command | when | meaning |
//! |---|---|---|
//! | `*IDN?` | first, and to resynchronise | manufacturer, model, serial number, firmware; nothing else is sent to another model |
//! | `*CLS`, `*RST` | set-up | empty queue of errors, initial state (bias 0 V and off) |
//! | `:FUNC:IMP CPD` | set-up | measures parallel capacitance and dissipation factor |
//! | `:FREQ <Hz>`, `:VOLT <V>` | set-up | frequency and level of the oscillator |
//! | `:FORM:ASC:LONG ON` | set-up | ten digits instead of six: a shift is a small difference |
//! | `:TRIG:SOUR BUS`, `:INIT:CONT OFF` | set-up | measures when it is triggered and at no other time |
//! | `:APER SHOR`, `:APER MED` | start of a run | measurement time: medium where the shorter part of a symbol has room for it |
//! | `:BIAS:VOLT <V>`, `:BIAS:STAT ON`, `:BIAS:STAT OFF` | each part, start, end | bias voltage, and whether it is applied |
//! | `:BIAS:VOLT?`, `:BIAS:STAT?` | after each of them | what the bias is set to; another value is an error |
//! | `:TRIG:IMM`, `*OPC?`, `:FETC?` | end of a part | measures, waits for it, answers `<C>,<D>,<status>` |
//! | `:SYST:ERR?` | after each command of the set-up, after triggers, after errors | oldest error of the queue, or `+0,"No error"` |
//!
//! The set-up is repeated at the start of each run: a meter may have restarted since. A status
//! other than 0 (−1 no data, 1 overload, 3 source overloaded, 4 level not regulated) and the value
//! 9.9E37 are a reading that is missing. Everything else that goes wrong ends with 0 V commanded
//! and read back, over a new connection if the old one is of no use. What is read back is the
//! setting, not a voltage that somebody has measured at the device.

mod client;
mod error;
mod link;
#[cfg(any(test, feature = "testing"))]
pub mod pretended;
mod symbol_clock;
#[cfg(test)]
mod tests;

pub use client::{MeterSettings, ScpiMeter};
pub use error::MeterError;
#[cfg(any(test, feature = "testing"))]
pub use pretended::PretendedMeter;
pub use symbol_clock::LateSymbols;
