//! Wind estimates of a recording, interval by interval, in memory of one interval.

use std::path::Path;

use dr_core::wind::QualityFlags;
use recording::head_mounting::HeadMounting;
use recording::wind::{ESTIMATED_GAS, QUALITY_FLAGS, SPEED_UNCERTAINTY, WIND_ESTIMATE, WIND_FROM, WIND_SPEED};
use recording::{ColumnValues, RecordingColumn, RecordingError, RecordingReader, TIME, TRUE_WIND};

use super::eddy::EddyOptions;
use super::report::{AveragingOptions, MeanInterval, MeteorologyReport};
use super::wind_series::{EstimateSeries, SeriesEntry};

/// Key of the metadata of a file of estimates.
const BANDWIDTH: &str = "bandwidth_hz";

/// Why a recording has no averages.
#[derive(Debug, thiserror::Error)]
pub enum AveragingError {
    /// It cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Fluxes need a bandwidth.
    #[error("the recording does not state the bandwidth of its wind, which fluxes need: --bandwidth does")]
    NoBandwidth,
    /// No row has an estimate, or is late enough.
    #[error("no estimate is at or after {0} s: nothing is averaged")]
    Nothing(f64),
}

/// Averages a recording: a file of `anemo wind` or `anemo combine`, a run or a log of a calibrated
/// head, or any table with these columns.
///
/// # Errors
/// If it cannot be read, has no wind, or no estimate counts.
pub fn average(path: &Path, options: &AveragingOptions) -> Result<MeteorologyReport, AveragingError> {
    let mut reader = RecordingReader::open(path)?;
    let metadata = reader.metadata();
    let columns = wind_columns(path, reader.names())?;
    reader.select(&columns);
    let stated = metadata.iter().find(|(key, _)| key == BANDWIDTH).and_then(|(_, text)| text.parse().ok());
    let bandwidth_hz = options.bandwidth_hz.or(stated);
    let eddy = match (options.height_m, bandwidth_hz) {
        (None, _) => None,
        (Some(_), None) => return Err(AveragingError::NoBandwidth),
        (Some(height_m), Some(bandwidth_hz)) => Some(EddyOptions {
            height_m,
            bandwidth_hz,
            temperature_bandwidth_hz: options.temperature_bandwidth_hz,
            gravity_m_s2: options.gravity_m_s2,
        }),
    };
    let mut averager = Averager { options, eddy, current: None, intervals: Vec::new() };
    while let Some(chunk) = reader.next_chunk()? {
        for entries in entries(&chunk, options.mounting.unwrap_or_default()) {
            averager.add(entries);
        }
    }
    averager.close();
    if averager.intervals.is_empty() {
        return Err(AveragingError::Nothing(options.from_s));
    }
    let intervals = averager.intervals;
    Ok(MeteorologyReport::new(path, &metadata, options, bandwidth_hz, intervals))
}

/// Sorts estimates into intervals.
struct Averager<'a> {
    options: &'a AveragingOptions,
    eddy: Option<EddyOptions>,
    /// Number of the open interval, its estimates and true winds.
    current: Option<(i64, EstimateSeries, EstimateSeries)>,
    intervals: Vec<MeanInterval>,
}

impl Averager<'_> {
    fn add(&mut self, (estimate, truth): (SeriesEntry, Option<SeriesEntry>)) {
        let since_s = estimate.time_s - self.options.from_s;
        if since_s.is_nan() || since_s < 0.0 {
            return;
        }
        // A time that is a rounding below an interval's begin belongs to it.
        let number = (since_s / self.options.interval_s + 1e-9).floor() as i64;
        if self.current.as_ref().is_none_or(|(open, ..)| *open != number) {
            self.close();
        }
        let (_, estimates, truths) =
            self.current.get_or_insert_with(|| (number, Default::default(), Default::default()));
        estimates.entries.push(estimate);
        truths.entries.extend(truth);
    }

    fn close(&mut self) {
        let Some((number, estimates, truth)) = self.current.take() else { return };
        let interval_s = self.options.interval_s;
        let begin_s = self.options.from_s + number as f64 * interval_s;
        let statistics = estimates.statistics(begin_s, interval_s, self.eddy.as_ref());
        self.intervals.push(MeanInterval {
            begin_s,
            end_s: begin_s + interval_s,
            valid_share: estimates.share(interval_s),
            left_out_by: if statistics.is_none() { estimates.left_out_by(interval_s) } else { None },
            statistics,
            truth: truth.statistics(begin_s, interval_s, self.eddy.as_ref()),
        });
    }
}

