//! Health of the firmware: feeding of the watchdog, the status of each second, identity, and log
//! messages.

use crate::board::{self, Watchdog};
use crate::mcu::ticking::BEATS_PER_SECOND;
use dr_core::control::RunState;
use dr_core::wind::{QualityFlags, WindTick};
use firmware::azimuth::azimuth_deg;
use firmware::check_ins::CheckIns;
use firmware::crash_record::CrashRecord;
use wire::{Identity, Name, ResetCause};

/// Name and version of this firmware.
pub const NAME: &str = env!("ANEMO_FIRMWARE_NAME");

/// Who has checked in for the watchdog.
pub static CHECK_INS: CheckIns = CheckIns::none();

/// Memory of the health task.
pub struct Health {
    watchdog: Watchdog,
    beats: u32,
    /// Seconds since the start.
    pub uptime_s: u32,
}

impl Health {
    /// Starts with a watchdog that is already running.
    pub const fn new(watchdog: Watchdog) -> Self {
        Self { watchdog, beats: 0, uptime_s: 0 }
    }

    /// One beat; true once a second. `cut`: the platinum is to lose its supply.
    pub fn beat(&mut self, cut: bool) -> bool {
        if CHECK_INS.all_anew() {
            self.watchdog.feed(cut);
        }
        self.beats = (self.beats + 1) % BEATS_PER_SECOND;
        let second = self.beats == 0;
        self.uptime_s = self.uptime_s.wrapping_add(second.into());
        second
    }
}

/// Who this is.
pub fn identity(reset: ResetCause, past: CrashRecord) -> Identity {
    let mut firmware = Name::new();
    // A longer name is cut: it is for people.
    NAME.chars().take_while(|&c| firmware.push(c).is_ok()).for_each(drop);
    let (elements, order) = (board::ELEMENTS as u8, dr_core::model::ORDER as u8);
    let CrashRecord { starts, crash, .. } = past;
    Identity { firmware, board: board::KIND, elements, order, reset, starts, crash, unique_id: board::unique_id() }
}

/// A wind estimate for the log.
#[derive(Clone, Copy)]
pub struct LoggedWind {
    speed_m_s: f32,
    towards_m_s: [f32; 2],
    flags: QualityFlags,
}

impl LoggedWind {
    /// Part of an estimate that the log shows.
    pub const fn of(tick: &WindTick) -> Self {
        let [x_m_s, y_m_s, _] = tick.wind.wind_m_s;
        Self { speed_m_s: tick.wind.speed_m_s, towards_m_s: [x_m_s, y_m_s], flags: tick.quality_flags }
    }

    /// In words, once a second. The azimuth is the vector's, from the head's x axis towards y.
    pub fn log(self) {
        let Self { speed_m_s, towards_m_s: [x_m_s, y_m_s], flags } = self;
        if flags.has(QualityFlags::FAILED) {
            defmt::info!("no wind, flags {=u16}", flags.0);
        } else {
            let towards_deg = azimuth_deg(x_m_s, y_m_s);
            defmt::info!("wind {=f32} m/s towards azimuth {=u16}, flags {=u16}", speed_m_s, towards_deg, flags.0);
        }
    }
}

/// A change of state, for people.
pub fn log_event(event: &wire::Event) {
    match event.state {
        RunState::Standby => defmt::info!("standby at tick {=u32}", event.tick),
        RunState::Running => defmt::info!("running from tick {=u32}", event.tick),
        RunState::Testing => defmt::info!("testing itself from tick {=u32}", event.tick),
        RunState::Tripped(trip) => {
            // 255 is the whole instrument.
            let element = trip.element.unwrap_or(u8::MAX);
            defmt::warn!("tripped at tick {=u32}: {=str}, element {=u8}", event.tick, trip.cause.name(), element);
        }
    }
}
