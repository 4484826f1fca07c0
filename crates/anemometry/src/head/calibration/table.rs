//! The tables of a calibration as they stand in a head file, read and written: every key, before
//! anything is checked.

use dr_core::wind::calibration_uncertainty::{CalibrationUncertainty, KNOTS};
use dr_core::wind::card_inverse::{KNOTS as CARD_KNOTS, TERMS};
use dr_core::wind::free_stream::STEM_KNOTS;
use dr_core::wind::nusselt::{ORDERS, POINTS};
use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{CardConfig, ConvectionConfig, HeadForm, NusseltConfig, RiseConfig, StemConfig, SurfaceConfig};
use recording::text::tidy;
use recording::toml_file::exactly;
use serde::{Deserialize, Serialize};

use crate::gas::Species;
use crate::network::parameters::{CrossHeatingParameters, SelfHeatingParameters};

/// `[calibration]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CalibrationTable {
    /// Recordings and cross-validation of the calibration, in words.
    pub made_from: String,
    /// Day of its recordings, as 2026-03-01, where they state it.
    pub made_on: Option<String>,
    /// Its version; 1 if it does not state one.
    pub version: Option<u32>,
    /// The calibration that this one was made of by a scale, in words.
    pub former: Option<String>,
    /// The gas that it holds for.
    pub species: Species,
    /// Temperature of the gas of the quiescent-gas network, °C.
    pub reference_gas_c: f64,
    /// Temperature of the support in the records of the quiescent-gas network, °C, if they say it.
    pub support_c: Option<f64>,
    /// Form that the surfaces belong to; without the key parts of a sphere, or dice.
    #[serde(default, skip_serializing_if = "is_sphere")]
    pub form: HeadForm,
    /// Diameter of sphere, cylinder or wire, or side of a die, m.
    pub diameter_m: f64,
    /// Directions that are more uncertain are flagged as none, °.
    pub direction_error_max_deg: f64,
    /// The element that measures the gas.
    pub reference: Option<String>,
    /// Dependence of conductances on the wind, but of a card.
    pub nusselt: Option<NusseltTable>,
    /// The same of a card.
    pub card: Option<CardTable>,
    /// Convection of the surfaces.
    pub convection: Option<ConvectionModelTable>,
    /// In which gas and at which temperatures it was made; older heads do not state it.
    pub conditions: Option<CalibrationConditions>,
    /// Amount that it adds to the uncertainty of the wind.
    pub uncertainty: Option<UncertaintyTable>,
    /// Slow errors that are taken out.
    pub correction: Option<CorrectionTable>,
    /// Surfaces, in the head's order.
    #[serde(default)]
    pub surfaces: Vec<SurfaceTable>,
    /// Self-heating of the quiescent-gas network.
    #[serde(default)]
    pub self_heating: Vec<SelfHeatingParameters>,
    /// Cross-heating of the quiescent-gas network.
    #[serde(default)]
    pub cross_heating: Vec<CrossHeatingParameters>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_sphere(form: &HeadForm) -> bool {
    *form == HeadForm::Sphere
}

/// `[calibration.nusselt]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NusseltTable {
    /// Least Reynolds number of the winds.
    pub least_reynolds: f64,
    /// Greatest Reynolds number of the winds.
    pub most_reynolds: f64,
    /// a_0 … a_5 at Reynolds numbers in geometric progression from the least to the greatest.
    pub amplitudes: [[f64; ORDERS]; POINTS],
}

/// `[calibration.convection]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ConvectionModelTable {
    /// At which temperature the properties of the gas are taken.
    pub properties: PropertyTemperature,
    /// Nusselt number in quiescent gas.
    pub nusselt_at_rest: f64,
    /// Reynolds number of the slowest wind.
    pub slowest_reynolds: f64,
    /// Least and greatest temperature of the gas, °C.
    #[serde(deserialize_with = "exactly")]
    pub gas_c: [f64; 2],
    /// Amount that each kelvin beyond these adds to the standard uncertainty of the speed, as its
    /// share.
    pub speed_share_per_k: f64,
    /// The same of the direction, °.
    pub direction_deg_per_k: f64,
    /// Rise of the warmed gas, where the readings determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rise: Option<RiseTable>,
    /// Stem and the stream behind it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stem: Option<StemTable>,
}

