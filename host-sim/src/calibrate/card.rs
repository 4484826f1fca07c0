//! Calibration of the four dice of a card: from their readings in known winds of the card's plane to the curves by which dr-core's
//! [`card`](dr_core::sensor::wind::card) tells unknown ones.
//!
//! ```text
//! Nu_i = c_i (q_i + G0 a_i) / (θ_i k a)          G0 = 4/√π k a
//! (D_p, D_q) = −Re^n (P(θ), Q(θ)) + (ε_p, ε_q) M        by linear least squares for every n, and the n that leaves least
//! M = mean(√(Re E(θ)))                                  by Gauss–Newton for knots and harmonics together; E is 1 head-on
//! c_i = 1/(1 + ε_p p_i + ε_q q_i + ε_t p_i q_i)         dice that are not alike lose more or less in every wind
//! ```
//!
//! G0 is what a square on a plane conducts away in still gas: the windless network has it in it, and the wind adds to it. How much each curve is
//! wrong by itself, the readings say: `mean_share` and `difference_share` are what the fit leaves. With winds that are held shorter than the card
//! takes to cool (minutes) most of the former is what the card still remembers, so hold them for about as long as winds last where they are to be told.
//!
//! *Limits.* Winds in the plane, in the frame in which the normal of the card and its tip are given; no mounting is sought.

use dr_core::sensor::wind::card::{CONDUCTION, Card, CardConfig, DICE, KNOTS, TERMS, anisotropy};
use dr_core::sensor::wind::{Measured, PartConfig};
use nalgebra::{DMatrix, DVector};

use super::CalibrateError;
use super::held_out::{Error, Summary};
use super::run::{PartReading, Steady};
use crate::head::calibration::CardTable;

/// p_i, q_i: neighbours follow each other from the tip on.
const PLACES: [[f64; 2]; DICE] = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
/// Sectors of directions of which each needs a wind.
const SECTORS: usize = 12;
/// Fewest winds: some for every unknown.
const LEAST_WINDS: usize = 40;
/// Least ratio of the greatest to the least speed.
const LEAST_RATIO: f64 = 3.0;
/// Greatest share of a wind that may lie across the plane.
const MOST_ACROSS: f64 = 0.02;
/// Harmonics of E that are sought.
const SEEN: usize = 5;
/// What a bend of the mean curve by a factor of e from one knot to the next costs, and a harmonic of E, beside a relative error of one.
const BEND: f64 = 0.05;
const HARMONIC: f64 = 1e-3;
const MOST_STEPS: usize = 60;
/// As in `held_out`.
const DIRECTION_ERROR_MAX_RAD: f32 = 1.0;

/// A card as drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnCard {
    /// Side of a die, m.
    pub side_m: f64,
    /// Outward.
    pub normal: [f64; 3],
    /// Along the boom; from it around is tip × normal.
    pub tip: [f64; 3],
}

/// A calibrated card.
#[derive(Debug, Clone, PartialEq)]
pub struct CardCalibration {
    pub drawn: DrawnCard,
    pub least_reynolds: f64,
    pub most_reynolds: f64,
    pub mean: [f64; KNOTS],
    pub difference: [f64; KNOTS],
    pub along: [f64; TERMS],
    pub around: [f64; TERMS],
    pub seen: [f64; TERMS],
    /// n
    pub exponent: f64,
    pub mean_share: f64,
    pub difference_share: f64,
    /// c, of mean one.
    pub gains: [f64; DICE],
    /// G0 at the reference, W/K.
    pub still_w_k: f64,
    pub winds: usize,
}

/// Errors of winds that were held out.
#[derive(Debug, Clone, PartialEq)]
pub struct CardHeldOut {
    pub errors: Vec<Error>,
    pub failed: Vec<String>,
}

/// A wind in the plane.
struct Row {
    /// √Re
    root: f64,
    angle: f64,
    /// M, D_p, D_q, and the fourth, which no wind makes.
    mean: f64,
    differences: [f64; 2],
    twist: f64,
}

impl DrawnCard {
    fn around(&self) -> [f64; 3] {
        let ([a, b, c], [x, y, z]) = (unit(self.tip), unit(self.normal));
        [b * z - c * y, c * x - a * z, a * y - b * x]
    }

    /// The dice as dr-core has them.
    pub fn dice(&self) -> [PartConfig; DICE] {
        let (tip, around) = (unit(self.tip), self.around());
        PLACES.map(|[p, q]| PartConfig {
            axis: self.normal.map(|x| x as f32),
            corner: std::array::from_fn(|k| (p * tip[k] + q * around[k]) as f32),
            area_m2: (self.side_m * self.side_m) as f32,
            means: [0.0; 5],
            threefold: [0.0; 3],
        })
    }

