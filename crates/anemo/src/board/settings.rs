//! `anemo board settings`: what a board keeps in its flash, shown, changed, backed up and restored.

use std::path::{Path, PathBuf};

use crate::instrument::{EMULATED, Emulation, On, OpenBoard};
use crate::output::Failure;
use anemometry::head::Head;
use host_sim::instrument::InstrumentError;
use host_sim::settings::{self, Settings, SettingsReport, StoredSettings, file};
use recording::toml_file::TomlSource;

/// Show, change, back up and restore a board's settings.
///
/// Settings are name, head and set-up.
///
/// A board sets itself up by this at each start; it never starts a run by itself. Settings are read
/// and changed in standby only. A power cut leaves all of them as they were or as they were to be.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo board settings show --on serial:/dev/ttyACM0
  anemo board settings set name \"north mast\" --on serial:/dev/ttyACM0
  anemo board settings set --head heads/sphere-b.toml --sample-period 0.001 \\
      --on serial:/dev/ttyACM0
  anemo board settings set fingerprint measured --on serial:/dev/ttyACM0
  anemo board settings backup -o north-mast.toml --on serial:/dev/ttyACM0
  anemo board settings restore north-mast.toml --on serial:/dev/ttyACM0
  anemo board settings erase gas --on serial:/dev/ttyACM0
  anemo board settings show --on qemu --flash board.flash")]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(clap::Subcommand)]
enum Task {
    /// All values with their defaults.
    Show {
        #[command(flatten)]
        board: BoardArguments,
        /// Print one JSON object instead of the table.
        #[arg(long)]
        json: bool,
    },
    /// Change one value, or the whole head.
    ///
    /// Keys: name, telemetry_every, sample_period_s, guard.missing_limit_ticks,
    /// guard.unreachable_limit_ticks, guard.stuck_limit_ticks, observe, host_timeout_s,
    /// fingerprint (`measured`), gas.pressure_pa, gas.temperature_c.
    Set {
        /// The key.
        #[arg(requires = "value", required_unless_present = "head", conflicts_with = "head")]
        key: Option<String>,
        /// Its new value.
        #[arg(allow_hyphen_values = true)]
        value: Option<String>,
        /// A head file: its guard, elements and calibration, in place of those of another head.
        #[arg(long, value_name = "FILE")]
        head: Option<PathBuf>,
        /// Sample period for the head, s; by default the one that is kept.
        #[arg(long, value_name = "S", requires = "head")]
        sample_period: Option<f64>,
        #[command(flatten)]
        board: BoardArguments,
    },
    /// Write all values to a text file.
    Backup {
        /// The file.
        #[arg(short, long = "output-file", value_name = "FILE")]
        output: PathBuf,
        #[command(flatten)]
        board: BoardArguments,
    },
    /// Replace all settings by those of a file.
    Restore {
        /// The file.
        file: PathBuf,
        #[command(flatten)]
        board: BoardArguments,
    },
    /// Erase the value of a key, or all values: defaults hold then.
    Erase {
        /// The key: one of `set`, without its part, or head.
        #[arg(required_unless_present = "all", conflicts_with = "all")]
        key: Option<String>,
        /// Erase all values. A flash with foreign or damaged contents becomes usable again.
        #[arg(long)]
        all: bool,
        #[command(flatten)]
        board: BoardArguments,
    },
}

#[derive(clap::Args)]
struct BoardArguments {
    /// The board.
    #[arg(long, value_name = "qemu|serial:DEVICE")]
    on: On,
    /// The file that is the flash of the emulated board; made if there is none.
    #[arg(long, value_name = "FILE", default_value = "settings.flash", help_heading = EMULATED)]
    flash: PathBuf,
    #[command(flatten)]
    emulation: Emulation,
}

impl OpenBoard {
    fn read(&mut self) -> Result<StoredSettings, Failure> {
        settings::read_all(self.port()).map_err(Failure::work)
    }

    /// Changes the settings.
    fn edit(
        &mut self,
        edit: impl FnOnce(&mut Settings, &StoredSettings) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let stored = self.read()?;
        let mut new = stored.settings.clone().map_err(|why| {
            Failure::work(format!("{}; `restore` or `erase --all` writes new ones", InstrumentError::Settings(why)))
        })?;
        edit(&mut new, &stored)?;
        self.write(&new)
    }

    /// Replaces the settings; not if the instrument would refuse the new ones.
    fn write(&mut self, new: &Settings) -> Result<(), Failure> {
        settings::rehearse(new, self.port().limits()).map_err(Failure::usage)?;
        settings::write(self.port(), new).map_err(Failure::work)?;
        let bytes = new.bytes().map_err(Failure::work)?.len();
        crate::output::print(&format!("settings stored: {bytes} bytes\n"))
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.task {
        Task::Show { board, json } => with(board, |board| {
            let stored = board.read()?;
            crate::output::print_report(&SettingsReport::of(board.port().firmware(), &stored), *json)
        }),
        Task::Set { key, value, head, sample_period, board } => {
            // Files are read before a board is asked for anything.
            let head = head.as_deref().map(Head::read).transpose()?;
            with(board, |board| {
                board.edit(|new, stored| match (&head, key, value) {
                    (Some(head), ..) => set_head(head, *sample_period, new),
                    (None, Some(key), Some(value)) => {
                        new.set(key, value, stored.test_at_start.as_ref()).map_err(Failure::usage)
                    }
                    _ => Err(Failure::usage("a key and a value belong here, or --head FILE")),
                })
            })
        }
        Task::Backup { output, board } => with(board, |board| backup(board, output)),
        Task::Restore { file, board } => {
            let new = file::from_source(&TomlSource::read(file)?)?;
            with(board, |board| {
                let refused = settings::rehearse(&new, board.port().limits());
                refused.map_err(|error| Failure::in_file(file, error))?;
                board.write(&new)
            })
        }
        Task::Erase { key, all: _, board } => with(board, |board| match key {
            Some(key) => board.edit(|new, _| new.erase(key).map_err(Failure::usage)),
            None => board.write(&Settings::default()),
        }),
    }
}

/// Opens a board, does something with it and closes it whatever came of it.
fn with(arguments: &BoardArguments, work: impl FnOnce(&mut OpenBoard) -> Result<(), Failure>) -> Result<(), Failure> {
    let mut board = OpenBoard::open(&arguments.on, &arguments.emulation, &arguments.flash)?;
    let done = work(&mut board);
    let closed = board.close();
    done.and(closed)
}

fn set_head(head: &Head, sample_period_s: Option<f64>, settings: &mut Settings) -> Result<(), Failure> {
    // Through text: the kept period is the decimal that was meant.
    let kept = settings.sample_period_s().and_then(|period_s| period_s.to_string().parse().ok());
    let period_s = sample_period_s
        .or(kept)
        .filter(|period_s: &f64| period_s.is_finite() && *period_s > 0.0)
        .ok_or_else(|| Failure::usage("--head: no sample period is kept; give one, as in --sample-period 0.01"))?;
    settings.set_head(head, period_s).map_err(Failure::usage)
}

fn backup(board: &mut OpenBoard, output: &Path) -> Result<(), Failure> {
    let settings = board.read()?.settings.map_err(|why| Failure::work(InstrumentError::Settings(why)))?;
    let text = file::to_toml(board.port().firmware(), &settings).map_err(Failure::work)?;
    crate::output::write_text(output, &text)?;
    crate::output::print(&format!("the settings are in {}\n", output.display()))
}
