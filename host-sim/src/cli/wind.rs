//! `anemo wind`: the wind from a recording, as the board would have told it.

use std::path::PathBuf;

use dr_core::control::Doubts;
use serde_json::json;
use wire::WindSample;

use super::Failure;
use crate::answer::errors::{Errors, SLOWEST_M_S};
use crate::answer::off_line::{OffLine, axes};
use crate::answer::replay::{Moment, Replay, head_of};
use crate::answer::tally::Tally;
use crate::answer::winds;
use crate::head::{Answering, Calibration, Head};
use crate::plot;
use crate::recording::{Column, Metadata, Reader, Recording, RecordingError, Values, Words};
use crate::recording::{EVENT, GAS_TEMPERATURE, TIME, WIND, answer, write_columns};

/// Tell the wind from a recording of a calibrated head.
///
/// The board's own anemometer goes through the recording tick by tick, so that the answers have the bits that the board would have
/// given: convective powers beside the windless network, conductances, wind vector with standard errors, and what is to be doubted. The
/// bandwidth is free to choose: what is slow is smooth. Where the true wind is known (simulated tunnels, or --winds), the errors are told.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo wind gusts.parquet --head sphere-b-calibrated.toml -o wind.csv --plot wind.svg
  anemo wind tunnel.parquet --bandwidth 0.5 --every 1 --json
  anemo wind day.parquet --head head.toml --gas-temperature temperature_c:boom --pressure 820

Doubts: failed, refused, degraded, ambiguous, undetermined, no-direction, extrapolated, uncalibrated, no-gas, not-running, saturated,
starting, cold; in the table they are the sum of 1, 2, 4, 8 … 4096 in this order.")]
pub struct Arguments {
    /// The recording: a .parquet or .csv file.
    recording: PathBuf,
    /// The calibrated head (`anemo calibrate`); by default the one that the recording carries.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Bandwidth of the convective powers, 0.5 to 50 Hz.
    #[arg(long, value_name = "HZ", default_value_t = Answering::DEFAULT_BANDWIDTH_HZ)]
    bandwidth: f64,
    /// Keep the bandwidth when the wind jumps, instead of raising it for a while.
    #[arg(long)]
    fixed: bool,
    /// An answer every so many seconds; by default 0.01 or a tick.
    #[arg(long, value_name = "SECONDS")]
    every: Option<f64>,
    /// Temperature of the gas: a number in °C, or a column; by default that of the head's reference, or the recording's.
    #[arg(long, value_name = "°C|COLUMN", allow_hyphen_values = true)]
    gas_temperature: Option<String>,
    /// Pressure of the gas, Pa; by default the recording's.
    #[arg(long, value_name = "PA")]
    pressure: Option<f64>,
    /// True winds by the label of the conditions, a .csv or .parquet file, for the errors.
    #[arg(long, value_name = "FILE")]
    winds: Option<PathBuf>,
    /// Answers before this time are left out of the errors, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    from: f64,
    /// Of every stretch of one label, so many seconds are left out of the errors.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    settle: f64,
    /// Write the answers to this file; its name ends in .parquet or .csv.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw them into this .svg file.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

/// What is kept of all answers.
struct Told {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    /// Labels of the conditions and true temperature of the gas, for the picture.
    events: Words,
    gas_c: Vec<f64>,
    errors: Errors,
    tally: Tally,
    speed_error: (f64, u64),
    direction_error_deg: (f64, u64),
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    super::finite(&[
        ("--pressure", arguments.pressure),
        ("--from", Some(arguments.from)),
        ("--settle", Some(arguments.settle)),
    ])
    .map_err(Failure::usage)?;
    if !Answering::BANDWIDTHS_HZ.contains(&arguments.bandwidth) {
        return Err(Failure::usage(format!("--bandwidth {} must lie between 0.5 and 50 Hz", arguments.bandwidth)));
    }
    super::keep(&[&arguments.recording], &[arguments.output.as_deref(), arguments.plot.as_deref()])?;
    if let Some(path) = &arguments.output {
        crate::recording::check_name(path).map_err(Failure::usage)?;
    }
    let head = head_of(&arguments.recording, arguments.head.as_deref()).map_err(Failure::usage)?;
    let Some(calibration) = &head.calibration else {
        return Err(Failure::usage(format!(
            "head `{}` has no calibration, and so no wind: make one with `anemo calibrate` and name it with --head",
            head.name
        )));
    };
    let column = arguments.gas_temperature.as_deref().filter(|word| word.parse::<f64>().is_err());
    let mut replay = Replay::open(&arguments.recording, &head, column).map_err(Failure::usage)?;
    let table = arguments.winds.as_deref().map(winds::read).transpose().map_err(Failure::usage)?;
    let answering =
        Answering::new(Some(arguments.bandwidth), arguments.every, arguments.fixed, replay.sample_period_s());
    let mut anemometer =
        OffLine::new(&head, calibration, &answering, replay.sample_period_s()).map_err(Failure::usage)?;
    let mut gas = GasTold::new(arguments, calibration, &replay)?;

