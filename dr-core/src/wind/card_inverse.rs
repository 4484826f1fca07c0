//! The wind in the plane of a card, from the conductances of its four heated dice.
//!
//! ```text
//! Nu_i = G_i / (k a) = M + p_i D_p + q_i D_q
//! M    = mean(√(Re E(θ)))      (D_p, D_q) = −difference(√Re) (P(θ), Q(θ))      Re = |v| ρ a / µ
//! P    = Σ along_n cos nθ      Q = Σ around_n sin (n+1)θ      E = Σ seen_n cos nθ      n = 0 … 7
//! p_i, q_i = ±1, the die's place towards the tip and around the boom
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | a | side of a die, m |
//! | θ | angle of the wind, where the gas goes to, from the tip towards *around*: 0 in reverse, π head-on |
//! | M | mean of the four: rises with the speed that the card sees |
//! | D | differences: dice upstream lose more than those downstream |
//! | E | share of the speed that the card sees: less in reverse and across than head-on |
//! | P, Q | how the differences depend on the angle: the card's own anisotropy |
//!
//! All curves come from a calibration: `mean` and `difference` at `KNOTS` values of √Re evenly from
//! zero, straight between them, since a laminar layer goes as √Re. P and Q make a closed curve
//! around the origin; in which sector of it the measured differences lie says the angle, and their
//! size a speed. The mean says a speed as well. The two are weighted by their variances, to which
//! belongs what each does wrong by itself (`mean_share`, `difference_share`): the mean is slow,
//! because the card that holds the dice is cooled too and takes minutes for it, while differences
//! forget the card, but are a tenth of the mean.
//!
//! | dice | result |
//! |---|---|
//! | four | speed and angle; the fourth number, and the two speeds, check them (`chi_square`) |
//! | three | speed and angle, wider: three numbers for M, D_p, D_q |
//! | two | none |
//!
//! *Limits.* Mirror-symmetric about the boom. The wind across the plane is not determined; it
//! appears as an error of the speed. Above the calibration the last slopes go on.

use super::estimate::WindEstimate;
use super::gas::GasState;
use super::normal::{Factors, Matrix, plus_outer, quadratic};
use super::quality_flags::QualityFlags;
use super::surface::SurfaceConfig;
use super::surface_inverse::{MeasuredConductance, nusselt_number};
use crate::arithmetic::{cross, dot, length, plus, scaled, sqrt};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};
use core::f32::consts::PI;

/// Dice of a card.
pub const DICE: usize = 4;
/// Values of √Re at which the curves are given.
pub const KNOTS: usize = 12;
/// Harmonics of P, Q and E.
pub const TERMS: usize = 8;
/// Directions in which P, Q and E are kept.
const RAYS: usize = 36;
/// Nusselt number of a square on an adiabatic plane in quiescent gas: 4/√π.
pub const CONDUCTION: f32 = 2.256_758_3;

/// The curves as they travel and are stored.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CardConfig {
    /// M at √Re from zero to that of the greatest Reynolds number.
    pub mean: [f32; KNOTS],
    /// Size of the differences there.
    pub difference: [f32; KNOTS],
    /// Coefficients of cos nθ in P.
    pub along: [f32; TERMS],
    /// Coefficients of sin (n+1)θ in Q.
    pub around: [f32; TERMS],
    /// Coefficients of cos nθ in E.
    pub seen: [f32; TERMS],
    /// Standard error of the curve M, as a share of what the wind adds to it.
    pub mean_share: f32,
    /// Standard error of the curves D, as a share of their size.
    pub difference_share: f32,
}

/// A curve, straight between its knots and beyond them.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
struct CardCurve {
    value: [f32; KNOTS],
    /// Knots per unit of √Re.
    per_root: f32,
}

impl CardCurve {
    fn new(parameter: Parameter, value: &[f32; KNOTS], per_root: f32) -> Result<Self, ConfigError> {
        for pair in value.windows(2) {
            error::ascending((parameter, pair[0]), (parameter, pair[1]))?;
        }
        Ok(Self { value: *value, per_root })
    }

    /// Value at √Re.
    fn at(&self, root: f32) -> f32 {
        let position = root * self.per_root;
        // Below the first knot a conversion gives zero.
        let knot = (position as usize).min(KNOTS - 2);
        let (low, high) = (self.value[knot], self.value[knot + 1]);
        low + (position - knot as f32) * (high - low)
    }

