//! The one door to every job of the project, for people and for continuous integration alike:
//! `cargo xtask <job>`.

mod artefacts;
mod book;
mod campaign;
mod ci;
mod cost;
mod counterparts;
mod coverage;
mod demo;
mod deny;
mod dist;
mod emulator;
mod features;
mod flash;
mod fuzz;
mod hardware;
mod install;
mod lines;
mod links;
mod lint;
mod markdown;
mod miri;
mod mutants;
mod nightly;
mod pages;
mod programs;
mod python;
mod reference;
mod registers;
mod response;
mod safety;
mod same_results;
mod seeded;
mod shell;
mod size;
mod sources;
mod stages;
mod stated;
mod test;

use clap::{CommandFactory, Parser};
use std::process::ExitCode;

#[derive(Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    about = "Every job of the project, one command each",
    disable_help_subcommand = true
)]
enum Job {
    /// Fly the simulated sphere through gusts with the real firmware on an emulated board, and plot
    /// it
    Demo,
    /// Run unit tests, examples in the documentation, tests of the command and closed loops on the
    /// emulated board, and check size, panics and stack of the firmware
    Test,
    /// Run every command that README.md, CONTRIBUTING.md and docs show, and compare what it prints
    /// with what they show
    Pages(pages::PagesOptions),
    /// Build the pages of docs as a book in target/book, with its links checked
    Book(book::BookOptions),
    /// Check what can be checked by reading: format, clippy, documentation, links between pages
    Lint,
    /// Refuse dependencies by their licences and sources, and by advisories where a database is
    /// given
    Deny(deny::DenyOptions),
    /// Do what continuous integration does: install what is missing, lint, book, pages, Python,
    /// faults and scenarios, and all of `test`
    Ci,
    /// Do what takes longer, in stages of at most an hour; passed ones are not repeated
    Nightly(nightly::NightlyOptions),
    /// Count lines of code of every crate, of its tests and examples, and the words of all pages
    Lines(lines::LinesOptions),
    /// Run all experiments and a chain of commands by an older `anemo` and by this one, and compare
    /// results and files to the bit; or images of the firmware
    SameResults(same_results::SameResultsOptions),
    /// Write the pages of the command-line reference, or check them
    Reference(reference::ReferenceOptions),
    /// Pack a release: a small `anemo`, completions, man pages, licences, and what a user begins
    /// with
    Dist,
    /// Show flash and RAM of both boards' images, and refuse an image beyond its budget
    Size,
    /// Show on both boards' images that no task can panic and that the stack suffices, and that an
    /// overflow of it ends as a fault
    Safety,
    /// Run the sensor board's scenarios and hold the registers that they use against ST's description
    /// of the chip and against the crate of its registers
    Registers,
    /// Simulate the sensor board's analogue part, its cut-off and their single faults by ngspice,
    /// and compare with hardware/results.csv
    Hardware(hardware::HardwareOptions),
    /// Count instructions and cycles of the hot paths on the emulated Cortex-M4F
    Cost(cost::CostOptions),
    /// Try endings, lives, flipped bits or long runs, as many or as long as one likes
    Campaign(campaign::CampaignOptions),
    /// Look for inputs at which a reader or the controller fails, as long as one likes, and keep
    /// what was found on the way
    Fuzz(fuzz::FuzzOptions),
    /// Run the unit tests of dr-core and wire in an interpreter that finds undefined behaviour
    Miri,
    /// Count the lines of dr-core that its unit tests run, and refuse too few
    Coverage,
    /// Change dr-core's signals and control in every way that cargo-mutants knows, and show the
    /// changes that no test finds
    Mutants(mutants::MutantsOptions),
    /// Put defects into the sensor board's firmware, one at a time, and show that its scenarios
    /// notice each
    Seeded(seeded::SeededOptions),
    /// Build the Python package's wheel, install it into target/tools/python, and test it
    Python(python::PythonOptions),
    /// Install the programs that what `anemo` publishes is tested against
    Counterparts {
        /// Install those of Slurm, which only `cargo xtask nightly` needs, and no others
        #[arg(long)]
        slurm: bool,
    },
    /// Program a sensor board through a debug probe and follow its log
    Flash(flash::FlashOptions),
}

fn main() -> ExitCode {
    let outcome = match Job::parse() {
        Job::Demo => demo::run(),
        Job::Test => test::run(),
        Job::Pages(options) => pages::run(&options, Job::command(), None),
        Job::Book(options) => book::run(&options),
        Job::Lint => lint::run(),
        Job::Deny(options) => deny::run(&options),
        Job::Ci => ci::run(Job::command()),
        Job::Nightly(options) => nightly::run(&options),
        Job::Lines(options) => lines::run(&options),
        Job::SameResults(options) => same_results::run(&options),
        Job::Reference(options) => reference::run(&options),
        Job::Dist => dist::run(),
        Job::Size => size::run(),
        Job::Safety => safety::run(),
        Job::Registers => registers::run(),
        Job::Hardware(options) => hardware::run(&options),
        Job::Cost(options) => cost::run(&options),
        Job::Campaign(options) => campaign::run(&options),
        Job::Fuzz(options) => fuzz::run(&options),
        Job::Miri => miri::run(),
        Job::Coverage => coverage::run(),
        Job::Mutants(options) => mutants::run(&options),
        Job::Seeded(options) => seeded::run(&options),
        Job::Python(options) => python::run(&options),
        Job::Counterparts { slurm: false } => counterparts::run(),
        Job::Counterparts { slurm: true } => {
            counterparts::slurm();
            Ok(())
        }
        Job::Flash(options) => flash::run(&options),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
