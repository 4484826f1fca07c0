//! Test of the currents: all elements that a head may drive heated pseudo-randomly at once, a bit a
//! tick, and the ratio of the currents of each from its own ticks by
//! [`anemometry::current_ratio`].
//!
//! Safe by the guard, as every run, and by ending early: an element that comes near its
//! `temperature_max_c` ends the excitation, and what there is by then is judged. Each element has
//! half the power of its high level in the mean.

use std::fmt;
use std::path::PathBuf;

use anemometry::current_ratio::{CurrentRatioError, CurrentRatioTicks, CurrentRatioUnknown, current_ratio};
use anemometry::head::{Head, HeadElement};
use dr_core::Command;
use dr_core::control::{Drive, RunState};
use dr_core::sensor::Level;
use recording::text::{columns, count};
use serde::{Serialize, Serializer};

use crate::instrument::observation::TickSample;
use crate::instrument::{InstrumentError, InstrumentPort, setup};

/// Sample period of the test, s: the shorter, the further is the error from any heat.
pub const PERIOD_S: f64 = 1e-3;
/// Errors beyond it fail, ppm: 3 mK between the levels. At 20 ppm winds of sphere B are wrong by a
/// degree in the mean.
pub const BOUND_PPM: f64 = 10.0;
/// Coverage factor of printed uncertainties and of verdicts.
const COVERAGE: f64 = 2.0;
/// An element so near to its `temperature_max_c` ends the excitation, K.
const MARGIN_K: f64 = 5.0;

/// Finding on an element's currents.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CurrentsFinding {
    /// Name of the element.
    pub element: String,
    /// `pass`, `off`, `uncertain` or `unknown`.
    pub verdict: &'static str,
    /// High over low current by the head.
    pub head_ratio: f64,
    /// Error of the ratio, ppm, if it is known.
    pub error_ppm: Option<f64>,
    /// Standard uncertainty of the error, ppm.
    pub error_u_ppm: Option<f64>,
    /// Why the ratio is not known.
    pub why: Option<String>,
    /// The error, if its uncertainty is small enough.
    #[serde(skip)]
    known: Option<CurrentRatioError>,
}

/// Result of a test of the currents.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CurrentsReport {
    /// Name and version of the firmware.
    pub firmware: String,
    /// Ticks of the excitation, without gaps.
    pub ticks: usize,
    /// Greatest error that passes, ppm.
    pub bound_ppm: f64,
    /// All elements pass.
    #[serde(rename = "well")]
    pub pass: bool,
    /// One an element of the head, none of those that are never driven.
    #[serde(rename = "elements", serialize_with = "driven")]
    pub findings: Vec<Option<CurrentsFinding>>,
    /// The element that came near its highest temperature, if one did.
    #[serde(skip)]
    pub hot: Option<String>,
    /// The head that was written.
    #[serde(skip)]
    pub written: Option<PathBuf>,
}

