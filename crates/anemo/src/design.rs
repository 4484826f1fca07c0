//! `anemo design`: which loop meets requirements, by a model.

use std::path::PathBuf;

use crate::output::Failure;
use diffusive::design::{DesignReport, Requirements, design};
use diffusive::model::Model;
use diffusive::model::pair_class::PairClass;
use diffusive::predict::loop_model::{LoopModel, of_another_gas};

/// Choose levels, sample period and set-point of a loop on a model.
///
/// `design` chooses a loop from requirements. `analyse` examines one given loop at its set-point.
/// `predict` predicts the powers of a whole experiment.
///
/// The recommended loop is simulated on the model, and the result printed beside the prediction.
#[derive(clap::Args)]
#[command(after_help = "\
A requirement that cannot be met is refused, and the error names what can be met.

Examples:
  anemo design heater.json --target 20
  anemo design sectors.json --element sector1 --target 10..20 \\
      --low 0.0015 --high 0.042 --ripple 0.05
  anemo design winds.json --target 10 --wind still,gust --response 300 \\
      --reach 600 --json
  anemo design conductance.json --target 10 --conductance 0..0.01")]
pub struct Arguments {
    /// The model: a .json file of `anemo identify` or `anemo model`.
    model: PathBuf,
    /// Set-point, K above the temperature without heating (of the first wind), or a range that
    /// would do.
    #[arg(long, value_name = "K|LOW..HIGH", allow_hyphen_values = true)]
    target: String,
    /// Pair, where the model has several: columns (power_w_a:temperature_c_b) or elements (a:b).
    #[arg(long, value_name = "INPUT:OUTPUT", conflicts_with = "element")]
    pair: Option<String>,
    /// Self-heating pair of this element: short for --pair NAME:NAME.
    #[arg(long, value_name = "NAME")]
    element: Option<String>,
    /// Winds in which the loop holds its set-point; by default all classes of the model.
    #[arg(long, value_name = "LABEL,…", value_delimiter = ',', conflicts_with = "conductance")]
    wind: Vec<String>,
    /// Winds as a range of ΔG over the reference, W/K, where the wind is a conductance.
    #[arg(long, value_name = "LOW..HIGH", allow_hyphen_values = true)]
    conductance: Option<String>,
    /// Gas temperature, °C, where the wind is a conductance; by default the model's.
    #[arg(long, value_name = "°C", allow_negative_numbers = true)]
    gas_temperature: Option<f64>,
    /// Power of the low level, W; recommended if not given.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    low: Option<f64>,
    /// Power of the high level, W; recommended if not given.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    high: Option<f64>,
    /// Distance of the levels from the power of every wind, as a share of it.
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, allow_negative_numbers = true)]
    margin: f64,
    /// Greatest ripple of the temperature, from peak to peak, K.
    #[arg(long, value_name = "K", default_value_t = 0.1, allow_negative_numbers = true)]
    ripple: f64,
    /// Longest settling time of the power after a change of the wind, to within 2 %, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    response: Option<f64>,
    /// Longest time from rest to the set-point, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    reach: Option<f64>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let (first, last) = range("--target", &arguments.target)?;
    crate::output::finite(&[
        ("--low", arguments.low),
        ("--high", arguments.high),
        ("--margin", Some(arguments.margin)),
        ("--ripple", Some(arguments.ripple)),
        ("--response", arguments.response),
        ("--reach", arguments.reach),
        ("--gas-temperature", arguments.gas_temperature),
    ])?;
    let twice = arguments.wind.iter().enumerate().find(|(at, label)| arguments.wind[..*at].contains(label));
    if let Some((_, label)) = twice {
        return Err(Failure::usage(format!("--wind names `{label}` twice: once is enough")));
    }
    let (winds, pair, notes) =
        winds(arguments, &model).map_err(|failure| Failure::in_file(&arguments.model, failure))?;
    let wanted = Requirements {
        rise_k: (first, last),
        power_low_w: arguments.low,
        power_high_w: arguments.high,
        margin: arguments.margin,
        ripple_k: arguments.ripple,
        response_s: arguments.response,
        reach_s: arguments.reach,
    };
    let design = design(&winds, &wanted).map_err(|error| Failure::in_file(&arguments.model, error))?;
    let report = DesignReport { pair, design, notes };
    crate::output::print_report(&report, arguments.json)
}

/// One number, or two with `..` between them.
fn range(option: &str, text: &str) -> Result<(f64, f64), Failure> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let both = match text.split_once("..") {
        // Three dots could be two and a point.
        Some((_, last)) if last.starts_with('.') => None,
        Some((first, last)) => number(first).zip(number(last)),
        None => number(text).map(|only| (only, only)),
    };
    both.ok_or_else(|| {
        Failure::usage(format!("{option} is `{text}`: a number belongs there, or a range such as 10..40"))
    })
}

/// The winds that are requested, what the pair is called, and what a reader must know of it.
fn winds(arguments: &Arguments, model: &Model) -> Result<(Vec<LoopModel>, String, Vec<String>), Failure> {
    let named = arguments.element.as_ref().map(|element| format!("{element}:{element}"));
    let pair = arguments.pair.as_ref().or(named.as_ref()).map(String::as_str);
    let reference = model.wind.as_ref().map_or(&model.classes[0], |wind| &wind.reference);
    let part = PairClass::find(model, pair, Some(reference)).map_err(Failure::usage)?;
    let called = format!("{} → {}", part.pair.input, part.pair.output);
    part.refuse_cross_heating().map_err(Failure::usage)?;
    let late = part.pair.dead_time_samples;
    if late > 0 {
        return Err(Failure::usage(format!(
            "pair {called} has a dead time of {late} samples, in which the temperature runs on past its set-point, and which no design here allows for: identify it with --dead-time 0"
        )));
    }
    let notes =
        model.support_warning(Some(part.pair)).into_iter().chain(of_another_gas(model, arguments.gas_temperature));
    let notes = notes.collect();
    let Some(conductance) = &arguments.conductance else {
        let labels = if arguments.wind.is_empty() { &model.classes } else { &arguments.wind };
        let of = |label: &String| {
            let part = PairClass::find(model, pair, Some(label)).map_err(Failure::usage)?;
            LoopModel::of(&part, arguments.gas_temperature).map_err(Failure::usage)
        };
        return Ok((labels.iter().map(of).collect::<Result<_, Failure>>()?, called, notes));
    };
    if model.wind.is_none() {
        return Err(Failure::usage("the wind of this model is no conductance: name its classes with --wind"));
    }
    let (low, high) = range("--conductance", conductance)?;
    if low > high {
        return Err(Failure::usage(format!("--conductance is {conductance}: the first must be the smaller one")));
    }
    let of = |value: &f64| {
        let label = format!("ΔG = {value} W/K");
        LoopModel::of(&PairClass { label: &label, wind_w_per_k: Some(*value), ..part }, arguments.gas_temperature)
            .map_err(Failure::usage)
    };
    let values = if low == high { vec![low] } else { vec![low, high] };
    Ok((values.iter().map(of).collect::<Result<_, Failure>>()?, called, notes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_two_numbers_and_a_number_is_both() {
        assert_eq!(range("--target", "30"), Ok((30.0, 30.0)));
        assert_eq!(range("--target", "-1..40.5"), Ok((-1.0, 40.5)));
        for wrong in ["", "..", "10..", "a..b", "nan", "10...40"] {
            assert!(range("--target", wrong).unwrap_err().sentence.contains("a range such as 10..40"), "{wrong}");
        }
    }
}
