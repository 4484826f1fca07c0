//! Reasons why a meter cannot be used.

use crate::port::PortError;

/// Reason why a meter cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MeterError {
    /// No answer in time.
    #[error("the meter has not answered {command} for {timeout_s} s")]
    Silent {
        /// Command that it was sent.
        command: String,
        /// Time that it had, s.
        timeout_s: f64,
    },
    /// After the set-up began: it says whether the bias is known to be 0 V.
    #[error(transparent)]
    Port(#[from] PortError),
    /// Anything else, as a sentence.
    #[error("{0}")]
    Other(String),
}

impl MeterError {
    pub(super) fn unreachable(address: &str, source: &std::io::Error) -> Self {
        Self::Other(format!("no meter can be reached at {address}: {source}; is it on, and is its LAN port enabled?"))
    }

    /// The beginning of an answer.
    pub(super) fn cut_short(command: &str, answer: &str) -> Self {
        Self::Other(format!("the meter's answer to {command} is cut short: {answer:?}"))
    }

    /// An answer to something else, or to nothing.
    pub(super) fn garbled(command: &str, answer: &str) -> Self {
        Self::Other(format!("the meter's answer to {command} makes no sense: {answer:?}"))
    }
}
