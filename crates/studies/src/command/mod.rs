//! The two commands of the program.

pub mod benchmark;
mod output;
pub mod thesis;
