//! The figure of a recording: wind, temperatures, powers and heater bits over one time axis; of an
//! anemometer its wind estimates as well, and estimates by themselves (`wind.rs`).
//!
//! Everything is reduced to about one value a pixel, so that 100 000 ticks stay a picture of some
//! hundred kilobytes in which a single odd tick can still be seen. Charts for which the recording
//! has no columns are left out.

use super::columns::{VectorColumns, stretches};
use super::set_points::SetPoint;
use super::wind::WindEstimates;
use crate::engine::chart::{Chart, ChartFrame, Figure, Shading};
use crate::engine::colour::{Colour, GAS, INK, PALETTE, QUIET, REFERENCE, STRETCHES};
use crate::engine::extent::extent;
use crate::engine::pen::Pen;
use crate::engine::reduce::{BINS, Bin, MeanPower, bins, mean_power, reach};
use crate::engine::trace::{CURVE, Trace};
use crate::engine::words::{brief, power_unit};
use crate::error::PlotError;
use anemometry::vector::length;
use recording::{GAS_TEMPERATURE, HEATER, POWER, Recording, STATE, TEMPERATURE, TRUE_WIND};

/// Ticks of the close-up of the heater bits.
const CLOSE_UP: usize = 200;
/// Dashed lines of set-points; more of them would be all that is seen.
const MOST_SET_POINTS: usize = 40;
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
pub fn figure(recording: &Recording) -> Result<Figure, PlotError> {
    let run = RunCharts::of(recording)?;
    let estimates = WindEstimates::of(recording, run.time_s);
    let alone = estimates.as_ref().filter(|_| run.elements.is_empty());
    let mut charts: Vec<Chart> = Vec::new();
    if alone.is_none() {
        charts.extend(run.wind(estimates.as_ref()));
    }
    charts.extend(estimates.iter().flat_map(|estimates| estimates.charts(alone.is_some())));
    charts.extend([run.temperatures(), run.deviations(), run.powers()].into_iter().flatten());
    let bits = run.heater_bits();
    charts.extend(bits.iter().map(|[whole, _]| whole.clone()));
    let Some(last) = charts.len().checked_sub(1) else { return Err(PlotError::Nothing(recording.path.clone())) };
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

/// A recording, and what all of its charts have in common.
struct RunCharts<'r> {
    recording: &'r Recording,
    time_s: &'r [f64],
    /// Of the time axis: to the end of the last tick.
    ends_s: (f64, f64),
    /// Name and pen.
    elements: Vec<(&'r str, Pen)>,
    /// Words, row and time.
    trips: Vec<(String, usize, f64)>,
    set_points: Vec<SetPoint>,
}

impl<'r> RunCharts<'r> {
    fn of(recording: &'r Recording) -> Result<Self, PlotError> {
        let time_s = recording.time_s()?;
        let Some(whole) = bins(time_s, |_| 0.0, 1).pop() else {
            return Err(PlotError::Nothing(recording.path.clone()));
        };
        let ends_s = (whole.from_s, if whole.to_s > whole.from_s { whole.to_s } else { whole.from_s + 1.0 });
        let states = stretches(recording.words(STATE).ok()).into_iter();
        let trip = |(row, _, state): (usize, usize, &str)| {
            Some((state.strip_prefix("tripped:")?.replacen(':', ", ", 1), row, time_s[row.min(time_s.len() - 1)]))
        };
        let trips: Vec<_> = states.filter_map(trip).collect();
        let set_points = SetPoint::of(recording, trips.first().map_or(f64::INFINITY, |(_, _, time_s)| *time_s));
        Ok(Self { recording, time_s, ends_s, elements: elements(recording), trips, set_points })
    }

    fn numbers(&self, prefix: &str, element: &str) -> Option<&'r [f64]> {
        self.recording.numbers(&recording::column_name(prefix, element)).ok()
    }

    fn bins(&self, values: impl Fn(usize) -> f64) -> Vec<Bin> {
        bins(self.time_s, values, BINS)
    }

    fn title(&self) -> String {
        self.recording.metadata("title").map_or_else(|| self.recording.path.display().to_string(), str::to_owned)
    }

    fn subtitle(&self, estimates: Option<&WindEstimates<'_>>, alone: bool) -> String {
        let of = |key| self.recording.metadata(key);
        let (rows, elements) = (self.time_s.len(), self.elements.len());
        let mut parts =
            vec![of("head_name").map_or_else(|| format!("{elements} elements"), |head| format!("head {head}"))];
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

    fn temperatures(&self) -> Option<Chart> {
        let line = |&(name, pen): &(&str, Pen)| {
            let temperature_c = self.numbers(TEMPERATURE, name)?;
            Some(Trace::bins(name, self.bins(|row| temperature_c[row])).painted(pen).band(0.12))
        };
        let lines: Vec<Trace> = self.elements.iter().filter_map(line).collect();
        if lines.is_empty() {
            return None;
        }
        // Wide and beneath: what measures the gas lies on it.
        let gas = self.recording.numbers(GAS_TEMPERATURE).ok().map(|gas_c| self.bins(|row| gas_c[row]));
        let gas = gas.map(|bins| Trace::bins("gas", bins).painted(GAS).width(3.0 * CURVE).band(0.0));
        // Most elements share their set-points; one line does for them.
        let (start_s, end_s) = self.ends_s;
        let mut held: Vec<(f64, f64, f64)> = Vec::new();
        for of in &self.set_points {
            let line = (of.from_s.clamp(start_s, end_s), of.to_s.clamp(start_s, end_s), of.celsius);
            if !held.contains(&line) {
                held.push(line);
            }
        }
        let mut distinct: Vec<f64> = self.set_points.iter().map(|of| of.celsius).collect();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        let chart = Chart::new("Temperature", "°C").height(25.0);
        let chart = match distinct.as_slice() {
            [] => chart,
            [one] => chart.note(format!("set-point {}", one.to_string().replace('-', "−"))),
            _ => chart.note("set-points dashed"),
        };
        held.truncate(MOST_SET_POINTS);
        let arrived_s = self.arrived_s();
        let kept = |trace: &&Trace| trace.bins.iter().any(|bin| bin.mean.is_finite());
        let after = |bin: &&Bin| arrived_s.is_none_or(|arrived_s| bin.from_s >= arrived_s);
        let settled = lines.iter().chain(&gas).filter(kept).flat_map(|trace| trace.bins.iter().filter(after));
        let settled: Vec<f64> = settled.flat_map(|bin| [bin.least, bin.most]).chain(distinct).collect();
        let whole = extent(lines.iter().flat_map(|trace| trace.bins.iter().map(|bin| bin.least)));
        // A tenth of the range is air.
        let leaves =
            |least: &f64| extent(settled.iter().copied()).is_some_and(|(low, high)| *least < low - 0.1 * (high - low));
        let chart = match arrived_s.and(whole).map(|(least, _)| least).filter(leaves) {
            Some(least) => chart.around(settled).note(format!("the warm-up from {} °C leaves the panel", brief(least))),
            None => chart,
        };
        let held = held.into_iter().map(|(from_s, to_s, celsius)| Trace::held(from_s, to_s, celsius));
        Some(chart.first_on_top(lines.into_iter().chain(gas).chain(held)))
    }

    /// The row of the first trip, after which nothing is held.
    fn running_until(&self) -> usize {
        self.trips.first().map_or(usize::MAX, |(_, row, _)| *row)
    }

    /// When the last element that arrives at its first set-point does so.
    fn arrived_s(&self) -> Option<f64> {
        let arrived = |&(name, _): &(&str, Pen)| {
            let temperature_c = self.numbers(TEMPERATURE, name)?;
            let first = self.set_points.iter().find(|of| recording::in_columns(&of.element) == name)?;
            let rows = first.rows_held(self.time_s, temperature_c, self.running_until());
            (!rows.is_empty()).then(|| self.time_s[rows.start])
        };
        self.elements.iter().filter_map(arrived).reduce(f64::max)
    }

    /// How well the loops hold: from when an element first arrived at its set-point, with a range
    /// that the rare extremes may leave.
    fn deviations(&self) -> Option<Chart> {
        let deviation = |&(name, pen): &(&str, Pen)| {
            let temperature_c = self.numbers(TEMPERATURE, name)?;
            let held: Vec<_> = (self.set_points.iter().filter(|of| recording::in_columns(&of.element) == name))
                .map(|of| (of.rows_held(self.time_s, temperature_c, self.running_until()), of.celsius))
                .collect();
            let deviation_mk = |row: usize| {
                let now = held.iter().find(|(rows, _)| rows.contains(&row));
                now.map_or(f64::NAN, |(_, celsius)| (temperature_c[row] - celsius) * 1e3)
            };
            let bins = self.bins(deviation_mk);
            // Elements that never arrived have nothing to show.
            bins.iter().any(|bin| bin.mean.is_finite()).then_some((pen, bins))
        };
        let deviations: Vec<(Pen, Vec<Bin>)> = self.elements.iter().filter_map(deviation).collect();
        let ends = deviations.iter().flat_map(|(_, bins)| bins).flat_map(|bin| [bin.least.abs(), bin.most.abs()]);
        let mut distances: Vec<f64> = ends.filter(|distance| distance.is_finite()).collect();
        distances.sort_by(f64::total_cmp);
        let most = distances.get(distances.len().checked_sub(1)? * 98 / 100)?.max(1e-3);
        let all = Trace::extremes(reach(deviations.iter().map(|(_, bins)| bins.as_slice())), 0.15).painted(QUIET);
        let lines = deviations.into_iter().map(|(pen, bins)| Trace::bins("", bins).painted(pen).width(0.7).band(0.0));
        let chart = Chart::new("Off the set-point", "mK").note("means, and what all of them reach over");
        Some(chart.height(20.0).range(-most, most).first_on_top(lines.chain([all])))
    }

    fn powers(&self) -> Option<Chart> {
        let power = |name| mean_power(self.time_s, self.numbers(POWER, name)?, BINS);
        let powers: Vec<(&str, Pen, MeanPower)> =
            self.elements.iter().filter_map(|&(name, pen)| Some((name, pen, power(name)?))).collect();
        let greatest = powers.iter().flat_map(|(_, _, mean)| &mean.power_w).copied().fold(0.0, f64::max);
        let (factor, unit) = power_unit(greatest);
        let step_s = (self.time_s.last()? - self.time_s.first()?) / (self.time_s.len().max(2) - 1) as f64;
        let window_s = f64::from(powers.first()?.2.ratio) * step_s;
        let line = |(name, pen, mean): (&str, Pen, MeanPower)| {
            let power = mean.power_w.into_iter().map(|power_w| power_w * factor);
            Trace::line(name, mean.time_s.into_iter().zip(power).collect()).painted(pen)
        };
        let chart = Chart::new("Heating power", unit).height(34.0).range(0.0, greatest * factor);
        let chart = chart.note(format!("decimated to one value in {} s", brief(window_s)));
        Some(chart.first_on_top(powers.into_iter().map(line)))
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
