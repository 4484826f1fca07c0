//! A recommended loop as a report: the text and the keys of `anemo design`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::{Serialize, Serializer};

use super::trial::LoopTrial;

/// Needs of one wind from the recommended loop, and what a trial of it gave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignInWind {
    /// Label of the wind.
    #[serde(skip)]
    pub label: String,
    /// u_Q, W.
    pub steady_power_w: f64,
    /// u_Q − P_low and P_high − u_Q, W.
    pub margins_w: (f64, f64),
    /// From rest under the high level, s.
    pub reaching_time_s: f64,
    /// Bound of the swing from peak to peak, K.
    pub chatter_k: f64,
    /// Result of the trial.
    pub trial: LoopTrial,
}

/// A loop that meets its requirements.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoopDesign {
    /// Set-point, °C.
    pub target_c: f64,
    /// Set-point over the temperature without heating, K.
    pub rise_k: f64,
    /// Low level, W.
    pub power_low_w: f64,
    /// High level, W.
    pub power_high_w: f64,
    /// Sample period, s.
    pub sample_period_s: f64,
    /// (P_high − P_low) Ts / window: one bit more or less in a window, W.
    pub resolution_w: f64,
    /// Time over which the bits are averaged for `resolution_w`, s.
    pub window_s: f64,
    /// The longest settling of the power after a change from one of the winds to another, s; `None`
    /// with one wind.
    pub settling_s: Option<f64>,
    /// One a wind, as they were given.
    #[serde(serialize_with = "by_label")]
    pub winds: Vec<DesignInWind>,
    /// A sentence for every decision.
    pub reasons: Vec<String>,
}

/// A recommended loop with the pair that it is for. It prints as a summary, and serialises to the
/// keys of `anemo design --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignReport {
    /// `INPUT → OUTPUT`.
    pub pair: String,
    /// The loop.
    #[serde(flatten)]
    pub design: LoopDesign,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

/// Serialises as a map by label.
fn by_label<S: Serializer>(winds: &[DesignInWind], serializer: S) -> Result<S::Ok, S::Error> {
    winds.iter().map(|wind| (&wind.label, wind)).collect::<BTreeMap<_, _>>().serialize(serializer)
}

impl std::fmt::Display for DesignReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { pair, design: found, notes } = self;
        // Writing to a String cannot fail.
        let mut text = format!(
            "{pair}\n\nset-point      {:.3} °C, {:.4} K above the temperature without heating\nlow level      {:.5} W\nhigh level     {:.5} W\nsample period  {} s\nresolution     {:.3e} W, averaged over {} s\n\n",
            found.target_c,
            found.rise_k,
            found.power_low_w,
            found.power_high_w,
            found.sample_period_s,
            found.resolution_w,
            found.window_s
        );
        for reason in &found.reasons {
            let _ = writeln!(text, "{reason}");
        }
        let width = found.winds.iter().map(|wind| wind.label.chars().count()).max().unwrap_or(0).max("wind".len());
        let _ = writeln!(
            text,
            "\n{:width$}  {:>10}  {:>10}  {:>9}  {:>9}  {:>10}  {:>10}  {:>9}  {:>9}",
            "wind", "power W", "tried W", "to low W", "to high W", "reached s", "tried s", "swing K", "tried K"
        );
        for wind in &found.winds {
            let tried_s = wind.trial.reaching_time_s.map_or("never".to_owned(), |time_s| format!("{time_s:.3}"));
            let _ = writeln!(
                text,
                "{:width$}  {:>10.6}  {:>10.6}  {:>9.5}  {:>9.5}  {:>10.3}  {tried_s:>10}  {:>9.4}  {:>9.4}",
                wind.label,
                wind.steady_power_w,
                wind.trial.mean_power_w,
                wind.margins_w.0,
                wind.margins_w.1,
                wind.reaching_time_s,
                wind.chatter_k,
                wind.trial.swing_k
            );
        }
        text.push_str(
            "\nThe swing is a bound to first order in the fastest pole and without reading noise, which adds to it.\n",
        );
        for note in notes {
            let _ = writeln!(text, "{note}");
        }
        f.write_str(&text)
    }
}
