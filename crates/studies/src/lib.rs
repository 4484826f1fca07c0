//! The experiments of the thesis, and the benchmark of the whole instrument, both on the simulated
//! sensors.
//!
//! | module | what |
//! |---|---|
//! | [`thesis`] | its experiments, with its published values beside ours: `studies thesis` |
//! | [`benchmark`] | what the whole instrument has to reach, and what it reaches: `studies benchmark` |
//!
//! ```
//! use studies::thesis::{STUDIES, StudyLab};
//!
//! let progress = |line: &str| eprintln!("{line}");
//! let experiments = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/thesis");
//! let lab = StudyLab::new(experiments, &progress);
//! let names: Vec<&str> = STUDIES.iter().map(|study| study.name).collect();
//! assert_eq!(names[0], "rems-self");
//! // STUDIES[0].run(&lab)? would take some seconds.
//! assert_eq!(lab.experiment("rems-self-still")?.sample_period_s, 0.05);
//! # Ok::<(), studies::thesis::StudyError>(())
//! ```

pub mod benchmark;
mod table;
pub mod thesis;
