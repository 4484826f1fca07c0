//! Result of a calibration, as text and as dr-core's configurations.
//!
//! Standard uncertainties are by the noise of the readings and by the misfit of the model
//! ([`fit`](super::fit)).

use std::fmt;

use dr_core::ConfigError;
use dr_core::wind::free_stream::STEM_KNOTS;
use dr_core::wind::nusselt::POINTS;
use dr_core::wind::{ConvectionSettings, HeadForm, MeasuredConductance, SurfaceConfig, WindVector};
use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3};
use recording::text::{count, estimate, short};
use serde::Serialize;

use super::super::drawn::DrawnOptions;
use super::super::steady_wind::{SurfaceReading, WorstReading};
use super::equations::{QUIESCENT, SurfaceEquations, SurfaceProblem};
use super::family::AmplitudeShape;
use super::fit::{ADVICE, CalibrationGrade, FittedKing, SurfaceFit};
use super::readings::chord;
use super::sought::SoughtConvection;

use crate::gas::ZERO_CELSIUS_K;
use crate::head::calibration::table::{ConvectionModelTable, NusseltTable, PropertyTemperature, RiseTable, StemTable};
use crate::vector::length;

/// Nusselt numbers beyond so many times published ones are those of wrong units.
const UNLIKELY: f64 = 5.0;
/// Amount that a gas one kelvin beyond those of the calibration adds to the uncertainty of the
/// speed, as its share, and of the direction, °: of calibrations in gas of one temperature, and of
/// several (`studies benchmark field`).
const AWAY_OF_ONE: (f64, f64) = (1.6e-3, 0.016);
const AWAY_OF_TWO: (f64, f64) = (1.5e-4, 0.008);
/// Distance of two readings of quiescent gas for these, K.
const AWAY_OF_TWO_K: f64 = 30.0;
/// Share of the winds, from either end of their gas temperatures, that say nothing of a gas.
const FEW_WINDS: f64 = 0.05;
/// Component out of a plane, rms, from which on winds are not of it.
const LEAST_OUT: f64 = 0.08;
/// Winds are unknown nearer to the stem than the nearest one by so much, °; and no farther than
/// a stem reaches.
const NEAREST_DEG: f64 = 1.0;
const MOST_UNKNOWN_DEG: f64 = 35.0;
/// Readings that leave a greater part of what is known of G0 before any of them have not fitted it.
const FITTED: f64 = 0.5;

/// A calibrated head.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceCalibration {
    /// Form that the surfaces belong to.
    pub form: HeadForm,
    /// Diameter, m.
    pub diameter_m: f64,
    /// The amplitudes, as a head file has them.
    pub curves: NusseltTable,
    /// One a surface, in the order of the head.
    pub surfaces: Vec<CalibratedSurface>,
    /// R from the tunnel's frame into the head's: axis times angle, rad.
    pub rotation_rad: [f64; 3],
    /// Standard errors of small turns about the head's axes, rad; of two hemispheres nothing about
    /// their own.
    pub rotation_error_rad: [f64; 3],
    /// Size of (q − q̂) over the convective power, rms.
    pub residual_rms: f64,
    /// χ² of the fit.
    pub chi_square: f64,
    /// Readings less what of the unknowns they determine.
    pub degrees_of_freedom: f64,
    /// Size of the stated standard uncertainties of the readings over the convective power, rms.
    pub reading_rms: f64,
    /// Misfit of the model over the convective power, rms: what residuals are beyond the
    /// uncertainty of the readings.
    pub misfit_rms: f64,
    /// The reading that the fit leaves farthest off.
    pub worst: WorstReading,
    /// Winds that were used, and how many of them were quiescent gas. Without quiescent gas G0
    /// rests on k A / d and its 30 %.
    pub winds: usize,
    /// Number of these, readings of quiescent gas.
    pub quiescent: usize,
    /// Coefficients of an amplitude, as many as the speeds allowed; none by King's law.
    pub coefficients: Option<usize>,
    /// King's law, if the amplitudes follow it.
    pub king: Option<FittedKing>,
    /// Orders of the amplitudes.
    pub orders: Vec<usize>,
    /// Σ of squares, of the readings and of what was known before.
    pub cost: f64,
    /// Convection of a sphere.
    pub convection: Option<ConvectionModelTable>,
    /// Standard uncertainties of a and b of the rise, where it is sought.
    pub rise_errors: Option<[f64; 2]>,
    /// Unknowns that were sought.
    pub sought: SoughtConvection,
    /// All winds are of one plane, though the head determines more.
    pub is_of_plane: bool,
}

