//! Statistics of the wind estimates of a run: their number, quality flags, mean speed and standard
//! errors; elements that no loop holds; heat that elements without a surface gain on ways that the
//! identification did not have.

use std::collections::BTreeMap;
use std::fmt;

use dr_core::control::{MOST_ELEMENTS, RunState, Tick};
use dr_core::wind::QualityFlags;
use recording::text::count;
use serde::Serialize;
use wire::WindSample;

use super::comparison::SLOWEST_M_S;

/// Adds wind estimates up.
#[derive(Debug, Clone, Default)]
pub struct EstimateTally {
    estimates: u64,
    quality_flags: BTreeMap<&'static str, u64>,
    /// Estimates that have a wind.
    winds: u64,
    speed_m_s: f64,
    speed_error_m_s: LogMedian,
    /// Medians of winds that have a relative speed to speak of, and of those that have a direction,
    /// °.
    relative_error: LogMedian,
    direction_error_deg: LogMedian,
}

/// Statistics of all estimates of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EstimateSummary {
    /// Number of wind estimates.
    pub estimates: u64,
    /// Number of estimates with each flag; flags that were never raised are left out.
    pub quality_flags: BTreeMap<&'static str, u64>,
    /// Mean speed of estimates that have a wind; `None` if there was none.
    pub mean_speed_m_s: Option<f64>,
    /// Standard error of one estimate by the noise of the readings: the median, since a few
    /// estimates right after a jump of the wind have very great ones.
    pub speed_error_m_s: Option<f64>,
    /// The same as a share of the speed.
    pub speed_standard_error: Option<f64>,
    /// The same of the direction, °.
    pub direction_standard_error_deg: Option<f64>,
}

impl EstimateTally {
    /// Adds an estimate.
    pub fn add(&mut self, estimate: &WindSample) {
        self.estimates += 1;
        for (flag, name) in QualityFlags::NAMES {
            if estimate.quality_flags.has(flag) {
                *self.quality_flags.entry(name).or_default() += 1;
            }
        }
        if !estimate.quality_flags.has(QualityFlags::FAILED) {
            self.winds += 1;
            self.speed_m_s += f64::from(estimate.speed_m_s);
            self.speed_error_m_s.add(f64::from(estimate.speed_error_m_s));
            if f64::from(estimate.speed_m_s) >= SLOWEST_M_S {
                self.relative_error.add(f64::from(estimate.speed_error_m_s / estimate.speed_m_s));
                if !estimate.quality_flags.has(QualityFlags::NO_DIRECTION) {
                    self.direction_error_deg.add(f64::from(estimate.direction_error_rad.to_degrees()));
                }
            }
        }
    }

    /// The statistics so far.
    pub fn summary(&self) -> EstimateSummary {
        EstimateSummary {
            estimates: self.estimates,
            quality_flags: self.quality_flags.clone(),
            mean_speed_m_s: (self.winds > 0).then(|| self.speed_m_s / self.winds as f64),
            speed_error_m_s: self.speed_error_m_s.value(),
            speed_standard_error: self.relative_error.value(),
            direction_standard_error_deg: self.direction_error_deg.value(),
        }
    }
}

impl fmt::Display for EstimateSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", count(self.estimates as usize, "wind estimate"))?;
        if let (Some(speed_m_s), Some(error_m_s)) = (self.mean_speed_m_s, self.speed_error_m_s) {
            write!(f, ", mean speed {speed_m_s:.2} m/s, each with a standard error of about {error_m_s:.2} m/s")?;
        } else {
            write!(f, ", none with a wind")?;
        }
        writeln!(f)?;
        for (name, number) in &self.quality_flags {
            writeln!(f, "  {name:<13} {:.1} %", 100.0 * *number as f64 / self.estimates.max(1) as f64)?;
        }
        Ok(())
    }
}

/// Bins by the factor e.
const BINS: f64 = 200.0;

/// Values that are not negative, counted by their logarithm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LogMedian {
    counts: BTreeMap<i32, u64>,
    count: u64,
}

impl LogMedian {
    /// Counts a value, unless it is negative or not finite.
    pub fn add(&mut self, value: f64) {
        if value.is_finite() && value >= 0.0 {
            // ln 0 is the least bin of all.
            *self.counts.entry((BINS * libm::log(value)).round() as i32).or_default() += 1;
            self.count += 1;
        }
    }