    fn still_w_k(&self, conductivity_w_m_k: f64) -> f64 {
        f64::from(CONDUCTION) * conductivity_w_m_k * self.side_m
    }

    fn conductance_w_k(&self, steady: &Steady, reading: &PartReading) -> f64 {
        let still_w_k = self.still_w_k(steady.gas.conductivity_w_m_k);
        (reading.power_w + still_w_k * reading.above_reference_k) / reading.overheat_k
    }

    fn reynolds_per_speed(&self, steady: &Steady) -> f64 {
        steady.gas.density_kg_m3 * self.side_m / steady.gas.viscosity_pa_s
    }

    /// # Errors
    /// If a reading cannot be meant. Nothing for still gas.
    fn row(&self, steady: &Steady) -> Result<Option<Row>, CalibrateError> {
        let refuse = |sentence: String| CalibrateError::Reading { label: steady.label.clone(), sentence };
        let readings: &[PartReading; DICE] = steady
            .parts
            .as_slice()
            .try_into()
            .map_err(|_| refuse(format!("{} dice were read, but a card has {DICE}", steady.parts.len())))?;
        if let Some(bad) = readings.iter().find(|of| !(of.overheat_k > 0.0 && of.power_w.is_finite())) {
            return Err(refuse(format!("a die is {} K above the gas: it must be warmer", bad.overheat_k)));
        }
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let flat = [dot(steady.wind_m_s, unit(self.tip)), dot(steady.wind_m_s, self.around())];
        let (across, speed) = (dot(steady.wind_m_s, unit(self.normal)), flat[0].hypot(flat[1]));
        if across.abs() > MOST_ACROSS * speed {
            return Err(refuse(format!(
                "{across:.2} m/s of it blow across the card: a card is calibrated in winds of its plane"
            )));
        }
        if speed == 0.0 {
            return Ok(None);
        }
        let unit_w_k = steady.gas.conductivity_w_m_k * self.side_m;
        let nusselt = readings.map(|reading| self.conductance_w_k(steady, &reading) / unit_w_k);
        let sum = |of: fn([f64; 2]) -> f64| (0..DICE).map(|i| of(PLACES[i]) * nusselt[i]).sum::<f64>() / DICE as f64;
        Ok(Some(Row {
            root: (speed * self.reynolds_per_speed(steady)).sqrt(),
            angle: flat[1].atan2(flat[0]),
            mean: sum(|_| 1.0),
            differences: [sum(|[p, _]| p), sum(|[_, q]| q)],
            twist: sum(|[p, q]| p * q),
        }))
    }
}

/// Calibrates a card.
///
/// # Errors
/// If a reading cannot be meant, if the winds do not determine what is sought, or if what fits best makes no card.
pub fn calibrate(drawn: &DrawnCard, steady: &[Steady]) -> Result<CardCalibration, CalibrateError> {
    let lacking = lacking(&rows(drawn, steady)?);
    if lacking.is_empty() { solve(drawn, steady) } else { Err(CalibrateError::Spread(lacking)) }
}

fn rows(drawn: &DrawnCard, steady: &[Steady]) -> Result<Vec<Row>, CalibrateError> {
    steady.iter().filter_map(|steady| drawn.row(steady).transpose()).collect()
}

/// Which winds are missing, a sentence each.
fn lacking(rows: &[Row]) -> Vec<String> {
    let mut lacking = Vec::new();
    if rows.len() < LEAST_WINDS {
        lacking.push(format!("{} winds are given, at least {LEAST_WINDS} are needed", rows.len()));
    }
    let (least, most) = ends(rows);
    if most < LEAST_RATIO * least {
        lacking.push(format!(
            "the fastest wind is {:.1} times as fast as the slowest; {LEAST_RATIO} times are needed at least",
            most / least
        ));
    }
    let width = 360 / SECTORS;
    let sector = |row: &Row| (row.angle.to_degrees().rem_euclid(360.0) as usize / width).min(SECTORS - 1);
    for empty in (0..SECTORS).filter(|&n| rows.iter().all(|row| sector(row) != n)) {
        lacking.push(format!(
            "no wind goes towards {} to {}° from the tip around the boom",
            empty * width,
            (empty + 1) * width
        ));
    }
    lacking
}

