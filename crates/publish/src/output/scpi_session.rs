//! The language of SCPI: what a line is answered with. Without sockets, so that tests read it.
//!
//! | message | answer |
//! |---|---|
//! | `*IDN?` | `anemo,<head>,<chip's number>,<firmware>` |
//! | `*CLS`, `*OPC?`, `SYSTem:ERRor[:NEXT]?`, `SYSTem:VERSion?` | as the standard says (SCPI-99) |
//! | `MEASure:WIND?` | speed in m/s, direction from which it blows in °, their standard uncertainties |
//! | `MEASure:WIND:SPEed?`, `MEASure:WIND:DIRection?`, `MEASure:WIND:VECTor?` | one of them; the vector towards, m/s |
//! | `MEASure:TEMPerature?`, `MEASure:POWer?` | one number an element, °C and W |
//! | `STATus:QUEStionable?`, `STATus:OPERation?` | quality flags; the instrument's state |
//! | `SYSTem:PASSword "<token>"` | allows what follows |
//! | `INITiate`, `ABORt`, `OUTPut:ARM`, `OUTPut:PROTection:CLEar`, `CALibration:TEST` | start, stop, arm, acknowledge, self-test |
//! | `SOURce:TEMPerature "<element>",<°C>`, `SYSTem:MARK "<text>"` | set-point; event mark |
//! | `SOURce:PRESsure <Pa>` | pressure of the gas, as a barometer elsewhere measures it |
//!
//! A value that is not known, or not valid, is 9.91E37, the standard's not-a-number. The crate
//! `scpi` was weighed: it depends on releases of `lexical-core` with known unsoundness.

use crate::commands::{FeedCommand, FeedCommands};
use crate::feed::{FeedLayout, FeedRow, FeedWind, lock};
use crate::listen::Token;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Instrument that sessions show, and whom they ask.
pub(super) struct ScpiInstrument {
    pub(super) layout: FeedLayout,
    pub(super) latest: Mutex<ScpiLatest>,
    pub(super) token: Token,
    pub(super) commands: Option<FeedCommands>,
}

/// The latest row, and the latest wind estimate.
#[derive(Default)]
pub(super) struct ScpiLatest {
    pub(super) row: Option<Arc<FeedRow>>,
    pub(super) wind: Option<FeedWind>,
}

/// One connection.
#[derive(Default)]
pub(super) struct ScpiSession {
    errors: VecDeque<ScpiError>,
    is_allowed: bool,
}

/// Number and text of an error, those of SCPI-99 where it has one.
#[derive(Debug, Clone, PartialEq, Eq)]
struct ScpiError(i16, String);

type CommandOf = fn(&str) -> Result<FeedCommand, ScpiError>;

/// Commands by their headers, each made of its parameters.
const COMMANDS: [(&str, CommandOf); 8] = [
    ("INITiate", |_| Ok(FeedCommand::Start)),
    ("ABORt", |_| Ok(FeedCommand::Stop)),
    ("OUTPut:ARM", |_| Ok(FeedCommand::Arm)),
    ("OUTPut:PROTection:CLEar", |_| Ok(FeedCommand::Acknowledge)),
    ("CALibration:TEST", |_| Ok(FeedCommand::SelfTest)),
    ("SYSTem:MARK", |text| Ok(FeedCommand::Mark { text: quoted(text)?.to_owned() })),
    ("SOURce:TEMPerature", set_point),
    ("SOURce:PRESsure", |pressure| Ok(FeedCommand::Pressure { pressure_pa: decimal(pressure)? })),
];

/// Errors that wait; the last one then says that there were more.
const MOST_ERRORS: usize = 16;
/// The run answers between two ticks; a board may take longer to be reached.
const PATIENCE: Duration = Duration::from_secs(5);
const NOT_A_NUMBER: &str = "9.91E37";