    let parts: Vec<String> = calibration.parts.iter().map(|&place| head.elements[place].name.clone()).collect();
    let axes = axes(&head, calibration);
    let mut told = Told::new(&parts, calibration.card_normal());
    let mut label = (String::new(), f64::NEG_INFINITY);
    while let Some(moment) = replay.next_moment().map_err(Failure::work)? {
        if label.0 != moment.event || label.1 == f64::NEG_INFINITY {
            label = (moment.event.clone(), moment.time_s);
        }
        gas.tell(&mut anemometer, &moment)?;
        let Some(answer) = anemometer.step(&moment.tick) else { continue };
        let truth = match &table {
            Some(winds) => winds.get(&moment.event).copied(),
            None => moment.wind_m_s,
        };
        let counts = moment.time_s >= arguments.from && moment.time_s - label.1 >= arguments.settle;
        told.take(&moment, &answer, truth, counts.then_some(&axes[..]));
    }
    finish(arguments, &head, calibration, &answering, told, anemometer.not_quick())
}

/// What the anemometer is told of the gas.
struct GasTold {
    pressure_pa: f32,
    /// Held for the whole recording, if it is.
    temperature_c: Option<f32>,
    /// Whether a column tells it, tick by tick.
    by_column: bool,
    last: Option<f32>,
    begun: bool,
}

impl GasTold {
    fn new(arguments: &Arguments, calibration: &Calibration, replay: &Replay) -> Result<Self, Failure> {
        let conditions = replay.conditions();
        let pressure_pa = arguments.pressure.or(conditions.map(|of| of.pressure_pa)).ok_or_else(|| {
            Failure::usage("the recording does not tell the pressure of its gas: give --pressure, in Pa")
        })?;
        let number = arguments.gas_temperature.as_deref().and_then(|word| word.parse::<f64>().ok());
        let by_column = arguments.gas_temperature.is_some() && number.is_none();
        if arguments.gas_temperature.is_some() && calibration.reference.is_some() {
            return Err(Failure::usage(
                "--gas-temperature is given, but this head measures the gas by its reference: leave one of them out",
            ));
        }
        let measured = calibration.reference.is_some() || by_column;
        let known_c = number.or(conditions.filter(|_| !measured).map(|of| of.gas_temperature_c));
        if known_c.is_none() && !measured {
            return Err(Failure::usage(
                "nothing tells the temperature of the gas: give --gas-temperature, a number in °C or a column",
            ));
        }
        let temperature_c = known_c.map(|celsius| celsius as f32);
        Ok(Self { pressure_pa: pressure_pa as f32, temperature_c, by_column, last: None, begun: false })
    }

