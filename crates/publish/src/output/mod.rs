//! Outputs: each in a thread of its own, with a queue of its own.
//!
//! An output that cannot be reached costs the run nothing: one sentence when it fails, one when it
//! works again, and a new attempt after a second, later after up to half a minute. What it missed
//! in between is in the recording.

mod mqtt;
mod scpi;
mod scpi_session;
mod text;

use std::io::{self, Read, Write};
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::commands::FeedCommands;
use crate::feed::{Feed, FeedEvent, FeedItem, FeedLayout, FeedReader, FeedRow, FeedWind};
use crate::listen::Listening;
use crate::target::{PublishFormat, PublishTarget};

/// From one call of `turn` to the next.
const TURN: Duration = Duration::from_millis(50);
/// After a first failure, and after many.
const RETRY: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(30)];
/// Rows that wait for an output: some seconds at 1 kHz.
const QUEUE: usize = 4_096;
/// An output gets this long to say good-bye.
const GOOD_BYE: Duration = Duration::from_secs(6);

/// The outputs of a run.
#[must_use = "outputs say good-bye when they are joined"]
pub struct Publishing {
    threads: Vec<(String, JoinHandle<()>)>,
}

/// Starts all outputs. They end with the feed: when all its clones are dropped.
///
/// # Errors
/// If the system has no thread left.
pub fn start(targets: &[PublishTarget], feed: &Feed, context: &PublishContext) -> io::Result<Publishing> {
    let mut threads = Vec::new();
    for target in targets {
        let (name, reader) = (target.name.clone(), feed.subscribe(QUEUE));
        let publisher = Publisher::new(target.clone(), feed.layout().clone(), context.clone());
        let thread = std::thread::Builder::new().name("publish".to_owned());
        threads.push((name, thread.spawn(move || publisher.run(&reader))?));
    }
    Ok(Publishing { threads })
}

impl Publishing {
    /// Waits until all outputs have said good-bye, some seconds at most. Gives the names of those
    /// that have not.
    pub fn join(self) -> Vec<String> {
        let deadline = Instant::now() + GOOD_BYE;
        let is_late = |thread: &JoinHandle<()>| {
            while !thread.is_finished() && Instant::now() < deadline {
                std::thread::sleep(Duration::from_millis(5));
            }
            !thread.is_finished()
        };
        self.threads.into_iter().filter(|(_, thread)| is_late(thread)).map(|(name, _)| name).collect()
    }
}

/// The thread of an output.
struct Publisher {
    target: PublishTarget,
    layout: FeedLayout,
    context: PublishContext,
    output: Option<Box<dyn Output>>,
    try_at: Instant,
    /// Failures in a row.
    failures: u32,
    rate: RowRate,
    /// It has missed rows.
    is_slow: bool,
}

impl Publisher {
    fn new(target: PublishTarget, layout: FeedLayout, context: PublishContext) -> Self {
        let rate = RowRate::new(target.every_s, layout.sample_period_s);
        Self { target, layout, context, output: None, try_at: Instant::now(), failures: 0, rate, is_slow: false }
    }

