//! Health of a board and the reason of its last start, for people and as JSON.

use std::fmt;

use dr_core::control::{FirstTrip, RunState, Trip};
use serde::Serialize;
use wire::{CrashKind, Identity, ResetCause, Status};

/// A board, and how it has fared since its supply or its reset pin started it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoardStatus {
    /// Name and version of its firmware.
    pub firmware: String,
    /// The number that no other board has.
    pub unique_id: String,
    /// Why it last started.
    pub started: String,
    /// Number of its starts since its supply came up.
    pub starts: u32,
    /// Seconds since it last started.
    pub uptime_s: u32,
    /// Run state.
    pub state: String,
    /// Three trips in ten minutes have locked it.
    pub locked: bool,
    /// Trips since its supply or its reset pin started it.
    pub trips: u32,
    /// The first of them.
    pub first_trip: Option<FirstTripReport>,
    /// Bit flips found in its memory.
    pub bit_flips: u32,
    /// Times that its heaters were lowered since levels had not been decided anew in time.
    pub deadlines: u32,
    /// Ticks that came before the one before was through.
    pub late_ticks: u32,
    /// Ticks that the wind estimate has missed.
    pub missed_estimates: u32,
    /// Longest time from the edge of a conversion to the heaters' pins in the last run, µs.
    pub edge_to_pins_us: u32,
    /// Frames that it could not read.
    pub damaged: u32,
}

/// The first trip of a board.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstTripReport {
    /// Why.
    pub cause: &'static str,
    /// Element; none for the whole instrument.
    pub element: Option<u8>,
    /// Seconds that its sample clock had run since its supply or its reset pin started it.
    pub at_s: u32,
}

impl BoardStatus {
    pub(super) fn of(identity: &Identity, status: &Status) -> Self {
        let Status { control, .. } = status;
        let [low, middle, high] = identity.unique_id;
        Self {
            firmware: identity.firmware.to_string(),
            unique_id: format!("{high:08x}{middle:08x}{low:08x}"),
            started: why_it_started(identity),
            starts: identity.starts,
            uptime_s: status.uptime_s,
            state: match control.state {
                RunState::Standby => "standby".to_owned(),
                RunState::Running => "running".to_owned(),
                RunState::Testing => "testing".to_owned(),
                RunState::Tripped(trip) => format!("tripped: {}", of_trip(trip.cause.name(), trip.element)),
            },
            locked: control.history.is_locked,
            trips: control.history.trips,
            first_trip: control.history.first.map(|FirstTrip { trip: Trip { cause, element }, at_s }| {
                FirstTripReport { cause: cause.name(), element, at_s }
            }),
            bit_flips: control.bit_flips,
            deadlines: status.deadlines,
            late_ticks: control.late_ticks,
            missed_estimates: control.missed_estimates,
            edge_to_pins_us: control.edge_to_pins_us,
            damaged: status.link.damaged + status.link.oversized,
        }
    }
}

fn of_trip(cause: &str, element: Option<u8>) -> String {
    element.map_or_else(|| cause.to_owned(), |element| format!("{cause}, element {element}"))
}

impl fmt::Display for BoardStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, number {}", self.firmware, self.unique_id)?;
        writeln!(f, "up for {} s, since {} (start {})", self.uptime_s, self.started, self.starts)?;
        let locked = if self.locked { "; locked until the supply or the reset pin restarts it" } else { "" };
        writeln!(f, "{}{locked}", self.state)?;
        write!(f, "trips: {}", self.trips)?;
        if let Some(FirstTripReport { cause, element, at_s }) = &self.first_trip {
            write!(f, "; the first after {at_s} s: {}", of_trip(cause, *element))?;
        }
        let Self { bit_flips, deadlines, late_ticks, missed_estimates, edge_to_pins_us, damaged, .. } = self;
        write!(f, "\nbit flips: {bit_flips}; deadlines missed: {deadlines}; late ticks: {late_ticks}; ")?;
        writeln!(f, "wind estimates missed: {missed_estimates}; damaged frames: {damaged}")?;
        writeln!(f, "levels on the pins {edge_to_pins_us} µs after their conversion at most")
    }
}

/// Why a board has started, as a clause.
pub fn why_it_started(identity: &Identity) -> String {
    let crash = identity.crash.as_ref().map(|crash| match crash.kind {
        CrashKind::Panic => format!("its firmware panicked at {}:{}", crash.file, crash.at),
        CrashKind::Fault => format!("its processor faulted at {:#010x}", crash.at),
    });
    let reset = match identity.reset {
        ResetCause::PowerOn => "its supply was gone",
        ResetCause::Pin => "somebody reset it",
        ResetCause::Software => "its firmware ran into an error",
        ResetCause::Watchdog => "a task of its firmware hung",
        ResetCause::BrownOut => "its supply dipped",
        ResetCause::Unknown => "it does not know why",
    };
    crash.unwrap_or_else(|| reset.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::control::{Cause, TripHistory};
    use wire::{BoardKind, ControlStatus, LinkCounters, Name, ResetCause};

    #[test]
    fn a_locked_board_says_so_with_its_first_trip_and_when_it_was() {
        let identity = Identity {
            firmware: Name::try_from("anemo 0.2.0").unwrap(),
            board: BoardKind::Sensor,
            elements: 6,
            order: 8,
            reset: ResetCause::Watchdog,
            starts: 2,
            crash: None,
            unique_id: [1, 2, 0xab],
        };
        let first = Some(FirstTrip { trip: Trip::of(2, Cause::Open), at_s: 75 });
        let control = ControlStatus {
            state: RunState::Tripped(Trip::whole(Cause::Watchdog)),
            history: TripHistory { trips: 3, is_locked: true, first },
            edge_to_pins_us: 61,
            ..ControlStatus::default()
        };
        let link = LinkCounters::default();
        let status = Status { uptime_s: 12, link, refused: 0, unsent: 0, deadlines: 1, control };
        let text = BoardStatus::of(&identity, &status).to_string();
        assert_eq!(
            text,
            "anemo 0.2.0, number 000000ab0000000200000001\n\
             up for 12 s, since a task of its firmware hung (start 2)\n\
             tripped: watchdog; locked until the supply or the reset pin restarts it\n\
             trips: 3; the first after 75 s: open, element 2\n\
             bit flips: 0; deadlines missed: 1; late ticks: 0; wind estimates missed: 0; damaged frames: 0\n\
             levels on the pins 61 µs after their conversion at most\n"
        );
    }
}
