//! `anemo head identify`: the thermal network of a head, from records.

use std::path::PathBuf;

use crate::output::{Failure, warn};
use crate::progress::progress;
use anemometry::head::Head;
use anemometry::network::NetworkReport;
use anemometry::network::from_model::checked;
use anemometry::network::identify::{PolesPerPair, identify};
use anemometry::network::record::QuiescentRecord;
use recording::toml_file::TomlSource;

/// Identify how all elements of a head heat themselves and each other in quiescent gas.
///
/// Convective losses are measured against this quiescent-gas network. It takes one record an
/// element, in gas at rest: the element driven pseudo-randomly, all others at their low level.
/// Every pair gets as many free rates as its record resolves. The result is a model, whose offsets
/// are the temperatures without heating.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  for e in sector1 sector2 sector3 sector4 core1 core2
  do anemo run experiments/wind/sphere-b/identify-$e.toml --on sim \\
      -o id-$e.parquet; done
  anemo head identify id-*.parquet -o network.json
  anemo head identify id-*.parquet --head heads/sphere-b.toml \\
      --cross-poles 3 --json

  for die in die1 die2 die3 die4
  do anemo run experiments/wind/rems/identify-$die.toml --on sim \\
      -o $die.parquet; done
  anemo head identify die*.parquet -o card1.json \\
      --elements card1-die1,card1-die2,card1-die3,card1-die4")]
pub struct IdentifyArguments {
    /// The records: one .parquet or .csv file an element, in any order.
    #[arg(required = true, value_name = "RECORD")]
    records: Vec<PathBuf>,
    /// Write the network to this .json file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    /// The head, with the number of layers between elements and surface; by default that of the
    /// records.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Elements of the network, with commas between them; by default all but `reference` and those
    /// that only sense. The others, which only measure, are part of the structure.
    #[arg(long, value_name = "ELEMENT", value_delimiter = ',')]
    elements: Vec<String>,
    /// Most free rates of the self-heating of an element, 1 to 8.
    #[arg(long, value_name = "K", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=8))]
    own_poles: u8,
    /// Most free rates of the cross-heating of one element by another, 1 to 4.
    #[arg(long, value_name = "K", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=4))]
    cross_poles: u8,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn identify_network(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let read: Vec<_> = arguments.records.iter().map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[arguments.output.as_deref()])?;
    if let Some(path) = &arguments.output {
        crate::output::writable(path, "a network", "json")?;
    }
    let poles = PolesPerPair { own: usize::from(arguments.own_poles), cross: usize::from(arguments.cross_poles) };
    let head = head(arguments)?;
    let senses: Vec<String> = head
        .iter()
        .flat_map(|head| &head.elements)
        .filter(|of| of.only_senses)
        .map(|of| recording::in_columns(&of.name))
        .chain([recording::REFERENCE.to_owned()])
        .collect();
    let open = |n: usize| {
        let record = QuiescentRecord::read(&arguments.records[n])?;
        let wanted: Vec<String> = match &arguments.elements[..] {
            [] => record.elements.iter().filter(|name| !senses.contains(name)).cloned().collect(),
            named => named.to_vec(),
        };
        record.only(&wanted)
    };
    // Shown before the first pair, which follows a fit of all pairs of its record.
    let bar = progress("reading", Some(1));
    let mut show = |what, done, all| {
        bar.set_message(what);
        bar.set_length(all);
        bar.set_position(done);
    };
    let found = identify(arguments.records.len(), &open, poles, &mut show);
    bar.finish_and_clear();
    let mut model = found.map_err(Failure::usage)?;
    let network = checked(&mut model, head.as_ref());
    if let Some(path) = &arguments.output {
        model.write(path).map_err(Failure::work)?;
    }
    model.warnings.iter().for_each(|warning| warn(warning));
    let mut report = NetworkReport::new(&model, network.as_ref());
    report.written.clone_from(&arguments.output);
    crate::output::print_report(&report, arguments.json)
}

/// The named file, or the head that the first record carries.
fn head(arguments: &IdentifyArguments) -> Result<Option<Head>, Failure> {
    if let Some(path) = &arguments.head {
        return Ok(Some(Head::read(path)?));
    }
    let first = QuiescentRecord::read(&arguments.records[0]).map_err(Failure::usage)?;
    let Some(text) = first.head else { return Ok(None) };
    Ok(Some(Head::from_source(TomlSource { path: format!("head in {}", first.name).into(), text })?))
}
