//! `anemo merge`: models that were identified one source at a time, as one.

use std::fmt::Write as _;
use std::path::PathBuf;

use super::Failure;
use crate::model::Model;
use crate::model::merge::merge;

/// Join models of different pairs of input and output into one that adds up their answers.
///
/// For heads that were driven one after the other: identify each from its own record, with all outputs, and merge. Offsets and
/// residuals of an output that several models have are the first's; `anemo validate` estimates offsets anew.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo identify head0.csv --input power_w:0 --output temperature_c:0 temperature_c:1 -o 0.json
  anemo identify head1.csv --input power_w:1 --output temperature_c:0 temperature_c:1 -o 1.json
  anemo merge 0.json 1.json -o both.json
  anemo validate both.json together.csv")]
pub struct Arguments {
    /// The models: two or more .json files of `anemo identify`.
    #[arg(required = true, num_args = 2.., value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// The merged model, a .json file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print the model as one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mut models = Vec::with_capacity(arguments.models.len());
    for path in &arguments.models {
        models.push((path.display().to_string(), Model::read(path).map_err(Failure::usage)?));
    }
    let merged = merge(&models).map_err(Failure::usage)?;
    merged.write(&arguments.output).map_err(Failure::work)?;
    if arguments.json {
        return super::print_json(&merged);
    }
    let mut text = String::new();
    // Writing to a String cannot fail.
    for pair in &merged.pairs {
        for (label, class) in &pair.classes {
            let label = if merged.classes.len() > 1 { format!(", {label}") } else { String::new() };
            let (gain, se) = (class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
            let rates = pair.mesh_rad_s.len();
            let _ = writeln!(
                text,
                "{} → {}{label}: {rates} rates, steady gain {gain:.5} ± {se:.2}",
                pair.input, pair.output
            );
        }
    }
    for output in &merged.outputs {
        let _ = writeln!(text, "{}: offset {:.4}, of the first model that has it", output.name, output.offset_c);
    }
    for warning in &merged.warnings {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    let _ = writeln!(text, "\nmodel written to {}", arguments.output.display());
    super::print(&text)
}
