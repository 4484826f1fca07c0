//! `anemo example`: identification on systems whose answer is known.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::Failure;
use super::identify::progress_bar;
use crate::identify::candidates::{Beginning, Given};
use crate::identify::cole_cole::{self, Case, Comparison, Input};
use crate::identify::record::Table;
use crate::identify::{Options, identify};
use crate::model::Model;
use crate::plot::Canvas;
use crate::plot::model::{Chart, Lines};
use crate::recording;

/// Identify a system whose answer is known, and see how close it comes.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    example: Example,
}

#[derive(clap::Subcommand)]
enum Example {
    ColeCole(ColeCole),
}

/// Cole and Cole's relaxation, H = 1/(1 + √p): 1000 s at 2 kHz with an exact output, with or without noise.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo example cole-cole
  anemo example cole-cole --noise 0.1 --plot cole-cole.svg
  anemo example cole-cole --input step -o step.parquet --plot figures")]
struct ColeCole {
    /// What drives it: a step, or pseudo-random bits of 1 s.
    #[arg(long, value_enum, default_value = "prbs")]
    input: InputName,
    /// Standard deviation of white noise on the output; the output itself swings by 1.
    #[arg(long, value_name = "SIGMA", default_value_t = 0.0, value_parser = noise, allow_negative_numbers = true)]
    noise: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the record (time_s, u, y) to this file; its name ends in .parquet or .csv.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw symbol, output and errors into this file, or, if the name does not end in .svg, two pictures into this folder.
    #[arg(long, value_name = "SVG|FOLDER")]
    plot: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum InputName {
    Step,
    Prbs,
}

fn noise(text: &str) -> Result<f64, String> {
    let sigma = text.parse().ok().filter(|sigma: &f64| sigma.is_finite() && *sigma >= 0.0);
    sigma.ok_or_else(|| "a standard deviation is a number of at least 0".to_owned())
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.example {
        Example::ColeCole(arguments) => arguments.execute(),
    }
}

impl ColeCole {
    fn execute(&self) -> Result<(), Failure> {
        // What could only fail once the work is done is looked at first.
        if let Some(path) = &self.output {
            recording::check_name(path).map_err(Failure::usage)?;
        }
        let canvases = self.canvases()?;
        let input = match self.input {
            InputName::Step => Input::Step,
            InputName::Prbs => Input::Prbs,
        };
        let case = cole_cole::case(input, self.noise, self.seed, None);
        if let Some(path) = &self.output {
            self.write(&case, path)?;
        }
        let model = identified(&case, input)?;
        let comparison = cole_cole::compare(&model, &case).map_err(Failure::work)?;
        self.draw(canvases, &model, &case, input, &comparison)?;
        if self.json {
            return super::print_json(&serde_json::json!({
                "input": self.input_name(),
                "noise": self.noise,
                "seed": self.seed,
                "rows": case.input.len(),
                "sample_period_s": case.sample_period_s,
                "comparison": comparison,
                "model": model,
            }));
        }
        super::print(&self.summary(&model, &case, &comparison))
    }

    fn input_name(&self) -> &'static str {
        match self.input {
            InputName::Step => "step",
            InputName::Prbs => "prbs",
        }
    }

    fn write(&self, case: &Case, path: &Path) -> Result<(), Failure> {
        let metadata = [
            ("title", "Cole-Cole relaxation, H = 1/(1 + sqrt p)".to_owned()),
            ("input", self.input_name().to_owned()),
            ("noise", self.noise.to_string()),
            ("seed", self.seed.to_string()),
        ];
        let metadata = metadata.map(|(key, value)| (key.to_owned(), value)).to_vec();
        let columns = [("u", case.input.as_slice()), ("y", case.output.as_slice())];
        recording::write_columns(path, case.sample_period_s, &columns, &metadata).map_err(Failure::work)
    }

    /// The pictures that are going to be drawn: one of everything, or one of the symbol and one of the output.
    fn canvases(&self) -> Result<Vec<Canvas>, Failure> {
        let Some(path) = &self.plot else { return Ok(Vec::new()) };
        let is_picture = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
        if is_picture {
            return Ok(vec![Canvas::create(path).map_err(Failure::usage)?]);
        }
        let failed = |error| Failure::usage(format!("{}: cannot be made: {error}", path.display()));
        std::fs::create_dir_all(path).map_err(failed)?;
        let canvas = |name: &str| Canvas::create(&path.join(name)).map_err(Failure::usage);
        Ok(vec![canvas("symbol.svg")?, canvas("output.svg")?])
    }

