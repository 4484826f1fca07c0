//! The table of laws.

use std::fmt::{self, Display, Formatter};

use recording::stated_unit;
use recording::text::{brief, columns, listed, short};
use serde::Serialize;

use super::record::ForecastRecord;
use crate::model::{Model, rise_unit};

/// All laws on one record; for people by `Display`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LawsReport {
    /// The diffusive model, identified from the first part.
    #[serde(skip)]
    pub model: Model,
    /// Files of the record.
    pub records: Vec<String>,
    /// The input's column.
    pub input: String,
    /// The output's column.
    pub output: String,
    /// Unit of errors, decays and differences of the output, if its name states one.
    pub unit: Option<String>,
    /// Rows of the record.
    pub rows: usize,
    /// Their distance in time.
    pub sample_period_s: f64,
    /// Rows of the part that is fitted.
    pub fitted_rows: usize,
    /// Time of the first row that is forecast.
    pub until_s: f64,
    /// The laws, the diffusive model last.
    pub laws: Vec<LawForecast>,
    /// The one of least error in the held-out part.
    pub best: String,
    /// What the record's reader decided by default, and what it found remarkable.
    pub notes: Vec<String>,
    /// What must be known of the numbers.
    pub warnings: Vec<String>,
    /// Unit of the input, if its name states one.
    #[serde(skip)]
    pub input_unit: Option<String>,
    /// Time of the first row.
    #[serde(skip)]
    pub first_time_s: f64,
    /// The output, NaN where it is missing.
    #[serde(skip)]
    pub measured: Vec<f64>,
}

/// One law: its numbers, and how well it fits and forecasts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LawForecast {
    /// What it is called.
    pub law: String,
    /// How many numbers were fitted.
    pub numbers: usize,
    /// Its terms.
    pub terms: Vec<LawTerm>,
    /// The output without any input, in the end.
    pub rest: f64,
    /// In the part that was fitted.
    pub fitted: PartFigures,
    /// In the rest.
    pub held_out: PartFigures,
    /// Whether the error held out is within the noise of the least one.
    pub within_noise: bool,
    /// The output at all rows; NaN where a dead time leaves none.
    #[serde(skip)]
    pub predicted: Vec<f64>,
}

/// One term A S(t).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LawTerm {
    /// A, in units of the output by those of the input, and by √s for the square root of time.
    pub gain: f64,
    /// What the time before the record has left of it at the first row, in units of the output;
    /// none of a model.
    pub decay: Option<f64>,
    /// τ
    pub time_constant_s: Option<f64>,
    /// β
    pub exponent: Option<f64>,
}

/// Errors in a part of the record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PartFigures {
    /// 100 (1 − ‖y − ŷ‖ / ‖y − mean y‖); none where the output is the same in all rows.
    pub fit_percent: Option<f64>,
    /// Root mean square error, in the output's unit.
    pub rmse: f64,
}

impl LawsReport {
    pub(super) fn new(
        record: ForecastRecord,
        measured: Vec<f64>,
        laws: Vec<LawForecast>,
        model: Model,
        best: usize,
        warnings: Vec<String>,
    ) -> Self {
        let until_s = record.time_s(record.fitted);
        let ForecastRecord { survey, fitted, .. } = record;
        let (input, output) = (survey.inputs[0].clone(), survey.outputs[0].clone());
        Self {
            model,
            records: survey.paths.iter().map(|path| path.display().to_string()).collect(),
            unit: rise_unit(&output).map(str::to_owned),
            input_unit: stated_unit(&input).map(str::to_owned),
            rows: measured.len(),
            sample_period_s: survey.sample_period_s,
            fitted_rows: fitted,
            until_s,
            best: laws[best].law.clone(),
            laws,
            notes: survey.notes,
            warnings,
            first_time_s: survey.first_time_s,
            measured,
            input,
            output,
        }
    }