/// Least and greatest Reynolds number.
fn ends(rows: &[Row]) -> (f64, f64) {
    rows.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), row| {
        (least.min(row.root * row.root), most.max(row.root * row.root))
    })
}

/// The same without asking whether the winds are well spread.
fn solve(drawn: &DrawnCard, steady: &[Steady]) -> Result<CardCalibration, CalibrateError> {
    let rows = rows(drawn, steady)?;
    let (least_reynolds, most_reynolds) = ends(&rows);
    let differences = differences(&rows).ok_or(CalibrateError::NoMinimum)?;
    let mean = mean(&rows, most_reynolds.sqrt()).ok_or(CalibrateError::NoMinimum)?;
    let squares = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).sum::<f64>();
    let twist = squares(&|row| row.twist * row.mean) / squares(&|row| row.mean * row.mean);
    let [along, around] = differences.unlike;
    let gains = PLACES.map(|[p, q]| 1.0 / (1.0 + along * p + around * q + twist * p * q));
    let usual = gains.iter().sum::<f64>() / DICE as f64;
    let knots =
        |of: &dyn Fn(f64) -> f64| std::array::from_fn(|k| of(most_reynolds.sqrt() * k as f64 / (KNOTS - 1) as f64));
    // Still gas counts at the reference, where the network holds it.
    let conductivity_w_m_k = steady.first().map_or(0.0, |steady| steady.gas.conductivity_w_m_k);
    let calibration = CardCalibration {
        least_reynolds,
        most_reynolds,
        mean: mean.knots,
        difference: knots(&|root| root.powf(2.0 * differences.exponent)),
        along: differences.along,
        around: differences.around,
        seen: mean.seen,
        exponent: differences.exponent,
        mean_share: mean.share,
        difference_share: differences.share,
        gains: gains.map(|gain| gain / usual),
        still_w_k: drawn.still_w_k(conductivity_w_m_k),
        winds: rows.len(),
        drawn: drawn.clone(),
    };
    calibration.card()?;
    Ok(calibration)
}

struct Differences {
    along: [f64; TERMS],
    around: [f64; TERMS],
    exponent: f64,
    /// ε_p, ε_q
    unlike: [f64; 2],
    share: f64,
}

fn differences(rows: &[Row]) -> Option<Differences> {
    let solved = |exponent: f64, k: usize| {
        let of = |n: usize, angle: f64| match k {
            0 => (n as f64 * angle).cos(),
            _ => ((n + 1) as f64 * angle).sin(),
        };
        let size = |row: &Row| row.root.powf(2.0 * exponent);
        let design = DMatrix::from_fn(rows.len(), TERMS + 1, |at, n| {
            let row = &rows[at];
            if n < TERMS { of(n, row.angle) } else { -row.mean / size(row) }
        });
        let wanted = DVector::from_fn(rows.len(), |at, _| -rows[at].differences[k] / size(&rows[at]));
        let found = design.clone().svd(true, true).solve(&wanted, 1e-12).ok()?;
        let left = (&design * &found - wanted).norm_squared();
        Some((found, left))
    };
    let both = |exponent: f64| Some((solved(exponent, 0)?, solved(exponent, 1)?));
    let left = |exponent: f64| both(exponent).map_or(f64::INFINITY, |(along, around)| along.1 + around.1);
    let exponent = (0..=100).map(|n| 0.25 + 0.005 * f64::from(n)).min_by(|&a, &b| left(a).total_cmp(&left(b)))?;
    let ((along, along_left), (around, around_left)) = both(exponent)?;
    let terms = |of: &DVector<f64>| std::array::from_fn(|n| of[n]);
    let (along_terms, around_terms): ([f64; TERMS], [f64; TERMS]) = (terms(&along), terms(&around));
    let size2: f64 = rows
        .iter()
        .map(|row| {
            let sum = |of: &[f64; TERMS], f: fn(f64) -> f64, first: usize| {
                of.iter().enumerate().map(|(n, a)| a * f((n + first) as f64 * row.angle)).sum::<f64>()
            };
            sum(&along_terms, f64::cos, 0).powi(2) + sum(&around_terms, f64::sin, 1).powi(2)
        })
        .sum();
    // Of one component beside the size of both; two components a wind less what was fitted to them.
    let free = (2 * rows.len()).saturating_sub(2 * TERMS + 3).max(1) as f64;
    let share = ((along_left + around_left) / free / (size2 / rows.len() as f64)).sqrt();
    Some(Differences {
        along: along_terms,
        around: around_terms,
        exponent,
        unlike: [along[TERMS], around[TERMS]],
        share,
    })
}