/// At which temperature the properties of the gas are taken.
#[derive(Deserialize, Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum PropertyTemperature {
    /// That of the gas.
    Gas,
    /// Half-way between gas and surfaces.
    Film,
}

/// `[calibration.convection.rise]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RiseTable {
    /// Gravity where the head is used, m/s².
    pub gravity_m_s2: f64,
    /// Direction that points up.
    #[serde(deserialize_with = "exactly")]
    pub up: [f64; 3],
    /// Rise in quiescent gas, over √(g β ΔT d).
    pub at_rest: f64,
    /// Rate at which a wind carries it away.
    pub decay: f64,
}

/// `[calibration.convection.stem]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct StemTable {
    /// From the head along the stem.
    #[serde(deserialize_with = "exactly")]
    pub axis: [f64; 3],
    /// Winds from within this angle are flagged `near-stem`, °.
    pub unknown_deg: f64,
    /// Share of the speed behind it, at chords from 0 in steps of 0.1.
    #[serde(deserialize_with = "exactly")]
    pub factor: [f64; STEM_KNOTS],
    /// Turn away from it.
    #[serde(deserialize_with = "exactly")]
    pub deflection: [f64; STEM_KNOTS],
}

/// `[calibration.uncertainty]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct UncertaintyTable {
    /// Misfit of a conductance, as its share, at Reynolds numbers in geometric progression over the
    /// calibration's.
    #[serde(deserialize_with = "exactly")]
    pub conductance_share: [f64; KNOTS],
    /// Standard uncertainty of the speed, as its share.
    #[serde(deserialize_with = "exactly")]
    pub speed_share: [f64; KNOTS],
    /// Standard uncertainty of the direction about one axis across it, °.
    #[serde(deserialize_with = "exactly")]
    pub direction_deg: [f64; KNOTS],
    /// Greatest χ² that the calibration explains.
    pub chi_square_most: f64,
}

/// `[calibration.card]`: the curves of a card, as dr-core's `CardConfig` has them.
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CardTable {
    /// Least Reynolds number of the winds.
    pub least_reynolds: f64,
    /// Greatest Reynolds number of the winds.
    pub most_reynolds: f64,
    /// At values of √Re evenly from zero to that of the greatest Reynolds number.
    #[serde(deserialize_with = "exactly")]
    pub mean: [f64; CARD_KNOTS],
    /// D, at the same values.
    #[serde(deserialize_with = "exactly")]
    pub difference: [f64; CARD_KNOTS],
    /// Coefficients of cos nθ in P.
    #[serde(deserialize_with = "exactly")]
    pub along: [f64; TERMS],
    /// Coefficients of sin nθ in Q.
    #[serde(deserialize_with = "exactly")]
    pub around: [f64; TERMS],
    /// Coefficients of cos nθ in E.
    #[serde(deserialize_with = "exactly")]
    pub seen: [f64; TERMS],
    /// Standard error of M, as a share of what the wind adds to it.
    pub mean_share: f64,
    /// Standard error of D, as a share of its size.
    pub difference_share: f64,
}

/// `[[calibration.surfaces]]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SurfaceTable {
    /// Name of its element.
    pub element: String,
    /// Outward, in the tunnel's frame.
    #[serde(deserialize_with = "exactly")]
    pub axis: [f64; 3],
    /// Towards a corner.
    #[serde(deserialize_with = "exactly")]
    pub corner: [f64; 3],
    /// Area, m².
    pub area_m2: f64,
    /// Means of the Legendre polynomials over the surface, from the first order on.
    #[serde(deserialize_with = "exactly")]
    pub means: [f64; 5],
    /// Their threefold parts, from the third order on.
    #[serde(deserialize_with = "exactly")]
    pub threefold: [f64; 3],
    /// Factor of its convective loss.
    pub gain: f64,
    /// Conductance in quiescent gas at the reference, W/K.
    pub quiescent_w_k: f64,
}

