//! A log: rows of an instrument until somebody stops it.
//!
//! The end of a run is an event of a log. When the link is lost, or the board starts anew, the
//! [`LogHost`] connects again and the log goes on in the same recording, whose times show the gap.
//! After a reset or a trip it only records: heaters stay low until a person starts them.
//!
//! | file | what |
//! |---|---|
//! | `session` | the loop |
//! | `tick_time` | times of rows, over gaps and resets |
//! | `overheat` | set-points above the measured gas |
//! | this one | requests and their refusals, and trips acknowledged without a person |

mod overheat;
mod session;
mod tick_time;

use std::fmt;

use dr_core::control::{Cause, SelfTestPlan};
use recording::RecordingRow;
use recording::text::count;
use serde::Serialize;

use super::error::{EarlyEnd, RunError};
use crate::instrument::{InstrumentPort, Observation};

pub use overheat::{alternate, set as hold};
pub use session::log;

/// Options of a log.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LogOptions {
    /// Time of the first row, s: a recording that is continued has one before.
    pub begin_s: f64,
    /// A trip ends the log.
    pub ends_at_trip: bool,
    /// Trips are acknowledged, at most two in ten minutes, and never for open, short or
    /// over-temperature. Heaters stay low.
    pub acknowledges: bool,
    /// Set-points are so far above the gas that the reference element measures, K.
    pub overheat_k: Option<f64>,
    /// Gap of a recording that is continued: for how long it has no rows, s.
    pub continued: Option<f64>,
}

/// Services that a log needs of the program around it.
pub trait LogHost {
    /// Opens the instrument, at first and after it was lost.
    ///
    /// # Errors
    /// If it cannot be reached now.
    fn connect(&mut self) -> Result<Box<dyn InstrumentPort>, RunError>;

    /// Tells whether an instrument that is lost can come back.
    fn reconnects(&self) -> bool;

    /// Time since the first row by the clock of the host, s; none where time passes with rows only.
    fn elapsed_s(&self) -> Option<f64>;

    /// Takes a row; so many were lost before it, in all.
    ///
    /// # Errors
    /// [`RunError::Interrupted`] ends the log in order, any other with this reason.
    fn row(&mut self, row: &RecordingRow<'_>, observation: &Observation, lost: u64) -> Result<(), RunError>;

    /// Takes an event.
    fn happened(&mut self, time_s: f64, event: &LogEvent);

    /// The next request, if there is one: asked at every row, and often while there is none.
    fn request(&mut self) -> Option<LogRequest>;

    /// Waits a moment for a lost instrument.
    ///
    /// # Errors
    /// [`RunError::Interrupted`] ends the log.
    fn wait(&mut self) -> Result<(), RunError>;
}

/// Event.
#[derive(Debug, Clone, PartialEq)]
pub enum LogEvent {
    /// The instrument tripped.
    Trip {
        /// Why.
        cause: &'static str,
        /// Where.
        element: String,
    },
    /// The trip was acknowledged without a person.
    Acknowledged,
    /// The instrument cannot be reached.
    LinkLost(String),
    /// It can again.
    LinkBack,
    /// It started anew.
    BoardReset(String),
    /// A recording goes on that has no rows for so long, s.
    Continued(f64),
    /// Somebody wrote this.
    Mark(String),
}

impl fmt::Display for LogEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Trip { cause, element } => write!(f, "tripped: {cause}, {element}"),
            Self::Acknowledged => f.write_str("trip acknowledged automatically; heaters stay low"),
            Self::LinkLost(why) => write!(f, "gap: {why}"),
            Self::LinkBack => f.write_str("link is back"),
            Self::BoardReset(why) => write!(f, "board started anew: {why}; heaters stay low"),
            Self::Continued(without_s) => write!(f, "log started again after {without_s:.2} s without rows"),
            Self::Mark(text) => f.write_str(text),
        }
    }
}

/// Commands of a log.
#[derive(Debug, Clone, PartialEq)]
pub enum LogCommand {
    /// Allow heat for a while: a start, a set-point or a self-test.
    Arm,
    /// Heat by the set-points; the instrument must be armed.
    Start,
    /// Test the elements; the instrument must be armed. Findings are events.
    SelfTest(SelfTestPlan),
    /// Heaters to standby; rows go on.
    Stop,
    /// Acknowledge a trip.
    Acknowledge,
    /// Another set-point; while it heats, the instrument must be armed.
    SetPoint {
        /// Name of the element.
        element: String,
        /// °C.
        temperature_c: f64,
    },
    /// Another pressure of the gas, Pa.
    Pressure(f64),
    /// An event of the next row.
    Mark(String),
}

/// A command, and who waits for its answer.
pub struct LogRequest {
    /// Command.
    pub command: LogCommand,
    /// Takes the answer.
    pub answer: Box<dyn FnOnce(anyhow::Result<()>)>,
}

/// Summary of a log.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct LogSummary {
    /// Title of the experiment.
    pub title: String,
    /// Name of the head.
    pub head: String,
    /// Name and version of the firmware.
    pub firmware: String,
    /// Rows.
    pub rows: u64,
    /// From the first row to the last, s.
    pub duration_s: f64,
    /// Ticks of which no sample arrived, as far as the board counted on.
    pub lost: u64,
    /// Number of times that the link was lost.
    pub gaps: u32,
    /// Number of times that the board started anew.
    pub resets: u32,
    /// Trips.
    pub trips: u32,
    /// The last of them.
    pub last_trip: Option<String>,
    /// Cause of its end, if nobody stopped it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<EarlyEnd>,
}

impl fmt::Display for LogSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} · head {} · {}", self.title, self.head, self.firmware)?;
        let Self { rows, duration_s, lost, gaps, resets, trips, .. } = self;
        let (rows, gaps) = (count(*rows as usize, "row"), count(*gaps as usize, "gap"));
        let (resets, trips) = (count(*resets as usize, "reset"), count(*trips as usize, "trip"));
        writeln!(f, "{rows}, {duration_s:.3} s; {lost} lost, {gaps}, {resets}, {trips}")?;
        self.last_trip.iter().try_for_each(|trip| writeln!(f, "last trip: {trip}"))
    }
}

/// In so long, s …
const WITHIN_S: f64 = 600.0;
/// … at most so many.
const MOST: usize = 2;

/// Counts acknowledges.
#[derive(Default)]
pub(super) struct Acknowledges(Vec<f64>);

impl Acknowledges {
    /// Tells whether a trip for this cause may be acknowledged now; counts it if so. What says that
    /// an element is broken or was too hot never is.
    pub fn grant(&mut self, cause: Cause, now_s: f64) -> bool {
        self.0.retain(|at_s| now_s - at_s < WITHIN_S);
        let is_granted = !matches!(cause, Cause::Open | Cause::Short | Cause::OverTemperature) && self.0.len() < MOST;
        if is_granted {
            self.0.push(now_s);
        }
        is_granted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_in_ten_minutes_and_never_what_is_broken_or_hot() {
        let mut acknowledges = Acknowledges::default();
        for cause in [Cause::Open, Cause::Short, Cause::OverTemperature] {
            assert!(!acknowledges.grant(cause, 0.0));
        }
        let granted =
            [0.0, 1.0, 2.0, 599.0, 600.0, 600.5, 601.0].map(|now_s| acknowledges.grant(Cause::Watchdog, now_s));
        assert_eq!(granted, [true, true, false, false, true, false, true]);
    }
}
