//! Scenarios on the image that is flashed. `cargo xtask test` builds it and then runs these.
//!
//! No scenario may end with a complaint of the models but those of `known_defects`.

mod boot;
mod closed_loop;
mod crashes;
mod crashes_in_tasks;
mod guard;
mod known_defects;
mod lives;
mod process;
mod proof;
mod rig;
mod settings;
mod snapshot;
mod soak;
mod supervision;
mod supply;
mod ticks;
