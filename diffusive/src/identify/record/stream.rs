//! A record read from its file, block by block.

use std::path::Path;

use super::classes::Classes;
use super::clock::{Clock, ClockFault};
use super::error::{RecordError, finite};
use super::extent::{extent, gap};
use super::roles::{Roles, shown};
use super::source::{Block, RecordSource, Selection, Survey};
use crate::model::Conditions;
use recording::{ColumnValues, ColumnWords, GAS_TEMPERATURE, RecordingColumn, RecordingReader};

/// The state in which our instrument keeps to its drives.
const RUNNING: &str = "running";

/// Note on a recording of our instrument whose gas column is not used.
const OSCILLATING: &str = "the gas temperature oscillated while this was recorded, and its column `gas_temperature_c` is left out: \
    structure `conductance` takes it with --gas-temperature gas_temperature_c";

/// A Parquet or CSV file as a record.
pub struct RecordStream {
    survey: Survey,
    roles: Roles,
    /// The columns that are read, each once.
    columns: Vec<usize>,
    reader: RecordingReader,
    clock: Clock,
    classes: Classes,
    block: Block,
    /// States other than running, with their first row and how many rows they hold.
    stops: Vec<(String, u64, u64)>,
    read_once: bool,
}

impl RecordStream {
    /// Looks at the head and the end of a record, and decides which columns play which part.
    pub fn open(path: &Path, selection: &Selection) -> Result<Self, RecordError> {
        let roles = Roles::choose(path, selection)?;
        let extent = extent(path, roles.time)?;
        let mut reader = RecordingReader::open(path)?;
        let mut notes = roles.notes.clone();
        if roles.gas.is_none() && reader.names().iter().any(|name| name == GAS_TEMPERATURE) {
            notes.push(OSCILLATING.to_owned());
        }
        let name = |&column: &usize| reader.names()[column].clone();
        let survey = Survey {
            path: path.to_owned(),
            time_column: name(&roles.time),
            inputs: roles.inputs.iter().map(name).collect(),
            outputs: roles.outputs.iter().map(name).collect(),
            event_column: roles.event.as_ref().map(name),
            gas_column: roles.gas.as_ref().map(name),
            rows: extent.rows,
            first_time_s: extent.clock.first_s,
            last_time_s: extent.last_s,
            sample_period_s: extent.clock.period_s,
            conditions: Conditions::of_metadata(&reader.metadata()),
            notes,
        };
        let mut columns = vec![roles.time];
        for &column in
            roles.inputs.iter().chain(&roles.outputs).chain(&roles.event).chain(&roles.gas).chain(&roles.state)
        {
            if !columns.contains(&column) {
                columns.push(column);
            }
        }
        let classes = if roles.event.is_some() { Classes::growing() } else { Classes::none() };
        prepare(&mut reader, &columns, &roles);
        Ok(Self {
            survey,
            roles,
            columns,
            reader,
            clock: extent.clock,
            classes,
            block: Block::default(),
            stops: Vec::new(),
            read_once: false,
        })
    }

