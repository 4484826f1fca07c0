//! An observer whose bandwidth rises for a while after the wind has jumped: gain schedules for all
//! surfaces, where they are stable beside each other.

use super::error::NetworkError;
use super::gain_schedule::gain_schedule;
use super::kalman::Plant;
use super::observer::NetworkObserver;
use super::parameters::QuiescentNetwork;
use super::stability::{quick_sets_settle, worse_when_quick};

impl QuiescentNetwork {
    /// Configurations as those of [`stable_observer`](Self::stable_observer), with a gain schedule
    /// for every surface, or for none: one wind is estimated from all surfaces, and just after its
    /// alarm a surface that is quicker than the others counts as missing. There are none if one of
    /// them is too noisy or worse beside the other elements ([`stability`](super::stability)).
    ///
    /// # Errors
    /// As [`stable_observer`](Self::stable_observer).
    pub fn adaptive_observer(&self, bandwidth_hz: f64, sample_period_s: f64) -> Result<NetworkObserver, NetworkError> {
        let steady = self.stable_observer(bandwidth_hz, sample_period_s)?;
        let mut quick = steady.clone();
        let mut too_noisy = Vec::new();
        for (i, own) in self.own.iter().enumerate().filter(|(_, own)| own.surface.is_some()) {
            match gain_schedule(&Plant { own, sample_period_s }, &steady.filters[i]) {
                Some(schedule) => {
                    quick.own[i].1.alarm = Some(schedule.alarm);
                    quick.faster.extend(schedule.sets);
                }
                None => too_noisy.push(own.name.as_str()),
            }
        }
        let (names, why) = match too_noisy.is_empty() {
            false => (too_noisy, "nothing quicker is quiet enough"),
            true => {
                let worse = worse_when_quick(self, &steady, &quick, bandwidth_hz, sample_period_s);
                match worse.is_empty() && !quick_sets_settle(self, &quick, sample_period_s) {
                    false => (worse, "beside their own network quick gains do worse after a jump"),
                    true => {
                        let surfaces = self.own.iter().filter(|own| own.surface.is_some());
                        (surfaces.map(|own| own.name.as_str()).collect(), "beside each other quick gains are unstable")
                    }
                }
            }
        };
        if names.is_empty() {
            return Ok(quick);
        }
        Ok(NetworkObserver { fixed: Some(format!("{}: {why}", names.join(", "))), ..steady })
    }
}
