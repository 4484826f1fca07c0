//! From a head, its quiescent-gas network and its steady winds to the calibrated head.

use dr_core::wind::{SurfaceConfig, sphere};
use recording::text::suggest;

use super::card::drawn::DrawnCard;
use super::card::{self, calibration::CardCalibration};
use super::cross_validation::{CrossValidation, Scheme};
use super::error::CalibratorError;
use super::sphere::calibration::SphereCalibration;
use super::sphere::cross_validation::cross_validate;
use super::sphere::readings::{DrawnSphere, DrawnSurface};
use super::sphere::solve::calibrate;
use super::steady_wind::SteadyWind;
use super::steady_winds::{ObservedHead, SteadyWindSearch};
use crate::gas::Species;
use crate::head::calibration::table::{CalibrationTable, SurfaceTable};
use crate::head::file::Head;
use crate::network::parameters::QuiescentNetwork;
use crate::wind::given_winds::GivenWinds;
use diffusive::model::Model;

/// Greatest number of folds of the cross-validation.
const FOLDS: usize = 10;
/// The boom of a card lies along x, with its tip at +x.
const TIP: [f64; 3] = [1.0, 0.0, 0.0];

/// A head that is going to be calibrated.
pub struct Calibrator<'a> {
    observed: ObservedHead<'a>,
    drawn: DrawnHead,
}

/// Surfaces of a head as drawn.
enum DrawnHead {
    Sphere(DrawnSphere),
    Card(DrawnCard),
}

/// A calibrated head.
pub struct CalibratedHead {
    /// Text of the head file.
    pub text: String,
    /// The head that it makes.
    pub head: Head,
    /// The calibration, with its errors.
    pub result: CalibrationResult,
}

/// A calibration and its cross-validation.
pub enum CalibrationResult {
    /// Of a sphere.
    Sphere {
        /// The calibration.
        calibration: Box<SphereCalibration>,
        /// Errors in directions that were left out.
        directions: CrossValidation,
        /// Errors in speeds that were left out.
        speeds: CrossValidation,
    },
    /// Of a card.
    Card {
        /// The calibration.
        calibration: Box<CardCalibration>,
        /// Errors in winds that were left out.
        winds: CrossValidation,
    },
}

impl<'a> Calibrator<'a> {
    /// For a sphere; `model` is the quiescent-gas network of `anemo head identify`.
    ///
    /// # Errors
    /// If the head is no sphere, or the network is not one of it.
    pub fn new(head: &'a Head, model: &Model, diameter_m: f64) -> Result<Self, CalibratorError> {
        let (places, drawn) = sphere(head, diameter_m)?;
        let reference = head.elements.iter().position(|element| element.name == recording::REFERENCE);
        Self::of(head, model, places, reference, DrawnHead::Sphere(drawn))
    }

    /// For the card of four dice: the two at the tip, the second of them around the boom from the
    /// first, then the two behind, each beside the one before it.
    ///
    /// # Errors
    /// If the elements are not the dice of one card, or the network is not one of the head.
    pub fn card(head: &'a Head, model: &Model, elements: &[String], side_m: f64) -> Result<Self, CalibratorError> {
        let (places, drawn) = dice(head, elements, side_m)?;
        Self::of(head, model, places, None, DrawnHead::Card(drawn))
    }

    fn of(
        head: &'a Head,
        model: &Model,
        surfaces: Vec<usize>,
        reference: Option<usize>,
        drawn: DrawnHead,
    ) -> Result<Self, CalibratorError> {
        let network = QuiescentNetwork::of(model, head)?;
        if let Some(&missing) = surfaces.iter().find(|&&place| network.own.iter().all(|own| own.element != place)) {
            let (element, head) = (&head.elements[missing].name, &head.name);
            return Err(CalibratorError::Head(format!(
                "network has no `{element}`, which is a surface of head `{head}`: is it of another head?"
            )));
        }
        let quiescent = model.provenance.conditions.clone();
        let quiescent = quiescent.ok_or_else(|| CalibratorError::Head("does not tell its gas".to_owned()))?;
        let species = Species::named(&quiescent.species)
            .ok_or_else(|| CalibratorError::Head(format!("is of the gas {}", quiescent.species)))?;
        Ok(Self { observed: ObservedHead { head, network, surfaces, reference, species, quiescent }, drawn })
    }

    /// Search for steady winds in recordings; `settle_s` is left out at the beginning of every
    /// wind.
    pub fn search<'b>(&'b self, settle_s: f64, winds: Option<&'b GivenWinds>) -> SteadyWindSearch<'b> {
        SteadyWindSearch { observed: &self.observed, settle_s, winds }
    }

    /// The calibrated head, with its errors in winds that were left out.
    ///
    /// # Errors
    /// If winds are missing, or nothing can be fitted.
    pub fn calibrated(
        &self,
        steady: &[SteadyWind],
        recordings: usize,
        direction_error_max_deg: f64,
    ) -> Result<CalibratedHead, CalibratorError> {
        let result = self.result(steady)?;
        let (winds, diameter_m, nusselt, card) = match &result {
            CalibrationResult::Sphere { calibration: of, .. } => {
                (format!("{} winds", of.winds), of.diameter_m, Some(of.curves.clone()), None)
            }
            CalibrationResult::Card { calibration: of, .. } => {
                let winds = format!("{} winds in the plane of a card,", of.winds);
                (winds, of.drawn.side_m, None, Some(of.curves.clone()))
            }
        };
        let overall = result.cross_validation().overall();
        let ObservedHead { head, network, reference, species, quiescent, .. } = &self.observed;
        let new = CalibrationTable {
            made_from: format!(
                "{winds} of {recordings} recordings; cross-validated: direction {:.2}° rms, speed {:.2} % rms",
                overall.direction_rms_deg,
                100.0 * overall.speed_rms
            ),
            species: *species,
            reference_gas_c: quiescent.gas_temperature_c,
            diameter_m,
            direction_error_max_deg,
            reference: reference.map(|element| head.elements[element].name.clone()),
            nusselt,
            card,
            surfaces: self.surfaces(&result),
            self_heating: network.own.clone(),
            cross_heating: network.cross.clone(),
        };
        let (text, head) = new.with_head(head)?;
        Ok(CalibratedHead { text, head, result })
    }

