//! The wind that is likeliest for what several instruments say.
//!
//! ```text
//! cost(v) = Σ (w_i − |v| m_i)² / (s_i² |v|² + σ_i²) + Σ ln(s_i² + σ_i²/|v|²)
//! χ²(v)   = rᵀ C⁻¹ r,    r_i = w_i − |v| m_i,    C_ij = ρ_ij s_i s_j |v|² + δ_ij (n_i |v|² + σ_i²)
//!
//! m: answers in the direction of v;  n: scatter of rows, part of s above;  ρ: correlation
//! ```
//!
//! The cost is sought in even directions, each with the speed that fits best there, then χ² by
//! Gauss–Newton from the best one, with C as there.
//!
//! | flag | when |
//! |---|---|
//! | ambiguous | a direction fits about as well that is farther from the best one than its uncertainty explains |
//! | inconsistent | χ² beyond the 99th percentile of chance, and of winds that were left out: the instruments do not say the same; uncertainties grow with χ |
//! | no-direction | its standard uncertainty is above 20° |

use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};

use super::combination::Combination;
use super::instrument::{InstrumentKind, InstrumentReading};
use super::space::WindSpace;

use crate::vector::{angle_deg, dot};

/// Directions that are searched.
const DIRECTIONS: usize = 1000;
/// Steps of Gauss–Newton at most.
const MOST_STEPS: usize = 30;
/// Relative step by which a wind is settled.
const SETTLED: f64 = 1e-6;
/// Relative step of the derivatives.
const STEP: f64 = 1e-4;
/// A direction so far from the best is another one: in standard uncertainties, and in steps of the
/// search.
const ANOTHER_U: f64 = 5.0;
const ANOTHER_STEPS: f64 = 2.5;
/// And fits about as well if its cost is not more by so much: three standard errors.
const AS_WELL: f64 = 9.0;
/// Speeds beyond those of the known winds by this factor are extrapolated.
const BEYOND: f64 = 1.05;
/// The greatest standard uncertainty of a direction, rad: 20°, as that of heads.
const DIRECTION_U_MAX_RAD: f64 = 0.35;

/// A wind by several instruments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CombinedWind {
    /// Where the gas goes to, m/s.
    pub wind_m_s: [f64; 3],
    /// Standard uncertainty of the speed, m/s.
    pub speed_u_m_s: f64,
    /// Uncertainty of the direction, in the worse of its two components, rad.
    pub direction_u_rad: f64,
    /// χ² of the components.
    pub chi_square: f64,
    /// Components beyond those of the wind.
    pub degrees_of_freedom: usize,
    /// Another direction fits about as well.
    pub is_ambiguous: bool,
    /// The instruments do not say the same.
    pub is_inconsistent: bool,
    /// The direction is not known.
    pub has_no_direction: bool,
    /// Slower or faster than the known winds.
    pub is_extrapolated: bool,
    /// An instrument has no estimate.
    pub is_degraded: bool,
}

impl CombinedWind {
    /// Tells whether its uncertainties do not say all.
    pub const fn is_flagged(&self) -> bool {
        self.is_ambiguous || self.is_inconsistent || self.has_no_direction || self.is_extrapolated
    }
}

/// 99th percentile of χ².
pub fn chi_square_99(degrees_of_freedom: usize) -> f64 {
    chi_square_quantile(degrees_of_freedom as f64, 2.326)
}

/// Quantile of χ² where that of the normal distribution is `deviations`, by Wilson and Hilferty
/// (Proc. Natl. Acad. Sci. 17 (1931) 684): from one degree of freedom on the 99th percentile within
/// 1 %, the 95th within 3 %, the median within 4 %.
pub fn chi_square_quantile(degrees_of_freedom: f64, deviations: f64) -> f64 {
    let ninth = 2.0 / (9.0 * degrees_of_freedom);
    degrees_of_freedom * (1.0 - ninth + deviations * ninth.sqrt()).powi(3)
}