    /// The median; `None` without values.
    pub fn value(&self) -> Option<f64> {
        let mut left = self.count.div_ceil(2);
        for (&bin, &count) in &self.counts {
            if count >= left {
                return Some(libm::exp(f64::from(bin) / BINS));
            }
            left -= count;
        }
        None
    }
}

/// A loop changes its level far more often than this; the first tick may precede the heating.
const MOST_CHANGES: u32 = 1;

/// Counts changes of the heater levels.
#[derive(Debug, Clone, Default)]
pub struct LevelRecord {
    last: Option<usize>,
    changes: Vec<u32>,
}

impl LevelRecord {
    /// Adds a tick; those without a run count for nothing.
    pub fn add(&mut self, tick: &Tick<MOST_ELEMENTS>) {
        if tick.state != RunState::Running {
            return;
        }
        let changed = self.last.map_or(0, |last| last ^ tick.heaters.0);
        self.changes.resize(tick.elements.into(), 0);
        for (i, count) in self.changes.iter_mut().enumerate() {
            *count += (changed >> i & 1) as u32;
        }
        self.last = Some(tick.heaters.0);
    }

    /// Tells whether an element stayed at its level all the time.
    pub fn is_constant(&self, element: usize) -> bool {
        self.last.is_some() && self.changes.get(element).is_some_and(|changes| *changes <= MOST_CHANGES)
    }
}

/// Less heat than this is no drift that matters: 0.01 % of R₀ of a core of sphere B, which is 0.2 %
/// of speed.
const MATTERS_W: f64 = 1e-3;
/// Heats whose sizes are nearer to each other than this ratio are of one cause.
const ALIKE: f64 = 0.5;

/// Statistics of one element's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnknownHeat {
    /// Name of the element.
    pub element: String,
    /// Mean, W.
    pub mean_w: f64,
    /// Least and greatest, W.
    pub range_w: [f64; 2],
    /// Place of the element in the head.
    #[serde(skip)]
    pub place: usize,
    #[serde(skip)]
    count: u64,
}

impl UnknownHeat {
    /// Record of an element of which nothing is known yet.
    pub fn new(element: String, place: usize) -> Self {
        Self { element, place, mean_w: 0.0, range_w: [f64::INFINITY, f64::NEG_INFINITY], count: 0 }
    }

    /// Adds the heat at an estimate.
    pub fn add(&mut self, heat_w: f64) {
        self.count += 1;
        self.mean_w += (heat_w - self.mean_w) / self.count as f64;
        self.range_w = [self.range_w[0].min(heat_w), self.range_w[1].max(heat_w)];
    }

    /// Tells whether anything was added.
    pub fn is_known(&self) -> bool {
        self.count > 0
    }
}

/// Two elements whose heats no support explains, in words: it gives both the same sign.
pub fn contradiction(heats: &[UnknownHeat]) -> Option<String> {
    let least = heats.iter().min_by(|a, b| a.mean_w.total_cmp(&b.mean_w))?;
    let most = heats.iter().max_by(|a, b| a.mean_w.total_cmp(&b.mean_w))?;
    let (gained_w, lost_w) = (most.mean_w, -least.mean_w);
    (gained_w.min(lost_w) > MATTERS_W.max(ALIKE * gained_w.max(lost_w))).then(|| {
        format!(
            "heat of {most} and {least} has opposite signs, which no support gives: the resistor of one has drifted, and the wind is wrong by it"
        )
    })
}