impl ScpiSession {
    /// The answers to a line, joined by semicolons; none if nothing was asked.
    pub(super) fn answer(&mut self, line: &str, instrument: &ScpiInstrument) -> Option<String> {
        let mut answers = Vec::new();
        for message in split(line, ';') {
            match self.message(message.trim(), instrument) {
                Ok(answer) => answers.extend(answer),
                Err(_) if self.errors.len() >= MOST_ERRORS => {
                    self.errors.pop_back();
                    self.errors.push_back(ScpiError(-350, "Queue overflow".to_owned()));
                }
                Err(error) => self.errors.push_back(error),
            }
        }
        (!answers.is_empty()).then(|| answers.join(";"))
    }

    fn message(&mut self, message: &str, instrument: &ScpiInstrument) -> Result<Option<String>, ScpiError> {
        let (header, parameters) = message.split_once(char::is_whitespace).unwrap_or((message, ""));
        let header = header.strip_prefix(':').unwrap_or(header);
        if header.is_empty() {
            return Ok(None);
        }
        let is = |pattern: &str| matches(header, pattern);
        if header.ends_with('?') {
            if is("SYSTem:ERRor?") || is("SYSTem:ERRor:NEXT?") {
                let ScpiError(number, text) = self.errors.pop_front().unwrap_or(ScpiError(0, "No error".to_owned()));
                return Ok(Some(format!("{number},\"{}\"", text.replace('"', "'"))));
            }
            return query(header, instrument).map(Some).ok_or_else(undefined);
        }
        if is("*CLS") {
            self.errors.clear();
            return Ok(None);
        } else if is("SYSTem:PASSword") {
            self.is_allowed = instrument.token.is(quoted(parameters)?);
            return if self.is_allowed {
                Ok(None)
            } else {
                Err(ScpiError(-221, "Settings conflict; wrong token".to_owned()))
            };
        }
        let command = match COMMANDS.iter().find(|(pattern, _)| is(pattern)) {
            Some((_, command)) => command(parameters)?,
            None => return Err(undefined()),
        };
        if !self.is_allowed {
            return Err(ScpiError(-203, "Command protected; SYST:PASS \"<token>\" first".to_owned()));
        }
        let commands = instrument.commands.as_ref();
        let refuse = |why: String| ScpiError(-200, format!("Execution error; {why}"));
        let commands = commands.ok_or_else(|| refuse("the run takes no commands".to_owned()))?;
        commands.ask(command, PATIENCE).map_err(|refusal| refuse(refusal.0))?;
        Ok(None)
    }
}

fn undefined() -> ScpiError {
    ScpiError(-113, "Undefined header".to_owned())
}

/// The answer to a query; none if there is no such query.
fn query(header: &str, instrument: &ScpiInstrument) -> Option<String> {
    let latest = lock(&instrument.latest);
    let layout = &instrument.layout;
    let (row, wind) = (latest.row.as_deref(), latest.wind.as_ref());
    let speed = || number(wind.filter(|wind| wind.is_valid()).map(|wind| wind.estimate.speed_m_s));
    let from = || number(wind.filter(|wind| wind.has_direction()).map(|wind| wind.from_deg as f32));
    let valid = wind.filter(|wind| wind.is_valid()).map(|wind| &wind.estimate);
    let each = |of: fn(&FeedRow) -> &[f32]| {
        let numbers = row.map_or(vec![f32::NAN; layout.elements.len()], |row| of(row).to_vec());
        numbers.into_iter().map(|each| number(Some(each))).collect::<Vec<_>>().join(",")
    };
    // Four fields between three commas, whatever the names are.
    let identity = || {
        let fields = [&layout.head, &layout.id(), &layout.firmware];
        fields
            .iter()
            .fold("anemo".to_owned(), |all, field| format!("{all},{}", field.replace([',', ';', '\n', '\r'], " ")))
    };
    let wind_and_errors = || {
        let direction_u_deg = valid.map(|estimate| estimate.direction_error_rad.to_degrees());
        [speed(), from(), number(valid.map(|estimate| estimate.speed_error_m_s)), number(direction_u_deg)].join(",")
    };
    let vector = || {
        let vector = valid.map_or([f32::NAN; 3], |estimate| estimate.wind_m_s);
        vector.map(|each| number(Some(each))).join(",")
    };
    let queries: [(&str, &dyn Fn() -> String); 11] = [
        ("*IDN?", &identity),
        ("*OPC?", &|| "1".to_owned()),
        ("SYSTem:VERSion?", &|| "1999.0".to_owned()),
        ("MEASure:WIND?", &wind_and_errors),
        ("MEASure:WIND:SPEed?", &speed),
        ("MEASure:WIND:DIRection?", &from),
        ("MEASure:WIND:VECTor?", &vector),
        ("MEASure:TEMPerature?", &|| each(|row| &row.temperature_c)),
        ("MEASure:POWer?", &|| each(|row| &row.power_w)),
        ("STATus:QUEStionable?", &|| wind.map_or(0, |wind| wind.estimate.quality_flags.0).to_string()),
        ("STATus:OPERation?", &|| format!("\"{}\"", row.map_or("", |row| &row.state))),
    ];
    queries.iter().find(|(pattern, _)| matches(header, pattern)).map(|(_, answer)| answer())
}

