//! A record in memory, from arrays or from another source.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::classes::Classes;
use super::error::{RecordError, finite};
use super::source::{BLOCK, Block, RecordSource, Survey};
use recording::{ColumnValues, ColumnWords};

/// Rows are cut into blocks once, so that passes over them copy nothing.
#[derive(Debug, Clone)]
pub struct RecordTable {
    survey: Survey,
    blocks: Vec<Block>,
    next: usize,
    classes: Vec<String>,
}

impl RecordTable {
    /// A record of named columns of equal length that begins at 0 s and has one class.
    pub fn new(
        sample_period_s: f64,
        inputs: Vec<(String, Vec<f64>)>,
        outputs: Vec<(String, Vec<f64>)>,
    ) -> Result<Self, RecordError> {
        let path = PathBuf::from("the table");
        let refuse = |sentence: String| Err(RecordError::content(&path, sentence));
        if !(sample_period_s.is_finite() && sample_period_s > 0.0) {
            return refuse("its sample period must be finite and above 0 s".to_owned());
        }
        let (Some(_), Some((_, first))) = (inputs.first(), outputs.first()) else {
            return refuse("needs at least one input and one output".to_owned());
        };
        let rows = first.len();
        if rows < 2 {
            return refuse(format!("has {rows} rows: at least two belong there"));
        }
        for (name, values) in inputs.iter().chain(&outputs) {
            if values.len() != rows {
                return refuse(format!("column `{name}` has {} rows where others have {rows}", values.len()));
            }
            finite(&path, name, values, 0)?;
        }
        let names = |columns: &[(String, Vec<f64>)]| columns.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let cut = |columns: &[(String, Vec<f64>)], from: usize, to: usize| {
            columns.iter().map(|(_, values)| values[from..to].to_vec()).collect::<Vec<_>>()
        };
        let time_s = |row: usize| row as f64 * sample_period_s;
        let blocks = (0..rows).step_by(BLOCK).map(|from| {
            let to = rows.min(from + BLOCK);
            Block {
                inputs: cut(&inputs, from, to),
                outputs: cut(&outputs, from, to),
                class: vec![0; to - from],
                gas: Vec::new(),
                time_s: (time_s(from), time_s(to - 1)),
                ..Block::default()
            }
        });
        let survey = Survey {
            time_column: recording::TIME.to_owned(),
            inputs: names(&inputs),
            outputs: names(&outputs),
            event_column: None,
            gas_column: None,
            rows: rows as u64,
            segments: 1,
            longest_rows: rows as u64,
            start_utc: None,
            first_time_s: 0.0,
            last_time_s: time_s(rows - 1),
            sample_period_s,
            is_uneven: false,
            conditions: None,
            notes: Vec::new(),
            path: path.clone(),
            paths: vec![path.clone()],
        };
        Ok(Self::of(survey, blocks.collect()))
    }

    /// Rows in blocks, of one class.
    pub(super) fn of(survey: Survey, blocks: Vec<Block>) -> Self {
        Self { survey, blocks, next: 0, classes: vec!["all".to_owned()] }
    }

    /// The same record, beginning at another time.
    pub fn starting_at(mut self, first_time_s: f64) -> Self {
        self.survey.first_time_s = first_time_s;
        self
    }

    /// Some rows of a record of one segment that is kept whole, as a record of one class and
    /// without gas. Outputs that are missing stay so, and times stay the record's.
    pub fn part(survey: &Survey, all: &Block, rows: Range<usize>) -> Self {
        let time_s = |row: usize| survey.first_time_s + row as f64 * survey.sample_period_s;
        let cut = |columns: &[Vec<f64>], from: usize, to: usize| {
            columns.iter().map(|values| values[from..to].to_vec()).collect::<Vec<_>>()
        };
        let blocks = rows.clone().step_by(BLOCK).map(|from| {
            let to = rows.end.min(from + BLOCK);
            let missing = all.missing.iter().map(|row| *row as usize).filter(|row| (from..to).contains(row));
            Block {
                inputs: cut(&all.inputs, from, to),
                outputs: cut(&all.outputs, from, to),
                class: vec![0; to - from],
                time_s: (time_s(from), time_s(to - 1)),
                missing: missing.map(|row| (row - from) as u32).collect(),
                ..Block::default()
            }
        });
        let survey = Survey {
            event_column: None,
            gas_column: None,
            rows: rows.len() as u64,
            longest_rows: survey.longest_rows.min(rows.len() as u64),
            first_time_s: time_s(rows.start),
            last_time_s: time_s(rows.end.max(1) - 1),
            notes: Vec::new(),
            ..survey.clone()
        };
        Self::of(survey, blocks.collect())
    }

    /// Gives every row the label of its conditions.
    pub fn with_events<L: AsRef<str>>(mut self, labels: &[L]) -> Result<Self, RecordError> {
        self.check_rows("event", labels.len())?;
        let mut classes = Classes::growing();
        for (at, (block, labels)) in self.blocks.iter_mut().zip(labels.chunks(BLOCK)).enumerate() {
            let mut words = ColumnWords::default();
            labels.iter().for_each(|label| words.push(label.as_ref()));
            let first_row = (at * BLOCK) as u64;
            let (rows, words) = (0..labels.len(), ColumnValues::Words(words));
            classes.fill(&self.survey.path, "event", first_row, &words, rows, &mut block.class)?;
        }
        self.survey.event_column = Some(recording::EVENT.to_owned());
        self.classes = classes.names().to_vec();
        Ok(self)
    }

    /// Gives every row the temperature of the gas.
    pub fn with_gas(mut self, gas_c: &[f64]) -> Result<Self, RecordError> {
        self.check_rows("gas", gas_c.len())?;
        finite(&self.survey.path, "gas", gas_c, 0)?;
        for (block, gas_c) in self.blocks.iter_mut().zip(gas_c.chunks(BLOCK)) {
            block.gas = gas_c.to_vec();
        }
        self.survey.gas_column = Some("gas".to_owned());
        Ok(self)
    }

    /// What errors and provenance call the table.
    #[must_use]
    pub fn named(mut self, path: &Path) -> Self {
        self.survey.path = path.to_owned();
        self.survey.paths = vec![path.to_owned()];
        self
    }

    fn check_rows(&self, column: &str, rows: usize) -> Result<(), RecordError> {
        if rows as u64 == self.survey.rows {
            return Ok(());
        }
        let sentence = format!("column `{column}` has {rows} rows where others have {}", self.survey.rows);
        Err(RecordError::content(&self.survey.path, sentence))
    }
}

impl RecordSource for RecordTable {
    fn survey(&self) -> &Survey {
        &self.survey
    }

    fn next_block(&mut self) -> Result<Option<&Block>, RecordError> {
        let block = self.blocks.get(self.next);
        self.next += 1;
        Ok(block)
    }

    fn restart(&mut self) -> Result<(), RecordError> {
        self.next = 0;
        Ok(())
    }

    fn classes(&self) -> &[String] {
        &self.classes
    }
}
