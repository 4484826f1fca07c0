//! Output of an anemometer's wind estimate, checked and made ready for one sample period.

use super::command::WindOutputConfig;
use super::head_inverse::HeadInverse;

/// An element without a reading for longer than this is left out, s.
pub const READING_TIMEOUT_S: f32 = 0.05;
/// A reference without a reading for longer than this is not used, s.
pub const REFERENCE_TIMEOUT_S: f32 = 1.0;
/// An element at one level for longer than this is saturated, s.
pub const SATURATED_S: f32 = 1.0;
/// The estimate is `starting` for this many smoothing times of the raw power.
pub const STARTING: f32 = 10.0;
/// The checked output settings.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct PreparedOutput {
    pub config: WindOutputConfig,
    pub head: Option<HeadInverse>,
    /// Weights of a new reading of the reference and of a new power in their means.
    pub gas_share: f32,
    pub power_share: f32,
    pub reading_timeout_ticks: u32,
    pub reference_timeout_ticks: u32,
    pub saturated_ticks: u32,
    pub starting_ticks: u32,
    /// Weight of an estimate in the memory of contradictions.
    pub memory_gain: f32,
}
