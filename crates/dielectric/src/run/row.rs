//! A symbol as a row of the recording.

use dr_core::control::RunState;
use host_sim::instrument::TickSample;
use host_sim::run::{RowSink, RunError};
use recording::{
    BITS, Metadata, OFFSET_CAPACITANCE, RecordingLayout, RecordingRow, SYMBOL, SYMBOL_CAPACITANCE,
    TRUE_OFFSET_CAPACITANCE, TRUE_VOLTAGE_SHIFT, VOLTAGE_SHIFT, column_name,
};

use crate::experiment::DeviceExperiment;
use crate::port::ChargeSymbol;
use crate::port::{DeviceTruth, SymbolReadings};

/// Quantities of a device, in the order of its columns: the symbol that is held from t_n on, the
/// voltage shift and C₀ by the readings of the symbol before t_n, and these readings.
const MEASURED: [&str; 7] =
    [SYMBOL, BITS[0], BITS[1], VOLTAGE_SHIFT, OFFSET_CAPACITANCE, SYMBOL_CAPACITANCE[0], SYMBOL_CAPACITANCE[1]];
/// The same of the simulation.
const TRUE: [&str; 2] = [TRUE_VOLTAGE_SHIFT, TRUE_OFFSET_CAPACITANCE];

/// Columns of the rows of an experiment.
pub fn layout(experiment: &DeviceExperiment, simulated: bool) -> RecordingLayout {
    let quantities = MEASURED.into_iter().chain(TRUE.into_iter().filter(|_| simulated));
    let numbers = quantities.map(|quantity| column_name(quantity, &experiment.device.name)).collect();
    RecordingLayout { numbers, ..RecordingLayout::default() }
}

/// Metadata of a recording before its run.
pub fn metadata(experiment: &DeviceExperiment, instrument: &str) -> Metadata {
    let pairs = [
        ("title", experiment.title.clone()),
        ("instrument", instrument.to_owned()),
        ("sample_period_s", experiment.shape.symbol_time_s.to_string()),
        (
            "units",
            "time_s: s; symbol: -1 or 1, 0 at 0 V; bit1, bit0: 0 or 1; voltage_shift_v: V; capacitance_f: F".to_owned(),
        ),
        ("device_name", experiment.device.name.clone()),
        ("experiment", experiment.source.text.clone()),
        ("device", experiment.device.source.text.clone()),
    ];
    pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// One symbol.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DeviceRow {
    pub symbol: f32,
    /// NaN where the readings were none.
    pub shift_v: f32,
    pub state: RunState,
    pub truth: Option<DeviceTruth>,
    numbers: Vec<f32>,
}

impl DeviceRow {
    pub fn new(
        sample: &TickSample,
        readings: SymbolReadings,
        symbol: Option<ChargeSymbol>,
        truth: Option<DeviceTruth>,
    ) -> Self {
        let is_valid = sample.valid & 1 == 1;
        let measured = |place: usize| match sample.temperature_c.get(place) {
            Some(&value) if is_valid => value,
            _ => f32::NAN,
        };
        let symbol = match symbol {
            None => 0.0,
            Some(ChargeSymbol::Bit0) => -1.0,
            Some(ChargeSymbol::Bit1) => 1.0,
        };
        let [first_f, second_f] = readings.map(|reading| reading.map_or(f32::NAN, |of| of as f32));
        let [bit1, bit0] = [1.0, -1.0].map(|of| if symbol == of { 1.0 } else { 0.0 });
        let mut numbers = vec![symbol, bit1, bit0, measured(0), measured(1), first_f, second_f];
        numbers.extend(truth.iter().flat_map(|truth| [truth.shift_v as f32, truth.offset_f as f32]));
        Self { symbol, shift_v: measured(0), state: sample.state, truth, numbers }
    }

    pub fn push(&self, experiment: &DeviceExperiment, tick: u32, sink: RowSink) -> Result<(), RunError> {
        let state = match self.state {
            RunState::Standby => "standby".to_owned(),
            RunState::Testing => "testing".to_owned(),
            RunState::Running => "running".to_owned(),
            RunState::Tripped(trip) => format!("tripped:{}", trip.cause.name()),
        };
        sink(&RecordingRow {
            time_s: experiment.time_s(tick),
            event: &experiment.phase(tick).label,
            state: &state,
            estimate: &self.numbers,
            ..RecordingRow::default()
        })
    }
}
