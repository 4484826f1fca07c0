//! Effect of the uncertainty of the gas's readings on a wind: beside the anemometer go others, each
//! with one reading a little off, and the difference of their winds is added, as much larger as the
//! reading's uncertainty is.
//!
//! ```text
//! C ← C + Σ_r d_r d_rᵀ        d_r = (u_r/h_r) (v(r + h_r) − v)
//! ```
//!
//! h_r is half a per cent of the pressure, and 0.1 K.
//!
//! So it holds for every head, whatever its calibration takes the gas for.
//!
//! *Limits.* Of first order in the uncertainties. They are taken for independent of each other and
//! of all else, and the same for the whole recording, so that no mean over it is more certain.

use core::f32::consts::PI;

use dr_core::control::{MOST_ELEMENTS, Tick};
use dr_core::wind::QualityFlags;
use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use recording::toml_file::FileError;
use wire::WindSample;

use super::off_line::{GasInputError, OffLineAnemometer};

use crate::head::calibration::checked::Calibration;
use crate::head::calibration::commands::WindOutput;
use crate::head::file::Head;
use crate::vector::angle_deg;

/// Standard uncertainties of the readings of the gas; what is none is taken for certain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GasUncertainty {
    /// Uncertainty of the pressure, Pa.
    pub pressure_pa: Option<f64>,
    /// Uncertainty of the temperature, K.
    pub temperature_k: Option<f64>,
}

/// By which share of the pressure, and by how many kelvins, a reading is off.
const PRESSURE_SHARE: f32 = 5e-3;
const TEMPERATURE_K: f32 = 0.1;

/// Anemometers whose readings of the gas are off.
#[derive(Debug, Clone)]
pub struct GasReadingErrors<'a> {
    others: Vec<OffReading<'a>>,
    /// Element that measures the gas.
    reference: Option<usize>,
    /// Number of axes across the wind about which a direction may be off.
    axes_across: f64,
}

#[derive(Debug, Clone)]
struct OffReading<'a> {
    anemometer: OffLineAnemometer<'a>,
    reading: GasReading,
    /// Standard uncertainty, Pa or K.
    uncertainty: f32,
    /// By how much the reading is off, Pa or K; 0 before there is one.
    off: f32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GasReading {
    Pressure,
    Temperature,
}

impl<'a> GasReadingErrors<'a> {
    /// Beside an anemometer of the same settings; none of readings that are certain.
    ///
    /// # Errors
    /// As of [`OffLineAnemometer::new`].
    pub fn new(
        uncertainty: GasUncertainty,
        head: &'a Head,
        calibration: &Calibration,
        output: &WindOutput,
        sample_period_s: f64,
    ) -> Result<Self, FileError> {
        let pressure = uncertainty.pressure_pa.map(|pressure_pa| (GasReading::Pressure, pressure_pa as f32));
        let temperature = uncertainty.temperature_k.map(|kelvin| (GasReading::Temperature, kelvin as f32));
        let others = [pressure, temperature].into_iter().flatten().map(|(reading, uncertainty)| {
            let anemometer = OffLineAnemometer::new(head, calibration, output, sample_period_s)?;
            Ok(OffReading { anemometer, reading, uncertainty, off: 0.0 })
        });
        Ok(Self {
            others: others.collect::<Result<_, FileError>>()?,
            reference: calibration.reference,
            axes_across: if calibration.plane_normal().is_some() { 1.0 } else { 2.0 },
        })
    }

    /// Sets the gas as it was read.
    ///
    /// # Errors
    /// The number that the board refuses.
    pub fn gas(&mut self, pressure_pa: f32, temperature_c: Option<f32>) -> Result<(), GasInputError> {
        self.others.iter_mut().try_for_each(|of| match of.reading {
            GasReading::Pressure => {
                of.off = PRESSURE_SHARE * pressure_pa;
                of.anemometer.gas(pressure_pa + of.off, temperature_c)
            }
            GasReading::Temperature => {
                of.off = TEMPERATURE_K;
                of.anemometer.gas(pressure_pa, temperature_c.map(|celsius| celsius + of.off))
            }
        })
    }

    /// Corrects slow errors of the first surfaces from now on.
    pub fn correct(&mut self, corrections: [SurfaceCorrection; SECTORS]) {
        self.others.iter_mut().for_each(|of| of.anemometer.correct(corrections));
    }

