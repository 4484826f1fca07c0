//! `anemo plot`: a recording or a model as a picture.

use std::path::PathBuf;

use crate::output::{Failure, print_report};
use plot::{PictureOptions, TimeCrop};

/// Draw a recording (wind, temperatures, powers and heater bits over time) or a model
/// (time-constant spectra, frequency responses, structure functions).
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  anemo plot gusts.parquet -o gusts.svg\n  anemo plot sector1.json -o sector1.svg")]
pub struct Arguments {
    /// The recording, a .parquet or .csv file, or the model, a .json file.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The picture; its name ends in .svg.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let report = plot::draw_file(&arguments.file, &arguments.output, PictureOptions::default(), TimeCrop::default())
        .map_err(Failure::usage)?;
    print_report(&report, arguments.json)
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffusive::model::testing;

    #[test]
    fn draws_a_model_and_refuses_what_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let (file, output) = (folder.path().join("model.json"), folder.path().join("model.svg"));
        testing::model(&[0.1, 1.0], &[3.0, 2.0]).write(&file).unwrap();
        execute(&Arguments { file: file.clone(), output: output.clone(), json: true }).unwrap();
        assert!(std::fs::read_to_string(&output).unwrap().contains("Time-constant spectrum"));
        std::fs::write(&file, "{}").unwrap();
        assert!(execute(&Arguments { file, output, json: true }).is_err());
    }
}