struct Mean {
    knots: [f64; KNOTS],
    seen: [f64; TERMS],
    share: f64,
}

/// Logarithms of what the curve rises from knot to knot, so that it rises; then harmonics of E but the zeroth.
fn unpacked(x: &DVector<f64>) -> ([f64; KNOTS], [f64; TERMS]) {
    let mut knots = [f64::from(CONDUCTION); KNOTS];
    for k in 1..KNOTS {
        knots[k] = knots[k - 1] + x[k - 1].exp();
    }
    let mut seen = [0.0; TERMS];
    seen[0] = 1.0;
    for n in 1..=SEEN {
        seen[n] = x[KNOTS - 2 + n];
        // One head-on, at π.
        seen[0] -= seen[n] * if n % 2 == 0 { 1.0 } else { -1.0 };
    }
    (knots, seen)
}

fn seen_at(seen: &[f64; TERMS], angle: f64) -> f64 {
    seen.iter().enumerate().map(|(n, a)| a * (n as f64 * angle).cos()).sum()
}

fn straight(knots: &[f64; KNOTS], position: f64) -> f64 {
    let knot = (position as usize).min(KNOTS - 2);
    knots[knot] + (position - knot as f64) * (knots[knot + 1] - knots[knot])
}

fn mean(rows: &[Row], most_root: f64) -> Option<Mean> {
    let per_root = (KNOTS - 1) as f64 / most_root;
    let of_row = |row: &Row, (knots, seen): &([f64; KNOTS], [f64; TERMS])| {
        // A share of nothing or less is none; the steps do not end there.
        straight(knots, row.root * seen_at(seen, row.angle).max(1e-3).sqrt() * per_root)
    };
    let bends = KNOTS - 2;
    let errors = |x: &DVector<f64>| {
        let both = unpacked(x);
        DVector::from_iterator(
            rows.len() + bends + SEEN,
            rows.iter()
                .map(|row| of_row(row, &both) / row.mean - 1.0)
                .chain((1..KNOTS - 1).map(|k| BEND * (x[k] - x[k - 1])))
                .chain((1..=SEEN).map(|n| HARMONIC * n as f64 * both.1[n])),
        )
    };
    let most_mean = rows.iter().map(|row| row.mean).fold(0.0, f64::max);
    let start = f64::from(CONDUCTION);
    let mut x = DVector::from_fn(KNOTS - 1 + SEEN, |n, _| match n {
        n if n < KNOTS - 1 => ((most_mean - start).max(1e-3) / (KNOTS - 1) as f64).ln(),
        n if n == KNOTS - 1 => -0.3,
        _ => 0.0,
    });
    let mut left = errors(&x);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let jacobian = DMatrix::from_columns(
            &(0..x.len())
                .map(|n| {
                    let step = 1e-6 * x[n].abs().max(1.0);
                    let mut moved = x.clone();
                    moved[n] += step;
                    (errors(&moved) - &left) / step
                })
                .collect::<Vec<_>>(),
        );
        let mut normal = jacobian.tr_mul(&jacobian);
        for n in 0..x.len() {
            normal[(n, n)] *= 1.0 + damping;
        }
        let step = normal.cholesky()?.solve(&jacobian.tr_mul(&left));
        let next = &x - step;
        let after = errors(&next);
        if after.norm_squared() < left.norm_squared() {
            let gained = 1.0 - after.norm_squared() / left.norm_squared();
            (x, left, damping) = (next, after, damping * 0.3);
            if gained < 1e-9 {
                break;
            }
        } else {
            damping *= 5.0;
        }
    }
    let (knots, seen) = unpacked(&x);
    let squares: f64 =
        rows.iter().map(|row| ((of_row(row, &(knots, seen)) - row.mean) / (row.mean - start)).powi(2)).sum();
    let free = rows.len().saturating_sub(x.len()).max(1) as f64;
    Some(Mean { knots, seen, share: (squares / free).sqrt() })
}

impl CardCalibration {
    /// As a head file has it.
    pub fn table(&self) -> CardTable {
        CardTable {
            least_reynolds: self.least_reynolds,
            most_reynolds: self.most_reynolds,
            mean: self.mean,
            difference: self.difference,
            along: self.along,
            around: self.around,
            seen: self.seen,
            mean_share: self.mean_share,
            difference_share: self.difference_share,
        }
    }

    /// As the board takes it.
    pub fn config(&self) -> CardConfig {
        self.table().config()
    }