    /// Follows a tick; widens the estimate that the anemometer made of it.
    pub fn step(&mut self, tick: &Tick<MOST_ELEMENTS>, estimate: Option<&mut WindSample>) {
        let mut off = [None, None];
        for (off, other) in off.iter_mut().zip(&mut self.others) {
            let mut tick = *tick;
            if let Some(read_c) = self.reference.and_then(|place| tick.temperature_c.get_mut(place))
                && other.reading == GasReading::Temperature
            {
                *read_c += other.off;
            }
            *off = other.anemometer.step(&tick).map(|off| (off, other.uncertainty / other.off));
        }
        let Some(estimate) = estimate else { return };
        for (off, ratio) in off.into_iter().flatten() {
            add(&off, ratio, self.axes_across, estimate);
        }
    }
}

/// Adds what a reading does to a wind whose uncertainty is so many times as large as it is off.
fn add(off: &WindSample, ratio: f32, axes_across: f64, estimate: &mut WindSample) {
    let unknown = [QualityFlags::FAILED, QualityFlags::AMBIGUOUS];
    if unknown.iter().any(|&flag| estimate.quality_flags.has(flag) || off.quality_flags.has(flag)) {
        return;
    }
    let [x, y, z] = core::array::from_fn(|i| f64::from(ratio * (off.wind_m_s[i] - estimate.wind_m_s[i])));
    let turned_deg = angle_deg(off.wind_m_s.map(f64::from), estimate.wind_m_s.map(f64::from));
    let turned_rad = f64::from(ratio) * turned_deg.to_radians() / axes_across.sqrt();
    let faster_m_s = f64::from(ratio * (off.speed_m_s - estimate.speed_m_s));
    add_uncertainty(estimate, [x * x, y * y, z * z, x * y, x * z, y * z], [faster_m_s, turned_rad]);
}

/// Adds what a cause that is independent of all else does: to xx, yy, zz, xy, xz, yz, m²/s², to the
/// speed, m/s, and to the direction about one axis across it, rad.
pub fn add_uncertainty(sample: &mut WindSample, covariance_m2_s2: [f64; 6], [speed_m_s, direction_rad]: [f64; 2]) {
    let elements = sample.covariance_m2_s2.iter_mut().zip(covariance_m2_s2);
    elements.for_each(|(element, added)| *element += added as f32);
    sample.speed_error_m_s = libm::hypotf(sample.speed_error_m_s, speed_m_s as f32);
    sample.direction_error_rad = libm::hypotf(sample.direction_error_rad, direction_rad as f32).min(PI);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wind(wind_m_s: [f32; 3]) -> WindSample {
        WindSample {
            quality_flags: QualityFlags::default(),
            wind_m_s,
            speed_m_s: wind_m_s.iter().map(|of| of * of).sum::<f32>().sqrt(),
            across_m_s: 0.0,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.3,
            direction_error_rad: 0.03,
            chi_square: 0.0,
            gas_c: 0.0,
            conductance_w_k: wire::SurfaceValues::new(),
            raw_w_k: wire::SurfaceValues::new(),
        }
    }

    #[test]
    fn what_a_reading_moves_is_added_to_what_was_uncertain() {
        // Faster by 0.4 m/s, and turned by 0.04 rad, by ten times what the reading is off.
        let (sin, cos) = libm::sincosf(0.004);
        let mut estimate = wind([5.0, 0.0, 0.0]);
        add(&wind([5.04 * cos, 5.04 * sin, 0.0]), 10.0, 1.0, &mut estimate);
        assert!((estimate.speed_error_m_s - 0.5).abs() < 1e-4, "{estimate:?}");
        assert!((estimate.direction_error_rad - 0.05).abs() < 1e-4, "{estimate:?}");
        let [xx, yy, zz, xy, ..] = estimate.covariance_m2_s2;
        assert!((xx - 0.16).abs() < 1e-3 && (yy - 0.0406).abs() < 1e-3 && (xy * xy / (xx * yy) - 1.0).abs() < 1e-3);
        assert!(zz.abs() < 1e-9);
    }

    #[test]
    fn a_wind_that_another_reading_makes_ambiguous_says_nothing() {
        let mut estimate = wind([5.0, 0.0, 0.0]);
        let twin = WindSample { quality_flags: QualityFlags::AMBIGUOUS, ..wind([-5.0, 0.0, 0.0]) };
        add(&twin, 1.0, 2.0, &mut estimate);
        assert_eq!(estimate, wind([5.0, 0.0, 0.0]));
    }
}
