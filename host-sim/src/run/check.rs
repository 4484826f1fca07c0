//! Preview of an experiment, without doing it: for people, and as JSON.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use dr_core::control::Drive;
use dr_core::sensor::Level;
use serde::Serialize;

use super::start::SetPointJudgement;
use crate::experiment::{DriveChange, Experiment};
use crate::sensor::{DirectionSwing, DustDevil, Gust, Sine, Spectrum, TemperatureSwing, WindEntry};
use anemometry::gas::Species;
use recording::text::tidy;

/// Entries of a list that are printed one by one.
const MOST: usize = 12;

/// An experiment with the verdict on its set-points.
#[derive(Debug, Clone, Serialize)]
pub struct CheckReport<'a> {
    title: &'a str,
    head: &'a str,
    ticks: u32,
    sample_period_s: f64,
    duration_s: f64,
    drives: BTreeMap<&'a str, String>,
    changes: Vec<ChangeReport<'a>>,
    currents: BTreeMap<&'a str, CurrentLevels>,
    gas_swing: Option<TemperatureSwing>,
    support_swing: Option<TemperatureSwing>,
    winds: usize,
    #[serde(flatten)]
    judgement: SetPointJudgement,
    models: Option<&'a str>,
    /// Differences from the head's calibration that matter.
    differences: Vec<String>,
    #[serde(skip)]
    experiment: &'a Experiment,
}

#[derive(Debug, Clone, Serialize)]
struct ChangeReport<'a> {
    start_s: f64,
    drives: BTreeMap<&'a str, String>,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct CurrentLevels {
    low_a: f64,
    high_a: f64,
}

impl<'a> CheckReport<'a> {
    /// Preview of what would run, and how many of its set-points can be held.
    pub fn new(experiment: &'a Experiment, judgement: SetPointJudgement) -> Self {
        let names = experiment.head.names();
        let described = |(element, drive): (usize, &Drive)| (names[element], describe(drive, experiment));
        let change = |change: &DriveChange| ChangeReport {
            start_s: experiment.time_s(change.tick),
            drives: change.drives.iter().map(|(element, drive)| described((*element, drive))).collect(),
        };
        let levels = |&element: &usize| {
            let nominal = &experiment.head.elements[element].nominal;
            (names[element], CurrentLevels { low_a: nominal.current_low_a, high_a: nominal.current_high_a })
        };
        Self {
            title: &experiment.title,
            head: &experiment.head.name,
            ticks: experiment.ticks,
            sample_period_s: experiment.sample_period_s,
            duration_s: experiment.duration_s(),
            drives: experiment.drives.iter().enumerate().map(described).collect(),
            changes: experiment.changes.iter().map(change).collect(),
            currents: experiment.currents.iter().map(levels).collect(),
            gas_swing: experiment.gas_swing,
            support_swing: experiment.support_swing,
            winds: experiment.wind.len(),
            judgement,
            differences: experiment.differences(),
            models: experiment.models.as_ref().map(|models| models.conditions.as_str()),
            experiment,
        }
    }

    /// Writes later drives. Those of a change are sorted by name, as in the file.
    fn write_changes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.changes.is_empty() {
            writeln!(f)?;
        }
        for ChangeReport { start_s, drives } in self.changes.iter().take(MOST) {
            let drives: Vec<String> = drives.iter().map(|(name, drive)| format!("{name}: {drive}")).collect();
            writeln!(f, "from {start_s:>6} s  {}", drives.join("; "))?;
        }
        f.write_str(&left_out(self.changes.len()))
    }

    /// Levels that are the experiment's and not the head's.
    fn write_currents(&self, f: &mut fmt::Formatter<'_>, names: &[&str]) -> fmt::Result {
        if !self.currents.is_empty() {
            writeln!(f)?;
        }
        for name in names {
            let Some(CurrentLevels { low_a, high_a }) = self.currents.get(name) else { continue };
            // 8.9 mA has no end in A.
            let [low, high] = [low_a, high_a].map(|current_a| (1e9 * current_a).round() / 1e6);
            writeln!(f, "{name}: {low} mA low and {high} mA high, in place of the head's")?;
        }
        Ok(())
    }
}