impl fmt::Display for UnknownHeat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.range_w.map(|of| 1e3 * of);
        write!(f, "`{}` {:.2} mW ({least:.2} to {most:.2})", self.element, 1e3 * self.mean_w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(speed_m_s: f32, quality_flags: QualityFlags) -> WindSample {
        WindSample {
            quality_flags,
            wind_m_s: [speed_m_s, 0.0, 0.0],
            speed_m_s,
            across_m_s: 0.0,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.5,
            direction_error_rad: 0.0,
            chi_square: 0.0,
            gas_c: 0.0,
            conductance_w_k: [0.0; 4].into_iter().collect(),
            raw_w_k: [0.0; 4].into_iter().collect(),
        }
    }

    #[test]
    fn estimates_without_a_wind_are_counted_and_have_no_speed() {
        let mut tally = EstimateTally::default();
        tally.add(&estimate(2.0, QualityFlags::default()));
        tally.add(&estimate(4.0, QualityFlags::STARTING));
        tally.add(&estimate(0.0, QualityFlags(QualityFlags::FAILED.0 | QualityFlags::NO_GAS.0)));
        let summary = tally.summary();
        assert_eq!((summary.estimates, summary.mean_speed_m_s), (3, Some(3.0)));
        assert!((summary.speed_error_m_s.unwrap() - 0.5).abs() < 3e-3);
        // 0.5 m/s of 2 m/s, and of 4 m/s: the median is the lower one of two.
        assert!((summary.speed_standard_error.unwrap() - 0.125).abs() < 1e-3);
        assert_eq!(summary.quality_flags, BTreeMap::from([("failed", 1), ("no-gas", 1), ("starting", 1)]));
        let text = summary.to_string();
        assert!(
            text.contains("3 wind estimates, mean speed 3.00 m/s") && text.contains("no-gas        33.3 %"),
            "{text}"
        );
        let mut none = EstimateTally::default();
        none.add(&estimate(0.0, QualityFlags::FAILED));
        assert_eq!(none.summary().mean_speed_m_s, None);
        assert!(none.summary().to_string().starts_with("1 wind estimate, none with a wind\n"));
    }
}

#[cfg(test)]
mod median_tests {
    use super::*;

    #[test]
    fn is_the_middle_value_to_half_a_per_cent_whatever_the_greatest_is() {
        let mut median = LogMedian::default();
        assert_eq!(median.value(), None);
        for value in [3e-3, 1e6, 0.0, 2e-3, 1e9, f64::NAN, -1.0] {
            median.add(value);
        }
        assert!((median.value().unwrap() / 3e-3 - 1.0).abs() < 5e-3, "{median:?}");
        let mut none = LogMedian::default();
        none.add(0.0);
        assert_eq!(none.value(), Some(0.0));
    }
}

#[cfg(test)]
mod level_record_tests {
    use super::super::moment::{ElementReading, Ticks};
    use super::*;

    #[test]
    fn an_element_that_no_loop_holds_stays_at_its_level() {
        let (mut ticks, mut levels) = (Ticks::new(0.01), LevelRecord::default());
        assert!(!levels.is_constant(0));
        for n in 0..100 {
            // The first at the high level from the second tick on, the other with a loop.
            let readings = [n > 0, n % 3 == 0];
            let readings =
                readings.map(|is_high| ElementReading { temperature_c: 20.0, power_w: 0.0, is_high }).into_iter();
            levels.add(&ticks.tick(0.01 * f64::from(n), RunState::Running, readings));
        }
        assert!(levels.is_constant(0) && !levels.is_constant(1));
    }
}

#[cfg(test)]
mod unknown_heat_tests {
    use super::*;

    #[test]
    fn mean_and_range_are_of_what_was_added() {
        let mut heat = UnknownHeat::new("core1".to_owned(), 4);
        assert!(!heat.is_known());
        [1e-3, -2e-3, 4e-3].into_iter().for_each(|of| heat.add(of));
        assert_eq!(heat.to_string(), "`core1` 1.00 mW (-2.00 to 4.00)");
        assert!(heat.is_known());
    }

    #[test]
    fn a_core_that_gains_what_the_other_loses_has_drifted() {
        let heats = |means_w: [f64; 2]| {
            let mut heats = vec![UnknownHeat::new("core1".to_owned(), 4), UnknownHeat::new("core2".to_owned(), 5)];
            heats.iter_mut().zip(means_w).for_each(|(heat, mean_w)| heat.add(mean_w));
            heats
        };
        let said = contradiction(&heats([-7.35e-3, 7.92e-3])).unwrap();
        assert!(said.starts_with("heat of `core2` 7.92 mW (7.92 to 7.92) and `core1` -7.35 mW"), "{said}");
        // A support, next to nothing, and a core in the wind beside one that is not.
        for other in [[12e-3, 12e-3], [-12e-3, -12e-3], [0.5e-3, -0.5e-3], [-3.8e-3, 1.1e-3], [0.0, 0.0]] {
            assert_eq!(contradiction(&heats(other)), None, "{other:?}");
        }
        assert_eq!(contradiction(&[]), None);
    }
}