    fn tell(&mut self, anemometer: &mut OffLine<'_>, moment: &Moment) -> Result<(), Failure> {
        let now = if self.by_column { moment.gas_c.map(|celsius| celsius as f32) } else { self.temperature_c };
        if self.begun && now == self.last {
            return Ok(());
        }
        (self.begun, self.last) = (true, now);
        anemometer.gas(self.pressure_pa, now).map_err(|error| Failure::usage(format!("gas: {error}")))
    }
}

impl Told {
    fn new(parts: &[String], card_normal: Option<[f64; 3]>) -> Self {
        let mut names = vec![TIME.to_owned()];
        names.extend(answer::columns(parts));
        names.extend(WIND.map(str::to_owned));
        Self {
            columns: vec![Vec::new(); names.len()],
            names,
            events: Words::default(),
            gas_c: Vec::new(),
            errors: Errors::in_plane(card_normal),
            tally: Tally::default(),
            speed_error: (0.0, 0),
            direction_error_deg: (0.0, 0),
        }
    }

    fn take(&mut self, moment: &Moment, answer: &WindSample, truth: Option<[f64; 3]>, axes: Option<&[[f64; 3]]>) {
        let parts = answer.conductance_w_k.len();
        let numbers = answer::numbers(Some(answer), parts).into_iter().map(f64::from);
        let row = std::iter::once(moment.time_s).chain(numbers).chain(truth.unwrap_or([f64::NAN; 3]));
        for (column, number) in self.columns.iter_mut().zip(row) {
            column.push(number);
        }
        self.events.push(&moment.event);
        self.gas_c.push(moment.gas_c.unwrap_or(f64::NAN));
        self.tally.add(answer);
        if !answer.doubts.has(Doubts::FAILED) && f64::from(answer.speed_m_s) >= SLOWEST_M_S {
            self.speed_error.0 += f64::from(answer.speed_error_m_s / answer.speed_m_s).powi(2);
            self.speed_error.1 += 1;
            if !answer.doubts.has(Doubts::NO_DIRECTION) {
                self.direction_error_deg.0 += f64::from(answer.direction_error_rad.to_degrees()).powi(2);
                self.direction_error_deg.1 += 1;
            }
        }
        if let (Some(axes), Some(truth)) = (axes, truth) {
            self.errors.add(answer, axes, truth);
        }
    }
}

fn rms((squares, count): (f64, u64)) -> Option<f64> {
    (count > 0).then(|| (squares / count as f64).sqrt())
}

fn finish(
    arguments: &Arguments,
    head: &Head,
    calibration: &Calibration,
    answering: &Answering,
    mut told: Told,
    not_quick: &[String],
) -> Result<(), Failure> {
    let has_truth = told.columns.last().is_some_and(|column| column.iter().any(|number| number.is_finite()));
    let kept = if has_truth { told.names.len() } else { told.names.len() - WIND.len() };
    let metadata = metadata(arguments, head, answering).map_err(Failure::work)?;
    if let Some(path) = &arguments.output {
        let columns: Vec<(&str, &[f64])> = told
            .names
            .iter()
            .zip(&told.columns)
            .take(kept)
            .skip(1)
            .map(|(name, values)| (name.as_str(), &values[..]))
            .collect();
        write_columns(path, answering.every_s, &columns, &metadata).map_err(Failure::work)?;
    }
    if let Some(path) = &arguments.plot {
        let canvas = plot::Canvas::create(path).map_err(Failure::usage)?;
        canvas.draw(&recording(&mut told, kept, metadata)).map_err(Failure::work)?;
    }
    let errors = &told.errors;
    let tally = told.tally.summary();
    if arguments.json {
        return super::print_json(&json!({
            "head": head.name,
            "answers": tally.answers,
            "bandwidth_hz": answering.bandwidth_hz,
            "every_s": answering.every_s,
            "doubts": tally.doubts,
            "mean_speed_m_s": tally.mean_speed_m_s,
            "speed_error_m_s": tally.speed_error_m_s,
            "speed_standard_error": rms(told.speed_error),
            "direction_standard_error_deg": rms(told.direction_error_deg),
            "compared": errors.count,
            "failed": errors.failed,
            "without_direction": errors.no_direction,
            "speed_rms_error": errors.speed_rms(),
            "speed_bias": errors.speed_bias(),
            "speed_worst_error": errors.speed_worst(),
            "direction_rms_error_deg": errors.direction_rms_deg(),
            "direction_worst_error_deg": errors.direction_worst_deg(),
            "linear_direction_rms_error_deg": errors.linear_rms_deg(),
        }));
    }
    let mut text = format!(
        "{} · head {} · {}\n{} answers, one each {} s, bandwidth {} Hz\n",
        arguments.recording.display(),
        head.name,
        calibration.made_from(),
        tally.answers,
        answering.every_s,
        answering.bandwidth_hz
    );
    for sentence in not_quick {
        text += &format!("bandwidth fixed for {sentence}\n");
    }
    if let Some(error) = rms(told.speed_error) {
        text += &format!("standard error by the noise of the readings: speed {:.2} %", 100.0 * error);
        if let Some(error_deg) = rms(told.direction_error_deg) {
            text += &format!(", direction {error_deg:.2}°");
        }
        text += "\n";
    }
    if tally.doubts.is_empty() {
        text += "no doubts\n";
    }
    for (name, count) in &tally.doubts {
        text += &format!("{name:<13} {count} answers, {:.1} %\n", 100.0 * *count as f64 / tally.answers.max(1) as f64);
    }
    if errors.count > 0 {
        text += &format!("\nbeside the true wind, {} answers", errors.count);
        if errors.failed > 0 {
            text += &format!(", {} of them without a wind", errors.failed);
        }
        text += "\n";
        let percent = |of: Option<f64>| of.map_or("-".to_owned(), |of| format!("{:.2} %", 100.0 * of));
        let degrees = |of: Option<f64>| of.map_or("-".to_owned(), |of| format!("{of:.2}°"));
        text += &format!(
            "  speed      {} rms, {} mean, {} at worst\n",
            percent(errors.speed_rms()),
            percent(errors.speed_bias()),
            percent(Some(errors.speed_worst()))
        );
        text += &format!(
            "  direction  {} rms, {} at worst",
            degrees(errors.direction_rms_deg()),
            degrees(Some(errors.direction_worst_deg()))
        );
        text += &match calibration.card_normal() {
            Some(_) => ", in the plane of the card\n".to_owned(),
            None => format!("; linear inverse {} rms\n", degrees(errors.linear_rms_deg())),
        };
    }
    for path in [&arguments.output, &arguments.plot].into_iter().flatten() {
        text += &format!("\nwritten to {}\n", path.display());
    }
    super::print(&text)
}

/// Where the answers come from.
fn metadata(arguments: &Arguments, head: &Head, answering: &Answering) -> Result<Metadata, RecordingError> {
    let recording = arguments.recording.display().to_string();
    let known = Reader::open(&arguments.recording)?.metadata();
    let title = known.into_iter().find(|(key, _)| key == "title").map_or_else(|| recording.clone(), |(_, title)| title);
    let pairs = [
        ("title", title),
        ("head_name", head.name.clone()),
        ("head", head.source.text.clone()),
        ("bandwidth_hz", answering.bandwidth_hz.to_string()),
        ("recording", recording),
    ];
    Ok(pairs.map(|(key, value)| (key.to_owned(), value)).into())
}

/// The answers as a recording, to be drawn; it takes them.
fn recording(told: &mut Told, kept: usize, metadata: Metadata) -> Recording {
    let numbers = |(name, values): (&String, Vec<f64>)| Column { name: name.clone(), values: Values::Numbers(values) };
    let mut columns: Vec<Column> =
        told.names.iter().zip(std::mem::take(&mut told.columns)).take(kept).map(numbers).collect();
    columns.push(numbers((&GAS_TEMPERATURE.to_owned(), std::mem::take(&mut told.gas_c))));
    columns.push(Column { name: EVENT.to_owned(), values: Values::Words(std::mem::take(&mut told.events)) });
    Recording { path: "these answers".into(), metadata, columns }
}
