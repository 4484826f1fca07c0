//! What an anemometer says of the wind, reduced to what a picture can hold, and its panels.
//!
//! | panel | answer | truth, where it is known |
//! |---|---|---|
//! | speed | mean, band of ± one standard error of a single answer | wide and pale behind it |
//! | azimuth, elevation | of where the wind goes to, likewise; gaps where there is no direction | likewise |
//! | angle to the axis | in place of both, for heads with one axis | likewise |
//! | conductances | of the parts | raw ones pale behind them |
//! | gas | temperature as the anemometer knows it, where it changes | wide and pale |
//! | doubts | a row each: the share of answers that have it | |

mod angle;
mod panels;

use dr_core::control::Doubts;
use plotters::style::RGBColor;

pub use panels::{draw, drawn_over};

use super::content::{BINS, Curve};
use super::draw::{INK, PALETTE, shade};
use super::reduce::{Bin, bins};
use crate::recording::answer::{ANSWER as COMPONENTS, ANSWER_DOUBTS, ANSWER_SPEED, CONDUCTANCE, RAW_CONDUCTANCE};
use crate::recording::{GAS_TEMPERATURE, Recording, WIND};

/// A gas that stays within so many kelvin is not drawn.
const STEADY_GAS_K: f64 = 0.2;
/// Slower truths have no direction, m/s.
const STILL_M_S: f64 = 1e-3;

/// A panel of answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Speed,
    Azimuth,
    Elevation,
    Angle,
    Conductances,
    Gas,
    Doubts,
}

/// A quantity with its standard error and its truth.
pub struct Quantity {
    pub answer: Vec<Bin>,
    /// Standard error of a single answer, by bin.
    pub error: Vec<f64>,
    pub truth: Option<Vec<Bin>>,
}

