//! Thermal anemometers without hardware: simulated sensors in their wind tunnel, instruments,
//! experiments, and running them.
//!
//! An [`experiment::Experiment`] describes what every element does, in which gas and wind. An
//! [`instrument`] carries it out: dr-core's controller in this process, the firmware on an emulated
//! board (feature `qemu`), or a sensor board (feature `serial`). The first two are closed around a
//! simulated [`sensor`]. [`run::run`] hands out every sample as a row.
//!
//! ```
//! use host_sim::experiment::Experiment;
//! use host_sim::instrument::{LockStep, in_process::InProcess};
//! use host_sim::run::run;
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/steady.toml");
//! let experiment = Experiment { ticks: 200, ..Experiment::read(path.as_ref())? };
//! let instrument = LockStep::new(InProcess::new(), experiment.sensor()?);
//! let mut rows = 0;
//! let summary = run(&experiment, Box::new(instrument), &mut |_| Ok(rows += 1))?;
//! assert_eq!((summary.ticks, rows), (200, 200));
//! # Ok::<(), host_sim::run::RunError>(())
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`sensor`] | the simulated sensors: body, gas, wind, front end |
//! | [`instrument`] | what an experiment can be run on, and its errors |
//! | [`experiment`] | the experiment file, checked |
//! | [`run`] | set-up, loop, statistics and summary of a run |
//! | [`settings`] | what a board keeps in its flash: read, checked, changed |
//! | [`new_head`] | a head to begin with: its file by kind, and its first experiments |
//! | [`self_test`] | self-tests: started, waited for, reported |

pub mod experiment;
pub mod head_check;
pub mod instrument;
pub mod new_head;
pub mod run;
pub mod self_test;
pub mod sensor;
pub mod settings;

/// The examples name this crate as others do.
#[cfg(test)]
extern crate self as host_sim;

#[cfg(test)]
#[allow(dead_code, reason = "an example's own main")]
#[path = "../examples/one_loop.rs"]
mod one_loop;

#[cfg(test)]
mod tests {
    #[test]
    fn the_example_prints_what_stands_beside_it() {
        assert_eq!(super::one_loop::table().unwrap(), include_str!("../examples/one_loop.out"));
    }
}
