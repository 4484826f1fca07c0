//! A run of the simulated device, in memory.

use anyhow::Result;
use dielectric::experiment::DeviceExperiment;
use dielectric::run::{DeviceRunSummary, layout, metadata, run};
use diffusive::identify::record::{RecordError, RecordTable};
use host_sim::instrument::in_process::InProcess;
use host_sim::run::RunError;
use recording::{Collector, Recording};

/// One run.
pub struct DeviceRecord {
    /// Summary of the run.
    pub summary: DeviceRunSummary,
    /// Its rows.
    pub recording: Recording,
    /// T_s, s.
    pub symbol_time_s: f64,
    /// Symbol held from row n on, voltage shift before it, readings, true shift.
    pub rows: Vec<DeviceNumbers>,
}

/// A row in numbers.
#[derive(Debug, Clone, Copy)]
pub struct DeviceNumbers {
    /// Held from here on.
    pub symbol: f64,
    /// Measured, V.
    pub shift_v: f64,
    /// Readings of the symbol before, F.
    pub readings_f: [f64; 2],
    /// True, V.
    pub true_v: f64,
}

/// Runs an experiment on its simulated device.
pub fn run_of(experiment: &DeviceExperiment) -> Result<DeviceRecord> {
    let known = metadata(experiment, "sim");
    let mut collector = Collector::thinned(layout(experiment, true), &known);
    let mut rows = Vec::with_capacity(experiment.ticks as usize);
    let mut device = experiment.simulated()?;
    let summary = run(experiment, Box::new(InProcess::new()), &mut device, &mut |row| {
        let of = |place: usize| row.estimate.get(place).map_or(f64::NAN, |&of| of.into());
        rows.push(DeviceNumbers { symbol: of(0), shift_v: of(3), readings_f: [of(5), of(6)], true_v: of(7) });
        collector.push(row).map_err(RunError::from)
    })?;
    let recording = collector.finish(&Vec::new());
    Ok(DeviceRecord { summary, recording, symbol_time_s: experiment.shape.symbol_time_s, rows })
}

impl DeviceRecord {
    /// Symbols and shifts as a record to identify from.
    pub fn table(&self) -> Result<RecordTable, RecordError> {
        let column =
            |name: &str, of: fn(&DeviceNumbers) -> f64| vec![(name.to_owned(), self.rows.iter().map(of).collect())];
        RecordTable::new(
            self.symbol_time_s,
            column("symbol", |row| row.symbol),
            column("voltage_shift_v", |row| row.shift_v),
        )
    }

    /// Some rows of the same with the two symbols as two inputs.
    pub fn table_of_bits(&self, rows: std::ops::Range<usize>) -> Result<RecordTable, RecordError> {
        let first_s = rows.start as f64 * self.symbol_time_s;
        let rows = &self.rows[rows];
        let input = |name: &str, of: f64| {
            let is = |row: &DeviceNumbers| if row.symbol == of { 1.0 } else { 0.0 };
            (name.to_owned(), rows.iter().map(is).collect())
        };
        let output = vec![("voltage_shift_v".to_owned(), rows.iter().map(|row| row.shift_v).collect())];
        let inputs = vec![input("bit1_mems", 1.0), input("bit0_mems", -1.0)];
        Ok(RecordTable::new(self.symbol_time_s, inputs, output)?.starting_at(first_s))
    }
}
