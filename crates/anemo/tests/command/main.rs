//! The command from outside.

mod ambient;
mod charge;
mod cli;
mod combine;
mod currents;
mod export;
mod head;
mod long_record;
mod losses;
mod many_elements;
mod process;
mod report;
mod steady_table;
mod wind;
