//! `anemo plot`: a recording as a picture.

use std::path::PathBuf;

use super::Failure;
use crate::plot::Canvas;
use crate::recording::Recording;

/// Draw a recording: wind, temperatures, powers and heater bits over time.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  anemo plot gusts.parquet -o gusts.svg")]
pub struct Arguments {
    /// The recording: a .parquet or .csv file.
    recording: PathBuf,
    /// The picture; its name ends in .svg.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let recording = Recording::read(&arguments.recording).map_err(Failure::usage)?;
    let canvas = Canvas::create(&arguments.output).map_err(Failure::usage)?;
    canvas.draw(&recording).map_err(Failure::usage)?;
    let output = arguments.output.display().to_string();
    if arguments.json {
        return super::print_json(&serde_json::json!({ "plot": output, "rows": recording.len() }));
    }
    super::print(&format!("{} rows drawn into {output}\n", recording.len()))
}
