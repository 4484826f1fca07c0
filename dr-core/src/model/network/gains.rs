//! Gains that become quick when the wind has changed, and quiet again.

use super::config::{AlarmConfig, FASTER, FasterConfig, GainsConfig};
use crate::error::{self, ConfigError, Parameter, Problem};
use crate::model::mesh;
use crate::seal::{Seal, Sealable};

/// Until an alarm is over, its own errors are looked at as well: only what is so many times the threshold is another alarm.
const ANOTHER: f32 = 4.0;

/// What is remembered of the innovations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watch {
    /// Smoothed innovation, K.
    pub smoothed_k: f32,
    /// Ticks since the last alarm.
    pub calm_ticks: u32,
}

impl Default for Watch {
    /// Calm for ever.
    fn default() -> Self {
        Self { smoothed_k: 0.0, calm_ticks: u32::MAX }
    }
}

/// Sets of gains with the ticks after an alarm until which they are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sets([Option<(u32, GainsConfig)>; FASTER]);

impl Sets {
    /// Takes in the gains of a set; those before it have to be known, and those after it are forgotten.
    pub fn set(&mut self, config: &FasterConfig, sample_period_s: f32) -> Result<(), ConfigError> {
        let set = usize::from(config.set);
        let problem = Problem::OutOfRange { least: 0.0, most: (FASTER - 1) as f32 };
        if set >= FASTER {
            return Err(ConfigError { parameter: Parameter::GainSet, problem });
        }
        let until_ticks = (error::positive(Parameter::UntilS, config.until_s)? / sample_period_s) as u32;
        let before = match set.checked_sub(1) {
            None => Some(0),
            Some(before) => self.0.get(before).copied().flatten().map(|(until, _)| until),
        };
        if before.is_none_or(|before| before >= until_ticks) {
            return Err(ConfigError { parameter: Parameter::UntilS, problem: Problem::NotAscending });
        }
        let gains = checked(&config.gains)?;
        // Those after it were told for other times.
        for (place, slot) in self.0.iter_mut().enumerate().skip(set) {
            *slot = (place == set).then_some((until_ticks, gains));
        }
        Ok(())
    }
}

impl Default for Sets {
    /// None.
    fn default() -> Self {
        Self([None; FASTER])
    }
}

/// Gains of an element, checked and made ready.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adaptive {
    steady: GainsConfig,
    /// Share of a new innovation, and threshold in K.
    alarm: Option<(f32, f32)>,
    /// Which sets are this element's, of those of its network.
    pub sets: Option<u8>,
}

impl Adaptive {
    pub fn new(gains: &GainsConfig, alarm: Option<&AlarmConfig>, sample_period_s: f32) -> Result<Self, ConfigError> {
        let alarm = match alarm {
            None => None,
            Some(alarm) => {
                error::positive(Parameter::SmoothingS, alarm.smoothing_s)?;
                error::positive(Parameter::AlarmThresholdK, alarm.threshold_k)?;
                let share = mesh::gain(1.0 / f64::from(alarm.smoothing_s), f64::from(sample_period_s)) as f32;
                Some((share, alarm.threshold_k))
            }
        };
        Ok(Self { steady: checked(gains)?, alarm, sets: None })
    }

    /// Whether the element has a convection at all.
    pub fn convects(&self) -> bool {
        self.steady.convection_w_per_k > 0.0
    }

    /// The gains for an innovation, before its weight, at a level.
    #[inline]
    pub fn at<'a>(&'a self, sets: Option<&'a Sets>, watch: &mut Watch, error_k: f32, level: usize) -> &'a GainsConfig {
        let Some((share, threshold_k)) = self.alarm else { return &self.steady };
        watch.smoothed_k += share * (self.steady.weights[level] * error_k - watch.smoothed_k);
        watch.calm_ticks = watch.calm_ticks.saturating_add(1);
        let sets = || sets.into_iter().flat_map(|sets| sets.0.iter().map_while(Option::as_ref));
        let is_quick = sets().any(|(until, _)| watch.calm_ticks < *until);
        let threshold_k = if is_quick { ANOTHER * threshold_k } else { threshold_k };
        if watch.smoothed_k > threshold_k || watch.smoothed_k < -threshold_k {
            watch.calm_ticks = 0;
        }
        for (until_ticks, gains) in sets() {
            if watch.calm_ticks < *until_ticks {
                return gains;
            }
        }
        &self.steady
    }
}

fn checked(gains: &GainsConfig) -> Result<GainsConfig, ConfigError> {
    for correction in gains.correction_w_per_k {
        error::within(Parameter::CorrectionWPerK, correction, -1e6, 1e6)?;
    }
    for weight in gains.weights {
        error::positive(Parameter::ReadingWeight, weight)?;
        error::within(Parameter::ReadingWeight, weight, 0.0, 1e3)?;
    }
    error::within(Parameter::ConvectionWPerK, gains.convection_w_per_k, 0.0, 1e6)?;
    error::within(Parameter::VarianceW2, gains.variance_w2, 0.0, 1e6)?;
    Ok(*gains)
}

crate::seal::sealable!(Adaptive { steady, alarm, sets });

impl Sealable for Sets {
    fn seal_into(&self, seal: &mut Seal) {
        self.0.seal_into(seal);
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
        let adaptive = Adaptive::new(&gains(0.1), Some(&alarm), 0.001).unwrap();
        let mut sets = Sets::default();
        for (set, until_s, convection) in [(0, 0.01, 0.9), (1, 0.03, 0.5)] {
            let config = FasterConfig { element: 0, set, until_s, gains: gains(convection) };
            sets.set(&config, 0.001).unwrap();
        }
        let mut watch = Watch::default();
        let mut at = |error_k: f32| adaptive.at(Some(&sets), &mut watch, error_k, 1).convection_w_per_k;
        assert!((0..1000).all(|n| at(if n % 2 == 0 { 0.002 } else { -0.002 }) == 0.1), "noise is no alarm");
        assert!((0..20).any(|_| at(0.002) == 0.9), "a mean is one");
        let after: std::vec::Vec<f32> = (0..100).map(|_| at(0.0)).collect();
        let count = |convection: f32| after.iter().filter(|&&found| found == convection).count();
        assert_eq!((count(0.9) + count(0.5) + count(0.1), after[99]), (100, 0.1));
        assert!(count(0.5) == 20 && (8..14).contains(&count(0.9)), "{after:?}");
    }

    extern crate std;

    #[test]
    fn sets_come_in_the_order_of_their_times() {
        let mut sets = Sets::default();
        let config = |set, until_s| FasterConfig { element: 0, set, until_s, gains: gains(0.5) };
        assert_eq!(sets.set(&config(1, 0.1), 0.001).unwrap_err().parameter, Parameter::UntilS);
        sets.set(&config(0, 0.1), 0.001).unwrap();
        assert_eq!(sets.set(&config(1, 0.05), 0.001).unwrap_err().parameter, Parameter::UntilS);
        assert!(sets.set(&config(1, 0.2), 0.001).is_ok());
        assert_eq!(sets.set(&config(16, 0.3), 0.001).unwrap_err().parameter, Parameter::GainSet);
        // The first again, beyond what the second was told.
        sets.set(&config(0, 0.5), 0.001).unwrap();
        assert_eq!(sets.0.iter().flatten().count(), 1);
        assert!(sets.set(&config(1, 0.6), 0.001).is_ok());
        assert!(Adaptive::new(&GainsConfig { weights: [0.0, 1.0], ..gains(0.1) }, None, 0.001).is_err());
    }
}
