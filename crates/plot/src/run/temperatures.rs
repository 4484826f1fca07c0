//! Charts of a run's temperatures and of how well its loops hold them; of a MEMS capacitor its
//! voltage shift, mean symbol, and offset of the capacitance.

use super::figure::RunCharts;
use crate::engine::axis::extent;
use crate::engine::chart::Chart;
use crate::engine::colour::{GAS, PALETTE, Pen, QUIET, TRUTH};
use crate::engine::reduce::{Bin, reach};
use crate::engine::trace::{CURVE, Trace};
use crate::engine::words::brief;
use recording::{
    GAS_TEMPERATURE, OFFSET_CAPACITANCE, SYMBOL, TEMPERATURE, TRUE_OFFSET_CAPACITANCE, TRUE_VOLTAGE_SHIFT,
    VOLTAGE_SHIFT,
};

/// Dashed lines of set-points; more of them would be all that is seen.
const MOST_SET_POINTS: usize = 40;

impl RunCharts<'_> {
    pub fn temperatures(&self) -> Option<Chart> {
        let line = |&(name, pen): &(&str, Pen)| {
            let temperature_c = self.numbers(TEMPERATURE, name)?;
            Some(Trace::bins(name, self.bins(|row| temperature_c[row])).painted(pen).band(0.12))
        };
        let kept = |trace: &Trace| trace.bins.iter().any(|bin| bin.mean.is_finite());
        let lines: Vec<Trace> = self.elements.iter().filter_map(line).filter(kept).collect();
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
        let after = |bin: &&Bin| arrived_s.is_none_or(|arrived_s| bin.from_s >= arrived_s);
        let settled =
            lines.iter().chain(&gas).filter(|trace| kept(trace)).flat_map(|trace| trace.bins.iter().filter(after));
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

    /// Deviations of the loops: from when an element first arrived at its set-point, with a range
    /// that the rare extremes may leave.
    pub fn deviations(&self) -> Option<Chart> {
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
}

/// Picofarad a farad.
const PF_PER_F: f64 = 1e12;

impl RunCharts<'_> {
    /// Nothing for a recording without voltage shifts.
    pub fn charge(&self) -> Vec<Chart> {
        let devices: Vec<&str> = self.recording.behind(VOLTAGE_SHIFT).collect();
        let shift =
            self.over_truth(&devices, Chart::new("Voltage shift", "V"), [VOLTAGE_SHIFT, TRUE_VOLTAGE_SHIFT], 1.0);
        let offset = Chart::new("Offset of the capacitance", "pF");
        let offset = self.over_truth(&devices, offset, [OFFSET_CAPACITANCE, TRUE_OFFSET_CAPACITANCE], PF_PER_F);
        let pens = devices.iter().copied().zip(PALETTE.into_iter().map(Pen::from).cycle());
        let symbols = self.decimated(SYMBOL, pens, |_, _| (Chart::new("Mean symbol", "").height(25.0), 1.0));
        [shift, symbols, offset].into_iter().flatten().collect()
    }

    /// A quantity of every device over what is true of it, wide and pale.
    fn over_truth(&self, devices: &[&str], chart: Chart, [measured, truth]: [&str; 2], factor: f64) -> Option<Chart> {
        let bins = |prefix: &str, device: &str| {
            let values = self.numbers(prefix, device)?;
            Some(self.bins(|row| values[row] * factor))
        };
        let lines = devices.iter().zip(PALETTE.iter().cycle());
        let lines = lines.filter_map(|(device, colour)| {
            Some(Trace::bins(*device, bins(measured, device)?).painted(*colour).band(0.15))
        });
        let lines: Vec<Trace> = lines.collect();
        let truths = devices.iter().filter_map(|device| Some(Trace::pale("true", bins(truth, device)?, TRUTH)));
        let has_any = lines.iter().any(|line| line.bins.iter().any(|bin| bin.mean.is_finite()));
        has_any.then(|| chart.height(34.0).first_on_top(lines.into_iter().chain(truths)))
    }
}
