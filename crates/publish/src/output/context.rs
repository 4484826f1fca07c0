//! What every output gets and does, and why one does not work.

use crate::commands::FeedCommands;
use crate::feed::{FeedEvent, FeedRow};
use crate::listen::{ListenError, Listening};
use std::io::{self, Read, Write};
use std::sync::Arc;

/// What outputs need besides the feed.
#[derive(Clone)]
pub struct PublishContext {
    /// What listeners may bind to.
    pub listening: Listening,
    /// Where commands go to; without, every command is refused.
    pub commands: Option<FeedCommands>,
    /// Takes sentences for the user.
    pub report: Arc<dyn Fn(&str) + Send + Sync>,
}

/// Why an output does not work.
#[derive(Debug, thiserror::Error)]
pub enum PublishError {
    /// It cannot listen.
    #[error(transparent)]
    Listen(#[from] ListenError),
    /// It cannot be reached, or is no more.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It was reached and refuses.
    #[error("{0}")]
    Refused(String),
}

#[cfg(not(feature = "tls"))]
impl PublishError {
    pub(super) fn no_tls() -> Self {
        Self::Refused("this program was built without the feature `tls`".to_owned())
    }
}

/// One way out, open.
pub(super) trait Output: Send {
    /// Sends a row.
    fn row(&mut self, row: &Arc<FeedRow>) -> Result<(), PublishError>;

    /// Sends an event.
    fn event(&mut self, _event: &FeedEvent) -> Result<(), PublishError> {
        Ok(())
    }

    /// What is to be done several times a second, whether there is a row or not.
    fn turn(&mut self) -> Result<(), PublishError> {
        Ok(())
    }

    /// Says good-bye.
    fn end(&mut self) {}
}

/// A stream to a broker, encrypted or not.
pub(super) trait BrokerStream: Read + Write + Send {}
impl<T: Read + Write + Send> BrokerStream for T {}
