//! Charts of a MEMS capacitor: voltage shift, mean symbol, and offset of the capacitance.

use super::figure::RunCharts;
use crate::engine::chart::Chart;
use crate::engine::colour::{PALETTE, TRUTH};
use crate::engine::extent::extent;
use crate::engine::reduce::{BINS, MeanPower, mean_power};
use crate::engine::trace::Trace;
use crate::engine::words::brief;
use recording::{OFFSET_CAPACITANCE, SYMBOL, TRUE_OFFSET_CAPACITANCE, TRUE_VOLTAGE_SHIFT, VOLTAGE_SHIFT};

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
        [shift, self.symbols(&devices), offset].into_iter().flatten().collect()
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

    fn symbols(&self, devices: &[&str]) -> Option<Chart> {
        let mean = |&device| Some((device, mean_power(self.time_s, self.numbers(SYMBOL, device)?, BINS)?));
        let means: Vec<(&str, MeanPower)> = devices.iter().filter_map(mean).collect();
        let step_s = (self.time_s.last()? - self.time_s.first()?) / (self.time_s.len().max(2) - 1) as f64;
        let window_s = f64::from(means.first()?.1.ratio) * step_s;
        let all = means.iter().flat_map(|(_, mean)| &mean.power_w).copied();
        let (least, most) = extent(all.chain([0.0]))?;
        let chart = Chart::new("Mean symbol", "").note(format!("decimated to one value in {} s", brief(window_s)));
        let line = |((device, mean), colour): ((&str, MeanPower), &_)| {
            Trace::line(device, mean.time_s.into_iter().zip(mean.power_w).collect()).painted(*colour)
        };
        let lines = means.into_iter().zip(PALETTE.iter().cycle()).map(line);
        Some(chart.height(25.0).range(least, most).first_on_top(lines))
    }
}
