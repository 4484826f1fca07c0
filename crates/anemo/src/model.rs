//! `anemo model`: reduces, merges and exports model files that `anemo identify` has written.

use std::path::PathBuf;

use crate::options::choice;
use crate::output::Failure;
use diffusive::model::export::source::Language;
use diffusive::model::export::spice::SpiceNetwork;
use diffusive::model::export::{ExportForm, ExportReport};
use diffusive::model::merge::{MergeReport, merge};
use diffusive::model::reduce::{Rates, ReductionReport, board, reduce};
use diffusive::model::{Model, PairClass};

/// Reduce, merge and export models.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: ModelCommand,
}

#[derive(clap::Subcommand)]
enum ModelCommand {
    Reduce(ReduceArguments),
    Merge(MergeArguments),
    Export(ExportArguments),
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.command {
        ModelCommand::Reduce(arguments) => reduce_model(arguments),
        ModelCommand::Merge(arguments) => merge_models(arguments),
        ModelCommand::Export(arguments) => export_model(arguments),
    }
}

/// Reduce a model to a few poles in f32, for the board, and report its error.
#[derive(clap::Args)]
#[command(after_help = "\
The error is measured: the board's f32 arithmetic and the whole model run on the same random bits and \
levels.

Examples:
  anemo model reduce heater.json --order 3 -o small.json
  anemo model reduce sector1.json --order 2 --json
  anemo model reduce winds.json --order 4 --class still --toml still.toml")]
struct ReduceArguments {
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

fn reduce_model(arguments: &ReduceArguments) -> Result<(), Failure> {
    crate::output::keep(&[&arguments.model], &[arguments.output.as_deref(), arguments.toml.as_deref()])?;
    crate::output::writable(arguments.output.as_deref(), "a model", "json")?;
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

/// Merge models of different pairs of input and output into one.
///
/// The merged model adds up their responses.
///
/// For elements driven one after the other: identify each from its own record, with all outputs,
/// and merge. An output of several models has the offset and residuals of the first; `anemo
/// validate` estimates offsets anew.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo identify id-sector1.parquet --input sector1 \\
      --output sector1 sector2 -o heats1.json
  anemo identify id-sector2.parquet --input sector2 \\
      --output sector1 sector2 -o heats2.json
  anemo model merge heats1.json heats2.json -o both.json")]
struct MergeArguments {
    /// The models: two or more .json files.
    #[arg(required = true, num_args = 2.., value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// Write the merged model to this .json file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: PathBuf,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

fn merge_models(arguments: &MergeArguments) -> Result<(), Failure> {
    let read: Vec<_> = arguments.models.iter().map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[Some(&arguments.output)])?;
    crate::output::writable(Some(&arguments.output), "a model", "json")?;
    let mut models = Vec::with_capacity(arguments.models.len());
    for path in &arguments.models {
        models.push((path.display().to_string(), Model::read(path).map_err(Failure::usage)?));
    }
    let merged = merge(&models).map_err(Failure::usage)?;
    merged.write(&arguments.output).map_err(Failure::work)?;
    let report = MergeReport { model: &merged };
    crate::output::tell(&report)?;
    if arguments.json {
        return crate::output::print_json(&report);
    }
    crate::output::print(&format!("{report}\nmodel written to {}\n", arguments.output.display()))
}

/// Export a model as a network, a netlist, a table or source text.
#[derive(clap::Args)]
#[command(after_help = "\
Tables are CSV with units in their names; without -o the export goes to stdout.

Examples:
  anemo model export sector1.json --as foster --pair sector1:sector1
  anemo model export heater.json --as response --points 400 -o bode.csv
  anemo model export winds.json --as spice --network cauer --class gust \\
      -o gust.lib
  anemo model export small.json --as c -o small.h")]
struct ExportArguments {
    /// The model: a .json file of `anemo identify` or `anemo model`.
    model: PathBuf,
    #[arg(long = "as", value_name = "FORM", value_parser = choice([
        ("foster", "Resistor and capacitor of every pole, side by side and in series", ExportForm::Foster),
        ("cauer", "The ladder of resistors and capacitors with the same impedance", ExportForm::Cauer),
        ("spice", "A netlist: 1 V is 1 K, 1 A is 1 W", ExportForm::Spice(SpiceNetwork::Foster)),
        ("response", "Magnitude and phase of the thermal impedance over frequency", ExportForm::Response(0)),
        ("symbol", "The time-constant spectrum (diffusive symbol), discrete and continuous, with standard errors", ExportForm::Symbol),
        ("structure", "Cumulative structure function: heat capacity against resistance from the heater", ExportForm::Structure),
        ("c", "Constant tables in f32 for a C program", ExportForm::Source(Language::C)),
        ("rust", "Constant tables in f32 for a Rust program", ExportForm::Source(Language::Rust)),
    ]))]
    form: ExportForm,
    /// Pair, where the model has several: columns (power_w_a:temperature_c_b) or elements (a:b).
    #[arg(long, value_name = "INPUT:OUTPUT")]
    pair: Option<String>,
    /// Event class, where the model has several.
    #[arg(long, value_name = "LABEL")]
    class: Option<String>,
    /// Number of frequencies of a response.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    points: u32,
    /// Which network a netlist holds.
    #[arg(long, default_value = "foster", value_parser = choice([
        ("foster", "Resistor and capacitor side by side, in series: any model", SpiceNetwork::Foster),
        ("cauer", "A ladder: models without negative resistances", SpiceNetwork::Cauer),
    ]))]
    network: SpiceNetwork,
    /// Write to this file instead of stdout.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print one JSON object: the table, or the text.
    #[arg(long)]
    json: bool,
}

fn export_model(arguments: &ExportArguments) -> Result<(), Failure> {
    crate::output::keep(&[&arguments.model], &[arguments.output.as_deref()])?;
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let part = PairClass::find(&model, arguments.pair.as_deref(), arguments.class.as_deref())
        .map_err(|error| Failure::in_file(&arguments.model, error))?;
    let form = match arguments.form {
        ExportForm::Spice(_) => ExportForm::Spice(arguments.network),
        ExportForm::Response(_) => ExportForm::Response(arguments.points as usize),
        form => form,
    };
    let file = arguments.output.as_ref().map(|output| output.display().to_string());
    let report = ExportReport::new(&part, form, file).map_err(|error| Failure::in_file(&arguments.model, error))?;
    if let Some(output) = &arguments.output {
        crate::output::write_text(output, &report.text())?;
    }
    crate::output::print_report(&report, arguments.json)
}
