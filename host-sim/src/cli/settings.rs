//! `anemo settings`: what a board keeps in its flash, shown, changed, put aside and brought back.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use wire::settings::{Key, KeyNumber, Kind};
use wire::{Setting, SettingsRequest};

use super::Failure;
use super::run::{LinkName, On, firmware_of};
use crate::head::Head;
use crate::instrument::emulated::Emulated;
use crate::instrument::serial::Serial;
use crate::instrument::{Account, Body, InstrumentError, Keeper};
use crate::settings::{self, Kept, file, names};
use crate::toml_file::Source;

/// Characters of a value that a line of the table has room for.
const MOST_SHOWN: usize = 60;

/// What a board keeps in its flash: its name, the head it has and how it is set up.
///
/// A board sets itself up by this at each start, so that it knows its head without a host; it never starts a run by itself. Settings are
/// read and changed in standby only. A power cut at any moment leaves each value as it was or as it was to be.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo settings show --on serial:/dev/ttyACM0
  anemo settings set name \"north mast\" --on serial:/dev/ttyACM0
  anemo settings set --head sphere-b.toml --sample-period 0.001 --on serial:/dev/ttyACM0
  anemo settings backup -o north-mast.toml --on serial:/dev/ttyACM0
  anemo settings restore north-mast.toml --on serial:/dev/ttyACM0
  anemo settings forget gas --on serial:/dev/ttyACM0
  anemo settings show --on qemu --flash board.flash")]
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
    /// Keys: name, telemetry_every, sample_period_s, guard.missing_limit_ticks, guard.unreachable_limit_ticks, guard.stuck_limit_ticks, observe, gas.pressure_pa,
    /// gas.temperature_c.
    Set {
        /// What to change.
        #[arg(requires = "value", required_unless_present = "head", conflicts_with = "head")]
        key: Option<String>,
        /// To what.
        #[arg(allow_hyphen_values = true)]
        value: Option<String>,
        /// A head file: its guard, elements and calibration, in place of all that is kept of another head.
        #[arg(long, value_name = "FILE")]
        head: Option<PathBuf>,
        /// Sample period for the head, s; without it the one that is kept.
        #[arg(long, value_name = "S", requires = "head")]
        sample_period: Option<f64>,
        #[command(flatten)]
        board: BoardArguments,
    },
    /// Put all values aside, in a text file.
    Backup {
        /// The file.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        #[command(flatten)]
        board: BoardArguments,
    },
    /// Bring all values back from a file, in place of all that is kept.
    Restore {
        /// The file.
        file: PathBuf,
        #[command(flatten)]
        board: BoardArguments,
    },
    /// Keep nothing of a key, or of all: defaults hold then.
    Forget {
        /// Which, as `show` names it.
        #[arg(required_unless_present = "all", conflicts_with = "all")]
        key: Option<String>,
        /// All of them. A flash that holds something else, or has rotted, is erased.
        #[arg(long)]
        all: bool,
        #[command(flatten)]
        board: BoardArguments,
    },
}

#[derive(clap::Args)]
pub(super) struct BoardArguments {
    /// Whose settings.
    #[arg(long, value_name = "qemu|serial:DEVICE")]
    pub(super) on: On,
    /// The file that is the flash of the emulated board; it is made if there is none.
    #[arg(long, value_name = "FILE", default_value = "settings.flash")]
    pub(super) flash: PathBuf,
    /// The firmware that the emulated board runs.
    #[arg(long, value_name = "ELF", env = "ANEMO_FIRMWARE")]
    pub(super) firmware: Option<PathBuf>,
    /// How to talk to the emulated board.
    #[arg(long, value_name = "fifo|usart", default_value = "fifo", hide_possible_values = true)]
    pub(super) link: LinkName,
}

/// A board that is open.
pub(super) enum Board {
    Emulated(Box<Emulated>),
    Serial(Box<Serial>),
}

