//! What there is to draw of a recording, reduced to what a picture can hold.

use plotters::style::RGBColor;

use super::PlotError;
use super::draw::{GREYS, INK, PALETTE};
use super::reduce::{Bin, bins, mean_power};
use crate::recording::{HEATER, POWER, Recording, STATE, TEMPERATURE, WIND};

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
    /// Element, set-point in °C, from the experiment.
    pub set_points: Vec<(String, f64)>,
    pub deviations: Vec<Curve>,
    pub powers: Vec<Power>,
    pub power_window_s: f64,
    pub heaters: Vec<(&'r str, RGBColor, &'r [f64])>,
    /// Label, from, to.
    pub events: Vec<(String, f64, f64)>,
    /// Words, row, when.
    pub trips: Vec<(String, usize, f64)>,
}

impl<'r> Content<'r> {
    pub fn of(recording: &'r Recording) -> Result<Self, PlotError> {
        let time_s = recording.time_s()?;
        let column = |prefix: &str, element: &str| recording.numbers(&format!("{prefix}{element}")).ok();
        let mut cores = 0;
        let elements: Vec<_> = (recording.elements().into_iter().enumerate())
            .map(|(i, name)| {
                let colour = if name.starts_with("core") {
                    cores += 1;
                    GREYS[(cores - 1) % GREYS.len()]
                } else {
                    PALETTE[i % PALETTE.len()]
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
        let set_points = set_points(recording);
        let (mut temperatures, mut deviations, mut powers, mut heaters) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut power_window_s = 0.0;
        for &(name, colour) in &elements {
            if let Some(temperature_c) = column(TEMPERATURE, name) {
                temperatures.push(curve(name, colour, &|row| temperature_c[row]));
                if let Some((_, set_point_c)) = set_points.iter().find(|(element, _)| element == name) {
                    // Warming up is another story, and so is cooling down after a trip.
                    let arrival = temperature_c.iter().position(|celsius| celsius >= set_point_c).unwrap_or(usize::MAX);
                    let held = arrival..running_until;
                    let deviation = |row: usize| {
                        if held.contains(&row) { (temperature_c[row] - set_point_c) * 1e3 } else { f64::NAN }
                    };
                    deviations.push(curve(name, colour, &deviation));
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

        let events = recording
            .events()
            .map(|words| words.stretches().map(|(from, to, word)| (word.to_owned(), start(from), start(to))));
        Ok(Self {
            recording,
            time_s,
            elements,
            wind,
            temperatures,
            set_points,
            deviations,
            powers,
            power_window_s,
            heaters,
            events: events.into_iter().flatten().collect(),
            trips,
        })
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

/// Constant set-points, read from the experiment that the recording carries.
fn set_points(recording: &Recording) -> Vec<(String, f64)> {
    let table = recording.metadata("experiment").and_then(|text| text.parse::<toml::Table>().ok());
    let drives = table.as_ref().and_then(|table| table.get("drives")?.as_table());
    let set_point =
        |(element, drive): (&String, &toml::Value)| Some((element.clone(), drive.get("temperature_c")?.as_float()?));
    drives.into_iter().flatten().filter_map(set_point).collect()
}
