//! Rows of a run that goes on, as the moments that a recording of it would be replayed as.

use super::moment::{Known, Moment, Reading, Ticks, run_state};
use crate::recording::Row;

/// A run that is being followed.
#[derive(Debug, Clone)]
pub struct Live {
    ticks: Ticks,
}

impl Live {
    pub fn new(sample_period_s: f64) -> Self {
        Self { ticks: Ticks::new(sample_period_s) }
    }

    /// The row's moment. Rows begin at time 0 and come in order, with none left out.
    pub fn moment(&mut self, row: &Row<'_>) -> Moment {
        let reading =
            |(i, (&temperature_c, &power_w))| Reading { temperature_c, power_w, is_high: row.heaters >> i & 1 == 1 };
        let readings = row.temperature_c.iter().zip(row.power_w).enumerate().map(reading);
        Moment {
            time_s: row.time_s,
            tick: self.ticks.tick(row.time_s, run_state(row.state), readings),
            event: row.event.to_owned(),
            state: row.state.to_owned(),
            wind_m_s: row.wind_m_s,
            gas_c: row.gas_temperature_c,
            known: Known::Recorded,
        }
    }
}