/// A surface of a calibrated head.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CalibratedSurface {
    /// Name of its element.
    #[serde(skip)]
    pub name: String,
    /// Outward, in the tunnel's frame.
    #[serde(skip)]
    pub axis: [f64; 3],
    /// Configuration of the board, in the tunnel's frame.
    #[serde(skip)]
    pub config: SurfaceConfig,
    /// c, of mean one.
    pub gain: f64,
    /// Standard uncertainty of c.
    #[serde(rename = "se_gain")]
    pub gain_error: f64,
    /// G0, W/K.
    pub quiescent_w_k: f64,
    /// Standard uncertainty of G0, W/K.
    #[serde(rename = "se_quiescent_w_k")]
    pub quiescent_error_w_k: f64,
    /// The readings determine G0; else it is k̄ A / d times the Nusselt number at rest, taken with
    /// its 30 %.
    #[serde(skip)]
    pub is_quiescent_fitted: bool,
}

impl SurfaceCalibration {
    pub(super) fn of(problem: &SurfaceProblem<'_>, fitted: &SurfaceFit, king: Option<FittedKing>) -> Self {
        let head = problem.head.drawn;
        let SurfaceFit { place, equations, covariance, degrees_of_freedom } = fitted;
        let family = &problem.family;
        let points = points(family.least_reynolds, family.most_reynolds);
        let amplitudes = points.map(|reynolds| family.amplitudes(&family.at(reynolds), &place.coefficients));
        let errors = |first: usize, basis: &DMatrix<f64>| -> Vec<f64> {
            let size = basis.ncols();
            let own = covariance.view((first, first), (size, size));
            (basis * own * basis.transpose()).diagonal().iter().map(|v| v.sqrt()).collect()
        };
        let gain_errors = errors(problem.first_gain(), &problem.spread);
        let n = place.gains.len();
        let quiescent_errors = errors(problem.first_quiescent(), &DMatrix::identity(n, n));
        let turn_errors = errors(problem.first_turn(), &place.mounting.turns);
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        let surface = |i: usize| {
            let drawn = head.surfaces[i].config;
            let axis = place.mounting.outward(drawn.axis);
            let corner = narrow(place.mounting.outward(drawn.corner));
            CalibratedSurface {
                name: head.surfaces[i].name.clone(),
                axis,
                config: SurfaceConfig { axis: narrow(axis), corner, ..drawn },
                gain: place.gains[i],
                gain_error: gain_errors[i],
                quiescent_w_k: place.quiescent[i] * problem.quiescent_unit_w_k[i],
                // The Nusselt number at rest of other forms is no better known than G0 itself.
                is_quiescent_fitted: head.form.is_sphere() && quiescent_errors[i] < FITTED * QUIESCENT * family.at_rest,
                quiescent_error_w_k: problem.quiescent_unit_w_k[i]
                    * match head.form {
                        HeadForm::Sphere | HeadForm::Cube => quiescent_errors[i],
                        // Only the law says what of it is conduction into the gas.
                        _ => libm::hypot(quiescent_errors[i], QUIESCENT * family.at_rest),
                    },
            }
        };
        let readings = equations.residuals.len() as f64;
        let mean_square = equations.relative_square / readings;
        let reading_square = equations.relative_errors.iter().map(|error| error * error).sum::<f64>() / readings;
        // Residuals are smaller than errors by what the unknowns take of them.
        let scatter_square = mean_square * readings / degrees_of_freedom.max(1.0);
        let misfit_rms = (scatter_square - reading_square).max(0.0).sqrt();
        Self {
            form: head.form,
            diameter_m: head.diameter_m,
            curves: NusseltTable {
                least_reynolds: family.least_reynolds,
                most_reynolds: family.most_reynolds,
                amplitudes,
            },
            surfaces: (0..n).map(surface).collect(),
            rotation_rad: place.mounting.vector(),
            rotation_error_rad: [turn_errors[0], turn_errors[1], turn_errors[2]],
            residual_rms: mean_square.sqrt(),
            chi_square: equations.chi_square,
            degrees_of_freedom: *degrees_of_freedom,
            reading_rms: reading_square.sqrt(),
            misfit_rms,
            worst: worst(problem, equations, misfit_rms),
            winds: problem.winds.len(),
            quiescent: problem.winds.iter().filter(|wind| wind.is_quiescent()).count(),
            coefficients: match &family.shape {
                AmplitudeShape::Spline(spline) => Some(spline.count()),
                AmplitudeShape::Law | AmplitudeShape::King { .. } => None,
            },
            king,
            orders: family.orders.clone(),
            cost: equations.cost,
            convection: convection(problem, fitted),
            rise_errors: (head.convection.of_rise() > 0).then(|| {
                let first = problem.first_of_stream(place);
                [first, first + 1].map(|k| covariance[(k, k)].sqrt())
            }),
            sought: head.convection.clone(),
            is_of_plane: problem.head.is_complete() && is_of_plane(problem),
        }
    }