/// Combines readings by a [`Combination`].
pub struct Combiner<'a> {
    combination: &'a Combination,
    correlation: DMatrix<f64>,
    grid: Vec<SearchedDirection>,
}

/// A direction of the search.
struct SearchedDirection {
    towards: [f64; 3],
    answers: Vec<f64>,
    /// By component: of what is left, and of rows.
    variances: Vec<[f64; 2]>,
}

/// A component that was read: its place, value and σ²; of one that knows no speed both are shares.
struct ReadComponent {
    place: usize,
    value: f64,
    variance: f64,
    kind: InstrumentKind,
}

impl<'a> Combiner<'a> {
    /// Prepares the search.
    pub fn new(combination: &'a Combination) -> Self {
        let of = |towards| SearchedDirection {
            towards,
            answers: combination.answers(towards),
            variances: combination.variances(towards),
        };
        let grid = combination.space.even_directions(DIRECTIONS).into_iter().map(of).collect();
        Self { combination, correlation: combination.correlation(), grid }
    }

    /// The wind of one reading of each instrument; none with fewer components than it has itself,
    /// or without a speed.
    pub fn estimate(&self, readings: &[Option<InstrumentReading>]) -> Option<CombinedWind> {
        let (read, dimensions) = (self.components(readings), self.combination.space.dimensions());
        if read.len() < dimensions || read.iter().all(|of| of.kind == InstrumentKind::Direction) {
            return None;
        }
        let starts: Vec<_> = self.grid.iter().map(|of| (fitted(&read, of), of)).collect();
        let ((speed_m_s, least), start) = starts.iter().min_by(|a, b| a.0.1.total_cmp(&b.0.1))?;
        let weight = self.covariance(&read, start, *speed_m_s).cholesky()?.inverse();
        let mut wind = Vector3::from(start.towards) * *speed_m_s;
        let (mut chi_square, mut normal) = (self.chi_square(&read, &weight, wind), Matrix3::identity());
        for _ in 0..MOST_STEPS {
            let (h, b) = self.equations(&read, &weight, wind);
            normal = h;
            let mut step = h.cholesky()?.solve(&b);
            let mut next = self.chi_square(&read, &weight, wind + step);
            while next > chi_square && step.norm() > SETTLED * wind.norm() {
                step *= 0.5;
                next = self.chi_square(&read, &weight, wind + step);
            }
            if next > chi_square {
                break;
            }
            wind += step;
            chi_square = next;
            if step.norm() <= SETTLED * wind.norm() {
                break;
            }
        }
        let covariance = normal.try_inverse()?;
        let along = |of: Vector3<f64>| (of.transpose() * covariance * of)[0].max(0.0);
        let towards = wind.normalize();
        let sideways = match self.combination.space {
            WindSpace::Across(normal) => along(towards.cross(&Vector3::from(normal))),
            WindSpace::Everywhere => {
                let across = Matrix3::identity() - towards * towards.transpose();
                (across * covariance * across).symmetric_eigenvalues().max().max(0.0)
            }
        };
        let mut speed_u_m_s = along(towards).sqrt();
        let mut direction_u_rad = sideways.sqrt() / wind.norm();
        let far_deg =
            (ANOTHER_STEPS * self.combination.space.step_deg(DIRECTIONS)).max(ANOTHER_U * direction_u_rad.to_degrees());
        let another = |((_, cost), of): &((f64, f64), &SearchedDirection)| {
            *cost < least + AS_WELL && angle_deg(of.towards, start.towards) > far_deg
        };
        let is_ambiguous = starts.iter().any(another);
        let degrees_of_freedom = read.len() - dimensions;
        let too_much = chi_square / (self.combination.chi_square_ratio * chi_square_99(degrees_of_freedom.max(1)));
        let is_inconsistent = degrees_of_freedom > 0 && too_much > 1.0;
        if is_inconsistent {
            speed_u_m_s *= too_much.sqrt();
            direction_u_rad *= too_much.sqrt();
        }
        let [slowest, fastest] = self.combination.speeds_m_s;
        Some(CombinedWind {
            wind_m_s: wind.into(),
            speed_u_m_s,
            direction_u_rad,
            chi_square,
            degrees_of_freedom,
            is_ambiguous,
            is_inconsistent,
            has_no_direction: direction_u_rad > DIRECTION_U_MAX_RAD,
            is_degraded: readings.iter().any(Option::is_none),
            is_extrapolated: !(slowest / BEYOND..=fastest * BEYOND).contains(&wind.norm()),
        })
    }