impl fmt::Display for CheckReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { experiment, judgement: SetPointJudgement { judged, unjudged }, .. } = *self;
        let names = experiment.head.names();
        writeln!(
            f,
            "{} · head {}\n{} ticks of {} ms, {} s, in {} of {} Pa at {} °C{}, support at {} °C{}\n",
            experiment.title,
            experiment.head.name,
            experiment.ticks,
            experiment.sample_period_s * 1e3,
            experiment.duration_s(),
            match experiment.species {
                Species::CarbonDioxide => "CO2",
                Species::Air => "air",
            },
            experiment.pressure_pa,
            experiment.gas_temperature_c,
            swinging(experiment.gas_swing),
            experiment.support_temperature_c,
            swinging(experiment.support_swing)
        )?;
        let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        for name in &names {
            writeln!(f, "{name:width$}  {}", self.drives[name])?;
        }
        self.write_changes(f)?;
        self.write_currents(f, &names)?;
        let field = experiment.field.keys();
        if !field.is_empty() {
            writeln!(f, "\neffects of the field: {}", field.join(", "))?;
        }
        writeln!(f)?;
        for entry in experiment.wind.iter().take(MOST) {
            writeln!(
                f,
                "from {:>6} s  {:>5} m/s towards {:>4}° azimuth, {:>3}° elevation{}  ({})",
                entry.start_s,
                // 7 m/min has no end in m/s.
                tidy(entry.speed_m_s),
                tidy(entry.azimuth_deg),
                tidy(entry.elevation_deg),
                blown(entry),
                entry.label
            )?;
        }
        f.write_str(&left_out(experiment.wind.len()))?;
        for fault in &experiment.faults {
            writeln!(f, "from {:>6} s  {} breaks: {:?}", fault.start_s, names[fault.element], fault.fault)?;
        }
        for difference in &self.differences {
            writeln!(f, "\nwarning: {difference}")?;
        }
        let conditions = self.models.unwrap_or_default();
        match (judged, unjudged) {
            (0, 0) => Ok(()),
            (judged, 0) => writeln!(f, "\n{} can be held according to the models for {conditions}", set_points(judged)),
            (0, unjudged) => {
                writeln!(f, "\n{} are not judged: the experiment names no `models` for them", set_points(unjudged))
            }
            (judged, unjudged) => writeln!(
                f,
                "\n{} can be held according to the models for {conditions}; no model judges {}",
                set_points(judged),
                set_points(unjudged)
            ),
        }
    }
}

/// Wind on top of a mean.
fn blown(entry: &WindEntry) -> String {
    let mut text = String::new();
    if let Some(turbulence) = entry.turbulence {
        let _ = write!(text, ", {} % turbulence", turbulence.intensity * 100.0);
        let _ = match turbulence.spectrum {
            Spectrum::Relaxation { .. } => Ok(()),
            Spectrum::VonKarman { length_m } => write!(text, " (von Kármán, {length_m} m)"),
            Spectrum::Kaimal { height_m } => write!(text, " (Kaimal, {height_m} m above ground)"),
        };
    }
    if let Some(Sine { amplitude_m_s, frequency_hz }) = entry.sine {
        let _ = write!(text, ", ± {amplitude_m_s} m/s at {frequency_hz} Hz");
    }
    if let Some(DirectionSwing { amplitude_deg, frequency_hz }) = entry.swing {
        let _ = write!(text, ", ± {amplitude_deg}° at {frequency_hz} Hz");
    }
    if let Some(Gust { start_s, duration_s, rise_m_s, .. }) = entry.gust {
        let _ = write!(text, ", a gust of {rise_m_s} m/s at {} s for {duration_s} s", entry.start_s + start_s);
    }
    if let Some(DustDevil { time_s, miss_m, swirl_m_s, .. }) = entry.dust_devil {
        let _ = write!(
            text,
            ", a dust devil of {swirl_m_s} m/s passing at {} s in {} m",
            entry.start_s + time_s,
            miss_m.abs()
        );
    }
    text
}

/// Swing of a temperature, if it does.
fn swinging(swing: Option<TemperatureSwing>) -> String {
    let Some(TemperatureSwing { amplitude_k, period_s, start_s }) = swing else { return String::new() };
    let from = if start_s > 0.0 { format!(" from {start_s} s on") } else { String::new() };
    format!(" ± {amplitude_k} K in {period_s} s{from}")
}

/// Number of entries that are not printed.
fn left_out(entries: usize) -> String {
    match entries.checked_sub(MOST) {
        Some(more @ 1..) => format!("… and {more} more\n"),
        _ => String::new(),
    }
}

fn describe(drive: &Drive, experiment: &Experiment) -> String {
    let seconds = |ticks: u32| experiment.time_s(ticks);
    match *drive {
        Drive::Passive => "passive: only senses".to_owned(),
        Drive::Level(Level::Low) => "constant current, low level".to_owned(),
        Drive::Level(Level::High) => "constant current, high level".to_owned(),
        Drive::Power { power_w } => format!("constant power, {power_w} W"),
        Drive::Temperature { target_c } => format!("constant temperature, {target_c} °C"),
        Drive::SecondOrder { target, .. } => format!("constant temperature, {target} °C, by a loop of second order"),
        Drive::Prbs { order, seed, ticks_per_bit } => {
            format!("pseudo-random bits of {} s, order {order}, seed {seed}", seconds(ticks_per_bit))
        }
        Drive::Alternation { low_c, high_c, half_ticks } => {
            format!("constant temperature, {high_c} and {low_c} °C in turn, each for {} s", seconds(half_ticks))
        }
        Drive::Setpoints { low_c, high_c, dwell_ticks, seed } => {
            format!("random set-points from {low_c} to {high_c} °C, each for {} s, seed {seed}", seconds(dwell_ticks))
        }
    }
}

fn set_points(count: u32) -> String {
    if count == 1 { "1 set-point".to_owned() } else { format!("{count} set-points") }
}
