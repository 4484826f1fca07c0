//! Summary of a run on a device, for people and as JSON.
//!
//! It has the spectrum of each stream of symbols by octaves. The power of an octave is that of the
//! difference of neighbouring means, ½⟨(mean of m symbols − mean of the next m)²⟩ for m = 1, 2, 4 …:
//! the Allan variance of the stream, whose octave has its middle near a period of 2 m T_s. Noise that
//! a loop shapes falls faster than the 1/m of independent symbols, until the charge itself moves.

use std::fmt;

use dr_core::control::Trip;
use serde::Serialize;

use super::row::DeviceRow;
use crate::experiment::DeviceExperiment;

/// Why a run ended before its time, its rows kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, thiserror::Error)]
#[error("{why}{}", if *released { "" } else { "; that the bias is 0 V is not certain: take it off by hand" })]
pub struct DeviceEnd {
    /// A sentence.
    pub why: String,
    /// The device is known to be at 0 V.
    pub released: bool,
}

/// Summary of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct DeviceRunSummary {
    /// Title of the experiment.
    pub title: String,
    /// Name of the device.
    pub device: String,
    /// Who decided: name and version of the firmware, or of this program.
    pub firmware: String,
    /// Rows of the recording.
    pub ticks: u32,
    /// Time of the last row, s.
    pub duration_s: f64,
    /// Symbols without a voltage shift: 0 V, or a reading that did not come.
    pub without_reading: u32,
    /// The trip, if there was one.
    pub trips: Vec<DeviceTrip>,
    /// It came to its end.
    pub complete: bool,
    /// Cause of its early end; left out if nothing did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<DeviceEnd>,
    /// Hash of all states, readings and bits.
    pub hash: String,
    /// Standard uncertainty of one voltage shift by the meter's noise, V.
    pub shift_noise_v: f64,
    /// Root mean square of measured less true voltage shift, V, where it is simulated.
    pub shift_rms_error_v: Option<f64>,
    /// By phase of the experiment.
    pub phases: Vec<PhaseSummary>,
}

/// A trip.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct DeviceTrip {
    /// When, in s after the start.
    pub time_s: String,
    /// Cause of the trip.
    pub cause: &'static str,
}

/// One phase, its second half: what it has settled to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhaseSummary {
    /// Its start, s.
    pub start_s: f64,
    /// Name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// Set-point, V, if it holds one.
    pub target_v: Option<f64>,
    /// Mean voltage shift over the second half, V.
    pub mean_voltage_shift_v: Option<f64>,
    /// Its standard deviation there, V.
    pub sd_voltage_shift_v: Option<f64>,
    /// Mean symbol over the second half.
    pub mean_symbol: Option<f64>,
    /// When its set-point was first reached, s after its start.
    pub reached_s: Option<f64>,
    /// Spectrum of its symbols in the second half.
    pub octaves: Vec<StreamOctave>,
}

/// Sums of a run.
pub(super) struct DeviceStatistics {
    summary: DeviceRunSummary,
    symbol_time_s: f64,
    squares: (f64, u32),
    /// Symbols and shifts of the running phase.
    phase: PhaseRows,
    starts: Vec<(f64, String, Option<f64>)>,
}

#[derive(Default)]
struct PhaseRows {
    symbols: Vec<f32>,
    shifts_v: Vec<f32>,
    reached_s: Option<f64>,
    first_error_v: Option<f64>,
}

impl DeviceStatistics {
    pub fn new(experiment: &DeviceExperiment, firmware: &str) -> Self {
        let of = |phase: &crate::experiment::DevicePhase| {
            let target_v = phase.drive.target_range_c().map(|(target, _)| f64::from(target));
            (experiment.time_s(phase.tick), phase.label.clone(), target_v)
        };
        let summary = DeviceRunSummary {
            title: experiment.title.clone(),
            device: experiment.device.name.clone(),
            firmware: firmware.to_owned(),
            shift_noise_v: experiment.device.shift_noise_v(&experiment.shape),
            ..DeviceRunSummary::default()
        };
        let starts = experiment.phases.iter().map(of).collect();
        let symbol_time_s = experiment.shape.symbol_time_s;
        Self { summary, symbol_time_s, squares: (0.0, 0), phase: PhaseRows::default(), starts }
    }

    pub const fn rows(&self) -> u32 {
        self.summary.ticks
    }

    pub fn trip(&mut self, time_s: f64, trip: Trip) {
        self.summary.trips.push(DeviceTrip { time_s: time_s.to_string(), cause: trip.cause.name() });
    }

    pub fn add(&mut self, row: &DeviceRow, time_s: f64) {
        if let Some(truth) = row.truth.filter(|_| !row.shift_v.is_nan()) {
            self.squares.0 += (f64::from(row.shift_v) - truth.shift_v).powi(2);
            self.squares.1 += 1;
        }
        self.count(row.symbol, row.shift_v, time_s);
    }

