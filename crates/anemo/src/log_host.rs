//! Surroundings of a log: its recording, who listens and asks, its files, the clock.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::process::{Child, Command};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant, SystemTime};

use crate::feeding;
use crate::log_files::{LogStatus, MOST_EVENTS, MarkReader};
use crate::log_source::PressureSource;
use crate::output::complain;
use crate::progress::LiveTable;
use host_sim::instrument::serial::Serial;
use host_sim::instrument::{InstrumentPort, Observation};
use host_sim::run::RunError;
use host_sim::run::log::{LogCommand, LogEvent, LogHost, LogRequest};
use publish::commands::FeedRequest;
use publish::feed::{Feed, FeedEvent, FeedEventKind, FeedItem};
use recording::head_mounting::HeadMounting;
use recording::{Recorder, RecordingRow, utc};

/// Files are looked at as often.
const LOOK_EVERY: Duration = Duration::from_millis(250);
const STATUS_EVERY: Duration = Duration::from_secs(1);
/// A lost instrument is looked for as often.
const CONNECT_EVERY: Duration = Duration::from_secs(1);
/// Longest sleep before somebody who wants the end is noticed.
const NAP: Duration = Duration::from_millis(100);

/// Where the pressure comes from, and what it was.
pub(super) struct PressureFile {
    pub source: PressureSource,
    pub last_pa: f64,
    pub modified: Option<SystemTime>,
}

pub(super) struct Host {
    /// Opened before anything else.
    pub first: Option<Box<dyn InstrumentPort>>,
    /// The port of a board, which may come back.
    pub device: Option<String>,
    pub recorder: Recorder,
    pub folder: PathBuf,
    /// Time of the first row, s, and the moment that it stands for.
    pub begin_s: f64,
    pub begin: SystemTime,
    /// By the clock that nobody sets; of the first row.
    pub began: Option<Instant>,
    /// Simulated rows wait for their time.
    pub is_paced: bool,
    pub until_s: Option<f64>,
    pub mounting: HeadMounting,
    pub keeps_heating: bool,
    pub on_trip: Option<String>,
    pub interrupted: Arc<AtomicBool>,
    pub feed: Feed,
    pub requests: Receiver<FeedRequest>,
    pub own_requests: VecDeque<LogCommand>,
    pub marks: MarkReader,
    pub pressure: Option<PressureFile>,
    pub looked: Instant,
    pub status: LogStatus,
    pub status_written: Instant,
    pub table: LiveTable,
    pub children: Vec<Child>,
}

impl Host {
    fn moment(&self, time_s: f64) -> SystemTime {
        match self.device {
            Some(_) => SystemTime::now(),
            None => self.begin + Duration::try_from_secs_f64(time_s - self.begin_s).unwrap_or_default(),
        }
    }

    fn interrupt(&self) -> Result<(), RunError> {
        if self.interrupted.load(Relaxed) { Err(RunError::Interrupted) } else { Ok(()) }
    }

    /// Says it to everybody: at the terminal, in the status, to listeners.
    fn tell(&mut self, time_s: f64, line: &str, kind: Option<FeedEventKind>) {
        self.table.say(&format!("{time_s:.2} s: {line}"));
        self.status.events.push(format!("{time_s:.2} s  {line}"));
        let more = self.status.events.len().saturating_sub(MOST_EVENTS);
        self.status.events.drain(..more);
        if let Some(kind) = kind {
            self.feed.push(&FeedItem::Event(FeedEvent { time_s, utc: self.moment(time_s), kind }));
        }
        self.write_status();
    }

    pub fn write_status(&mut self) {
        self.status_written = Instant::now();
        self.status.utc = utc::rfc3339(utc::seconds_of(SystemTime::now()).round());
        // A disk without room keeps the status before.
        let _ = self.status.write(&self.folder);
    }

    /// Marks that were written, and a pressure that changed.
    fn look(&mut self) {
        self.looked = Instant::now();
        self.own_requests.extend(self.marks.take().into_iter().map(LogCommand::Mark));
        self.children.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
        let Some(pressure) = &mut self.pressure else { return };
        let PressureSource::File(path) = &pressure.source else { return };
        let modified = path.metadata().and_then(|file| file.modified()).ok();
        if modified == pressure.modified {
            return;
        }
        pressure.modified = modified;
        match pressure.source.now_pa() {
            Ok(now_pa) if now_pa != pressure.last_pa => {
                pressure.last_pa = now_pa;
                self.own_requests.push_back(LogCommand::Pressure(now_pa));
            }
            Ok(_) => {}
            Err(failure) => {
                let (time_s, line) = (self.status.time_s, format!("{}; the pressure stays", failure.sentence));
                self.tell(time_s, &line, None);
            }
        }
    }

