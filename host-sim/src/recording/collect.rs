//! Gathering a run's rows in memory, as the columns that would be read back from its file.

use std::path::PathBuf;

use super::write::Kind;
use super::{Column, Layout, Metadata, Recording, RecordingError, Row, Values, Words};

/// Rows gathered in memory instead of in a file.
#[derive(Debug)]
pub struct Collector {
    layout: Layout,
    recording: Recording,
}

impl Collector {
    pub fn new(layout: Layout, metadata: &Metadata) -> Self {
        let empty = |kind| match kind {
            Kind::Text => Values::Words(Words::default()),
            Kind::Time | Kind::Number | Kind::Bit => Values::Numbers(Vec::new()),
        };
        let columns = layout.columns().into_iter().map(|(name, kind)| Column { name, values: empty(kind) }).collect();
        Self { layout, recording: Recording { path: PathBuf::from("this run"), metadata: metadata.clone(), columns } }
    }

    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn push(&mut self, row: &Row) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        let heaters = (0..self.layout.elements.len()).map(|i| f64::from(row.heaters >> i & 1));
        let readings =
            row.temperature_c.iter().chain(row.power_w).chain(row.equivalent_power_w).map(|&number| f64::from(number));
        // The columns stand in the order of the layout, in which each kind keeps the order of the row.
        let mut numbers = std::iter::once(row.time_s).chain(readings).chain(heaters).chain(row.conditions());
        let mut words = [row.event, row.state].into_iter();
        for column in &mut self.recording.columns {
            match &mut column.values {
                Values::Numbers(values) => values.extend(numbers.next()),
                Values::Words(values) => words.next().into_iter().for_each(|word| values.push(word)),
            }
        }
        Ok(())
    }

    pub fn finish(mut self, metadata: &Metadata) -> Recording {
        self.recording.metadata.extend(metadata.iter().cloned());
        self.recording
    }
}