impl Board {
    pub(super) fn open(arguments: &BoardArguments) -> Result<Self, Failure> {
        Ok(match &arguments.on {
            On::Sim => {
                return Err(Failure::usage(
                    "--on sim: a controller in this process keeps nothing; name a board: qemu or serial:DEVICE",
                ));
            }
            On::Qemu => {
                let firmware = firmware_of(arguments.firmware.as_deref());
                let board = Emulated::start_with(&firmware, arguments.link.path(), Some(&arguments.flash));
                Self::Emulated(Box::new(board.map_err(Failure::work)?))
            }
            On::Serial(device) => Self::Serial(Box::new(Serial::open(device).map_err(Failure::work)?)),
        })
    }

    pub(super) fn keeper(&mut self) -> &mut dyn Keeper {
        match self {
            Self::Emulated(board) => board.as_mut(),
            Self::Serial(board) => board.as_mut(),
        }
    }

    pub(super) fn close(self) -> Result<(), Failure> {
        match self {
            Self::Emulated(board) => board.finish().map(|_: Account| ()).map_err(Failure::work),
            // It goes on with whatever it does.
            Self::Serial(_) => Ok(()),
        }
    }

    fn read(&mut self) -> Result<(Vec<Kept>, bool), Failure> {
        settings::read_all(self.keeper()).map_err(Failure::work)
    }

    /// Changes what is kept; nothing, if the instrument would not take it.
    fn change(&mut self, from: &[Kept], to: &BTreeMap<KeyNumber, Setting>) -> Result<(), Failure> {
        settings::rehearse(to).map_err(Failure::usage)?;
        let (written, forgotten) = settings::change(self.keeper(), from, to).map_err(Failure::work)?;
        let forgotten = if forgotten > 0 { format!(", {forgotten} forgotten") } else { String::new() };
        super::print(&format!(
            "{written} values written{forgotten}; {} are kept\n",
            to.keys().filter(|&&number| !names::is_the_boards(number)).count()
        ))
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.task {
        Task::Show { board, json } => with(board, |board| show(board, *json)),
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
                let usable: Vec<Kept> = kept.into_iter().filter(|kept| kept.setting.is_ok()).collect();
                board.change(&usable, &to)
            })
        }
        Task::Backup { output, board } => with(board, |board| backup(board, output)),
        Task::Restore { file, board } => {
            let to = file::from_source(&Source::read(file)?)?;
            settings::rehearse(&to).map_err(|sentence| Failure::usage(format!("{}: {sentence}", file.display())))?;
            with(board, |board| {
                let (kept, whole) = board.read()?;
                if !whole {
                    board.keeper().ask_settings(&SettingsRequest::ForgetAll).map_err(Failure::work)?;
                }
                board.change(if whole { &kept } else { &[] }, &to)
            })
        }
        Task::Forget { key, all, board } => {
            let number = key.as_deref().map(number_of).transpose()?;
            with(board, |board| {
                let request = match number {
                    Some(key) => SettingsRequest::Forget { key },
                    None if *all => SettingsRequest::ForgetAll,
                    None => return Err(Failure::usage("a key belongs here, or --all")),
                };
                for request in [request, SettingsRequest::Load] {
                    board.keeper().ask_settings(&request).map_err(Failure::work)?;
                }
                super::print("forgotten\n")
            })
        }
    }
}

/// Opens a board, does something with it and closes it whatever came of it.
fn with(arguments: &BoardArguments, work: impl FnOnce(&mut Board) -> Result<(), Failure>) -> Result<(), Failure> {
    let mut board = Board::open(arguments)?;
    let done = work(&mut board);
    let closed = board.close();
    done.and(closed)
}

