//! `anemo design`: which loop a model and a wish ask for.

use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::Failure;
use super::analyse::own_heat;
use crate::design::{Design, Wish, design};
use crate::model::Model;
use crate::model::export::part::Part;
use crate::predict::windy::{Windy, of_another_gas};

/// Recommend levels, sample period and set-point for a closed loop, from a model and a wish.
///
/// The loop is tried once on the model, and what came out stands beside what was predicted.
#[derive(clap::Args)]
#[command(after_help = "\
A wish that cannot be met is refused, with what could be had. Levels that a head has already are given with --low and --high; others
are recommended.

Examples:
  anemo design model.json --target 30
  anemo design model.json --target 10..40 --low 0.0015 --high 0.042 --ripple 0.05
  anemo design model.json --element sector1 --target 30 --wind still,gust --response 5 --reach 60 --json
  anemo design model.json --target 30 --conductance 0..0.01 --gas-temperature -53.15")]
pub struct Arguments {
    /// The model: a JSON file of `anemo identify`.
    model: PathBuf,
    /// The set-point in K above the temperature without heating (of the first wind), or a range of those that would do.
    #[arg(long, value_name = "K|LOW..HIGH", allow_hyphen_values = true)]
    target: String,
    /// The pair of input and output, as `sector1:sector1`, where the model has several.
    #[arg(long, value_name = "INPUT:OUTPUT", conflicts_with = "element")]
    pair: Option<String>,
    /// The element whose own pair is meant: short for `--pair NAME:NAME`.
    #[arg(long, value_name = "NAME")]
    element: Option<String>,
    /// The winds to be ready for: all classes of the model if not given.
    #[arg(long, value_name = "LABEL,…", value_delimiter = ',', conflicts_with = "conductance")]
    wind: Vec<String>,
    /// The winds as a range of ΔG in W/K over the reference, of a model in which the wind is a conductance.
    #[arg(long, value_name = "LOW..HIGH", allow_hyphen_values = true)]
    conductance: Option<String>,
    /// Temperature of the gas, °C, where the wind is a conductance: the model's own if not given.
    #[arg(long, value_name = "°C", allow_negative_numbers = true)]
    gas_temperature: Option<f64>,
    /// Power of the low level, W, if it is given.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    low: Option<f64>,
    /// Power of the high level, W, if it is given.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    high: Option<f64>,
    /// How far the levels stay from the power of every wind, as a share of it.
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, allow_negative_numbers = true)]
    margin: f64,
    /// By how much the temperature may swing, from peak to peak, K.
    #[arg(long, value_name = "K", default_value_t = 0.1, allow_negative_numbers = true)]
    ripple: f64,
    /// In what time the power shall show a change of the wind to within 2 %, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    response: Option<f64>,
    /// In what time the set-point shall be reached from rest, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    reach: Option<f64>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let refuse = |sentence: String| Failure::usage(format!("{}: {sentence}", arguments.model.display()));
    let (first, last) = range("--target", &arguments.target).map_err(Failure::usage)?;
    super::finite(&[
        ("--low", arguments.low),
        ("--high", arguments.high),
        ("--margin", Some(arguments.margin)),
        ("--ripple", Some(arguments.ripple)),
        ("--response", arguments.response),
        ("--reach", arguments.reach),
        ("--gas-temperature", arguments.gas_temperature),
    ])
    .map_err(Failure::usage)?;
    let twice = arguments.wind.iter().enumerate().find(|(at, label)| arguments.wind[..*at].contains(label));
    if let Some((_, label)) = twice {
        return Err(Failure::usage(format!("--wind names `{label}` twice: once is enough")));
    }
    let (winds, Chosen { pair, notes }) = winds(arguments, &model).map_err(refuse)?;
    let wish = Wish {
        rise_k: (first, last),
        power_low_w: arguments.low,
        power_high_w: arguments.high,
        margin: arguments.margin,
        ripple_k: arguments.ripple,
        response_s: arguments.response,
        reach_s: arguments.reach,
    };
    let found = design(&winds, &wish).map_err(refuse)?;
    if arguments.json {
        return super::print_json(&as_json(&pair, &found, &notes));
    }
    super::print(&summary(&pair, &found, &notes))
}

/// One number, or two with `..` between them.
fn range(option: &str, text: &str) -> Result<(f64, f64), String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let both = match text.split_once("..") {
        // Three dots could be two and a point.
        Some((_, last)) if last.starts_with('.') => None,
        Some((first, last)) => number(first).zip(number(last)),
        None => number(text).map(|only| (only, only)),
    };
    both.ok_or_else(|| format!("{option} is `{text}`: a number belongs there, or a range such as 10..40"))
}

/// What the pair is called, and what is to be said of it.
struct Chosen {
    pair: String,
    notes: Vec<String>,
}

