//! What the page can ask of the run, as JSON.

use serde::Deserialize;

use crate::commands::{CommandRefusal, FeedCommand};

/// A command with what it needs: `"stop"`, `{"mark": {"text": "…"}}`.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum CommandMessage {
    Arm,
    Start,
    Stop,
    Acknowledge,
    SelfTest,
    SetPoint { element: String, temperature_c: f64 },
    Mark { text: String },
}

/// The command of a body, and what to say when it is done.
///
/// # Errors
/// If the body is no command.
pub fn command(body: &[u8]) -> Result<(FeedCommand, String), CommandRefusal> {
    let message: CommandMessage =
        serde_json::from_slice(body).map_err(|error| CommandRefusal(format!("no command: {error}")))?;
    let (command, done) = match message {
        CommandMessage::Arm => (FeedCommand::Arm, "Armed for 30 s: start, or heat.".to_owned()),
        CommandMessage::Start => (FeedCommand::Start, "Started.".to_owned()),
        CommandMessage::Stop => (FeedCommand::Stop, "Stopped: heaters are low.".to_owned()),
        CommandMessage::Acknowledge => (FeedCommand::Acknowledge, "Acknowledged.".to_owned()),
        CommandMessage::SelfTest => (FeedCommand::SelfTest, "Self-test begun; its findings are events.".to_owned()),
        CommandMessage::SetPoint { element, temperature_c } => {
            let done = format!("Set-point of {element}: {temperature_c} °C.");
            (FeedCommand::SetPoint { element, temperature_c }, done)
        }
        CommandMessage::Mark { text } => (FeedCommand::Mark { text }, "Marked.".to_owned()),
    };
    Ok((command, done))
}
