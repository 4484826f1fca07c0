//! From a head, its quiescent-gas network and its steady winds to the calibrated head.

use diffusive::model::Model;
use dr_core::wind::HeadForm;
use recording::RecordingError;
use recording::text::count;

use super::card;
use super::card::calibration::CardCalibration;
use super::card::drawn::DrawnCard;
use super::cross_validation::{CrossValidation, Scheme};
use super::drawn::{DrawnOptions, drawn, named};
use super::steady_table::SteadyTable;
use super::steady_wind::{CalibrateError, CalibratorError, SteadyWind};
use super::steady_winds::{ObservedHead, SteadyWindSearch};
use super::surfaces::calibration::SurfaceCalibration;
use super::surfaces::choice::{ConvectionOptions, chosen};
use super::surfaces::cross_validation::cross_validate;
use super::surfaces::readings::{DrawnSurfaces, LossLaw};
use super::surfaces::solve::calibrate;
use super::uncertainty::uncertainty;

use crate::gas::Species;
use crate::head::calibration::table::{CalibrationConditions, CalibrationTable, SurfaceTable, UncertaintyTable};
use crate::head::file::Head;
use crate::network::parameters::QuiescentNetwork;
use crate::wind::given_winds::GivenWinds;

/// Greatest number of folds of the cross-validation.
const FOLDS: usize = 10;
/// Held-out directions that are worse, rms, are those of another head, °.
const MOST_DIRECTION_DEG: f64 = 45.0;
/// The boom of a card lies along x, with its tip at +x.
const TIP: [f64; 3] = [1.0, 0.0, 0.0];

/// Where the quiescent-gas network of a head comes from.
#[derive(Clone, Copy)]
pub enum NetworkSource<'a> {
    /// Identified from recordings, by `anemo head identify`.
    Identified(&'a Model),
    /// A table of steady winds by itself.
    Table {
        /// The table.
        table: &'a SteadyTable,
        /// In which every surface follows a step of its power in still gas, s.
        time_constant_s: f64,
    },
}

/// A head that is going to be calibrated.
pub struct Calibrator<'a> {
    observed: ObservedHead<'a>,
    drawn: DrawnHead,
    law: Option<LossLaw>,
    convection: ConvectionOptions,
    /// Without a network of its own.
    is_by_table: bool,
}

/// Surfaces of a head as drawn.
enum DrawnHead {
    Surfaces(DrawnSurfaces),
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
    /// Result of surfaces on a sphere, round a cylinder, of wires or of one element.
    Surfaces {
        /// The calibration.
        calibration: Box<SurfaceCalibration>,
        /// Errors in directions that were left out; of a head that has none in every n-th wind.
        directions: CrossValidation,
        /// Errors in speeds that were left out.
        speeds: CrossValidation,
    },
    /// Result of a card.
    Card {
        /// The calibration.
        calibration: Box<CardCalibration>,
        /// Errors in winds that were left out.
        winds: CrossValidation,
    },
}

impl<'a> Calibrator<'a> {
    /// For the elements of a head that have a normal, or the named ones of them; for the card of
    /// four dice if these are four with one normal: the two at the tip, the second of them around
    /// the boom from the first, then the two behind, each beside the one before it. Without a
    /// `law` that one is taken whose held-out speeds are better.
    ///
    /// # Errors
    /// If the normals are those of no head, or the network is not one of it.
    pub fn new(
        head: &'a Head,
        network: NetworkSource<'_>,
        options: &DrawnOptions,
        law: Option<LossLaw>,
    ) -> Result<Self, CalibratorError> {
        let refuse = |sentence: &str| Err(CalibratorError::Options(sentence.to_owned()));
        if let Some((places, drawn)) = card(head, options)? {
            if options.film_share.is_some() {
                return refuse("--properties is of surfaces round a body: the law of a card has its own numbers");
            }
            if matches!(network, NetworkSource::Table { .. }) {
                return refuse("dice of one card warm each other: in place of --time-constant they need --network");
            }
            return Self::of(head, network, options, (places, None), (DrawnHead::Card(drawn), None));
        }
        let (places, drawn) = drawn(head, options, law.unwrap_or(LossLaw::Spline))?;
        if matches!(law, Some(LossLaw::King { .. })) && !has_law(drawn.form) {
            return refuse(
                "--law king is of a single element or of wires: round a sphere or a cylinder each order has its own",
            );
        }
        let reference = head.elements.iter().position(|element| element.name == recording::REFERENCE);
        Self::of(head, network, options, (places, reference), (DrawnHead::Surfaces(drawn), law))
    }

