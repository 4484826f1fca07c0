//! Mean readings of a head in one steady, known wind; reasons why readings make no calibration.

use dr_core::ConfigError;
use dr_core::wind::GasState;
use recording::RecordingError;
use recording::toml_file::FileError;

use crate::gas::{IdealGas, ZERO_CELSIUS_K};
use crate::network::parameters::NetworkError;

/// One steady wind.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyWind {
    /// Label of the conditions.
    pub label: String,
    /// Where the gas goes to, m/s, in the tunnel's frame; zero for quiescent gas.
    pub wind_m_s: [f64; 3],
    /// The gas.
    pub gas: IdealGas,
    /// Readings of the surfaces, in the head's order.
    pub surfaces: Vec<SurfaceReading>,
}

/// Mean readings of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceReading {
    /// Convective power beyond that in quiescent gas at the reference, W.
    pub power_w: f64,
    /// Surface over gas, K.
    pub overheat_k: f64,
    /// Surface over the gas of the identification, K.
    pub above_reference_k: f64,
    /// Variance of the mean of `power_w`, W².
    pub variance_w2: f64,
}

impl SteadyWind {
    /// Gas temperature, °C, pressure, Pa, and temperatures of the surfaces, °C.
    pub(super) fn conditions(&self) -> (f64, f64, Vec<f64>) {
        let gas_c = self.gas.temperature_k - ZERO_CELSIUS_K;
        (gas_c, self.gas.pressure_pa, self.surfaces.iter().map(|of| gas_c + of.overheat_k).collect())
    }

    /// Mean overheat of the surfaces, K.
    pub(super) fn overheat_k(&self) -> f64 {
        self.surfaces.iter().map(|of| of.overheat_k).sum::<f64>() / self.surfaces.len() as f64
    }

    /// The gas as dr-core takes it, with its properties at so great a share of the way from its
    /// temperature to that of the surfaces.
    pub(super) fn core_gas(&self, film_share: f64) -> Result<GasState, CalibrateError> {
        let IdealGas { species, pressure_pa, temperature_k, .. } = self.gas;
        let properties_k = temperature_k + film_share * self.overheat_k();
        let gas = match film_share > 0.0 {
            true => {
                IdealGas::new(species, pressure_pa, properties_k).map_err(|error| self.refuse(error.to_string()))?
            }
            false => self.gas,
        };
        let IdealGas { density_kg_m3, viscosity_pa_s, conductivity_w_m_k, .. } = gas;
        GasState::new(density_kg_m3 as f32, viscosity_pa_s as f32, conductivity_w_m_k as f32)
            .map_err(|error| self.refuse(format!("gas: {error}")))
    }

    /// The error for a reading of this wind.
    pub(super) fn refuse(&self, problem: String) -> CalibrateError {
        CalibrateError::Reading(format!("`{}`: {problem}", self.label))
    }
}

/// Readings from which no calibration can be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// The head as drawn cannot be.
    #[error("head: {0}")]
    Head(String),
    /// A reading cannot be meant.
    #[error("wind {0}")]
    Reading(String),
    /// Winds are missing: a sentence each.
    #[error("the winds do not determine a calibration:\n  {}", .0.join("\n  "))]
    Spread(Vec<String>),
    /// The fit does not converge.
    #[error(
        "no best fit of the readings could be found: a gain is far from 1 or the mounting far from drawn; check the order of the surfaces \
         and the frame of the winds"
    )]
    NoMinimum,
    /// The best fit is a bad one.
    #[error(
        "what fits best leaves {:.0} % rms of the convective power, most of it `{}`, {}: surfaces in another order than the head's, winds in \
         another frame, or a surface of the head that is not as drawn; surfaces that are no body together are calibrated one by one, \
         `--elements {} --form single`, and combined by `anemo combine`",
        100.0 * residual_rms, worst.label, worst.surface, worst.surface
    )]
    Unexplained {
        /// Residuals over the convective power, rms.
        residual_rms: f64,
        /// The reading that fits least.
        worst: WorstReading,
    },
    /// Winds from where wires see the same as from elsewhere.
    #[error(
        "{} of the winds, such as `{}`, come from where the wires see the same as from in front: from behind their normals, or \
         from outside the quadrant between two normals that stand at right angles; turn the normals or the frame of the winds, or leave such \
         winds out",
        .0.len(), .0[0]
    )]
    Mirrored(Vec<String>),
    /// The fit tells no direction.
    #[error(
        "directions that were left out of the fit come out {0:.0}° wrong, rms: check the frame of the winds, the normals \
         and the order of the surfaces"
    )]
    Direction(f64),
    /// dr-core refuses the curves.
    #[error(
        "the amplitudes that fit best do not tell a wind: {0}; check the order of the surfaces and the signs of the winds"
    )]
    Amplitudes(#[from] ConfigError),
}

/// The reading that fits least.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstReading {
    /// Label of its wind.
    pub label: String,
    /// Name of its surface.
    pub surface: String,
    /// Measured less computed, in standard errors.
    pub errors: f64,
}

/// A head, a network or steady winds that make no calibrated head.
#[derive(Debug, thiserror::Error)]
pub enum CalibratorError {
    /// The network cannot be one of the head.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The head is no sphere that can be calibrated, or the network lacks its surfaces or its gas.
    #[error("{0}")]
    Head(String),
    /// Options that do not fit the head, with the option's name.
    #[error("{0}")]
    Options(String),
    /// Nothing can be fitted.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// A table of steady winds cannot be used.
    #[error(transparent)]
    Table(#[from] RecordingError),
    /// The calibration makes no head.
    #[error(transparent)]
    File(#[from] FileError),
}
