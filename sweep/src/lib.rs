//! Sweeps: many runs of an experiment over any keys of experiment, head and models, and what is
//! done with their recordings, on one machine or many.
//!
//! A [`Plan`] is read from a sweep file. Its [`runs`](Plan::runs) are known before any begins, each
//! by the hash of all that it consists of. A run has a folder by that hash: what is complete is not
//! done again, what two machines did can be compared, and any engine may hand out the work.
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use sweep::Plan;
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/sweeps/winds.toml");
//! let plan = Plan::read(path.as_ref())?;
//! let folder = tempfile::tempdir()?;
//!
//! // One run, by its place or its hash: what a worker of Dask or a task of Slurm does.
//! let never = AtomicBool::new(false);
//! let result = plan.run(0, folder.path(), &never)?;
//! assert_eq!(result.run, plan.runs()[0].hash);
//! assert_eq!(plan.run_of(&result.run, folder.path(), &never)?, result);
//!
//! // All that are missing, on two threads, and the table of results.
//! plan.work(folder.path(), None, 2, &never, &|_| ())?;
//! let report = plan.gather(folder.path())?;
//! assert_eq!((report.complete, report.runs), (plan.runs().len(), plan.runs().len()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | module | what |
//! |---|---|
//! | `sweep_file`, `key`, `sampling` | the file, its keys, which values they take together |
//! | `documents` | the files of a run, and its hash |
//! | [`Plan`] | the runs, and checking them |
//! | `conduct`, `steady`, `step`, `columns` | one run: experiments, means, steps, names of results |
//! | `run_folder`, `shard_note` | what is kept of it |
//! | `work` | many runs on threads |
//! | `gather`, `outlier`, [`SweepReport`] | the table of results, what stands apart, what is reported |
//! | [`slurm`] | the same on a cluster |

mod columns;
mod conduct;
mod documents;
mod error;
mod gather;
mod key;
mod outlier;
mod plan;
mod report;
mod run_folder;
mod sampling;
mod shard_note;
pub mod slurm;
mod steady;
mod step;
mod sweep_file;
mod work;

pub use error::{RunFailure, SweepError};
pub use gather::RESULTS;
pub use plan::{Plan, PlannedRun, Shard, ShardError};
pub use report::{FoundOutlier, MissingShard, RunNote, SweepReport};
pub use run_folder::RunResult;
pub use work::WorkDone;

#[cfg(test)]
mod tests;
