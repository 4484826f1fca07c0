//! Settings of the convection observer, as they travel over the link and are stored.

use crate::model::self_heating::ORDER;
use crate::room::room;

/// Number of rates of a pair: heat from another element arrives slowly.
pub const CROSS_ORDER: usize = 4;

/// Most sets of faster gains of an element.
pub const FASTER_SETS: usize = 16;

/// Most elements with such sets on a board: the surfaces of a head.
pub const BOARD_FASTER_ELEMENTS: usize = 8;
/// Most elements with such sets.
pub const FASTER_ELEMENTS: usize = room(BOARD_FASTER_ELEMENTS, 32);

/// Most pairs of different elements on a board: all pairs of a head of eight.
pub const BOARD_PAIRS: usize = 56;
/// Most pairs of different elements; on a host all pairs of 32 surfaces and four more elements.
pub const MOST_PAIRS: usize = room(BOARD_PAIRS, 1260);

/// Self-heating of an element in the quiescent-gas network, with the gains of its observer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NetworkSelfHeatingConfig {
    /// ξ_k, rad/s, ascending.
    pub mesh_rad_s: [f32; ORDER],
    /// R_k, K/W.
    pub r_k_per_w: [f32; ORDER],
    /// m_k: temperature of the surface over that of the element in relaxation k; 1 where the
    /// element is the surface.
    pub surface: [f32; ORDER],
    /// Temperature without heating of any element, in the gas of the identification at rest, °C.
    pub rest_c: f32,
    /// Gains in steady wind.
    pub gains: GainsConfig,
    /// Criterion for an abrupt change of the wind; without it there are no alarms.
    pub alarm: Option<AlarmConfig>,
}

/// Observer gains of one bandwidth.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GainsConfig {
    /// c_k, W/K.
    pub correction_w_per_k: [f32; ORDER],
    /// ℓ, W/K; 0 for an element all of whose heat is known.
    pub convection_w_per_k: f32,
    /// Weight of a reading at the low level, and of one at the high level.
    pub weights: [f32; 2],
    /// Variance of q by the noise of the readings, W².
    pub variance_w2: f32,
}

/// Criterion for an alarm: innovations beyond the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AlarmConfig {
    /// Innovations are smoothed over this time, s.
    pub smoothing_s: f32,
    /// A smoothed innovation beyond this, K, is a change of the wind.
    pub threshold_k: f32,
}

/// Gains for the time after an alarm.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FasterGainsConfig {
    /// Number of the element.
    pub element: u8,
    /// Number of the set, from 0: the fastest comes first.
    pub set: u8,
    /// In use until so long after the last alarm, s; ascending.
    pub until_s: f32,
    /// The gains.
    pub gains: GainsConfig,
}

/// Cross-heating of a pair of elements.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NetworkCrossHeatingConfig {
    /// The heated element.
    pub from: u8,
    /// The element whose temperature rises.
    pub to: u8,
    /// ξ_k, rad/s, ascending.
    pub mesh_rad_s: [f32; CROSS_ORDER],
    /// R_k, K/W; of any sign.
    pub r_k_per_w: [f32; CROSS_ORDER],
    /// m_k of the surface of `from`.
    pub surface: [f32; CROSS_ORDER],
}
