//! The network as it travels and is stored.

use crate::model::ORDER;

/// Most rates of a pair whose input is not the output's own: what comes from afar is slow.
pub const CROSS_ORDER: usize = 4;

/// Most sets of faster gains of an element.
pub const FASTER: usize = 16;

/// Most elements that have such sets: the parts of a head.
pub const QUICK: usize = 4;

/// Most pairs of different elements: all of a head of six.
pub const CROSSES: usize = 30;

/// How an element heats itself, and how its convective power is read off.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OwnConfig {
    /// ξ_k, rad/s, ascending.
    pub mesh_rad_s: [f32; ORDER],
    /// R_k, K/W.
    pub r_k_per_w: [f32; ORDER],
    /// m_k: temperature of the surface over that of the element in relaxation k; 1 where the element is the surface.
    pub surface: [f32; ORDER],
    /// Temperature without heating of any element, in the gas of the identification at rest, °C.
    pub rest_c: f32,
    /// In steady wind.
    pub gains: GainsConfig,
    /// When the wind counts as no longer steady; never without it.
    pub alarm: Option<AlarmConfig>,
}

/// Gains of one bandwidth.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GainsConfig {
    /// c_k, W/K.
    pub correction_w_per_k: [f32; ORDER],
    /// ℓ, W/K; 0 for an element that no wind cools.
    pub convection_w_per_k: f32,
    /// Weight of a reading at the low level, and of one at the high level.
    pub weights: [f32; 2],
    /// Variance of q by the noise of the readings, W².
    pub variance_w2: f32,
}

/// When innovations are more than noise.
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
pub struct FasterConfig {
    /// Which element.
    pub element: u8,
    /// Which set, from 0: the fastest comes first.
    pub set: u8,
    /// In use until so long after the last alarm, s; ascending.
    pub until_s: f32,
    /// The gains.
    pub gains: GainsConfig,
}

/// How an element heats another one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CrossConfig {
    /// The element that is heated by its current.
    pub from: u8,
    /// The element that becomes warm.
    pub to: u8,
    /// ξ_k, rad/s, ascending.
    pub mesh_rad_s: [f32; CROSS_ORDER],
    /// R_k, K/W; of any sign.
    pub r_k_per_w: [f32; CROSS_ORDER],
    /// m_k of the surface of `from`.
    pub surface: [f32; CROSS_ORDER],
}

crate::seal::sealable!(GainsConfig { correction_w_per_k, convection_w_per_k, weights, variance_w2 });