    fn of(
        head: &'a Head,
        network: NetworkSource<'_>,
        options: &DrawnOptions,
        (surfaces, reference): (Vec<usize>, Option<usize>),
        (drawn, law): (DrawnHead, Option<LossLaw>),
    ) -> Result<Self, CalibratorError> {
        let is_by_table = matches!(network, NetworkSource::Table { .. });
        let (network, quiescent) = match network {
            NetworkSource::Identified(model) => {
                (QuiescentNetwork::of(model, head)?, model.provenance.conditions.clone())
            }
            NetworkSource::Table { table, time_constant_s } => {
                let (network, conditions) = table.network(head, &surfaces, time_constant_s)?;
                (network, Some(conditions))
            }
        };
        if let Some(&missing) = surfaces.iter().find(|&&place| network.own.iter().all(|own| own.element != place)) {
            let (element, head) = (&head.elements[missing].name, &head.name);
            return Err(CalibratorError::Head(format!(
                "network has no `{element}`, which is a surface of head `{head}`: is it of another head?"
            )));
        }
        let quiescent = quiescent.ok_or_else(|| CalibratorError::Head("does not tell its gas".to_owned()))?;
        let species = Species::named(&quiescent.species)
            .ok_or_else(|| CalibratorError::Head(format!("is of the gas {}", quiescent.species)))?;
        let observed = ObservedHead { head, network, surfaces, reference, species, quiescent };
        let &DrawnOptions { film_share, gravity, stem, .. } = options;
        let convection = ConvectionOptions { film_share, gravity, stem };
        Ok(Self { observed, drawn, law, convection, is_by_table })
    }