    /// The head as dr-core inverts it, with how its convection is taken.
    pub(super) fn of_board(&self, direction_error_max_rad: f32) -> Result<BoardHead, ConfigError> {
        let surfaces: Vec<SurfaceConfig> = self.surfaces.iter().map(|of| of.config).collect();
        let diameter_m = self.diameter_m as f32;
        let mut vector =
            WindVector::new(self.form, &self.curves.config(), &surfaces, diameter_m, direction_error_max_rad)?;
        let Some(convection) = &self.convection else { return Ok(BoardHead { vector, convection: None }) };
        let convection = ConvectionSettings::new(&convection.config())?;
        vector.rest_at(convection.nusselt_at_rest)?;
        Ok(BoardHead { vector, convection: Some(convection) })
    }

    /// Share of the way from the gas to the surfaces at which properties are taken.
    pub fn film_share(&self) -> f64 {
        self.convection.as_ref().map_or(0.0, |of| of.properties.film_share())
    }

    /// Reynolds numbers of the slowest and the fastest wind.
    pub fn reynolds(&self) -> [f64; 2] {
        let least = self.convection.as_ref().map_or(self.curves.least_reynolds, |of| of.slowest_reynolds);
        [least, self.curves.most_reynolds]
    }

    /// Grade of the calibration.
    pub fn grade(&self) -> CalibrationGrade {
        CalibrationGrade::of(self.misfit_rms)
    }

    /// Warnings, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        if self.grade() == CalibrationGrade::Poor {
            let (percent, worst) = (100.0 * self.misfit_rms, &self.worst);
            sentences.push(format!(
                "the calibration is poor: the model misses the convective power by {percent:.1} % rms, most in {} at {}; {ADVICE}",
                worst.label, worst.surface
            ));
        }
        if self.sought.is_without_quiescent {
            sentences.push(
                "quiescent gas contradicts the winds, and was left out: was it quiescent, and does warm gas rise that --gravity leaves out?"
                    .to_owned(),
            );
        }
        if self.is_of_plane {
            sentences.push(
                "all winds are of one plane: winds out of it, which this head sees, are extrapolated, and may be 10 % wrong without a flag"
                    .to_owned(),
            );
        }
        let likely = self.over_published();
        if !(1.0 / UNLIKELY..=UNLIKELY).contains(&likely) {
            let [times, least, most] =
                [likely, self.curves.least_reynolds, self.curves.most_reynolds].map(|number| short(number, 2));
            sentences.push(format!(
                "the Nusselt numbers are {times} times those of such bodies at Re {least} to {most}: is the pressure in pascals, the speed \
                 in m/s, the power in watts, and are diameter and area those of the body?"
            ));
        }
        sentences
    }

    /// Amount that a stream adds to the mean Nusselt number over 0.6 Re^½, about that of published
    /// spheres, cylinders and wires; geometric mean over the range of speeds.
    fn over_published(&self) -> f64 {
        let at_rest = f64::from(self.form.nusselt_at_rest());
        let points = points(self.curves.least_reynolds, self.curves.most_reynolds);
        let over = self.curves.amplitudes.iter().zip(points).map(|(amplitudes, reynolds)| {
            libm::log((amplitudes[0] - at_rest).max(f64::MIN_POSITIVE) / (0.6 * reynolds.sqrt()))
        });
        libm::exp(over.sum::<f64>() / POINTS as f64)
    }

    /// c (q + G0 a) / θ of a reading of surface `i`, as
    /// [`WindVector::step`](dr_core::wind::WindVector::step) takes it.
    pub fn measured(&self, i: usize, reading: &SurfaceReading) -> MeasuredConductance {
        let surface = &self.surfaces[i];
        let per_watt = surface.gain / reading.overheat_k;
        let conductance = per_watt * (reading.power_w + surface.quiescent_w_k * reading.above_reference_k);
        MeasuredConductance {
            conductance_w_k: conductance as f32,
            variance_w2_k2: (per_watt * per_watt * reading.variance_w2) as f32,
        }
    }
}

