//! Rows and events of an instrument, from the run to everybody who listens.
//!
//! Nobody who is slow holds the run up: [`Feed::push`] takes no longer than it takes to append to
//! each reader's queue. A full queue loses its oldest row; events stay as long as there is a row to
//! lose instead. Every reader knows how much it lost.

use std::collections::VecDeque;
use std::fmt;
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant, SystemTime};

use dr_core::wind::QualityFlags;
use recording::head_mounting::{HeadMounting, from_deg};
use wire::WindSample;

/// Layout of an instrument's feed, before its first row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FeedLayout {
    /// Title of the run.
    pub title: String,
    /// Name of the head.
    pub head: String,
    /// Names of the elements, in the order of the rows' lists.
    pub elements: Vec<String>,
    /// Names of the elements whose rows carry the equivalent power of an observer.
    pub observed: Vec<String>,
    /// Names of the surfaces of the head, in the order of the wind estimate's conductances; none
    /// if the head outputs no wind estimate.
    pub surfaces: Vec<String>,
    /// s.
    pub sample_period_s: f64,
    /// Name and version of the firmware, or of the simulation.
    pub firmware: String,
    /// A number that no other board has; zeros for one that is no hardware.
    pub unique_id: [u32; 3],
    /// Compass direction and tilt of the head.
    pub mounting: HeadMounting,
}

impl FeedLayout {
    /// A name that stays the instrument's: the chip's number, or the head's name where there is no
    /// hardware. Letters, digits and underscores.
    pub fn id(&self) -> String {
        match self.unique_id {
            [0, 0, 0] => {
                let plain = |character: char| if character.is_ascii_alphanumeric() { character } else { '_' };
                format!("simulated_{}", self.head.chars().map(plain).collect::<String>())
            }
            [a, b, c] => format!("{a:08x}{b:08x}{c:08x}"),
        }
    }
}

/// One sample.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedRow {
    /// Since the start of the run, s.
    pub time_s: f64,
    /// The same instant by the host's clock.
    pub utc: SystemTime,
    /// One an element, °C; NaN where the reading was no temperature.
    pub temperature_c: Vec<f32>,
    /// Held until the next row, one an element, W.
    pub power_w: Vec<f32>,
    /// One an observed element, W.
    pub equivalent_power_w: Vec<f32>,
    /// Bit i set: element i is held at its high level until the next row.
    pub heaters: usize,
    /// `standby`, `running` or `tripped:<cause>:<element>`.
    pub state: Arc<str>,
    /// The wind estimate, at the end of an output interval.
    pub wind: Option<FeedWind>,
    /// Wind of the simulation, m/s.
    pub true_wind_m_s: Option<[f64; 3]>,
    /// Gas temperature of the simulation, °C.
    pub gas_temperature_c: Option<f64>,
}

/// A wind estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedWind {
    /// Estimate as the board sent it: vector (where the gas goes to), uncertainties, flags,
    /// conductances.
    pub estimate: WindSample,
    /// Direction from which it blows, degrees clockwise from north, in 0 … 360.
    pub from_deg: f64,
    /// Horizontal speed, m/s.
    pub horizontal_m_s: f64,
}

impl FeedWind {
    /// An estimate of a head that is mounted like this.
    pub fn new(estimate: WindSample, mounting: &HeadMounting) -> Self {
        let earth_m_s = mounting.earth(estimate.wind_m_s.map(f64::from));
        let [east_m_s, north_m_s, _] = earth_m_s;
        Self { from_deg: from_deg(earth_m_s), horizontal_m_s: libm::hypot(east_m_s, north_m_s), estimate }
    }

    /// Tells whether there is a wind vector: speed and direction mean something.
    pub fn is_valid(&self) -> bool {
        !self.estimate.quality_flags.has(QualityFlags::FAILED)
    }

    /// Tells whether the direction means something, too.
    pub fn has_direction(&self) -> bool {
        self.is_valid() && !self.estimate.quality_flags.has(QualityFlags::NO_DIRECTION)
    }
}

/// Event.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedEvent {
    /// Since the start of the run, s.
    pub time_s: f64,
    /// The same instant by the host's clock.
    pub utc: SystemTime,
    /// Kind.
    pub kind: FeedEventKind,
}

/// Kinds of events.
#[derive(Debug, Clone, PartialEq)]
pub enum FeedEventKind {
    /// The instrument tripped.
    Trip {
        /// Cause, as the recording's `state` names it.
        cause: String,
        /// The element, where it was one.
        element: Option<String>,
    },
    /// Somebody marked an event.
    Mark {
        /// In their words.
        text: String,
    },
    /// The board does not answer any more.
    LinkLost {
        /// A sentence.
        why: String,
    },
    /// The board answers again.
    LinkBack,
    /// The board started anew.
    BoardReset {
        /// A sentence.
        why: String,
    },
    /// A segment of the recording is complete.
    SegmentClosed {
        /// Its file.
        path: std::path::PathBuf,
    },
    /// The recording has no room.
    DiskFull,
    /// The recording goes on.
    DiskHasRoom,
    /// The run is over.
    Ended {
        /// Why, where it ended early.
        early: Option<String>,
    },
}