    /// The steady winds of a user's own tables.
    ///
    /// # Errors
    /// If a column is missing, or a row cannot be meant.
    pub fn winds_of(&self, tables: &[SteadyTable]) -> Result<Vec<SteadyWind>, RecordingError> {
        let each = tables.iter().map(|table| table.winds(&self.observed));
        Ok(each.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    }

    /// Search for steady winds in recordings; `settle_s` is left out at the beginning of every
    /// wind.
    pub fn search<'b>(&'b self, settle_s: f64, winds: Option<&'b GivenWinds>) -> SteadyWindSearch<'b> {
        SteadyWindSearch { observed: &self.observed, settle_s, winds }
    }

    /// The calibrated head, with its errors in winds that were left out; `recordings` says where
    /// the winds are from.
    ///
    /// # Errors
    /// If winds are missing, or nothing can be fitted.
    pub fn calibrated(
        &self,
        steady: &[SteadyWind],
        recordings: &str,
        direction_error_max_deg: f64,
    ) -> Result<CalibratedHead, CalibratorError> {
        let mut result = self.result(steady)?;
        if let (true, CalibrationResult::Surfaces { calibration, .. }) = (self.is_by_table, &mut result) {
            // A network by the table itself has taken still gas out of the readings.
            calibration.surfaces.iter_mut().for_each(|surface| surface.is_quiescent_fitted = false);
        }
        let (winds, form, diameter_m, nusselt, card, convection) = match &result {
            CalibrationResult::Surfaces { calibration: of, .. } => {
                let (nusselt, convection) = (Some(of.curves.clone()), of.convection.clone());
                (count(of.winds, "wind"), of.form, of.diameter_m, nusselt, None, convection)
            }
            CalibrationResult::Card { calibration: of, .. } => {
                let winds = format!("{} winds in the plane of a card,", of.winds);
                (winds, HeadForm::Sphere, of.drawn.side_m, None, Some(of.curves.clone()), None)
            }
        };
        let overall = result.cross_validation().overall();
        let ObservedHead { head, network, reference, species, quiescent, .. } = &self.observed;
        let new = CalibrationTable {
            made_from: format!("{winds} of {recordings}; cross-validated: {}", overall.in_words()),
            made_on: None,
            version: None,
            former: None,
            species: *species,
            reference_gas_c: quiescent.gas_temperature_c,
            support_c: (!self.is_by_table).then_some(quiescent.support_temperature_c),
            conditions: CalibrationConditions::of(steady.iter().map(SteadyWind::conditions)),
            form,
            diameter_m,
            direction_error_max_deg,
            reference: reference.map(|element| head.elements[element].name.clone()),
            nusselt,
            card,
            convection,
            uncertainty: self.uncertainty(&result, steady)?,
            correction: None,
            surfaces: self.surfaces(&result),
            self_heating: network.own.clone(),
            cross_heating: network.cross.clone(),
        };
        let (text, head) = new.with_head(head)?;
        Ok(CalibratedHead { text, head, result })
    }

    fn result(&self, steady: &[SteadyWind]) -> Result<CalibrationResult, CalibratorError> {
        Ok(match &self.drawn {
            DrawnHead::Surfaces(drawn) => self.surfaces_result(drawn, steady)?,
            DrawnHead::Card(drawn) => CalibrationResult::Card {
                calibration: Box::new(card::calibrate(drawn, steady)?),
                winds: card::cross_validate(drawn, steady, FOLDS)?,
            },
        })
    }

    /// By the law that was requested, or the one that is better at speeds that it has not seen.
    fn surfaces_result(
        &self,
        drawn: &DrawnSurfaces,
        steady: &[SteadyWind],
    ) -> Result<CalibrationResult, CalibrateError> {
        let (any, king) = (LossLaw::Spline, LossLaw::King { exponent: None });
        let laws = match self.law {
            Some(law) => vec![law],
            None if has_law(drawn.form) => vec![king, any],
            None => vec![any],
        };
        let convection = chosen(drawn, steady, &self.convection)?;
        let mut best: Option<CalibrationResult> = None;
        let mut refused = None;
        for law in laws {
            let drawn = DrawnSurfaces { law, convection: convection.clone(), ..drawn.clone() };
            match surfaces_by(&drawn, steady) {
                Ok(found) if best.as_ref().is_none_or(|best| found.speed_rms() < best.speed_rms()) => {
                    best = Some(found)
                }
                Ok(_) => {}
                Err(error) => refused = Some(error),
            }
        }
        best.ok_or(refused.unwrap_or(CalibrateError::NoMinimum))
    }

    /// Uncertainty that the calibration adds to the uncertainty of a wind.
    fn uncertainty(
        &self,
        result: &CalibrationResult,
        steady: &[SteadyWind],
    ) -> Result<Option<UncertaintyTable>, CalibrateError> {
        let by_region = &result.cross_validation().compared;
        Ok(match (result, &self.drawn) {
            (CalibrationResult::Surfaces { calibration: of, .. }, DrawnHead::Surfaces(drawn)) => {
                let axes = if of.form.is_sphere() && of.surfaces.len() > 2 { 2.0 } else { 1.0 };
                let drawn = DrawnSurfaces { convection: of.sought.clone(), ..drawn.clone() };
                let singly = cross_validate(&drawn, steady, Scheme::EveryNth, FOLDS)?.compared;
                uncertainty(by_region, &singly, of.reynolds(), axes)
            }
            // A card states its own shares, and follows its winds for minutes, which no mean has.
            _ => None,
        })
    }

    fn surfaces(&self, result: &CalibrationResult) -> Vec<SurfaceTable> {
        // Geometry, gain and conductance in quiescent gas.
        let found: Vec<_> = match result {
            CalibrationResult::Surfaces { calibration, .. } => {
                calibration.surfaces.iter().map(|of| (of.config, of.gain, of.quiescent_w_k)).collect()
            }
            CalibrationResult::Card { calibration, .. } => {
                let dice = calibration.drawn.dice().into_iter().zip(calibration.gains);
                dice.map(|(config, gain)| (config, gain, calibration.quiescent_w_k)).collect()
            }
        };
        let ObservedHead { head, surfaces, .. } = &self.observed;
        let names = surfaces.iter().map(|&place| head.elements[place].name.clone());
        names.zip(found).map(|(name, (config, gain, g0_w_k))| SurfaceTable::new(name, config, gain, g0_w_k)).collect()
    }
}

/// Tells whether King's law may be that of a head.
fn has_law(form: HeadForm) -> bool {
    matches!(form, HeadForm::Single | HeadForm::Wires)
}

/// A calibration by one law, with its errors in winds that were left out.
fn surfaces_by(drawn: &DrawnSurfaces, steady: &[SteadyWind]) -> Result<CalibrationResult, CalibrateError> {
    let by_direction = if drawn.form == HeadForm::Single { Scheme::EveryNth } else { Scheme::Directions };
    let calibration = Box::new(calibrate(drawn, steady)?);
    let directions = cross_validate(drawn, steady, by_direction, FOLDS)?;
    let rms_deg = directions.overall().direction_rms_deg;
    if rms_deg > MOST_DIRECTION_DEG {
        return Err(CalibrateError::Direction(rms_deg));
    }
    Ok(CalibrationResult::Surfaces {
        calibration,
        directions,
        speeds: cross_validate(drawn, steady, Scheme::Speeds, FOLDS)?,
    })
}

impl CalibrationResult {
    /// Error in speeds that were left out, rms.
    fn speed_rms(&self) -> f64 {
        match self {
            Self::Surfaces { speeds, .. } => speeds.overall().speed_rms,
            Self::Card { winds, .. } => winds.overall().speed_rms,
        }
    }

