//! Why a record cannot be identified: every sentence of this kind, in one place.

use std::path::PathBuf;

use dr_core::model::ORDER;

use super::record::{RecordError, RecordSource};

/// The least number of rows that anything is made of.
pub const LEAST_ROWS: u64 = 20;

/// Column values beyond it have squares, and sums of squares, that are no longer numbers.
pub(super) const GREATEST: f64 = 1e100;

/// Identification failed.
#[derive(Debug, thiserror::Error)]
pub enum IdentifyError {
    /// The record cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The record cannot be identified, or not with these options.
    #[error("{}: {reason}", record.display())]
    Unfit {
        /// The file, or what a table in memory is called.
        record: PathBuf,
        /// What is wrong, and what would be right.
        reason: Unidentifiable,
    },
}

impl IdentifyError {
    /// The reason with the name of its record.
    pub(super) fn unfit(source: &dyn RecordSource, reason: Unidentifiable) -> Self {
        Self::Unfit { record: source.survey().path.clone(), reason }
    }
}

/// What keeps a record from being identified with given options: the rest of a sentence that begins
/// with the record.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each variant's sentence says what its fields are")]
pub enum Unidentifiable {
    #[error("has {rows} rows: a model takes at least {LEAST_ROWS}")]
    FewRows { rows: u64 },
    #[error("has {rows} rows for {unknowns} unknowns: record longer, or ask for fewer with --order")]
    ManyUnknowns { rows: u64, unknowns: usize },
    #[error(
        "has {inputs} inputs and {classes} event classes, which make up to {unknowns} unknowns and {gigabytes:.0} GB of sums: join classes, name fewer inputs, or ask for fewer rates with --order"
    )]
    Unaffordable { inputs: usize, classes: usize, unknowns: usize, gigabytes: f64 },
    #[error(
        "has one input, `{input}`, and one output, `{output}`, so no heat crosses from one element to another: leave out --cross-order and --cross-mesh, or name more columns with --input and --output"
    )]
    NoCrossHeating { input: String, output: String },
    #[error("has {rows} rows: a dead time of {delay} samples leaves too few to learn from (at most a quarter)")]
    LongDeadTime { rows: u64, delay: usize },
    #[error(
        "lasts {duration_s:.4} s in steps of {period_s:.4} s: a mesh from {first:e} to {last:e} rad/s reaches far beyond what it shows; stay within {least:.1e} to {most:.1e}"
    )]
    MeshBeyondRecord { duration_s: f64, period_s: f64, first: f64, last: f64, least: f64, most: f64 },
    #[error(
        "column `{column}` reaches from {least:e} to {most:e}: values beyond ±{GREATEST:e} cannot be worked with; correct them, or choose another unit"
    )]
    HugeValues { column: String, least: f64, most: f64 },
    #[error(
        "column `{column}` is {value} in all {rows} rows: an input that never changes excites nothing; record again with a changing input, or leave it out with --input"
    )]
    ConstantInput { column: String, value: f64, rows: u64 },
    #[error(
        "class `{label}` of column `{column}` has no excitation: no input changes in its {rows} rows; excite it there, or give these rows another label"
    )]
    SilentClass { label: String, column: String, rows: u64 },
    #[error("has no output")]
    NoOutput,
    #[error("has no rows")]
    NoRows,
    #[error("gives no candidate")]
    NoCandidate,

    #[error("tied pairs are for structure `symbol`: leave out --tie")]
    TiesOfConductance,
    #[error(
        "free poles differ from output to output, and tied pairs share theirs: choose one of --free-poles and --tie"
    )]
    TiesOfFreePoles,
    #[error(
        "{} inputs ({}) and {} outputs ({}) cannot be tied: name as many outputs as inputs, two at least, in the same order with --input and --output",
        inputs.len(), inputs.join(", "), outputs.len(), outputs.join(", ")
    )]
    NothingToTie { inputs: Vec<String>, outputs: Vec<String> },

    #[error("free poles are 1 to {ORDER}, as many as the board carries, not {poles}")]
    PolesOfNumber { poles: usize },
    #[error("free poles are for structure `symbol`; `anemo reduce` makes any model smaller")]
    PolesOfConductance,
    #[error("with free poles all inputs share an output's rates: leave out --cross-order and --cross-mesh")]
    PolesOfCrossHeating,
    #[error(
        "{poles} poles are more than this record can tell apart: for `{output}` those at {slow:.4e} and {fast:.4e} rad/s come together; ask for fewer with --free-poles"
    )]
    PolesTogether { poles: usize, output: String, slow: f64, fast: f64 },
    /// Nowhere to begin the search for free poles: what the reduction of the mesh model says.
    #[error("{0}")]
    NoStart(String),

    #[error(
        "has one event class (`{label}`): conductances are told from one another by at least two; name their column with --event"
    )]
    OneClass { label: String },
    #[error(
        "has {inputs} inputs and {outputs} outputs: structure `conductance` needs the power and the temperature of each element, in the same order (--input, --output)"
    )]
    NoElements { inputs: usize, outputs: usize },
    #[error(
        "structure `conductance` knows no dead time and no feed-through: the loss goes with the very temperature that is measured"
    )]
    DeadTimeOfConductance,
    #[error(
        "has no gas column, from which the temperature of the gas was to come: name one, or give the temperature as a number (--gas-temperature)"
    )]
    NoGasColumn,
    #[error("has no class `{label}` for a reference; there are {}", classes.join(", "))]
    NoReference { label: String, classes: Vec<String> },
}