impl NusseltTable {
    /// Configuration of the board.
    pub fn config(&self) -> NusseltConfig {
        NusseltConfig {
            least_reynolds: self.least_reynolds as f32,
            most_reynolds: self.most_reynolds as f32,
            amplitudes: self.amplitudes.map(|row| row.map(|a| a as f32)),
        }
    }
}

impl PropertyTemperature {
    /// Share of the way from the gas to the surfaces.
    pub fn film_share(self) -> f64 {
        match self {
            Self::Gas => 0.0,
            Self::Film => 0.5,
        }
    }
}

impl ConvectionModelTable {
    /// Configuration of the board.
    pub fn config(&self) -> ConvectionConfig {
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        ConvectionConfig {
            film_share: self.properties.film_share() as f32,
            nusselt_at_rest: self.nusselt_at_rest as f32,
            slowest_reynolds: self.slowest_reynolds as f32,
            gas_c: self.gas_c.map(|celsius| celsius as f32),
            speed_share_per_k: self.speed_share_per_k as f32,
            direction_rad_per_k: self.direction_deg_per_k.to_radians() as f32,
            rise: self.rise.as_ref().map(|of| RiseConfig {
                gravity_m_s2: of.gravity_m_s2 as f32,
                up: narrow(of.up),
                at_rest: of.at_rest as f32,
                decay: of.decay as f32,
            }),
            stem: self.stem.as_ref().map(|of| StemConfig {
                axis: narrow(of.axis),
                unknown_chord: (2.0 * libm::sin(0.5 * of.unknown_deg.to_radians())) as f32,
                factor: of.factor.map(|x| x as f32),
                deflection: of.deflection.map(|x| x as f32),
            }),
        }
    }
}

impl UncertaintyTable {
    /// Configuration of the board.
    pub fn config(&self) -> CalibrationUncertainty {
        CalibrationUncertainty {
            conductance_share: self.conductance_share.map(|share| share as f32),
            speed_share: self.speed_share.map(|share| share as f32),
            direction_rad: self.direction_deg.map(|degrees| degrees.to_radians() as f32),
            chi_square_most: self.chi_square_most as f32,
        }
    }
}

impl CardTable {
    /// Configuration of the board.
    pub fn config(&self) -> CardConfig {
        CardConfig {
            mean: self.mean.map(|x| x as f32),
            difference: self.difference.map(|x| x as f32),
            along: self.along.map(|x| x as f32),
            around: self.around.map(|x| x as f32),
            seen: self.seen.map(|x| x as f32),
            mean_share: self.mean_share as f32,
            difference_share: self.difference_share as f32,
        }
    }
}

impl SurfaceTable {
    /// With a geometry as the board takes it.
    pub fn new(element: String, surface: SurfaceConfig, gain: f64, quiescent_w_k: f64) -> Self {
        Self {
            element,
            axis: surface.axis.map(f64::from),
            corner: surface.corner.map(f64::from),
            area_m2: surface.area_m2.into(),
            means: surface.means.map(f64::from),
            threefold: surface.threefold.map(f64::from),
            gain,
            quiescent_w_k,
        }
    }

    /// Its geometry as the board takes it.
    pub fn surface(&self) -> SurfaceConfig {
        SurfaceConfig {
            axis: self.axis.map(|x| x as f32),
            corner: self.corner.map(|x| x as f32),
            area_m2: self.area_m2 as f32,
            means: self.means.map(|x| x as f32),
            threefold: self.threefold.map(|x| x as f32),
        }
    }
}

/// `[calibration.conditions]`: least and greatest of the calibration's winds.
#[derive(Deserialize, Serialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CalibrationConditions {
    /// Temperature of the gas, °C.
    #[serde(deserialize_with = "exactly")]
    pub gas_c: [f64; 2],
    /// Pressure of the gas, Pa.
    #[serde(deserialize_with = "exactly")]
    pub pressure_pa: [f64; 2],
    /// Temperature of the surfaces, °C.
    #[serde(deserialize_with = "exactly")]
    pub surface_c: [f64; 2],
}

