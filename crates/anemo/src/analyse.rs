//! `anemo analyse`: what a closed loop will do, from a model.

use std::path::PathBuf;

use crate::output::Failure;
use crate::picture::PictureArguments;
use diffusive::model::Model;
use diffusive::predict::analysis_report::{AnalysisReport, AnalysisRequest};
use plot::closed_loop;

/// Analyse a given loop on a model: does it hold, and how fast.
///
/// `design` chooses a loop from requirements. `analyse` examines one given loop at its set-point.
/// `predict` predicts the powers of a whole experiment.
///
/// In the limit of fast sampling the time constants of a loop at its set-point are the transmission
/// zeros of the model. One class of one pair is analysed, and every change of the wind from it. The
/// picture shows poles, zeros and the step response of the power.
#[derive(clap::Args)]
#[command(after_help = "\
The weight of a zero is its share of the power above the steady value, in units of that value, right \
after a jump of the temperature to the set-point. `changes` of --json has the weights of each change \
of the wind.

Settling after a change of the wind lasts until the power stays within 2 % of the change and, where a \
level limited the power, the temperature is back at its set-point. Settling after a step of the \
set-point begins at rest: first at the high level, then between the levels.

Examples:
  anemo analyse heater.json
  anemo analyse sectors.json --element sector1 --target 15 --low 0.0015 \\
      --high 0.042 --sample-period 0.01 --plot loop.svg
  anemo analyse winds.json --class still --json")]
pub struct Arguments {
    /// The model: a .json file of `anemo identify` or `anemo model`.
    model: PathBuf,
    /// Pair, where the model has several: columns (power_w_a:temperature_c_b) or elements (a:b).
    #[arg(long, value_name = "INPUT:OUTPUT", conflicts_with = "element")]
    pair: Option<String>,
    /// Self-heating pair of this element: short for --pair NAME:NAME.
    #[arg(long, value_name = "NAME")]
    element: Option<String>,
    /// Event class; by default the reference, or the first.
    #[arg(long, value_name = "LABEL")]
    class: Option<String>,
    /// Set-point, K above the temperature without heating; by default half-way between those that
    /// the levels can hold.
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    target: Option<f64>,
    /// Power of the low level, W; by default the least input of the identified record.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    low: Option<f64>,
    /// Power of the high level, W; by default the greatest input.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    high: Option<f64>,
    /// Sample period of the loop, s; by default the model's.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    sample_period: Option<f64>,
    /// Gas temperature, °C, where the wind is a conductance; by default the model's.
    #[arg(long, value_name = "°C", allow_negative_numbers = true)]
    gas_temperature: Option<f64>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    crate::output::finite(&[
        ("--target", arguments.target),
        ("--low", arguments.low),
        ("--high", arguments.high),
        ("--sample-period", arguments.sample_period),
        ("--gas-temperature", arguments.gas_temperature),
    ])?;
    let own = arguments.element.as_ref().map(|element| format!("{element}:{element}"));
    let request = AnalysisRequest {
        pair: arguments.pair.clone().or(own),
        class: arguments.class.clone(),
        target_k: arguments.target,
        power_low_w: arguments.low,
        power_high_w: arguments.high,
        sample_period_s: arguments.sample_period,
        gas_c: arguments.gas_temperature,
    };
    let report = AnalysisReport::new(&model, &request).map_err(|error| Failure::in_file(&arguments.model, error))?;
    if let Some(canvas) = arguments.picture.canvas()? {
        let figure = closed_loop::analysis_figure(&report.pair, &report.analysis, &report.changes);
        canvas.draw(&figure).map_err(Failure::work)?;
    }
    crate::output::print_report(&report, arguments.json)
}