    /// Counts a symbol and the shift before it: where a phase begins, that one is still of the
    /// phase before.
    pub fn count(&mut self, symbol: f32, shift_v: f32, time_s: f64) {
        self.summary.ticks += 1;
        self.summary.duration_s = time_s;
        self.summary.without_reading += u32::from(shift_v.is_nan());
        let (start_s, _, target_v) = &self.starts[self.summary.phases.len()];
        if let (Some(target_v), None, false) = (target_v, self.phase.reached_s, shift_v.is_nan()) {
            let error_v = f64::from(shift_v) - target_v;
            let first_v = *self.phase.first_error_v.get_or_insert(error_v);
            self.phase.reached_s = (error_v * first_v <= 0.0).then_some(time_s - start_s);
        }
        self.phase.shifts_v.push(shift_v);
        if self.starts.get(self.summary.phases.len() + 1).is_some_and(|(start_s, ..)| time_s >= *start_s) {
            self.close_phase();
        }
        self.phase.symbols.push(symbol);
    }

    fn close_phase(&mut self) {
        let rows = std::mem::take(&mut self.phase);
        let (start_s, label, target_v) = self.starts[self.summary.phases.len()].clone();
        let shifts_v = &rows.shifts_v[rows.shifts_v.len() / 2..];
        let shifts_v: Vec<f64> = shifts_v.iter().filter(|of| !of.is_nan()).map(|&of| of.into()).collect();
        let symbols: Vec<f64> = rows.symbols[rows.symbols.len() / 2..].iter().map(|&of| of.into()).collect();
        let mean_v = mean(&shifts_v);
        let deviation = |mean_v: f64| mean(&shifts_v.iter().map(|of| (of - mean_v).powi(2)).collect::<Vec<_>>());
        self.summary.phases.push(PhaseSummary {
            start_s,
            label,
            target_v,
            mean_voltage_shift_v: mean_v,
            sd_voltage_shift_v: mean_v.and_then(deviation).map(f64::sqrt),
            mean_symbol: mean(&symbols),
            reached_s: rows.reached_s,
            octaves: octaves(&symbols, self.symbol_time_s),
        });
    }

    pub fn summary(mut self, hash: u64, ended: Option<DeviceEnd>) -> DeviceRunSummary {
        self.close_phase();
        let (sum, count) = self.squares;
        DeviceRunSummary {
            complete: ended.is_none() && self.summary.trips.is_empty(),
            ended,
            hash: format!("{hash:016x}"),
            shift_rms_error_v: (count > 0).then(|| (sum / f64::from(count)).sqrt()),
            ..self.summary
        }
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

impl fmt::Display for DeviceRunSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use recording::text::four_digits as brief;
        writeln!(f, "{} · device {} · {}", self.title, self.device, self.firmware)?;
        writeln!(f, "{} symbols, {} s; {} without a reading", self.ticks, self.duration_s, self.without_reading)?;
        writeln!(f, "hash of all states, readings and bits: {}", self.hash)?;
        write!(f, "voltage shift: ± {} V by the noise of the meter (standard uncertainty)", brief(self.shift_noise_v))?;
        match self.shift_rms_error_v {
            Some(error_v) => writeln!(f, "; {} V rms off the simulated one", brief(error_v))?,
            None => writeln!(f)?,
        }
        let words = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), brief);
        let mut lines = vec![
            ["from, s", "", "set-point, V", "reached after, s", "mean shift, V", "± (sd), V", "mean symbol"]
                .map(str::to_owned)
                .to_vec(),
        ];
        lines.extend(self.phases.iter().map(|phase| {
            vec![
                phase.start_s.to_string(),
                phase.label.clone(),
                words(phase.target_v),
                words(phase.reached_s),
                words(phase.mean_voltage_shift_v),
                words(phase.sd_voltage_shift_v),
                words(phase.mean_symbol),
            ]
        }));
        writeln!(f, "\nsecond half of each phase:")?;
        write!(f, "{}", recording::text::columns(&lines, &[0, 2, 3, 4, 5, 6]))
    }
}

/// Differences that a power is the mean of, at least.
const LEAST_DIFFERENCES: usize = 8;

/// One octave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StreamOctave {
    /// 2 m T_s, s.
    pub period_s: f64,
    /// Power of symbols of ±1; white noise of independent symbols has 1/m.
    pub power: f64,
}

/// All octaves for which a stream is long enough, the fastest first.
pub fn octaves(symbols: &[f64], symbol_time_s: f64) -> Vec<StreamOctave> {
    let mut all = Vec::new();
    let mut length = 1;
    while symbols.len() / length > LEAST_DIFFERENCES {
        let means: Vec<f64> =
            symbols.chunks_exact(length).map(|chunk| chunk.iter().sum::<f64>() / length as f64).collect();
        let squares: f64 = means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        let power = 0.5 * squares / (means.len() - 1) as f64;
        all.push(StreamOctave { period_s: 2.0 * length as f64 * symbol_time_s, power });
        length *= 2;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alternating_stream_is_all_in_the_first_octave_and_a_slow_one_in_its_own() {
        let alternating: Vec<f64> = (0..1024).map(|n| if n % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let found = octaves(&alternating, 0.5);
        assert_eq!((found[0].period_s, found[0].power), (1.0, 2.0));
        assert!(found[1..].iter().all(|octave| octave.power == 0.0));
        let slow: Vec<f64> = (0..1024).map(|n| if n / 16 % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let most = octaves(&slow, 1.0).into_iter().max_by(|a, b| a.power.total_cmp(&b.power)).unwrap();
        assert_eq!((most.period_s, most.power), (32.0, 2.0));
    }
}
