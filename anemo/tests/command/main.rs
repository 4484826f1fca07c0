//! The command from outside.

mod cli;
mod examples;
mod export;
mod long_record;
mod losses;
mod report;
