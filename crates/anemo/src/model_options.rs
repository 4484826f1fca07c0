//! Options of a model that is identified.

use crate::options::{Columns, at_least_one, choice};
use crate::output::Failure;
use diffusive::identify::record::{Selection, Survey};
use diffusive::identify::{Constraints, DriftGiven, DriftKind, GasGiven, IdentifyOptions, InitialState, Losses, Signs};
use diffusive::model::Structure;

/// Columns, structure and constraints of a model.
#[derive(clap::Args)]
pub struct ModelOptions {
    #[command(flatten)]
    columns: Columns,
    /// `symbol`: a time-constant spectrum a class; `conductance`: one spectrum, and a conductance a
    /// class.
    #[arg(long, value_parser = choice([("symbol", "", Structure::Symbol), ("conductance", "", Structure::Conductance)]))]
    structure: Option<Structure>,
    /// Gas temperature for --structure conductance, °C, or its column; estimated if not given.
    #[arg(long, value_name = "°C|COLUMN", allow_hyphen_values = true)]
    gas_temperature: Option<String>,
    /// Measured temperature of the surroundings, which the output follows with relaxations of its
    /// own: a column in °C. For structure `symbol`.
    #[arg(long, value_name = "COLUMN", conflicts_with_all = ["gas_temperature", "free_poles", "tie"])]
    ambient: Option<String>,
    /// Class from whose conductance the others are counted; by default the least.
    #[arg(long, value_name = "LABEL")]
    reference: Option<String>,
    /// Number of rates, 100 at most.
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = rates)]
    order: Option<usize>,
    /// Edges of the logarithmic grid of rates (diffusive mesh), rad/s.
    #[arg(long, value_name = "FIRST:LAST", value_parser = edges)]
    mesh: Option<(f64, f64)>,
    /// Ridge on columns of unit norm; 0 for plain least squares.
    #[arg(long, value_name = "EPSILON", allow_negative_numbers = true)]
    ridge: Option<f64>,
    /// Resistances that may not be negative: `auto` (unless cross-validation rejects it; none, of
    /// structure `conductance`), `all`, `none`, or pairs as INPUT:OUTPUT,….
    #[arg(long, value_name = "PAIRS", default_value = "auto")]
    non_negative: String,
    /// Initial state of the record; chosen if not given.
    #[arg(long, value_parser = choice([
        ("rest", "All states zero", InitialState::Rest),
        ("settled", "As if the first row's inputs had been held for ever", InitialState::Settled),
        ("free", "Anything", InitialState::Free),
    ]))]
    initial_state: Option<InitialState>,
    /// Whether the output may follow its input at once. This and --dead-time are searched for,
    /// unless both --order and --mesh are given.
    #[arg(long, value_name = "yes|no", value_parser = yes_or_no)]
    feed_through: Option<bool>,
    /// Samples by which the output is late, the same for all inputs.
    #[arg(long, value_name = "SAMPLES", allow_negative_numbers = true, value_parser = samples)]
    dead_time: Option<usize>,
    /// Number of free rates of an output, 1 to 8, for a small model; the fit starts from that on
    /// the grid.
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = at_least_one, conflicts_with = "tie")]
    free_poles: Option<usize>,
    /// Reciprocal pairs: resistances from input i to output j are those from input j to output i.
    #[arg(long)]
    tie: bool,
    /// Losses that grow with temperature: power less g (T − T₀)², T₀ being the temperature without
    /// heating.
    #[arg(long, default_value = "auto", value_parser = choice([
        ("none", "Heat is lost in proportion to temperature", Losses::None),
        ("growing", "g ≥ 0 of every element is estimated", Losses::Growing),
        ("auto", "As `growing` where the record leaves no doubt, else as `none`", Losses::Auto),
    ]))]
    losses: Losses,
    /// Whether the offset moves, as a room's temperature does.
    #[arg(long, value_name = "KIND", default_value = "auto", value_parser = choice([
        ("auto", "If the record shows it: kind and size of most evidence", DriftGiven::Auto),
        ("none", "It stands; nothing is averaged either", DriftGiven::None),
        ("random-walk", "A level with increments that have no memory", DriftGiven::Kind(DriftKind::RandomWalk)),
        ("integrated-walk", "A slope with such increments", DriftGiven::Kind(DriftKind::IntegratedWalk)),
        ("correlated", "A level that returns within a correlation time", DriftGiven::Kind(DriftKind::Correlated)),
    ]))]
    drift: DriftGiven,
}

fn samples(text: &str) -> Result<usize, Failure> {
    text.parse().map_err(|_| Failure::usage(format!("`{text}` is no whole number of samples, 0 or more")))
}

