//! Many runs in this process: as many threads as cores, each of which does run after run.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};
use std::{fs, thread};

use crate::error::{RunFailure, SweepError};
use crate::plan::{Plan, Shard};
use crate::shard_note;

/// What came of the runs that were asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WorkDone {
    /// Runs that were complete before.
    pub before: usize,
    /// Runs that were done now.
    pub done: usize,
    /// Runs that failed now.
    pub failed: usize,
    /// Whether it ended before its time, so that some were not begun.
    pub interrupted: bool,
}

impl Plan {
    /// Does the runs of a shard, or all, that are not complete, on so many threads. `progress` is
    /// called after each with the number of runs that are settled. A run that fails does not stop
    /// the others.
    ///
    /// # Errors
    /// If the folder cannot be made, or a run's folder cannot be written.
    pub fn work(
        &self,
        folder: &Path,
        shard: Option<Shard>,
        jobs: usize,
        interrupted: &AtomicBool,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<WorkDone, SweepError> {
        fs::create_dir_all(folder).map_err(|error| SweepError::folder(folder, &error))?;
        shard.map_or(Ok(()), |shard| shard_note::write(folder, shard.of))?;
        let places = self.places(shard);
        let (next, settled) = (AtomicUsize::new(0), Mutex::new(WorkDone::default()));
        let unwritten = OnceLock::new();
        let worker = || {
            while let Some(&place) = places.get(next.fetch_add(1, Ordering::Relaxed)) {
                if interrupted.load(Ordering::Relaxed) || unwritten.get().is_some() {
                    break;
                }
                let was_complete = self.is_complete(place, folder);
                let outcome = if was_complete { Ok(()) } else { self.run(place, folder, interrupted).map(|_| ()) };
                let Ok(mut settled) = settled.lock() else { break };
                match outcome {
                    Ok(()) if was_complete => settled.before += 1,
                    Ok(()) => settled.done += 1,
                    Err(RunFailure::Interrupted) => break,
                    Err(RunFailure::Unwritten(sentence)) => {
                        // The others would fare alike.
                        let _ = unwritten.set(SweepError::Folder(sentence));
                        break;
                    }
                    Err(_) => settled.failed += 1,
                }
                progress(settled.before + settled.done + settled.failed);
            }
        };
        thread::scope(|scope| {
            (0..jobs.clamp(1, places.len().max(1))).for_each(|_| {
                scope.spawn(worker);
            });
        });
        if let Some(error) = unwritten.into_inner() {
            return Err(error);
        }
        let mut done = settled.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        done.interrupted = done.before + done.done + done.failed < places.len();
        Ok(done)
    }
}