    /// √Re of a value, negative below the first one; and its derivative.
    fn inverse(&self, value: f32) -> (f32, f32) {
        let knot = self.value[1..KNOTS - 1].iter().take_while(|&&knot| knot <= value).count();
        let (low, high) = (self.value[knot], self.value[knot + 1]);
        let derivative = 1.0 / ((high - low) * self.per_root);
        (knot as f32 / self.per_root + (value - low) * derivative, derivative)
    }
}

/// P, Q and √E in a direction.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
struct Ray {
    towards: [f32; 2],
    differences: [f32; 2],
    root_seen: f32,
}

/// Direction: between two rays.
struct Direction {
    /// Direction of length one.
    towards: [f32; 2],
    /// Size of (P, Q).
    size: f32,
    root_seen: f32,
    /// Derivatives to the angle of (P, Q): of the angle of the wind, of ln of the size, of ln √E.
    per_angle: f32,
    size_per_angle: f32,
    seen_per_angle: f32,
}

/// The inverse for the four dice of a card. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct Card {
    mean: CardCurve,
    difference: CardCurve,
    rays: [Ray; RAYS],
    /// Mean of the greatest and the least √E, and half of what they are apart over it.
    usual_seen: (f32, f32),
    /// Towards the tip, and around the boom.
    basis: [[f32; 3]; 2],
    /// p_i, q_i.
    places: [[f32; 2]; DICE],
    side_m: f32,
    most_root: f32,
    mean_share: f32,
    difference_share: f32,
    direction_error_max_rad: f32,
}

impl Card {
    /// Dice of `side_m` in the card's order, neighbours following each other from the tip on: the
    /// axis of each is the card's outward normal, its corner points from the middle of the card to
    /// the die.
    ///
    /// # Errors
    /// Names what is wrong: curves that do not ascend, a greatest Reynolds number outside 1e-3 …
    /// 1e6, anisotropies that do not go round, dice that do not stand in a square, a side outside
    /// 0.1 mm … 1 m, or a bound outside 0 … π/2.
    pub fn new(
        config: &CardConfig,
        dice: &[SurfaceConfig; DICE],
        side_m: f32,
        most_reynolds: f32,
        direction_error_max_rad: f32,
    ) -> Result<Self, ConfigError> {
        error::positive(Parameter::DirectionErrorMaxRad, direction_error_max_rad)?;
        error::within(Parameter::DirectionErrorMaxRad, direction_error_max_rad, 0.0, core::f32::consts::FRAC_PI_2)?;
        error::within(Parameter::MostReynolds, most_reynolds, 1e-3, 1e6)?;
        error::within(Parameter::DiameterM, side_m, 1e-4, 1.0)?;
        error::within(Parameter::CardShare, config.mean_share, 0.0, 10.0)?;
        error::within(Parameter::CardShare, config.difference_share, 0.0, 10.0)?;
        error::positive(Parameter::CardMean, config.mean[0])?;
        error::within(Parameter::CardDifference, config.difference[0], 0.0, 1e4)?;
        let most_root = sqrt(most_reynolds);
        let per_root = (KNOTS - 1) as f32 / most_root;
        let rays = rays(config)?;
        let (least, most) = rays
            .iter()
            .fold((f32::MAX, 0.0_f32), |(least, most), ray| (least.min(ray.root_seen), most.max(ray.root_seen)));
        let basis = basis(dice)?;
        Ok(Self {
            mean: CardCurve::new(Parameter::CardMean, &config.mean, per_root)?,
            difference: CardCurve::new(Parameter::CardDifference, &config.difference, per_root)?,
            rays,
            usual_seen: (0.5 * (least + most), (most - least) / (most + least)),
            basis,
            places: places(dice, &basis)?,
            side_m,
            most_root,
            mean_share: config.mean_share,
            difference_share: config.difference_share,
            direction_error_max_rad,
        })
    }

    /// Towards the tip and around the boom, of length one.
    #[cfg(test)]
    pub(super) const fn basis(&self) -> [[f32; 3]; 2] {
        self.basis
    }

