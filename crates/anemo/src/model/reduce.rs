//! `anemo model reduce`: a smaller model for the board.

use std::path::PathBuf;

use crate::output::Failure;
use diffusive::model::Model;
use diffusive::model::reduce::{Rates, ReductionReport, board, reduce};

/// Reduce a model to a few poles in f32, for the board, and report its error.
#[derive(clap::Args)]
#[command(after_help = "\
The error is measured: the board's f32 arithmetic and the whole model run on the same random bits and \
levels.

Examples:
  anemo model reduce heater.json --order 3 -o small.json
  anemo model reduce sector1.json --order 2 --json
  anemo model reduce winds.json --order 4 --class still --toml still.toml")]
pub struct Arguments {
    /// The model: a .json file of `anemo identify` or `anemo model`.
    model: PathBuf,
    /// Poles a pair, 1 to 8.
    #[arg(long, value_name = "K", default_value_t = 8)]
    order: usize,
    /// Place every rate freely (the default).
    #[arg(long, conflicts_with = "mesh")]
    free: bool,
    /// Keep the rates on a logarithmic grid (diffusive mesh), and place its edges.
    #[arg(long)]
    mesh: bool,
    /// Write the smaller model to this .json file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the board's table, as an experiment's `models` has it: 8 rates an element that heats
    /// itself.
    #[arg(long, value_name = "FILE")]
    toml: Option<PathBuf>,
    /// Event class of that table, where the model has several.
    #[arg(long, value_name = "LABEL")]
    class: Option<String>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    crate::output::keep(&[&arguments.model], &[arguments.output.as_deref(), arguments.toml.as_deref()])?;
    if let Some(path) = &arguments.output {
        crate::output::writable(path, "a model", "json")?;
    }
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let rates = if arguments.mesh { Rates::Mesh } else { Rates::Free };
    let reduced = reduce(&model, arguments.order, rates).map_err(|error| Failure::in_file(&arguments.model, error))?;
    let wanted = arguments.toml.is_some() || arguments.class.is_some();
    let table = board::table_of(&reduced.model, arguments.class.as_deref());
    if let (Err(error), true) = (&table, wanted) {
        return Err(Failure::in_file(&arguments.model, error));
    }
    if let (Some(path), Ok(table)) = (&arguments.toml, &table) {
        crate::output::write_text(path, table)?;
    }
    if let Some(path) = &arguments.output {
        reduced.model.write(path).map_err(Failure::work)?;
    }
    let [file, table_file] =
        [&arguments.output, &arguments.toml].map(|path| path.as_ref().map(|path| path.display().to_string()));
    let report = ReductionReport::new(&model, (arguments.order, &reduced), &table, (file, table_file));
    crate::output::print_report(&report, arguments.json)
}
