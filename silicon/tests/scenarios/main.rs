//! Scenarios on the image that is flashed. `cargo xtask test` builds it and then runs these.
//!
//! No scenario may end with a complaint of the models.

mod boot;
mod closed_loop;
mod crashes;
mod crashes_in_tasks;
mod front_end;
mod guard;
mod lives;
mod process;
mod proof;
mod rig;
mod settings;
mod snapshot;
mod soak;
mod stop;
mod supervision;
mod supply;
mod ticks;
