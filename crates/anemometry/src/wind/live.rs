//! Rows of a run while it goes on, as the moments of a replayed recording.

use super::moment::{ElementReading, Moment, TickOrigin, Ticks, run_state};
use recording::RecordingRow;

/// Turns rows of a run into moments.
#[derive(Debug, Clone)]
pub struct LiveRows {
    ticks: Ticks,
}

impl LiveRows {
    /// For a run of a sample period.
    pub fn new(sample_period_s: f64) -> Self {
        Self { ticks: Ticks::new(sample_period_s) }
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
            tick: self.ticks.tick(row.time_s, run_state(row.state), readings),
            event: row.event.to_owned(),
            state: row.state.to_owned(),
            wind_m_s: row.true_wind_m_s,
            gas_c: row.gas_temperature_c,
            known: TickOrigin::Recorded,
        }
    }
}