fn number(number: Option<f32>) -> String {
    number.filter(|number| number.is_finite()).map_or(NOT_A_NUMBER.to_owned(), |number| format!("{number}"))
}

/// Tells whether a header is a pattern's: each word long or short, in letters of any case.
fn matches(header: &str, pattern: &str) -> bool {
    let (header, pattern) = (header.split(':'), pattern.split(':'));
    let is_word = |word: &str, long: &str| {
        let short = long.chars().filter(|letter| !letter.is_ascii_lowercase());
        word.eq_ignore_ascii_case(long) || word.eq_ignore_ascii_case(&short.collect::<String>())
    };
    header.clone().count() == pattern.clone().count() && header.zip(pattern).all(|(word, long)| is_word(word, long))
}

fn set_point(parameters: &str) -> Result<FeedCommand, ScpiError> {
    let mut parameters = split(parameters, ',');
    let missing = || ScpiError(-109, "Missing parameter".to_owned());
    let (element, temperature) = (parameters.next().ok_or_else(missing)?, parameters.next().ok_or_else(missing)?);
    Ok(FeedCommand::SetPoint { temperature_c: decimal(temperature)?, element: quoted(element)?.to_owned() })
}

fn decimal(parameter: &str) -> Result<f64, ScpiError> {
    let number = parameter.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| ScpiError(-120, "Numeric data error".to_owned()))
}

fn quoted(parameter: &str) -> Result<&str, ScpiError> {
    let parameter = parameter.trim();
    let between = |quote| parameter.strip_prefix(quote)?.strip_suffix(quote);
    between('"').or_else(|| between('\'')).ok_or_else(|| ScpiError(-150, "String data error".to_owned()))
}

