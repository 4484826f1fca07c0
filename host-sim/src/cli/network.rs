//! `anemo network`: the windless network of a head, from records in which one element after the other was driven.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::Failure;
use super::identify::progress_bar;
use super::network_summary::summary;
use crate::head::Head;
use crate::model::Model;
use crate::network::identified::{Poles, identified};
use crate::network::recorded::Recorded;
use crate::network::{Windless, reading_noise};
use crate::toml_file::Source;

/// Identify how all elements of a head heat themselves and each other in still gas: what wind is read off against.
///
/// One record an element: it is driven pseudo-randomly, all others stay at their low level, and the gas is still. Which one is driven is
/// found. Every pair gets as many free rates as its record can tell apart. The result is a model file like any other, whose offsets
/// are the temperatures with no heating at all.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  for e in sector1 sector2 sector3 sector4 core1 core2
  do anemo run experiments/wind/sphere-b/identify-$e.toml --on sim \\
      -o id-$e.parquet; done
  anemo network id-*.parquet -o network.json
  anemo network records/*.parquet --head my-sphere.toml -o network.json --json
  anemo network records/*.csv --cross-poles 3 -o network.json
  anemo network die*.parquet -o card1.json \\
      --elements card1-die1,card1-die2,card1-die3,card1-die4")]
pub struct Arguments {
    /// The records: one .parquet or .csv file an element.
    #[arg(required = true, value_name = "RECORD")]
    records: Vec<PathBuf>,
    /// The network, a .json file; without it, it is only summarised.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The head, which says what layers lie between elements and surface; by default the one that the records carry.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Elements of the network with commas between them, by default all of the head; what others do, which only measure, counts as part of the structure.
    #[arg(long, value_name = "ELEMENT", value_delimiter = ',')]
    elements: Vec<String>,
    /// Most free rates of an element's own heating.
    #[arg(long, value_name = "K", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=8))]
    own_poles: u8,
    /// Most free rates of the heating of one element by another.
    #[arg(long, value_name = "K", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=4))]
    cross_poles: u8,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let read: Vec<_> = arguments.records.iter().map(PathBuf::as_path).collect();
    super::keep(&read, &[arguments.output.as_deref()])?;
    if let Some(path) = &arguments.output {
        super::writable(path, "a network", "json")?;
    }
    let poles = Poles { own: usize::from(arguments.own_poles), cross: usize::from(arguments.cross_poles) };
    let open = |n: usize| {
        let record = Recorded::read(&arguments.records[n])?;
        if arguments.elements.is_empty() { Ok(record) } else { record.only(&arguments.elements) }
    };
    let head = head(arguments)?;
    let mut model = identified(arguments.records.len(), &open, poles, &mut progress_bar()).map_err(Failure::usage)?;
    let windless = match &head {
        None => {
            model.warnings.push(
                "the records carry no head: what lies between elements and surface is not known; name one with --head"
                    .to_owned(),
            );
            None
        }
        Some(head) => match Windless::of(&model, head) {
            Ok(windless) => Some(windless),
            Err(sentence) => {
                model.warnings.push(sentence);
                None
            }
        },
    };
    model.supported = model.warnings.is_empty();
    if let Some(path) = &arguments.output {
        model.write(path).map_err(Failure::work)?;
    }
    if arguments.json {
        return super::print_json(&described(&model, windless.as_ref(), head.as_ref()));
    }
    super::print(&summary(&model, windless.as_ref(), arguments.output.as_deref()))
}

/// The file that is named, or what the first record was made with.
fn head(arguments: &Arguments) -> Result<Option<Head>, Failure> {
    if let Some(path) = &arguments.head {
        return Ok(Some(Head::read(path)?));
    }
    let first = Recorded::read(&arguments.records[0]).map_err(Failure::usage)?;
    let Some(text) = first.head else { return Ok(None) };
    Ok(Some(Head::from_source(Source { path: format!("head in {}", first.name).into(), text })?))
}

fn described(model: &Model, windless: Option<&Windless>, head: Option<&Head>) -> Value {
    let noise = head.map(|head| reading_noise(model, head)).unwrap_or_default();
    let elements: Vec<Value> = windless.map_or_else(Vec::new, |windless| {
        let of = |own: &crate::network::windless::Own| {
            let layer = |section: &crate::network::ladder::Section| {
                json!({
                    "capacitance_j_per_k": section.capacitance_j_per_k,
                    "resistance_k_per_w": section.resistance_k_per_w,
                })
            };
            json!({
                "name": own.name,
                "rest_c": own.rest_c,
                "mesh_rad_s": own.mesh_rad_s,
                "r_k_per_w": own.r_k_per_w,
                "surface": own.surface,
                "layers": own.layers.iter().map(layer).collect::<Vec<_>>(),
                "contact_time_s": own.contact_time_s(),
                "noise_low_k": noise[own.element].low_k,
                "noise_high_k": noise[own.element].high_k,
            })
        };
        windless.own.iter().map(of).collect()
    });
    let gain = |pair: &crate::model::Pair| {
        let gain = pair.classes.values().next().map_or(0.0, |class| class.steady_gain_k_per_w);
        json!({ "input": pair.input, "output": pair.output, "rates": pair.mesh_rad_s.len(), "steady_gain_k_per_w": gain })
    };
    json!({
        "elements": elements,
        "pairs": model.pairs.iter().map(gain).collect::<Vec<_>>(),
        "outputs": model.outputs.iter().map(|output| json!({
            "name": output.name, "offset_c": output.offset_c, "residual_rms": output.residual_rms,
        })).collect::<Vec<_>>(),
        "reasons": model.chosen.reasons,
        "warnings": model.warnings,
        "supported": model.supported,
    })
}