    fn draw(
        &self,
        canvases: Vec<Canvas>,
        model: &Model,
        case: &Case,
        input: Input,
        comparison: &Comparison,
    ) -> Result<(), Failure> {
        if canvases.is_empty() {
            return Ok(());
        }
        let mut pages = vec![cole_cole::symbol_charts(comparison), cole_cole::output_charts(model, case, input)];
        if canvases.len() == 1 {
            pages = vec![pages.concat()];
        }
        for (canvas, charts) in canvases.into_iter().zip(pages) {
            let svg = self.figure(charts, model).svg().map_err(Failure::work)?;
            canvas.write(&svg).map_err(Failure::work)?;
        }
        Ok(())
    }

    fn figure(&self, charts: Vec<Chart>, model: &Model) -> Lines {
        let noise = if self.noise > 0.0 { format!("noise of {}", self.noise) } else { "no noise".to_owned() };
        let words = format!("{}, {noise}, {} rates", self.input_words(), rates(model));
        let figure = Lines::new("Cole–Cole relaxation").subtitle(words);
        charts.into_iter().fold(figure, |figure, chart| figure.row([chart]))
    }

    fn input_words(&self) -> &'static str {
        match self.input {
            InputName::Step => "unit step",
            InputName::Prbs => "pseudo-random bits of 1 s",
        }
    }

    fn summary(&self, model: &Model, case: &Case, comparison: &Comparison) -> String {
        let mut text = format!(
            "Cole–Cole relaxation, {}: {} rows, {} s apart, noise {}, seed {}\n\n",
            self.input_words(),
            case.input.len(),
            case.sample_period_s,
            self.noise,
            self.seed
        );
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  {:>12} {:>11} {:>11} {:>9} {:>10}",
            "rate rad/s", "exact", "identified", "error %", "± se"
        );
        for value in &comparison.symbol {
            let _ = writeln!(
                text,
                "{} {:>12.4e} {:>11.4e} {:>11.4e} {:>+9.2} {:>10.1e}",
                if value.interior { ' ' } else { '·' },
                value.rate_rad_s,
                value.exact,
                value.identified,
                100.0 * value.relative_error,
                value.se
            );
        }
        let _ = writeln!(
            text,
            "\nlargest error of the interior rates (without ·): {:.2} %",
            100.0 * comparison.largest_interior_error
        );
        let _ = writeln!(text, "negative values: {}", comparison.negative_values);
        let _ = writeln!(text, "output, from rest, to the exact one: {:.2e} rms", comparison.output_rmse);
        text.push_str("\nchosen:\n");
        for reason in &model.chosen.reasons {
            let _ = writeln!(text, "  {reason}");
        }
        for warning in &model.warnings {
            let _ = writeln!(text, "\nwarning: {warning}");
        }
        if let Some(path) = &self.output {
            let _ = writeln!(text, "\nrecord written to {}", path.display());
        }
        if let Some(path) = &self.plot {
            let _ = writeln!(text, "\ndrawn into {}", path.display());
        }
        text
    }
}

fn identified(case: &Case, input: Input) -> Result<Model, Failure> {
    // A step's record does not show that its input was 0 before: that it begins at rest has to be said.
    let beginning = (input == Input::Step).then_some(Beginning::Rest);
    let options = Options { given: Given { beginning, ..Given::default() }, ..Options::default() };
    let columns = |name: &str, values: &[f64]| vec![(name.to_owned(), values.to_vec())];
    let table = Table::new(case.sample_period_s, columns("u", &case.input), columns("y", &case.output));
    let mut table = table.map_err(Failure::work)?.named(Path::new("cole-cole"));
    Ok(identify(&mut table, &options, &mut progress_bar(), &mut |_| {})?)
}

fn rates(model: &Model) -> usize {
    model.pairs.first().map_or(0, |pair| pair.mesh_rad_s.len())
}

#[cfg(test)]
mod tests {
    use super::noise;

    #[test]
    fn noise_is_a_standard_deviation() {
        assert_eq!(noise("0.1"), Ok(0.1));
        assert_eq!(noise("0"), Ok(0.0));
        for text in ["-1", "nan", "inf", "much"] {
            assert!(noise(text).is_err(), "{text}");
        }
    }
}
