//! `anemo log`: an instrument, until it is stopped.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use crate::feeding;
use crate::instrument::{InstrumentArguments, On};
use crate::log_files::{ENDED, LogStatus, MarkReader};
use crate::log_host::{Host, PressureFile};
use crate::log_source::SourceArguments;
use crate::output::{Failure, complain};
use crate::progress::{LiveTable, on_interrupt};
use crate::publishing::PublishArguments;
use crate::record::SessionEnd;
use host_sim::experiment::Experiment;
use host_sim::run::log::{LogOptions, LogSummary, log};
use publish::commands::channel;
use publish::feed::{Feed, FeedEvent, FeedEventKind, FeedItem};
use recording::{Metadata, Recorder, SegmentLength, WriterOptions, utc};

/// Log an instrument until it is stopped by Ctrl-C or SIGTERM.
///
/// The recording is a folder of closed segments, which a later log continues. A lost link, a board
/// that starts anew, a trip and a full disk do not end it: the rows show the gap, the column
/// `event` says what happened. After a reset or a trip it only records, until a person starts the
/// heaters.
///
/// Exit codes: 0 stopped, 1 failed, 2 wrong usage, 3 stopped and had tripped, 4 ended early.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo log experiments/gusts.toml --on sim --fast --for 5s -o try/
  anemo log experiments/gusts.toml --on serial:/dev/ttyACM0 -o mast/ \\
      --segment 1h --keep 30d --every 1s
  anemo log heads/sphere-a-reference.toml --overheat 30 --pressure gas.txt \\
      --on serial:/dev/ttyACM0 -o mast/
  anemo log heads/sphere-a-reference.toml --overheat 30 --pressure 700 \\
      --overheat-alternation 20 --on serial:/dev/ttyACM0 -o mast/
  anemo log experiments/gusts.toml --on serial:/dev/ttyACM0 -o mast/ --service")]
