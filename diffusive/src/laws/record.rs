//! A record of one input and one output, cut in a part that is fitted and one that is forecast.

use std::ops::Range;

use crate::identify::record::{Block, RecordError, RecordSource, RecordTable, Survey, read_rows};
use crate::identify::validate_options::LEAST_ROWS;

/// Fewer rows than this are not fitted: the law of most numbers has 13 of them.
const LEAST_FITTED: usize = 50;

/// Where the part ends that is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FittedPart {
    /// At this time of the record, s.
    UntilS(f64),
    /// This share of the rows, above 0 and below 1, is left out at the end.
    HeldOut(f64),
}

impl Default for FittedPart {
    fn default() -> Self {
        Self::HeldOut(0.5)
    }
}

/// The record and where it is cut.
pub struct ForecastRecord {
    pub survey: Survey,
    pub block: Block,
    /// Rows of the first part.
    pub fitted: usize,
}

impl ForecastRecord {
    /// Reads a record.
    ///
    /// # Errors
    /// If it has several inputs, outputs or segments, or a part is too short or has nothing to fit.
    pub fn read(source: &mut dyn RecordSource, part: FittedPart) -> Result<Self, RecordError> {
        let survey = source.survey();
        let (inputs, outputs) = (survey.inputs.len(), survey.outputs.len());
        survey.refuse_if(
            inputs != 1 || outputs != 1,
            format_args!("has {inputs} inputs and {outputs} outputs where a law has one of each: name one with --input and one with --output"),
        )?;
        survey.refuse_if(
            survey.segments != 1,
            format_args!("has gaps, or an input that is missing, between its {} segments: a law remembers its whole input, so give one stretch without gaps", survey.segments),
        )?;
        let block = read_rows(source)?;
        let mut survey = source.survey().clone();
        if let (Some(column), 2..) = (&survey.event_column, source.classes().len()) {
            survey.notes.push(format!("labels in column `{column}` are not looked at: a law is one for all rows"));
        }
        let rows = block.len();
        let fitted = match part {
            FittedPart::UntilS(until_s) => {
                // A row at the very time is not before it, whatever the last digit says.
                let before = (until_s - survey.first_time_s) / survey.sample_period_s - 1e-6;
                before.ceil().clamp(0.0, rows as f64) as usize
            }
            FittedPart::HeldOut(share) => rows - (share * rows as f64).round() as usize,
        };
        let record = Self { survey, block, fitted };
        record.check()?;
        Ok(record)
    }

    /// The input.
    pub fn input(&self) -> &[f64] {
        &self.block.inputs[0]
    }

    /// The output, NaN where it is missing.
    pub fn output(&self) -> Vec<f64> {
        let mut output = self.block.outputs[0].clone();
        self.block.missing.iter().for_each(|&row| output[row as usize] = f64::NAN);
        output
    }

    /// Time of a row, s.
    pub fn time_s(&self, row: usize) -> f64 {
        self.survey.first_time_s + row as f64 * self.survey.sample_period_s
    }

    /// Some of its rows as a record.
    pub fn part(&self, rows: Range<usize>) -> RecordTable {
        RecordTable::part(&self.survey, &self.block, rows)
    }

    fn check(&self) -> Result<(), RecordError> {
        let Self { survey, fitted, .. } = self;
        let output = self.output();
        let known = |part: &[f64]| part.iter().filter(|y| !y.is_nan()).count();
        let (before, behind) = (known(&output[..*fitted]), known(&output[*fitted..]));
        survey.refuse_if(
            before < LEAST_FITTED || behind < LEAST_ROWS as usize,
            format_args!(
                "has {before} rows with an output to fit and {behind} to forecast: {LEAST_FITTED} and {LEAST_ROWS} are the least; give a longer record, or cut it elsewhere"
            ),
        )?;
        for (name, values) in [(&survey.inputs[0], self.input()), (&survey.outputs[0], output.as_slice())] {
            let mut part = values[..*fitted].iter().filter(|value| !value.is_nan());
            let first = part.next().copied().unwrap_or_default();
            survey.refuse_if(
                part.all(|value| *value == first),
                format_args!(
                    "column `{name}` is {first} in all rows before {} s: a law is found from the answer to changes, so fit a longer part, or record with an input that changes",
                    self.time_s(*fitted)
                ),
            )?;
        }
        Ok(())
    }
}
