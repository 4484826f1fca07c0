//! `anemo wind`: the wind from a recording, as the board would have told it.

mod gas;
mod told;

use std::path::PathBuf;

use dr_core::control::Doubts;

use super::Failure;
use crate::answer::errors::Errors;
use crate::answer::moment::{Known, Moment};
use crate::answer::off_line::{OffLine, axes};
use crate::answer::replay::{Replay, head_of};
use crate::answer::tally::Tally;
use crate::answer::winds;
use crate::head::{Answering, Head};
use crate::plot;
use crate::recording::{
    Collector, Layout, Metadata, Reader, RecordingError, RecordingWriter, Row, answer, check_name, tidy,
};
use gas::GasTold;
use told::{Made, Told};

/// Tell the wind from a recording of a calibrated head.
///
/// The board's own anemometer goes through the recording tick by tick, so that the answers have the bits that the board would have
/// given: convective powers beside the windless network, conductances, wind vector with standard errors, and what is to be doubted. The
/// bandwidth is free to choose: what is slow is smooth. Where the true wind is known (simulated tunnels, or --winds), the errors are told.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo wind gusts.parquet --head head.toml -o wind.csv --plot wind.svg
  anemo wind tunnel.parquet --bandwidth 0.5 --every 1 --json
  anemo wind day.parquet --head head.toml \\
      --gas-temperature temperature_c:boom --pressure 820

Doubts: failed, refused, degraded, ambiguous, undetermined, no-direction, extrapolated, \
uncalibrated, no-gas, not-running, saturated, starting, cold; in the table they are the sum \
of 1, 2, 4, 8 … 4096 in this order.")]
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
    /// An answer every so many seconds, a whole number of ticks; by default 0.01 or a tick.
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
    /// Answers before this time do not count in the summary, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    from: f64,
    /// Of every stretch of one label, so many seconds do not count in the summary.
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

/// Part of a tick by which `--every` may be off.
const WHOLE: f64 = 1e-3;

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    check(arguments)?;
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
    let answering = answering(arguments, replay.sample_period_s())?;
    let mut anemometer =
        OffLine::new(&head, calibration, &answering, replay.sample_period_s()).map_err(Failure::usage)?;
    let mut gas = GasTold::new(arguments, &head, calibration, &replay)?;

    let parts: Vec<String> = calibration.parts.iter().map(|&place| head.elements[place].name.clone()).collect();
    let layout = Layout {
        elements: Vec::new(),
        wind: table.is_some() || replay.has_wind(),
        gas: replay.has_gas(),
        observed: Vec::new(),
        answers: parts,
    };
    let mut kept = Kept::create(arguments, layout, &metadata(arguments, &head, &answering, &gas)?)?;
    let axes = axes(&head, calibration);
    let mut told = Told {
        answers: 0,
        tally: Tally::default(),
        errors: Errors::in_plane(calibration.card_normal()),
        has_truth: false,
        gaps: (0, 0.0),
    };
    let mut label = (String::new(), f64::NEG_INFINITY);
    while let Some(moment) = replay.next_moment().map_err(Failure::work)? {
        if label.0 != moment.event || label.1 == f64::NEG_INFINITY {
            label = (moment.event.clone(), moment.time_s);
        }
        gas.tell(&mut anemometer, &moment)?;
        let Some(mut answer) = anemometer.step(&moment.tick) else { continue };
        match moment.known {
            Known::Recorded => {}
            Known::AfterGap => answer.doubts = answer.doubts.with(Doubts::STARTING, true),
            Known::Missing => continue,
        }
        let truth = match &table {
            Some(winds) => winds.of(&moment.event),
            None => moment.wind_m_s.filter(|wind| wind.iter().all(|of| of.is_finite())),
        };
        told.answers += 1;
        told.has_truth |= truth.is_some();
        if moment.time_s >= arguments.from && moment.time_s - label.1 >= arguments.settle {
            told.tally.add(&answer);
            if let Some(truth) = truth {
                told.errors.add(&answer, &axes, truth);
            }
        }
        let numbers = answer::numbers(Some(&answer), answer.conductance_w_k.len());
        kept.push(&moment, truth, &numbers).map_err(Failure::work)?;
    }
    told.gaps = replay.gaps();
    kept.finish()?;
    let not_quick = anemometer.not_quick();
    let made = Made { arguments, head: &head, calibration, answering: &answering, gas: &gas, not_quick };
    if arguments.json {
        return super::print_json(&told.json(&made));
    }
    super::print(&told.text(&made))
}