    fn run(mut self, reader: &FeedReader) {
        let mut turn_at = Instant::now();
        loop {
            if self.output.is_none() && Instant::now() >= self.try_at {
                self.open();
            }
            let done = match reader.recv_timeout(TURN) {
                Ok(item) => self.pass(&item),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            let is_turn = turn_at.elapsed() >= TURN;
            let done = done.and_then(|()| match &mut self.output {
                Some(output) if is_turn => output.turn(),
                _ => Ok(()),
            });
            if is_turn {
                turn_at = Instant::now();
                self.count(reader.lost());
            }
            if let Err(error) = done {
                self.fail(&error);
            }
        }
        if let Some(mut output) = self.output {
            output.end();
        }
        if reader.lost() > 0 {
            (self.context.report)(&format!("{}: left out {} rows", self.target.name, reader.lost()));
        }
    }

    /// Says once that rows come too fast.
    fn count(&mut self, lost: u64) {
        if lost > 0 && !self.is_slow {
            self.is_slow = true;
            (self.context.report)(&format!(
                "{}: takes too long and misses rows; the recording has them",
                self.target.name
            ));
        }
    }

    fn open(&mut self) {
        let opened = match self.target.format {
            PublishFormat::Mqtt => mqtt::open(&self.target, &self.layout),
            PublishFormat::Scpi => scpi::open(&self.target, &self.layout, &self.context),
            _ => text::open(&self.target, &self.context),
        };
        match opened {
            Ok(output) => {
                if self.failures > 0 {
                    (self.context.report)(&format!("{}: works again", self.target.name));
                }
                (self.output, self.failures) = (Some(output), 0);
            }
            Err(error) => self.fail(&error),
        }
    }

    fn fail(&mut self, error: &anyhow::Error) {
        if self.failures == 0 {
            (self.context.report)(&format!("{}: {error}; the recording goes on, trying again", self.target.name));
        }
        let [first, most] = RETRY;
        self.try_at = Instant::now() + most.min(first * 2_u32.saturating_pow(self.failures));
        self.failures = self.failures.saturating_add(1);
        self.output = None;
    }

    fn pass(&mut self, item: &FeedItem) -> anyhow::Result<()> {
        let Some(output) = &mut self.output else { return Ok(()) };
        match item {
            FeedItem::Row(row) => self.rate.next(row).map_or(Ok(()), |row| output.row(&row)),
            FeedItem::Event(event) => output.event(event),
        }
    }
}

/// Lets rows pass, not more often than every so many seconds.
struct RowRate {
    every_s: f64,
    sample_period_s: f64,
    last_s: Option<f64>,
    /// The last wind estimate since the last row that passed.
    wind: Option<FeedWind>,
}

impl RowRate {
    fn new(every_s: f64, sample_period_s: f64) -> Self {
        Self { every_s, sample_period_s, last_s: None, wind: None }
    }

    /// The row if it is due, with the last wind estimate since the one before: estimates are rarer
    /// than rows, and a row in between would have none.
    fn next(&mut self, row: &Arc<FeedRow>) -> Option<Arc<FeedRow>> {
        if self.every_s == 0.0 {
            return Some(row.clone());
        }
        if row.wind.is_some() {
            self.wind.clone_from(&row.wind);
        }
        // A time that goes back is that of a new start.
        let is_early = |last_s: f64| (0.0..self.every_s - self.sample_period_s / 2.0).contains(&(row.time_s - last_s));
        if self.last_s.is_some_and(is_early) {
            return None;
        }
        self.last_s = Some(row.time_s);
        Some(match self.wind.take() {
            wind @ Some(_) if row.wind.is_none() => Arc::new(FeedRow { wind, ..FeedRow::clone(row) }),
            _ => row.clone(),
        })
    }
}

/// Context that outputs need besides the feed.
#[derive(Clone)]
pub struct PublishContext {
    /// Addresses that listeners may bind to.
    pub listening: Listening,
    /// Where commands go to; without, every command is refused.
    pub commands: Option<FeedCommands>,
    /// Takes sentences for the user.
    pub report: Arc<dyn Fn(&str) + Send + Sync>,
}

/// One way out, open.
pub(super) trait Output: Send {
    /// Sends a row.
    fn row(&mut self, row: &Arc<FeedRow>) -> anyhow::Result<()>;

    /// Sends an event.
    fn event(&mut self, _event: &FeedEvent) -> anyhow::Result<()> {
        Ok(())
    }

    /// Work that is done several times a second, whether there is a row or not.
    fn turn(&mut self) -> anyhow::Result<()> {
        Ok(())
    }

    /// Says good-bye.
    fn end(&mut self) {}
}

/// A stream to a broker, encrypted or not.
pub(super) trait BrokerStream: Read + Write + Send {}
impl<T: Read + Write + Send> BrokerStream for T {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::examples;

    #[test]
    fn rows_pass_as_often_as_wanted_and_take_the_last_wind_along() {
        let mut rate = RowRate::new(1.0, 0.01);
        let row = |tick: u32| {
            let wind = (tick % 10 == 5).then(|| examples::wind(2.0, 270.0, Default::default()));
            Arc::new(FeedRow { time_s: f64::from(tick) * 0.01, ..examples::row(wind) })
        };
        let passed: Vec<_> = (0..301).filter_map(|tick| rate.next(&row(tick))).collect();
        assert_eq!(passed.iter().map(|row| row.time_s).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(passed.iter().map(|row| row.wind.is_some()).collect::<Vec<_>>(), [false, true, true, true]);
        // After a new start the time begins anew.
        assert!(rate.next(&row(0)).is_some());
        let mut all = RowRate::new(0.0, 0.01);
        assert_eq!((0..10).filter_map(|tick| all.next(&row(tick))).count(), 10);
    }
}
