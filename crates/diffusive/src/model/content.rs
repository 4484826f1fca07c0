//! Content of a model, key by key as in its file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::conditions::Conditions;

/// Key `format` of every model.
pub const FORMAT: &str = "anemo-model";

/// Counts changes that an older reader would misunderstand.
pub const VERSION: u32 = 1;

/// The label of the only class of a record without events.
pub const ALL: &str = "all";

/// A diffusive model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Always `anemo-model`.
    pub format: String,
    /// Version of the format.
    pub version: u32,
    /// Structure: how the wind enters.
    pub structure: Structure,
    /// Sample period of the record that it was identified from, s.
    pub sample_period_s: f64,
    /// Columns that heat, in order.
    pub inputs: Vec<String>,
    /// One an output, in order.
    pub outputs: Vec<ModelOutput>,
    /// One a pair of input and output that was identified.
    pub pairs: Vec<Pair>,
    /// The column with the labels of the conditions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub event_column: Option<String>,
    /// Labels of the event classes: `["all"]` without events.
    pub classes: Vec<String>,
    /// ΔG per class over the reference, W/K, of the first (mostly the only) element. Empty for
    /// structure `symbol`.
    pub conductance_w_per_k: BTreeMap<String, Estimate>,
    /// The wind of structure `conductance`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind: Option<ModelWind>,
    /// Relaxations by which outputs follow a measured surrounding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient: Option<ModelAmbient>,
    /// Losses that grow with temperature; absent where the model is linear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub losses: Option<ModelLosses>,
    /// Offset of the first (mostly the only) output, as in `outputs`.
    pub offset_c: f64,
    /// Residuals of the first output, K.
    pub residual_rms: f64,
    /// Fit of the first output.
    pub fit_percent: f64,
    /// Forecast error of the first output, K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forecast_rms: Option<f64>,
    /// False if predictions by the model may be far off; `warnings` say what the record lacks.
    pub supported: bool,
    /// A sentence for everything that the record does not show. A supported model with warnings
    /// predicts as well as its fit; single parameters of it, which are named, are not resolved.
    pub warnings: Vec<String>,
    /// Advice on the next record of the same body, a sentence for every part of it; empty where the
    /// model comes from no single record.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub advice: Vec<String>,
    /// Decisions for the model.
    pub chosen: Chosen,
    /// Where the model comes from.
    pub provenance: Provenance,
    /// Where the record ended, so that a record that goes on from there can be predicted without
    /// having seen its output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<RecordEnd>,
}

/// Structure by which the wind enters a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Structure {
    /// Every event class has resistances of its own.
    Symbol,
    /// The wind is a conductance to the gas, one a class.
    Conductance,
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub se: f64,
}

/// One output, and how well the model fits it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelOutput {
    /// Column of the record.
    pub name: String,
    /// Temperature without heating, °C.
    pub offset_c: f64,
    /// Its standard error, K.
    pub se_offset_c: f64,
    /// Root mean square of what the model leaves of the record, K.
    pub residual_rms: f64,
    /// 100 (1 − ‖y − ŷ‖ / ‖y − mean y‖).
    pub fit_percent: f64,
    /// Standard deviation of the record's values, K: what `residual_rms` is to be compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread_rms: Option<f64>,
    /// `None` until the residuals were looked at one by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub whiteness: Option<Whiteness>,
    /// Drift of the offset, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<OutputDrift>,
    /// Root mean square error, K, of predictions of what lies ahead, whose outputs were not used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forecast_rms: Option<f64>,
}

/// An offset that moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputDrift {
    /// `random-walk`, `integrated-walk` or `correlated`; `average` where several stand for it.
    pub kind: String,
    /// Size: of a random walk its its increments, K/√s; of an integrated one those of its slope,
    /// K/s/√s; of a level that returns its standard deviation, K.
    pub size: f64,
    /// Time in which a level returns, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation_s: Option<f64>,
    /// Its level behind the last row, K.
    pub last_level_k: f64,
    /// Amount by which the record is more likely with it than without, nats.
    pub evidence_nats: f64,
}

/// Correlation of the residuals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Whiteness {
    /// Autocorrelation at lags 1, 2, …
    pub autocorrelation: Vec<f64>,
    /// Ljung and Box's Q over those lags, and the probability that white noise has a greater one.
    pub q: f64,
    /// Probability that white noise has a greater Q.
    pub p_value: f64,
    /// By how much standard errors that take the residuals for white are too small: √(1 + 2 Σ ρ).
    pub inflation: f64,
}