impl fmt::Display for SurfaceCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.reynolds();
        let winds = count(self.winds, "wind");
        write!(f, "{winds} ({} of quiescent gas), Re {least:.1} to {most:.1}, ", self.quiescent)?;
        if let Some(coefficients) = self.coefficients {
            writeln!(f, "{coefficients} coefficients an amplitude")?;
        }
        if let Some(king) = &self.king {
            write!(f, "King's law with exponent {}", estimate(king.exponent, king.se_exponent))?;
            if let (Some(yaw), Some(se_yaw)) = (king.yaw_factor, king.se_yaw_factor) {
                write!(f, ", yaw factor {}", estimate(yaw, se_yaw))?;
            }
            writeln!(f)?;
        }
        let [residual, reading, misfit] = [self.residual_rms, self.reading_rms, self.misfit_rms].map(|rms| 100.0 * rms);
        let WorstReading { label, surface, errors } = &self.worst;
        writeln!(
            f,
            "residuals {residual:.3} % rms of the convective power; worst {label} {surface} with {errors:+.1} σ"
        )?;
        let (square, freedom) = (self.chi_square, self.degrees_of_freedom);
        write!(f, "readings known to {reading:.3} %, misfit of the model {misfit:.3} %; ")?;
        writeln!(f, "χ² {square:.0} for {freedom:.0} degrees of freedom by the readings alone")?;
        let advice = if self.grade() == CalibrationGrade::Poor { format!(": {ADVICE}") } else { String::new() };
        let [grade, meaning] = self.grade().words();
        writeln!(f, "{grade}: {meaning}{advice}")?;
        if self.form != HeadForm::Single {
            self.write_mounting(f)?;
        }
        self.write_convection(f)?;
        writeln!(f, "{:<12} {:>23} {:>23}", "surface", "gain", "G0 mW/K")?;
        for surface in &self.surfaces {
            let gain = estimate(surface.gain, surface.gain_error);
            writeln!(f, "{:<12} {gain:>23} {:>23}", surface.name, surface.quiescent())?;
        }
        if self.surfaces.iter().any(|surface| !surface.is_quiescent_fitted) {
            let percent = 100.0 * QUIESCENT;
            writeln!(f, "G0 taken: no reading fits it; by conductivity and area, known to {percent:.0} %")?;
        }
        Ok(())
    }
}

impl SurfaceCalibration {
    fn write_convection(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(of) = &self.convection else { return Ok(()) };
        let at = match of.properties {
            PropertyTemperature::Film => "film temperature",
            PropertyTemperature::Gas => "the temperature of the gas",
        };
        writeln!(f, "properties of the gas at {at}, Nu at rest {}", short(of.nusselt_at_rest, 3))?;
        if let (Some(rise), Some([a, b])) = (&of.rise, self.rise_errors) {
            let (a, b) = (estimate(rise.at_rest, a), estimate(rise.decay, b));
            writeln!(f, "rise of the warmed gas: a {a}, b {b}, at {} m/s²", rise.gravity_m_s2)?;
        }
        if let Some(stem) = of.stem.as_ref().filter(|stem| stem.factor.iter().any(|factor| *factor != 1.0)) {
            let least = stem.factor.iter().copied().fold(f64::INFINITY, f64::min);
            writeln!(f, "behind the stem: down to {:.0} % of the speed", 100.0 * least)?;
        }
        Ok(())
    }

    fn write_mounting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (turns, errors) = (self.rotation_rad.map(f64::to_degrees), self.rotation_error_rad.map(f64::to_degrees));
        let [x, y, z] = [0, 1, 2].map(|k| estimate(turns[k], errors[k]));
        writeln!(f, "mounting turned by {:.2}°: ({x}, {y}, {z})°", length(self.rotation_rad).to_degrees())
    }
}

impl CalibratedSurface {
    /// G0 in mW/K, with its standard uncertainty if it was fitted.
    fn quiescent(&self) -> String {
        match self.is_quiescent_fitted {
            true => estimate(1e3 * self.quiescent_w_k, 1e3 * self.quiescent_error_w_k),
            false => format!("taken {}", short(1e3 * self.quiescent_w_k, 2)),
        }
    }
}

/// A calibrated head as the board has it.
pub(super) struct BoardHead {
    pub vector: WindVector,
    pub convection: Option<ConvectionSettings>,
}

