//! A moment of a run or of a recording: the tick of the instrument, and the conditions beside it.
//!
//! Temperatures, powers and bits are in the f32 in which the instrument computed, so that wind
//! estimates off line equal those of the board to the bit. A missing temperature was no good
//! reading; the last good one stands in its place, as on the board.

use dr_core::control::{Heaters, MOST_ELEMENTS, RunState, Tick};
use recording::RecordingRow;

/// Time over which powers are averaged for ticks that are missing, s: long beside a switching loop,
/// short beside a wind.
const HELD_S: f64 = 1.0;

/// One tick.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Since the beginning, s.
    pub time_s: f64,
    /// Tick as the instrument had it.
    pub tick: Tick<MOST_ELEMENTS>,
    /// Label of the conditions; empty where there is none.
    pub event: String,
    /// Run state, such as `running`; empty where the recording has none.
    pub state: String,
    /// True wind over the interval, where it is known.
    pub wind_m_s: Option<[f64; 3]>,
    /// True or measured temperature of the gas, from the requested column, °C.
    pub gas_c: Option<f64>,
    /// The moment was recorded.
    pub known: TickOrigin,
}

/// Origin of a tick: recorded or filled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TickOrigin {
    /// It was recorded.
    Recorded,
    /// It was recorded, but soon after a gap in which the heating is not known.
    AfterGap,
    /// It was not: the elements are assumed to have kept their mean power, and nothing was read.
    Missing,
}

/// An element at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementReading {
    /// °C; NaN where there was no good reading.
    pub temperature_c: f32,
    /// Heating power, W; NaN where it is not known: the mean of the last second stands for it.
    pub power_w: f32,
    /// The heater was at its high level.
    pub is_high: bool,
}

/// Run state of an instrument from the word in a recording.
pub fn run_state(word: &str) -> RunState {
    if matches!(word, "running" | "") { RunState::Running } else { RunState::Standby }
}

/// Turns readings into ticks.
#[derive(Debug, Clone)]
pub struct Ticks {
    sample_period_s: f64,
    first_s: Option<f64>,
    last: Tick<MOST_ELEMENTS>,
    mean_w: [f32; MOST_ELEMENTS],
}

impl Ticks {
    /// For ticks of a sample period.
    pub fn new(sample_period_s: f64) -> Self {
        let last = Tick {
            tick: 0,
            elements: 0,
            heaters: Heaters::default(),
            valid: 0,
            temperature_c: [0.0; MOST_ELEMENTS],
            power_w: [0.0; MOST_ELEMENTS],
            equivalent_power_w: None,
            state: RunState::Standby,
            trip: None,
        };
        Self { sample_period_s, first_s: None, last, mean_w: [0.0; MOST_ELEMENTS] }
    }

    /// The tick of these readings, which come in the order of the head's elements.
    pub fn tick(
        &mut self,
        time_s: f64,
        state: RunState,
        readings: impl Iterator<Item = ElementReading>,
    ) -> Tick<MOST_ELEMENTS> {
        let begins = self.first_s.is_none();
        let first_s = *self.first_s.get_or_insert(time_s);
        let share = if begins { 1.0 } else { (self.sample_period_s / HELD_S).min(1.0) as f32 };
        let (mut valid, mut heaters, mut elements) = (0_usize, 0_usize, 0_u8);
        for (i, reading) in readings.enumerate().take(MOST_ELEMENTS) {
            if reading.temperature_c.is_finite() {
                valid |= 1 << i;
                self.last.temperature_c[i] = reading.temperature_c;
            }
            heaters |= usize::from(reading.is_high) << i;
            if reading.power_w.is_finite() {
                self.mean_w[i] += share * (reading.power_w - self.mean_w[i]);
            }
            self.last.power_w[i] = if reading.power_w.is_finite() { reading.power_w } else { self.mean_w[i] };
            elements += 1;
        }
        let tick = ((time_s - first_s) / self.sample_period_s).round() as u32;
        self.last = Tick { tick, elements, heaters: Heaters(heaters), valid, state, ..self.last };
        self.last
    }

    /// The next tick, which was not recorded.
    pub fn missing(&mut self) -> Tick<MOST_ELEMENTS> {
        self.last = Tick { tick: self.last.tick.saturating_add(1), valid: 0, power_w: self.mean_w, ..self.last };
        self.last
    }

    /// The moment of a row. Rows begin at time 0 and come in order, with none left out.
    pub fn moment(&mut self, row: &RecordingRow<'_>) -> Moment {
        let reading = |(i, (&temperature_c, &power_w))| ElementReading {
            temperature_c,
            power_w,
            is_high: row.heaters >> i & 1 == 1,
        };
        let readings = row.temperature_c.iter().zip(row.power_w).enumerate().map(reading);
        Moment {
            time_s: row.time_s,
            tick: self.tick(row.time_s, run_state(row.state), readings),
            event: row.event.to_owned(),
            state: row.state.to_owned(),
            wind_m_s: row.true_wind_m_s,
            gas_c: row.gas_temperature_c,
            known: TickOrigin::Recorded,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(temperature_c: f32, power_w: f32) -> ElementReading {
        ElementReading { temperature_c, power_w, is_high: power_w > 0.01 }
    }

    #[test]
    fn a_tick_that_is_missing_goes_on_with_the_mean_power_and_no_reading() {
        let mut ticks = Ticks::new(0.01);
        let mut last = None;
        for n in 0..400 {
            // One tick in four at 40 mW.
            let power_w = if n % 4 == 0 { 0.04 } else { 0.0 };
            let readings = [reading(-20.0, power_w), reading(f32::NAN, 0.0)];
            last = Some(ticks.tick(5.0 + 0.01 * f64::from(n), RunState::Running, readings.into_iter()));
        }
        let last = last.unwrap();
        assert_eq!((last.tick, last.valid, last.elements), (399, 0b01, 2));
        let missing = ticks.missing();
        assert_eq!((missing.tick, missing.valid, missing.state), (400, 0, RunState::Running));
        assert!((missing.power_w[0] / 0.01 - 1.0).abs() < 0.05, "{}", missing.power_w[0]);
        assert_eq!(missing.temperature_c[0], -20.0);
    }
}
