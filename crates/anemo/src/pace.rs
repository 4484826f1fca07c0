//! Time of a simulation or recording, held against the clock.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Longest sleep before another look whether to end.
const LOOK: Duration = Duration::from_millis(50);

/// So many seconds of a run in one of the clock.
pub struct Pace {
    speed: f64,
    begun: Instant,
}

impl Pace {
    /// From now on.
    pub fn new(speed: f64) -> Self {
        Self { speed, begun: Instant::now() }
    }

    /// Waits until a row of this time is due, or somebody asks to end. What is late is made up for.
    pub fn wait(&self, time_s: f64, interrupted: &AtomicBool) {
        let due = Duration::try_from_secs_f64(time_s / self.speed).unwrap_or_default();
        while let Some(left) = due.checked_sub(self.begun.elapsed())
            && !left.is_zero()
            && !interrupted.load(Ordering::Relaxed)
        {
            std::thread::sleep(left.min(LOOK));
        }
    }
}