fn number_of(key: &str) -> Result<KeyNumber, Failure> {
    let hexadecimal = || KeyNumber::from_str_radix(key.strip_prefix("0x")?, 16).ok();
    names::number(key)
        .or_else(hexadecimal)
        .ok_or_else(|| Failure::usage(format!("`{key}` is no key: `anemo settings show` names them")))
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

fn backup(board: &mut Board, output: &Path) -> Result<(), Failure> {
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
    let text = file::to_toml(board.keeper().firmware(), &usable).map_err(Failure::work)?;
    super::write_text(output, &text)?;
    let mut told = format!("{} values are in {}\n", usable.len(), output.display());
    if !unusable.is_empty() {
        let _ = writeln!(told, "left out, since this firmware cannot use them: {}", unusable.join(", "));
    }
    super::print(&told)
}

/// One line of the table.
struct Line {
    key: String,
    value: String,
    default: String,
    state: String,
}

fn show(board: &mut Board, json: bool) -> Result<(), Failure> {
    let (kept, whole) = board.read()?;
    let mut numbers: Vec<KeyNumber> = kept.iter().map(|kept| kept.number).collect();
    // What always holds has its line always.
    let always = [Kind::Name, Kind::TelemetryEvery, Kind::SamplePeriod, Kind::Guard, Kind::Observe];
    numbers.extend(always.map(|kind| Key { kind, which: 0 }.number()));
    numbers.sort_unstable();
    numbers.dedup();
    let found = |number| kept.iter().find(|kept| kept.number == number);
    let default = |number| Key::of_number(number).and_then(|key| settings::default_of(key.kind));
    if json {
        let all = numbers.iter().map(|&number| {
            let default = default(number).as_ref().map(settings::content);
            let (value, stored, unusable) = match found(number).map(|kept| &kept.setting) {
                Some(Ok(setting)) => (Some(settings::content(setting)), true, None),
                Some(Err(why)) => (default.clone(), true, Some(why.to_string())),
                None => (default.clone(), false, None),
            };
            let entry =
                serde_json::json!({ "value": value, "default": default, "stored": stored, "unusable": unusable });
            (names::of(number), entry)
        });
        let settings: serde_json::Map<_, _> = all.collect();
        let firmware = board.keeper().firmware().to_owned();
        return super::print_json(&serde_json::json!({ "firmware": firmware, "whole": whole, "settings": settings }));
    }
    let mut lines = Vec::new();
    for &number in &numbers {
        let default = default(number).as_ref().map(settings::content);
        let (value, state) = match found(number).map(|kept| &kept.setting) {
            Some(Ok(setting)) => (Some(settings::content(setting)), "stored".to_owned()),
            Some(Err(why)) => (default.clone(), format!("not used: {why}")),
            None => (default.clone(), "default".to_owned()),
        };
        flatten(&names::of(number), value.as_ref(), default.as_ref(), &state, &mut lines);
    }
    let width = |of: fn(&Line) -> &str, title: &str| {
        lines.iter().map(|line| of(line).chars().count()).chain([title.len()]).max().unwrap_or(0)
    };
    let (keys, values, defaults) =
        (width(|line| &line.key, "key"), width(|line| &line.value, "value"), width(|line| &line.default, "default"));
    let mut text = format!(
        "{}\n\n{:keys$}  {:values$}  {:defaults$}  state\n",
        board.keeper().firmware(),
        "key",
        "value",
        "default"
    );
    for Line { key, value, default, state } in &lines {
        let _ = writeln!(text, "{key:keys$}  {value:values$}  {default:defaults$}  {state}");
    }
    if !whole {
        let _ = writeln!(text, "\n{}: bring them back with `anemo settings restore`", wire::SettingsRefusal::NotWhole);
    }
    super::print(&text)
}

/// The lines of a value: one for each of a few plain numbers, one for all of what is longer.
fn flatten(
    key: &str,
    value: Option<&serde_json::Value>,
    default: Option<&serde_json::Value>,
    state: &str,
    lines: &mut Vec<Line>,
) {
    if let Some(serde_json::Value::Object(parts)) = value
        && parts.values().all(|part| !part.is_object() && !part.is_array())
        && parts.len() <= 4
    {
        for (name, part) in parts {
            let default = default.and_then(|default| default.get(name));
            lines.push(Line {
                key: format!("{key}.{name}"),
                value: brief(Some(part)),
                default: brief(default),
                state: state.to_owned(),
            });
        }
        return;
    }
    lines.push(Line { key: key.to_owned(), value: brief(value), default: brief(default), state: state.to_owned() });
}

fn brief(value: Option<&serde_json::Value>) -> String {
    let text = match value {
        None | Some(serde_json::Value::Null) => return "–".to_owned(),
        Some(serde_json::Value::String(text)) if text.is_empty() => return "–".to_owned(),
        Some(serde_json::Value::String(text)) => text.clone(),
        Some(other) => other.to_string().replace('"', ""),
    };
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or(&text)),
        None => text,
    }
}
