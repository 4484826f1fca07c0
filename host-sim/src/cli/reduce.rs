//! `anemo reduce`: a smaller model for the board.

use std::fmt::Write as _;
use std::path::PathBuf;

use super::Failure;
use crate::model::export::Part;
use crate::model::reduce::{Rates, Reduced, board, reduce};
use crate::model::{Class, Model, Pair};
use crate::recording::Temporary;

/// Make a smaller model in f32, for the board, and say what it loses.
#[derive(clap::Args)]
#[command(after_help = "\
The loss is measured: the board's own f32 arithmetic runs beside the whole model on random bits and on random levels.

Examples:
  anemo reduce model.json --order 8 -o small.json
  anemo reduce model.json --order 3 --json
  anemo reduce model.json --order 8 --class still --toml still.toml    (the `models` of an experiment)")]
pub struct Arguments {
    /// The model: a JSON file of `anemo identify`.
    model: PathBuf,
    /// Poles a pair, 1 to 8.
    #[arg(long, value_name = "K", default_value_t = 8)]
    order: usize,
    /// Place every rate freely (the default).
    #[arg(long, conflicts_with = "mesh")]
    free: bool,
    /// Keep the rates on a geometric mesh, and place its edges.
    #[arg(long)]
    mesh: bool,
    /// The smaller model to write, JSON.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The board's table to write, as an experiment's `models` has it: 8 rates an element that heats itself.
    #[arg(long, value_name = "FILE")]
    toml: Option<PathBuf>,
    /// The event class of the board's table, where the model has several.
    #[arg(long, value_name = "LABEL")]
    class: Option<String>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let refuse = |sentence: String| Failure::usage(format!("{}: {sentence}", arguments.model.display()));
    let rates = if arguments.mesh { Rates::Mesh } else { Rates::Free };
    let reduced = reduce(&model, arguments.order, rates).map_err(refuse)?;
    let wanted = arguments.toml.is_some() || arguments.class.is_some();
    let table = match board_table(&reduced.model, arguments.class.as_deref()) {
        Err(sentence) if wanted => return Err(refuse(sentence)),
        table => table,
    };
    if let (Some(path), Ok(table)) = (&arguments.toml, &table) {
        let failed = |error| Failure::usage(format!("{}: cannot be written: {error}", path.display()));
        Temporary::write(path, table.as_bytes()).map_err(failed)?;
    }
    if let Some(path) = &arguments.output {
        reduced.model.write(path).map_err(Failure::usage)?;
    }
    if arguments.json {
        return super::print_json(&serde_json::json!({
            "order": arguments.order,
            "pairs": reduced.model.pairs,
            "losses": reduced.losses,
            "toml": table.ok(),
            "file": arguments.output.as_ref().map(|path| path.display().to_string()),
        }));
    }
    let mut text = summary(&model, &reduced);
    match (table, &arguments.toml) {
        (_, Some(path)) => text.push_str(&format!("\nboard's table in {}\n", path.display())),
        (Ok(table), None) => text.push_str(&format!("\nThe board's table (--toml FILE writes it):\n\n{table}")),
        (Err(sentence), None) => text.push_str(&format!("\nNo table for the board: {sentence}\n")),
    }
    if let Some(path) = &arguments.output {
        text.push_str(&format!("\nmodel in {}\n", path.display()));
    }
    super::print(&text)
}

/// The table of the class that was named, or of the only one.
fn board_table(model: &Model, class: Option<&str>) -> Result<String, String> {
    let first = &model.pairs[0];
    let name = format!("{}:{}", first.input, first.output);
    let label = match (class, &model.wind, &model.classes[..]) {
        (Some(class), ..) => class,
        (None, Some(wind), _) => &wind.reference,
        (None, None, [only]) => only,
        (None, None, several) => {
            return Err(format!(
                "it holds for one class, and the model has {}; choose with --class",
                several.join(", ")
            ));
        }
    };
    let part = Part::find(model, Some(&name), Some(label))?;
    board::toml(model, part.label)
}

fn summary(whole: &Model, reduced: &Reduced) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    for (before, pair) in whole.pairs.iter().zip(&reduced.model.pairs) {
        let (from, to) = (before.mesh_rad_s.len(), pair.mesh_rad_s.len());
        let _ = writeln!(text, "{} → {}: {from} poles → {to}, f32", pair.input, pair.output);
        for (label, class) in &pair.classes {
            class_summary(&mut text, pair, label, class);
            let own = |loss: &&crate::model::reduce::loss::Loss| {
                loss.input == pair.input && loss.output == pair.output && loss.class == *label
            };
            if let Some(loss) = reduced.losses.iter().find(own) {
                for (input, difference) in [("random bits", loss.bits), ("random levels", loss.levels)] {
                    let _ = writeln!(
                        text,
                        "  lost on {input}: {:.2e} of the output's rms, at most {:.2e} K/W",
                        difference.rms_share, difference.largest_k_per_w
                    );
                }
                let _ = writeln!(text, "  steady gain changes by {:.2e} of itself", loss.steady_gain_change);
            }
        }
    }
    text
}

fn class_summary(text: &mut String, pair: &Pair, label: &str, class: &Class) {
    let _ = writeln!(text, "  class {label}\n  {:>14}  {:>14}  {:>10}", "rate rad/s", "R K/W", "± K/W");
    for ((rate, r), se) in pair.mesh_rad_s.iter().zip(&class.r_k_per_w).zip(&class.se_k_per_w) {
        let _ = writeln!(text, "  {:>14}  {:>14}  {se:>10.1e}", *rate as f32, *r as f32);
    }
}
