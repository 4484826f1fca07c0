//! Options of averages; averages as text, as JSON, and as a table.

use std::fmt;
use std::path::{Path, PathBuf};

use recording::head_mounting::HeadMounting;
use recording::text::{columns, count, listed, tidy};
use recording::{Metadata, RecordingError, write_table};
use serde::Serialize;

use super::eddy::Sampled;
use super::wind_series::{LEAST_SHARE, WindStatistics};

/// Intervals and reasons that a report names.
const MOST_NAMED: usize = 6;
/// Turbulence intensity from which on standard deviations are compared: in a steady wind they are
/// those of noise.
const LEAST_TURBULENCE: f64 = 0.01;

/// An interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeanInterval {
    /// s.
    pub begin_s: f64,
    /// s.
    pub end_s: f64,
    /// Share of the estimates that count.
    pub valid_share: f64,
    /// Reason. Of an interval without statistics, the flag for which most do not; none where more
    /// rows lack.
    pub left_out_by: Option<&'static str>,
    /// None where too few estimates count.
    pub statistics: Option<WindStatistics>,
    /// The same of the true wind, where it is known.
    pub truth: Option<WindStatistics>,
}

/// Distance of the statistics from those of the true wind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeteorologyComparison {
    /// Intervals with both.
    pub intervals: usize,
    /// Mean and rms of the relative error of the mean speed.
    pub mean_speed: [f64; 2],
    /// The same of its standard deviation, where the wind had one; NaN where it never had.
    pub speed_sd: [f64; 2],
    /// The same of the gust.
    pub gust: [f64; 2],
    /// Mean and rms of the error of the direction, °.
    pub direction_deg: [f64; 2],
    /// Mean and rms of the relative error of the standard deviation of the direction.
    pub direction_sd: [f64; 2],
}

/// Averages of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeteorologyReport {
    /// The recording.
    pub recording: PathBuf,
    /// Its title.
    pub title: String,
    /// Length of an interval, s.
    pub interval_s: f64,
    /// Bandwidth of the wind, Hz, where it is known.
    pub bandwidth_hz: Option<f64>,
    /// Directions are those of the compass.
    pub has_heading: bool,
    /// Interval by interval.
    pub intervals: Vec<MeanInterval>,
    /// Compared with the true wind, where it is known.
    pub comparison: Option<MeteorologyComparison>,
    /// The file that was written.
    #[serde(skip)]
    pub written: Option<PathBuf>,
}

impl MeteorologyReport {
    pub(super) fn new(
        path: &Path,
        metadata: &Metadata,
        options: &AveragingOptions,
        bandwidth_hz: Option<f64>,
        intervals: Vec<MeanInterval>,
    ) -> Self {
        Self {
            recording: path.to_owned(),
            title: title(path, metadata),
            interval_s: options.interval_s,
            bandwidth_hz,
            has_heading: options.mounting.is_some(),
            comparison: MeteorologyComparison::of(&intervals),
            intervals,
            written: None,
        }
    }

    /// Writes the averages as a .parquet or .csv file, a row an interval; `time_s` is its begin.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path, metadata: &Metadata) -> Result<(), RecordingError> {
        let of = |number: &dyn Fn(&WindStatistics) -> Option<f64>| -> Vec<f64> {
            let cell = |of: &MeanInterval| of.statistics.as_ref().and_then(number).unwrap_or(f64::NAN);
            self.intervals.iter().map(cell).collect()
        };
        let mut table: Vec<(&str, Vec<f64>)> = vec![
            ("interval_s", vec![self.interval_s; self.intervals.len()]),
            ("valid_share", self.intervals.iter().map(|of| of.valid_share).collect()),
        ];
        for (name, number) in NUMBERS {
            table.push((name, of(&number)));
        }
        if self.intervals.iter().any(|of| of.statistics.as_ref().is_some_and(|of| of.fluxes.is_some())) {
            for (name, uncertainty, flux) in FLUXES {
                table.push((name, of(&|of| flux(of).map(|of| of.value))));
                table.push((uncertainty, of(&|of| flux(of).map(|of| of.u))));
            }
        }
        let time_s: Vec<f64> = self.intervals.iter().map(|of| of.begin_s).collect();
        let table: Vec<(&str, &[f64])> = table.iter().map(|(name, values)| (*name, values.as_slice())).collect();
        write_table(path, &time_s, &table, metadata)
    }
}

type Number = fn(&WindStatistics) -> Option<f64>;
type Flux = fn(&WindStatistics) -> Option<Sampled>;