/// All that is drawn of the answers of a recording.
pub struct Answer {
    /// The vector and its speed; of a head with one axis the speed alone.
    pub components: Vec<Curve>,
    pub speed: Quantity,
    /// Angles, °.
    pub azimuth: Option<Quantity>,
    pub elevation: Option<Quantity>,
    pub angle: Option<Quantity>,
    /// W/K.
    pub conductances: Vec<Curve>,
    pub raw: Vec<Curve>,
    pub gas: Option<(Curve, Option<Vec<Bin>>)>,
    /// Those that occur, with the share of answers that have them.
    pub doubts: Vec<(&'static str, Vec<Bin>)>,
}

impl Answer {
    /// None where a recording has no answers.
    pub fn of(recording: &Recording, time_s: &[f64], elements: &[(&str, RGBColor)]) -> Option<Self> {
        let numbers = |name: &str| recording.numbers(name).ok();
        let (doubts, speed_m_s) = (numbers(ANSWER_DOUBTS)?, numbers(ANSWER_SPEED)?);
        let [x, y, z] = COMPONENTS.map(numbers);
        let vector = [x?, y?, z?];
        // Most ticks have no answer; what follows counts answers.
        let rows: Vec<usize> = (0..doubts.len()).filter(|&row| doubts[row].is_finite()).collect();
        let times: Vec<f64> = rows.iter().map(|&row| time_s[row]).collect();
        if rows.is_empty() {
            return None;
        }
        let reduced = |values: &dyn Fn(usize) -> f64| bins(&times, |i| values(rows[i]), BINS);
        let curve = |label: &str, colour, values: &dyn Fn(usize) -> f64| Curve {
            label: label.to_owned(),
            colour,
            bins: reduced(values),
        };
        let errors = |name: &str| {
            let means = |column: &[f64]| reduced(&|row| column[row]).iter().map(|bin| bin.mean).collect();
            numbers(name).map(means).unwrap_or_default()
        };

        let truth = match WIND.map(numbers) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]).filter(|[x, ..]| rows.iter().any(|&row| x[row].is_finite())),
            _ => None,
        };
        let length = |[x, y, z]: [&[f64]; 3], row: usize| (x[row] * x[row] + y[row] * y[row] + z[row] * z[row]).sqrt();
        let speed = Quantity {
            answer: reduced(&|row| speed_m_s[row]),
            error: errors("answer_speed_error_m_s"),
            truth: truth.map(|wind| reduced(&|row| length(wind, row))),
        };

        let axis = axis(recording);
        let lacking =
            Doubts::FAILED.0 | Doubts::NO_DIRECTION.0 | if axis.is_none() { Doubts::UNDETERMINED.0 } else { 0 };
        let is_told = |row: usize| doubts[row] as u16 & lacking == 0 && speed_m_s[row] > 0.0;
        let true_wind =
            |row: usize| truth.filter(|&wind| length(wind, row) > STILL_M_S).map(|wind| wind.map(|of| of[row]));
        let told = |row: usize| is_told(row).then(|| vector.map(|of| of[row]));
        let direction_error = errors("answer_direction_error_deg");
        let (mut azimuth, mut elevation, mut angle) = (None, None, None);
        if let Some(axis) = axis {
            let of = |along: f64, speed: f64| (along / speed).clamp(-1.0, 1.0).acos().to_degrees();
            let dot = |[x, y, z]: [f64; 3]| x * axis[0] + y * axis[1] + z * axis[2];
            let from_truth = |row: usize| true_wind(row).map_or(f64::NAN, |wind| of(dot(wind), size(wind)));
            angle = Some(Quantity {
                answer: reduced(&|row| told(row).map_or(f64::NAN, |wind| of(dot(wind), speed_m_s[row]))),
                error: direction_error,
                truth: truth.map(|_| reduced(&from_truth)),
            });
        } else {
            let upwards = |wind: Option<[f64; 3]>| {
                wind.map_or(f64::NAN, |wind| (wind[2] / size(wind)).clamp(-1.0, 1.0).asin().to_degrees())
            };
            let up = Quantity {
                answer: reduced(&|row| upwards(told(row))),
                error: direction_error.clone(),
                truth: truth.map(|_| reduced(&|row| upwards(true_wind(row)))),
            };
            // The same error on the sphere is a greater one of the azimuth towards the poles.
            let widened = up
                .answer
                .iter()
                .zip(&direction_error)
                .map(|(up, error)| (error / up.mean.to_radians().cos().max(1e-3)).min(180.0));
            azimuth = Some(Quantity {
                answer: angle::azimuths(&times, |i| told(rows[i]), BINS),
                error: widened.collect(),
                truth: truth.map(|_| angle::azimuths(&times, |i| true_wind(rows[i]), BINS)),
            });
            elevation = Some(up);
        }

        let colour = |name: &str, i: usize| {
            let known = elements.iter().find(|(element, _)| *element == name);
            known.map_or(shade(PALETTE[i % PALETTE.len()], i / PALETTE.len()), |(_, colour)| *colour)
        };
        let of_parts = |prefix: &str| {
            let columns = recording.columns.iter().filter_map(|column| column.name.strip_prefix(prefix));
            let curve = |(i, part): (usize, &str)| {
                numbers(&format!("{prefix}{part}")).map(|of| curve(part, colour(part, i), &|row| of[row]))
            };
            columns.enumerate().filter_map(curve).collect::<Vec<_>>()
        };
        let gas = numbers("answer_gas_c").map(|gas_c| curve("gas", INK, &|row| gas_c[row]));
        let gas = gas.filter(|gas| changes(&gas.bins)).map(|gas| {
            let truth = numbers(GAS_TEMPERATURE).map(|true_c| reduced(&|row| true_c[row]));
            (gas, truth.filter(|bins| bins.iter().any(|bin| bin.mean.is_finite())))
        });
        let has = |doubt: Doubts| move |row: usize| if doubts[row] as u16 & doubt.0 != 0 { 1.0 } else { 0.0 };
        let occurring = Doubts::NAMES.into_iter().filter(|(doubt, _)| rows.iter().any(|&row| has(*doubt)(row) > 0.0));
        let mut components = Vec::new();
        if axis.is_none() {
            for (label, colour, of) in [("x", PALETTE[0], 0), ("y", PALETTE[1], 1), ("z", PALETTE[2], 2)] {
                components.push(curve(label, colour, &|row| vector[of][row]));
            }
        }
        components.push(curve("speed", INK, &|row| speed_m_s[row]));
        Some(Self {
            components,
            speed,
            azimuth,
            elevation,
            angle,
            conductances: of_parts(CONDUCTANCE),
            raw: of_parts(RAW_CONDUCTANCE),
            gas,
            doubts: occurring.map(|(doubt, name)| (name, reduced(&has(doubt)))).collect(),
        })
    }

    /// Its panels with their heights: all of them, or those that a run has beside its own.
    pub fn parts(&self, alone: bool) -> Vec<(Part, f64)> {
        let doubts = 20.0 * self.doubts.len().max(1) as f64;
        let all = [
            (Part::Speed, 170.0, alone),
            (Part::Azimuth, 130.0, alone && self.azimuth.is_some()),
            (Part::Elevation, 110.0, alone && self.elevation.is_some()),
            (Part::Angle, 130.0, self.angle.is_some()),
            (Part::Conductances, 170.0, alone && !self.conductances.is_empty()),
            (Part::Gas, 90.0, alone && self.gas.is_some()),
            (Part::Doubts, doubts, true),
        ];
        all.into_iter().filter(|(_, _, wanted)| *wanted).map(|(part, height, _)| (part, height)).collect()
    }
}

fn size([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

fn changes(bins: &[Bin]) -> bool {
    let of = |pick: fn(f64, f64) -> f64| bins.iter().map(|bin| bin.mean).fold(f64::NAN, pick);
    of(f64::max) - of(f64::min) > STEADY_GAS_K
}

/// The axis of a head of two hemispheres, which tells one angle only; none for others.
fn axis(recording: &Recording) -> Option<[f64; 3]> {
    let head: toml::Table = recording.metadata("head")?.parse().ok()?;
    let parts = head.get("calibration")?.get("parts")?.as_array()?;
    let [first, _] = parts.as_slice() else { return None };
    let axis: Vec<f64> = first.get("axis")?.as_array()?.iter().filter_map(toml::Value::as_float).collect();
    let axis: [f64; 3] = axis.try_into().ok()?;
    let length = size(axis);
    (length > 0.0).then(|| axis.map(|of| of / length))
}
