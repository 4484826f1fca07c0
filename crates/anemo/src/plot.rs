//! `anemo plot`: a recording or a model as a picture.

use std::path::PathBuf;

use crate::choice::choice;
use crate::output::{Failure, finite, keep, print_report};
use plot::{PictureFormat, PictureOptions, PictureWidth, TimeCrop};

/// Draw a recording or a model.
///
/// A recording gives wind, temperatures, powers and heater bits over time; a model time-constant
/// spectra, frequency responses and structure functions.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo plot gusts.parquet -o gusts.svg
  anemo plot gusts.parquet -o gust.pdf --width 88 --from 20 --to 40
  anemo plot sector1.json -o sector1.png
  anemo plot sector1.json -o bode.pdf --width 88 --panel magnitude phase")]
pub struct Arguments {
    /// The recording, a .parquet or .csv file, or the model, a .json file.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The picture: a .svg, .pdf or .png file, or what --format says.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: PathBuf,
    /// Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
    /// Type keeps its size.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    width: Option<PictureWidth>,
    /// Format of the picture, whatever its name.
    #[arg(long, value_parser = choice([("svg", "", PictureFormat::Svg), ("pdf", "", PictureFormat::Pdf), ("png", "300 dots an inch", PictureFormat::Png)]))]
    format: Option<PictureFormat>,
    /// Draw only the panels whose captions begin so: magnitude, phase.
    #[arg(long, value_name = "CAPTION", num_args = 1.., action = clap::ArgAction::Append)]
    panel: Vec<String>,
    /// Draw a recording from this time on, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Draw a recording until this time, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    finite(&[("--from", arguments.from), ("--to", arguments.to)])?;
    if let (Some(from), Some(to)) = (arguments.from, arguments.to)
        && from >= to
    {
        return Err(Failure::usage(format!("--from {from} must lie before --to {to}")));
    }
    keep(&[&arguments.file], &[Some(&arguments.output)])?;
    let panels = arguments.panel.clone();
    let options = PictureOptions { width: arguments.width, format: arguments.format, panels };
    let crop = TimeCrop { from_s: arguments.from, to_s: arguments.to };
    let report = plot::draw_file(&arguments.file, &arguments.output, options, crop).map_err(Failure::usage)?;
    print_report(&report, arguments.json)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use diffusive::model::testing;

    #[derive(Parser)]
    struct CommandLine {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn run(words: &str) -> Result<(), String> {
        let line = CommandLine::try_parse_from(words.split(' ')).map_err(|error| error.to_string())?;
        execute(&line.arguments).map_err(|failure| failure.sentence)
    }

    #[test]
    fn draws_a_model_and_refuses_what_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let [file, svg, odd] = ["model.json", "model.svg", "model.dat"].map(|name| folder.path().join(name));
        testing::model(&[0.1, 1.0], &[3.0, 2.0]).write(&file).unwrap();
        let plot = format!("plot {} --json -o", file.display());
        run(&format!("{plot} {} --width 88", svg.display())).unwrap();
        let drawn = std::fs::read_to_string(&svg).unwrap();
        assert!(drawn.starts_with("<svg width=\"88mm\"") && drawn.contains("Time-constant spectrum"));
        run(&format!("{plot} {} --format pdf", odd.display())).unwrap();
        assert!(std::fs::read(&odd).unwrap().starts_with(b"%PDF"));
        for (rest, sentence) in [
            ("--from 3", "is a model, whose axes are rates; a part of the time is drawn of recordings only"),
            ("--width 500", "a picture is 60 to 400 mm wide, not `500`"),
            ("--format gif", "[possible values: svg, pdf, png]"),
        ] {
            let error = run(&format!("{plot} {} {rest}", svg.display())).unwrap_err();
            assert!(error.contains(sentence), "{error}");
        }
        std::fs::write(&file, "{}").unwrap();
        assert!(run(&format!("{plot} {}", svg.display())).is_err());
    }

    #[test]
    fn draws_a_part_of_a_recording() {
        let folder = tempfile::tempdir().unwrap();
        let [file, svg] = ["probe.csv", "probe.svg"].map(|name| folder.path().join(name));
        let rows: String = (0..100).map(|n| format!("{n},{n}\n")).collect();
        std::fs::write(&file, format!("time_s,temperature_c_probe\n{rows}")).unwrap();
        let plot = format!("plot {} --json -o {}", file.display(), svg.display());
        run(&format!("{plot} --from 20 --to 39")).unwrap();
        assert!(std::fs::read_to_string(&svg).unwrap().contains("20 ticks"));
        let error = run(&format!("{plot} --from 20 --to 3")).unwrap_err();
        assert_eq!(error, "--from 20 must lie before --to 3");
        let error = run(&format!("{plot} --from 200")).unwrap_err();
        assert!(error.ends_with("has no row between these times; it lasts from 0 s to 99 s"), "{error}");
    }
}
