//! The wind of an experiment: entries that hold until the next one, with seeded turbulence on top.
//!
//! ```text
//! v(t) = U (cos el cos az, cos el sin az, sin el) + s x(t)         m/s; the direction is the one the air goes *to*
//! dx   = −x dt/τ + √(2/τ) dW                                       Ornstein–Uhlenbeck, unit variance, each component its own
//! ```
//!
//! s = intensity × U, so `intensity` is the usual σ_u/U of each component and still air has no turbulence. Sampled exactly,
//! x ← a x + √(1 − a²) n with a = exp(−Ts/τ), so variance and correlation time do not depend on the sample period. x starts in its
//! stationary distribution and goes on from entry to entry.
//!
//! Limits: isotropic, without spatial structure (the sphere is small against any eddy); held over each sample period.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::SensorError;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbulence {
    /// Standard deviation of each component over the mean speed.
    pub intensity: f64,
    pub correlation_time_s: f64,
}

/// A wind that holds from `start_s` to the start of the next entry.
#[derive(Clone, Debug, PartialEq)]
pub struct WindEntry {
    pub start_s: f64,
    /// Name of the conditions; becomes the `event` of a recording.
    pub label: String,
    pub speed_m_s: f64,
    pub azimuth_deg: f64,
    pub elevation_deg: f64,
    pub turbulence: Option<Turbulence>,
}

impl WindEntry {
    /// Mean wind vector, m/s.
    pub fn mean_m_s(&self) -> [f64; 3] {
        let (azimuth, elevation) = (self.azimuth_deg.to_radians(), self.elevation_deg.to_radians());
        [elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()].map(|v| v * self.speed_m_s)
    }
}

#[derive(Clone, Debug)]
struct Segment {
    first_tick: u64,
    label: String,
    mean_m_s: [f64; 3],
    deviation_m_s: f64,
    /// a and √(1 − a²) of one sample period.
    memory: f64,
    renewal: f64,
}

/// The wind, tick by tick.
#[derive(Clone, Debug)]
pub struct Wind {
    segments: Vec<Segment>,
    current: usize,
    next_tick: u64,
    turbulence: [f64; 3],
    rng: ChaCha8Rng,
}

impl Wind {
    /// Checks the entries; no entry at all is still gas without a label.
    pub fn new(entries: &[WindEntry], sample_period_s: f64, mut rng: ChaCha8Rng) -> Result<Wind, SensorError> {
        let mut segments = Vec::with_capacity(entries.len().max(1));
        for (i, entry) in entries.iter().enumerate() {
            check(entry, i, entries)?;
            let (deviation_m_s, memory) = match entry.turbulence {
                Some(t) => (t.intensity * entry.speed_m_s, (-sample_period_s / t.correlation_time_s).exp()),
                None => (0.0, 1.0),
            };
            segments.push(Segment {
                // A start within a millionth of a period of a tick belongs to that tick.
                first_tick: (entry.start_s / sample_period_s - 1e-6).ceil().max(0.0) as u64,
                label: entry.label.clone(),
                mean_m_s: entry.mean_m_s(),
                deviation_m_s,
                memory,
                renewal: (1.0 - memory * memory).sqrt(),
            });
        }
        if segments.is_empty() {
            segments.push(Segment {
                first_tick: 0,
                label: String::new(),
                mean_m_s: [0.0; 3],
                deviation_m_s: 0.0,
                memory: 1.0,
                renewal: 0.0,
            });
        }
        let turbulence = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
        Ok(Wind { segments, current: 0, next_tick: 0, turbulence, rng })
    }

    /// Wind vector of the next sample period, m/s.
    pub fn advance(&mut self) -> [f64; 3] {
        while self.segments.get(self.current + 1).is_some_and(|next| next.first_tick <= self.next_tick) {
            self.current += 1;
        }
        self.next_tick += 1;
        let segment = &self.segments[self.current];
        if segment.deviation_m_s == 0.0 {
            return segment.mean_m_s;
        }
        let mut wind = segment.mean_m_s;
        for (wind, x) in wind.iter_mut().zip(&mut self.turbulence) {
            *wind += segment.deviation_m_s * *x;
            let normal: f64 = StandardNormal.sample(&mut self.rng);
            *x = segment.memory * *x + segment.renewal * normal;
        }
        wind
    }

    /// Mean wind of the entry in force, m/s.
    pub fn mean_m_s(&self) -> [f64; 3] {
        self.segments[self.current].mean_m_s
    }

    /// Label of the entry in force.
    pub fn label(&self) -> &str {
        &self.segments[self.current].label
    }
}