    fn card(&self) -> Result<Card, dr_core::ConfigError> {
        let (side_m, most) = (self.drawn.side_m as f32, self.most_reynolds as f32);
        Card::new(&self.config(), &self.drawn.dice(), side_m, most, DIRECTION_ERROR_MAX_RAD)
    }

    /// E at an angle, rad: the share of the speed that the card sees.
    pub fn seen_at(&self, angle: f64) -> f64 {
        anisotropy(&self.config(), angle).2
    }

    /// What it says of a known wind; nothing where it has no answer.
    ///
    /// # Errors
    /// If it makes no card, or the reading cannot be meant.
    pub fn error(&self, steady: &Steady) -> Result<Option<Error>, CalibrateError> {
        let gas = steady.gas.core().map_err(|error| CalibrateError::Reading {
            label: steady.label.clone(),
            sentence: format!("gas: {error}"),
        })?;
        let mut measured = [None; DICE];
        for (i, (measured, reading)) in measured.iter_mut().zip(&steady.parts).enumerate() {
            let share = self.gains[i] / reading.overheat_k;
            *measured = Some(Measured {
                conductance_w_k: (self.gains[i] * self.drawn.conductance_w_k(steady, reading)) as f32,
                variance_w2_k2: (share * share * reading.variance_w2) as f32,
            });
        }
        let answer = self.card()?.step(&gas, &measured);
        let speed_m_s = steady.wind_m_s.iter().map(|v| v * v).sum::<f64>().sqrt();
        if answer.quality.failed || answer.quality.no_direction || speed_m_s == 0.0 {
            return Ok(None);
        }
        Ok(Some(Error {
            label: steady.label.clone(),
            speed_m_s,
            reynolds: speed_m_s * self.drawn.reynolds_per_speed(steady),
            direction_deg: crate::answer::errors::angle_deg(answer.wind_m_s.map(f64::from), steady.wind_m_s),
            speed: f64::from(answer.speed_m_s) / speed_m_s - 1.0,
            chi_square: f64::from(answer.chi_square) / f64::from(answer.degrees_of_freedom.max(1)),
        }))
    }
}

impl CardHeldOut {
    pub fn overall(&self) -> Summary {
        Summary::of(self.errors.iter())
    }
}

/// Fits all but every `count`-th wind, from each of the first `count` on, and asks for what was left out.
///
/// # Errors
/// As those of [`calibrate`].
pub fn held_out(drawn: &DrawnCard, steady: &[Steady], count: usize) -> Result<CardHeldOut, CalibrateError> {
    let mut result = CardHeldOut { errors: Vec::new(), failed: Vec::new() };
    for fold in 0..count {
        let (out, stay): (Vec<_>, Vec<_>) = steady.iter().enumerate().partition(|(at, _)| at % count == fold);
        let stay: Vec<Steady> = stay.into_iter().map(|(_, steady)| steady.clone()).collect();
        let calibration = solve(drawn, &stay)?;
        for (_, steady) in out.into_iter().filter(|(_, steady)| steady.wind_m_s != [0.0; 3]) {
            match calibration.error(steady)? {
                Some(error) => result.errors.push(error),
                None => result.failed.push(steady.label.clone()),
            }
        }
    }
    Ok(result)
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / size)
}

impl std::fmt::Display for CardCalibration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} winds, Re {:.1} to {:.1}", self.winds, self.least_reynolds, self.most_reynolds)?;
        writeln!(
            f,
            "mean: {:.2} % of what the wind adds is left over; differences: {:.2} %, as Re^{:.3}",
            100.0 * self.mean_share,
            100.0 * self.difference_share,
            self.exponent
        )?;
        let seen = |degrees: f64| self.seen_at(degrees.to_radians());
        writeln!(
            f,
            "of the speed head-on the card sees {:.2} across and {:.2} in reverse",
            0.5 * (seen(90.0) + seen(-90.0)),
            seen(0.0)
        )?;
        let gains: Vec<String> = self.gains.iter().map(|gain| format!("{gain:.4}")).collect();
        writeln!(f, "gains {}; in still gas {:.4} mW/K", gains.join(", "), 1e3 * self.still_w_k)
    }
}

impl std::fmt::Display for CardHeldOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let all = self.overall();
        writeln!(
            f,
            "held out: {} winds, direction {:.2}° rms, {:.2}° at worst; speed {:.2} % rms, {:.2} % at worst",
            all.winds,
            all.direction_rms_deg,
            all.direction_worst_deg,
            100.0 * all.speed_rms,
            100.0 * all.speed_worst
        )?;
        if !self.failed.is_empty() {
            writeln!(f, "no direction: {}", self.failed.join(", "))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
