//! Reports of an instrument: of each tick, and at the end of the conversation.

use dr_core::control::{Heaters, RunState, Tick};
use dr_core::wind::WindTick;
use wire::{FromBoard, LinkCounters, ObservedSample, Sample, Status, WindSample};

/// Sample of one tick: a [`Sample`] of a head of any size.
#[derive(Debug, Clone, PartialEq)]
pub struct TickSample {
    /// Number of the tick since the start of the run.
    pub tick: u32,
    /// Levels held until the next tick.
    pub heaters: Heaters,
    /// Bit i is set if element i had a good reading.
    pub valid: usize,
    /// State after the tick.
    pub state: RunState,
    /// °C.
    pub temperature_c: Vec<f32>,
    /// W, held until the next tick.
    pub power_w: Vec<f32>,
}

impl From<Sample> for TickSample {
    fn from(Sample { tick, heaters, valid, state, temperature_c, power_w }: Sample) -> Self {
        Self { tick, heaters, valid, state, temperature_c: temperature_c.to_vec(), power_w: power_w.to_vec() }
    }
}

/// Report of a controller on one tick.
#[derive(Debug, Clone, PartialEq)]
pub struct TickReport {
    /// Temperatures, powers, heater levels and run state.
    pub sample: TickSample,
    /// Power that the elements' structures take by their observers, W; where these run.
    pub equivalent_power_w: Option<Vec<f32>>,
    /// The anemometer's wind estimate, where one is due.
    pub wind: Option<WindSample>,
}

impl TickReport {
    /// The tick of a message, if it is of one. Its estimate comes in a message of its own.
    pub fn of(message: FromBoard) -> Option<Self> {
        match message {
            FromBoard::Sample(sample) => Some(Self { sample: sample.into(), equivalent_power_w: None, wind: None }),
            FromBoard::Observed(ObservedSample { sample, equivalent_power_w }) => {
                let equivalent_power_w = Some(equivalent_power_w.to_vec()).filter(|observed| !observed.is_empty());
                Some(Self { sample: sample.into(), equivalent_power_w, wind: None })
            }
            _ => None,
        }
    }

    /// A tick of a controller in this process, as messages would bring it.
    pub fn of_tick<const N: usize>(tick: &Tick<N>, wind: Option<&WindTick>) -> Self {
        let list = |of: &[f32; N]| of.iter().copied().take(tick.elements.into()).collect::<Vec<f32>>();
        let sample = TickSample {
            tick: tick.tick,
            heaters: tick.heaters,
            valid: tick.valid,
            state: tick.state,
            temperature_c: list(&tick.temperature_c),
            power_w: list(&tick.power_w),
        };
        let equivalent_power_w = tick.equivalent_power_w.as_ref().filter(|_| tick.elements > 0).map(list);
        Self { sample, equivalent_power_w, wind: wind.map(WindSample::from) }
    }
}

/// Observation of one tick of an instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Sample of the board.
    pub sample: TickSample,
    /// Power that the elements' structures take by their observers, W; where these run.
    pub equivalent_power_w: Option<Vec<f32>>,
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
    /// Tells whether every list has an entry for each of so many elements, and none more.
    pub fn is_of(&self, elements: usize) -> bool {
        let TickSample { temperature_c, power_w, .. } = &self.sample;
        [Some(temperature_c), Some(power_w), self.equivalent_power_w.as_ref()]
            .into_iter()
            .flatten()
            .all(|list| list.len() == elements)
    }
}

/// Losses of the link, and the last status of the board.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LinkReport {
    /// Counters of the link.
    pub link: LinkCounters,
    /// The board's last status.
    pub status: Option<Status>,
    /// Log of the board, line by line.
    pub log: Vec<String>,
}
