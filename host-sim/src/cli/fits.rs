//! Measured and predicted values on their way into a picture, for the commands that follow a record with a model.

use std::path::Path;

use super::Failure;
use crate::identify::record::Survey;
use crate::identify::residuals::Seen;
use crate::model::{Model, Whiteness};
use crate::plot::Canvas;
use crate::plot::model::{FitBuilder, FitSeries, page};

/// One series an output, and the file that they will be drawn into.
pub struct Fits {
    canvas: Option<Canvas>,
    series: Vec<FitBuilder>,
    first_time_s: f64,
    sample_period_s: f64,
}

impl Fits {
    /// The file is tried at once: a wrong name should not be told at the end of long work.
    pub fn new(path: Option<&Path>, survey: &Survey) -> Result<Self, Failure> {
        let unit = |name: &String| if name.starts_with("temperature_c") { "°C" } else { "" };
        Ok(Self {
            canvas: path.map(Canvas::create).transpose().map_err(Failure::usage)?,
            series: survey.outputs.iter().map(|name| FitSeries::builder(name.clone(), unit(name))).collect(),
            first_time_s: survey.first_time_s,
            sample_period_s: survey.sample_period_s,
        })
    }

    pub fn see(&mut self, seen: &Seen<'_>) {
        if self.canvas.is_none() {
            return;
        }
        let time_s = self.first_time_s + seen.row as f64 * self.sample_period_s;
        for (output, series) in self.series.iter_mut().enumerate() {
            // Outputs on other meshes have a reading of their own.
            if seen.predicted[output].is_finite() {
                series.push(time_s, seen.measured[output], seen.predicted[output], seen.class);
            }
        }
    }

    /// Draws the model's page with them, if a file was named.
    pub fn draw(self, model: &Model, whiteness: &[Option<Whiteness>]) -> Result<(), Failure> {
        let Some(canvas) = self.canvas else { return Ok(()) };
        let fits: Vec<FitSeries> =
            self.series.into_iter().zip(whiteness).map(|(series, white)| series.finish(white.clone())).collect();
        canvas.write(&page(model, &fits).map_err(Failure::work)?).map_err(Failure::work)
    }
}
