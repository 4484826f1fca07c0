//! The wind that is likeliest for what several instruments say.
//!
//! ```text
//! cost(v) = Σ (w_i − |v| m_i)² / (s_i² |v|² + σ_i²) + Σ ln(s_i² + σ_i²/|v|²)        m = answers in the direction of v
//! ```
//!
//! Sought in even directions, each with the speed that fits best there, then by Gauss–Newton from
//! the best one, with variances as there. Where a second direction fits about as well, the estimate
//! is ambiguous.

use nalgebra::{Matrix3, Vector3};

use super::combination::{Combination, along};
use super::harmonics::even_directions;
use super::readings::InstrumentReading;
use crate::vector::{angle_deg, dot, length};

/// Directions that are searched.
const DIRECTIONS: usize = 1000;
/// Steps of Gauss–Newton at most.
const MOST_STEPS: usize = 30;
/// Relative step by which a wind is settled.
const SETTLED: f64 = 1e-6;
/// Relative step of the derivatives.
const STEP: f64 = 1e-4;
/// A direction so far from the best is another one, °.
const ANOTHER_DEG: f64 = 45.0;
/// And fits about as well if its cost is not more by so much: three standard errors.
const AS_WELL: f64 = 9.0;

/// A wind by several instruments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CombinedWind {
    /// Where the gas goes to, m/s.
    pub wind_m_s: [f64; 3],
    /// Standard uncertainty of the speed, m/s.
    pub speed_u_m_s: f64,
    /// Of the direction, in the worse of its two components, rad.
    pub direction_u_rad: f64,
    /// χ² of the components.
    pub chi_square: f64,
    /// Components beyond the three of a vector.
    pub degrees_of_freedom: usize,
    /// Another direction fits about as well.
    pub is_ambiguous: bool,
}

/// Combines readings by a [`Combination`].
pub struct Combiner<'a> {
    combination: &'a Combination,
    /// Direction, answers and s² of each.
    grid: Vec<([f64; 3], Vec<f64>, Vec<f64>)>,
}

/// A component that was read: its place, value and σ².
struct ReadComponent {
    place: usize,
    value_m_s: f64,
    variance_m2_s2: f64,
}

impl<'a> Combiner<'a> {
    /// Prepares the search.
    pub fn new(combination: &'a Combination) -> Self {
        let of = |towards| (towards, combination.answers(towards), combination.variances(towards));
        Self { combination, grid: even_directions(DIRECTIONS).into_iter().map(of).collect() }
    }

