//! The command from outside.

mod ambient;
mod charge;
mod cli;
mod combine;
mod currents;
mod export;
mod head;
mod identify_parts;
mod laws;
mod long_record;
mod losses;
mod many_elements;
#[cfg(feature = "object-store")]
mod object_store;
mod process;
mod report;
mod steady_table;
mod sweep;
#[cfg(target_os = "linux")]
mod sweep_slurm;
mod wind;
