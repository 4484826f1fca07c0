//! The labels of a record's conditions, which decide how many columns the regression has.

use super::options::Progress;
use super::record::{RecordError, RecordSource};

/// The labels of all classes: a record with an event column is read once for them.
pub(super) fn labels(source: &mut dyn RecordSource, progress: &mut Progress<'_>) -> Result<Vec<String>, RecordError> {
    if source.survey().event_column.is_some() {
        source.restart()?;
        let (mut done, rows) = (0, source.survey().rows);
        while let Some(block) = source.next_block()? {
            done += block.len() as u64;
            progress("looking for events", done, rows);
        }
    }
    Ok(source.classes().to_vec())
}