    /// Conductances of the dice in a wind, W/K; only its component in the plane counts.
    #[cfg(test)]
    pub(super) fn conductances_w_k(&self, gas: &GasState, wind_m_s: [f32; 3]) -> [f32; DICE] {
        let per_nusselt = self.per_nusselt_w_k(gas);
        let flat = self.basis.map(|b| dot(b, wind_m_s));
        let root = sqrt(sqrt(flat[0] * flat[0] + flat[1] * flat[1]) * gas.reynolds_per_speed(self.side_m));
        let Some((ray, next, share)) = self.between(flat, |ray| ray.towards) else {
            return [self.mean.at(0.0) * per_nusselt; DICE];
        };
        let mix = |of: fn(&Ray) -> f32| of(ray) + share * (of(next) - of(ray));
        let mean = self.mean.at(root * mix(|ray| ray.root_seen));
        let size = self.difference.at(root);
        let (p, q) = (-size * mix(|ray| ray.differences[0]), -size * mix(|ray| ray.differences[1]));
        self.places.map(|place| (mean + place[0] * p + place[1] * q) * per_nusselt)
    }

    /// The wind from what was measured; dice that were not are `None`.
    pub fn step(&self, gas: &GasState, measured: &[Option<MeasuredConductance>; DICE]) -> WindEstimate {
        let mut quality = QualityFlags::UNDETERMINED;
        let per_nusselt = self.per_nusselt_w_k(gas);
        let nusselt = measured.map(|measured| nusselt_number(measured, per_nusselt, &mut quality));
        let estimate = self.fit(&nusselt).map(|fitted| self.estimate(gas, &fitted, quality));
        estimate.filter(WindEstimate::is_finite).unwrap_or(WindEstimate::failed(quality))
    }

    fn per_nusselt_w_k(&self, gas: &GasState) -> f32 {
        gas.conductance_per_nusselt_w_k(self.side_m, self.side_m * self.side_m)
    }

    /// M, D_p and D_q by least squares.
    fn fit(&self, nusselt: &[Option<(f32, f32)>; DICE]) -> Option<FittedDice> {
        if nusselt.iter().flatten().count() < 3 {
            return None;
        }
        let least = nusselt.iter().flatten().fold(f32::MAX, |least, &(_, variance)| least.min(variance));
        let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
        for (nusselt, [p, q]) in nusselt.iter().zip(self.places) {
            let Some((nusselt, variance)) = nusselt else { continue };
            let row = [1.0, p, q];
            plus_outer(&mut normal, least / variance, row);
            right = plus(right, least / variance * nusselt, row);
        }
        let factors = Factors::of(&normal)?;
        let x = factors.solve(right);
        let mut chi_square = 0.0;
        for (nusselt, [p, q]) in nusselt.iter().zip(self.places) {
            let Some((nusselt, variance)) = nusselt else { continue };
            let left = nusselt - dot(x, [1.0, p, q]);
            chi_square += left * left / variance;
        }
        let covariance = factors.inverse().map(|row| scaled(row, least));
        let degrees_of_freedom = nusselt.iter().flatten().count() as u8 - 3;
        Some(FittedDice { mean: x[0], downstream: [-x[1], -x[2]], covariance, chi_square, degrees_of_freedom })
    }