    fn components(&self, readings: &[Option<InstrumentReading>]) -> Vec<ReadComponent> {
        let mut read = Vec::new();
        let mut place = 0;
        for (of, reading) in self.combination.instruments.iter().zip(readings) {
            for axis in &of.axes {
                if let Some(reading) = reading {
                    let (value, variance) = (dot(reading.wind_m_s, *axis), reading.variance(*axis));
                    read.push(ReadComponent { place, value, variance, kind: of.kind });
                }
                place += 1;
            }
        }
        read
    }

    /// Readings in a wind, by component: |v| m(v/|v|).
    fn answers(&self, read: &[ReadComponent], wind: Vector3<f64>) -> Vec<f64> {
        let speed_m_s = wind.norm();
        let shares = self.combination.answers(self.combination.space.part((wind / speed_m_s).into()));
        read.iter().map(|of| shares[of.place] * of.kind.scale(speed_m_s)).collect()
    }

    /// C
    fn covariance(&self, read: &[ReadComponent], at: &SearchedDirection, speed_m_s: f64) -> DMatrix<f64> {
        DMatrix::from_fn(read.len(), read.len(), |i, j| {
            let [left, scatter] = at.variances[read[i].place];
            let scales = read[i].kind.scale(speed_m_s) * read[j].kind.scale(speed_m_s);
            let alike = self.correlation[(read[i].place, read[j].place)];
            let own = if i == j { scatter * scales + read[i].variance } else { 0.0 };
            alike * (left * at.variances[read[j].place][0]).sqrt() * scales + own
        })
    }

    /// Readings beyond the answers to a wind.
    fn off(&self, read: &[ReadComponent], wind: Vector3<f64>) -> DVector<f64> {
        let off = read.iter().zip(self.answers(read, wind)).map(|(of, answer)| of.value - answer);
        DVector::from_iterator(read.len(), off)
    }

    fn chi_square(&self, read: &[ReadComponent], weight: &DMatrix<f64>, wind: Vector3<f64>) -> f64 {
        let off = self.off(read, wind);
        off.dot(&(weight * &off))
    }

    fn equations(
        &self,
        read: &[ReadComponent],
        weight: &DMatrix<f64>,
        wind: Vector3<f64>,
    ) -> (Matrix3<f64>, Vector3<f64>) {
        let by = STEP * wind.norm();
        let space = self.combination.space;
        let mut rows = Matrix3xX::zeros(read.len());
        for k in 0..3 {
            let step = Vector3::ith(k, by);
            let slope = (self.off(read, wind - step) - self.off(read, wind + step)) / (2.0 * by);
            rows.set_row(k, &slope.transpose());
        }
        rows.column_iter_mut().for_each(|mut row| row.copy_from_slice(&space.part([row[0], row[1], row[2]])));
        let mut h = &rows * weight * rows.transpose();
        if let WindSpace::Across(normal) = space {
            // Nothing leaves the plane.
            let normal = Vector3::from(normal);
            h += normal * normal.transpose() * h.trace();
        }
        (h, &rows * (weight * self.off(read, wind)))
    }
}

