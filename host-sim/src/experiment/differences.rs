//! What an experiment has otherwise than its head's calibration, before anything runs.

use dr_core::control::Drive;

use super::checked::Experiment;
use diffusive::model::Conditions;

impl Experiment {
    /// What matters of it, a sentence each; nothing for a head without a calibration. Set-points
    /// are those with which the surfaces begin.
    pub fn differences(&self) -> Vec<String> {
        let Some(calibration) = &self.head.calibration else { return Vec::new() };
        let support_swing_k = self.support_swing.map_or(0.0, |swing| swing.amplitude_k);
        let conditions = self.conditions();
        let support_temperature_c = conditions.support_temperature_c + support_swing_k;
        let conditions = Conditions { support_temperature_c, ..conditions };
        let held = calibration.surfaces.iter().filter_map(|&element| match self.drives.get(element)? {
            Drive::Temperature { target_c } => Some(f64::from(*target_c)),
            Drive::Alternation { high_c, .. } => Some(f64::from(*high_c)),
            _ => None,
        });
        let surface_c = held.fold(None, |range: Option<[f64; 2]>, target_c| {
            let [least, most] = range.unwrap_or([target_c; 2]);
            Some([least.min(target_c), most.max(target_c)])
        });
        let gas = self.gas_range();
        calibration.differences(&conditions, Some([gas.coldest_c, gas.hottest_c]), surface_c)
    }
}