    /// Notices what the recorder has met.
    fn watch_disk(&mut self, time_s: f64) {
        self.status.left_out = self.recorder.left_out();
        let (is_full, segment) = (self.recorder.lacks_room(), self.recorder.segment());
        if segment != self.status.segment {
            let path = self.folder.join(format!("segment-{:06}.parquet", self.status.segment));
            self.status.segment = segment;
            let kind = FeedEventKind::SegmentClosed { path };
            self.feed.push(&FeedItem::Event(FeedEvent { time_s, utc: self.moment(time_s), kind }));
        }
        if is_full == self.status.disk_full {
            return;
        }
        self.status.disk_full = is_full;
        if !is_full {
            let line = format!("the disk has room again; {} rows were left out", self.status.left_out);
            return self.tell(time_s, &line, Some(FeedEventKind::DiskHasRoom));
        }
        let heaters = if self.keeps_heating {
            "heaters go on"
        } else {
            self.own_requests.push_back(LogCommand::Stop);
            "heaters go to standby"
        };
        let line = format!("the disk is full: the segment is closed, rows are left out, {heaters}");
        self.tell(time_s, &line, Some(FeedEventKind::DiskFull));
    }

    /// Sleeps until a simulated row is due.
    fn pace(&mut self, time_s: f64) -> Result<(), RunError> {
        let began = *self.began.get_or_insert_with(Instant::now);
        let due = Duration::try_from_secs_f64(time_s - self.begin_s).unwrap_or_default();
        while self.is_paced && began.elapsed() < due {
            self.interrupt()?;
            std::thread::sleep((due - began.elapsed().min(due)).min(NAP));
        }
        Ok(())
    }
}

impl LogHost for Host {
    fn connect(&mut self) -> Result<Box<dyn InstrumentPort>, RunError> {
        match (self.first.take(), &self.device) {
            (Some(instrument), _) => Ok(instrument),
            (None, Some(device)) => Ok(Box::new(Serial::open(device)?)),
            (None, None) => Err(RunError::NoSample),
        }
    }

    fn reconnects(&self) -> bool {
        self.device.is_some()
    }

    fn elapsed_s(&self) -> Option<f64> {
        self.device.as_ref()?;
        Some(self.begin_s + self.began.map_or(0.0, |began| began.elapsed().as_secs_f64()))
    }

    fn row(&mut self, row: &RecordingRow<'_>, observation: &Observation, lost: u64) -> Result<(), RunError> {
        self.pace(row.time_s)?;
        let moment = self.moment(row.time_s);
        self.recorder.push_at(row, moment)?;
        self.watch_disk(row.time_s);
        if row.state != self.status.state {
            row.state.clone_into(&mut self.status.state);
        }
        let feed_row = feeding::row(row, observation, moment, &self.mounting);
        self.table.push(row, lost + self.status.left_out);
        self.feed.push(&FeedItem::Row(Arc::new(feed_row)));
        self.status.rows += 1;
        self.status.time_s = row.time_s;
        if self.status_written.elapsed() >= STATUS_EVERY {
            self.write_status();
        }
        if self.until_s.is_some_and(|until_s| row.time_s >= until_s) {
            return Err(RunError::Interrupted);
        }
        self.interrupt()
    }

    fn happened(&mut self, time_s: f64, event: &LogEvent) {
        if let (LogEvent::Trip { cause, element }, Some(command)) = (event, &self.on_trip) {
            let mut shell = Command::new("sh");
            shell.args(["-c", command]).env("ANEMO_TRIP_CAUSE", cause).env("ANEMO_TRIP_ELEMENT", element);
            match shell.spawn() {
                Ok(child) => self.children.push(child),
                Err(error) => self.table.say(&format!("--on-trip cannot be started: {error}")),
            }
        }
        self.tell(time_s, &event.to_string(), feeding::event(event.clone()));
    }

    fn request(&mut self) -> Option<LogRequest> {
        if self.looked.elapsed() >= LOOK_EVERY {
            self.look();
        }
        if let Some(command) = self.own_requests.pop_front() {
            let refused = format!("{command:?} was refused");
            let answer = move |outcome| {
                if let Err(refusal) = outcome {
                    complain(&format!("{refused}: {refusal}"));
                }
            };
            return Some(LogRequest { command, answer: Box::new(answer) });
        }
        feeding::request(&self.requests, self.feed.layout().sample_period_s)
    }

    fn wait(&mut self) -> Result<(), RunError> {
        let begin = Instant::now();
        while begin.elapsed() < CONNECT_EVERY {
            self.interrupt()?;
            std::thread::sleep(NAP);
        }
        self.watch_disk(self.status.time_s);
        self.write_status();
        Ok(())
    }
}
