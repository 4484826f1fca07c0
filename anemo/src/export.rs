//! `anemo export`: a model in the forms that others use.

use std::path::PathBuf;

use crate::output::Failure;
use diffusive::model::export::{ExportForm, ExportReport, source, spice};
use diffusive::model::{Model, PairClass};
use recording::Temporary;

/// Write a model as a network, a netlist, a table or source text.
#[derive(clap::Args)]
#[command(after_help = "\
Tables are CSV with units in their names; without -o the export goes to stdout.

Examples:
  anemo export model.json --as response --points 400 -o bode.csv
  anemo export model.json --as foster --pair sector1:sector1
  anemo export model.json --as spice --network cauer --class gust -o model.lib
  anemo export model.json --as c -o model.h")]
pub struct Arguments {
    /// The model: a JSON file of `anemo identify` or `anemo reduce`.
    model: PathBuf,
    #[arg(long = "as", value_enum, value_name = "FORM")]
    form: FormOption,
    /// Which pair, where the model has several: by columns (power_w_a:temperature_c_b) or elements
    /// (a:b).
    #[arg(long, value_name = "INPUT:OUTPUT")]
    pair: Option<String>,
    /// Which event class, where the model has several.
    #[arg(long, value_name = "LABEL")]
    class: Option<String>,
    /// Number of frequencies of a response.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    points: u32,
    /// Which network a netlist holds.
    #[arg(long, value_enum, default_value_t = NetworkOption::Foster)]
    network: NetworkOption,
    /// The file to write.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print one JSON object: the table, or the text.
    #[arg(long)]
    json: bool,
}

/// What a netlist holds.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum NetworkOption {
    /// Resistor and capacitor side by side, in series: any model.
    Foster,
    /// A ladder: models without negative resistances.
    Cauer,
}

impl From<NetworkOption> for spice::SpiceNetwork {
    fn from(network: NetworkOption) -> Self {
        match network {
            NetworkOption::Foster => Self::Foster,
            NetworkOption::Cauer => Self::Cauer,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum FormOption {
    /// Resistor and capacitor of every pole, side by side and in series.
    Foster,
    /// The ladder of resistors and capacitors with the same impedance.
    Cauer,
    /// A netlist: 1 V is 1 K, 1 A is 1 W.
    Spice,
    /// Magnitude and phase of the thermal impedance over frequency.
    Response,
    /// The time-constant spectrum (diffusive symbol), discrete and continuous, with standard
    /// errors.
    Symbol,
    /// Cumulative structure function: heat capacity against resistance from the heater.
    Structure,
    /// Constant tables in f32 for a C program.
    C,
    /// Constant tables in f32 for a Rust program.
    Rust,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let part = PairClass::find(&model, arguments.pair.as_deref(), arguments.class.as_deref())
        .map_err(|error| Failure::in_file(&arguments.model, error))?;
    let form = match arguments.form {
        FormOption::Foster => ExportForm::Foster,
        FormOption::Cauer => ExportForm::Cauer,
        FormOption::Spice => ExportForm::Spice(arguments.network.into()),
        FormOption::Response => ExportForm::Response(arguments.points as usize),
        FormOption::Symbol => ExportForm::Symbol,
        FormOption::Structure => ExportForm::Structure,
        FormOption::C => ExportForm::Source(source::Language::C),
        FormOption::Rust => ExportForm::Source(source::Language::Rust),
    };
    let file = arguments.output.as_ref().map(|output| output.display().to_string());
    let report = ExportReport::new(&part, form, file).map_err(|error| Failure::in_file(&arguments.model, error))?;
    if let Some(output) = &arguments.output {
        let failed = |error| Failure::in_file(output, format!("cannot be written: {error}"));
        Temporary::write(output, report.text().as_bytes()).map_err(failed)?;
    }
    if arguments.json {
        return crate::output::print_json(&report);
    }
    crate::output::print(&report.to_string())
}