/// What the options alone say.
fn check(arguments: &Arguments) -> Result<(), Failure> {
    super::finite(&[
        ("--pressure", arguments.pressure),
        ("--from", Some(arguments.from)),
        ("--settle", Some(arguments.settle)),
    ])
    .map_err(Failure::usage)?;
    if !Answering::BANDWIDTHS_HZ.contains(&arguments.bandwidth) {
        return Err(Failure::usage(format!("--bandwidth {} must lie between 0.5 and 50 Hz", arguments.bandwidth)));
    }
    let read = [Some(&arguments.recording), arguments.head.as_ref(), arguments.winds.as_ref()];
    let read: Vec<_> = read.into_iter().flatten().map(PathBuf::as_path).collect();
    super::keep(&read, &[arguments.output.as_deref(), arguments.plot.as_deref()])?;
    arguments.output.as_deref().map_or(Ok(()), check_name).map_err(Failure::usage)
}

/// How it shall answer: every so many whole ticks.
fn answering(arguments: &Arguments, period_s: f64) -> Result<Answering, Failure> {
    let mut answering = Answering::new(Some(arguments.bandwidth), arguments.every, arguments.fixed, period_s);
    let ticks = answering.every_s / period_s;
    if let Some(every_s) = arguments.every
        && !(ticks.is_finite() && ticks > 0.5 && (ticks - ticks.round()).abs() < WHOLE)
    {
        let (below, above) = (ticks.floor().max(1.0) * period_s, (ticks.floor() + 1.0).max(1.0) * period_s);
        let right = match every_s > period_s {
            true => format!("{} s or {} s", tidy(below), tidy(above)),
            false => format!("{} s", tidy(period_s)),
        };
        return Err(Failure::usage(format!(
            "--every {every_s} is not a whole number of sample periods of {} s: {right} would be",
            tidy(period_s)
        )));
    }
    // Twelve digits of a product, so that 3 × 0.01 is 0.03.
    let every_s = ticks.round().max(1.0) * period_s;
    answering.every_s = format!("{every_s:.11e}").parse().unwrap_or(every_s);
    Ok(answering)
}

/// The answers' file and picture, as far as they are wanted.
struct Kept {
    writer: Option<RecordingWriter>,
    picture: Option<(plot::Canvas, Collector)>,
}

impl Kept {
    /// All that could be wrong with the outputs shows before anything is computed.
    fn create(arguments: &Arguments, layout: Layout, metadata: &Metadata) -> Result<Self, Failure> {
        let writer = arguments.output.as_deref().map(|path| RecordingWriter::create(path, layout.clone(), metadata));
        let writer = writer.transpose().map_err(Failure::usage)?;
        let canvas = arguments.plot.as_deref().map(plot::Canvas::create).transpose().map_err(Failure::usage)?;
        Ok(Self { writer, picture: canvas.map(|canvas| (canvas, Collector::new(layout, metadata))) })
    }

    fn push(&mut self, moment: &Moment, truth: Option<[f64; 3]>, answer: &[f32]) -> Result<(), RecordingError> {
        let row = |layout: &Layout| Row {
            time_s: moment.time_s,
            temperature_c: &[],
            power_w: &[],
            equivalent_power_w: &[],
            heaters: 0,
            event: &moment.event,
            state: &moment.state,
            wind_m_s: layout.wind.then(|| truth.unwrap_or([f64::NAN; 3])),
            gas_temperature_c: layout.gas.then(|| moment.gas_c.unwrap_or(f64::NAN)),
            answer,
        };
        if let Some(writer) = &mut self.writer {
            writer.push(&row(writer.layout()))?;
        }
        if let Some((_, collector)) = &mut self.picture {
            collector.push(&row(collector.layout()))?;
        }
        Ok(())
    }

    fn finish(self) -> Result<(), Failure> {
        let nothing_more = Metadata::new();
        if let Some(writer) = self.writer {
            writer.finish(&nothing_more).map_err(Failure::work)?;
        }
        if let Some((canvas, collector)) = self.picture {
            canvas.draw(&collector.finish(&nothing_more)).map_err(Failure::work)?;
        }
        Ok(())
    }
}

/// Where the answers come from.
fn metadata(arguments: &Arguments, head: &Head, answering: &Answering, gas: &GasTold) -> Result<Metadata, Failure> {
    let recording = arguments.recording.display().to_string();
    let known = Reader::open(&arguments.recording).map_err(Failure::usage)?.metadata();
    let title = known.into_iter().find(|(key, _)| key == "title").map_or_else(|| recording.clone(), |(_, title)| title);
    let pairs = [
        ("title", title),
        ("head_name", head.name.clone()),
        ("head", head.source.text.clone()),
        ("bandwidth_hz", answering.bandwidth_hz.to_string()),
        ("fixed", answering.fixed.to_string()),
        ("every_s", answering.every_s.to_string()),
        ("recording", recording),
        ("software", format!("anemo {}", env!("CARGO_PKG_VERSION"))),
    ];
    let known = pairs.into_iter().map(|(key, value)| (key.to_owned(), value));
    Ok(known.chain(gas.metadata()).collect())
}