    /// The cross-validation by which the calibration is judged.
    pub fn cross_validation(&self) -> &CrossValidation {
        match self {
            Self::Surfaces { directions, .. } => directions,
            Self::Card { winds, .. } => winds,
        }
    }
}

/// Places in the head, and the card that they are on, if the named elements are of one.
fn card(head: &Head, options: &DrawnOptions) -> Result<Option<(Vec<usize>, DrawnCard)>, CalibratorError> {
    let places = named(head, &options.elements)?;
    let normals: Vec<_> = places.iter().filter_map(|&place| head.elements[place].normal).collect();
    let like = |normal: &[f64; 3]| normals.iter().filter(|of| **of == *normal).count();
    let Some(normal) = normals.iter().find(|normal| like(normal) > 1) else { return Ok(None) };
    if like(normal) < normals.len() {
        let sentence = ": dice of one card have the same outward `normal` in the head, parts of one body all others";
        return Err(CalibratorError::Options(format!("--elements{sentence}")));
    }
    if places.len() != 4 {
        let sentence = format!("--elements names {} with one `normal`: a card has four dice", places.len());
        return Err(CalibratorError::Options(sentence));
    }
    Ok(Some((places, DrawnCard { side_m: options.die_m, normal: *normal, tip: TIP })))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::drawn::surfaces_of;
    use super::super::steady_wind::SurfaceReading;
    use super::super::surfaces::readings::DrawnSurface;
    use super::super::surfaces::sought::SoughtConvection;
    use super::*;
    use crate::gas::IdealGas;
    use crate::vector::{dot, unit};

    /// Films of 0.5 mm in winds within an angle of x, by King's law to 0.1 %.
    fn films(
        normals: [[f64; 3]; 2],
        yaw_factor: f64,
        winds: i32,
        within_deg: f64,
    ) -> Result<CalibrationResult, CalibrateError> {
        let gas = IdealGas::new(Species::Air, 101_325.0, 293.15).unwrap();
        let built = [unit([1.0, 1.0, 0.0]), unit([1.0, -1.0, 0.0])];
        let wind = |n: i32| {
            let share = |by: f64| (f64::from(n + 1) * by).fract();
            let (speed, angle) =
                (0.5 * libm::pow(20.0, share(0.618)), 2.0 * within_deg.to_radians() * (share(0.755) - 0.5));
            let wind_m_s = [-speed * libm::cos(angle), -speed * libm::sin(angle), 0.0];
            let surfaces = built.map(|normal| {
                let (along, turned) = (dot(wind_m_s, normal), dot(wind_m_s, [-normal[1], normal[0], 0.0]));
                let power_w = 20.0 * 2e-4 * libm::pow(libm::hypot(along, yaw_factor * turned), 0.45);
                SurfaceReading {
                    power_w,
                    overheat_k: 20.0,
                    above_reference_k: 20.0,
                    variance_w2: (1e-3 * power_w).powi(2),
                }
            });
            SteadyWind { label: format!("wind {n}"), wind_m_s, gas, surfaces: surfaces.into() }
        };
        let surfaces = surfaces_of(HeadForm::Wires, &normals, 5e-4, 5e-3).unwrap().into_iter();
        let surfaces = surfaces.map(|config| DrawnSurface { name: "film".to_owned(), config }).collect();
        let law = LossLaw::King { exponent: None };
        let convection = SoughtConvection::default();
        let drawn = DrawnSurfaces { form: HeadForm::Wires, law, diameter_m: 5e-4, surfaces, convection };
        surfaces_by(&drawn, &(0..winds).map(wind).collect::<Vec<_>>())
    }

    const ACROSS: [[f64; 3]; 2] = {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        [[half, half, 0.0], [half, -half, 0.0]]
    };

    #[test]
    fn winds_that_wires_see_mirrored_are_refused() {
        let mirrored = |normals, within_deg| match films(normals, 0.2, 60, within_deg) {
            Err(CalibrateError::Mirrored(labels)) => labels.len(),
            Err(error) => panic!("{error}"),
            Ok(_) => 0,
        };
        assert_eq!(mirrored(ACROSS, 34.0), 0);
        assert_eq!(mirrored(ACROSS.map(|normal| normal.map(|x| -x)), 34.0), 60, "all from behind");
        // Beyond 45° of the middle, and 5° that a mounting may be off, are 30 of 80.
        assert!((20..26).contains(&mirrored(ACROSS, 80.0)));
        assert_eq!(mirrored(ACROSS, 49.0), 0);
        assert!((20..36).contains(&mirrored([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 34.0)), "half of them");
    }

    #[test]
    fn the_yaw_factor_is_that_of_the_law_and_not_of_six_cosines() {
        for built in [0.0, 0.05, 0.1, 0.15, 0.25, 0.4] {
            let Ok(CalibrationResult::Surfaces { calibration, .. }) = films(ACROSS, built, 60, 45.0) else {
                panic!("yaw factor {built}")
            };
            let king = calibration.king.unwrap();
            let (yaw, error) = (king.yaw_factor.unwrap(), king.se_yaw_factor.unwrap());
            assert!((yaw - built).abs() < 1e-4 && (king.exponent / 0.45 - 1.0).abs() < 1e-4, "{built}: {king:?}");
            assert!(error > 0.0 && error < 0.01, "{built} ± {error}");
        }
    }

    #[test]
    fn a_network_that_lacks_a_surface_of_the_head_is_refused_by_its_name() {
        // It has hemisphere 1 and a core.
        let model = crate::network::from_model::tests::model();
        let head = Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-a.toml")).unwrap();
        let refused = Calibrator::new(&head, NetworkSource::Identified(&model), &DrawnOptions::default(), None)
            .err()
            .unwrap()
            .to_string();
        assert_eq!(
            refused,
            "network has no `hemisphere2`, which is a surface of head `sphere-a`: is it of another head?"
        );
    }
}