fn check(entry: &WindEntry, i: usize, entries: &[WindEntry]) -> Result<(), SensorError> {
    let refuse = |key: &str, value: f64, expected: &'static str| {
        Err(SensorError::out_of_range(format!("wind[{i}].{key}"), value, expected))
    };
    if i == 0 && entry.start_s != 0.0 {
        return refuse("start_s", entry.start_s, "0 for the first entry, so that the wind is known from the start");
    }
    if i > 0 && !(entry.start_s > entries[i - 1].start_s && entry.start_s.is_finite()) {
        return refuse("start_s", entry.start_s, "later than the start of the entry before it");
    }
    if !(entry.speed_m_s.is_finite() && entry.speed_m_s >= 0.0) {
        return refuse("speed_m_s", entry.speed_m_s, "zero or more; turn the direction instead of the sign");
    }
    if !entry.azimuth_deg.is_finite() {
        return refuse("azimuth_deg", entry.azimuth_deg, "a finite angle");
    }
    if !(-90.0..=90.0).contains(&entry.elevation_deg) {
        return refuse("elevation_deg", entry.elevation_deg, "-90 to 90");
    }
    if let Some(turbulence) = entry.turbulence {
        if !(0.0..=1.0).contains(&turbulence.intensity) {
            return refuse("turbulence.intensity", turbulence.intensity, "0 to 1, a fraction of the mean speed");
        }
        if !(turbulence.correlation_time_s.is_finite() && turbulence.correlation_time_s > 0.0) {
            return refuse("turbulence.correlation_time_s", turbulence.correlation_time_s, "more than 0");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    fn entry(start_s: f64, label: &str, speed_m_s: f64) -> WindEntry {
        WindEntry { start_s, label: label.into(), speed_m_s, azimuth_deg: 0.0, elevation_deg: 0.0, turbulence: None }
    }

    fn wind(entries: &[WindEntry], sample_period_s: f64) -> Wind {
        Wind::new(entries, sample_period_s, ChaCha8Rng::seed_from_u64(5)).unwrap()
    }

    #[test]
    fn holds_each_entry_until_the_next_one_starts() {
        // 0.3 / 0.1 is not 3 in binary: the entry must still begin at tick 3.
        let mut wind = wind(&[entry(0.0, "calm", 0.0), entry(0.3, "breeze", 2.0), entry(0.55, "gust", 8.0)], 0.1);
        let speeds: Vec<f64> = (0..8).map(|_| wind.advance()[0]).collect();
        assert_eq!(speeds, [0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 8.0, 8.0]);
        assert_eq!(wind.label(), "gust");
    }

    #[test]
    fn azimuth_and_elevation_say_where_the_air_goes() {
        let mut entry = entry(0.0, "", 2.0);
        (entry.azimuth_deg, entry.elevation_deg) = (90.0, 30.0);
        let [x, y, z] = entry.mean_m_s();
        assert!(x.abs() < 1e-15 && (y - 3.0_f64.sqrt()).abs() < 1e-15 && (z - 1.0).abs() < 1e-15);
    }

    #[test]
    fn turbulence_has_the_variance_and_the_correlation_time_asked_for() {
        let mut gusty = entry(0.0, "gusty", 4.0);
        gusty.turbulence = Some(Turbulence { intensity: 0.15, correlation_time_s: 1.5 });
        let (period, count) = (0.05, 2_000_000);
        let mut wind = wind(&[gusty], period);
        let samples: Vec<[f64; 3]> = (0..count).map(|_| wind.advance()).collect();
        // Independent samples: the duration over twice the correlation time.
        let independent = count as f64 * period / (2.0 * 1.5);
        let sigma = 0.15 * 4.0;
        for axis in 0..3 {
            let mean = samples.iter().map(|v| v[axis]).sum::<f64>() / count as f64;
            let expected = [4.0, 0.0, 0.0][axis];
            assert!((mean - expected).abs() < 4.0 * sigma / independent.sqrt(), "mean {mean}");
            let covariance = |lag: usize| {
                let pairs = samples.iter().zip(&samples[lag..]);
                pairs.map(|(a, b)| (a[axis] - mean) * (b[axis] - mean)).sum::<f64>() / (count - lag) as f64
            };
            // Four standard errors: σ²√(2/N) of a variance; the same, at most, of a covariance.
            let tolerance = 4.0 * (2.0 / independent).sqrt();
            assert!((covariance(0) / (sigma * sigma) - 1.0).abs() < tolerance, "variance {}", covariance(0));
            let after_tau = covariance(30) / (sigma * sigma);
            assert!((after_tau - (-1.0_f64).exp()).abs() < tolerance, "correlation after τ {after_tau}");
        }
        let cross: f64 = samples.iter().map(|v| (v[0] - 4.0) * v[1]).sum::<f64>() / count as f64;
        assert!((cross / (sigma * sigma)).abs() < 4.0 / independent.sqrt(), "components are independent: {cross}");
    }

    #[test]
    fn the_same_seed_gives_the_same_bits() {
        let mut gusty = entry(0.0, "gusty", 4.0);
        gusty.turbulence = Some(Turbulence { intensity: 0.3, correlation_time_s: 0.5 });
        let run = |seed| {
            let mut wind = Wind::new(&[gusty.clone()], 0.01, ChaCha8Rng::seed_from_u64(seed)).unwrap();
            (0..1000).map(|_| wind.advance().map(f64::to_bits)).collect::<Vec<_>>()
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }

    #[test]
    fn refuses_impossible_entries_by_name() {
        let mut cases = vec![(vec![entry(1.0, "", 1.0)], "wind[0].start_s")];
        cases.push((vec![entry(0.0, "", 1.0), entry(0.0, "", 2.0)], "wind[1].start_s"));
        cases.push((vec![entry(0.0, "", -1.0)], "wind[0].speed_m_s"));
        cases.push((vec![entry(0.0, "", f64::NAN)], "wind[0].speed_m_s"));
        cases.push((vec![WindEntry { elevation_deg: 91.0, ..entry(0.0, "", 1.0) }], "wind[0].elevation_deg"));
        let turbulence = Some(Turbulence { intensity: 0.1, correlation_time_s: 0.0 });
        cases.push((vec![WindEntry { turbulence, ..entry(0.0, "", 1.0) }], "wind[0].turbulence.correlation_time_s"));
        for (entries, name) in cases {
            let error = Wind::new(&entries, 0.01, ChaCha8Rng::seed_from_u64(1)).unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
    }
}