pub struct Arguments {
    #[command(flatten)]
    source: SourceArguments,
    #[command(flatten)]
    instrument: InstrumentArguments,
    /// The folder of the recording: new, or of a log that is continued.
    #[arg(short, long = "output-file", value_name = "FOLDER")]
    output: PathBuf,
    /// Length of a segment: a time, or a size (64MB).
    #[arg(long, value_name = "LENGTH", default_value = "10min")]
    segment: SegmentLength,
    /// Remove segments whose rows are older than this (30d).
    #[arg(long, value_name = "TIME")]
    keep: Option<SegmentLength>,
    /// Record mean, least and greatest of so long (1s) beside, in the folder every-1s.
    #[arg(long, value_name = "TIME")]
    every: Option<SegmentLength>,
    /// Heat on while the disk is full.
    #[arg(long)]
    keep_heating: bool,
    /// At a trip: `stop` ends the log, anything else is run by the shell, with ANEMO_TRIP_CAUSE and
    /// ANEMO_TRIP_ELEMENT in its environment.
    #[arg(long, value_name = "stop|COMMAND")]
    on_trip: Option<String>,
    /// Acknowledge trips, at most two in ten minutes, and never open, short or over-temperature.
    /// Heaters stay low.
    #[arg(long)]
    auto_acknowledge: bool,
    /// Simulate as fast as possible instead of in real time.
    #[arg(long)]
    fast: bool,
    /// Stop after so long.
    #[arg(long = "for", value_name = "TIME")]
    for_time: Option<SegmentLength>,
    #[command(flatten)]
    publish: PublishArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
    /// Print the systemd unit that runs this log as a service, and do nothing else.
    #[arg(long)]
    service: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let on = &arguments.instrument.on;
    let device = if let On::Serial(device) = on { Some(device.clone()) } else { None };
    let mut experiment = arguments.source.experiment(arguments.instrument.on.board())?;
    let options = WriterOptions {
        has_journal: true,
        segment: arguments.segment,
        has_utc: true,
        appends: true,
        keep_s: seconds("--keep", arguments.keep)?,
        every_s: seconds("--every", arguments.every)?.map(milliseconds).transpose()?,
        outlasts_full_disk: true,
    };
    let for_s = seconds("--for", arguments.for_time)?;
    let folder = &arguments.output;
    if folder.extension().is_some() && !folder.is_dir() {
        return Err(Failure::in_file(folder, "a log is recorded into a folder, whose name has no extension"));
    }
    let targets = arguments.publish.targets()?;
    if let Some(target) = targets.iter().find(|target| target.is_wind_only() && experiment.surfaces().is_empty()) {
        let (target, head) = (&target.name, &experiment.head.name);
        return Err(Failure::usage(format!(
            "{target}: head `{head}` has no calibration, so that there is no wind to send: calibrate it by `anemo calibrate`, or leave this address out"
        )));
    }
    if arguments.service {
        return crate::output::print(&crate::log_files::unit(&experiment.title)?);
    }
    crate::output::note_corrections(&experiment.head);
    arguments.publish.mount(&mut experiment.head)?;
    let layout = crate::run::layout_on(&experiment, on);
    let mut known = host_sim::run::metadata(&experiment, &layout, &crate::run::instrument_name(on));
    let Begin { begin_s, begin, continued } = begin(folder, &experiment, &mut known)?;
    let interrupted = on_interrupt();
    let first = arguments.instrument.open(Some(arguments.source.path()), || Ok(experiment.sensor()?))?;
    let recorder = Recorder::create(folder, layout, &known, &options).map_err(Failure::usage)?;
    let feed = Feed::new(feeding::layout(&experiment, first.identity()));
    let (commands, requests) = channel();
    let published = arguments.publish.start(&targets, &feed, &commands)?;
    let pressure = arguments.source.pressure.clone().map(|source| PressureFile {
        source,
        last_pa: experiment.pressure_pa,
        modified: None,
    });
    let status = LogStatus {
        title: experiment.title.clone(),
        head: experiment.head.name.clone(),
        instrument: crate::run::instrument_name(on),
        firmware: first.identity().firmware.to_string(),
        segment: recorder.segment(),
        is_running: true,
        ..LogStatus::default()
    };
    let mut host = Host {
        first: Some(first),
        is_paced: device.is_none() && !arguments.fast,
        device,
        recorder,
        folder: folder.clone(),
        begin_s,
        begin,
        began: None,
        // The time of the last row, about.
        until_s: for_s.map(|for_s| begin_s + for_s - 1.5 * experiment.sample_period_s),
        mounting: feed.layout().mounting,
        keeps_heating: arguments.keep_heating,
        on_trip: arguments.on_trip.clone().filter(|what| what != "stop"),
        interrupted,
        table: LiveTable::new(&experiment.title, feed.layout().elements.clone(), None, feed.layout().mounting),
        feed,
        requests,
        own_requests: VecDeque::new(),
        marks: MarkReader::new(folder),
        pressure,
        looked: Instant::now(),
        status,
        status_written: Instant::now(),
        children: Vec::new(),
    };
    let options = LogOptions {
        begin_s,
        ends_at_trip: arguments.on_trip.as_deref() == Some("stop"),
        acknowledges: arguments.auto_acknowledge,
        overheat_k: arguments.source.overheat,
        continued,
    };
    let summary = log(&experiment, &options, &mut host)?;
    end(host, &summary)?;
    published.end();
    // That the instrument tripped is more than that nobody reads of it.
    verdict(&summary).and(crate::output::print_report(&summary, arguments.json))
}

/// Closes the recording, and tells listeners.
fn end(mut host: Host, summary: &LogSummary) -> Result<(), Failure> {
    ENDED.clone_into(&mut host.status.state);
    host.write_status();
    let Host { recorder, feed, status, .. } = host;
    let early = summary.ended.as_ref().map(ToString::to_string);
    let kind = FeedEventKind::Ended { early: early.clone() };
    feed.push(&FeedItem::Event(FeedEvent { time_s: status.time_s, utc: SystemTime::now(), kind }));
    let mut outcome = vec![
        ("firmware".to_owned(), summary.firmware.clone()),
        ("lost".to_owned(), summary.lost.to_string()),
        ("trips".to_owned(), summary.trips.to_string()),
        ("complete".to_owned(), early.is_none().to_string()),
    ];
    outcome.push(("ended".to_owned(), early.unwrap_or_else(|| "stopped".to_owned())));
    let left_out = recorder.finish(&outcome).map_err(Failure::work)?;
    if left_out > 0 {
        complain(&format!("{left_out} rows were left out while the disk was full"));
    }
    Ok(())
}

