//! Outputs of lines: a format, and a way that carries it.

use super::carrier::{self, Carrier};
use super::context::{Output, PublishContext, PublishError};
use crate::feed::FeedRow;
use crate::format::{gill, nmea};
use crate::target::{PublishFormat, PublishTarget};
use std::sync::Arc;

struct TextOutput {
    format: PublishFormat,
    carrier: Box<dyn Carrier>,
}

/// Opens the way.
pub(super) fn open(target: &PublishTarget, context: &PublishContext) -> Result<Box<dyn Output>, PublishError> {
    let carrier = carrier::open(target, &context.listening)?;
    Ok(Box::new(TextOutput { format: target.format, carrier }))
}

impl Output for TextOutput {
    fn row(&mut self, row: &Arc<FeedRow>) -> Result<(), PublishError> {
        let line = match (self.format, &row.wind) {
            (PublishFormat::Nmea, Some(wind)) => nmea::mwv(wind),
            (PublishFormat::GillPolar, Some(wind)) => gill::polar(wind),
            (PublishFormat::GillUv, Some(wind)) => gill::uv(wind),
            _ => return Ok(()),
        };
        self.carrier.send(&line)
    }

    fn turn(&mut self) -> Result<(), PublishError> {
        self.carrier.turn()
    }
}
