//! The wind of an experiment: entries that hold until the next one, with what blows on top of each.
//!
//! ```text
//! v(t) = U e(t) + g(t) e_g + s(t) e(t) + σ x(t) + d(t)         m/s; directions are the ones the air goes *to*
//! e    = (cos el cos az, cos el sin az, sin el)
//! ```
//!
//! | term | what | file |
//! |---|---|---|
//! | U e | the mean, whose azimuth may swing | this one, [`sine`] |
//! | g e_g | a gust, 1 − cos | [`gust`] |
//! | s e | a sine along the mean | [`sine`] |
//! | σ x | turbulence of one relaxation, or of a spectrum | [`turbulence`], which uses `relaxations` and `series` |
//! | d | a dust devil that passes | [`dust_devil`] |
//!
//! Every time is counted from the entry's start. The wind is held over each sample period: what is known as a function of time is
//! taken in the period's middle.
//!
//! Limits: one wind for the whole sensor, which is small against any eddy.

pub mod dust_devil;
pub mod gust;
mod relaxations;
mod series;
pub mod sine;
pub mod turbulence;

use rand_chacha::ChaCha8Rng;

use super::SensorError;
pub use dust_devil::DustDevil;
pub use gust::Gust;
use series::Series;
pub use sine::{Sine, Swing};
use turbulence::Relaxed;
pub use turbulence::{Spectrum, Turbulence};

/// Nothing that is asked for may add more than this, m/s.
const HIGHEST_M_S: f64 = 100.0;

/// A wind that holds from `start_s` to the start of the next entry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindEntry {
    pub start_s: f64,
    /// Name of the conditions; becomes the `event` of a recording.
    pub label: String,
    pub speed_m_s: f64,
    pub azimuth_deg: f64,
    pub elevation_deg: f64,
    pub swing: Option<Swing>,
    pub sine: Option<Sine>,
    pub gust: Option<Gust>,
    pub dust_devil: Option<DustDevil>,
    pub turbulence: Option<Turbulence>,
}

impl WindEntry {
    /// Mean wind vector, m/s.
    pub fn mean_m_s(&self) -> [f64; 3] {
        towards(self.azimuth_deg, self.elevation_deg).map(|v| v * self.speed_m_s)
    }

    /// Names of what makes it change by a plan, not by chance.
    pub fn planned(&self) -> Vec<&'static str> {
        let named = [
            (self.swing.is_some(), "swing"),
            (self.sine.is_some(), "sine"),
            (self.gust.is_some(), "gust"),
            (self.dust_devil.is_some(), "dust_devil"),
        ];
        named.into_iter().filter(|(given, _)| *given).map(|(_, name)| name).collect()
    }

    /// Wind without turbulence `time_s` after the entry's start, m/s, and the azimuth of the mean then, °.
    fn planned_m_s(&self, time_s: f64) -> ([f64; 3], f64) {
        let azimuth_deg = self.azimuth_deg + self.swing.map_or(0.0, |swing| swing.angle_deg(time_s));
        let along = towards(azimuth_deg, self.elevation_deg);
        let speed_m_s = self.speed_m_s + self.sine.map_or(0.0, |sine| sine.rise_m_s(time_s));
        let mut wind = along.map(|v| v * speed_m_s);
        if let Some(gust) = self.gust {
            let into = gust.towards(azimuth_deg, self.elevation_deg);
            wind = added(wind, into, gust.rise_at_m_s(time_s));
        }
        if let Some(devil) = self.dust_devil {
            let [x, y] = devil.wind_m_s(time_s, self);
            wind = [wind[0] + x, wind[1] + y, wind[2]];
        }
        (wind, azimuth_deg)
    }
}

/// Unit vector into a direction.
fn towards(azimuth_deg: f64, elevation_deg: f64) -> [f64; 3] {
    let (azimuth, elevation) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
    [elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()]
}

/// Along the mean, across it and horizontal (to its left), and the third, which looks up as far as it can.
fn axes(azimuth_deg: f64, elevation_deg: f64) -> [[f64; 3]; 3] {
    let upwards = towards(azimuth_deg + 180.0, 90.0 - elevation_deg);
    [towards(azimuth_deg, elevation_deg), towards(azimuth_deg + 90.0, 0.0), upwards]
}

