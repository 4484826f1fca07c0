//! Why settings cannot be had or changed as asked.

use dr_core::control::Refusal;

/// Each names the key, what is wrong with it, and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A controller does not take the value.
    #[error("{key}: {refusal}{}", if *.refusal == Refusal::NoSamplePeriod { "; set sample_period_s first" } else { "" })]
    Refused {
        /// Of the setting.
        key: String,
        /// Of the controller.
        refusal: Refusal,
    },
    /// The head's calibration cannot be used at this sample period.
    #[error("{0}")]
    Calibration(String),
    /// The text is not a value of the key.
    #[error("{key}: {value:?} is not {right}")]
    NotAValue {
        /// Of the setting.
        key: String,
        /// As it was given.
        value: String,
        /// What belongs there.
        right: &'static str,
    },
    /// The board's name is too long.
    #[error("name: {name:?} has {} bytes, and a name has {most} at the most", .name.len())]
    LongName {
        /// As it was given.
        name: String,
        /// Bytes.
        most: usize,
    },
    /// The gas's temperature is kept with its pressure.
    #[error("gas.temperature_c: set gas.pressure_pa first")]
    NoPressure,
    /// The key belongs to a head.
    #[error("`{0}` is not set by itself: `anemo settings set --head FILE` sets a whole head")]
    OfAHead(String),
    /// There is no such key.
    #[error("unknown key `{key}`; {hint}")]
    UnknownKey {
        /// As it was given.
        key: String,
        /// The nearest that is known.
        hint: String,
    },
}