    fn result(&self, steady: &[SteadyWind]) -> Result<CalibrationResult, CalibratorError> {
        Ok(match &self.drawn {
            DrawnHead::Sphere(drawn) => CalibrationResult::Sphere {
                calibration: Box::new(calibrate(drawn, steady)?),
                directions: cross_validate(drawn, steady, Scheme::Directions, FOLDS)?,
                speeds: cross_validate(drawn, steady, Scheme::Speeds, FOLDS)?,
            },
            DrawnHead::Card(drawn) => CalibrationResult::Card {
                calibration: Box::new(card::calibrate(drawn, steady)?),
                winds: card::cross_validate(drawn, steady, FOLDS)?,
            },
        })
    }

    fn surfaces(&self, result: &CalibrationResult) -> Vec<SurfaceTable> {
        // Geometry, gain and conductance in quiescent gas.
        let found: Vec<(SurfaceConfig, f64, f64)> = match result {
            CalibrationResult::Sphere { calibration, .. } => {
                calibration.surfaces.iter().map(|of| (of.config, of.gain, of.quiescent_w_k)).collect()
            }
            CalibrationResult::Card { calibration, .. } => {
                let dice = calibration.drawn.dice().into_iter().zip(calibration.gains);
                dice.map(|(config, gain)| (config, gain, calibration.quiescent_w_k)).collect()
            }
        };
        let names = self.observed.surfaces.iter().map(|&place| self.observed.head.elements[place].name.clone());
        names
            .zip(found)
            .map(|(name, (config, gain, quiescent_w_k))| SurfaceTable::new(name, config, gain, quiescent_w_k))
            .collect()
    }
}

impl CalibrationResult {
    /// The cross-validation by which the calibration is judged.
    pub fn cross_validation(&self) -> &CrossValidation {
        match self {
            Self::Sphere { directions, .. } => directions,
            Self::Card { winds, .. } => winds,
        }
    }
}

/// Places in the head and geometry of the surfaces: four sectors of a tetrahedron, or two
/// hemispheres.
fn sphere(head: &Head, diameter_m: f64) -> Result<(Vec<usize>, DrawnSphere), CalibratorError> {
    let outward: Vec<(usize, [f64; 3])> = head
        .elements
        .iter()
        .enumerate()
        .filter_map(|(place, element)| element.normal.map(|normal| (place, normal)))
        .collect();
    let narrow = |v: [f64; 3]| v.map(|x| x as f32);
    let shapes: Vec<_> = match outward.len() {
        4 => sphere::tetrahedral_sectors(diameter_m as f32).to_vec(),
        2 => sphere::hemispheres(diameter_m as f32).to_vec(),
        count => {
            return Err(CalibratorError::Head(format!(
                "head `{}` has {count} elements with an outward `normal`: four sectors of a sphere, or two hemispheres can be calibrated",
                head.name
            )));
        }
    };
    let surfaces = outward.iter().zip(shapes).enumerate().map(|(i, ((place, normal), mut config))| {
        config.axis = narrow(*normal);
        if outward.len() == 4 {
            // A corner of a sector is opposite to the axis of another.
            config.corner = narrow(outward[(i + 1) % 4].1.map(|x| -x));
        } else {
            // Any direction across the axis: a hemisphere has no corner.
            let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
            config.corner = std::array::from_fn(|k| if k == least { 1.0 } else { 0.0 });
        }
        DrawnSurface { name: head.elements[*place].name.clone(), config }
    });
    let surfaces = surfaces.collect();
    Ok((outward.iter().map(|(place, _)| *place).collect(), DrawnSphere { diameter_m, surfaces }))
}

/// Places in the head, and the card that they are on.
fn dice(head: &Head, elements: &[String], side_m: f64) -> Result<(Vec<usize>, DrawnCard), CalibratorError> {
    let refuse = CalibratorError::Elements;
    if elements.len() != 4 {
        return Err(refuse(format!(" names {}: four dice of one card belong there", elements.len())));
    }
    let names = head.names();
    let place = |name: &String| {
        names.iter().position(|known| known == name).ok_or_else(|| {
            let hint = suggest(name, names.iter().copied());
            refuse(format!(": `{name}` is no element of head `{}`; {hint}", head.name))
        })
    };
    let places = elements.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    let normals: Vec<_> = places.iter().filter_map(|&place| head.elements[place].normal).collect();
    match normals.first() {
        Some(normal) if normals.len() == 4 && normals.iter().all(|other| other == normal) => {
            Ok((places, DrawnCard { side_m, normal: *normal, tip: TIP }))
        }
        _ => Err(refuse(": dice of one card have the same outward `normal` in the head".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_network_that_lacks_a_surface_of_the_head_is_refused_by_its_name() {
        // It has hemisphere 1 and a core.
        let model = crate::network::from_model::tests::model();
        let head = Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads/sphere-a.toml")).unwrap();
        let refused = Calibrator::new(&head, &model, 0.01).err().unwrap().to_string();
        assert_eq!(
            refused,
            "network has no `hemisphere2`, which is a surface of head `sphere-a`: is it of another head?"
        );
    }
}
