//! The command `anemo`. Everything that it does is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
