//! The page of the figures.

use diffusive::identify::validate::ValidationReport;
use diffusive::model::{Model, Pair};
use recording::text::four_digits as brief;

use super::loops::{DaysFigures, LoopFigures};
use super::plateaus::PlateauFigures;
use super::readings::ReadingFigures;
use crate::table::ResultTable;

/// All that was measured.
#[derive(Debug)]
pub struct MemsReport {
    /// Over the first hour, and the whole record.
    pub readings: [ReadingFigures; 2],
    /// The diffusive model of two inputs, one a symbol: a day fitted, the next one forecast.
    pub two_symbols: TwoSymbolFigures,
    /// Set-points, predicted and simulated.
    pub held: Vec<LoopFigures>,
    /// Two days at a set-point.
    pub days: [DaysFigures; 2],
    /// Where the loop of first order locks.
    pub plateaus: Vec<PlateauFigures>,
}

/// A model of two symbols, from a device without charge.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoSymbolFigures {
    /// Fit on the second day, forecast, %.
    pub fit_percent: Option<f64>,
    /// Its error, V rms.
    pub rmse_v: f64,
    /// Steady shift under one symbol for ever, V: 1, −1.
    pub steady_v: [f64; 2],
}

impl TwoSymbolFigures {
    /// From what validation found.
    pub(super) fn of(report: &ValidationReport, model: &Model) -> Self {
        let steady_v = |pair: &Pair| pair.classes.values().flat_map(|class| &class.r_k_per_w).sum::<f64>();
        let mut pairs = model.pairs.iter().map(steady_v);
        Self {
            fit_percent: report.outputs.first().and_then(|output| output.fit_percent),
            rmse_v: report.outputs.first().map_or(f64::NAN, |output| output.rmse),
            steady_v: [pairs.next().unwrap_or(f64::NAN), pairs.next().unwrap_or(f64::NAN)],
        }
    }
}

impl MemsReport {
    fn tables(&self) -> [ResultTable; 5] {
        let readings = self.readings.iter().map(|of| {
            vec![
                brief(of.duration_s),
                brief(of.quasi_differential_v),
                brief(of.single_v),
                format!("{:.2} %", 100.0 * of.quasi_differential_v / of.single_v),
            ]
        });
        let percent = |fit: Option<f64>| fit.map_or_else(|| "–".to_owned(), |fit| format!("{fit:.2} %"));
        let [up_v, down_v] = self.two_symbols.steady_v.map(brief);
        let two = vec![percent(self.two_symbols.fit_percent), brief(self.two_symbols.rmse_v), up_v, down_v];
        let held = self.held.iter().map(|of| {
            let [predicted, simulated] = of.mean_symbol;
            let [predicted_v, simulated_v] = of.mean_shift_v;
            vec![
                of.order.to_string(),
                brief(of.target_v),
                brief(predicted),
                brief(simulated),
                // Difference of the share of ones, (1 + s)/2.
                format!("{:.2} %", 50.0 * (predicted - simulated).abs()),
                format!("{:.3} %", 100.0 * (predicted_v - simulated_v).abs() / of.span_v),
                of.reached_s.map(brief).join(", "),
            ]
        });
        let days = self.days.iter().map(|of| {
            vec![
                of.order.to_string(),
                brief(of.most_off_v),
                brief(of.step_v),
                brief(of.mean_off_v),
                of.mean_symbol.map(brief).join(" → "),
            ]
        });
        let plateaus = self.plateaus.iter().map(|of| {
            let [from_v, to_v] = of.simulated_v;
            let width_v = of.predicted.to_v - of.predicted.from_v;
            let off_v = (of.predicted.from_v - from_v).abs().max((of.predicted.to_v - to_v).abs());
            vec![
                format!("{} of {}", of.predicted.ones, of.predicted.symbols),
                format!("{} … {}", brief(of.predicted.from_v), brief(of.predicted.to_v)),
                format!("{} … {}", brief(from_v), brief(to_v)),
                format!(
                    "{:.2} % of the span, {:.0} % of the width",
                    100.0 * off_v / of.span_v,
                    100.0 * off_v / width_v
                ),
                of.first_order.map(brief).join(", "),
                of.second_order.map(brief).join(", "),
            ]
        });
        [
            ResultTable::new("first, s | two readings, V rms | one reading, V rms | share", readings),
            ResultTable::new("fit, second day | V rms | 1 for ever, V | −1 for ever, V", [two]),
            ResultTable::new(
                "order | set-point, V | mean symbol predicted | simulated | share of ones off by | shift off by, of the span | reached, s",
                held,
            ),
            ResultTable::new("order | most off, V | one symbol moves, V | mean off, V | mean symbol", days),
            ResultTable::new(
                "ones | predicted, V | simulated, V | edges off by | mean symbol across it, first order | second order",
                plateaus,
            ),
        ]
    }

    /// The page of the results.
    pub fn page(&self, day: &str) -> String {
        let tables = self.tables().map(|table| table.markdown());
        let fill = [
            ("day", day),
            ("readings", &tables[0]),
            ("model", &tables[1]),
            ("held", &tables[2]),
            ("days", &tables[3]),
            ("plateaus", &tables[4]),
        ];
        recording::template::fill(include_str!("page.md"), &fill).unwrap_or_else(|error| error.to_string())
    }
}
