//! Voltage shifts by quasi-differential and by single readings, where C₀ drifts.

use dielectric::experiment::DeviceExperiment;

use super::records::DeviceRecord;

/// Root mean square errors over the first hour and over the whole record, V.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingFigures {
    /// Length of what they are of, s.
    pub duration_s: f64,
    /// By the two readings of a symbol.
    pub quasi_differential_v: f64,
    /// By the one reading at V₊, with C₀ as the device's file has it.
    pub single_v: f64,
}

/// Compares both on a record: over its first hour, and over all of it.
pub fn compare(experiment: &DeviceExperiment, record: &DeviceRecord) -> [ReadingFigures; 2] {
    let positive_v = experiment.shape.positive_v;
    let hour = (3600.0 / record.symbol_time_s) as usize;
    [hour.min(record.rows.len()), record.rows.len()].map(|rows| {
        let (mut quasi, mut single) = (0.0, 0.0);
        let mut count = 0.0;
        for pair in record.rows[..rows].windows(2) {
            let [before, row] = pair else { continue };
            // A 1 begins with V₊, a −1 ends with it.
            let at_positive_f = row.readings_f[usize::from(before.symbol < 0.0)];
            quasi += (row.shift_v - row.true_v).powi(2);
            single += (experiment.device.single_shift_v(at_positive_f, positive_v) - row.true_v).powi(2);
            count += 1.0;
        }
        let rms = |sum: f64| (sum / f64::max(count, 1.0)).sqrt();
        ReadingFigures {
            duration_s: rows as f64 * record.symbol_time_s,
            quasi_differential_v: rms(quasi),
            single_v: rms(single),
        }
    })
}
