//! Report of a calibration, as text and as JSON.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use recording::text::{count, short};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::calibrator::{CalibratedHead, CalibrationResult};
use super::card::calibration::CardCalibration;
use super::surfaces::calibration::SurfaceCalibration;

use crate::head::file::Head;

/// Bandwidths whose noise is given, Hz.
const BANDWIDTHS_HZ: [f64; 7] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Overheat and sample period at which it is given.
const OVERHEAT_K: f64 = 30.0;
const SAMPLE_PERIOD_S: f64 = 1e-3;

/// Residuals of winds that were left out, as χ², beyond which hardly any fault of a surface shows.
const BLIND: f64 = 50.0;
/// Held-out directions that are worse, rms, are warned of, °.
const POOR_DIRECTION_DEG: f64 = 10.0;

/// Summary of `anemo calibrate`.
pub struct CalibrationReport {
    /// The calibration, with its errors.
    pub result: CalibrationResult,
    /// Winds that were shorter than the time that is left out of each.
    pub short: usize,
    /// Left out at the beginning of every wind, s.
    pub settle_s: f64,
    /// Noise of a surface's conductance by bandwidth.
    pub noise: Vec<ConductanceNoise>,
    /// Greatest χ² that the calibration explains, if it says so.
    pub chi_square_most: Option<f64>,
    /// The file that was written.
    pub written: Option<PathBuf>,
}

/// Noise of a surface's conductance at 30 K and 1 kHz.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ConductanceNoise {
    /// Bandwidth, Hz.
    pub bandwidth_hz: f64,
    /// Standard deviation, W/K.
    #[serde(rename = "value")]
    pub sd_w_k: f64,
}

/// Noise of a surface's conductance at usual bandwidths, as far as these can be had.
pub fn conductance_noise(head: &Head) -> Vec<ConductanceNoise> {
    let noise = |bandwidth_hz| {
        let calibration = head.calibration.as_ref()?;
        let observer = calibration.network.observer(bandwidth_hz, SAMPLE_PERIOD_S).ok()?;
        let sd_w_k = observer.noise_w(*calibration.surfaces.first()?)? / OVERHEAT_K;
        Some(ConductanceNoise { bandwidth_hz, sd_w_k })
    };
    BANDWIDTHS_HZ.into_iter().filter_map(noise).collect()
}

impl CalibrationReport {
    /// Report of a calibrated head.
    pub fn new(calibrated: CalibratedHead, short: usize, settle_s: f64) -> Self {
        let noise = match calibrated.result {
            CalibrationResult::Surfaces { .. } => conductance_noise(&calibrated.head),
            CalibrationResult::Card { .. } => Vec::new(),
        };
        let table = calibrated.head.calibration.as_ref().and_then(|of| of.table.uncertainty.as_ref());
        let chi_square_most = table.map(|of| of.chi_square_most);
        Self { result: calibrated.result, short, settle_s, noise, chi_square_most, written: None }
    }

    /// Warnings, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let CalibrationResult::Surfaces { calibration, directions, .. } = &self.result else { return Vec::new() };
        let mut sentences = calibration.warnings();
        if let Some(most) = self.chi_square_most.filter(|most| *most > BLIND) {
            sentences.push(format!(
                "winds that were left out contradict themselves by a χ² of {most:.0}: a surface that fails later may go unnoticed; calibrate \
                 in more winds"
            ));
        }
        let rms_deg = directions.overall().direction_rms_deg;
        if rms_deg > POOR_DIRECTION_DEG {
            sentences.push(format!("directions that were left out of the fit come out {rms_deg:.0}° wrong, rms"));
        }
        sentences
    }
}

impl Serialize for CalibrationReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match &self.result {
            CalibrationResult::Surfaces { calibration, directions, speeds } => {
                surfaces(&mut map, calibration)?;
                map.serialize_entry("cross_validated_directions", directions)?;
                map.serialize_entry("cross_validated_speeds", speeds)?;
                map.serialize_entry("conductance_noise_w_k", &self.noise)?;
            }
            CalibrationResult::Card { calibration, winds } => {
                card(&mut map, calibration)?;
                map.serialize_entry("cross_validated", winds)?;
            }
        }
        map.end()
    }
}

fn surfaces<M: SerializeMap>(map: &mut M, calibration: &SurfaceCalibration) -> Result<(), M::Error> {
    map.serialize_entry("form", &calibration.form)?;
    map.serialize_entry("king", &calibration.king)?;
    map.serialize_entry("orders", &calibration.orders)?;
    map.serialize_entry("winds", &calibration.winds)?;
    map.serialize_entry("quiescent", &calibration.quiescent)?;
    map.serialize_entry("reynolds", &calibration.reynolds())?;
    map.serialize_entry("convection", &calibration.convection)?;
    map.serialize_entry("residual_rms", &calibration.residual_rms)?;
    map.serialize_entry("chi_square", &calibration.chi_square)?;
    map.serialize_entry("degrees_of_freedom", &calibration.degrees_of_freedom)?;
    map.serialize_entry("reading_rms", &calibration.reading_rms)?;
    map.serialize_entry("misfit_rms", &calibration.misfit_rms)?;
    map.serialize_entry("grade", &calibration.grade())?;
    map.serialize_entry("mounting_deg", &calibration.rotation_rad.map(f64::to_degrees))?;
    map.serialize_entry("se_mounting_deg", &calibration.rotation_error_rad.map(f64::to_degrees))?;
    let by_name: BTreeMap<_, _> = calibration.surfaces.iter().map(|of| (&of.name, of)).collect();
    map.serialize_entry("surfaces", &by_name)
}

fn card<M: SerializeMap>(map: &mut M, calibration: &CardCalibration) -> Result<(), M::Error> {
    map.serialize_entry("winds", &calibration.winds)?;
    map.serialize_entry("reynolds", &[calibration.curves.least_reynolds, calibration.curves.most_reynolds])?;
    map.serialize_entry("exponent", &calibration.exponent)?;
    map.serialize_entry("mean_share", &calibration.curves.mean_share)?;
    map.serialize_entry("difference_share", &calibration.curves.difference_share)?;
    map.serialize_entry("seen_across", &calibration.seen_at(std::f64::consts::FRAC_PI_2))?;
    map.serialize_entry("seen_in_reverse", &calibration.seen_at(0.0))?;
    map.serialize_entry("gains", &calibration.gains)?;
    map.serialize_entry("quiescent_w_k", &calibration.quiescent_w_k)
}

impl fmt::Display for CalibrationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.result {
            CalibrationResult::Surfaces { calibration, directions, speeds } => {
                write!(f, "{calibration}\n{directions}\n{speeds}")?;
            }
            CalibrationResult::Card { calibration, winds } => write!(f, "{calibration}\n{winds}")?,
        }
        if self.short > 0 {
            let (winds, settle_s) = (count(self.short, "wind"), self.settle_s);
            let were = if self.short == 1 { "was" } else { "were" };
            writeln!(f, "\n{winds} {were} shorter than the {settle_s} s that are left out of each")?;
        }
        if matches!(self.result, CalibrationResult::Surfaces { .. }) {
            writeln!(f, "\nbandwidth  noise of a surface's conductance, at 30 K, 1 kHz")?;
        }
        for ConductanceNoise { bandwidth_hz, sd_w_k } in &self.noise {
            writeln!(f, "{bandwidth_hz:>6} Hz  {:>10} mW/K", short(1e3 * sd_w_k, 3))?;
        }
        self.written.iter().try_for_each(|path| writeln!(f, "\nhead written to {}", path.display()))
    }
}
