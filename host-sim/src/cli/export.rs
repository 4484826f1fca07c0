//! `anemo export`: a model in the forms that others use.

use std::path::PathBuf;

use super::Failure;
use crate::model::Model;
use crate::model::export::spice::Network;
use crate::model::export::{Part, source, spice, table};
use crate::recording::Temporary;

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
    form: Form,
    /// Which pair, where the model has several: by columns (power_w:a:temperature_c:b) or elements (a:b).
    #[arg(long, value_name = "INPUT:OUTPUT")]
    pair: Option<String>,
    /// Which event class, where the model has several.
    #[arg(long, value_name = "LABEL")]
    class: Option<String>,
    /// Number of frequencies of a response.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    points: u32,
    /// Which network a netlist holds.
    #[arg(long, value_enum, default_value = "foster")]
    network: Network,
    /// The file to write.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print one JSON object: the table, or the text.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Form {
    /// Resistor and capacitor of every pole, side by side and in series.
    Foster,
    /// The ladder of resistors and capacitors with the same impedance.
    Cauer,
    /// A netlist: 1 V is 1 K, 1 A is 1 W.
    Spice,
    /// Magnitude and phase over frequency.
    Response,
    /// The diffusive symbol, discrete and continuous, with standard errors.
    Symbol,
    /// Cumulative structure function: heat capacity against resistance from the heater.
    Structure,
    /// Constant tables in f32 for a C program.
    C,
    /// Constant tables in f32 for a Rust program.
    Rust,
}

enum Content {
    Table(table::Table),
    Text(String),
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let refuse = |sentence: String| Failure::usage(format!("{}: {sentence}", arguments.model.display()));
    let part = Part::find(&model, arguments.pair.as_deref(), arguments.class.as_deref()).map_err(refuse)?;
    let content = match arguments.form {
        Form::Foster => table::foster_table(&part).map(Content::Table),
        Form::Cauer => table::cauer_table(&part).map(Content::Table),
        Form::Spice => spice::netlist(&part, arguments.network).map(Content::Text),
        Form::Response => table::response_table(&part, arguments.points as usize).map(Content::Table),
        Form::Symbol => table::symbol_table(&part).map(Content::Table),
        Form::Structure => table::structure_table(&part).map(Content::Table),
        Form::C => source::source(&part, source::Language::C).map(Content::Text),
        Form::Rust => source::source(&part, source::Language::Rust).map(Content::Text),
    };
    let content = content.map_err(refuse)?;
    let text = match &content {
        Content::Table(table) => table.to_csv(),
        Content::Text(text) => text.clone(),
    };
    if let Some(output) = &arguments.output {
        let failed = |error| Failure::usage(format!("{}: cannot be written: {error}", output.display()));
        Temporary::write(output, text.as_bytes()).map_err(failed)?;
    }
    let file = arguments.output.as_ref().map(|output| output.display().to_string());
    if arguments.json {
        let mut object = serde_json::json!({
            "input": part.pair.input,
            "output": part.pair.output,
            "class": part.label,
            "file": file,
        });
        match content {
            Content::Table(table) => {
                object["columns"] = table.columns.into();
                object["rows"] = table.rows.into();
            }
            Content::Text(text) => object["text"] = text.into(),
        }
        return super::print_json(&object);
    }
    match file {
        Some(file) => {
            super::print(&format!("{} → {}, class {}: {file}\n", part.pair.input, part.pair.output, part.label))
        }
        None => super::print(&text),
    }
}
