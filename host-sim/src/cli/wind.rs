//! `anemo wind`: the wind from a recording, as the board would have told it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use dr_core::control::{Anemometer, Doubts, WindCommand};
use serde_json::json;
use wire::{MOST_ELEMENTS, WindSample};

use super::Failure;
use crate::answer::errors::Errors;
use crate::answer::replay::{Moment, Replay, head_of};
use crate::answer::winds;
use crate::head::{Answering, Calibration, Head};
use crate::plot;
use crate::recording::{Column, Metadata, Recording, Values};
use crate::recording::{TIME, WIND, answer, write_columns};

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
    errors: Errors,
    answers: u64,
    doubts: BTreeMap<&'static str, u64>,
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
    let answering = Answering::new(Some(arguments.bandwidth), arguments.every, replay.sample_period_s());
    let mut anemometer = set_up(calibration, &answering, replay.sample_period_s()).map_err(Failure::usage)?;
    let mut gas = GasTold::new(arguments, calibration, &replay)?;

    let parts: Vec<String> = calibration.parts.iter().map(|&place| head.elements[place].name.clone()).collect();
    let axes = axes(&head, calibration);
    let mut told = Told::new(&parts, calibration.card_normal());
    let mut label = (String::new(), f64::NEG_INFINITY);
    while let Some(moment) = replay.next().map_err(Failure::work)? {
        if label.0 != moment.event || label.1 == f64::NEG_INFINITY {
            label = (moment.event.clone(), moment.time_s);
        }
        gas.tell(&mut anemometer, &moment, replay.sample_period_s())?;
        let Some(answer) = anemometer.step(&moment.tick, |i, celsius| standing_w(&head, i, celsius)) else { continue };
        let answer = WindSample::from(&answer);
        let truth = match &table {
            Some(winds) => winds.get(&moment.event).copied(),
            None => moment.wind_m_s,
        };
        let counts = moment.time_s >= arguments.from && moment.time_s - label.1 >= arguments.settle;
        told.take(&moment, &answer, truth, counts.then_some(&axes[..]));
    }
    finish(arguments, &head, calibration, &answering, &told)
}

/// An anemometer that knows its head.
fn set_up(
    calibration: &Calibration,
    answering: &Answering,
    sample_period_s: f64,
) -> Result<Anemometer<MOST_ELEMENTS>, String> {
    let (commands, _) = calibration.commands(answering, sample_period_s)?;
    let mut anemometer = Anemometer::new();
    for command in &commands {
        let told = anemometer.handle(command, sample_period_s as f32);
        told.map_err(|error| format!("the head's calibration is refused: {error}"))?;
    }
    Ok(anemometer)
}

/// Power of an element at its low level, W.
fn standing_w(head: &Head, element: usize, temperature_c: f32) -> f32 {
    head.elements.get(element).map_or(0.0, |of| of.config.channel.standing_power_w(temperature_c))
}

/// Outward axes of the parts, for the linear inverse.
fn axes(head: &Head, calibration: &Calibration) -> Vec<[f64; 3]> {
    calibration.parts.iter().filter_map(|&place| head.elements[place].normal).collect()
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

    fn tell(
        &mut self,
        anemometer: &mut Anemometer<MOST_ELEMENTS>,
        moment: &Moment,
        sample_period_s: f64,
    ) -> Result<(), Failure> {
        let now = if self.by_column { moment.gas_c.map(|celsius| celsius as f32) } else { self.temperature_c };
        if self.begun && now == self.last {
            return Ok(());
        }
        (self.begun, self.last) = (true, now);
        let command = WindCommand::Gas { pressure_pa: self.pressure_pa, temperature_c: now };
        anemometer.handle(&command, sample_period_s as f32).map_err(|error| Failure::usage(format!("gas: {error}")))
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
            errors: Errors::in_plane(card_normal),
            answers: 0,
            doubts: BTreeMap::new(),
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
        self.answers += 1;
        for (doubt, name) in Doubts::NAMES {
            if answer.doubts.has(doubt) {
                *self.doubts.entry(name).or_default() += 1;
            }
        }
        // Of a speed that is not known from nothing, a relative error says nothing.
        if !answer.doubts.has(Doubts::FAILED) && answer.speed_m_s > answer.speed_error_m_s {
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
    told: &Told,
) -> Result<(), Failure> {
    let has_truth = told.columns.last().is_some_and(|column| column.iter().any(|number| number.is_finite()));
    let kept = if has_truth { told.names.len() } else { told.names.len() - WIND.len() };
    if let Some(path) = &arguments.output {
        let columns: Vec<(&str, &[f64])> = told
            .names
            .iter()
            .zip(&told.columns)
            .take(kept)
            .skip(1)
            .map(|(name, values)| (name.as_str(), &values[..]))
            .collect();
        let metadata = vec![
            ("head".to_owned(), head.source.text.clone()),
            ("bandwidth_hz".to_owned(), answering.bandwidth_hz.to_string()),
            ("recording".to_owned(), arguments.recording.display().to_string()),
        ];
        write_columns(path, answering.every_s, &columns, &metadata).map_err(Failure::work)?;
    }
    if let Some(path) = &arguments.plot {
        let canvas = plot::Canvas::create(path).map_err(Failure::usage)?;
        canvas.draw(&recording(told, kept)).map_err(Failure::work)?;
    }
    let errors = &told.errors;
    if arguments.json {
        return super::print_json(&json!({
            "head": head.name,
            "answers": told.answers,
            "bandwidth_hz": answering.bandwidth_hz,
            "every_s": answering.every_s,
            "doubts": told.doubts,
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
        told.answers,
        answering.every_s,
        answering.bandwidth_hz
    );
    if let Some(error) = rms(told.speed_error) {
        text += &format!("standard error by the noise of the readings: speed {:.2} %", 100.0 * error);
        if let Some(error_deg) = rms(told.direction_error_deg) {
            text += &format!(", direction {error_deg:.2}°");
        }
        text += "\n";
    }
    if told.doubts.is_empty() {
        text += "no doubts\n";
    }
    for (name, count) in &told.doubts {
        text += &format!("{name:<13} {count} answers, {:.1} %\n", 100.0 * *count as f64 / told.answers.max(1) as f64);
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

/// The answers as a recording, to be drawn.
fn recording(told: &Told, kept: usize) -> Recording {
    let columns = told.names.iter().zip(&told.columns).take(kept);
    let column =
        |(name, values): (&String, &Vec<f64>)| Column { name: name.clone(), values: Values::Numbers(values.clone()) };
    Recording { path: "these answers".into(), metadata: Metadata::new(), columns: columns.map(column).collect() }
}
