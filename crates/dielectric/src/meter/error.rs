//! Why a meter cannot be used.

use crate::port::PortError;
use std::io;

/// Why a meter cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MeterError {
    /// A setting, a symbol or an address that cannot be; what would be right.
    #[error("{0}")]
    Unusable(String),
    /// Nobody answers at an address.
    #[error("no meter can be reached at {address}: {source}; is it on, and is its LAN port enabled?")]
    Unreachable {
        /// As it was given.
        address: String,
        /// Why.
        source: io::Error,
    },
    /// Another instrument answers.
    #[error("{address} is {identity:?}: this program commands a Keysight or Agilent E4980A, nothing has been set")]
    OtherInstrument {
        /// As it was given.
        address: String,
        /// Its answer to `*IDN?`.
        identity: String,
    },
    /// No answer in time.
    #[error("the meter has not answered {command} for {timeout_s} s")]
    Silent {
        /// What it was sent.
        command: String,
        /// How long.
        timeout_s: f64,
    },
    /// The beginning of an answer.
    #[error("the meter's answer to {command} is cut short: {answer:?}")]
    CutShort {
        /// What it was sent.
        command: String,
        /// What came.
        answer: String,
    },
    /// An answer to something else, or to nothing.
    #[error("the meter's answer to {command} makes no sense: {answer:?}")]
    Garbled {
        /// What it was sent.
        command: String,
        /// What came.
        answer: String,
    },
    /// The connection ended.
    #[error("the connection to the meter broke at {command}: {source}")]
    Broken {
        /// What it was to be sent.
        command: String,
        /// Why.
        source: io::Error,
    },
    /// The meter put an error into its queue.
    #[error("the meter refuses {command}: {reason}")]
    Refused {
        /// What it was sent.
        command: String,
        /// Number and text of the error.
        reason: String,
    },
    /// The bias is not the commanded one.
    #[error(
        "the meter has a bias of {found_v} V, {found}, where {commanded_v} V, {commanded}, was commanded{reason}; does it have Option 001, and does nobody else use it?",
        found = on_or_off(*.found_on), commanded = on_or_off(*.commanded_on)
    )]
    OtherBias {
        /// Commanded, V.
        commanded_v: f64,
        /// Commanded to be applied.
        commanded_on: bool,
        /// Read back, V.
        found_v: f64,
        /// Read back to be applied.
        found_on: bool,
        /// What the meter's queue of errors has to it.
        reason: String,
    },
    /// Symbols do not keep their time.
    #[error(
        "{late} of {symbols} symbols were late by more than {tolerance_percent} % of a symbol time, the worst by {worst_s:.3} s; a symbol time of {enough_s:.2} s would do"
    )]
    Late {
        /// Symbols that were late.
        late: u64,
        /// All.
        symbols: u64,
        /// Lateness that does not count, per cent of the symbol time.
        tolerance_percent: f64,
        /// Of the worst, s.
        worst_s: f64,
        /// Symbol time that leaves room for bias and reading, s.
        enough_s: f64,
    },
    /// After the set-up began: it says whether the bias is known to be 0 V.
    #[error(transparent)]
    Port(#[from] PortError),
}

fn on_or_off(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}
