//! An observer whose bandwidth rises for a while after the wind has jumped: gain schedules for all
//! elements that keep them stable beside each other.

use dr_core::model::{FasterGainsConfig, GainsConfig};

use super::error::NetworkError;
use super::gain_schedule::gain_schedule;
use super::kalman::{ReadingNoise, design};
use super::observer::{NetworkObserver, padded};
use super::parameters::QuiescentNetwork;
use super::stability::drop_unstable_gains;

impl QuiescentNetwork {
    /// Configurations as those of [`observer`](Self::observer), with a gain schedule for every
    /// element that has one which is neither too noisy nor unstable beside the other elements
    /// ([`stability`](super::stability)).
    ///
    /// # Errors
    /// As [`observer`](Self::observer).
    pub fn adaptive_observer(
        &self,
        bandwidth_hz: f64,
        sample_period_s: f64,
        noise: &[ReadingNoise],
    ) -> Result<NetworkObserver, NetworkError> {
        let mut observer = self.observer(bandwidth_hz, sample_period_s, noise)?;
        let mut too_noisy = Vec::new();
        for own in self.own.iter().filter(|own| own.surface.is_some()) {
            let Some((_, config)) = observer.own.iter_mut().find(|(element, _)| *element == own.element) else {
                continue;
            };
            let plant = own.plant(sample_period_s, noise[own.element]);
            let steady = design(&plant, bandwidth_hz)
                .map_err(|error| NetworkError::Filter { element: own.name.clone(), error })?;
            let Some(schedule) = gain_schedule(&plant, &steady) else {
                too_noisy.push(own.name.as_str());
                continue;
            };
            config.alarm = Some(schedule.alarm);
            for (set, of) in (0_u8..).zip(&schedule.sets) {
                let gains = GainsConfig {
                    correction_w_per_k: padded(&of.correction_w_per_k, 0.0),
                    convection_w_per_k: of.convection_w_per_k as f32,
                    weights: config.gains.weights,
                    variance_w2: of.variance_w2 as f32,
                };
                let (element, until_s) = (own.element as u8, of.until_s as f32);
                observer.faster.push(FasterGainsConfig { element, set, until_s, gains });
            }
        }
        let lost = drop_unstable_gains(self, &mut observer, bandwidth_hz, sample_period_s);
        for (element, config) in &mut observer.own {
            if lost.contains(element) {
                config.alarm = None;
            }
        }
        let lost = self.own.iter().filter(|own| lost.contains(&own.element)).map(|own| own.name.as_str()).collect();
        for (names, why) in [
            (too_noisy, "nothing quicker is quiet enough"),
            (lost, "beside their own network quick gains do worse after a jump"),
        ] {
            if !names.is_empty() {
                observer.fixed.push(format!("{}: {why}", names.join(", ")));
            }
        }
        Ok(observer)
    }
}
