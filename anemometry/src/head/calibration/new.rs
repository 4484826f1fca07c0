//! A calibration that was just made, on its way to the end of a head file.

use dr_core::wind::SurfaceConfig;
use serde::Serialize;

use super::table::{CalibrationTable, CardTable, CrossHeatingTable, NusseltTable, SelfHeatingTable, SurfaceTable};
use crate::gas::Species;
use crate::head::error::NewCalibrationError;
use crate::head::file::Head;
use crate::network::kalman::ReadingNoise;
use crate::network::parameters::QuiescentNetwork;
use recording::toml_file::TomlSource;

/// A calibrated surface.
#[derive(Debug, Clone, PartialEq)]
pub struct NewSurface {
    /// Name of its element.
    pub element: String,
    /// Its geometry, in the tunnel's frame.
    pub surface: SurfaceConfig,
    /// Factor of its convective loss.
    pub gain: f64,
    /// Conductance in quiescent gas at the reference, W/K.
    pub quiescent_w_k: f64,
}

/// How conductances depend on the wind.
#[derive(Debug, Clone, PartialEq)]
pub enum Curves {
    /// Of a sphere: least and greatest Reynolds number, and the amplitudes between them.
    Nusselt(f64, f64, Vec<[f64; 6]>),
    /// Of a card.
    Card(Box<CardTable>),
}

/// A new calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct NewCalibration<'a> {
    /// Recordings and cross-validation, in words.
    pub made_from: String,
    /// The gas.
    pub species: Species,
    /// Temperature of the gas of the quiescent-gas network, °C.
    pub reference_gas_c: f64,
    /// Diameter of the sphere, or side of a die, m.
    pub diameter_m: f64,
    /// Directions that are more uncertain are flagged as none, °.
    pub direction_error_max_deg: f64,
    /// The element that measures the gas.
    pub reference: Option<String>,
    /// How conductances depend on the wind.
    pub curves: Curves,
    /// Surfaces, in the head's order.
    pub surfaces: Vec<NewSurface>,
    /// The quiescent-gas network.
    pub network: &'a QuiescentNetwork,
    /// Noise of readings, by element of the head.
    pub noise: &'a [ReadingNoise],
    /// Names of the head's elements.
    pub names: &'a [&'a str],
}

impl NewCalibration<'_> {
    /// The table, as the end of a head file.
    ///
    /// # Errors
    /// If it cannot be written as TOML.
    fn to_toml(&self) -> Result<String, toml::ser::Error> {
        #[derive(Serialize)]
        struct CalibrationTail {
            calibration: CalibrationTable,
        }
        toml::to_string(&CalibrationTail { calibration: self.table() })
    }

    /// The head's file with this calibration at its end, and the head that it makes.
    ///
    /// # Errors
    /// If it cannot be written, or not be read again.
    pub fn with_head(&self, head: &Head) -> Result<(String, Head), NewCalibrationError> {
        let tail = self.to_toml()?;
        let text = format!("{}\n{tail}", without_calibration(&head.source.text).trim_end());
        // What cannot be read again is not written.
        let source = TomlSource { path: head.source.path.clone(), text: text.clone() };
        let made = Head::from_source(source)?;
        Ok((text, made))
    }

    fn table(&self) -> CalibrationTable {
        let name = |element: usize| self.names.get(element).copied().unwrap_or_default().to_owned();
        let (nusselt, card) = match self.curves.clone() {
            Curves::Nusselt(least_reynolds, most_reynolds, amplitudes) => {
                (Some(NusseltTable { least_reynolds, most_reynolds, amplitudes }), None)
            }
            Curves::Card(card) => (None, Some(*card)),
        };
        CalibrationTable {
            made_from: self.made_from.clone(),
            species: self.species.name().to_owned(),
            reference_gas_c: self.reference_gas_c,
            diameter_m: self.diameter_m,
            direction_error_max_deg: self.direction_error_max_deg,
            reference: self.reference.clone(),
            nusselt,
            card,
            surfaces: self.surfaces.iter().map(surface_table).collect(),
            self_heating: self
                .network
                .own
                .iter()
                .map(|own| SelfHeatingTable {
                    element: name(own.element),
                    rest_c: own.rest_c,
                    noise_k: self.noise.get(own.element).map_or([1e-3; 2], |noise| [noise.low_k, noise.high_k]),
                    mesh_rad_s: own.mesh_rad_s.clone(),
                    r_k_per_w: own.r_k_per_w.clone(),
                    surface: own.surface.clone(),
                })
                .collect(),
            cross_heating: self
                .network
                .cross
                .iter()
                .map(|cross| CrossHeatingTable {
                    from: name(cross.from),
                    to: name(cross.to),
                    mesh_rad_s: cross.mesh_rad_s.clone(),
                    r_k_per_w: cross.r_k_per_w.clone(),
                    surface: cross.surface.clone(),
                })
                .collect(),
        }
    }
}

fn surface_table(of: &NewSurface) -> SurfaceTable {
    let SurfaceConfig { axis, corner, area_m2, means, threefold } = of.surface;
    SurfaceTable {
        element: of.element.clone(),
        axis: axis.map(f64::from),
        corner: corner.map(f64::from),
        area_m2: area_m2.into(),
        means: means.map(f64::from),
        threefold: threefold.map(f64::from),
        gain: of.gain,
        quiescent_w_k: of.quiescent_w_k,
    }
}

/// A head's text without a calibration that stands at its end.
pub fn without_calibration(text: &str) -> &str {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with("[calibration") {
            return &text[..at];
        }
        at += line.len();
    }
    text
}