/// The speed that fits best in a direction, and its cost.
fn fitted(read: &[ReadComponent], at: &SearchedDirection) -> (f64, f64) {
    let variance = |of: &ReadComponent| at.variances[of.place].iter().sum::<f64>();
    let (mut both, mut own) = (0.0, 0.0);
    for of in read.iter().filter(|of| of.kind != InstrumentKind::Direction) {
        let answer = at.answers[of.place];
        both += answer * of.value / variance(of);
        own += answer * answer / variance(of);
    }
    let speed_m_s = (both / own).max(1e-6);
    let cost = read.iter().map(|of| {
        let scale = of.kind.scale(speed_m_s);
        let variance = variance(of) + of.variance / (scale * scale);
        (of.value / scale - at.answers[of.place]).powi(2) / variance + libm::log(variance)
    });
    (speed_m_s, cost.sum())
}

#[cfg(test)]
mod tests {
    use super::super::readings::KnownWind;
    use super::*;
    use crate::vector::{across, length, unit};

    /// Instruments in the wind: readings of all of them.
    type Rig = fn([f64; 3]) -> Vec<InstrumentReading>;

    fn reading(wind_m_s: [f64; 3]) -> InstrumentReading {
        InstrumentReading::new(wind_m_s, 0.005 * length(wind_m_s), 0.005, InstrumentKind::Vector)
    }

    /// Three cards round x, each of which sees its plane, and the less the more it is in the lee.
    fn cards(wind_m_s: [f64; 3]) -> Vec<InstrumentReading> {
        let card = |n: i32| {
            let angle = (90.0 + 120.0 * f64::from(n)).to_radians();
            let normal = [0.0, libm::cos(angle), libm::sin(angle)];
            let facing = -dot(wind_m_s, normal) / length(wind_m_s);
            let share = 1.0 + 0.5 * facing + 0.1 * facing * facing;
            reading(across(wind_m_s, normal).map(|x| x * share))
        };
        (0..3).map(card).collect()
    }

    /// Six boards round x that know a speed each, higher where the wind comes from: across x.
    fn boards(wind_m_s: [f64; 3]) -> Vec<InstrumentReading> {
        let board = |n: i32| {
            let angle = (60.0 * f64::from(n)).to_radians();
            let facing = -dot(wind_m_s, [0.0, libm::cos(angle), libm::sin(angle)]);
            let speed_m_s = 0.8 * length(wind_m_s) + 0.5 * facing;
            InstrumentReading::new([speed_m_s, 0.0, 0.0], 0.005 * speed_m_s, 0.0, InstrumentKind::Speed)
        };
        (0..6).map(board).collect()
    }

    /// Two needles that see the wind mirrored into a quadrant, and a vane that knows it to 10°.
    fn needles(wind_m_s: [f64; 3]) -> Vec<InstrumentReading> {
        let [x, y, _] = unit(wind_m_s);
        let turned = libm::sincos(libm::atan2(y, x) + 0.17 * libm::sin(4.0 * libm::atan2(y, x)) + 1.0);
        let vane = InstrumentReading::new([turned.1, turned.0, 0.0], 0.0, 0.17, InstrumentKind::Direction);
        vec![reading(wind_m_s.map(f64::abs)), vane]
    }

    fn known(rig: Rig, space: WindSpace, count: usize) -> Vec<KnownWind> {
        let wind = |(n, towards): (usize, [f64; 3])| {
            let speed_m_s = 0.5 * libm::pow(20.0, (0.618 * n as f64).fract());
            let wind_m_s = towards.map(|x| speed_m_s * x);
            KnownWind::steady(wind_m_s, rig(wind_m_s).into_iter().map(Some).collect())
        };
        space.even_directions(count).into_iter().enumerate().map(wind).collect()
    }

    fn fitted_to(known: &[KnownWind]) -> Result<Combination, String> {
        let names: Vec<String> = (0..known[0].readings.len()).map(|n| format!("instrument{n}")).collect();
        Combination::fit(&names, &names, known).map_err(|error| error.to_string())
    }

