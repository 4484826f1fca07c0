//! A file of either format that appears when it is complete.
//!
//! A file of measured rows ends with the drift of the board's clock by that of its host: a straight
//! line by least squares through the moments at which rows arrived.
//!
//! ```text
//! utc_n − time_n = o + d · time_n + e_n      d̂ = S_ty / S_tt      u(d̂) = s / √S_tt
//! ```
//!
//! `d` is the drift, positive where the board is slow; `s` is the scatter of the arrivals about the
//! line, which rows wait for the cable and the system. The uncertainty takes these waits for
//! independent; a step of the host's clock shows as scatter.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::column::{ColumnKind, Metadata, RowCell, RowSink};
use crate::csv::CsvWriter;
use crate::error::RecordingError;
use crate::parts::{FileFormat, check_name};
use crate::temporary::Temporary;

/// Room is reserved in steps of so many bytes.
const STEP: u64 = 64 << 10;

pub(super) struct TableWriter {
    path: PathBuf,
    file: File,
    /// Bytes that the disk keeps for the file.
    reserved: u64,
    has_rows: bool,
    sink: Box<dyn RowSink + Send>,
    // Declared after the sink: the file is closed before it is removed.
    temporary: Temporary,
    /// Clock of a table with times and moments.
    clock: Option<ClockFit>,
}

impl TableWriter {
    pub fn create(path: &Path, columns: &[(String, ColumnKind)], metadata: &Metadata) -> Result<Self, RecordingError> {
        check_name(path)?;
        let format = FileFormat::of(path)?;
        let (temporary, file) = Temporary::create(path).map_err(unwritten(path))?;
        let own = file.try_clone().map_err(unwritten(path))?;
        let sink: Box<dyn RowSink + Send> = match format {
            #[cfg(feature = "parquet")]
            FileFormat::Parquet => {
                let sink = crate::parquet::ParquetWriter::new(file, columns, metadata);
                Box::new(sink.map_err(io::Error::other).map_err(unwritten(path))?)
            }
            FileFormat::Csv | FileFormat::Journal => {
                Box::new(CsvWriter::new(file, columns, metadata).map_err(unwritten(path))?)
            }
        };
        let has_moments = columns.get(1).is_some_and(|(_, kind)| *kind == ColumnKind::Utc);
        Ok(Self {
            path: path.to_owned(),
            file: own,
            reserved: 0,
            has_rows: false,
            sink,
            temporary,
            clock: has_moments.then(ClockFit::default),
        })
    }

    pub fn has_rows(&self) -> bool {
        self.has_rows
    }

    pub fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> Result<(), RecordingError> {
        self.has_rows = true;
        let Some(clock) = &mut self.clock else { return self.sink.push(cells).map_err(unwritten(&self.path)) };
        let mut stamp = [f64::NAN; 2];
        let mut look = |(at, cell): (usize, RowCell<'_>)| {
            if let (Some(seen), RowCell::Number(number)) = (stamp.get_mut(at), cell) {
                *seen = number;
            }
        };
        self.sink
            .push(&mut cells.enumerate().inspect(|cell| look(*cell)).map(|(_, cell)| cell))
            .map_err(unwritten(&self.path))?;
        clock.add(stamp[0], stamp[1]);
        Ok(())
    }

    /// Has the disk keep room for one more row and for the end of the file, so that it can always
    /// be closed.
    pub fn reserve(&mut self) -> Result<(), RecordingError> {
        let wanted = self.sink.bytes() + self.sink.frame_bytes() + STEP / 4;
        if wanted > self.reserved {
            let length = wanted.next_multiple_of(STEP);
            allocate(&self.file, length).map_err(unwritten(&self.path))?;
            self.reserved = length;
        }
        Ok(())
    }

    /// Length of the rows so far, at most.
    pub fn bytes(&self) -> u64 {
        self.sink.bytes()
    }