/// Parts between separators that are not in quotes.
fn split(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut quote = None;
    text.split(move |character| {
        match quote {
            None if character == '"' || character == '\'' => quote = Some(character),
            Some(open) if open == character => quote = None,
            _ => {}
        }
        quote.is_none() && character == separator
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands;
    use crate::format::examples;
    use dr_core::wind::QualityFlags;

    fn instrument() -> ScpiInstrument {
        let wind = examples::wind(2.0, 270.0, QualityFlags::NO_GAS);
        let row = Some(Arc::new(examples::row(None)));
        ScpiInstrument {
            layout: examples::layout(),
            latest: Mutex::new(ScpiLatest { row, wind: Some(wind) }),
            token: Token::new("a-token-of-the-test").expect("long enough"),
            commands: None,
        }
    }

    #[test]
    fn queries_are_answered_in_any_of_their_forms() {
        let (instrument, mut session) = (instrument(), ScpiSession::default());
        let mut ask = |line: &str| session.answer(line, &instrument).unwrap_or_default();
        assert_eq!(ask("*idn?"), "anemo,sphere  silver,000000010000abcdffffffff,anemo 0.2.0");
        assert_eq!(ask("MEAS:WIND:SPE?"), "2");
        assert_eq!(ask(":measure:Wind:DIRection?;*OPC?"), "270;1");
        assert_eq!(ask("MEAS:WIND?"), "2,270,0.25,5.729578");
        assert_eq!(ask("MEAS:TEMP?"), "60.1,9.91E37");
        assert_eq!(ask("STAT:QUES?;:STAT:OPER?"), "256;\"running\"");
        assert_eq!(ask("SYST:ERR?"), "0,\"No error\"");
    }

    #[test]
    fn before_the_first_row_there_are_no_numbers() {
        let instrument = ScpiInstrument { latest: Mutex::default(), ..instrument() };
        let answer = ScpiSession::default().answer("MEAS:WIND:VECT?;MEAS:POW?", &instrument);
        assert_eq!(answer.as_deref(), Some("9.91E37,9.91E37,9.91E37;9.91E37,9.91E37"));
    }

    #[test]
    fn errors_wait_in_a_queue_that_has_an_end() {
        let (instrument, mut session) = (instrument(), ScpiSession::default());
        assert_eq!(session.answer("MEAS:WINDS?;SOUR:TEMP \"core\"", &instrument), None);
        assert_eq!(session.answer("SYST:ERR?", &instrument).as_deref(), Some("-113,\"Undefined header\""));
        assert_eq!(session.answer("SYST:ERR:NEXT?", &instrument).as_deref(), Some("-109,\"Missing parameter\""));
        for _ in 0..100 {
            session.answer("GET / HTTP/1.1", &instrument);
        }
        assert_eq!(session.errors.len(), MOST_ERRORS);
        assert_eq!(session.errors.back().map(|error| error.0), Some(-350));
        session.answer("*CLS", &instrument);
        assert!(session.errors.is_empty());
    }

    #[test]
    fn nothing_heats_without_the_token() {
        let (asked, requests) = commands::channel();
        let instrument = ScpiInstrument { commands: Some(asked), ..instrument() };
        let mut session = ScpiSession::default();
        for line in ["INIT", "SYST:PASS \"a guess\";INIT", "OUTP:ARM;:SOUR:TEMP 'core',90"] {
            session.answer(line, &instrument);
            assert!(session.errors.back().is_some_and(|error| error.0 == -203), "{line}");
        }
        assert!(requests.try_recv().is_err(), "the run has heard of none");
        std::thread::scope(|scope| {
            let run = scope.spawn(move || {
                let asked = [(); 2].map(|()| {
                    let request = requests.recv().expect("a request");
                    let command = request.command.clone();
                    request.answer(Ok(()));
                    command
                });
                requests.recv().expect("a request").answer(Err(commands::CommandRefusal("tripped".to_owned())));
                asked
            });
            session.answer(
                "*CLS;SYST:PASS \"a-token-of-the-test\";SOUR:TEMP 'core;1',90.5;SOUR:PRES x;:SOUR:PRES 7.1e2;INIT",
                &instrument,
            );
            let set = FeedCommand::SetPoint { element: "core;1".to_owned(), temperature_c: 90.5 };
            let wanted = [set, FeedCommand::Pressure { pressure_pa: 710.0 }];
            assert_eq!(run.join().expect("no panic"), wanted);
        });
        let wrong = ScpiError(-120, "Numeric data error".to_owned());
        assert_eq!(session.errors, [wrong, ScpiError(-200, "Execution error; tripped".to_owned())]);
    }

    #[test]
    fn no_bytes_break_it_or_heat() {
        let (asked, requests) = commands::channel();
        let instrument = ScpiInstrument { commands: Some(asked), ..instrument() };
        let mut session = ScpiSession::default();
        let pieces =
            ["SYST", ":", "PASS", "\"", "'", ";", " ", ",", "?", "*IDN?", "INIT", "SOUR:TEMP", "é", "9e999", "\0"];
        let mut state = 1_u64;
        for _ in 0..20_000 {
            let mut line = String::new();
            for _ in 0..8 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                line.push_str(pieces[(state >> 33) as usize % pieces.len()]);
            }
            session.answer(&line, &instrument);
        }
        assert!(requests.try_recv().is_err());
    }
}