    /// Finds 77 winds that it has not seen, to `within_deg` and a share of the speed; returns how
    /// many were ambiguous: next to a fold of the needles the vane cannot say on which side.
    fn finds(rig: Rig, space: WindSpace, components: usize, within_deg: f64, within: f64) -> usize {
        let combination = fitted_to(&known(rig, space, 120)).unwrap();
        assert_eq!((combination.space.dimensions(), combination.components()), (space.dimensions(), components));
        let combiner = Combiner::new(&combination);
        let mut ambiguous = 0;
        for towards in space.even_directions(77) {
            let wind_m_s = towards.map(|x| 3.0 * x);
            let readings: Vec<_> = rig(wind_m_s).into_iter().map(Some).collect();
            let found = combiner.estimate(&readings).unwrap();
            assert!(angle_deg(found.wind_m_s, wind_m_s) < within_deg, "{towards:?}: {found:?}");
            assert!((length(found.wind_m_s) / 3.0 - 1.0).abs() < within, "{found:?}");
            assert_eq!(found.degrees_of_freedom, components - space.dimensions());
            ambiguous += usize::from(found.is_ambiguous);
        }
        ambiguous
    }

    #[test]
    fn cards_boards_and_a_vane_beside_needles_find_the_wind() {
        assert_eq!(finds(cards, WindSpace::Everywhere, 6, 0.5, 0.01), 0);
        assert_eq!(finds(boards, WindSpace::Across([1.0, 0.0, 0.0]), 6, 0.5, 0.01), 0);
        assert!(finds(needles, WindSpace::Across([0.0, 0.0, 1.0]), 4, 2.5, 0.05) <= 8);
    }

    #[test]
    fn fewer_instruments_know_less() {
        let combination = fitted_to(&known(cards, WindSpace::Everywhere, 120)).unwrap();
        let combiner = Combiner::new(&combination);
        let mut readings: Vec<_> = cards([1.0, 2.0, 3.0]).into_iter().map(Some).collect();
        let all = combiner.estimate(&readings).unwrap();
        readings[0] = None;
        let two = combiner.estimate(&readings).unwrap();
        assert!(two.speed_u_m_s >= all.speed_u_m_s && two.degrees_of_freedom == 1, "{two:?}");
        readings[1] = None;
        assert_eq!(combiner.estimate(&readings), None);
    }

    #[test]
    fn in_the_wake_of_a_mast_the_other_boom_counts() {
        // Two booms that see the whole wind; the first stands behind a mast in winds towards x,
        // where the gas is slow and goes anywhere.
        let booms = |wind_m_s: [f64; 3], n: usize| {
            let turn = [0.9, -0.7, 0.4, -1.0][n % 4];
            let behind = unit(wind_m_s)[0] > 0.8;
            let wake = [0.4 * wind_m_s[0], wind_m_s[1] + turn * wind_m_s[0], wind_m_s[2] - 0.5 * turn * wind_m_s[0]];
            vec![Some(reading(if behind { wake } else { wind_m_s })), Some(reading(wind_m_s.map(|x| 0.97 * x)))]
        };
        let winds = known(cards, WindSpace::Everywhere, 300).into_iter().enumerate();
        let known: Vec<_> = winds.map(|(n, of)| KnownWind { readings: booms(of.wind_m_s, n), ..of }).collect();
        let combination = fitted_to(&known).unwrap();
        let combiner = Combiner::new(&combination);
        for n in 0..4 {
            let wind_m_s = [2.0, 0.3, -0.2];
            let readings = booms(wind_m_s, n);
            let (found, by_first) = (combiner.estimate(&readings).unwrap(), readings[0].unwrap().wind_m_s);
            assert!(angle_deg(by_first, wind_m_s) > 30.0 && angle_deg(found.wind_m_s, wind_m_s) < 3.0, "{found:?}");
        }
    }