/// Verdict of a log: the cause of an early end counts more than a trip.
pub fn verdict(summary: &LogSummary) -> Result<(), Failure> {
    let early = summary.ended.as_ref().map(|ended| format!("the log ended early: {ended}"));
    let tripped = summary.last_trip.as_ref().map(|trip| format!("the log was stopped and had tripped: {trip}"));
    crate::record::verdict([early.map(SessionEnd::Early), tripped.map(SessionEnd::Tripped)])
}

/// Beginning of a log.
struct Begin {
    /// Time of the first row, s: in a recording that is continued, behind its last.
    begin_s: f64,
    /// The moment that it stands for.
    begin: SystemTime,
    /// For how long there are no rows before it, s, if the recording is continued.
    continued: Option<f64>,
}

/// Looks what is in the folder, whose recording this adds to.
fn begin(folder: &Path, experiment: &Experiment, known: &mut Metadata) -> Result<Begin, Failure> {
    let now = SystemTime::now();
    // Rows that a killed program has left become a segment.
    let recovered = recording::recover(folder).map_err(Failure::work)?;
    if let Some(damaged) = recovered.and_then(|recovered| recovered.damaged) {
        complain(&crate::recover::put_aside(&damaged));
    }
    let Some(before) = recording::so_far(folder).map_err(Failure::usage)? else {
        return Ok(Begin { begin_s: 0.0, begin: now, continued: None });
    };
    refuse_other(folder, &before.metadata, known)?;
    let start = before.metadata.iter().find(|(key, _)| key == "start_utc").map(|(_, start)| start.clone());
    let start_s = start.as_deref().and_then(utc::from_rfc3339);
    let elapsed_s = start_s.map_or(0.0, |start_s| utc::seconds_of(now) - start_s);
    if let (Some(start), Some((_, own))) = (start, known.iter_mut().find(|(key, _)| key == "start_utc")) {
        *own = start;
    }
    let period_s = experiment.sample_period_s;
    let begin_s = elapsed_s.max(before.last_s + period_s);
    let begin_s = experiment.time_of((begin_s / period_s - 1e-6).ceil());
    // A simulation that ran faster than the clock is ahead of it.
    let begin = start_s.and_then(|start_s| Duration::try_from_secs_f64(start_s + begin_s).ok());
    let begin = begin.map_or(now, |since| SystemTime::UNIX_EPOCH + since);
    Ok(Begin { begin_s, begin, continued: Some(begin_s - before.last_s - period_s) })
}

/// Refuses to continue the recording of another head or at another period, whose columns may be the
/// same.
fn refuse_other(folder: &Path, before: &Metadata, known: &Metadata) -> Result<(), Failure> {
    for (key, what) in [("head_name", "of head"), ("sample_period_s", "with a sample period, in s, of")] {
        let of = |metadata: &Metadata| metadata.iter().find(|(own, _)| own == key).map(|(_, value)| value.clone());
        if let (Some(theirs), Some(own)) = (of(before), of(known))
            && theirs != own
        {
            let sentence = format!("holds a log {what} {theirs}, this one is {what} {own}: name another folder");
            return Err(Failure::in_file(folder, sentence));
        }
    }
    Ok(())
}

/// A time, s, where a size makes no sense.
fn seconds(option: &str, length: Option<SegmentLength>) -> Result<Option<f64>, Failure> {
    match length {
        None => Ok(None),
        Some(SegmentLength::Seconds(seconds)) => Ok(Some(seconds)),
        Some(SegmentLength::Bytes(_)) => {
            Err(Failure::usage(format!("{option}: a time belongs there, as in 1s, 10min, 12h or 30d")))
        }
    }
}

/// Refuses what is no whole number of milliseconds, which name the folder.
fn milliseconds(every_s: f64) -> Result<f64, Failure> {
    let milliseconds = (every_s * 1e3).round();
    if (every_s * 1e3 - milliseconds).abs() > 1e-6 {
        return Err(Failure::usage("--every: a whole number of milliseconds belongs there"));
    }
    Ok(Duration::from_millis(milliseconds as u64).as_secs_f64())
}
