//! A quiescent-gas network as the board's configurations: filters of one bandwidth for the
//! surfaces, element by element.
//!
//! An element without a surface, as a core that guards the foot of a sector, has an unknown heat of
//! its own: what its temperature needs beyond the model. A support that is warmer or colder than in
//! the identification, or a stem that the wind cools, brings it; else all of that would be taken
//! for wind, by the cross-heating. It changes slowly, and is let change at 0.2 Hz at most: between
//! 0.05 and 0.5 Hz it made no difference (sphere B, support ±20 K).

use dr_core::ConfigError;
use dr_core::control::MOST_ELEMENTS;
use dr_core::model::{
    ConvectionObserver, FasterGainsConfig, GainsConfig, NetworkCrossHeatingConfig, NetworkSelfHeatingConfig,
};

use super::kalman::{KalmanFilter, Plant, design};
use super::parameters::{CrossHeatingParameters, NetworkError, QuiescentNetwork, SelfHeatingParameters};

/// Bandwidth of heat that elements without a surface lose on unknown ways, Hz, at most.
const UNKNOWN_HEAT_HZ: f64 = 0.2;

/// Configurations for the board, and how good its filters are.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkObserver {
    /// Place in the head, and configuration.
    pub own: Vec<(usize, NetworkSelfHeatingConfig)>,
    /// One an ordered pair of elements.
    pub cross: Vec<NetworkCrossHeatingConfig>,
    /// Greater gains for the time after an alarm; none where the bandwidth is fixed.
    pub faster: Vec<FasterGainsConfig>,
    /// Why the bandwidth stays fixed although it was to rise: surfaces that allow no more.
    pub fixed: Option<String>,
    /// By element as in `own`: the filter, with its bandwidth and its figures of noise.
    pub filters: Vec<KalmanFilter>,
}

impl NetworkObserver {
    /// Standard deviation of the convective power, or the unknown heat, of an element of the head
    /// by the noise of its readings, W.
    pub fn noise_w(&self, place: usize) -> Option<f64> {
        let at = self.own.iter().position(|(own, _)| *own == place)?;
        Some(self.filters[at].noise_w)
    }

    /// The network as the board has it.
    ///
    /// # Errors
    /// Names the number that the board refuses.
    pub fn board(&self, sample_period_s: f32) -> Result<ConvectionObserver<MOST_ELEMENTS>, ConfigError> {
        let mut board = ConvectionObserver::default();
        for (element, config) in &self.own {
            board.set_self_heating(*element, config, sample_period_s)?;
        }
        for config in &self.faster {
            board.set_faster_gains(config, sample_period_s)?;
        }
        for config in &self.cross {
            board.set_cross_heating(config, sample_period_s)?;
        }
        Ok(board)
    }
}

impl QuiescentNetwork {
    /// Configurations for a sample period, with filters of one bandwidth for all surfaces.
    ///
    /// # Errors
    /// The element whose filter cannot be designed.
    pub fn observer(&self, bandwidth_hz: f64, sample_period_s: f64) -> Result<NetworkObserver, NetworkError> {
        let mut observer = NetworkObserver {
            own: Vec::new(),
            cross: self.cross.iter().map(CrossHeatingParameters::config).collect(),
            faster: Vec::new(),
            fixed: None,
            filters: Vec::new(),
        };
        for own in &self.own {
            let most_hz = if own.surface.is_some() { f64::INFINITY } else { UNKNOWN_HEAT_HZ };
            let plant = Plant { own, sample_period_s };
            let filter = design(&plant, bandwidth_hz.min(most_hz)).map_err(|error| error.of(&own.name))?;
            observer.own.push((own.element, own.config(&filter)));
            observer.filters.push(filter);
        }
        Ok(observer)
    }
}

impl SelfHeatingParameters {
    fn config(&self, filter: &KalmanFilter) -> NetworkSelfHeatingConfig {
        NetworkSelfHeatingConfig {
            mesh_rad_s: ascending(&self.mesh_rad_s),
            r_k_per_w: padded(&self.r_k_per_w, 0.0),
            surface: padded(&self.shares(), 1.0),
            rest_c: self.rest_c as f32,
            gains: GainsConfig {
                correction_w_per_k: padded(&filter.correction_w_per_k, 0.0),
                convection_w_per_k: filter.convection_w_per_k as f32,
                weights: filter.weights.map(|weight| weight as f32),
                variance_w2: (filter.noise_w * filter.noise_w) as f32,
            },
            alarm: None,
        }
    }
}

impl CrossHeatingParameters {
    fn config(&self) -> NetworkCrossHeatingConfig {
        NetworkCrossHeatingConfig {
            // No head has more elements than a mask has bits.
            from: self.from as u8,
            to: self.to as u8,
            mesh_rad_s: ascending(&self.mesh_rad_s),
            r_k_per_w: padded(&self.r_k_per_w, 0.0),
            surface: padded(&self.surface, 1.0),
        }
    }
}

/// Pads to as many values as the board carries; `with` stands for those that are not there.
pub(super) fn padded<const K: usize>(values: &[f64], with: f32) -> [f32; K] {
    std::array::from_fn(|k| values.get(k).map_or(with, |&value| value as f32))
}

/// Rates without a resistance stand above the others, each twice the one before.
fn ascending<const K: usize>(rates: &[f64]) -> [f32; K] {
    let last = rates.last().copied().unwrap_or(1.0);
    std::array::from_fn(|k| match rates.get(k) {
        Some(&rate) => rate as f32,
        None => (last * 2f64.powi((k + 1 - rates.len()) as i32)) as f32,
    })
}