    fn estimate(&self, gas: &GasState, fitted: &FittedDice, mut quality: QualityFlags) -> WindEstimate {
        let size = sqrt(fitted.downstream[0] * fitted.downstream[0] + fitted.downstream[1] * fitted.downstream[1]);
        let direction = self.direction(fitted.downstream);
        // Standard errors along and across the differences: of the readings, and of the curves.
        let unit = fitted.downstream.map(|d| if size > 0.0 { d / size } else { 0.0 });
        let curves = self.difference_share * size;
        let along = quadratic(&fitted.covariance, [0.0, unit[0], unit[1]]) + curves * curves;
        let across = quadratic(&fitted.covariance, [0.0, -unit[1], unit[0]]) + curves * curves;
        let angle_rad = match &direction {
            Some(direction) if size > 0.0 => (direction.per_angle * sqrt(across) / size).min(PI),
            _ => PI,
        };
        let no_direction = angle_rad > self.direction_error_max_rad;

        let of_wind = self.mean_share * (fitted.mean - self.mean.at(0.0));
        let mean_variance = fitted.covariance[0][0] + of_wind * of_wind;
        let (seen_root, per_mean) = self.mean.inverse(fitted.mean);
        let by_mean =
            |root_seen: f32| (seen_root / root_seen, mean_variance * per_mean * per_mean / (root_seen * root_seen));
        let (mut chi_square, mut degrees_of_freedom) = (fitted.chi_square, fitted.degrees_of_freedom);
        let (root, variance, with_angle) = match &direction {
            Some(direction) if !no_direction => {
                let (d, per) = self.difference.inverse(size / direction.size);
                let per = per / direction.size;
                let (m, m_variance) = by_mean(direction.root_seen);
                // An error of the angle moves both: it is taken for another anisotropy.
                let angle_variance = across / (size * size);
                let (d_slope, m_slope) = (-per * size * direction.size_per_angle, -m * direction.seen_per_angle);
                let d_variance = along * per * per + d_slope * d_slope * angle_variance;
                let m_variance = m_variance + m_slope * m_slope * angle_variance;
                let both = d_slope * m_slope * angle_variance;
                let sum = d_variance + m_variance - 2.0 * both;
                let share = (m_variance - both) / sum;
                chi_square += (d - m) * (d - m) / sum;
                degrees_of_freedom += 1;
                let slope = share * d_slope + (1.0 - share) * m_slope;
                let variance = (d_variance * m_variance - both * both) / sum;
                (m + share * (d - m), variance, slope * angle_variance * direction.per_angle)
            }
            // Without a direction it is not known how much of the speed the card sees.
            _ => {
                let (usual, spread) = self.usual_seen;
                let (root, variance) = by_mean(usual);
                (root, variance + spread * spread * root * root, 0.0)
            }
        };
        let root = root.max(0.0);
        quality = quality
            .with(QualityFlags::NO_DIRECTION, no_direction)
            .with(QualityFlags::EXTRAPOLATED, root > self.most_root);
        let speed_per_reynolds = 1.0 / gas.reynolds_per_speed(self.side_m);
        let speed_m_s = root * root * speed_per_reynolds;
        // Near zero the square has 2 x σ below σ².
        let speed_error_m_s = (2.0 * root * sqrt(variance)).max(variance) * speed_per_reynolds;
        let [u, v] = direction.map_or([0.0; 2], |direction| direction.towards);
        let (along, around) = (plus(scaled(self.basis[0], u), v, self.basis[1]), [-v, u]);
        let around = plus(scaled(self.basis[0], around[0]), around[1], self.basis[1]);
        let third = cross(self.basis[0], self.basis[1]);
        let sideways_m_s = speed_m_s * angle_rad;
        let mut covariance_m2_s2 = [[0.0; 3]; 3];
        plus_outer(&mut covariance_m2_s2, speed_error_m_s * speed_error_m_s, along);
        plus_outer(&mut covariance_m2_s2, sideways_m_s * sideways_m_s, around);
        // Coupling: a b + b a = ½ ((a + b)² − (a − b)²).
        let coupled = 0.5 * 2.0 * root * speed_per_reynolds * with_angle * speed_m_s;
        plus_outer(&mut covariance_m2_s2, coupled, plus(along, 1.0, around));
        plus_outer(&mut covariance_m2_s2, -coupled, plus(along, -1.0, around));
        // Across the plane it may be as fast as within.
        plus_outer(&mut covariance_m2_s2, speed_m_s * speed_m_s, third);
        WindEstimate {
            wind_m_s: scaled(along, speed_m_s),
            speed_m_s,
            across_m_s: 0.0,
            covariance_m2_s2,
            speed_error_m_s,
            direction_error_rad: angle_rad,
            chi_square,
            degrees_of_freedom,
            steps: 0,
            other_m_s: None,
            quality,
        }
    }

