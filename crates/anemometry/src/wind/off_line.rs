//! The board's anemometer, set up with a calibrated head, off line: it follows the ticks of a run
//! or a recording.

use dr_core::control::{MOST_ELEMENTS, Tick};
use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{Anemometer, WindCommand, WindTick};
use recording::RecordingError;
use recording::toml_file::FileError;
use wire::WindSample;

use crate::head::calibration::checked::Calibration;
use crate::head::calibration::commands::WindOutput;
use crate::head::file::Head;

/// An anemometer that knows its head.
#[derive(Debug, Clone)]
pub struct OffLineAnemometer<'a> {
    head: &'a Head,
    /// Hundreds of kilobytes, which copies on a thread's stack would not leave room for.
    anemometer: Box<Anemometer<MOST_ELEMENTS>>,
    sample_period_s: f32,
    /// Why the bandwidth stays fixed although it was to rise after a jump of the wind.
    pub fixed: Option<String>,
}

impl<'a> OffLineAnemometer<'a> {
    /// Sets an anemometer up.
    ///
    /// # Errors
    /// If the bandwidth or the interval cannot be had, or the board refuses a number of the
    /// calibration.
    pub fn new(
        head: &'a Head,
        calibration: &Calibration,
        output: &WindOutput,
        sample_period_s: f64,
    ) -> Result<Self, FileError> {
        let (commands, observer) = calibration.commands(output, sample_period_s).map_err(|error| FileError {
            path: head.source.path.clone(),
            line: None,
            sentence: error.to_string(),
        })?;
        let (anemometer, fixed) = (Box::<Anemometer<MOST_ELEMENTS>>::default(), observer.fixed);
        let mut own = Self { head, anemometer, sample_period_s: sample_period_s as f32, fixed };
        head.set_up(own.anemometer.as_mut(), &commands, sample_period_s)?;
        Ok(own)
    }

    /// Sets the gas; its temperature only where the head has no reference.
    ///
    /// # Errors
    /// The number that the board refuses.
    pub fn gas(&mut self, pressure_pa: f32, temperature_c: Option<f32>) -> Result<(), GasInputError> {
        let set = self.anemometer.handle(&WindCommand::Gas { pressure_pa, temperature_c }, self.sample_period_s);
        set.map_err(|error| GasInputError(format!("gas: {error}")))
    }

    /// Follows a tick; returns an estimate where one is due.
    pub fn step(&mut self, tick: &Tick<MOST_ELEMENTS>) -> Option<WindSample> {
        self.step_whole(tick).as_ref().map(WindSample::from)
    }

    /// The same with overheats and variances.
    pub fn step_whole(&mut self, tick: &Tick<MOST_ELEMENTS>) -> Option<WindTick> {
        let head = self.head;
        self.anemometer.step(tick, |element, temperature_c| standing_w(head, element, temperature_c))
    }

    /// The anemometer itself.
    pub fn anemometer(&self) -> &Anemometer<MOST_ELEMENTS> {
        &self.anemometer
    }

    /// Corrects slow errors of the first surfaces from now on.
    pub fn correct(&mut self, corrections: [SurfaceCorrection; SECTORS]) {
        self.anemometer.correct(Some(corrections));
    }

    /// Heat that an element without a surface gains on ways that the identification did not have,
    /// W.
    pub fn unknown_heat_w(&self, element: usize) -> f64 {
        -f64::from(self.anemometer.convection_w(element).unwrap_or(0.0))
    }
}

/// Power of an element at its low level, W.
pub fn standing_w(head: &Head, element: usize, temperature_c: f32) -> f32 {
    head.elements.get(element).map_or(0.0, |of| of.config.channel.standing_power_w(temperature_c))
}

/// Outward axes of the surfaces, for the linear inverse.
pub fn axes(head: &Head, calibration: &Calibration) -> Vec<[f64; 3]> {
    calibration.surfaces.iter().filter_map(|&place| head.elements[place].normal).collect()
}

/// A recording from which no wind can be estimated.
#[derive(Debug, thiserror::Error)]
pub enum WindError {
    /// It cannot be replayed.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The head has no calibration.
    #[error("head `{0}` has no calibration, and so no wind: make one with `anemo calibrate` and name it with --head")]
    NoCalibration(String),
    /// The output interval is no whole number of ticks: what it is, and the nearest ones.
    #[error("--every {0}")]
    Interval(String),
    /// The anemometer cannot be set up.
    #[error(transparent)]
    SetUp(#[from] FileError),
    /// The gas is not known, or known twice.
    #[error(transparent)]
    Gas(#[from] GasInputError),
}

/// Pressure or temperature of the gas that is not known, known twice, or impossible: a sentence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct GasInputError(pub(super) String);

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn sphere_b() -> Head {
        Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml"))
            .unwrap()
    }

    #[test]
    fn quick_gains_of_a_sphere_hold() {
        let calibration = sphere_b().calibration.unwrap();
        for bandwidth_hz in [0.5, 1.0, 2.0, 5.0] {
            let observer = calibration.network.adaptive_observer(bandwidth_hz, 1e-3).unwrap();
            assert_eq!(observer.fixed, None, "{bandwidth_hz} Hz");
            assert!((0..4).all(|place| observer.faster.iter().any(|of| of.element == place)), "{bandwidth_hz} Hz");
        }
    }

    #[test]
    fn a_sphere_has_filters_at_any_rate() {
        let calibration = sphere_b().calibration.unwrap();
        for sample_period_s in [1e-3, 2e-3, 4e-3, 5e-3, 1e-2, 2e-2] {
            for bandwidth_hz in [0.25, 0.5, 1.0, 2.0, 5.0] {
                let observer = calibration.network.stable_observer(bandwidth_hz, sample_period_s);
                assert!(observer.is_ok(), "{sample_period_s} s, {bandwidth_hz} Hz: {:?}", observer.err());
            }
        }
    }

    #[test]
    fn a_sphere_of_which_one_sector_must_stay_slow_is_slow_altogether() {
        // At 10 ms a small jump of one sector is noticed too late. Without it the wind of the three
        // others, which would be ahead of it after each of their alarms, is ambiguous.
        let calibration = sphere_b().calibration.unwrap();
        let observer = calibration.network.adaptive_observer(2.0, 1e-2).unwrap();
        assert!(observer.fixed.unwrap_or_default().starts_with("sector4: "));
        assert!(observer.faster.is_empty() && observer.own.iter().all(|(_, config)| config.alarm.is_none()));
    }

    #[test]
    fn the_board_takes_the_sets_of_any_rate_and_bandwidth() {
        let head = sphere_b();
        let calibration = head.calibration.as_ref().unwrap();
        for (rate_hz, bandwidth_hz) in [(100.0, 2.0), (100.0, 3.0), (100.0, 5.0), (250.0, 5.0), (20.0, 1.0)] {
            let output = WindOutput { bandwidth_hz, interval_s: 0.1, fixed: false };
            let made = OffLineAnemometer::new(&head, calibration, &output, 1.0 / rate_hz);
            assert!(made.is_ok(), "{rate_hz} Hz, {bandwidth_hz} Hz: {:?}", made.err());
        }
    }
}