impl CalibrationConditions {
    /// Ranges that winds had, each with a gas temperature in °C, a pressure in Pa, and surface
    /// temperatures in °C; none without a wind.
    pub fn of(winds: impl Iterator<Item = (f64, f64, Vec<f64>)>) -> Option<Self> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let mut all = Self { gas_c: none, pressure_pa: none, surface_c: none };
        let widen = |range: &mut [f64; 2], value: f64| *range = [range[0].min(value), range[1].max(value)];
        for (gas_c, pressure_pa, surface_c) in winds {
            widen(&mut all.gas_c, gas_c);
            widen(&mut all.pressure_pa, pressure_pa);
            surface_c.into_iter().for_each(|of| widen(&mut all.surface_c, of));
        }
        // Six digits are more than any of them has.
        let tidy = |range: [f64; 2]| range.map(tidy);
        let all = Self { gas_c: tidy(all.gas_c), pressure_pa: tidy(all.pressure_pa), surface_c: tidy(all.surface_c) };
        [all.gas_c, all.pressure_pa, all.surface_c].iter().flatten().all(|of| of.is_finite()).then_some(all)
    }

    /// The key of a range that cannot be, if there is one.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let ranges = [("gas_c", self.gas_c), ("pressure_pa", self.pressure_pa), ("surface_c", self.surface_c)];
        ranges.into_iter().find(|(_, [least, most])| !(least <= most && most.is_finite())).map(|(key, _)| key)
    }
}

/// `[calibration.correction]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CorrectionTable {
    /// Errors that were sought, and the recordings, in words.
    pub made_from: String,
    /// Day of the last of them, as 2026-03-01, if it states one.
    pub made_on: Option<String>,
    /// Corrections of every surface, in the order of the calibration's.
    pub surfaces: Vec<SurfaceCorrectionTable>,
}

/// `[[calibration.correction.surfaces]]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SurfaceCorrectionTable {
    /// Name of its element.
    pub element: String,
    /// Heat that it takes up beside the wind, W.
    pub offset_w: f64,
    /// Standard uncertainty, W.
    pub offset_u_w: f64,
    /// Change of its gain since the calibration, as a share.
    pub gain_change: f64,
    /// Standard uncertainty.
    pub gain_change_u: f64,
}

impl SurfaceCorrectionTable {
    /// Table of a correction as the board takes it: what multiplies a conductance takes back what
    /// its gain has changed by.
    pub fn new(element: String, of: &SurfaceCorrection) -> Self {
        let factor = 1.0 + f64::from(of.gain);
        Self {
            element,
            offset_w: of.offset_w.into(),
            offset_u_w: of.offset_u_w.into(),
            gain_change: 1.0 / factor - 1.0,
            gain_change_u: f64::from(of.gain_u) / factor.powi(2),
        }
    }

    /// Configuration of the board.
    pub fn config(&self) -> SurfaceCorrection {
        let remains = 1.0 + self.gain_change;
        SurfaceCorrection {
            offset_w: self.offset_w as f32,
            gain: (1.0 / remains - 1.0) as f32,
            offset_u_w: self.offset_u_w as f32,
            gain_u: (self.gain_change_u / remains.powi(2)) as f32,
        }
    }
}

impl CorrectionTable {
    /// Configuration of the board; none of a table that was not checked.
    pub fn config(&self) -> Option<[SurfaceCorrection; SECTORS]> {
        let [a, b, c, d] = &self.surfaces[..] else { return None };
        Some([a, b, c, d].map(SurfaceCorrectionTable::config))
    }

    /// That they are applied, in a sentence.
    pub fn sentence(&self) -> String {
        let day = self.made_on.as_ref().map_or_else(String::new, |day| format!(" of {day}"));
        format!("corrections{day} are applied, by {}", self.made_from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_upside_down_is_a_fault_with_its_key() {
        let good = CalibrationConditions { gas_c: [1.0, 2.0], pressure_pa: [1e5, 1e5], surface_c: [50.0, 51.0] };
        assert_eq!(good.fault(), None);
        assert_eq!(CalibrationConditions { pressure_pa: [2.0, 1.0], ..good }.fault(), Some("pressure_pa"));
        assert_eq!(CalibrationConditions { surface_c: [f64::NAN, 1.0], ..good }.fault(), Some("surface_c"));
        assert_eq!(CalibrationConditions::of(std::iter::empty()), None);
    }
}
