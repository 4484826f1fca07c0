//! One listener: who it is, what it asks for, and the answer.

use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::json;

use super::http::{PageRequest, answer, answer_events, page_text};
use super::message::{LayoutMessage, RowsMessage, SpectrumMessage, command, event};
use super::spectrum::welch;
use super::state::{PageState, WINDOWS_S};
use crate::commands::{CommandRefusal, FeedCommands};
use crate::feed::lock;
use crate::listen::{Token, check_http};

/// Longest time that a command waits for its answer: a tick, and repeats to a board.
const TIMEOUT: Duration = Duration::from_secs(15);
/// Longest time for a listener to send its request, or to take what it gets.
const SLOWEST: Duration = Duration::from_secs(5);
/// Between two pictures.
const PICTURE: Duration = Duration::from_millis(100);
/// Between two spectra.
const SPECTRUM: Duration = Duration::from_secs(1);
/// Between two signs of life, without which nobody notices that a page was closed.
const SIGN: Duration = Duration::from_secs(5);

/// State that all listeners share.
#[derive(Clone)]
pub struct Served {
    pub state: Arc<Mutex<PageState>>,
    pub commands: Option<FeedCommands>,
    pub address: SocketAddr,
    pub token: Token,
}

impl Served {
    /// Answers one request.
    ///
    /// # Errors
    /// If the listener goes away, or sends no request.
    pub fn answer(&self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_read_timeout(Some(SLOWEST))?;
        stream.set_write_timeout(Some(SLOWEST))?;
        let asked = PageRequest::read(&mut stream)?;
        let text = "text/plain; charset=utf-8";
        let (given, path) = asked.path().trim_start_matches('/').split_once('/').unzip();
        let (host, origin) = (asked.header("host"), asked.header("origin"));
        if let Err(refusal) = check_http(self.address, host, origin, (&self.token, given)) {
            return answer(&mut stream, "403 Forbidden", text, refusal.to_string().as_bytes());
        }
        match (asked.method.as_str(), path.unwrap_or_default()) {
            ("GET", "") => answer(&mut stream, "200 OK", "text/html; charset=utf-8", page_text().as_bytes()),
            ("GET", "events") => self.send_events(&mut stream, &asked),
            ("POST", "command") => {
                let (status, body) = match self.carry_out(&asked) {
                    Ok(done) => ("200 OK", json!({ "done": done })),
                    Err(refusal) => ("409 Conflict", json!({ "refused": refusal.0 })),
                };
                answer(&mut stream, status, "application/json", body.to_string().as_bytes())
            }
            _ => answer(&mut stream, "404 Not Found", text, b"there is no such page"),
        }
    }

    fn carry_out(&self, asked: &PageRequest) -> Result<String, CommandRefusal> {
        let refuse = |sentence: &str| CommandRefusal(sentence.to_owned());
        let commands = self.commands.as_ref().ok_or_else(|| refuse("this is a recording: it takes no commands"))?;
        // No form of another page can send this type without being asked beforehand.
        if !asked.header("content-type").is_some_and(|kind| kind.starts_with("application/json")) {
            return Err(refuse("a command is JSON"));
        }
        let (command, done) = command(&asked.body)?;
        commands.ask(command, TIMEOUT)?;
        Ok(done)
    }

    /// Pictures until the listener goes away, or there are no more.
    fn send_events(&self, stream: &mut impl Write, asked: &PageRequest) -> io::Result<()> {
        let number = |key| asked.query(key).and_then(|text| text.parse::<f64>().ok());
        let wanted_s = number("window_s").unwrap_or(WINDOWS_S[1]);
        let window = WINDOWS_S.iter().position(|&window_s| window_s >= wanted_s).unwrap_or(WINDOWS_S.len() - 1);
        let channel = number("spectrum").map_or(0, |channel| channel as usize);
        answer_events(stream)?;
        let mut seen = Seen { epoch: None, events: 0, rows: 0, id: i64::MIN };
        let (mut spectrum_due, mut sign_due) = (Instant::now(), Instant::now());
        loop {
            let (mut text, ended) = self.news(window, &mut seen);
            if spectrum_due <= Instant::now() {
                spectrum_due = Instant::now() + SPECTRUM;
                text += &self.spectrum(channel).unwrap_or_default();
            }
            if text.is_empty() && sign_due <= Instant::now() {
                text += ": still here\n\n";
            }
            if !text.is_empty() {
                sign_due = Instant::now() + SIGN;
                stream.write_all(text.as_bytes())?;
            }
            if ended {
                return Ok(());
            }
            std::thread::sleep(PICTURE);
        }
    }

    /// News for a listener, and whether it is the last.
    fn news(&self, window: usize, seen: &mut Seen) -> (String, bool) {
        let state = lock(&self.state);
        let mut text = String::new();
        if seen.epoch != Some(state.epoch) {
            *seen = Seen { epoch: Some(state.epoch), events: 0, rows: 0, id: i64::MIN };
            text += &event("layout", &LayoutMessage::new(&state, window, self.commands.is_some()));
        }
        // First, as a trip is among them.
        for happened in state.events_since(seen.events) {
            text += &event("event", happened);
        }
        seen.events = state.event_count;
        if seen.rows != state.rows
            && let Some(rows) = RowsMessage::since(&state, window, seen.id)
        {
            seen.id = rows.next_id().unwrap_or(seen.id);
            text += &event("rows", &rows);
        }
        seen.rows = state.rows;
        if let Some(ended) = &state.ended {
            text += &event("ended", &json!({ "text": ended }));
        }
        (text, state.ended.is_some())
    }

    fn spectrum(&self, channel: usize) -> Option<String> {
        let (samples, unit, sample_period_s) = {
            let state = lock(&self.state);
            (state.samples(channel), state.channels.get(channel)?.unit, state.layout.sample_period_s)
        };
        let spectrum = welch(&samples, 1.0 / sample_period_s)?;
        Some(event("spectrum", &SpectrumMessage { spectrum, unit }))
    }
}

/// Place to which a listener has come.
struct Seen {
    epoch: Option<u64>,
    events: u64,
    rows: u64,
    /// Number of the bucket that was sent last.
    id: i64,
}
