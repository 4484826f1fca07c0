//! The command from outside.

mod cli;
mod export;
mod long_record;
