//! Charts of a MEMS capacitor: voltage shift, mean symbol, and offset of the capacitance.

use super::figure::RunCharts;
use crate::engine::chart::Chart;
use crate::engine::colour::{PALETTE, Pen, TRUTH};
use crate::engine::trace::Trace;
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
