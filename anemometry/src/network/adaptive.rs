//! An observer whose bandwidth rises for a while after the wind has jumped: gain schedules for all
//! elements that keep them stable beside each other.

use super::error::NetworkError;
use super::gain_schedule::gain_schedule;
use super::kalman::Plant;
use super::observer::NetworkObserver;
use super::parameters::QuiescentNetwork;
use super::stability::drop_unstable_gains;

impl QuiescentNetwork {
    /// Configurations as those of [`observer`](Self::observer), with a gain schedule for every
    /// element that has one which is neither too noisy nor unstable beside the other elements
    /// ([`stability`](super::stability)).
    ///
    /// # Errors
    /// As [`observer`](Self::observer).
    pub fn adaptive_observer(&self, bandwidth_hz: f64, sample_period_s: f64) -> Result<NetworkObserver, NetworkError> {
        let mut observer = self.observer(bandwidth_hz, sample_period_s)?;
        let mut too_noisy = Vec::new();
        for (i, own) in self.own.iter().enumerate().filter(|(_, own)| own.surface.is_some()) {
            match gain_schedule(&Plant { own, sample_period_s }, &observer.filters[i]) {
                Some(schedule) => {
                    observer.own[i].1.alarm = Some(schedule.alarm);
                    observer.faster.extend(schedule.sets);
                }
                None => too_noisy.push(own.name.as_str()),
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
