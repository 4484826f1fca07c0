//! The figure of a recording: wind, temperatures (`temperatures.rs`), powers and heater bits over
//! one time axis; of an anemometer its wind estimates as well, and estimates by themselves
//! (`wind.rs`).
//!
//! Everything is reduced to about one value a pixel, so that 100 000 ticks stay a picture of some
//! hundred kilobytes in which a single odd tick can still be seen. Charts for which the recording
//! has no columns are left out.

use anyhow::Context;

use super::columns::{SetPoint, VectorColumns, stretches};
use super::wind::WindEstimates;
use crate::engine::axis::extent;
use crate::engine::chart::{Chart, ChartFrame, Figure, Shading};
use crate::engine::colour::{Colour, INK, PALETTE, Pen, REFERENCE, STRETCHES};
use crate::engine::reduce::{BINS, Bin, MeanPower, bins, mean_power};
use crate::engine::trace::Trace;
use crate::engine::words::{brief, power_unit};
use anemometry::vector::length;
use recording::text::count;
use recording::{HEATER, POWER, Recording, STATE, TRUE_WIND};

/// Ticks of the close-up of the heater bits.
const CLOSE_UP: usize = 200;
/// Stretches of events; of more of them nothing but stripes would be seen.
const MOST_EVENTS: usize = 150;
/// Height of a row of bits, and of one of the close-up, mm.
const BIT_ROWS: [f64; 2] = [3.9, 3.4];
/// Height of the strip of events, mm.
const STRIP: f64 = 3.9;

/// The figure of a run, or of wind estimates alone.
///
/// # Errors
/// If the recording has none of the columns that can be drawn.
pub fn figure(recording: &Recording) -> anyhow::Result<Figure> {
    let run = RunCharts::of(recording)?;
    let estimates = WindEstimates::of(recording, run.time_s);
    let alone = estimates.as_ref().filter(|_| run.elements.is_empty());
    let mut charts: Vec<Chart> = Vec::new();
    if alone.is_none() {
        charts.extend(run.wind(estimates.as_ref()));
    }
    charts.extend(estimates.iter().flat_map(|estimates| estimates.charts(alone.is_some())));
    charts.extend([run.temperatures(), run.deviations(), run.powers()].into_iter().flatten());
    charts.extend(run.charge());
    let bits = run.heater_bits();
    charts.extend(bits.iter().map(|[whole, _]| whole.clone()));
    let last = charts.len().checked_sub(1).with_context(|| nothing(recording))?;
    let strip = run.over_time(&mut charts, last);
    let figure = Figure::new(run.title()).subtitle(run.subtitle(estimates.as_ref(), alone.is_some()));
    let over_time = strip.into_iter().chain(charts).chain(bits.map(|[_, close_up]| close_up));
    // A run shows errors only where its winds are too many for a time axis.
    let errors = estimates.iter().filter(|of| alone.is_some() || of.sweep().is_some()).flat_map(WindEstimates::errors);
    Ok(match alone.and_then(WindEstimates::sweep) {
        Some(_) => errors.fold(figure, Figure::row).stack(over_time),
        None => errors.fold(figure.stack(over_time), Figure::row),
    })
}

/// Refusal of a table that neither a run nor an anemometer makes.
fn nothing(recording: &Recording) -> String {
    let path = recording.path.display();
    format!("{path}: holds none of the columns that a run records, such as temperature_c_<element>")
}

/// A recording, and what all of its charts have in common.
pub struct RunCharts<'r> {
    pub recording: &'r Recording,
    pub time_s: &'r [f64],
    /// Ends of the time axis: to the end of the last tick.
    pub ends_s: (f64, f64),
    /// Name and pen.
    pub elements: Vec<(&'r str, Pen)>,
    /// Words, row and time.
    pub trips: Vec<(String, usize, f64)>,
    pub set_points: Vec<SetPoint>,
}

impl<'r> RunCharts<'r> {
    fn of(recording: &'r Recording) -> anyhow::Result<Self> {
        let time_s = recording.time_s()?;
        let whole = bins(time_s, |_| 0.0, 1).pop().with_context(|| nothing(recording))?;
        let ends_s = (whole.from_s, if whole.to_s > whole.from_s { whole.to_s } else { whole.from_s + 1.0 });
        let states = stretches(recording.words(STATE).ok()).into_iter();
        let trip = |(row, _, state): (usize, usize, &str)| {
            Some((state.strip_prefix("tripped:")?.replacen(':', ", ", 1), row, time_s[row.min(time_s.len() - 1)]))
        };
        let trips: Vec<_> = states.filter_map(trip).collect();
        let set_points = SetPoint::of(recording, trips.first().map_or(f64::INFINITY, |(_, _, time_s)| *time_s));
        Ok(Self { recording, time_s, ends_s, elements: elements(recording), trips, set_points })
    }

