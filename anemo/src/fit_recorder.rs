//! Collects measured and predicted values of every row for a picture, for `identify` and
//! `validate`.

use crate::output::Failure;
use crate::picture::PictureArguments;
use diffusive::identify::FitRow;
use diffusive::identify::record::Survey;
use diffusive::model::Whiteness;
use plot::model::FitSeries;
use plot::{Canvas, Figure};

/// One series an output, and the file that they will be drawn into.
pub struct FitRecorder {
    canvas: Option<Canvas>,
    series: Vec<FitSeries>,
    /// As they were before the first row.
    empty: Vec<FitSeries>,
    /// By output: the row that comes next.
    next: Vec<u64>,
    first_time_s: f64,
    sample_period_s: f64,
}

impl FitRecorder {
    /// The file is tried at once.
    pub fn new(picture: &PictureArguments, survey: &Survey) -> Result<Self, Failure> {
        let unit = |name: &String| recording::stated_unit(name).unwrap_or_default().to_owned();
        let empty: Vec<_> = survey.outputs.iter().map(|name| FitSeries::new(name.clone(), unit(name))).collect();
        Ok(Self {
            canvas: picture.canvas()?,
            series: empty.clone(),
            empty,
            next: vec![0; survey.outputs.len()],
            first_time_s: survey.first_time_s,
            sample_period_s: survey.sample_period_s,
        })
    }

    pub fn see(&mut self, seen: &FitRow<'_>) {
        if self.canvas.is_none() {
            return;
        }
        let time_s = self.first_time_s + seen.row as f64 * self.sample_period_s;
        for (output, series) in self.series.iter_mut().enumerate() {
            // Outputs on other meshes have a reading of their own.
            if (seen.predicted[output] + seen.measured[output]).is_finite() {
                // Of rows that come again, by a better model, the last ones count.
                if seen.row < std::mem::replace(&mut self.next[output], seen.row + 1) {
                    *series = self.empty[output].clone();
                }
                series.push(time_s, seen.measured[output], seen.predicted[output], seen.class);
            }
        }
    }

    /// Draws them, if a file was named; `figure` makes a picture of them.
    pub fn draw(
        mut self,
        whiteness: &[Option<Whiteness>],
        figure: impl FnOnce(&[FitSeries]) -> Figure,
    ) -> Result<(), Failure> {
        let Some(canvas) = self.canvas else { return Ok(()) };
        self.series.iter_mut().zip(whiteness).for_each(|(series, white)| series.whiteness.clone_from(white));
        canvas.draw(&figure(&self.series)).map_err(Failure::work)
    }
}