impl fmt::Display for FeedEventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Trip { cause, element: Some(element) } => write!(f, "trip: {cause} of {element}"),
            Self::Trip { cause, element: None } => write!(f, "trip: {cause}"),
            Self::Mark { text } => write!(f, "mark: {text}"),
            Self::LinkLost { why } => write!(f, "link lost: {why}"),
            Self::LinkBack => f.write_str("link back"),
            Self::BoardReset { why } => write!(f, "board reset: {why}"),
            Self::SegmentClosed { path } => write!(f, "segment closed: {}", path.display()),
            Self::DiskFull => f.write_str("disk full"),
            Self::DiskHasRoom => f.write_str("disk has room again"),
            Self::Ended { early: None } => f.write_str("ended"),
            Self::Ended { early: Some(why) } => write!(f, "ended early: {why}"),
        }
    }
}

/// A row or an event.
#[derive(Debug, Clone, PartialEq)]
pub enum FeedItem {
    /// A row.
    Row(Arc<FeedRow>),
    /// An event.
    Event(FeedEvent),
}

/// From the run to its readers. Clones feed the same readers.
#[derive(Debug, Clone)]
pub struct Feed(Arc<FeedHub>);

#[derive(Debug)]
struct FeedHub {
    layout: FeedLayout,
    queues: Mutex<Vec<Weak<FeedQueue>>>,
}

/// Items that wait for one reader.
#[derive(Debug)]
struct FeedQueue {
    capacity: usize,
    state: Mutex<QueueState>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct QueueState {
    items: VecDeque<FeedItem>,
    lost: u64,
    is_over: bool,
}

/// Locks what a panic of another thread leaves as usable as it was.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Feed {
    /// A feed that nobody reads yet.
    pub fn new(layout: FeedLayout) -> Self {
        Self(Arc::new(FeedHub { layout, queues: Mutex::default() }))
    }

    /// Layout of the feed.
    pub fn layout(&self) -> &FeedLayout {
        &self.0.layout
    }

    /// Hands an item to every reader. Never waits for one of them.
    pub fn push(&self, item: &FeedItem) {
        lock(&self.0.queues).retain(|queue| queue.upgrade().map(|queue| queue.push(item.clone())).is_some());
    }

    /// A reader of all that is pushed from now on, of which at most `capacity` items (at least
    /// one) wait for it.
    pub fn subscribe(&self, capacity: usize) -> FeedReader {
        let queue = FeedQueue { capacity: capacity.max(1), state: Mutex::default(), changed: Condvar::new() };
        let queue = Arc::new(queue);
        lock(&self.0.queues).push(Arc::downgrade(&queue));
        FeedReader { queue }
    }
}

impl Drop for FeedHub {
    fn drop(&mut self) {
        for queue in lock(&self.queues).iter().filter_map(Weak::upgrade) {
            lock(&queue.state).is_over = true;
            queue.changed.notify_all();
        }
    }
}

impl FeedQueue {
    fn push(&self, item: FeedItem) {
        let mut state = lock(&self.state);
        if state.items.len() >= self.capacity {
            let oldest_row = state.items.iter().position(|item| matches!(item, FeedItem::Row(_)));
            state.items.remove(oldest_row.unwrap_or(0));
            state.lost += 1;
        }
        state.items.push_back(item);
        self.changed.notify_all();
    }
}

/// Reads a [`Feed`].
#[derive(Debug)]
pub struct FeedReader {
    queue: Arc<FeedQueue>,
}

impl FeedReader {
    /// The next item.
    ///
    /// # Errors
    /// `Timeout` if none came in time, `Disconnected` if none will ever come.
    pub fn recv_timeout(&self, timeout: Duration) -> Result<FeedItem, RecvTimeoutError> {
        let deadline = Instant::now() + timeout;
        let mut state = lock(&self.queue.state);
        loop {
            if let Some(item) = state.items.pop_front() {
                return Ok(item);
            }
            if state.is_over {
                return Err(RecvTimeoutError::Disconnected);
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(RecvTimeoutError::Timeout);
            }
            state = self.queue.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Items that this reader was too slow for, since it subscribed.
    pub fn lost(&self) -> u64 {
        lock(&self.queue.state).lost
    }
}

#[cfg(test)]
mod tests;
