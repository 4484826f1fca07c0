//! Collects measured and predicted values of every row for a picture, for `identify` and
//! `validate`.

use diffusive::identify::FitRow;
use diffusive::identify::record::Survey;
use diffusive::model::Whiteness;
use plot::model::FitSeries;

/// One series an output; none if nobody is going to draw them.
pub struct FitRecorder {
    series: Vec<FitSeries>,
    /// As they were before the first row.
    empty: Vec<FitSeries>,
    /// By output: the row that comes next.
    next: Vec<u64>,
    first_time_s: f64,
    sample_period_s: f64,
}

impl FitRecorder {
    /// For the outputs of a record, if they are going to be drawn.
    pub fn new(is_drawn: bool, survey: &Survey) -> Self {
        let unit = |name: &String| recording::stated_unit(name).unwrap_or_default().to_owned();
        let outputs = survey.outputs.iter().filter(|_| is_drawn);
        let empty: Vec<_> = outputs.map(|name| FitSeries::new(name.clone(), unit(name))).collect();
        Self {
            series: empty.clone(),
            next: vec![0; empty.len()],
            empty,
            first_time_s: survey.first_time_s,
            sample_period_s: survey.sample_period_s,
        }
    }

    pub fn see(&mut self, seen: &FitRow<'_>) {
        let time_s = self.first_time_s + seen.row as f64 * self.sample_period_s;
        for (output, series) in self.series.iter_mut().enumerate() {
            // Outputs on other meshes have a reading of their own.
            if (seen.predicted[output] + seen.measured[output]).is_finite() {
                // Of rows that come again, by a better model, the last ones count.
                if seen.row < std::mem::replace(&mut self.next[output], seen.row + 1) {
                    *series = self.empty[output].clone();
                }
                let of = |values: &[f64]| values.get(output).copied().unwrap_or(0.0);
                let drift = (of(seen.drift), of(seen.drift_se));
                series.push(time_s, seen.measured[output], seen.predicted[output], drift, seen.class);
            }
        }
    }

    /// What was seen, with the whiteness of the residuals of every output.
    pub fn fits<'w>(mut self, whiteness: impl IntoIterator<Item = &'w Option<Whiteness>>) -> Vec<FitSeries> {
        self.series.iter_mut().zip(whiteness).for_each(|(series, white)| series.whiteness.clone_from(white));
        self.series
    }
}
