//! A prediction in words and as JSON.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::json;

use super::analysis_summary::brief;
use crate::predict::closed::{Predicted, Prediction};
use crate::predict::compare::{Compared, Decimated};

/// One element's comparison.
pub struct Row<'a> {
    pub of: &'a Predicted,
    pub decimated: Decimated,
    /// `None` where nothing is predicted, or nothing can be compared.
    pub compared: Option<Compared>,
}

/// All that there is to be said.
pub struct Said<'a> {
    pub prediction: &'a Prediction,
    pub rows: &'a [Row<'a>],
    /// Of the decimator, in ticks.
    pub ratio: usize,
    pub against: Option<&'a Path>,
    pub notes: &'a [String],
}

impl Said<'_> {
    pub fn as_json(&self) -> serde_json::Value {
        let period_s = self.prediction.sample_period_s;
        let first = self.rows.iter().find(|row| row.of.regulated);
        let of_first = first.and_then(|row| row.compared.as_ref());
        let seconds = |(from, to): (usize, usize)| [from as f64 * period_s, to as f64 * period_s];
        let element = |row: &Row<'_>| {
            let compared = row.compared.as_ref();
            json!({
                "name": row.of.name,
                "regulated": row.of.regulated,
                "rms_w": compared.map(|of| of.rms_w),
                "bias_w": compared.map(|of| of.bias_w),
                "mean_w": compared.map(|of| of.mean_w),
                "n": compared.map_or(0, |of| of.count),
                "first_met_s": row.of.first_met_s,
                "saturated_s": row.of.saturated().into_iter().map(seconds).collect::<Vec<_>>(),
            })
        };
        json!({
            "element": first.map(|row| &row.of.name),
            "rms_w": of_first.map(|of| of.rms_w),
            "bias_w": of_first.map(|of| of.bias_w),
            "mean_w": of_first.map(|of| of.mean_w),
            "window_s": self.ratio as f64 * period_s,
            "ticks": self.prediction.class.len(),
            "against": self.against.map(|path| path.display().to_string()),
            "elements": self.rows.iter().map(element).collect::<Vec<_>>(),
            "notes": self.notes,
        })
    }

    pub fn summary(&self) -> String {
        let period_s = self.prediction.sample_period_s;
        let mut text = format!(
            "{} ticks of {period_s} s, decimated by windows of {} s\n",
            self.prediction.class.len(),
            brief(self.ratio as f64 * period_s)
        );
        // Writing to a string cannot fail.
        for note in self.notes {
            let _ = writeln!(text, "  {note}");
        }
        let what = self.against.map_or("one-bit rule on the model".to_owned(), |path| path.display().to_string());
        for row in self.rows {
            let _ = writeln!(text, "\n{}", row.of.name);
            if !row.of.regulated {
                text.push_str("  heated as its drive says: nothing is predicted\n");
                continue;
            }
            let _ = match row.of.first_met_s {
                Some(0.0) => writeln!(text, "  meets its set-point at once"),
                Some(time_s) => writeln!(text, "  meets its set-point after {} s", brief(time_s)),
                None => writeln!(text, "  NEVER MEETS ITS SET-POINT{}", nearest(row.of)),
            };
            for (from, to) in row.of.saturated() {
                let _ = writeln!(
                    text,
                    "  off its set-point's surface from {} to {} s",
                    brief(from as f64 * period_s),
                    brief(to as f64 * period_s)
                );
            }
            if let Some(of) = &row.compared {
                let share = |power_w: f64| match of.mean_w {
                    0.0 => String::new(),
                    mean_w => format!(" ({:.3} %)", 100.0 * power_w / mean_w.abs()),
                };
                let _ = writeln!(
                    text,
                    "  {what} against the limit, {} outputs: {} W rms{}, bias {} W{}, mean {} W",
                    of.count,
                    brief(of.rms_w),
                    share(of.rms_w),
                    brief(of.bias_w),
                    share(of.bias_w),
                    brief(of.mean_w)
                );
            }
        }
        text
    }
}

/// How near to its set-point an element comes that never meets it, and what it lacks.
fn nearest(of: &Predicted) -> String {
    let ticks = of.sampled_c.iter().zip(&of.target_c).map(|(c, target_c)| (c - target_c, *c, *target_c));
    let Some((apart_k, c, target_c)) = ticks.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs())) else {
        return String::new();
    };
    let (level, side) = if apart_k < 0.0 { ("high", "below") } else { ("low", "above") };
    format!(
        " of {} °C: under the {level} level it comes to {} °C at best, {} K {side} it",
        brief(target_c),
        brief(c),
        brief(apart_k.abs())
    )
}