fn added(wind: [f64; 3], into: [f64; 3], m_s: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| wind[k] + m_s * into[k])
}

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
pub struct Wind {
    sample_period_s: f64,
    segments: Vec<Segment>,
    current: usize,
    next_tick: u64,
    /// Goes on from entry to entry; each component has unit variance.
    relaxed: [f64; 3],
    /// Turbulence of a spectrum: of the entry in force, along its axes.
    series: Option<[Series; 3]>,
    rng: ChaCha8Rng,
}

impl Wind {
    /// Checks the entries; no entry at all is still gas without a label.
    pub fn new(entries: &[WindEntry], sample_period_s: f64, mut rng: ChaCha8Rng) -> Result<Wind, SensorError> {
        for (i, entry) in entries.iter().enumerate() {
            check(entry, i, entries, sample_period_s)?;
        }
        let still = [WindEntry::default()];
        let entries = if entries.is_empty() { &still[..] } else { entries };
        let segments = entries.iter().map(|entry| Segment::of(entry, sample_period_s)).collect();
        let relaxed = turbulence::at_rest_in_distribution(&mut rng);
        let mut wind = Wind { sample_period_s, segments, current: 0, next_tick: 0, relaxed, series: None, rng };
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

    /// Label of the entry in force.
    pub fn label(&self) -> &str {
        &self.segments[self.current].entry.label
    }

    /// A spectrum's turbulence is that of its entry, and comes in with it.
    fn begin(&mut self) {
        let entry = &self.segments[self.current].entry;
        let components = entry.turbulence.and_then(|turbulence| turbulence.components(entry.speed_m_s));
        let (period_s, rng) = (self.sample_period_s, &mut self.rng);
        self.series = components.map(|all| all.map(|component| Series::begin(&component, period_s, rng)));
    }
}

/// What a check refuses: the key in its entry, its value, what would be right.
type Refused = (&'static str, f64, &'static str);

/// Refuses the first that is not so.
fn first_refused(cases: impl IntoIterator<Item = (bool, Refused)>) -> Result<(), Refused> {
    cases.into_iter().find(|(right, _)| !right).map_or(Ok(()), |(_, refused)| Err(refused))
}

fn check(entry: &WindEntry, i: usize, entries: &[WindEntry], sample_period_s: f64) -> Result<(), SensorError> {
    let refuse =
        |(key, value, expected): Refused| SensorError::out_of_range(format!("wind[{i}].{key}"), value, expected);
    let start_s = entry.start_s;
    let after = i == 0 || (start_s > entries[i - 1].start_s && start_s.is_finite());
    let speed_m_s = entry.speed_m_s;
    first_refused([
        (
            i > 0 || start_s == 0.0,
            ("start_s", start_s, "0 for the first entry, so that the wind is known from the start"),
        ),
        (after, ("start_s", start_s, "later than the start of the entry before it")),
        (
            speed_m_s.is_finite() && speed_m_s >= 0.0,
            ("speed_m_s", speed_m_s, "zero or more; turn the direction instead of the sign"),
        ),
        (entry.azimuth_deg.is_finite(), ("azimuth_deg", entry.azimuth_deg, "a finite angle")),
        ((-90.0..=90.0).contains(&entry.elevation_deg), ("elevation_deg", entry.elevation_deg, "-90 to 90")),
    ])
    .map_err(refuse)?;
    entry.swing.map_or(Ok(()), |swing| swing.check(sample_period_s)).map_err(refuse)?;
    entry.sine.map_or(Ok(()), |sine| sine.check(speed_m_s, sample_period_s)).map_err(refuse)?;
    entry.gust.map_or(Ok(()), |gust| gust.check(speed_m_s, sample_period_s)).map_err(refuse)?;
    entry.dust_devil.map_or(Ok(()), |devil| devil.check(entry)).map_err(refuse)?;
    entry.turbulence.map_or(Ok(()), |turbulence| turbulence.check(speed_m_s, sample_period_s)).map_err(refuse)
}

#[cfg(test)]
mod tests;