    pub fn numbers(&self, prefix: &str, element: &str) -> Option<&'r [f64]> {
        // The hyphens of a table of one's own stay.
        let names = [recording::column_name(prefix, element), format!("{prefix}{element}")];
        names.iter().find_map(|name| self.recording.numbers(name).ok())
    }

    pub fn bins(&self, values: impl Fn(usize) -> f64) -> Vec<Bin> {
        bins(self.time_s, values, BINS)
    }

    fn title(&self) -> String {
        self.recording.metadata("title").map_or_else(|| self.recording.path.display().to_string(), str::to_owned)
    }

    fn subtitle(&self, estimates: Option<&WindEstimates<'_>>, alone: bool) -> String {
        let of = |key| self.recording.metadata(key);
        let (rows, elements) = (self.time_s.len(), self.elements.len());
        let head = of("head_name").map(|head| format!("head {head}"));
        let mut parts: Vec<String> =
            head.or_else(|| (elements > 0).then(|| count(elements, "element"))).into_iter().collect();
        parts.extend(of("firmware").map(str::to_owned));
        if alone && estimates.is_some() {
            parts.push(format!("{rows} wind estimates"));
            parts.extend(
                estimates
                    .and_then(WindEstimates::sweep)
                    .map(|winds| format!("{winds} winds, means of their second halves")),
            );
            parts.extend(of("bandwidth_hz").map(|bandwidth_hz| format!("bandwidth {bandwidth_hz} Hz")));
        } else {
            parts.push(format!("{rows} ticks"));
        }
        parts.extend(of("lost").filter(|lost| *lost != "0").map(|lost| format!("{lost} lost")));
        parts.extend(of("hash").map(|hash| format!("hash {hash}")));
        parts.join("  ·  ")
    }

    /// Puts charts over the time axis, which is labelled under the `last` one, with events and
    /// trips; returns the strip of the events.
    fn over_time(&self, charts: &mut [Chart], last: usize) -> Option<Chart> {
        let (start_s, end_s) = self.ends_s;
        let time = |row: usize| self.time_s.get(row).copied().unwrap_or(end_s);
        let events = stretches(self.recording.events()).into_iter();
        let events: Vec<(f64, f64, &str)> = events.map(|(from, to, word)| (time(from), time(to), word)).collect();
        let events = if events.iter().any(|(_, _, word)| !word.is_empty()) { events } else { Vec::new() };
        let is_crowded = events.len() > MOST_EVENTS;
        let stretches = || events.iter().zip(STRETCHES.iter().cycle()).filter(|_| !is_crowded);
        for (i, chart) in charts.iter_mut().enumerate() {
            (chart.x_range, chart.x_labels) = (Some(self.ends_s), i == last);
            let ground =
                stretches().map(|(&(from, to, _), colour)| Shading::new(from, to, colour.with_opacity(0.3), ""));
            chart.shadings.extend(ground);
            let words = |words: &String| if i == 0 { format!("tripped: {words}") } else { String::new() };
            chart.marks = self.trips.iter().map(|(trip, _, time_s)| (*time_s, words(trip))).collect();
        }
        let (first, last) = (events.first()?, events.last()?);
        let mut strip = Chart::new("", "").height(STRIP).bare().x_range(start_s, end_s);
        strip.x_labels = false;
        strip.shadings = stretches().map(|(&(from, to, word), colour)| Shading::new(from, to, *colour, word)).collect();
        if is_crowded {
            let words = format!("{} conditions, “{}” to “{}”", events.len(), first.2, last.2);
            strip.shadings = vec![Shading::new(start_s, end_s, STRETCHES[0], words)];
        }
        Some(strip)
    }

    /// The true wind, or the wind estimates over it.
    fn wind(&self, estimates: Option<&WindEstimates<'_>>) -> Option<Chart> {
        let truth = VectorColumns::of(self.recording, TRUE_WIND).map_or_else(Vec::new, |wind| {
            let axes = ["x", "y", "z"].into_iter().zip(PALETTE).zip(wind.0);
            let axes = axes.map(|((label, colour), of)| (label, colour, self.bins(|row| of[row])));
            axes.chain([("speed", INK, self.bins(|row| length(wind.at(row))))]).collect()
        });
        let line = |(label, colour, bins): &(&str, Colour, Vec<Bin>)| {
            Trace::bins(*label, bins.clone()).painted(*colour).width(if *label == "speed" { 0.9 } else { 0.7 })
        };
        let extremes = truth.iter().flat_map(|(_, _, bins)| bins).flat_map(|bin| [bin.least, bin.most]);
        let chart = Chart::new("Wind", "m/s");
        let Some(components) = estimates.map(WindEstimates::components) else {
            let lines = truth.iter().map(|of| line(of).band(0.18));
            let chart = chart.note("into which it blows").height(25.0).around(extremes.chain([0.0])).traces(lines);
            return (!truth.is_empty()).then_some(chart);
        };
        let under = truth.iter().map(|(label, colour, bins)| {
            let known = components.iter().any(|(component, ..)| component == label);
            let label = if known { String::new() } else { format!("true {label}") };
            Trace::pale(label, bins.clone(), colour.paler())
        });
        let over = components.iter().map(|of| line(of).band(0.15));
        // Transients of the first estimates would hide the wind.
        let means = components.iter().filter(|_| truth.is_empty()).flat_map(|(_, _, bins)| bins).map(|bin| bin.mean);
        let note = match truth.is_empty() {
            true => "into which it blows, as estimated",
            false => "into which it blows; estimates over the true wind, which is wide and pale",
        };
        let chart = chart.note(note).height(34.0).around(extremes.chain(means).chain([0.0]));
        Some(chart.traces(under.chain(over)))
    }

    fn powers(&self) -> Option<Chart> {
        self.decimated(POWER, self.elements.iter().copied(), |least_w, greatest_w| {
            let (factor, unit) = power_unit(greatest_w.max(-least_w));
            (Chart::new("Heating power", unit).height(34.0), factor)
        })
    }

    /// Columns decimated to what a picture shows. `chart` makes the chart from the least and the
    /// greatest value, and returns the factor of all values.
    pub fn decimated<'n>(
        &self,
        prefix: &str,
        names: impl Iterator<Item = (&'n str, Pen)>,
        chart: impl FnOnce(f64, f64) -> (Chart, f64),
    ) -> Option<Chart> {
        let mean = |(name, pen)| Some((name, pen, mean_power(self.time_s, self.numbers(prefix, name)?, BINS)?));
        let means: Vec<(&str, Pen, MeanPower)> = names.filter_map(mean).collect();
        let step_s = (self.time_s.last()? - self.time_s.first()?) / (self.time_s.len().max(2) - 1) as f64;
        let window_s = f64::from(means.first()?.2.ratio) * step_s;
        let all = means.iter().flat_map(|(.., mean)| &mean.power_w).copied();
        let (least, greatest) = extent(all.chain([0.0]))?;
        let (chart, factor) = chart(least, greatest);
        let line = |(name, pen, mean): (&str, Pen, MeanPower)| {
            let values = mean.power_w.into_iter().map(|value| value * factor);
            Trace::line(name, mean.time_s.into_iter().zip(values).collect()).painted(pen)
        };
        let chart = chart.range(least * factor, greatest * factor);
        let chart = chart.note(format!("decimated to one value in {} s", brief(window_s)));
        Some(chart.first_on_top(means.into_iter().map(line)))
    }

    /// A row an element: the share of ticks at the high level over the whole run, and every single
    /// bit of a short stretch.
    fn heater_bits(&self) -> Option<[Chart; 2]> {
        let bits =
            self.elements.iter().filter_map(|&(name, pen)| Some((name, pen.colour, self.numbers(HEATER, name)?)));
        let bits: Vec<(&str, Colour, &[f64])> = bits.collect();
        let rows = self.close_up();
        let near_s = &self.time_s[rows.clone()];
        let [whole, near] = BIT_ROWS;
        let of_all = bits.iter().map(|&(name, colour, bits)| (name.to_owned(), colour, self.bins(|row| bits[row])));
        let of_few = bits.iter().map(|&(name, colour, bits)| {
            (name.to_owned(), colour, bins(near_s, |row| bits[rows.start + row], rows.len()))
        });
        let all = Chart::new("Heater bits", "").note("share of ticks at the high level").bars(of_all, whole);
        let mut few = Chart::new(format!("every bit of {} ticks", rows.len()), "").bars(of_few, near);
        few.frame = ChartFrame::CloseUp;
        let near = &few.traces.first()?.bins;
        few.x_range = Some((near.first()?.from_s, near.last()?.to_s));
        Some([all, few])
    }

    /// Rows of the close-up: around the first trip, or else from the middle of the run's second
    /// half, where it has settled.
    fn close_up(&self) -> std::ops::Range<usize> {
        let rows = self.time_s.len();
        let length = CLOSE_UP.min(rows);
        let around = self.trips.first().map(|(_, row, _)| row.saturating_sub(length / 2));
        let from = around.unwrap_or(rows * 3 / 4).min(rows - length);
        from..from + length
    }
}

/// The elements of a recording with their pens.
fn elements(recording: &Recording) -> Vec<(&str, Pen)> {
    // Ink and grey.
    let mut cores = (6..8).cycle();
    let pen = |(i, name): (usize, &str)| match name {
        recording::REFERENCE => REFERENCE.into(),
        core if core.starts_with("core") => Pen::numbered(cores.next().unwrap_or_default()),
        _ => Pen::numbered(i),
    };
    let names = recording.elements();
    let pens: Vec<Pen> = names.iter().copied().enumerate().map(pen).collect();
    names.into_iter().zip(pens).collect()
}
