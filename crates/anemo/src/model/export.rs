//! `anemo model export`: a model in the forms that others use.

use std::path::PathBuf;

use crate::choice::choice;
use crate::output::Failure;
use diffusive::model::export::source::Language;
use diffusive::model::export::spice::SpiceNetwork;
use diffusive::model::export::{ExportForm, ExportReport};
use diffusive::model::{Model, PairClass};

/// Export a model as a network, a netlist, a table or source text.
#[derive(clap::Args)]
#[command(after_help = "\
Tables are CSV with units in their names; without -o the export goes to stdout.

Examples:
  anemo model export sector1.json --as foster --pair sector1:sector1
  anemo model export heater.json --as response --points 400 -o bode.csv
  anemo model export winds.json --as spice --network cauer --class gust -o gust.lib
  anemo model export small.json --as c -o small.h")]
pub struct Arguments {
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

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
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
