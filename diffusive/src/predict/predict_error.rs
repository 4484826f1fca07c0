//! Why a loop cannot be predicted from a model.

use dr_core::ConfigError;

use super::loop_model::GasTemperatureError;
use super::sliding_surface::SurfaceError;

/// What the model lacks, or has too much of.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the sentence of a variant names its fields")]
pub enum PredictError {
    /// More elements than a prediction handles.
    #[error("the model has {elements} inputs; loops of {most} at most can be predicted")]
    TooManyElements { elements: usize, most: usize },
    /// A gas temperature that is missing or impossible.
    #[error("the model {0}")]
    Gas(GasTemperatureError),
    /// A heater without a reading.
    #[error("the model has no output that input `{0}` could be regulated by")]
    NoOutput(String),
    /// A reading that is late.
    #[error(
        "{pair} has a dead time of {samples} samples, which a prediction of the loop leaves out: identify it without"
    )]
    DeadTime { pair: String, samples: usize },
    /// A class in which a pair was never seen.
    #[error("{pair} has no class `{label}`: the record never showed it")]
    Unseen { pair: String, label: String },
    /// A pair that no loop can be closed on.
    #[error("{pair}, class `{label}`, {error}")]
    Pair { pair: String, label: String, error: SurfaceError },
    /// An element that no loop can be closed on.
    #[error("the model of {element}, class `{label}`, {error}")]
    Element { element: String, label: String, error: SurfaceError },
    /// A model without the state at its record's end.
    #[error("the model does not hold the state at the end of its record: begin from standby or rest")]
    NoEnd,
    /// Held elements that are one.
    #[error("the elements that are held cannot be told apart: their Γ matrix is singular")]
    Singular,
    /// Standing by without end.
    #[error("the model has no steady state in the first wind")]
    NoSteadyState,
    /// Another number of drives than of inputs.
    #[error("the model has {inputs} inputs, and {drives} drives were given")]
    Drives { inputs: usize, drives: usize },
    /// A drive that the instrument would refuse.
    #[error("{element}: {error}")]
    Drive { element: String, error: ConfigError },
    /// A power that is no number any more.
    #[error("the power of {0} grows without bounds: the model is unstable under this loop")]
    Unstable(String),
}
