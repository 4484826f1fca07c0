//! Runs every command that README.md, CONTRIBUTING.md and the pages in `docs` show, and compares
//! what it prints with what the page shows below it.
//!
//! | a page has | and then |
//! |---|---|
//! | ```` ```console ```` | lines that begin with `$ ` are run by bash, continued by lines that begin with `> `; what follows is compared; `…` stands for any lines, or any text of a line |
//! | ```` ```bash ```` | is run as one script; the block ```` ```text ```` right after it is compared |
//! | ```` ```console fails ```` | the last command is expected to fail |
//! | ```` ```console board ```` | needs a sensor board: its lines with `anemo` must parse |
//! | ```` ```python ```` | is run by Python with duckdb, numpy, pandas, pyarrow, scipy and xarray |
//! | `cargo …`, `git …` | is not run; jobs of `cargo xtask` must exist |
//! | code in the text that begins with `anemo` | must parse, if it is a whole command or a name |
//!
//! The blocks of a page run in their order in one fresh folder, `target/pages/NAME`, with copies of
//! `experiments`, `heads`, `docs` and `tests/fixtures`. Pictures that `docs/gallery.md` makes are
//! those of `docs/images`, to the byte.

mod elision;
mod gallery;
mod names;
mod page;
mod transcript;

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, python, shell, sources};
use anyhow::{Context, Result, bail};
use page::{Page, PageOutcome, Workshop};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use transcript::Step;

#[derive(clap::Args, Default)]
pub struct PagesOptions {
    /// Pages to run; without any, README.md, CONTRIBUTING.md and all in docs
    #[arg(value_name = "PAGE")]
    pages: Vec<PathBuf>,
    /// Put what is printed into the pages, and what is drawn into docs/images
    #[arg(long)]
    write: bool,
}

/// Programs that pages run, built.
pub struct PagePrograms {
    pub anemo: PathBuf,
    /// `anemo`'s example that reads command lines without running them.
    pub interface: PathBuf,
    pub firmware: PathBuf,
}

impl PagePrograms {
    pub fn build() -> Result<Self> {
        let given = |variable: &str, build: &dyn Fn() -> Result<PathBuf>| {
            std::env::var_os(variable).map(PathBuf::from).map_or_else(build, Ok)
        };
        Ok(Self {
            anemo: given("ANEMO_BIN", &artefacts::anemo)?,
            interface: artefacts::interface()?,
            firmware: given("ANEMO_FIRMWARE", &|| artefacts::firmware(FirmwareBoard::Virtual))?,
        })
    }
}

/// Runs pages; `jobs` are those of `cargo xtask`. Programs that are not handed over are built.
pub fn run(options: &PagesOptions, jobs: clap::Command, programs: Option<PagePrograms>) -> Result<()> {
    let paths = if options.pages.is_empty() { all(&shell::root())? } else { options.pages.clone() };
    let mut pages = paths.iter().map(|path| Page::read(path)).collect::<Result<Vec<_>>>()?;
    // The longest come first, so that no processor waits for them at the end.
    pages.sort_by_key(|page| std::cmp::Reverse(page.steps.len()));
    let programs = match programs {
        Some(programs) => programs,
        None => {
            let imports = |step: &Step| matches!(step, Step::Python { script, .. } if script.contains("import anemo"));
            if pages.iter().flat_map(|page| &page.steps).any(imports) {
                python::package()?;
            }
            PagePrograms::build()?
        }
    };
    let workshop = prepare(&pages, jobs, programs)?;
    let mut outcomes = run_all(&pages, &workshop)?;
    outcomes.sort_by_key(|(_, outcome)| std::cmp::Reverse(outcome.time));
    if options.write {
        for (page, outcome) in &outcomes {
            page.revise(&outcome.revisions)?;
            gallery::replace(&outcome.changed_pictures)?;
        }
    }
    report(&outcomes, options.write)
}

/// The pages whose commands are run: those that a reader is led to.
pub fn all(root: &Path) -> Result<Vec<PathBuf>> {
    let mut pages = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    pages.extend(sources::files_with_extension(&root.join("docs"), "md")?);
    Ok(pages)
}

/// Brings whatever these pages' commands need.
fn prepare(pages: &[Page], jobs: clap::Command, programs: PagePrograms) -> Result<Workshop> {
    let steps = || pages.iter().flat_map(|page| &page.steps);
    let shows = |word: &str| steps().any(|step| matches!(step, Step::Command(shown) if shown.command.contains(word)));
    let mut workshop = Workshop::new(shell::target_directory()?.join("pages"), programs, jobs)?;
    if shows("--on qemu") {
        install::qemu()?;
    }
    if shows("python") || steps().any(|step| matches!(step, Step::Python { .. })) {
        workshop.programs.push(install::python()?);
    }
    Ok(workshop)
}

/// Runs pages beside each other, one on each processor.
fn run_all<'a>(pages: &'a [Page], workshop: &Workshop) -> Result<Vec<(&'a Page, PageOutcome)>> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut done = Vec::new();
        while let Some(page) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
            let outcome = page.run(workshop).with_context(|| format!("{} cannot be run", page.name))?;
            done.push((page, outcome));
        }
        Ok(done)
    };
    thread::scope(|scope| {
        let processors = thread::available_parallelism().map_or(1, usize::from);
        let workers: Vec<_> = (0..processors).map(|_| scope.spawn(worker)).collect();
        let done: Result<Vec<_>> = workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|_| bail!("a thread that runs pages has ended early")))
            .collect();
        Ok(done?.into_iter().flatten().collect())
    })
}

fn report(outcomes: &[(&Page, PageOutcome)], written: bool) -> Result<()> {
    let mut faults = 0;
    for (_, outcome) in outcomes {
        outcome.faults.iter().for_each(|fault| println!("{fault}"));
        let outputs = outcome.revisions.iter().map(|revision| revision.fault.clone());
        let picture = |made: &PathBuf| format!("{} is not the one of docs/images", made.display());
        let differences: Vec<_> = outputs.chain(outcome.changed_pictures.iter().map(picture)).collect();
        differences.iter().for_each(|fault| println!("{fault}{}", if written { "  (written)" } else { "" }));
        faults += outcome.faults.len() + if written { 0 } else { differences.len() };
    }
    for (page, outcome) in outcomes.iter().filter(|(_, outcome)| outcome.run > 0) {
        println!("{:>6.1} s  {:>3} commands  {}", outcome.time.as_secs_f64(), outcome.run, page.name);
    }
    println!("{} commands and scripts run", outcomes.iter().map(|(_, outcome)| outcome.run).sum::<usize>());
    if faults > 0 {
        bail!(
            "{faults} faults in pages, above with page and line; where the command is right and the page is not, \
             type: cargo xtask pages --write"
        );
    }
    Ok(())
}
