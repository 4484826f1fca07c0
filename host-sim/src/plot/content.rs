//! What there is to draw of a recording, reduced to what a picture can hold.

use plotters::style::RGBColor;

use super::PlotError;
use super::answer::Answer;
use super::draw::{GAS, GREYS, INK, PALETTE, REFERENCE, shade};
use super::reduce::{Bin, bins, mean_power};
use super::set_points::SetPoint;
use crate::recording::{GAS_TEMPERATURE, HEATER, POWER, Recording, STATE, TEMPERATURE, WIND};

/// Bins over the width of a panel, some more than a pixel each.
pub const BINS: usize = 730;
/// Values of a decimated power.
const POWERS: usize = 730;
/// Ticks of the close-up of the heater bits.
const CLOSE_UP: usize = 200;

/// A curve of a panel.
pub struct Curve {
    pub label: String,
    pub colour: RGBColor,
    pub bins: Vec<Bin>,
}

/// A decimated power: time in s, power in W.
pub struct Power {
    pub label: String,
    pub colour: RGBColor,
    pub points: Vec<(f64, f64)>,
}

/// What there is to draw, reduced.
pub struct Content<'r> {
    pub recording: &'r Recording,
    pub time_s: &'r [f64],
    /// Name, colour.
    pub elements: Vec<(&'r str, RGBColor)>,
    pub wind: Vec<Curve>,
    pub temperatures: Vec<Curve>,
    /// True temperature of the gas, where it swings.
    pub gas: Option<Curve>,
    /// From the experiment.
    pub set_points: Vec<SetPoint>,
    pub deviations: Vec<Curve>,
    pub powers: Vec<Power>,
    pub power_window_s: f64,
    pub heaters: Vec<(&'r str, RGBColor, &'r [f64])>,
    /// Label, from, to.
    pub events: Vec<(String, f64, f64)>,
    /// Words, row, when.
    pub trips: Vec<(String, usize, f64)>,
    /// What the anemometer says, where it does.
    pub answer: Option<Answer>,
}

impl<'r> Content<'r> {
    pub fn of(recording: &'r Recording) -> Result<Self, PlotError> {
        let time_s = recording.time_s()?;
        let column = |prefix: &str, element: &str| recording.numbers(&format!("{prefix}{element}")).ok();
        let mut cores = 0;
        let elements: Vec<_> = (recording.elements().into_iter().enumerate())
            .map(|(i, name)| {
                let colour = if name == crate::sensor::reference::NAME {
                    REFERENCE
                } else if name.starts_with("core") {
                    cores += 1;
                    GREYS[(cores - 1) % GREYS.len()]
                } else {
                    shade(PALETTE[i % PALETTE.len()], i / PALETTE.len())
                };
                (name, colour)
            })
            .collect();
        let curve = |label: &str, colour, values: &dyn Fn(usize) -> f64| Curve {
            label: label.to_owned(),
            colour,
            bins: bins(time_s, values, BINS),
        };

        let components: Vec<_> = WIND.iter().filter_map(|name| recording.numbers(name).ok()).collect();
        let mut wind = Vec::new();
        if let &[x, y, z] = components.as_slice() {
            for (label, colour, component) in [("x", PALETTE[0], x), ("y", PALETTE[1], y), ("z", PALETTE[2], z)] {
                wind.push(curve(label, colour, &|row| component[row]));
            }
            wind.push(curve("speed", INK, &|row| (x[row] * x[row] + y[row] * y[row] + z[row] * z[row]).sqrt()));
        }

        let start = |row: usize| time_s.get(row).copied().unwrap_or(time_s[time_s.len() - 1]);
        let states = recording.words(STATE).ok().into_iter().flat_map(|words| words.stretches().collect::<Vec<_>>());
        let trips: Vec<_> = states
            .filter_map(|(from, _, state)| {
                Some((state.strip_prefix("tripped:")?.replacen(':', ", ", 1), from, start(from)))
            })
            .collect();
        let running_until = trips.first().map_or(usize::MAX, |(_, row, _)| *row);
        let set_points = SetPoint::of(recording, trips.first().map_or(f64::INFINITY, |(_, _, time_s)| *time_s));
        let (mut temperatures, mut deviations, mut powers, mut heaters) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut power_window_s = 0.0;
        for &(name, colour) in &elements {
            if let Some(temperature_c) = column(TEMPERATURE, name) {
                temperatures.push(curve(name, colour, &|row| temperature_c[row]));
                let held: Vec<_> = set_points
                    .iter()
                    .filter(|of| of.element == name)
                    .map(|of| (held(of, time_s, temperature_c, running_until), of.celsius))
                    .collect();
                if !held.is_empty() {
                    let deviation = |row: usize| {
                        let now = held.iter().find(|(rows, _)| rows.contains(&row));
                        now.map_or(f64::NAN, |(_, celsius)| (temperature_c[row] - celsius) * 1e3)
                    };
                    let curve = curve(name, colour, &deviation);
                    // Elements that never arrived have nothing to show.
                    deviations.extend(curve.bins.iter().any(|bin| bin.mean.is_finite()).then_some(curve));
                }
            }
            if let Some(mean) = column(POWER, name).and_then(|power_w| mean_power(time_s, power_w, POWERS)) {
                let step_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len().max(2) - 1) as f64;
                power_window_s = f64::from(mean.ratio) * step_s;
                let points = mean.time_s.into_iter().zip(mean.power_w).collect();
                powers.push(Power { label: name.to_owned(), colour, points });
            }
            heaters.extend(column(HEATER, name).map(|bits| (name, colour, bits)));
        }