/// Columns of the table.
const NUMBERS: [(&str, Number); 9] = [
    ("mean_speed_m_s", |of| Some(of.mean_speed_m_s)),
    ("mean_speed_u_m_s", |of| of.speed_u_m_s),
    ("vector_speed_m_s", |of| of.vector_speed_m_s),
    ("wind_from_deg", |of| of.wind_from_deg),
    ("wind_up_m_s", |of| of.wind_up_m_s),
    ("speed_sd_m_s", |of| Some(of.speed_sd_m_s)),
    ("direction_sd_deg", |of| of.direction_sd_deg),
    ("gust_m_s", |of| of.gust_m_s),
    ("turbulence_intensity", |of| Some(of.turbulence_intensity)),
];

/// Columns of fluxes, and of their uncertainties.
const FLUXES: [(&str, &str, Flux); 4] = [
    ("uw_m2_s2", "uw_u_m2_s2", |of| of.fluxes.as_ref()?.uw_m2_s2),
    ("friction_velocity_m_s", "friction_velocity_u_m_s", |of| of.fluxes.as_ref()?.friction_velocity_m_s),
    ("heat_flux_k_m_s", "heat_flux_u_k_m_s", |of| of.fluxes.as_ref()?.heat_flux_k_m_s),
    ("obukhov_length_m", "obukhov_length_u_m", |of| of.fluxes.as_ref()?.obukhov_length_m),
];

impl MeteorologyComparison {
    fn of(intervals: &[MeanInterval]) -> Option<Self> {
        let pairs = || intervals.iter().filter_map(|of| Some((of.statistics.as_ref()?, of.truth.as_ref()?)));
        let intervals = pairs().count();
        let relative =
            |number: Number| summary(pairs().filter_map(|(found, truth)| Some(number(found)? / number(truth)? - 1.0)));
        let gusty = || pairs().filter(|(_, truth)| truth.turbulence_intensity >= LEAST_TURBULENCE);
        let of_gusty =
            |number: Number| summary(gusty().filter_map(|(found, truth)| Some(number(found)? / number(truth)? - 1.0)));
        let turn = |deg: f64| (deg + 180.0).rem_euclid(360.0) - 180.0;
        let directions = pairs().filter_map(|(found, truth)| Some(turn(found.wind_from_deg? - truth.wind_from_deg?)));
        (intervals > 0).then(|| Self {
            intervals,
            mean_speed: relative(|of| Some(of.mean_speed_m_s)),
            speed_sd: of_gusty(|of| Some(of.speed_sd_m_s)),
            gust: relative(|of| of.gust_m_s),
            direction_deg: summary(directions),
            direction_sd: of_gusty(|of| of.direction_sd_deg),
        })
    }
}

/// Mean and rms; NaN of nothing, which JSON has as null.
fn summary(errors: impl Iterator<Item = f64>) -> [f64; 2] {
    let (sum, squares, count) = errors
        .filter(|of| of.is_finite())
        .fold((0.0, 0.0, 0.0), |(sum, squares, count), of| (sum + of, squares + of * of, count + 1.0));
    [sum / count, (squares / count).sqrt()]
}

/// The recording's own words, for a table of averages.
fn title(path: &Path, metadata: &Metadata) -> String {
    let title = metadata.iter().find(|(key, _)| key == "title").map(|(_, title)| title.clone());
    title.unwrap_or_else(|| path.display().to_string())
}

impl fmt::Display for MeteorologyReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bandwidth = self.bandwidth_hz.map_or(String::new(), |hz| format!(", bandwidth {hz} Hz"));
        writeln!(f, "{}: means of {} s{bandwidth}", self.title, self.interval_s)?;
        if !self.has_heading {
            writeln!(f, "no heading is known: directions count from the head's x axis, as if it pointed north")?;
        }
        write!(f, "{}", self.table())?;
        let left_out = self.intervals.iter().filter(|of| of.statistics.is_none());
        let left_out: Vec<String> = left_out
            .map(|of| format!("{} s ({:.0} %{})", tidy(of.begin_s), 100.0 * of.valid_share, of.cause()))
            .collect();
        if !left_out.is_empty() {
            let (intervals, least) = (count(left_out.len(), "interval"), 100.0 * LEAST_SHARE);
            write!(f, "{intervals} left out, as less than {least} % of the estimates count: ")?;
            writeln!(f, "from {}", listed(&left_out, MOST_NAMED))?;
        }
        self.fluxes(f)?;
        if let Some(comparison) = &self.comparison {
            let of = |[mean, rms]: [f64; 2]| match mean.is_nan() {
                true => "nothing to compare with".to_owned(),
                false => format!("{:+.1} % in the mean, {:.1} % rms", 100.0 * mean, 100.0 * rms),
            };
            writeln!(f, "\ncompared with the true wind, {}", count(comparison.intervals, "interval"))?;
            writeln!(f, "  mean speed          {}", of(comparison.mean_speed))?;
            let [mean_deg, rms_deg] = comparison.direction_deg;
            writeln!(f, "  direction           {mean_deg:+.1}° in the mean, {rms_deg:.1}° rms")?;
            writeln!(f, "  sd of speed         {}", of(comparison.speed_sd))?;
            writeln!(f, "  sd of direction     {}", of(comparison.direction_sd))?;
            writeln!(f, "  gust                {}", of(comparison.gust))?;
        }
        self.written.iter().try_for_each(|path| writeln!(f, "\nwritten to {}", path.display()))
    }
}

