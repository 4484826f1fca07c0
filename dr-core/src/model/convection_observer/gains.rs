//! Gains of an element: fast ones after an abrupt change of the wind, slower ones afterwards, and
//! all of them by what the readings of the last while weigh.
//!
//! Gains are made for readings at the low and the high level in turns. In a light wind nearly all
//! are at the low level; each weighs little, and a filter that corrects so little rings. So
//! innovations are scaled by the mean weight s̄ of the last readings, and the bandwidth is the
//! requested one at any duty cycle; what is left to it is the noise:
//!
//! ```text
//! s̄ ← s̄ + (s − s̄)/64
//! e = (T − T̂) s/s̄    at most (T − T̂)/Σ R_k g_k c_k, which is all that a reading can correct
//! σ² = σ²_turns/s̄
//! ```

use super::config::{AlarmConfig, FASTER_SETS, FasterGainsConfig, GainsConfig};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};
use crate::model::mesh;
use crate::model::self_heating::ORDER;

/// During an alarm the innovation contains the transient of the alarm itself: another alarm needs
/// this multiple of the threshold.
const ANOTHER: f32 = 4.0;

/// Share of a reading in the mean weight: 64 readings have some at the high level at the least
/// duty cycles of regulation.
const WEIGHT_SHARE: f32 = 1.0 / 64.0;

/// State of the innovation monitor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnovationMonitor {
    /// Smoothed innovation, K.
    pub smoothed_k: f32,
    /// Ticks since the last alarm.
    pub calm_ticks: u32,
    /// s̄: mean weight of the last readings; 0 before the first.
    pub mean_weight: f32,
}

impl Default for InnovationMonitor {
    /// No alarm yet.
    fn default() -> Self {
        Self { smoothed_k: 0.0, calm_ticks: u32::MAX, mean_weight: 0.0 }
    }
}

/// Sets of gains, each with the number of ticks after an alarm until which it is used.
#[derive(Debug, Clone, Copy, PartialEq, Default, Fields!)]
pub struct GainSets {
    in_order: [Option<(u32, Gains)>; FASTER_SETS],
}

impl GainSets {
    /// Sets the gains of a set; those before it must have been set, and those after it are cleared.
    pub fn set(
        &mut self,
        config: &FasterGainsConfig,
        seen_k_per_w: &[f32; ORDER],
        sample_period_s: f32,
    ) -> Result<(), ConfigError> {
        let set = usize::from(config.set);
        if set >= FASTER_SETS {
            return Err(error::out_of_range(Parameter::GainSet, 0.0, (FASTER_SETS - 1) as f32));
        }
        let until_ticks = (error::positive(Parameter::UntilS, config.until_s)? / sample_period_s) as u32;
        let before = match set.checked_sub(1) {
            None => Some(0),
            Some(before) => self.in_order.get(before).copied().flatten().map(|(until, _)| until),
        };
        if before.is_none_or(|before| before >= until_ticks) {
            return Err(ConfigError { parameter: Parameter::UntilS, problem: ParameterProblem::NotAscending });
        }
        let gains = Gains::new(&config.gains, seen_k_per_w)?;
        // The sets after it were made for other times.
        for (place, slot) in self.in_order.iter_mut().enumerate().skip(set) {
            *slot = (place == set).then_some((until_ticks, gains));
        }
        Ok(())
    }
}

/// Checked gains of one bandwidth.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct Gains {
    pub of: GainsConfig,
    /// Weight of a reading that corrects the temperature in full.
    most: f32,
}

impl Gains {
    fn new(gains: &GainsConfig, seen_k_per_w: &[f32; ORDER]) -> Result<Self, ConfigError> {
        for correction in gains.correction_w_per_k {
            error::within(Parameter::CorrectionWPerK, correction, -1e6, 1e6)?;
        }
        for weight in gains.weights {
            error::positive(Parameter::ReadingWeight, weight)?;
            error::within(Parameter::ReadingWeight, weight, 1e-6, 1e3)?;
        }
        error::within(Parameter::ConvectionWPerK, gains.convection_w_per_k, 0.0, 1e6)?;
        error::within(Parameter::VarianceW2, gains.variance_w2, 0.0, 1e6)?;
        let corrected: f32 = gains.correction_w_per_k.iter().zip(seen_k_per_w).map(|(c, seen)| c * seen).sum();
        // Gains that alone are more than that are not made smaller.
        let full = if corrected > 0.0 { 1.0 / corrected } else { f32::MAX };
        Ok(Self { of: *gains, most: full.max(gains.weights[0]).max(gains.weights[1]) })
    }

    /// Weight of a reading beside the mean weight of the last ones.
    #[inline]
    pub fn weight(&self, mean_weight: f32, level: usize) -> f32 {
        (self.of.weights[level] / mean_weight).min(self.most)
    }
}

/// Gains of an element, checked and prepared.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct AdaptiveGains {
    steady: Gains,
    /// Share of a new innovation, and threshold in K.
    alarm: Option<(f32, f32)>,
    /// Index of the sets of this element.
    pub sets: Option<u8>,
}

impl AdaptiveGains {
    /// `seen_k_per_w` is what a power of one tick does to the temperature by each relaxation.
    pub fn new(
        gains: &GainsConfig,
        alarm: Option<&AlarmConfig>,
        seen_k_per_w: &[f32; ORDER],
        sample_period_s: f32,
    ) -> Result<Self, ConfigError> {
        let alarm = match alarm {
            None => None,
            Some(alarm) => {
                error::positive(Parameter::SmoothingS, alarm.smoothing_s)?;
                error::positive(Parameter::AlarmThresholdK, alarm.threshold_k)?;
                let share = mesh::gain(1.0 / f64::from(alarm.smoothing_s), f64::from(sample_period_s)) as f32;
                Some((share, alarm.threshold_k))
            }
        };
        Ok(Self { steady: Gains::new(gains, seen_k_per_w)?, alarm, sets: None })
    }