        let gas = recording.numbers(GAS_TEMPERATURE).ok().map(|gas_c| curve("gas", GAS, &|row| gas_c[row]));
        let events = recording
            .events()
            .map(|words| words.stretches().map(|(from, to, word)| (word.to_owned(), start(from), start(to))));
        let answer = Answer::of(recording, time_s, &elements);
        Ok(Self {
            answer,
            recording,
            time_s,
            elements,
            wind,
            temperatures,
            gas,
            set_points,
            deviations,
            powers,
            power_window_s,
            heaters,
            events: events.into_iter().flatten().collect(),
            trips,
        })
    }

    /// Whether there are answers and nothing of the instrument that gave them: what `anemo wind` makes.
    pub fn is_of_answers(&self) -> bool {
        self.answer.is_some() && self.elements.is_empty()
    }

    /// Rows of the close-up: around the first trip, or else from the middle of the run's second half, where it has settled.
    pub fn close_up(&self) -> std::ops::Range<usize> {
        let rows = self.time_s.len();
        let length = CLOSE_UP.min(rows);
        let from =
            self.trips.first().map_or(rows * 3 / 4, |(_, row, _)| row.saturating_sub(length / 2)).min(rows - length);
        from..from + length
    }
}

/// Rows in which an element is held at a set-point: from its arrival there, from below or above, until it is told something else.
///
/// Warming up is another story, and so is cooling down after a trip.
fn held(of: &SetPoint, time_s: &[f64], temperature_c: &[f64], running_until: usize) -> std::ops::Range<usize> {
    // A change belongs to the tick that starts with it, whatever the last digits of its time.
    let row_at = |moment_s: f64| time_s.partition_point(|row_s| *row_s < moment_s - 1e-6);
    let (from, to) = (row_at(of.from_s), row_at(of.to_s).min(running_until));
    let told = temperature_c.get(from..to).unwrap_or_default();
    let from_below = told.iter().find(|celsius| celsius.is_finite()).is_some_and(|celsius| *celsius < of.celsius);
    let there = |celsius: &f64| if from_below { *celsius >= of.celsius } else { *celsius <= of.celsius };
    let arrival = told.iter().position(there).map_or(to, |row| from + row);
    arrival..to
}
