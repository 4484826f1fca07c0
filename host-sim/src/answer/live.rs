//! Rows of a run that goes on, as the moments that a recording of it would be replayed as.

use dr_core::control::{Heaters, RunState, Tick};
use wire::MOST_ELEMENTS;

use super::replay::Moment;
use crate::recording::Row;

/// What has been read last.
#[derive(Debug, Clone)]
pub struct Live {
    sample_period_s: f64,
    temperature_c: [f32; MOST_ELEMENTS],
}

impl Live {
    pub fn new(sample_period_s: f64) -> Self {
        Self { sample_period_s, temperature_c: [0.0; MOST_ELEMENTS] }
    }

    /// The row's moment. Rows begin at time 0 and come in order.
    pub fn moment(&mut self, row: &Row<'_>) -> Moment {
        let (mut valid, mut power_w) = (0, [0.0; MOST_ELEMENTS]);
        for (i, (&read_c, &taken_w)) in row.temperature_c.iter().zip(row.power_w).enumerate().take(MOST_ELEMENTS) {
            if read_c.is_finite() {
                valid |= 1 << i;
                self.temperature_c[i] = read_c;
            }
            power_w[i] = taken_w;
        }
        Moment {
            time_s: row.time_s,
            tick: Tick {
                tick: (row.time_s / self.sample_period_s).round() as u32,
                elements: row.power_w.len().min(MOST_ELEMENTS) as u8,
                heaters: Heaters(row.heaters),
                valid,
                temperature_c: self.temperature_c,
                power_w,
                equivalent_power_w: None,
                state: if row.state == "running" { RunState::Running } else { RunState::Standby },
                trip: None,
            },
            event: row.event.to_owned(),
            wind_m_s: row.wind_m_s,
            gas_c: row.gas_temperature_c,
        }
    }
}