    pub fn finish(self, metadata: &Metadata) -> Result<(), RecordingError> {
        let clock = self.clock.map(|clock| clock.metadata()).unwrap_or_default();
        let metadata: Metadata = metadata.iter().cloned().chain(clock).collect();
        let Self { path, file, reserved, sink, temporary, .. } = self;
        let give_back = || if reserved > 0 { file.set_len(file.metadata()?.len()) } else { Ok(()) };
        sink.finish(&metadata).and_then(|()| give_back()).and_then(|()| temporary.keep()).map_err(unwritten(&path))
    }
}

/// Blocks for so many bytes, where the system can: elsewhere the journal has the rows.
#[cfg(target_os = "linux")]
fn allocate(file: &File, length: u64) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    match fallocate(file, FallocateFlags::KEEP_SIZE, 0, length) {
        Err(rustix::io::Errno::OPNOTSUPP | rustix::io::Errno::NOSYS) => Ok(()),
        outcome => Ok(outcome?),
    }
}

#[cfg(not(target_os = "linux"))]
fn allocate(_: &File, _: u64) -> io::Result<()> {
    Ok(())
}

/// Makes the error for a file that the system does not let be written.
pub(super) fn unwritten(path: &Path) -> impl Fn(io::Error) -> RecordingError {
    move |error| RecordingError::unwritten(path, &error)
}

/// Sums about running means, as Welford has them, so that a long recording loses no digits.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ClockFit {
    /// The first row: time and UTC, s.
    first: Option<(f64, f64)>,
    count: f64,
    mean_t: f64,
    mean_y: f64,
    s_tt: f64,
    s_ty: f64,
    s_yy: f64,
}

impl ClockFit {
    /// Adds a row that arrived at this moment, s since 1970.
    pub fn add(&mut self, time_s: f64, utc_s: f64) {
        let (time_0_s, utc_0_s) = *self.first.get_or_insert((time_s, utc_s));
        let t = time_s - time_0_s;
        let y = (utc_s - utc_0_s) - t;
        self.count += 1.0;
        let (dt, dy) = (t - self.mean_t, y - self.mean_y);
        self.mean_t += dt / self.count;
        self.mean_y += dy / self.count;
        self.s_tt += dt * (t - self.mean_t);
        self.s_ty += dt * (y - self.mean_y);
        self.s_yy += dy * (y - self.mean_y);
    }

    /// The estimate, for the end of a file; nothing of fewer than three rows.
    pub fn metadata(&self) -> Metadata {
        if self.count < 3.0 || self.s_tt <= 0.0 {
            return Metadata::new();
        }
        let drift = self.s_ty / self.s_tt;
        let scatter_s = ((self.s_yy - drift * self.s_ty).max(0.0) / (self.count - 2.0)).sqrt();
        let ppm = |number: f64| format!("{:.3}", number * 1e6);
        [
            ("clock_drift_ppm", ppm(drift)),
            ("clock_drift_u_ppm", ppm(scatter_s / self.s_tt.sqrt())),
            ("clock_scatter_s", format!("{scatter_s:.6}")),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_board_is_found_within_the_uncertainty_that_is_stated() {
        let mut fit = ClockFit::default();
        // 80 ppm slow; rows wait 0 to 10 ms by turns of 11.
        for n in 0..60_000_u32 {
            let wait_s = f64::from(n * 7 % 11) * 1e-3;
            let time_s = 5e6 + f64::from(n) * 0.01;
            fit.add(time_s, 1.793e9 + f64::from(n) * 0.01 * (1.0 + 80e-6) + wait_s);
        }
        let metadata = fit.metadata();
        let [drift, u, scatter_s] = [0, 1, 2].map(|at: usize| metadata[at].1.parse::<f64>().unwrap());
        assert!((drift - 80.0).abs() < 2.0 * u.max(0.01), "{drift} {u}");
        // 3.16 ms, the deviation of eleven equal steps, over 173 s · √60 000.
        assert!((scatter_s - 3.162e-3).abs() < 1e-5 && (u - 0.0745).abs() < 1e-3, "{scatter_s} {u}");
        let mut short = ClockFit::default();
        short.add(0.0, 1.0);
        assert!(short.metadata().is_empty());
    }
}
