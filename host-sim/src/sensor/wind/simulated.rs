//! The wind of all entries, sample period by sample period.

use rand_chacha::ChaCha8Rng;

use super::entry::{WindEntry, check};
use super::planned::{added, axes};
use super::series::WindSeries;
use super::turbulence::{self, Relaxed};
use crate::sensor::error::SensorError;

#[derive(Clone, Debug)]
struct Segment {
    first_tick: u64,
    entry: WindEntry,
    mean_m_s: [f64; 3],
    varies: bool,
    /// Turbulence of one relaxation.
    relaxed: Option<Relaxed>,
}

impl Segment {
    fn of(entry: &WindEntry, sample_period_s: f64) -> Self {
        Self {
            // A start within a millionth of a period of a tick belongs to that tick.
            first_tick: (entry.start_s / sample_period_s - 1e-6).ceil().max(0.0) as u64,
            mean_m_s: entry.mean_m_s(),
            varies: !entry.planned().is_empty(),
            relaxed: entry.turbulence.and_then(|turbulence| turbulence.relaxed(entry.speed_m_s, sample_period_s)),
            entry: entry.clone(),
        }
    }
}

/// The wind, tick by tick.
#[derive(Clone, Debug)]
pub struct SimulatedWind {
    sample_period_s: f64,
    segments: Vec<Segment>,
    current: usize,
    next_tick: u64,
    /// Goes on from entry to entry; each component has unit variance.
    relaxed: [f64; 3],
    /// Turbulence of a spectrum: of the entry in force, along its axes.
    series: Option<[WindSeries; 3]>,
    rng: ChaCha8Rng,
}

impl SimulatedWind {
    /// Checks the entries; no entry at all is still gas without a label.
    pub fn new(entries: &[WindEntry], sample_period_s: f64, mut rng: ChaCha8Rng) -> Result<SimulatedWind, SensorError> {
        (0..entries.len()).try_for_each(|i| check(i, entries, sample_period_s))?;
        let still = [WindEntry::default()];
        let entries = if entries.is_empty() { &still[..] } else { entries };
        let segments = entries.iter().map(|entry| Segment::of(entry, sample_period_s)).collect();
        let relaxed = turbulence::at_rest_in_distribution(&mut rng);
        let mut wind =
            SimulatedWind { sample_period_s, segments, current: 0, next_tick: 0, relaxed, series: None, rng };
        wind.begin();
        Ok(wind)
    }

    /// Wind vector of the next sample period, m/s.
    pub fn advance(&mut self) -> [f64; 3] {
        let before = self.current;
        while self.segments.get(self.current + 1).is_some_and(|next| next.first_tick <= self.next_tick) {
            self.current += 1;
        }
        if self.current != before {
            self.begin();
        }
        let middle_s = (self.next_tick as f64 + 0.5) * self.sample_period_s;
        self.next_tick += 1;
        let Segment { entry, mean_m_s, varies, relaxed, .. } = &self.segments[self.current];
        let (mut wind, azimuth_deg) = match varies {
            true => entry.planned_m_s(middle_s - entry.start_s),
            false => (*mean_m_s, entry.azimuth_deg),
        };
        if let Some(relaxed) = relaxed {
            relaxed.add(&mut wind, &mut self.relaxed, &mut self.rng);
        }
        if let Some(series) = &mut self.series {
            for (series, axis) in series.iter_mut().zip(axes(azimuth_deg, entry.elevation_deg)) {
                wind = added(wind, axis, series.next_m_s(&mut self.rng));
            }
        }
        wind
    }

    /// Mean wind of the entry in force, m/s.
    pub fn mean_m_s(&self) -> [f64; 3] {
        self.segments[self.current].mean_m_s
    }

    /// A spectrum's turbulence is that of its entry, and comes in with it.
    fn begin(&mut self) {
        let entry = &self.segments[self.current].entry;
        let components = entry.turbulence.and_then(|turbulence| turbulence.components(entry.speed_m_s));
        let (period_s, rng) = (self.sample_period_s, &mut self.rng);
        self.series = components.map(|all| all.map(|component| WindSeries::begin(&component, period_s, rng)));
    }
}
