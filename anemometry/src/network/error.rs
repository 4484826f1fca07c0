//! Why a quiescent-gas network, its records or its filters cannot be had: a sentence each.

use recording::RecordingError;

/// A model that cannot be a head's quiescent-gas network, or a network that cannot be observed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// The model's conductances change with the wind.
    #[error(
        "structure `conductance` has its wind inside; a quiescent-gas network is made of structure `symbol`, from records in quiescent gas"
    )]
    Structure,
    /// The model knows other conditions than quiescent gas.
    #[error("the model has the classes {}: a quiescent-gas network has one, quiescent gas", .0.join(", "))]
    Classes(Vec<String>),
    /// No pair of the model is named after an element of the head.
    #[error(
        "the model heats none of head `{head}` and sees it become warm: its pairs must be named after {}",
        elements.join(", ")
    )]
    NoElement {
        /// Name of the head.
        head: String,
        /// Names of its elements.
        elements: Vec<String>,
    },
    /// An element's power is not known to heat another element.
    #[error("the model does not say how `{from}` heats `{to}`: identify `{input}` with all temperatures as outputs")]
    NoPair {
        /// The element that heats.
        from: String,
        /// The element that becomes warm.
        to: String,
        /// Column of the power.
        input: String,
    },
    /// A pair lacks the model's only class.
    #[error("pair {pair} has no class `{class}`")]
    NoClass {
        /// Input → output.
        pair: String,
        /// The class.
        class: String,
    },
    /// A pair has more rates than the board's network.
    #[error("pair {pair} has {rates} rates, and the board carries {most} of it: identify it with --free-poles")]
    Rates {
        /// Input → output.
        pair: String,
        /// Rates of the model.
        rates: usize,
        /// Rates that the board carries.
        most: usize,
    },
    /// A pair has a feed-through or a dead time.
    #[error(
        "pair {pair} answers at once or late, which the board's network does not: identify it with --feed-through no --dead-time 0"
    )]
    AtOnceOrLate {
        /// Input → output.
        pair: String,
    },
    /// The layers between an element and its surface do not follow from its rates.
    #[error("element `{element}`: {error}")]
    Layers {
        /// Name of the element.
        element: String,
        /// What is wrong.
        error: LadderError,
    },
    /// The noise of an element's readings is missing.
    #[error("element `{element}`: its readings' noise is not given")]
    NoNoise {
        /// Name of the element.
        element: String,
    },
    /// An element's filter cannot be designed.
    #[error("element `{element}`: {error}")]
    Filter {
        /// Name of the element.
        element: String,
        /// What is wrong.
        error: FilterError,
    },
}

/// A ladder whose first sections are not the layers of an element.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LadderError {
    /// The impedance has no ladder.
    #[error("{0}")]
    Cauer(String),
    /// The ladder has too few sections.
    #[error(
        "{known} rates make a ladder of {known} sections, and {layers} layers between element and surface take at least {}: identify it with more free poles, or say fewer `layers` in the head",
        layers + 1
    )]
    Short {
        /// Sections of the ladder.
        known: usize,
        /// Layers of the head.
        layers: usize,
    },
}

/// A Kalman filter that cannot be designed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// The sample rate is too low for the bandwidth.
    #[error(
        "a bandwidth of {bandwidth_hz} Hz cannot be had of a sample every {sample_period_s} s: it must be above 0 and at most {most_hz:.4} Hz, a tenth of the rate"
    )]
    Rate {
        /// Requested bandwidth, Hz.
        bandwidth_hz: f64,
        /// Sample period, s.
        sample_period_s: f64,
        /// Greatest bandwidth, Hz.
        most_hz: f64,
    },
    /// A standard deviation is not above zero.
    #[error("noise of readings is {low_k} K at the low and {high_k} K at the high level: both must be above 0")]
    Noise {
        /// At the low level, K.
        low_k: f64,
        /// At the high level, K.
        high_k: f64,
    },
    /// No process noise gives the bandwidth.
    #[error(
        "a bandwidth of {bandwidth_hz} Hz cannot be had of this element: its filters reach {} {edge_hz:.3} Hz",
        if *is_slow { "down to" } else { "up to" }
    )]
    Reach {
        /// Requested bandwidth, Hz.
        bandwidth_hz: f64,
        /// The nearest one, Hz.
        edge_hz: f64,
        /// Whether that is the slowest one.
        is_slow: bool,
    },
    /// The board refuses so great a correction.
    #[error("a correction of {0:.3e} W/K is more than the board takes: ask for less bandwidth")]
    Correction(f64),
    /// Riccati's equation has no solution.
    #[error("the equations of its filter do not settle: are the readings' noise and the model right?")]
    Unsettled,
    /// The closed filter is not stable.
    #[error("its filter is not stable: is the model right?")]
    Unstable,
}

/// Records from which no quiescent-gas network can be identified.
#[derive(Debug, thiserror::Error)]
pub enum NetworkIdentifyError {
    /// The file or one of its columns cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A record is not one of quiescent gas with one driven element, or does not tell a pair.
    #[error("{record}: {sentence}")]
    Content {
        /// Name of the record.
        record: String,
        /// What is wrong, where, and what would be right.
        sentence: String,
    },
    /// The records make no network together: of different heads or gases, or with an element that
    /// is driven twice or not at all.
    #[error("{0}")]
    Records(String),
    /// diffusive refuses the record, or finds no model of it.
    #[error("{0}")]
    Model(String),
}