/// Tells whether no wind leaves some plane by more than a few degrees.
fn is_of_plane(problem: &SurfaceProblem<'_>) -> bool {
    let towards = problem.winds.iter().filter(|wind| !wind.is_quiescent()).map(|wind| Vector3::from(wind.towards));
    let count = towards.clone().count().max(1) as f64;
    let spread: Matrix3<f64> = towards.map(|t| t * t.transpose()).sum();
    SymmetricEigen::new(spread / count).eigenvalues.min() < LEAST_OUT.powi(2)
}

/// Convection, if otherwise than by the gas in the wind itself.
fn convection(problem: &SurfaceProblem<'_>, fitted: &SurfaceFit) -> Option<ConvectionModelTable> {
    let (sought, place) = (&problem.head.drawn.convection, &fitted.place);
    let is_sphere = problem.head.form().is_sphere();
    if !is_sphere && sought.film_share == 0.0 {
        return None;
    }
    let moving = || problem.winds.iter().filter(|wind| !wind.is_quiescent());
    let slowest_reynolds = moving().map(|wind| wind.reynolds).fold(f64::INFINITY, f64::min);
    let rise = sought.rise.map(|gravity| RiseTable {
        gravity_m_s2: gravity.m_s2,
        up: gravity.up,
        at_rest: place.stream[0].max(0.0),
        decay: place.stream[1].max(0.0),
    });
    let stem = (is_sphere && problem.head.is_complete()).then(|| {
        let axis = sought.stem.unwrap_or(DrawnOptions::default().stem);
        let (factor, deflection) = match sought.stem {
            Some(_) => sought.stem_map(&place.stream),
            None => ([1.0; STEM_KNOTS], [0.0; STEM_KNOTS]),
        };
        // The nearest wind, less what a direction is off.
        let nearest = moving().map(|wind| chord(wind.towards, axis)).fold(2.0, f64::min);
        let nearest_deg = 2.0 * libm::asin((0.5 * nearest).min(1.0)).to_degrees() - NEAREST_DEG;
        StemTable { axis, unknown_deg: nearest_deg.clamp(0.0, MOST_UNKNOWN_DEG), factor, deflection }
    });
    let properties = if sought.film_share > 0.0 { PropertyTemperature::Film } else { PropertyTemperature::Gas };
    let nusselt_at_rest = problem.family.rest(&place.coefficients);
    // A few winds in another gas do not say how it differs.
    let mut gas_c: Vec<f64> = moving().map(|wind| wind.gas_k - ZERO_CELSIUS_K).collect();
    gas_c.sort_by(f64::total_cmp);
    let few = (FEW_WINDS * gas_c.len() as f64) as usize;
    let gas_c = [*gas_c.get(few)?, *gas_c.get(gas_c.len() - 1 - few)?];
    // A farther temperature would say this better.
    let farther = AWAY_OF_TWO_K / problem.quiescent_range_k().max(1.0);
    let per_k = |of_two: f64, of_one: f64| {
        if sought.is_rest_sought { (of_two * farther).clamp(of_two, of_one) } else { of_one }
    };
    let speed_share_per_k = per_k(AWAY_OF_TWO.0, AWAY_OF_ONE.0);
    let direction_deg_per_k = per_k(AWAY_OF_TWO.1, AWAY_OF_ONE.1);
    Some(ConvectionModelTable {
        properties,
        nusselt_at_rest,
        slowest_reynolds,
        gas_c,
        speed_share_per_k,
        direction_deg_per_k,
        rise,
        stem,
    })
}

/// Reynolds numbers at which the board has amplitudes: even in their logarithm.
fn points(least_reynolds: f64, most_reynolds: f64) -> [f64; POINTS] {
    let ratio = libm::log(most_reynolds / least_reynolds) / (POINTS - 1) as f64;
    std::array::from_fn(|j| least_reynolds * libm::exp(ratio * j as f64))
}

/// The reading farthest off, in standard uncertainties of reading and misfit together.
fn worst(problem: &SurfaceProblem<'_>, equations: &SurfaceEquations, misfit_rms: f64) -> WorstReading {
    let n = problem.head.surfaces.len();
    let off = |(residual, error): (&f64, &f64)| residual / libm::hypot(1.0, misfit_rms / error);
    let all = equations.residuals.iter().zip(&equations.relative_errors).map(off).enumerate();
    let (at, errors) = all.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0));
    WorstReading {
        label: problem.winds[at / n].label.clone(),
        surface: problem.head.drawn.surfaces[at % n].name.clone(),
        errors,
    }
}
