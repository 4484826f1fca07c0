//! `anemo board settings`: what a board keeps in its flash, shown, changed, backed up and restored.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use wire::settings::KeyNumber;
use wire::{Setting, SettingsRequest};

use crate::instrument::{EMULATED, Emulation, On, OpenBoard};
use crate::output::Failure;
use anemometry::head::Head;
use host_sim::instrument::InstrumentError;
use host_sim::settings::{self, KeptSetting, SettingsReport, file, names};
use recording::toml_file::TomlSource;

/// Show, change, back up and restore a board's settings.
///
/// Settings are name, head and set-up.
///
/// A board sets itself up by this at each start; it never starts a run by itself. Settings are read
/// and changed in standby only. A power cut leaves each value as it was or as it was to be.
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
    /// All values with their defaults, and whether they are kept.
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
    /// Replace all kept values by those of a file.
    Restore {
        /// The file.
        file: PathBuf,
        #[command(flatten)]
        board: BoardArguments,
    },
    /// Erase a key, or all of them: defaults hold then.
    Erase {
        /// The key, as `show` prints it.
        #[arg(required_unless_present = "all", conflicts_with = "all")]
        key: Option<String>,
        /// Erase all keys. A flash with foreign or damaged contents becomes usable again.
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
    fn read(&mut self) -> Result<(Vec<KeptSetting>, bool), Failure> {
        settings::read_all(self.port()).map_err(Failure::work)
    }

    /// Changes what is kept; nothing, if the instrument would not take it.
    fn change(&mut self, from: &[KeptSetting], to: &BTreeMap<KeyNumber, Setting>) -> Result<(), Failure> {
        settings::rehearse(to, self.port().limits()).map_err(Failure::usage)?;
        let (written, erased) = settings::change(self.port(), from, to).map_err(Failure::work)?;
        let erased = if erased > 0 { format!(", {erased} erased") } else { String::new() };
        crate::output::print(&format!(
            "{written} values written{erased}; {} are kept\n",
            to.keys().filter(|&&number| !names::is_the_boards(number)).count()
        ))
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.task {
        Task::Show { board, json } => with(board, |board| {
            let (kept, whole) = board.read()?;
            let report = SettingsReport::of(board.port().firmware(), &kept, whole);
            crate::output::print_report(&report, *json)
        }),
        Task::Set { key, value, head, sample_period, board } => {
            // Files are read before a board is asked for anything.
            let head = head.as_deref().map(Head::read).transpose()?;
            with(board, |board| {
                let (kept, _) = board.read()?;
                let mut to = settings::usable(&kept);
                match (&head, key, value) {
                    (Some(head), ..) => set_head(head, *sample_period, &mut to)?,
                    (None, Some(key), Some(value)) => names::set(&mut to, key, value).map_err(Failure::usage)?,
                    _ => return Err(Failure::usage("a key and a value belong here, or --head FILE")),
                }
                // What cannot be used stays where it is: another firmware may read it.
                let usable: Vec<KeptSetting> = kept.into_iter().filter(|kept| kept.setting.is_ok()).collect();
                board.change(&usable, &to)
            })
        }
        Task::Backup { output, board } => with(board, |board| backup(board, output)),
        Task::Restore { file, board } => {
            let to = file::from_source(&TomlSource::read(file)?)?;
            with(board, |board| {
                let taken = settings::rehearse(&to, board.port().limits());
                taken.map_err(|error| Failure::in_file(file, error))?;
                let (kept, whole) = board.read()?;
                if !whole {
                    board.port().ask_settings(&SettingsRequest::EraseAll).map_err(Failure::work)?;
                }
                board.change(if whole { &kept } else { &[] }, &to)
            })
        }
        Task::Erase { key, all, board } => {
            let number = key.as_deref().map(number_of).transpose()?;
            with(board, |board| {
                let request = match number {
                    Some(key) => SettingsRequest::Erase { key },
                    None if *all => SettingsRequest::EraseAll,
                    None => return Err(Failure::usage("a key belongs here, or --all")),
                };
                for request in [request, SettingsRequest::Load] {
                    board.port().ask_settings(&request).map_err(Failure::work)?;
                }
                crate::output::print("erased\n")
            })
        }
    }
}

/// Opens a board, does something with it and closes it whatever came of it.
fn with(arguments: &BoardArguments, work: impl FnOnce(&mut OpenBoard) -> Result<(), Failure>) -> Result<(), Failure> {
    let mut board = OpenBoard::open(&arguments.on, &arguments.emulation, &arguments.flash)?;
    let done = work(&mut board);
    let closed = board.close();
    done.and(closed)
}

fn number_of(key: &str) -> Result<KeyNumber, Failure> {
    let hexadecimal = || KeyNumber::from_str_radix(key.strip_prefix("0x")?, 16).ok();
    names::number(key).or_else(hexadecimal).ok_or_else(|| {
        // `show` has a line for each of a few plain numbers.
        let whole = key.rsplit_once('.').map(|(whole, _)| whole).filter(|whole| names::number(whole).is_some());
        Failure::usage(match whole {
            Some(whole) => format!("`{key}` is a part of `{whole}`, which is kept or erased as a whole"),
            None => format!("`{key}` is no key: `anemo board settings show` names them"),
        })
    })
}

fn set_head(head: &Head, sample_period_s: Option<f64>, to: &mut BTreeMap<KeyNumber, Setting>) -> Result<(), Failure> {
    // Through text: the kept period is the decimal that was meant.
    let kept = settings::sample_period_s(to).and_then(|period_s| period_s.to_string().parse().ok());
    let period_s = sample_period_s
        .or(kept)
        .filter(|period_s: &f64| period_s.is_finite() && *period_s > 0.0)
        .ok_or_else(|| Failure::usage("--head: no sample period is kept; give one, as in --sample-period 0.01"))?;
    settings::of_head(head, period_s, to).map_err(Failure::usage)
}

fn backup(board: &mut OpenBoard, output: &Path) -> Result<(), Failure> {
    let (kept, whole) = board.read()?;
    if !whole {
        return Err(Failure::work(InstrumentError::Settings(wire::SettingsRefusal::NotWhole)));
    }
    let unusable: Vec<String> = kept
        .iter()
        .filter_map(|kept| Some(format!("{} ({})", names::of(kept.number), kept.setting.as_ref().err()?)))
        .collect();
    let mut usable = settings::usable(&kept);
    // Of this board, and of no other.
    usable.retain(|&number, _| !names::is_the_boards(number));
    let text = file::to_toml(board.port().firmware(), &usable).map_err(Failure::work)?;
    crate::output::write_text(output, &text)?;
    let mut text = format!("{} values are in {}\n", usable.len(), output.display());
    if !unusable.is_empty() {
        let _ = writeln!(text, "left out, since this firmware cannot use them: {}", unusable.join(", "));
    }
    crate::output::print(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_key_leads_to_the_key() {
        let sentence = |key| match number_of(key) {
            Ok(number) => format!("{number:#06x}"),
            Err(failure) => failure.sentence,
        };
        assert_eq!(sentence("0x30ee"), "0x30ee");
        assert_eq!(
            sentence("guard.stuck_limit_ticks"),
            "`guard.stuck_limit_ticks` is a part of `guard`, which is kept or erased as a whole"
        );
        assert!(sentence("tested.0.verdict").starts_with("`tested.0.verdict` is a part of `tested.0`"));
        assert!(sentence("gurad").starts_with("`gurad` is no key"));
    }
}