fn driven<S: Serializer>(findings: &[Option<CurrentsFinding>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(findings.iter().flatten())
}

/// Heats the elements of a head for so many ticks, and reports on their currents. `each` gets the
/// ticks that are over; if it returns false, the test ends without a report.
///
/// # Errors
/// If the instrument refuses, trips or cannot be reached.
pub fn test_currents(
    head: &Head,
    instrument: &mut dyn InstrumentPort,
    ticks: u32,
    each: &mut dyn FnMut(u32) -> bool,
) -> Result<Option<CurrentsReport>, InstrumentError> {
    setup::start(instrument, &excitation(head))?;
    let mut record = CurrentsRecord::new(head.elements.len());
    let mut hot = None;
    for tick in 0..ticks {
        let sample = instrument.observe()?.sample;
        match sample.state {
            RunState::Tripped(trip) => {
                let element = setup::place(trip, &head.names());
                return Err(InstrumentError::Tripped { cause: trip.cause.name(), element });
            }
            RunState::Running => record.take(&sample),
            _ => return Err(InstrumentError::Stopped),
        }
        let mut readings = head.elements.iter().zip(&sample.temperature_c);
        hot = readings.find(|(of, read_c)| is_hot(of, **read_c)).map(|(of, _)| of.name.clone());
        if hot.is_some() {
            break;
        }
        if !each(tick + 1) {
            return Ok(None);
        }
    }
    instrument.command(Command::Stop)?;
    let elements = record.longest();
    let finding = |(of, ticks): (&HeadElement, &CurrentRatioTicks)| {
        let channel = &of.config.channel;
        let head_ratio = f64::from(channel.current_a(Level::High)) / f64::from(channel.current_a(Level::Low));
        of.may_be_driven().then(|| CurrentsFinding::new(&of.name, head_ratio, current_ratio(ticks, channel.platinum())))
    };
    let findings: Vec<_> = head.elements.iter().zip(&elements).map(finding).collect();
    Ok(Some(CurrentsReport {
        firmware: instrument.identity().firmware.to_string(),
        ticks: elements.first().map_or(0, |ticks| ticks.high.len()),
        hot,
        bound_ppm: BOUND_PPM,
        pass: findings.iter().flatten().all(|of| of.verdict == "pass"),
        findings,
        written: None,
    }))
}

/// Set-up of the excitation: the head, and random bits, which no two elements have alike for
/// years.
fn excitation(head: &Head) -> Vec<Command> {
    let mut commands =
        vec![Command::SamplePeriod { sample_period_s: PERIOD_S as f32 }, Command::Guard(head.guard_config(PERIOD_S))];
    for (i, of) in head.elements.iter().enumerate() {
        let element = i as u8;
        commands.push(Command::Element { element, config: of.config });
        // Multiples of the golden ratio begin far apart in a sequence of 2³² bits.
        let seed = 0x9E37_79B9_u32.wrapping_mul(i as u32 + 1);
        let bits = Drive::Prbs { order: 32, seed, ticks_per_bit: 1 };
        let drive = if of.may_be_driven() { bits } else { Drive::Passive };
        commands.push(Command::Drive { element, drive });
    }
    commands
}

fn is_hot(element: &HeadElement, read_c: f32) -> bool {
    element.may_be_driven() && f64::from(read_c) > f64::from(element.config.limits.temperature_max_c) - MARGIN_K
}

/// The stretch without gaps that is now, and the longest before it.
struct CurrentsRecord {
    now: Vec<CurrentRatioTicks>,
    before: Vec<CurrentRatioTicks>,
    last: Option<u32>,
}

impl CurrentsRecord {
    fn new(elements: usize) -> Self {
        let none = vec![CurrentRatioTicks::default(); elements];
        Self { now: none.clone(), before: none, last: None }
    }

    fn take(&mut self, sample: &TickSample) {
        let all = usize::MAX >> usize::BITS.saturating_sub(self.now.len() as u32);
        let is_next = self.last.is_none_or(|last| sample.tick == last + 1);
        if !is_next || sample.valid & all != all {
            let empty = vec![CurrentRatioTicks::default(); self.now.len()];
            let ended = std::mem::replace(&mut self.now, empty);
            if length(&ended) > length(&self.before) {
                self.before = ended;
            }
        }
        self.last = Some(sample.tick);
        if sample.valid & all != all {
            return;
        }
        let readings = sample.temperature_c.iter().zip(&sample.power_w);
        for (i, (ticks, (&celsius, &watt))) in self.now.iter_mut().zip(readings).enumerate() {
            let level = if sample.heaters.is_high(i) { Level::High } else { Level::Low };
            ticks.push(celsius.into(), watt.into(), level);
        }
    }

    fn longest(self) -> Vec<CurrentRatioTicks> {
        if length(&self.now) >= length(&self.before) { self.now } else { self.before }
    }
}

fn length(stretch: &[CurrentRatioTicks]) -> usize {
    stretch.first().map_or(0, |ticks| ticks.high.len())
}

impl CurrentsFinding {
    fn new(element: &str, head_ratio: f64, error: Result<CurrentRatioError, CurrentRatioUnknown>) -> Self {
        let found = error.ok();
        let known = found.filter(|found| COVERAGE * found.error_u_ppm <= BOUND_PPM);
        Self {
            element: element.to_owned(),
            verdict: match (found, known) {
                (None, _) => "unknown",
                (_, None) => "uncertain",
                (_, Some(found)) if found.error_ppm.abs() > BOUND_PPM => "off",
                _ => "pass",
            },
            head_ratio,
            error_ppm: found.map(|found| found.error_ppm),
            error_u_ppm: found.map(|found| found.error_u_ppm),
            why: error.err().map(|why| why.to_string()),
            known,
        }
    }
}

impl CurrentsReport {
    /// The errors by element of the head, of those that are known well enough.
    pub fn known(&self) -> Vec<Option<CurrentRatioError>> {
        self.findings.iter().map(|of| of.as_ref().and_then(|of| of.known)).collect()
    }

    /// The first element whose error is not known, and why, in one clause.
    pub fn unknown(&self) -> Option<String> {
        let of = self.findings.iter().flatten().find(|of| of.known.is_none())?;
        let why = of.why.as_deref().unwrap_or("its uncertainty is too great");
        let hot = self.hot.as_ref().map_or_else(String::new, |hot| {
            format!("; {hot} came within {MARGIN_K} K of its temperature_max_c and ended the test: cool the head")
        });
        Some(format!("the ratio of the currents of {} is not known: {why}{hot}", of.element))
    }

    /// Faults in one clause; nothing if the test has passed.
    pub fn faults(&self) -> Option<String> {
        let of = self.findings.iter().flatten();
        let wrong = of.clone().filter(|of| of.verdict != "pass").count();
        (wrong > 0).then(|| format!("faults in {wrong} of {} elements", of.count()))
    }
}

impl fmt::Display for CurrentsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let none = || "–".to_owned();
        let mut lines = vec![["element", "verdict", "high/low", "error", "±"].map(str::to_owned).to_vec()];
        for of in self.findings.iter().flatten() {
            let mut line = vec![of.element.clone(), of.verdict.to_owned()];
            line.extend(match (of.error_ppm, of.error_u_ppm) {
                (Some(error_ppm), Some(error_u_ppm)) => [
                    format!("{:.6}", of.head_ratio * (1.0 + 1e-6 * error_ppm)),
                    format!("{error_ppm:+.1} ppm"),
                    format!("{:.1} ppm", COVERAGE * error_u_ppm),
                ],
                _ => [none(), none(), none()],
            });
            lines.push(line);
        }
        write!(f, "{}: all elements heated at random for {}", self.firmware, count(self.ticks, "tick"))?;
        writeln!(f, " of {} ms\n\n{}", 1e3 * PERIOD_S, columns(&lines, &[2, 3, 4]))?;
        writeln!(
            f,
            "error: of the ratio of the true currents, from the head's; ±: k = {COVERAGE}; passes within {BOUND_PPM} ppm"
        )?;
        if let Some(path) = &self.written {
            writeln!(f, "{}: the head with these currents", path.display())?;
        }
        writeln!(f, "{}", self.faults().unwrap_or_else(|| "pass".to_owned()))
    }
}
