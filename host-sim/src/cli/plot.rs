//! `anemo plot`: a recording or a model as a picture.

use std::path::PathBuf;

use super::Failure;
use crate::model::Model;
use crate::plot::Canvas;
use crate::recording::Recording;

/// Draw a recording (wind, temperatures, powers and heater bits over time) or a model (symbols, frequency responses, structure
/// functions).
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  anemo plot gusts.parquet -o gusts.svg\n  anemo plot model.json -o model.svg")]
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
    let output = arguments.output.display().to_string();
    if arguments.file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        let model = Model::read(&arguments.file).map_err(Failure::usage)?;
        let canvas = Canvas::create(&arguments.output).map_err(Failure::usage)?;
        let svg = crate::plot::model::page(&model, &[]).map_err(Failure::usage)?;
        canvas.write(&svg).map_err(Failure::usage)?;
        let pairs = model.pairs.len();
        if arguments.json {
            return super::print_json(&serde_json::json!({ "plot": output, "pairs": pairs }));
        }
        let pairs = if pairs == 1 { "1 pair".to_owned() } else { format!("{pairs} pairs") };
        return super::print(&format!("model of {pairs} drawn into {output}\n"));
    }
    let recording = Recording::read(&arguments.file).map_err(Failure::usage)?;
    let canvas = Canvas::create(&arguments.output).map_err(Failure::usage)?;
    canvas.draw(&recording).map_err(Failure::usage)?;
    if arguments.json {
        return super::print_json(&serde_json::json!({ "plot": output, "rows": recording.len() }));
    }
    super::print(&format!("{} rows drawn into {output}\n", recording.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::export::testing;

    #[test]
    fn draws_a_model_and_refuses_what_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let (file, output) = (folder.path().join("model.json"), folder.path().join("model.svg"));
        testing::model(&[0.1, 1.0], &[3.0, 2.0]).write(&file).unwrap();
        execute(&Arguments { file: file.clone(), output: output.clone(), json: true }).unwrap();
        assert!(std::fs::read_to_string(&output).unwrap().contains("Symbol"));
        std::fs::write(&file, "{}").unwrap();
        assert!(execute(&Arguments { file, output, json: true }).is_err());
    }
}
