//! The simulated sensor at the pins: true levels in, codes of the converter out.
//!
//! It is host-sim's sensor with its front end, advanced in steps of a quarter of a millisecond,
//! which is a conversion at 4 kSPS. The steps are aligned to the conversions. The level of a heater
//! counts for heat as it stands at the end of a step; the voltage of a step in which it changes is
//! the mean of both levels, weighted by their times.
//!
//! Limits: heat is early by a change's distance from its step's begin, some 70 µs of 10 ms, both
//! when it rises and when it falls. Without its supply the platinum has no current, but is
//! simulated with the low level's.

use crate::adc::CHANNELS;
use crate::time::us;
use host_sim::sensor::{Sensor, SensorConfig, SensorError, SensorTruth};

/// A step, in core cycles.
const STEP: u64 = us(250);
/// The same, s.
pub const STEP_S: f64 = 250e-6;

/// The sensor, its heaters and what the converter sees of it.
#[derive(Clone, Debug)]
pub struct SensorPlant {
    sensor: Sensor,
    /// Bit i: element i has its high current.
    levels: u8,
    /// Heaters that have their high current whatever the level is.
    stuck_high: u8,
    /// The platinum has its supply, which the board has switched.
    is_supplied: bool,
    step_ends: u64,
    /// Since when the levels are these, and what they were at the step's begin.
    changed_at: u64,
    levels_before: u8,
    /// Codes of the last step.
    codes: [i32; CHANNELS],
    /// Sum of all steps since the last conversion.
    sum: [i64; CHANNELS],
    steps: i64,
}

impl SensorPlant {
    /// A sensor in its wind tunnel. Its sample period is ours.
    ///
    /// # Errors
    /// As [`Sensor::new`].
    pub fn new(config: &SensorConfig) -> Result<Self, SensorError> {
        let sensor = Sensor::new(&SensorConfig { sample_period_s: STEP_S, ..config.clone() })?;
        let codes = six(sensor.codes());
        Ok(Self {
            sensor,
            levels: 0,
            stuck_high: 0,
            is_supplied: true,
            step_ends: STEP,
            changed_at: 0,
            levels_before: 0,
            codes,
            sum: [0; CHANNELS],
            steps: 0,
        })
    }

    /// Takes over steps and levels of another one, in whose place it comes.
    pub const fn follow(&mut self, other: &Self) {
        (self.step_ends, self.changed_at) = (other.step_ends, other.changed_at);
        (self.levels, self.levels_before) = (other.levels, other.levels_before);
        self.is_supplied = other.is_supplied;
    }

    /// Truth that only a simulation knows.
    pub fn truth(&self) -> SensorTruth {
        self.sensor.truth()
    }

    /// Wind of the last step, m/s.
    pub fn wind_m_s(&self) -> [f64; 3] {
        self.sensor.wind_m_s()
    }

    /// Levels at the pins.
    pub const fn levels(&self) -> u8 {
        self.levels
    }

    /// The pins have other levels from now on.
    pub fn set_levels(&mut self, now: u64, levels: u8) {
        self.pass(now);
        self.levels = levels;
        self.changed_at = now;
    }

    /// Tells whether the platinum has its supply.
    pub const fn is_supplied(&self) -> bool {
        self.is_supplied
    }

    /// The platinum has its supply, or no current, from now on.
    pub fn set_supply(&mut self, now: u64, is_supplied: bool) {
        self.pass(now);
        self.is_supplied = is_supplied;
    }

    /// The switches of these heaters are stuck.
    pub const fn stick_high(&mut self, heaters: u8) {
        self.stuck_high = heaters;
    }

    /// Heaters that have their high current.
    pub const fn heated(&self) -> u8 {
        if self.is_supplied { self.levels | self.stuck_high } else { 0 }
    }

    /// Puts the steps so that one ends at `end`.
    pub fn align(&mut self, now: u64, end: u64) {
        self.pass(now);
        self.step_ends = end - (end - now - 1) / STEP * STEP;
    }

    /// Mean codes, without the filter of the converter, since the last time of asking.
    pub fn mean_codes(&mut self, now: u64) -> [i32; CHANNELS] {
        self.pass(now);
        let steps = std::mem::take(&mut self.steps);
        let sum = std::mem::take(&mut self.sum);
        if steps == 0 { self.codes } else { sum.map(|sum| (sum as f64 / steps as f64).round() as i32) }
    }

    fn pass(&mut self, now: u64) {
        while self.step_ends <= now {
            self.step();
            self.step_ends += STEP;
        }
    }

    fn step(&mut self) {
        self.sensor.advance(self.heated().into());
        let after = if self.is_supplied { six(self.sensor.codes()) } else { [0; CHANNELS] };
        let begin = self.step_ends - STEP;
        let part_before = self.changed_at.saturating_sub(begin) as f64 / STEP as f64;
        let channels = self.codes.iter().zip(&after).zip(&mut self.sum);
        for (channel, ((&old, &new), sum)) in channels.enumerate() {
            let changed = (self.levels ^ self.levels_before) >> channel & 1 == 1;
            let (old, new) = (f64::from(old), f64::from(new));
            let code = if changed { part_before * old + (1.0 - part_before) * new } else { new };
            *sum += code.round() as i64;
        }
        self.codes = after;
        self.levels_before = self.levels;
        self.steps += 1;
    }
}

/// Channels without an element read nothing.
fn six(codes: &[i32]) -> [i32; CHANNELS] {
    std::array::from_fn(|channel| codes.get(channel).copied().unwrap_or(0))
}