    /// The wind of one reading of each instrument; none with fewer than three components.
    pub fn estimate(&self, readings: &[Option<InstrumentReading>]) -> Option<CombinedWind> {
        let read = self.components(readings);
        if read.len() < 3 {
            return None;
        }
        let starts = self.grid.iter().map(|of| {
            let (speed_m_s, cost) = fitted(&read, of);
            (cost, speed_m_s, of)
        });
        let starts: Vec<_> = starts.collect();
        let (least, speed_m_s, start) = starts.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let is_ambiguous =
            starts.iter().any(|(cost, _, of)| *cost < least + AS_WELL && angle_deg(of.0, start.0) > ANOTHER_DEG);
        let variances: Vec<f64> =
            read.iter().map(|of| start.2[of.place] * speed_m_s * speed_m_s + of.variance_m2_s2).collect();
        let mut wind = Vector3::from(start.0) * *speed_m_s;
        let (mut chi_square, mut normal) = (self.chi_square(&read, &variances, wind), Matrix3::identity());
        for _ in 0..MOST_STEPS {
            let (h, b) = self.equations(&read, &variances, wind);
            normal = h;
            let mut step = h.cholesky()?.solve(&b);
            let mut next = self.chi_square(&read, &variances, wind + step);
            while next > chi_square && step.norm() > SETTLED * wind.norm() {
                step *= 0.5;
                next = self.chi_square(&read, &variances, wind + step);
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
        let towards = wind.normalize();
        let speed_u_m_s = (towards.transpose() * covariance * towards)[0].max(0.0).sqrt();
        let across = Matrix3::identity() - towards * towards.transpose();
        let sideways = (across * covariance * across).symmetric_eigenvalues().max().max(0.0).sqrt();
        Some(CombinedWind {
            wind_m_s: wind.into(),
            speed_u_m_s,
            direction_u_rad: sideways / wind.norm(),
            chi_square,
            degrees_of_freedom: read.len() - 3,
            is_ambiguous,
        })
    }

    fn components(&self, readings: &[Option<InstrumentReading>]) -> Vec<ReadComponent> {
        let mut read = Vec::new();
        let mut place = 0;
        for (of, reading) in self.combination.instruments.iter().zip(readings) {
            for axis in &of.axes {
                if let Some(reading) = reading {
                    let speed_m_s = length(reading.wind_m_s).max(f64::MIN_POSITIVE);
                    let share = dot(reading.wind_m_s, *axis) / speed_m_s;
                    let (along_m_s, across_m_s) = (reading.speed_u_m_s, speed_m_s * reading.direction_u_rad);
                    let variance_m2_s2 = (share * along_m_s).powi(2) + (1.0 - share * share) * across_m_s * across_m_s;
                    let value_m_s = along(&Some(*reading), *axis);
                    read.push(ReadComponent { place, value_m_s, variance_m2_s2 });
                }
                place += 1;
            }
        }
        read
    }

    /// |v| m(v/|v|)
    fn answers(&self, wind: Vector3<f64>) -> Vec<f64> {
        let speed_m_s = wind.norm();
        self.combination.answers((wind / speed_m_s).into()).into_iter().map(|share| share * speed_m_s).collect()
    }

    fn chi_square(&self, read: &[ReadComponent], variances: &[f64], wind: Vector3<f64>) -> f64 {
        let answers = self.answers(wind);
        read.iter().zip(variances).map(|(of, variance)| (of.value_m_s - answers[of.place]).powi(2) / variance).sum()
    }

    fn equations(&self, read: &[ReadComponent], variances: &[f64], wind: Vector3<f64>) -> (Matrix3<f64>, Vector3<f64>) {
        let by = STEP * wind.norm();
        let here = self.answers(wind);
        let beside: [[Vec<f64>; 2]; 3] = std::array::from_fn(|k| {
            let step = Vector3::ith(k, by);
            [self.answers(wind + step), self.answers(wind - step)]
        });
        let (mut h, mut b) = (Matrix3::zeros(), Vector3::zeros());
        for (of, variance) in read.iter().zip(variances) {
            let row = Vector3::from_fn(|k, _| (beside[k][0][of.place] - beside[k][1][of.place]) / (2.0 * by));
            h += row * row.transpose() / *variance;
            b += row * (of.value_m_s - here[of.place]) / *variance;
        }
        (h, b)
    }
}

/// The speed that fits best in a direction, and its cost.
fn fitted(read: &[ReadComponent], (_, answers, variances): &([f64; 3], Vec<f64>, Vec<f64>)) -> (f64, f64) {
    let (mut both, mut own) = (0.0, 0.0);
    for of in read {
        let (answer, variance) = (answers[of.place], variances[of.place]);
        both += answer * of.value_m_s / variance;
        own += answer * answer / variance;
    }
    let speed_m_s = (both / own).max(1e-6);
    let cost = read.iter().map(|of| {
        let variance = variances[of.place] + of.variance_m2_s2 / (speed_m_s * speed_m_s);
        (of.value_m_s / speed_m_s - answers[of.place]).powi(2) / variance + variance.ln()
    });
    (speed_m_s, cost.sum())
}

#[cfg(test)]
mod tests {
    use super::super::readings::KnownWind;
    use super::*;
    use crate::vector::{across, unit};

    /// Three cards round x, each of which sees its plane, and the less the more it is in the lee.
    fn card(n: usize, wind_m_s: [f64; 3], shade: f64) -> InstrumentReading {
        let angle = (90.0 + 120.0 * n as f64).to_radians();
        let normal = [0.0, angle.cos(), angle.sin()];
        let facing = -dot(wind_m_s, normal) / length(wind_m_s);
        let share = 1.0 + shade * facing + 0.1 * facing * facing;
        let seen = across(wind_m_s, normal).map(|x| x * share);
        InstrumentReading { wind_m_s: seen, speed_u_m_s: 0.005 * length(seen), direction_u_rad: 0.005 }
    }

    fn known(count: usize, shade: f64) -> Vec<KnownWind> {
        let directions = even_directions(count).into_iter().enumerate();
        let wind = |(n, towards): (usize, [f64; 3])| {
            let speed_m_s = 0.5 * 20_f64.powf((0.618 * n as f64).fract());
            let wind_m_s = towards.map(|x| speed_m_s * x);
            KnownWind { wind_m_s, readings: (0..3).map(|n| Some(card(n, wind_m_s, shade))).collect() }
        };
        directions.map(wind).collect()
    }

    fn names() -> Vec<String> {
        ["card1", "card2", "card3"].map(str::to_owned).to_vec()
    }

    #[test]
    fn three_cards_of_two_components_make_a_vector() {
        let combination = Combination::fit(&names(), &known(120, 0.5)).unwrap();
        assert!(combination.instruments.iter().all(|of| of.axes.len() == 2));
        let combiner = Combiner::new(&combination);
        for towards in even_directions(77) {
            let wind_m_s = towards.map(|x| 3.0 * x);
            let mut readings: Vec<_> = (0..3).map(|n| Some(card(n, wind_m_s, 0.5))).collect();
            let found = combiner.estimate(&readings).unwrap();
            assert!(angle_deg(found.wind_m_s, wind_m_s) < 0.5, "{towards:?}: {found:?}");
            assert!((length(found.wind_m_s) / 3.0 - 1.0).abs() < 0.01 && !found.is_ambiguous, "{found:?}");
            assert_eq!(found.degrees_of_freedom, 3);
            // Two of them still have four components.
            readings[0] = None;
            let two = combiner.estimate(&readings).unwrap();
            assert!(two.speed_u_m_s >= found.speed_u_m_s && two.degrees_of_freedom == 1, "{two:?}");
            readings[1] = None;
            assert_eq!(combiner.estimate(&readings), None);
        }
    }

    #[test]
    fn a_wind_that_no_instrument_can_have_seen_has_a_large_chi_square() {
        let combination = Combination::fit(&names(), &known(120, 0.5)).unwrap();
        let combiner = Combiner::new(&combination);
        let wind_m_s = unit([1.0, 2.0, -0.5]);
        let mut readings: Vec<_> = (0..3).map(|n| Some(card(n, wind_m_s, 0.5))).collect();
        assert!(combiner.estimate(&readings).unwrap().chi_square < 11.3);
        let turned = readings[2].map(|of| InstrumentReading { wind_m_s: of.wind_m_s.map(|x| -x), ..of });
        readings[2] = turned;
        assert!(combiner.estimate(&readings).unwrap().chi_square > 100.0);
    }

    #[test]
    fn winds_of_one_side_and_too_few_are_refused() {
        let refused = |known: &[KnownWind]| Combination::fit(&names(), known).unwrap_err().to_string();
        let mut all = known(120, 0.5);
        assert!(refused(&all[..4]).starts_with("4 known winds have estimates of all instruments"));
        all.retain(|of| of.wind_m_s[2] > 0.0);
        assert!(refused(&all).contains("winds from everywhere are needed"));
    }
}
