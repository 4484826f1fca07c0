//! `anemo example`: identification on systems whose answer is known.

use std::path::{Path, PathBuf};

use crate::choice::choice;
use crate::output::Failure;
use crate::picture::PictureArguments;
use crate::progress::progress_bar;
use diffusive::identify::cole_cole::{self, ColeColeCase, ColeColeComparison, ColeColeInput, ColeColeReport};
use diffusive::identify::record::RecordTable;
use diffusive::identify::{Constraints, InitialState};
use diffusive::identify::{IdentifyOptions, identify};
use diffusive::model::Model;
use plot::{Canvas, Chart, Figure, PictureFormat};

/// Identify a system that is known exactly, and report the errors.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    example: ExampleSystem,
}

#[derive(clap::Subcommand)]
enum ExampleSystem {
    ColeCole(ColeCole),
}

/// Cole and Cole's relaxation, H = 1/(1 + √p): 1000 s at 2 kHz with an exact output, with or
/// without noise.
///
/// The picture shows time-constant spectrum, output and errors; another name of --plot is a folder
/// for two pictures.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo example cole-cole
  anemo example cole-cole --noise 0.1 --plot cole-cole.svg
  anemo example cole-cole --input step -o step.parquet --plot figures")]
struct ColeCole {
    /// Its input: a step, or pseudo-random bits of 1 s.
    #[arg(long, default_value = "prbs", value_parser = choice([("step", "", ColeColeInput::Step), ("prbs", "", ColeColeInput::Prbs)]))]
    input: ColeColeInput,
    /// Standard deviation of white noise on the output, which swings by 1.
    #[arg(long, value_name = "SIGMA", default_value_t = 0.0, value_parser = noise, allow_negative_numbers = true)]
    noise: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the record (time_s, u, y) to this .parquet or .csv file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

fn noise(text: &str) -> Result<f64, Failure> {
    let sigma = text.parse().ok().filter(|sigma: &f64| sigma.is_finite() && *sigma >= 0.0);
    sigma.ok_or_else(|| Failure::usage("a standard deviation is a number of at least 0"))
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let ExampleSystem::ColeCole(arguments) = &arguments.example;
    arguments.execute()
}

impl ColeCole {
    fn execute(&self) -> Result<(), Failure> {
        // What could only fail once the work is done is looked at first.
        if let Some(path) = &self.output {
            recording::check_name(path).map_err(Failure::usage)?;
        }
        let canvases = self.canvases()?;
        let case = cole_cole::case(self.input, self.noise, self.seed, None);
        if let Some(path) = &self.output {
            self.write(&case, path)?;
        }
        let model = identified(&case, self.input)?;
        let comparison = cole_cole::compare(&model, &case).map_err(Failure::work)?;
        self.draw(canvases, &model, &case, &comparison)?;
        let report = ColeColeReport {
            input: self.input,
            noise: self.noise,
            seed: self.seed,
            rows: case.input.len(),
            sample_period_s: case.sample_period_s,
            comparison,
            model,
        };
        crate::output::print_report(&report, self.json)?;
        if self.json { Ok(()) } else { crate::output::print(&self.written()) }
    }

    fn write(&self, case: &ColeColeCase, path: &Path) -> Result<(), Failure> {
        let metadata = [
            ("title", "Cole-Cole relaxation, H = 1/(1 + sqrt p)".to_owned()),
            ("input", if self.input == ColeColeInput::Step { "step" } else { "prbs" }.to_owned()),
            ("noise", self.noise.to_string()),
            ("seed", self.seed.to_string()),
        ];
        let metadata = metadata.map(|(key, value)| (key.to_owned(), value)).to_vec();
        let columns = [("u", case.input.as_slice()), ("y", case.output.as_slice())];
        recording::write_columns(path, case.sample_period_s, &columns, &metadata).map_err(Failure::work)
    }

    /// The pictures that are going to be drawn: one of everything, or one of the symbol and one of
    /// the output.
    fn canvases(&self) -> Result<Vec<Canvas>, Failure> {
        let Some(path) = self.picture.path() else { return Ok(Vec::new()) };
        if PictureFormat::of(path).is_ok() {
            return Ok(vec![self.picture.canvas_in(path)?]);
        }
        let failed = |error| Failure::in_file(path, format!("cannot be made: {error}"));
        std::fs::create_dir_all(path).map_err(failed)?;
        let canvas = |name: &str| self.picture.canvas_in(&path.join(name));
        Ok(vec![canvas("symbol.svg")?, canvas("output.svg")?])
    }

    fn draw(
        &self,
        canvases: Vec<Canvas>,
        model: &Model,
        case: &ColeColeCase,
        comparison: &ColeColeComparison,
    ) -> Result<(), Failure> {
        if canvases.is_empty() {
            return Ok(());
        }
        let mut pages =
            vec![plot::cole_cole::spectrum_charts(comparison), plot::cole_cole::output_charts(model, case, self.input)];
        if canvases.len() == 1 {
            pages = vec![pages.concat()];
        }
        for (canvas, charts) in canvases.into_iter().zip(pages) {
            canvas.draw(&self.figure(charts, model)).map_err(Failure::work)?;
        }
        Ok(())
    }

    fn figure(&self, charts: Vec<Chart>, model: &Model) -> Figure {
        let noise = if self.noise > 0.0 { format!("noise of {}", self.noise) } else { "no noise".to_owned() };
        let words = format!("{}, {noise}, {} rates", self.input.words(), rates(model));
        Figure::new("Cole–Cole relaxation").subtitle(words).stack(charts)
    }

    /// Which files were written.
    fn written(&self) -> String {
        let said = |what: &str, path: Option<&Path>| {
            path.map_or(String::new(), |path| format!("\n{what} {}\n", path.display()))
        };
        said("record written to", self.output.as_deref()) + &said("drawn into", self.picture.path())
    }
}

fn identified(case: &ColeColeCase, input: ColeColeInput) -> Result<Model, Failure> {
    // A step's record does not show that its input was 0 before: that it begins at rest has to be
    // said.
    let initial_state = (input == ColeColeInput::Step).then_some(InitialState::Rest);
    let options = IdentifyOptions {
        constraints: Constraints { initial_state, ..Constraints::default() },
        ..IdentifyOptions::default()
    };
    let columns = |name: &str, values: &[f64]| vec![(name.to_owned(), values.to_vec())];
    let table = RecordTable::new(case.sample_period_s, columns("u", &case.input), columns("y", &case.output));
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