/// One input that heats one output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// Column that heats.
    pub input: String,
    /// Column that is heated.
    pub output: String,
    /// Ascending rates.
    pub mesh_rad_s: Vec<f64>,
    /// Standard errors of rates that were fitted to the record; absent where the mesh was given or
    /// chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub se_rate_rad_s: Option<Vec<f64>>,
    /// Whole sample periods by which the output answers late.
    pub dead_time_samples: usize,
    /// The resistances were held at or above zero.
    pub non_negative: bool,
    /// By label. Structure `conductance` has one, that of the reference.
    pub classes: BTreeMap<String, Class>,
}

/// The resistances of a pair in one event class.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Class {
    /// R_k, one a rate, K/W.
    pub r_k_per_w: Vec<f64>,
    /// Their standard errors, K/W.
    pub se_k_per_w: Vec<f64>,
    /// Σ R_k + feed-through.
    pub steady_gain_k_per_w: f64,
    /// Its standard error, K/W: half of the central interval of 68 %.
    pub se_steady_gain_k_per_w: f64,
    /// The central interval of the steady gain that holds 95 %, K/W. Absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_95: Option<[f64; 2]>,
    /// Part of the input that the output follows at once; 0 where there is none.
    pub feed_through_k_per_w: f64,
    /// Its standard error, K/W.
    pub se_feed_through_k_per_w: f64,
    /// Covariance of R_1 … R_K, the feed-through and, of rates that were fitted, ln ξ_1 … ln ξ_K:
    /// the lower triangle row by row, in (K/W)², K/W and 1. Absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<f64>>,
}

/// The wind of structure `conductance`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelWind {
    /// The class to which ΔG = 0 belongs and for which the symbol holds.
    pub reference: String,
    /// Where the temperature of the gas comes from.
    pub gas: ModelGas,
    /// Element by element: input i heats output i.
    pub elements: Vec<BTreeMap<String, Estimate>>,
    /// Absent where the gas stood still, was not measured, or moved nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub following: Option<Following>,
}

/// Relaxations by which outputs follow the gas in the reference's wind: y_o += Σ_k F_k^o x_k,
/// dx_k/dt = ξ_k (T_gas − from − x_k).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Following {
    /// The gas temperature to which the offsets belong: that of the record's first row, °C.
    pub from_c: f64,
    /// Least and greatest in the record, °C.
    pub range_c: [f64; 2],
    /// Ascending rates, rad/s.
    pub mesh_rad_s: Vec<f64>,
    /// One an output, in order.
    pub outputs: Vec<Followed>,
}

/// Relaxations by which one output follows the gas.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Followed {
    /// F_k: kelvins of the output a kelvin of the gas.
    pub f_k_per_k: Vec<f64>,
    /// Their standard errors.
    pub se_k_per_k: Vec<f64>,
    /// Σ F_k: 1 where nothing but this gas surrounds the structure.
    pub steady_gain_k_per_k: f64,
    /// Its standard error.
    pub se_steady_gain_k_per_k: f64,
}

/// Where the temperature of the gas comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ModelGas {
    /// It was given, °C.
    ConstantC(f64),
    /// It stands in a column of the record.
    Column(String),
    /// It was estimated with the model, °C.
    EstimatedC(Estimate),
}

/// Relaxations by which outputs follow a measured surrounding, whose input is its temperature.
/// Offsets belong to `following.from_c`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelAmbient {
    /// The column of the record that holds the surrounding's temperature.
    pub column: String,
    /// Outputs follow a gas.
    pub following: Following,
}

/// Losses that grow with temperature: w_i = u_i − Σ g (T_o − T_0)² in place of u_i.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelLosses {
    /// From where ΔT counts.
    pub origin: LossOrigin,
    /// One an element that has such a loss.
    pub elements: Vec<ElementLoss>,
}

/// From where the ΔT of a loss counts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LossOrigin {
    /// The output's temperature without heating: its offset.
    Offset,
    /// A measured ambient: the gas column of a record.
    Column(String),
}

/// The loss of one element.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElementLoss {
    /// The output with whose temperature it grows.
    pub output: String,
    /// The input that it takes heat from.
    pub input: String,
    /// g, W/K².
    pub g_w_per_k2: Estimate,
    /// b = g Σ R of the pair (in the first class), 1/K.
    pub b_per_k: Estimate,
}