/// Places of the columns that are averaged.
fn wind_columns(path: &Path, names: &[String]) -> Result<Vec<usize>, RecordingError> {
    let has = |wanted: &[&str]| wanted.iter().all(|wanted| names.iter().any(|own| own == wanted));
    if !has(&[TIME]) || !(has(&WIND_ESTIMATE) || has(&[WIND_SPEED])) {
        let sentence = format!(
            "has no wind to average: {TIME} with {} or {WIND_SPEED} are wanted, which `anemo wind … -o` writes, and recordings of a calibrated head have",
            WIND_ESTIMATE.join(", ")
        );
        return Err(RecordingError::new(path, sentence));
    }
    let single = [TIME, WIND_SPEED, SPEED_UNCERTAINTY, ESTIMATED_GAS, QUALITY_FLAGS, WIND_FROM];
    let is_wanted = |name: &str| single.into_iter().chain(WIND_ESTIMATE).chain(TRUE_WIND).any(|wanted| wanted == name);
    Ok((0..names.len()).filter(|place| is_wanted(&names[*place])).collect())
}

/// The estimates of a chunk with the true winds beside them; rows without an estimate are left out.
fn entries(chunk: &[RecordingColumn], mounting: HeadMounting) -> Vec<(SeriesEntry, Option<SeriesEntry>)> {
    let of_name = |name: &str| chunk.iter().find(|column| column.name == name);
    let column = |name: &str| match of_name(name).map(|column| &column.values) {
        Some(ColumnValues::Numbers(numbers)) => &numbers[..],
        _ => &[],
    };
    let (time, vector, truth) = (column(TIME), WIND_ESTIMATE.map(column), TRUE_WIND.map(column));
    let (speed, uncertainty, gas) = (column(WIND_SPEED), column(SPEED_UNCERTAINTY), column(ESTIMATED_GAS));
    let (has_flags, has_speed) = (of_name(QUALITY_FLAGS).is_some(), of_name(WIND_SPEED).is_some());
    // Another anemometer has a direction in place of a vector.
    let has_vector = WIND_ESTIMATE.iter().all(|name| of_name(name).is_some());
    let (flags, from) = (column(QUALITY_FLAGS), if has_vector { &[] } else { column(WIND_FROM) });
    let number = |of: &[f64], row: usize| of.get(row).copied().unwrap_or(f64::NAN);
    let entry = |row: usize| {
        let time_s = number(time, row);
        let own = vector.map(|of| number(of, row));
        let (sin, cos) = libm::sincos(number(from, row).to_radians());
        let towards = [-sin, -cos, 0.0].map(|of| of * number(speed, row));
        let length_m_s = own.iter().map(|of| of * of).sum::<f64>().sqrt();
        let bits = number(flags, row);
        let flags = match has_flags {
            true => bits.is_finite().then_some(QualityFlags(bits as u16))?,
            // A table of another instrument: what has no number is no wind.
            false => QualityFlags::default().with(QualityFlags::FAILED, !length_m_s.is_finite() && !has_speed),
        };
        let vectors = [mounting.earth(own), towards];
        let vector = vectors.into_iter().find(|of| of.iter().all(|of| of.is_finite()));
        let estimate = SeriesEntry {
            time_s,
            wind_m_s: vector.unwrap_or([0.0; 3]),
            speed_m_s: if has_speed { number(speed, row) } else { length_m_s },
            speed_u_m_s: number(uncertainty, row),
            gas_c: number(gas, row),
            flags,
        };
        let wind_m_s = mounting.earth(truth.map(|of| number(of, row)));
        let speed_m_s = wind_m_s.iter().map(|of| of * of).sum::<f64>().sqrt();
        let flags = QualityFlags::default();
        let truth = SeriesEntry { wind_m_s, speed_m_s, speed_u_m_s: f64::NAN, flags, ..estimate };
        Some((estimate, speed_m_s.is_finite().then_some(truth)))
    };
    (0..time.len()).filter_map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options() -> AveragingOptions {
        AveragingOptions {
            interval_s: 120.0,
            from_s: 0.0,
            mounting: None,
            height_m: None,
            bandwidth_hz: None,
            temperature_bandwidth_hz: None,
            gravity_m_s2: 9.81,
        }
    }

    /// Seven minutes at 2 Hz: 4 m/s towards x, then 6 m/s; the first five seconds and half of the
    /// third interval are flagged.
    fn table(folder: &Path) -> std::path::PathBuf {
        let path = folder.join("winds.csv");
        let mut text = String::from("time_s,wind_x_m_s,wind_y_m_s,wind_z_m_s,wind_speed_m_s,quality_flags\n");
        for n in 0..840 {
            let (time_s, x) = (0.5 * f64::from(n), if n < 240 { 4.0 } else { 6.0 });
            let flags = if n < 10 || (480..600).contains(&n) { 8192 } else { 0 };
            text += &format!("{time_s},{x},0,0,{x},{flags}\n");
            // Rows between estimates, as a run at 1 kHz has them.
            text += &format!("{},,,,,\n", time_s + 0.25);
        }
        std::fs::write(&path, text).unwrap();
        path
    }

    #[test]
    fn a_recording_is_cut_into_intervals_and_too_few_estimates_make_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = table(folder.path());
        let report = average(&path, &options()).unwrap();
        let begins: Vec<f64> = report.intervals.iter().map(|of| of.begin_s).collect();
        assert_eq!(begins, [0.0, 120.0, 240.0, 360.0]);
        let speed = |n: usize| report.intervals[n].statistics.as_ref().map(|of| of.mean_speed_m_s);
        assert_eq!([speed(0), speed(1), speed(2), speed(3)], [Some(4.0), Some(6.0), None, None]);
        assert!((report.intervals[2].valid_share - 0.5).abs() < 1e-9 && report.intervals[3].valid_share < 0.51);
        let left_out: Vec<_> = report.intervals.iter().map(|of| of.left_out_by).collect();
        assert_eq!(left_out, [None, None, Some("inconsistent"), None]);
        assert_eq!(report.intervals[0].statistics.as_ref().unwrap().wind_from_deg, Some(180.0));
        let later = average(&path, &AveragingOptions { from_s: 60.0, ..options() }).unwrap();
        // Half of 4 and half of 6 m/s.
        assert_eq!(later.intervals[0].statistics.as_ref().unwrap().mean_speed_m_s, 5.0);
    }

    #[test]
    fn what_cannot_be_averaged_is_refused_with_what_would_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = table(folder.path());
        let sentence = |options: &AveragingOptions| average(&path, options).unwrap_err().to_string();
        assert!(
            sentence(&AveragingOptions { from_s: 1e4, ..options() }).starts_with("no estimate is at or after 10000 s")
        );
        assert!(sentence(&AveragingOptions { height_m: Some(2.0), ..options() }).ends_with("--bandwidth does"));
        let other = folder.path().join("power.csv");
        std::fs::write(&other, "time_s,power_w\n0,1\n1,1\n").unwrap();
        let sentence = average(&other, &options()).unwrap_err().to_string();
        assert!(sentence.contains("power.csv: has no wind to average"), "{sentence}");
    }
}