    /// Tells whether the element loses heat by convection.
    pub fn convects(&self) -> bool {
        self.steady.of.convection_w_per_k > 0.0
    }

    /// A reading at a level has come.
    #[inline]
    pub fn weigh(&self, monitor: &mut InnovationMonitor, level: usize) {
        let weight = self.steady.of.weights[level];
        let share = if monitor.mean_weight > 0.0 { WEIGHT_SHARE } else { 1.0 };
        monitor.mean_weight += share * (weight - monitor.mean_weight);
    }

    /// The gains for an innovation, before its weight, at a level.
    #[inline]
    pub fn at<'a>(
        &'a self,
        sets: Option<&'a GainSets>,
        monitor: &mut InnovationMonitor,
        error_k: f32,
        level: usize,
    ) -> &'a Gains {
        let Some((share, threshold_k)) = self.alarm else { return &self.steady };
        monitor.smoothed_k += share * (self.steady.of.weights[level] * error_k - monitor.smoothed_k);
        monitor.calm_ticks = monitor.calm_ticks.saturating_add(1);
        let sets = || sets.into_iter().flat_map(|sets| sets.in_order.iter().map_while(Option::as_ref));
        let is_fast = sets().any(|(until, _)| monitor.calm_ticks < *until);
        let threshold_k = if is_fast { ANOTHER * threshold_k } else { threshold_k };
        if monitor.smoothed_k > threshold_k || monitor.smoothed_k < -threshold_k {
            monitor.calm_ticks = 0;
        }
        for (until_ticks, gains) in sets() {
            if monitor.calm_ticks < *until_ticks {
                return gains;
            }
        }
        &self.steady
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gains(convection_w_per_k: f32) -> GainsConfig {
        GainsConfig { correction_w_per_k: [0.0; 8], convection_w_per_k, weights: [0.5, 1.5], variance_w2: 1e-9 }
    }

    #[test]
    fn after_an_alarm_the_sets_follow_each_other_until_all_is_calm() {
        let alarm = AlarmConfig { smoothing_s: 0.01, threshold_k: 0.001 };
        let adaptive = AdaptiveGains::new(&gains(0.1), Some(&alarm), &[0.0; ORDER], 0.001).unwrap();
        let mut sets = GainSets::default();
        for (set, until_s, convection) in [(0, 0.01, 0.9), (1, 0.03, 0.5)] {
            let config = FasterGainsConfig { element: 0, set, until_s, gains: gains(convection) };
            sets.set(&config, &[0.0; ORDER], 0.001).unwrap();
        }
        let mut monitor = InnovationMonitor::default();
        let mut at = |error_k: f32| adaptive.at(Some(&sets), &mut monitor, error_k, 1).of.convection_w_per_k;
        assert!((0..1000).all(|n| at(if n % 2 == 0 { 0.002 } else { -0.002 }) == 0.1), "noise is no alarm");
        assert!((0..20).any(|_| at(0.002) == 0.9), "a mean is one");
        let after: std::vec::Vec<f32> = (0..100).map(|_| at(0.0)).collect();
        let count = |convection: f32| after.iter().filter(|&&found| found == convection).count();
        assert_eq!((count(0.9) + count(0.5) + count(0.1), after[99]), (100, 0.1));
        assert!(count(0.5) == 20 && (8..14).contains(&count(0.9)), "{after:?}");
    }

    extern crate std;

    #[test]
    fn no_reading_is_overdone() {
        let of = |correction: f32| {
            let mut gains = gains(0.1);
            gains.correction_w_per_k[2] = correction;
            let mut seen_k_per_w = [0.0; ORDER];
            seen_k_per_w[2] = 4.0;
            let gains = Gains::new(&gains, &seen_k_per_w).unwrap();
            [0, 1].map(|level| gains.weight(0.5, level))
        };
        // Three times 4 K/W × 0.05 W/K are 0.6 of the temperature.
        assert_eq!(of(0.05), [1.0, 3.0]);
        assert_eq!(of(0.1), [1.0, 2.5]);
        assert_eq!(of(10.0), [1.0, 1.5], "nor is it less than it was");
        assert_eq!(of(-10.0), [1.0, 3.0]);
    }

    #[test]
    fn sets_come_in_the_order_of_their_times() {
        let mut sets = GainSets::default();
        let config = |set, until_s| FasterGainsConfig { element: 0, set, until_s, gains: gains(0.5) };
        assert_eq!(sets.set(&config(1, 0.1), &[0.0; ORDER], 0.001).unwrap_err().parameter, Parameter::UntilS);
        sets.set(&config(0, 0.1), &[0.0; ORDER], 0.001).unwrap();
        assert_eq!(sets.set(&config(1, 0.05), &[0.0; ORDER], 0.001).unwrap_err().parameter, Parameter::UntilS);
        assert!(sets.set(&config(1, 0.2), &[0.0; ORDER], 0.001).is_ok());
        assert_eq!(sets.set(&config(16, 0.3), &[0.0; ORDER], 0.001).unwrap_err().parameter, Parameter::GainSet);
        // The first again, beyond the time of the second.
        sets.set(&config(0, 0.5), &[0.0; ORDER], 0.001).unwrap();
        assert_eq!(sets.in_order.iter().flatten().count(), 1);
        assert!(sets.set(&config(1, 0.6), &[0.0; ORDER], 0.001).is_ok());
        assert!(
            AdaptiveGains::new(&GainsConfig { weights: [0.0, 1.0], ..gains(0.1) }, None, &[0.0; ORDER], 0.001).is_err()
        );
    }
}