    /// Makes a block of a chunk, whose columns are taken rather than copied.
    fn take(&mut self, mut chunk: Vec<RecordingColumn>) -> Result<(), RecordError> {
        let Self { survey, roles, columns, block, .. } = self;
        let path = &survey.path;
        let first_row = self.clock.rows();
        let slot = |column: usize| columns.iter().position(|&read| read == column).unwrap_or_default();

        let time_s = numbers(path, &survey.time_column, &mut chunk[slot(roles.time)], first_row)?;
        let rows = time_s.len();
        if let Err(ClockFault { sentence, is_drift }) = self.clock.pass(&survey.time_column, time_s) {
            // A gap further on stretches the mean period, by which the rows before it seem to
            // drift.
            let gap = if is_drift { gap(path, roles.time, &survey.time_column, &self.clock)? } else { None };
            return Err(RecordError::content(path, gap.unwrap_or(sentence)));
        }
        block.time_s = (time_s[0], time_s[rows - 1]);
        match roles.event {
            Some(event) => {
                let RecordingColumn { name, values, .. } = &chunk[slot(event)];
                self.classes.fill(path, name, first_row, values, &mut block.class)?;
            }
            None => block.class.resize(rows, 0),
        }
        if let (Some(state), false) = (roles.state, self.read_once)
            && let ColumnValues::Words(states) = &chunk[slot(state)].values
        {
            count_stops(&mut self.stops, states, first_row);
        }
        // A gas column may be an output as well, so it is copied before that is taken.
        block.gas.clear();
        if let (Some(gas), Some(name)) = (roles.gas, &survey.gas_column) {
            block.gas.extend_from_slice(numbers(path, name, &mut chunk[slot(gas)], first_row)?);
            finite(path, name, &block.gas, first_row)?;
        }
        for (columns, names, into) in
            [(&roles.inputs, &survey.inputs, &mut block.inputs), (&roles.outputs, &survey.outputs, &mut block.outputs)]
        {
            into.clear();
            for (&column, name) in columns.iter().zip(names) {
                let values = numbers(path, name, &mut chunk[slot(column)], first_row)?;
                finite(path, name, values, first_row)?;
                into.push(std::mem::take(values));
            }
        }
        Ok(())
    }

    /// Writes down what only a whole pass tells.
    fn finish(&mut self) {
        if std::mem::replace(&mut self.read_once, true) {
            return;
        }
        self.survey.rows = self.clock.rows();
        for (state, first, rows) in &self.stops {
            self.survey.notes.push(format!(
                "`state` is `{state}` in {rows} rows, first in row {first}: the heaters are off there, whatever their drives say"
            ));
        }
        if let (Some(event), [only]) = (&self.survey.event_column, self.classes.names())
            && self.roles.event_was_named
        {
            self.survey.notes.push(format!("column `{event}` has one label only, `{only}`: there is one class"));
        }
    }
}

impl RecordSource for RecordStream {
    fn survey(&self) -> &Survey {
        &self.survey
    }

    fn next_block(&mut self) -> Result<Option<&Block>, RecordError> {
        match self.reader.next_chunk()? {
            Some(chunk) => {
                self.take(chunk)?;
                Ok(Some(&self.block))
            }
            None => {
                self.finish();
                Ok(None)
            }
        }
    }

    fn restart(&mut self) -> Result<(), RecordError> {
        self.reader = RecordingReader::open(&self.survey.path)?;
        prepare(&mut self.reader, &self.columns, &self.roles);
        self.clock.restart();
        if !self.read_once {
            self.stops.clear();
        }
        Ok(())
    }

    fn classes(&self) -> &[String] {
        self.classes.names()
    }
}

fn prepare(reader: &mut RecordingReader, columns: &[usize], roles: &Roles) {
    reader.select(columns);
    if let Some(event) = roles.event {
        reader.read_as_text(event);
    }
}

fn count_stops(stops: &mut Vec<(String, u64, u64)>, states: &ColumnWords, first_row: u64) {
    for (from, to, state) in states.stretches().filter(|(_, _, state)| *state != RUNNING) {
        let rows = (to - from) as u64;
        let few = stops.len() < 8;
        match stops.iter_mut().find(|(known, ..)| known == state) {
            Some((.., all)) => *all += rows,
            // Causes of trips are few; a foreign column of ever new words must not pile up.
            None if few => stops.push((state.to_owned(), first_row + from as u64 + 1, rows)),
            None => {}
        }
    }
}

/// The values of a column that must be numbers.
fn numbers<'c>(
    path: &Path,
    name: &str,
    column: &'c mut RecordingColumn,
    first_row: u64,
) -> Result<&'c mut Vec<f64>, RecordError> {
    match &mut column.values {
        ColumnValues::Numbers(numbers) => Ok(numbers),
        ColumnValues::Words(words) => {
            let text = shown(words.iter().next().unwrap_or_default());
            Err(RecordError::value(path, name, first_row, format!("`{text}` stands where a number belongs")))
        }
    }
}