    #[test]
    fn a_wind_that_no_instrument_can_have_seen_has_a_large_chi_square() {
        let combination = fitted_to(&known(cards, WindSpace::Everywhere, 120)).unwrap();
        let combiner = Combiner::new(&combination);
        let mut readings: Vec<_> = cards(unit([1.0, 2.0, -0.5])).into_iter().map(Some).collect();
        let usual = combiner.estimate(&readings).unwrap();
        assert!(usual.chi_square < 11.3 && !usual.is_flagged(), "{usual:?}");
        readings[2] = readings[2].map(|of| InstrumentReading { wind_m_s: of.wind_m_s.map(|x| -x), ..of });
        let against = combiner.estimate(&readings).unwrap();
        assert!(against.chi_square > 100.0 && against.is_inconsistent, "{against:?}");
        // By how much it cannot be right is in its uncertainty.
        assert!(against.speed_u_m_s > 3.0 * usual.speed_u_m_s, "{against:?}");
    }

    #[test]
    fn percentiles_of_chi_square_are_those_of_tables() {
        for (degrees, table) in [(1, 6.635), (2, 9.210), (3, 11.345), (10, 23.209)] {
            assert!((chi_square_99(degrees) / table - 1.0).abs() < 0.01, "{degrees}: {}", chi_square_99(degrees));
        }
    }

    /// A mast that slows the wind in 30° of the circle, and a tunnel that turns to ten directions
    /// and holds seven speeds in each.
    #[test]
    fn many_speeds_in_few_directions_do_not_pretend_to_know_what_is_between() {
        let boom = |wind_m_s: [f64; 3]| {
            let off_deg = angle_deg(wind_m_s, [0.707, 0.707, 0.0]);
            vec![reading(wind_m_s.map(|x| x * (1.0 - 0.4 * libm::exp(-(off_deg / 15.0).powi(2)))))]
        };
        let space = WindSpace::Across([0.0, 0.0, 1.0]);
        let speeds = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0];
        let winds = space.even_directions(10).into_iter().flat_map(|towards| speeds.map(|v| towards.map(|x| v * x)));
        let known: Vec<_> =
            winds.map(|wind_m_s| KnownWind::steady(wind_m_s, boom(wind_m_s).into_iter().map(Some).collect())).collect();
        let combination = fitted_to(&known).unwrap();
        // Ten directions hold no more than the first harmonics.
        assert!(combination.degree <= 2, "{}", combination.degree);
        let combiner = Combiner::new(&combination);
        let all = space.even_directions(200).into_iter().map(|of| of.map(|x| 3.0 * x));
        let speeds = all.map(|wind_m_s| combiner.estimate(&boom(wind_m_s).into_iter().map(Some).collect::<Vec<_>>()));
        let offs: Vec<f64> =
            speeds.map(|of| of.map(|of| (length(of.wind_m_s) - 3.0) / of.speed_u_m_s).unwrap()).collect();
        let rms = (offs.iter().map(|of| of * of).sum::<f64>() / offs.len() as f64).sqrt();
        assert!(rms < 3.0, "errors are {rms} times what is stated");
        let grid = KnownWind::steady([1.0, 0.0, 0.0], boom([1.0, 0.0, 0.0]).into_iter().map(Some).collect());
        let few = fitted_to(&vec![grid; 30]).unwrap_err();
        assert!(few.contains("in 1 direction;"), "{few}");
    }

    #[test]
    fn winds_of_one_side_and_too_few_are_refused() {
        let mut all = known(cards, WindSpace::Everywhere, 120);
        let few = fitted_to(&all[..4]).unwrap_err();
        assert!(few.starts_with("4 of 4 known winds have estimates of all instruments"), "{few}");
        all.retain(|of| of.wind_m_s[2] > 0.0);
        assert!(fitted_to(&all).unwrap_err().contains("winds from everywhere are needed"));
        let mut flat = known(needles, WindSpace::Across([0.0, 0.0, 1.0]), 60);
        for of in &mut flat {
            of.readings.remove(0);
        }
        assert_eq!(fitted_to(&flat).unwrap_err(), "no instrument knows a speed");
        flat.retain(|of| of.wind_m_s[1] > 0.0);
        assert!(fitted_to(&flat).unwrap_err().contains("all around their plane"));
    }
}
