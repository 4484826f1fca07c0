//! Commands that a listener may give to the run, each with an answer: done, or the sentence of a
//! refusal.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use serde::Deserialize;

/// A request to the run; the page sends it as JSON: `"stop"`, `{"mark": {"text": "…"}}`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FeedCommand {
    /// Accept commands that can heat.
    Arm,
    /// Heat, by the set-points.
    Start,
    /// Heaters to standby.
    Stop,
    /// Acknowledge the trip.
    Acknowledge,
    /// Test the elements.
    SelfTest,
    /// Change what an element is held at.
    SetPoint {
        /// The element's name.
        element: String,
        /// °C.
        temperature_c: f64,
    },
    /// Mark an event in the recording.
    Mark {
        /// In the listener's words.
        text: String,
    },
    /// The gas has another pressure; no command of the page.
    #[serde(skip_deserializing)]
    Pressure {
        /// Pa.
        pressure_pa: f64,
    },
}

/// Why the run does not obey: a sentence.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CommandRefusal(pub String);

/// Done, or why not.
pub type CommandAnswer = Result<(), CommandRefusal>;

/// The listeners' end. Clones ask the same run.
#[derive(Debug, Clone)]
pub struct FeedCommands(SyncSender<FeedRequest>);

/// A command and where its answer goes to.
#[derive(Debug)]
pub struct FeedRequest {
    /// Command.
    pub command: FeedCommand,
    answer: SyncSender<CommandAnswer>,
}

/// Requests that wait at most; more are refused, so that nobody can fill memory with them.
const WAITING: usize = 16;

/// Both ends of a queue of commands. The run takes with `try_recv`, between its ticks.
pub fn channel() -> (FeedCommands, Receiver<FeedRequest>) {
    let (sender, receiver) = sync_channel(WAITING);
    (FeedCommands(sender), receiver)
}

impl FeedCommands {
    /// Asks the run and waits for its answer.
    ///
    /// # Errors
    /// A sentence: why the run refused, or that it did not answer within `timeout`.
    pub fn ask(&self, command: FeedCommand, timeout: Duration) -> CommandAnswer {
        let (answer, answered) = sync_channel(1);
        let refuse = |sentence: &str| Err(CommandRefusal(sentence.to_owned()));
        match self.0.try_send(FeedRequest { command, answer }) {
            Ok(()) => match answered.recv_timeout(timeout) {
                Ok(answer) => answer,
                Err(RecvTimeoutError::Timeout) => refuse("the run did not answer in time; it may still obey"),
                Err(RecvTimeoutError::Disconnected) => refuse("the run ended before it answered"),
            },
            Err(TrySendError::Full(_)) => refuse("too many commands wait for the run"),
            Err(TrySendError::Disconnected(_)) => refuse("the run takes no commands"),
        }
    }
}

impl FeedRequest {
    /// Answers. A listener that left does not matter.
    pub fn answer(self, answer: CommandAnswer) {
        self.answer.send(answer).ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn a_command_is_answered_by_the_run() {
        let (commands, requests) = channel();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                for request in requests.iter().take(2) {
                    let refused = request.command == FeedCommand::Start;
                    request.answer(if refused { Err(CommandRefusal("it is tripped".to_owned())) } else { Ok(()) });
                }
            });
            assert_eq!(commands.ask(FeedCommand::Start, LONG), Err(CommandRefusal("it is tripped".to_owned())));
            assert_eq!(commands.ask(FeedCommand::Stop, LONG), Ok(()));
        });
        assert_eq!(commands.ask(FeedCommand::Stop, LONG), Err(CommandRefusal("the run takes no commands".to_owned())));
    }

    #[test]
    fn a_run_that_does_not_listen_costs_a_listener_its_patience_and_no_memory() {
        let (commands, _requests) = channel();
        for _ in 0..WAITING {
            assert!(commands.ask(FeedCommand::Arm, Duration::ZERO).unwrap_err().0.contains("in time"));
        }
        assert!(commands.ask(FeedCommand::Arm, LONG).unwrap_err().0.contains("too many"));
    }
}
