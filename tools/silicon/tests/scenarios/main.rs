//! Scenarios on the image that is flashed. `cargo xtask test` builds it and then runs these.
//!
//! No scenario may end with a complaint of the models.

mod against_qemu;
mod boot;
mod closed_loop;
mod crashes;
mod crashes_in_tasks;
mod cut_off;
mod equal_bits;
mod front_end;
mod guard;
mod lives;
mod lock_out;
mod process;
mod proof;
mod reset_values;
mod response_times;
mod rig;
mod self_test;
mod settings;
mod snapshot;
mod soak;
mod stop;
mod supervision;
mod supply;
mod ticks;
mod upsets;
mod verdicts;
mod wind;