    /// The angle of the wind that has these differences.
    fn direction(&self, downstream: [f32; 2]) -> Option<Direction> {
        let (ray, next, share) = self.between(downstream, |ray| ray.differences)?;
        let mix = |a: [f32; 2], b: [f32; 2]| [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
        let towards = mix(ray.towards, next.towards);
        let differences = mix(ray.differences, next.differences);
        let towards_size = sqrt(towards[0] * towards[0] + towards[1] * towards[1]);
        let size = sqrt(differences[0] * differences[0] + differences[1] * differences[1]);
        let turned = turn(ray.towards, next.towards) / (towards_size * towards_size);
        let share_per_angle = size * size / turn(ray.differences, next.differences);
        let grows = [0, 1].map(|k| next.differences[k] - ray.differences[k]);
        let outwards = (differences[0] * grows[0] + differences[1] * grows[1]) / (size * size);
        let root_seen = ray.root_seen + share * (next.root_seen - ray.root_seen);
        Some(Direction {
            towards: towards.map(|x| x / towards_size),
            size,
            root_seen,
            per_angle: turned * share_per_angle,
            size_per_angle: outwards * share_per_angle,
            seen_per_angle: (next.root_seen - ray.root_seen) / root_seen * share_per_angle,
        })
    }

    /// The two rays between which a vector lies, and the share of the second.
    fn between(&self, vector: [f32; 2], of: fn(&Ray) -> [f32; 2]) -> Option<(&Ray, &Ray, f32)> {
        let following = self.rays.iter().cycle().skip(1);
        self.rays.iter().zip(following).find_map(|(ray, next)| {
            let (from, to) = (turn(of(ray), vector), turn(vector, of(next)));
            // All rays turn the same way by less than a right angle: both are positive between the
            // two alone.
            (from >= 0.0 && to > 0.0).then(|| (ray, next, from / (from + to)))
        })
    }
}

/// M, D and their covariance, in Nusselt numbers.
struct FittedDice {
    mean: f32,
    /// −D_p, −D_q.
    downstream: [f32; 2],
    covariance: Matrix,
    chi_square: f32,
    degrees_of_freedom: u8,
}

/// a × b in the plane.
fn turn(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

fn rays(config: &CardConfig) -> Result<[Ray; RAYS], ConfigError> {
    for &x in config.along.iter().chain(&config.around).chain(&config.seen) {
        error::within(Parameter::CardAnisotropy, x, -1e3, 1e3)?;
    }
    let refused = ConfigError { parameter: Parameter::CardAnisotropy, problem: ParameterProblem::NotPositive };
    let mut rays = [Ray { towards: [0.0; 2], differences: [0.0; 2], root_seen: 0.0 }; RAYS];
    for (j, ray) in rays.iter_mut().enumerate() {
        let angle = 2.0 * core::f64::consts::PI * j as f64 / RAYS as f64;
        let (along, around, seen) = anisotropy(config, angle);
        ray.towards = [libm::cos(angle) as f32, libm::sin(angle) as f32];
        ray.differences = [along as f32, around as f32];
        if seen <= 0.0 {
            return Err(refused);
        }
        ray.root_seen = sqrt(seen as f32);
    }
    for (j, ray) in rays.iter().enumerate() {
        let next = &rays[(j + 1) % RAYS];
        // Never a right angle away from the wind, and always on round: then once round.
        let [u, v] = ray.towards;
        let with_wind = u * ray.differences[0] + v * ray.differences[1];
        if !(with_wind > 0.0 && turn(ray.differences, next.differences) > 0.0) {
            return Err(refused);
        }
    }
    Ok(rays)
}

/// P, Q and E at an angle, rad.
pub fn anisotropy(config: &CardConfig, angle: f64) -> (f64, f64, f64) {
    let sum = |terms: &[f32; TERMS], of: fn(f64) -> f64, first: usize| {
        terms.iter().enumerate().map(|(n, &term)| f64::from(term) * of((n + first) as f64 * angle)).sum::<f64>()
    };
    (sum(&config.along, libm::cos, 0), sum(&config.around, libm::sin, 1), sum(&config.seen, libm::cos, 0))
}

/// Towards the tip, where the first two dice are, and around, from the first to the second.
fn basis(dice: &[SurfaceConfig; DICE]) -> Result<[[f32; 3]; 2], ConfigError> {
    let unit = |a: [f32; 3]| {
        let size = length(a);
        if size.is_normal() { Ok(scaled(a, 1.0 / size)) } else { Err(not_a_square()) }
    };
    let tip = unit(plus(dice[0].corner, 1.0, dice[1].corner))?;
    let around = plus(dice[1].corner, -1.0, dice[0].corner);
    Ok([tip, unit(plus(around, -dot(around, tip), tip))?])
}

/// p_i, q_i, which have to be those of a square.
fn places(dice: &[SurfaceConfig; DICE], basis: &[[f32; 3]; 2]) -> Result<[[f32; 2]; DICE], ConfigError> {
    let places = core::array::from_fn(|i| basis.map(|b| if dot(b, dice[i].corner) > 0.0 { 1.0 } else { -1.0 }));
    let square = places == [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let flat = dice.iter().all(|die| dot(die.axis, basis[0]).max(-dot(die.axis, basis[0])) < 0.1 * length(die.axis));
    if square && flat { Ok(places) } else { Err(not_a_square()) }
}

const fn not_a_square() -> ConfigError {
    ConfigError { parameter: Parameter::Corner, problem: ParameterProblem::NotPositive }
}