/// The winds that were asked for, and of what.
fn winds(arguments: &Arguments, model: &Model) -> Result<(Vec<Windy>, Chosen), String> {
    let named = arguments.element.as_ref().map(|element| format!("{element}:{element}"));
    let pair = arguments.pair.as_ref().or(named.as_ref()).map(String::as_str);
    let reference = model.wind.as_ref().map_or(&model.classes[0], |wind| &wind.reference);
    let part = Part::find(model, pair, Some(reference))?;
    let called = format!("{} → {}", part.pair.input, part.pair.output);
    own_heat(&part)?;
    let late = part.pair.dead_time_samples;
    if late > 0 {
        return Err(format!(
            "pair {called} has a dead time of {late} samples, in which the temperature runs on past its set-point, and which no design here allows for: identify it with --dead-time 0"
        ));
    }
    let notes = model.doubt(Some(part.pair)).into_iter().chain(of_another_gas(model, arguments.gas_temperature));
    let chosen = Chosen { pair: called, notes: notes.collect() };
    let Some(conductance) = &arguments.conductance else {
        let labels = if arguments.wind.is_empty() { &model.classes } else { &arguments.wind };
        let of = |label: &String| Windy::of(&Part::find(model, pair, Some(label))?, arguments.gas_temperature);
        return Ok((labels.iter().map(of).collect::<Result<_, String>>()?, chosen));
    };
    if model.wind.is_none() {
        return Err("the wind of this model is no conductance: name its classes with --wind".to_owned());
    }
    let (low, high) = range("--conductance", conductance)?;
    if low > high {
        return Err(format!("--conductance is {conductance}: the first must be the smaller one"));
    }
    let of = |value: &f64| {
        let label = format!("ΔG = {value} W/K");
        Windy::of(&Part { label: &label, wind_w_per_k: Some(*value), ..part }, arguments.gas_temperature)
    };
    let values = if low == high { vec![low] } else { vec![low, high] };
    Ok((values.iter().map(of).collect::<Result<_, String>>()?, chosen))
}

fn summary(pair: &str, found: &Design, notes: &[String]) -> String {
    // Writing to a String cannot fail.
    let mut text = format!(
        "{pair}\n\nset-point      {:.3} °C, {:.4} K above the temperature without heating\nlow level      {:.5} W\nhigh level     {:.5} W\nsample period  {} s\nresolution     {:.3e} W, averaged over {} s\n\n",
        found.target_c,
        found.rise_k,
        found.power_low_w,
        found.power_high_w,
        found.sample_period_s,
        found.resolution_w,
        found.window_s
    );
    for reason in &found.reasons {
        let _ = writeln!(text, "{reason}");
    }
    let width = found.winds.iter().map(|wind| wind.label.chars().count()).max().unwrap_or(0).max("wind".len());
    let _ = writeln!(
        text,
        "\n{:width$}  {:>10}  {:>10}  {:>9}  {:>9}  {:>10}  {:>10}  {:>9}  {:>9}",
        "wind", "power W", "tried W", "to low W", "to high W", "reached s", "tried s", "swing K", "tried K"
    );
    for wind in &found.winds {
        let tried_s = wind.trial.reaching_time_s.map_or("never".to_owned(), |time_s| format!("{time_s:.3}"));
        let _ = writeln!(
            text,
            "{:width$}  {:>10.6}  {:>10.6}  {:>9.5}  {:>9.5}  {:>10.3}  {tried_s:>10}  {:>9.4}  {:>9.4}",
            wind.label,
            wind.steady_power_w,
            wind.trial.mean_power_w,
            wind.margins_w.0,
            wind.margins_w.1,
            wind.reaching_time_s,
            wind.chatter_k,
            wind.trial.swing_k
        );
    }
    text.push_str(
        "\nThe swing is a bound to first order in the fastest pole and without reading noise, which adds to it.\n",
    );
    for note in notes {
        let _ = writeln!(text, "{note}");
    }
    text
}

fn as_json(pair: &str, found: &Design, notes: &[String]) -> Value {
    let wind = |wind: &crate::design::InWind| {
        let of = json!({
            "steady_power_w": wind.steady_power_w,
            "margins_w": [wind.margins_w.0, wind.margins_w.1],
            "reaching_time_s": wind.reaching_time_s,
            "chatter_k": wind.chatter_k,
            "trial": {
                "mean_power_w": wind.trial.mean_power_w,
                "reaching_time_s": wind.trial.reaching_time_s,
                "swing_k": wind.trial.swing_k,
            },
        });
        (wind.label.clone(), of)
    };
    json!({
        "pair": pair,
        "target_c": found.target_c,
        "rise_k": found.rise_k,
        "power_low_w": found.power_low_w,
        "power_high_w": found.power_high_w,
        "sample_period_s": found.sample_period_s,
        "resolution_w": found.resolution_w,
        "window_s": found.window_s,
        "settling_s": found.settling_s,
        "winds": found.winds.iter().map(wind).collect::<serde_json::Map<_, _>>(),
        "reasons": found.reasons,
        "notes": notes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_two_numbers_and_a_number_is_both() {
        assert_eq!(range("--target", "30"), Ok((30.0, 30.0)));
        assert_eq!(range("--target", "-1..40.5"), Ok((-1.0, 40.5)));
        for wrong in ["", "..", "10..", "a..b", "nan", "10...40"] {
            assert!(range("--target", wrong).unwrap_err().contains("a range such as 10..40"), "{wrong}");
        }
    }
}
