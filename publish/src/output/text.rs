//! Outputs of lines: a format, and a way that carries it.

use super::carrier::{self, Carrier};
use super::{Output, PublishContext, PublishError};
use crate::feed::{FeedEvent, FeedLayout, FeedRow};
use crate::format::{FeedColumns, gill, influx, nmea};
use crate::target::{PublishFormat, PublishTarget};
use std::sync::Arc;

struct TextOutput {
    format: PublishFormat,
    /// What Influx's lines begin with.
    tags: String,
    columns: FeedColumns,
    carrier: Box<dyn Carrier>,
}

/// Opens the way.
pub(super) fn open(
    target: &PublishTarget,
    layout: &FeedLayout,
    context: &PublishContext,
) -> Result<Box<dyn Output>, PublishError> {
    let carrier = carrier::open(target, &context.listening)?;
    let (tags, columns) = (influx::tags(layout), FeedColumns::new(layout));
    Ok(Box::new(TextOutput { format: target.format, tags, columns, carrier }))
}

impl Output for TextOutput {
    fn row(&mut self, row: &Arc<FeedRow>) -> Result<(), PublishError> {
        let line = match (self.format, &row.wind) {
            (PublishFormat::Nmea, Some(wind)) => nmea::mwv(wind),
            (PublishFormat::GillPolar, Some(wind)) => gill::polar(wind),
            (PublishFormat::GillUv, Some(wind)) => gill::uv(wind),
            (PublishFormat::Influx, _) => influx::line(&self.tags, &self.columns, row),
            _ => return Ok(()),
        };
        self.carrier.send(&line)
    }

    fn event(&mut self, event: &FeedEvent) -> Result<(), PublishError> {
        match self.format {
            PublishFormat::Influx => self.carrier.send(&influx::event(&self.tags, event)),
            _ => Ok(()),
        }
    }

    fn turn(&mut self) -> Result<(), PublishError> {
        self.carrier.turn(false)
    }

    fn end(&mut self) {
        // Nobody is left to be told.
        self.carrier.turn(true).ok();
    }
}
