//! A prediction, for people and as JSON.

use std::fmt;

use recording::text::{columns, four_digits as brief};
use serde::Serialize;

use super::locking::Plateau;
use crate::run::{DeviceRunSummary, PhaseSummary};

/// Prediction of an experiment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DevicePrediction {
    /// The run of the experiment on the model, under the one-bit rule.
    pub run: DeviceRunSummary,
    /// Shifts that the two symbols can hold for ever, V.
    pub range_v: [f64; 2],
    /// A symbol 1 raises the shift, as a loop needs it.
    pub raises: bool,
    /// Powers of every set-point, in the limit of fast symbols.
    pub held: Vec<HeldPhase>,
    /// Where a loop of first order locks.
    pub plateaus: Vec<Plateau>,
    /// The same phases of a recording, where one is compared with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<Vec<PhaseSummary>>,
    /// Warnings about the model, and of what it is compared with.
    pub warnings: Vec<String>,
}

/// Sliding-mode analysis of a set-point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeldPhase {
    /// Start of its phase, s.
    pub start_s: f64,
    /// Set-point, V.
    pub target_v: f64,
    /// The two symbols can hold it for ever.
    pub is_reachable: bool,
    /// Mean symbol once all has settled.
    pub steady_symbol: f64,
    /// From rest, s.
    pub reaching_from_rest_s: Option<f64>,
    /// From rest until the mean symbol stays within 2 % of the steady one, s.
    pub settled_from_rest_s: Option<f64>,
    /// The plateau that it lies on, of a loop of first order.
    pub plateau: Option<Plateau>,
}

impl DevicePrediction {
    /// The spectra of the last phase that holds a set-point.
    fn spectrum(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(at) = self.run.phases.iter().rposition(|phase| phase.target_v.is_some()) else { return Ok(()) };
        let recorded = self.against.iter().filter_map(|all| all.get(at)).next();
        let mut lines = vec![vec!["period, s".to_owned(), "predicted".to_owned()]];
        if recorded.is_some() {
            lines[0].push("recorded".to_owned());
        }
        for (octave, of) in self.run.phases[at].octaves.iter().enumerate() {
            let other = recorded.map(|phase| phase.octaves.get(octave).map_or("–".to_owned(), |of| brief(of.power)));
            lines.push([brief(of.period_s), brief(of.power)].into_iter().chain(other).collect());
        }
        writeln!(f, "\nspectrum of the symbols, power by octaves:")?;
        write!(f, "{}", columns(&lines, &[0, 1, 2]))
    }
}

impl fmt::Display for DevicePrediction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least_v, most_v] = self.range_v;
        if !self.raises {
            writeln!(
                f,
                "symbol 1 lowers the shift, so that no loop can hold it: take 1 − δ for `second_share` in the experiment"
            )?;
        }
        writeln!(f, "the two symbols hold shifts from {} to {} V for ever", brief(least_v), brief(most_v))?;
        let words = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), brief);
        for held in &self.held {
            write!(f, "set-point {} V from {} s: ", brief(held.target_v), held.start_s)?;
            if !self.raises {
                writeln!(f, "not held")?;
            } else if held.is_reachable {
                write!(f, "steady mean symbol {}", brief(held.steady_symbol))?;
                if held.reaching_from_rest_s.is_some() {
                    let [reached, settled] = [held.reaching_from_rest_s, held.settled_from_rest_s].map(words);
                    write!(f, "; from rest reached after {reached} s, settled after {settled} s")?;
                }
                writeln!(f)?;
            } else {
                writeln!(
                    f,
                    "out of reach in the long run: it would take a mean symbol of {}",
                    brief(held.steady_symbol)
                )?;
            }
            if let Some(of) = held.plateau {
                writeln!(
                    f,
                    "  a loop of first order locks there: {} of {} symbols are 1, from {} to {} V; one of second order does not",
                    of.ones,
                    of.symbols,
                    brief(of.from_v),
                    brief(of.to_v)
                )?;
            }
        }
        let mut lines =
            vec![["from, s", "", "reached after, s", "mean shift, V", "mean symbol"].map(str::to_owned).to_vec()];
        let line = |of: &PhaseSummary, what: &str| {
            vec![
                of.start_s.to_string(),
                what.to_owned(),
                words(of.reached_s),
                words(of.mean_voltage_shift_v),
                words(of.mean_symbol),
            ]
        };
        for (at, phase) in self.run.phases.iter().enumerate() {
            lines.push(line(phase, "predicted"));
            lines.extend(self.against.iter().filter_map(|all| all.get(at)).map(|of| line(of, "recorded")));
        }
        writeln!(f, "\nsecond half of each phase:")?;
        write!(f, "{}", columns(&lines, &[0, 2, 3, 4]))?;
        self.spectrum(f)?;
        self.warnings.iter().try_for_each(|warning| write!(f, "\nwarning: {warning}\n"))
    }
}