impl MeanInterval {
    /// Why estimates do not count, in words.
    fn cause(&self) -> String {
        self.left_out_by.map_or_else(|| ", few rows".to_owned(), |flag| format!(", `{flag}`"))
    }
}

impl MeteorologyReport {
    fn table(&self) -> String {
        let heads =
            ["from s", "valid", "speed m/s", "vector m/s", "from °", "up m/s", "sd m/s", "sd °", "gust m/s", "TI"];
        let mut lines = vec![heads.map(str::to_owned).to_vec()];
        let number = |of: Option<f64>, digits: usize| of.map_or("–".to_owned(), |of| format!("{of:.digits$}"));
        for interval in &self.intervals {
            let Some(of) = &interval.statistics else { continue };
            // A rounded 360 is north.
            let from = of.wind_from_deg.map(|from_deg| from_deg.round() % 360.0);
            lines.push(vec![
                tidy(interval.begin_s).to_string(),
                format!("{:.0} %", 100.0 * interval.valid_share),
                match of.speed_u_m_s {
                    Some(u) => format!("{:.2} ± {u:.2}", of.mean_speed_m_s),
                    None => number(Some(of.mean_speed_m_s), 2),
                },
                number(of.vector_speed_m_s, 2),
                number(from, 0),
                number(of.wind_up_m_s, 2),
                number(Some(of.speed_sd_m_s), 2),
                number(of.direction_sd_deg, 1),
                number(of.gust_m_s, 2),
                number(Some(of.turbulence_intensity), 3),
            ]);
        }
        if lines.len() == 1 { String::new() } else { columns(&lines, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]) }
    }

    fn fluxes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let with = |of: &MeanInterval| Some((of.begin_s, of.statistics.as_ref()?.fluxes.clone()?));
        let all: Vec<_> = self.intervals.iter().filter_map(with).collect();
        if all.is_empty() {
            return Ok(());
        }
        let cell = |of: Option<Sampled>| of.map_or("–".to_owned(), |of| recording::text::estimate(of.value, of.u));
        let mut lines = vec![["from s", "u* m/s", "u'w' m²/s²", "w'T' K m/s", "L m"].map(str::to_owned).to_vec()];
        let mut reasons: Vec<(String, usize)> = Vec::new();
        for (begin_s, of) in &all {
            lines.push(vec![
                tidy(*begin_s).to_string(),
                cell(of.friction_velocity_m_s),
                cell(of.uw_m2_s2),
                cell(of.heat_flux_k_m_s),
                cell(of.obukhov_length_m),
            ]);
            for reason in &of.left_out {
                // The flux alone: speeds differ from interval to interval.
                let flux = |reason: &str| reason.split(':').next().unwrap_or_default().to_owned();
                match reasons.iter_mut().find(|(own, _)| flux(own) == flux(reason)) {
                    Some((_, count)) => *count += 1,
                    None => reasons.push((reason.clone(), 1)),
                }
            }
        }
        write!(f, "\n{}", columns(&lines, &[0, 1, 2, 3, 4]))?;
        for (reason, number) in reasons.iter().take(MOST_NAMED) {
            writeln!(f, "left out in {}: {reason}", count(*number, "interval"))?;
        }
        Ok(())
    }
}

/// Intervals, mounting, and what fluxes need.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragingOptions {
    /// Length of an interval, s.
    pub interval_s: f64,
    /// Estimates before do not count, and the first interval begins there, s.
    pub from_s: f64,
    /// Mounting of the head; directions count from its x axis where that is not known.
    pub mounting: Option<HeadMounting>,
    /// Height above the ground, m, for fluxes.
    pub height_m: Option<f64>,
    /// Bandwidth of the wind, Hz, in place of that which the recording states.
    pub bandwidth_hz: Option<f64>,
    /// Bandwidth of the gas temperature, Hz.
    pub temperature_bandwidth_hz: Option<f64>,
    /// m/s².
    pub gravity_m_s2: f64,
}
