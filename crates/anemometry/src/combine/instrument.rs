//! An instrument that sees a part of the wind.
//!
//! A vane tells its direction by junctions that stand evenly round a warm core: those in its wake
//! are the warmer ones. It reads a recording, not a file of `anemo wind`: junctions only sense.

use std::f64::consts::PI;
use std::path::PathBuf;

use anyhow::{Context, bail};
use nalgebra::{Matrix3, Vector3};
use recording::text::suggest;
use recording::{Recording, RecordingError, TEMPERATURE, TIME, column_name};
use serde::{Deserialize, Serialize};

use crate::vector::length;

/// Knowledge that an instrument has of a wind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstrumentKind {
    /// A vector.
    Vector,
    /// The speed only.
    Speed,
    /// The direction only.
    Direction,
}

impl InstrumentKind {
    /// Divisor of components to be shares in a wind of this speed, m/s.
    pub fn scale(self, speed_m_s: f64) -> f64 {
        if self == Self::Direction { 1.0 } else { speed_m_s }
    }

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vector => "vector",
            Self::Speed => "speed only",
            Self::Direction => "direction only",
        }
    }
}

/// Reading of an instrument at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstrumentReading {
    /// Where the gas goes to, in the instrument's frame, m/s; of one that only knows the speed
    /// (v, 0, 0), of one that only knows the direction a unit vector.
    pub wind_m_s: [f64; 3],
    /// Covariance as it states it, (m/s)²; of a direction without unit.
    pub covariance: Matrix3<f64>,
    /// Kind of its knowledge.
    pub kind: InstrumentKind,
}

impl InstrumentReading {
    /// A wind with the standard uncertainties of its speed, m/s, and of its direction, rad.
    pub fn new(wind_m_s: [f64; 3], speed_u_m_s: f64, direction_u_rad: f64, kind: InstrumentKind) -> Self {
        let size = length(wind_m_s);
        let towards = Vector3::from(wind_m_s) / size.max(f64::MIN_POSITIVE);
        let along = towards * towards.transpose();
        let across = Matrix3::identity() - along;
        let covariance = along * speed_u_m_s.powi(2) + across * (size * direction_u_rad).powi(2);
        Self { wind_m_s, covariance, kind }
    }

    /// The variance of a component.
    pub fn variance(&self, axis: [f64; 3]) -> f64 {
        variance(&self.covariance, axis)
    }
}

/// aᵀ C a
pub fn variance(covariance: &Matrix3<f64>, axis: [f64; 3]) -> f64 {
    let axis = Vector3::from(axis);
    axis.dot(&(covariance * axis))
}

/// A difference between the junctions that is smaller, in standard deviations of its noise, says
/// nothing.
const LEAST_NOISES: f64 = 5.0;
/// Median length of a vector whose two components have a standard deviation of 1.
const MEDIAN_LENGTH: f64 = 1.1774;

/// Elements of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vane {
    /// The recording.
    pub recording: PathBuf,
    /// Names of the junctions in their order around the core, three at least.
    pub junctions: Vec<String>,
}

impl std::str::FromStr for Vane {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (recording, junctions) = text
            .rsplit_once('=')
            .context("is no FILE=NAME,NAME,…: a recording and its junctions in their order around the core")?;
        let junctions: Vec<String> = junctions.split(',').map(|name| name.trim().to_owned()).collect();
        if junctions.len() < 3 {
            bail!("names {} of its junctions, and it takes three to know a direction", junctions.len());
        }
        if let Some(twice) = (1..junctions.len()).find(|n| junctions[..*n].contains(&junctions[*n])) {
            bail!("names `{}` twice", junctions[twice]);
        }
        Ok(Self { recording: PathBuf::from(recording), junctions })
    }
}

impl Vane {
    /// Its directions at these times, from the mean temperatures within `near_s` of each, or
    /// half of its own step if that is more.
    ///
    /// # Errors
    /// If the recording cannot be read, or lacks a junction.
    pub(super) fn at(&self, times_s: &[f64], near_s: f64) -> Result<Vec<Option<InstrumentReading>>, RecordingError> {
        let table = Recording::read(&self.recording)?;
        let mut columns = Vec::new();
        for name in &self.junctions {
            let column = column_name(TEMPERATURE, name);
            if !table.has(&column) {
                let hint = suggest(name, table.elements());
                return Err(RecordingError::new(&self.recording, format!("has no element `{name}`; {hint}")));
            }
            columns.push(table.numbers(&column)?);
        }
        let recorded_s = table.finite(TIME)?;
        let own_s = recorded_s.windows(2).map(|pair| pair[1] - pair[0]).reduce(f64::min).unwrap_or(0.0);
        let near_s = near_s.max(0.5 * own_s);
        let count = columns.len() as f64;
        // Twice the mean of T e^{iφ}: the first harmonic round the core, K.
        let harmonic = |row: usize| {
            columns.iter().enumerate().fold([0.0; 2], |[x, y], (k, column)| {
                let (sine, cosine) = libm::sincos(2.0 * PI * k as f64 / count);
                [x + 2.0 / count * cosine * column[row], y + 2.0 / count * sine * column[row]]
            })
        };
        let mean = |time_s: f64| {
            let begin = recorded_s.partition_point(|of| *of < time_s - near_s);
            let end = recorded_s.partition_point(|of| *of <= time_s + near_s);
            let rows: Vec<[f64; 2]> = (begin..end).map(harmonic).filter(|of| of[0].is_finite()).collect();
            (!rows.is_empty()).then(|| [0, 1].map(|k| rows.iter().map(|of| of[k]).sum::<f64>() / rows.len() as f64))
        };
        let means: Vec<Option<[f64; 2]>> = times_s.iter().map(|time_s| mean(*time_s)).collect();
        let noise_k = noise_of(&means);
        Ok(means.into_iter().map(|of| direction(of?, noise_k)).collect())
    }
}

/// Standard deviation of a component, by what differs from one row to the next.
fn noise_of(means: &[Option<[f64; 2]>]) -> f64 {
    let steps = means.windows(2).filter_map(|pair| {
        let (a, b) = (pair[0]?, pair[1]?);
        Some(libm::hypot(b[0] - a[0], b[1] - a[1]))
    });
    let mut steps: Vec<f64> = steps.collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).map_or(0.0, |median| median / MEDIAN_LENGTH / 2_f64.sqrt())
}

/// In the frame of the vane: x from the core to its first junction, y a quarter of a turn on.
fn direction([x, y]: [f64; 2], noise_k: f64) -> Option<InstrumentReading> {
    let size_k = libm::hypot(x, y);
    let towards = [x / size_k, y / size_k, 0.0];
    (size_k > LEAST_NOISES * noise_k)
        .then(|| InstrumentReading::new(towards, 0.0, noise_k / size_k, InstrumentKind::Direction))
}
