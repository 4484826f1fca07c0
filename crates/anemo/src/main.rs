//! The binary; [`anemo::main`] does the work.

fn main() -> std::process::ExitCode {
    anemo::main()
}