fn yes_or_no(text: &str) -> Result<bool, Failure> {
    match text {
        "yes" => Ok(true),
        "no" => Ok(false),
        _ => Err(Failure::usage("say `yes` or `no`")),
    }
}

fn edges(text: &str) -> Result<(f64, f64), Failure> {
    let both = text.split_once(':').and_then(|(first, last)| first.parse().ok().zip(last.parse().ok()));
    both.filter(|&(first, last): &(f64, f64)| first > 0.0 && last > first && last.is_finite()).ok_or_else(|| {
        Failure::usage(format!("`{text}` is no FIRST:LAST in rad/s, such as 0.006:600, ascending and above zero"))
    })
}

/// More rates than seven in each of fourteen decades: no record tells them apart, and the work
/// grows with their cube.
const MOST_RATES: usize = 100;

fn rates(text: &str) -> Result<usize, Failure> {
    let count = at_least_one(text)?;
    if count > MOST_RATES {
        let sentence = format!("{count} rates are more than any record tells apart: {MOST_RATES} at most");
        return Err(Failure::usage(sentence));
    }
    Ok(count)
}

impl ModelOptions {
    /// Columns and their parts, and where the temperature of the gas is from.
    pub fn selection(&self) -> (Selection, GasGiven) {
        if let Some(column) = &self.ambient {
            return (Selection { gas: Some(column.clone()), ..self.columns.selection() }, GasGiven::Unknown);
        }
        let (gas, given) = match &self.gas_temperature {
            None => (None, GasGiven::Unknown),
            Some(text) => match text.parse::<f64>() {
                Ok(celsius) if celsius.is_finite() => (None, GasGiven::ConstantC(celsius)),
                _ => (Some(text.clone()), GasGiven::Column),
            },
        };
        (Selection { gas, ..self.columns.selection() }, given)
    }

    /// Options of the model of a record.
    pub fn options(&self, survey: &Survey, gas: GasGiven) -> Result<IdentifyOptions, Failure> {
        let is_conductance = self.structure == Some(Structure::Conductance);
        for (name, is_given) in
            [("--gas-temperature", self.gas_temperature.is_some()), ("--reference", self.reference.is_some())]
        {
            if is_given && !is_conductance {
                let sentence = format!("{name} belongs to --structure conductance: add it, or leave {name} out");
                return Err(Failure::usage(sentence));
            }
        }
        if is_conductance && self.ambient.is_some() {
            let sentence = "--ambient belongs to structure `symbol`: --structure conductance has --gas-temperature";
            return Err(Failure::usage(sentence));
        }
        if let Some(poles @ 9..) = self.free_poles {
            let sentence = format!("--free-poles must be 1 to 8, as many as the board carries, not {poles}");
            return Err(Failure::usage(sentence));
        }
        if self.ridge.is_some_and(|ridge| !(ridge.is_finite() && ridge >= 0.0)) {
            return Err(Failure::usage("--ridge must be a number of at least 0"));
        }
        Ok(self.asked(gas, self.signs(survey)?))
    }

    fn asked(&self, gas: GasGiven, signs: Signs) -> IdentifyOptions {
        let constraints = Constraints {
            order: self.order,
            edges_rad_s: self.mesh,
            ridge: self.ridge,
            initial_state: self.initial_state,
            feed_through: self.feed_through,
            delay: self.dead_time,
        };
        IdentifyOptions {
            structure: self.structure,
            constraints,
            signs,
            gas,
            reference: self.reference.clone(),
            free_poles: self.free_poles,
            tie: self.tie,
            losses: self.losses,
            drift: self.drift,
            follow_ambient: self.ambient.is_some(),
        }
    }

    fn signs(&self, survey: &Survey) -> Result<Signs, Failure> {
        match self.non_negative.as_str() {
            "auto" => Ok(Signs::Choose),
            "all" => Ok(Signs::AllPositive),
            "none" => Ok(Signs::Any),
            list => {
                let position = |pair: &str| {
                    let found = survey.inputs.iter().enumerate().find_map(|(i, input)| {
                        Some((i, survey.outputs.iter().position(|output| recording::is_pair(pair, input, output))?))
                    });
                    found.ok_or_else(|| {
                        let (inputs, outputs) = (survey.inputs.join(", "), survey.outputs.join(", "));
                        let sentence = format!("`{pair}` is no pair of an input ({inputs}) and an output ({outputs})");
                        Failure::usage(format!("--non-negative: {sentence}"))
                    })
                };
                Ok(Signs::Positive(list.split(',').map(position).collect::<Result<_, _>>()?))
            }
        }
    }
}
