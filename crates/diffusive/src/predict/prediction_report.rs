//! A prediction as a report, beside what it was compared with: the text and the keys of `anemo
//! predict`.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use super::closed::PredictedElement;
use super::compare::Compared;
use recording::text::four_digits as brief;

/// Prediction of a whole experiment. It prints as a summary, and serialises to the keys of `anemo
/// predict --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PredictionReport {
    /// The first regulated element; the numbers that follow are its own.
    element: Option<String>,
    rms_w: Option<f64>,
    bias_w: Option<f64>,
    mean_w: Option<f64>,
    /// Window of the decimator, s.
    window_s: f64,
    ticks: usize,
    /// The recording that was compared with.
    against: Option<String>,
    elements: Vec<PredictedElementReport>,
    notes: Vec<String>,
    #[serde(skip)]
    sample_period_s: f64,
}

/// Prediction of one element.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PredictedElementReport {
    name: String,
    regulated: bool,
    rms_w: Option<f64>,
    bias_w: Option<f64>,
    mean_w: Option<f64>,
    n: usize,
    first_met_s: Option<f64>,
    saturated_s: Vec<(f64, f64)>,
    #[serde(skip)]
    nearest: String,
}

impl PredictedElementReport {
    /// One element, and how far what it was compared with lies from it, where anything was.
    pub fn new(of: &PredictedElement, compared: Option<&Compared>, sample_period_s: f64) -> Self {
        let seconds = |(from, to): (usize, usize)| (from as f64 * sample_period_s, to as f64 * sample_period_s);
        Self {
            name: of.name.clone(),
            regulated: of.regulated,
            rms_w: compared.map(|of| of.rms_w),
            bias_w: compared.map(|of| of.bias_w),
            mean_w: compared.map(|of| of.mean_w),
            n: compared.map_or(0, |of| of.count),
            first_met_s: of.first_met_s,
            saturated_s: of.saturated().into_iter().map(seconds).collect(),
            nearest: nearest(of),
        }
    }
}

impl PredictionReport {
    /// All elements, compared by windows of `ratio` ticks with a recording, or with the one-bit
    /// rule on the model.
    pub fn new(
        elements: Vec<PredictedElementReport>,
        (ticks, sample_period_s): (usize, f64),
        ratio: usize,
        against: Option<String>,
        notes: Vec<String>,
    ) -> Self {
        let first = elements.iter().find(|element| element.regulated);
        Self {
            element: first.map(|of| of.name.clone()),
            rms_w: first.and_then(|of| of.rms_w),
            bias_w: first.and_then(|of| of.bias_w),
            mean_w: first.and_then(|of| of.mean_w),
            window_s: ratio as f64 * sample_period_s,
            ticks,
            against,
            elements,
            notes,
            sample_period_s,
        }
    }
}

impl Display for PredictionReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { ticks, sample_period_s, window_s, .. } = self;
        writeln!(f, "{ticks} ticks of {sample_period_s} s, decimated by windows of {} s", brief(*window_s))?;
        for note in &self.notes {
            writeln!(f, "  {note}")?;
        }
        let what = self.against.as_deref().unwrap_or("one-bit rule on the model");
        for element in &self.elements {
            element.write(f, what)?;
        }
        Ok(())
    }
}

impl PredictedElementReport {
    fn write(&self, f: &mut Formatter<'_>, what: &str) -> fmt::Result {
        writeln!(f, "\n{}", self.name)?;
        if !self.regulated {
            return writeln!(f, "  heated as its operating mode sets: nothing is predicted");
        }
        match self.first_met_s {
            Some(0.0) => writeln!(f, "  meets its set-point at once")?,
            Some(time_s) => writeln!(f, "  meets its set-point after {} s", brief(time_s))?,
            None => writeln!(f, "  NEVER MEETS ITS SET-POINT{}", self.nearest)?,
        }
        for (from_s, to_s) in &self.saturated_s {
            writeln!(f, "  off its set-point's surface from {} to {} s", brief(*from_s), brief(*to_s))?;
        }
        let (Some(rms_w), Some(bias_w), Some(mean_w)) = (self.rms_w, self.bias_w, self.mean_w) else { return Ok(()) };
        let share = |power_w: f64| match mean_w {
            0.0 => String::new(),
            mean_w => format!(" ({:.3} %)", 100.0 * power_w / mean_w.abs()),
        };
        writeln!(
            f,
            "  {what} against the limit, {} outputs: {} W rms{}, bias {} W{}, mean {} W",
            self.n,
            brief(rms_w),
            share(rms_w),
            brief(bias_w),
            share(bias_w),
            brief(mean_w)
        )
    }
}

/// Nearest approach to its set-point of an element that never meets it, and what it lacks.
fn nearest(of: &PredictedElement) -> String {
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