/// Decisions for the model, by whom and why.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chosen {
    /// Number of rates.
    pub order: usize,
    /// The slowest rate, rad/s.
    pub first_rate_rad_s: f64,
    /// The fastest rate, rad/s.
    pub last_rate_rad_s: f64,
    /// ξ_1 in units of the thesis' 2πJ/T.
    pub lower_edge_factor: f64,
    /// `ridge` or `smooth`.
    pub prior: String,
    /// Weight of the prior on unit-norm columns.
    pub ridge: f64,
    /// All resistances were held at or above zero.
    pub non_negative: bool,
    /// Outputs follow their inputs at once.
    pub feed_through: bool,
    /// Whole sample periods by which outputs are late.
    pub dead_time_samples: usize,
    /// `rest` or `free`.
    pub initial_state: String,
    /// Root mean square error on cross-validated blocks, and its standard error over the blocks, K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_validation: Option<Estimate>,
    /// A sentence for every decision.
    pub reasons: Vec<String>,
}

/// Where a model comes from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The program and its version.
    pub tool: String,
    /// Files of the records.
    pub records: Vec<String>,
    /// Rows of the records.
    pub rows: u64,
    /// Length of the records, s.
    pub duration_s: f64,
    /// Rows stand at times of their own: `sample_period_s` is the shortest interval after a change of
    /// an input.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub uneven_times: bool,
    /// Least and greatest value of every input in the record.
    pub input_range: Vec<[f64; 2]>,
    /// The gas of the record, where it tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conditions: Option<Conditions>,
}

/// The state behind the last row: what each output will do if all inputs fall silent, and what is
/// still on its way.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordEnd {
    /// Time of the row that would have come next.
    pub next_time_s: f64,
    /// By output: decays as (rate in rad/s, amplitude at `next_time_s` in K).
    pub decays: Vec<Vec<(f64, f64)>>,
    /// By input: the last values, oldest first, as many as the longest dead time.
    pub pending: Vec<Vec<f64>>,
    /// By input: the class of those values, as indices into `classes`.
    pub pending_class: Vec<usize>,
}

impl Model {
    /// The pair of an input and an output, by their columns.
    pub fn pair(&self, input: &str, output: &str) -> Option<&Pair> {
        self.pairs.iter().find(|pair| pair.input == input && pair.output == output)
    }

    /// Relaxations by which outputs follow a gas, or a surrounding, that moves.
    pub fn following(&self) -> Option<&Following> {
        let of_wind = self.wind.as_ref().and_then(|wind| wind.following.as_ref());
        of_wind.or(self.ambient.as_ref().map(|ambient| &ambient.following))
    }

    /// The column of a record that the model takes gas or surroundings from.
    pub fn gas_column(&self) -> Option<&str> {
        let of_wind = self.wind.as_ref().and_then(|wind| match &wind.gas {
            ModelGas::Column(name) => Some(name),
            ModelGas::ConstantC(_) | ModelGas::EstimatedC(_) => None,
        });
        let of_losses = self.losses.as_ref().and_then(|losses| match &losses.origin {
            LossOrigin::Column(name) => Some(name),
            LossOrigin::Offset => None,
        });
        of_wind.or(of_losses).or(self.ambient.as_ref().map(|ambient| &ambient.column)).map(String::as_str)
    }

    /// By how much standard errors of what leads to an output are too small.
    pub fn inflation(&self, output: &str) -> f64 {
        self.outputs.iter().find(|known| known.name == output).map_or(1.0, ModelOutput::inflation)
    }
}

/// Memory of residuals, as the factor by which it widens standard errors, below which they are all
/// but white.
const ALL_BUT_WHITE: f64 = 1.2;

impl ModelOutput {
    /// By how much standard errors are too small: coloured residuals make them so, unless the model
    /// is an average, whose errors hold how far its candidates differ. Else 1.
    pub fn inflation(&self) -> f64 {
        let is_average = self.drift.as_ref().is_some_and(OutputDrift::is_average);
        let coloured = self.whiteness.as_ref().filter(|white| !white.is_white() && white.inflation >= ALL_BUT_WHITE);
        coloured.filter(|_| !is_average).map_or(1.0, |white| white.inflation)
    }
}

impl Whiteness {
    /// Tells whether nothing but noise is left, as far as a test of one in a hundred tells.
    pub fn is_white(&self) -> bool {
        self.p_value >= 0.01
    }
}

impl OutputDrift {
    /// Kind of drift of an average, in which several may stand.
    pub const AVERAGE: &str = "average";

    /// Tells whether several drifts, or none, stand in an average.
    pub fn is_average(&self) -> bool {
        self.kind == Self::AVERAGE
    }
}

impl Class {
    /// Γ = Σ ξ_k R_k, the high-frequency gain in K/J.
    pub fn high_frequency_gain_k_per_j(&self, mesh_rad_s: &[f64]) -> f64 {
        self.r_k_per_w.iter().zip(mesh_rad_s).map(|(resistance, rate)| resistance * rate).sum()
    }
}