    /// The one of least error in the held-out part, and those within its noise, in one sentence.
    pub fn verdict(&self) -> String {
        let alike = self.laws.iter().filter(|law| law.within_noise && law.law != self.best);
        let names: Vec<&str> = alike.map(|law| law.law.as_str()).collect();
        let rmse = self.laws.iter().find(|law| law.law == self.best).map_or(f64::NAN, |law| law.held_out.rmse);
        let best = format!("least error held out: {}, {} rms", self.best, with_unit(rmse, self.unit.as_deref()));
        match names.len() {
            0 => format!("{best}; every other is worse by more than the noise"),
            count => format!("{best}; within the noise of it: {}", listed(&names, count)),
        }
    }

    /// Unit of a gain, as far as names state it.
    fn gain_unit(&self) -> String {
        match (&self.unit, &self.input_unit) {
            (Some(rise), Some(input)) => format!("{rise}/{input}"),
            (Some(rise), None) => format!("{rise} by unit of {}", self.input),
            _ => format!("unit of {} by unit of {}", self.output, self.input),
        }
    }
}

fn with_unit(value: f64, unit: Option<&str>) -> String {
    unit.map_or_else(|| short(value, 4), |unit| format!("{} {unit}", short(value, 4)))
}

impl Display for LawsReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { rows, fitted_rows, .. } = self;
        writeln!(
            f,
            "{}: {} → {}, {rows} rows, one each {} s",
            self.records.join(", "),
            self.input,
            self.output,
            brief(self.sample_period_s)
        )?;
        self.notes.iter().try_for_each(|note| writeln!(f, "  {note}"))?;
        writeln!(
            f,
            "fitted: {fitted_rows} rows, before {} s; held out: the {} rows from then on\n",
            brief(self.until_s),
            rows - fitted_rows
        )?;
        let rmse = self.unit.as_ref().map_or("rms".to_owned(), |unit| format!("rms {unit}"));
        let head = ["law", "numbers", "fit %", &rmse, "held out: fit %", &format!("held out: {rmse}"), ""]
            .map(str::to_owned)
            .to_vec();
        let percent = |figures: &PartFigures| figures.fit_percent.map_or("–".to_owned(), |fit| format!("{fit:.2}"));
        let line = |law: &LawForecast| {
            let mark = if law.law == self.best {
                "best"
            } else if law.within_noise {
                "alike"
            } else {
                ""
            };
            vec![
                law.law.clone(),
                law.numbers.to_string(),
                percent(&law.fitted),
                short(law.fitted.rmse, 4),
                percent(&law.held_out),
                short(law.held_out.rmse, 4),
                mark.to_owned(),
            ]
        };
        let lines: Vec<Vec<String>> = std::iter::once(head).chain(self.laws.iter().map(line)).collect();
        write!(f, "{}", columns(&lines, &[1, 2, 3, 4, 5]))?;
        writeln!(f, "\n{}\n", self.verdict())?;
        writeln!(f, "numbers (gain in {}; by √s for the square root of time):", self.gain_unit())?;
        let mut lines = vec![["law", "τ s", "β", "gain", "decay", "rest"].map(str::to_owned).to_vec()];
        for law in &self.laws {
            for (at, term) in law.terms.iter().enumerate() {
                let cell = |value: Option<f64>| value.map_or(String::new(), |value| short(value, 4));
                let first = |text: String| if at == 0 { text } else { String::new() };
                lines.push(vec![
                    first(law.law.clone()),
                    cell(term.time_constant_s),
                    cell(term.exponent),
                    cell(Some(term.gain)),
                    cell(term.decay),
                    first(short(law.rest, 4)),
                ]);
            }
        }
        for (cell, unit) in [(4, self.unit.as_deref()), (5, stated_unit(&self.output))] {
            lines[0][cell].extend(unit.map(|unit| format!(" {unit}")));
        }
        write!(f, "{}", columns(&lines, &[1, 2, 3, 4, 5]))?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "\nwarning: {warning}"))
    }
}
