//! What an instrument reports: of each tick, and at the end of the conversation.

use wire::{FromBoard, LinkCounters, List, ObservedSample, Sample, Status, WindSample};

/// What a controller reports of one tick.
#[derive(Debug, Clone, PartialEq)]
pub struct TickReport {
    /// Temperatures, powers, heater levels and run state.
    pub sample: Sample,
    /// What the elements' structures take by their observers, W; where these run.
    pub equivalent_power_w: Option<List<f32>>,
    /// The anemometer's wind estimate, where one is due.
    pub wind: Option<WindSample>,
}

impl TickReport {
    /// The tick of a message, if it is of one.
    pub fn of(message: FromBoard) -> Option<Self> {
        match message {
            FromBoard::Sample(sample) => Some(Self { sample, equivalent_power_w: None, wind: None }),
            FromBoard::Observed(ObservedSample { sample, equivalent_power_w, wind }) => {
                let equivalent_power_w = Some(equivalent_power_w).filter(|observed| !observed.is_empty());
                Some(Self { sample, equivalent_power_w, wind })
            }
            _ => None,
        }
    }
}

/// What one tick of an instrument brought.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// What the board reports.
    pub sample: Sample,
    /// What the elements' structures take by their observers, W; where these run.
    pub equivalent_power_w: Option<List<f32>>,
    /// The anemometer's wind estimate, where one is due.
    pub wind: Option<WindSample>,
    /// True wind over the tick that follows the sample, m/s, where it is simulated.
    pub true_wind_m_s: Option<[f64; 3]>,
    /// Temperature of the gas over that tick, °C, where it is simulated and swings.
    pub gas_temperature_c: Option<f64>,
    /// The wind is beyond what the simulation has been computed for.
    pub extrapolated: bool,
}

impl Observation {
    /// Whether every list has an entry for each of so many elements, and none more.
    pub fn is_of(&self, elements: usize) -> bool {
        let Sample { temperature_c, power_w, .. } = &self.sample;
        [Some(temperature_c), Some(power_w), self.equivalent_power_w.as_ref()]
            .into_iter()
            .flatten()
            .all(|list| list.len() == elements)
    }
}

/// Losses of the link, and the last status of the board.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LinkReport {
    /// What came from the board.
    pub link: LinkCounters,
    /// The board's last status.
    pub status: Option<Status>,
    /// What the board logged, line by line.
    pub log: Vec<String>,
}
