//! `anemo identify`: from a record to a diffusive model.

use std::path::{Path, PathBuf};

use crate::choice::choice;
use crate::fit_recorder::FitRecorder;
use crate::identify_page;
use crate::output::Failure;
use crate::picture::PictureArguments;
use crate::progress::progress_bar;
use diffusive::identify::Signs;
use diffusive::identify::parts::{identify_parts, join_files, refuse_incomplete};
use diffusive::identify::record::{RecordError, RecordSource as _, RecordStream, Selection, Survey, TimeUnit};
use diffusive::identify::report::IdentifyReport;
use diffusive::identify::{Constraints, DriftGiven, DriftKind, InitialState, Losses};
use diffusive::identify::{GasGiven, IdentifyOptions, identify};
use diffusive::model::Structure;
use plot::model::figure;

/// Identify a diffusive model from a record: thermal resistances on a logarithmic grid of rates
/// (diffusive mesh), with standard errors.
///
/// The record is a recording of `anemo run`, or any table that a logger writes with the time in its
/// first column. Gaps end a segment, across which nothing is taken. Options not given are chosen by
/// block cross-validation, and the reasons printed. The picture shows time-constant spectrum
/// (diffusive symbol), fit, the offset's drift if it has one, residuals, frequency response and
/// structure function.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo identify prbs.parquet --output sector1 --free-poles 4 \\
      -o sector1.json --plot sector1.svg
  anemo identify prbs.parquet --output sector1 sector2 sector3 sector4 \\
      --free-poles 4 -o sectors.json
  anemo identify prbs.parquet --input sector1 sector2 \\
      --output sector1 sector2 --tie -o tied.json
  anemo identify heater.csv --input power --output temperature -o heater.json
  anemo identify heater.csv -o eight.json --order 8 --mesh 0.006:30 \\
      --ridge 1e-6
  anemo identify heater.csv heater-second-half.csv -o both.json \\
      --report both.html
  anemo identify three-winds.csv --event wind --non-negative all \\
      -o winds.json --plot winds.svg
  anemo identify three-winds.csv --event wind --structure conductance \\
      --non-negative all --gas-temperature 18.0 -o conductance.json
  anemo identify charge.parquet --input bit1_mems bit0_mems \\
      --output voltage_shift_v_mems --initial-state rest --drift none \\
      -o charge.json

A row holds the outputs at its time, and the inputs from then on.")]
pub struct Arguments {
    /// The record: .parquet or .csv files; several are segments of one record, or one segment where
    /// each goes on where the one before ended. Or the sums of all of its parts, .gram files of
    /// `anemo gram`, in any order.
    #[arg(required = true, value_name = "RECORD")]
    records: Vec<PathBuf>,
    /// Write the model to this .json file.
    #[arg(short, long, value_name = "FILE")]
    output_file: Option<PathBuf>,
    #[command(flatten)]
    model: ModelOptions,
    #[command(flatten)]
    picture: PictureArguments,
    /// Write a report into this .html file: record, gains, fit, choices, warnings, what the next
    /// record should be, and the pictures. It needs no other file, and prints on A4.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

/// What is asked of a model, and of which columns: the same for a record and for a plan of its
/// parts.
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
    /// Number of rates of cross-heating pairs: input i and output i are of one element
    /// (self-heating).
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = rates)]
    cross_order: Option<usize>,
    /// Edges of the grid of cross-heating pairs, rad/s; by default number and edges are those of
    /// the others.
    #[arg(long, value_name = "FIRST:LAST", value_parser = edges)]
    cross_mesh: Option<(f64, f64)>,
    /// Ridge on columns of unit norm; 0 for plain least squares.
    #[arg(long, value_name = "EPSILON", allow_negative_numbers = true)]
    ridge: Option<f64>,
    /// Resistances that may not be negative: `auto` (unless cross-validation rejects it; none, of
    /// structure `conductance`), `all`, `none`, or pairs as INPUT:OUTPUT,….
    #[arg(long, value_name = "PAIRS", default_value = "auto")]
    non_negative: String,
    /// Initial state of the record.
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
    /// Samples by which the output is late.
    #[arg(long, value_name = "SAMPLES", allow_negative_numbers = true, value_parser = samples)]
    dead_time: Option<usize>,
    /// Number of free rates of an output, 1 to 8, for a small model; the fit starts from that on
    /// the grid.
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = at_least_one, conflicts_with_all = ["cross_order", "cross_mesh", "tie"])]
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

/// Which columns play which part: the same for every command that takes a record.
#[derive(clap::Args)]
pub struct Columns {
    /// Input columns, or elements; by default a recording's powers that vary, another table's
    /// columns that change between the first and the last.
    #[arg(long, value_name = "COLUMN", num_args = 1.., value_delimiter = ',')]
    pub input: Vec<String>,
    /// Output columns, or elements; by default the temperatures of a recording's inputs, another
    /// table's last column.
    #[arg(long, value_name = "COLUMN", num_args = 1.., value_delimiter = ',')]
    pub output: Vec<String>,
    /// Column with the labels of the conditions (winds); by default a text column `event`, in
    /// another table than a recording also `class`, `wind`, `condition`, `phase` or `label`.
    #[arg(long, value_name = "COLUMN")]
    pub event: Option<String>,
    /// Names of all columns, in their order: for a table without a line of names, or in place of
    /// them.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Unit of the times; by default what their column's name says (`time_ms`, `t [min]`), or s.
    #[arg(long, value_name = "UNIT", value_parser = choice([
        ("s", "", TimeUnit::Second),
        ("ms", "", TimeUnit::Millisecond),
        ("us", "", TimeUnit::Microsecond),
        ("min", "", TimeUnit::Minute),
        ("h", "", TimeUnit::Hour),
        ("d", "", TimeUnit::Day),
    ]))]
    pub time_unit: Option<TimeUnit>,
    /// Distance of the rows in time, s, for a table without times.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub sample_period: Option<f64>,
}

impl Columns {
    /// What is asked of a record, but for its gas.
    pub fn selection(&self) -> Selection {
        Selection {
            inputs: self.input.clone(),
            outputs: self.output.clone(),
            event: self.event.clone(),
            gas: None,
            columns: self.columns.clone(),
            time_unit: self.time_unit,
            sample_period_s: self.sample_period,
        }
    }
}

fn edges(text: &str) -> Result<(f64, f64), Failure> {
    let both = text.split_once(':').and_then(|(first, last)| first.parse().ok().zip(last.parse().ok()));
    both.filter(|&(first, last): &(f64, f64)| first > 0.0 && last > first && last.is_finite()).ok_or_else(|| {
        let what = "is no FIRST:LAST in rad/s, such as 0.006:600, ascending and above zero";
        Failure::usage(format!("`{text}` {what}"))
    })
}

/// A count.
pub fn at_least_one(text: &str) -> Result<usize, Failure> {
    let count = text.parse().ok().filter(|&count: &usize| count > 0);
    count.ok_or_else(|| Failure::usage(format!("`{text}` is no whole number of at least 1")))
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

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        Self::work(error)
    }
}

impl ModelOptions {
    /// Refuses any option where those of the plan hold, in `what`.
    pub fn refuse_any(&self, what: &str) -> Result<(), Failure> {
        let (selection, gas) = self.selection();
        let is_default = self.non_negative == "auto"
            && self.reference.is_none()
            && selection == Selection::default()
            && self.asked(gas, Signs::Choose) == IdentifyOptions { losses: Losses::Auto, ..IdentifyOptions::default() };
        if is_default {
            return Ok(());
        }
        Err(Failure::usage(format!(
            "options of columns and model belong to the plan of the parts: give them to `anemo gram` when it makes the plan; `{what}` follows it here"
        )))
    }

    /// Which columns play which part, and where the temperature of the gas is from.
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

    /// What is asked of the model of a record.
    pub fn options(&self, survey: &Survey, gas: GasGiven) -> Result<IdentifyOptions, Failure> {
        let is_conductance = self.structure == Some(Structure::Conductance);
        for (name, is_given) in
            [("--gas-temperature", self.gas_temperature.is_some()), ("--reference", self.reference.is_some())]
        {
            if is_given && !is_conductance {
                return Err(Failure::usage(format!(
                    "{name} belongs to --structure conductance: add it, or leave {name} out"
                )));
            }
        }
        if is_conductance && self.ambient.is_some() {
            return Err(Failure::usage(
                "--ambient belongs to structure `symbol`: --structure conductance has --gas-temperature",
            ));
        }
        if let Some(poles @ 9..) = self.free_poles {
            return Err(Failure::usage(format!(
                "--free-poles must be 1 to 8, as many as the board carries, not {poles}"
            )));
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
        let cross = (self.cross_order.is_some() || self.cross_mesh.is_some()).then(|| Constraints {
            order: self.cross_order,
            edges_rad_s: self.cross_mesh,
            ..Constraints::default()
        });
        IdentifyOptions {
            structure: self.structure,
            constraints,
            signs,
            cross,
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
                let mut pairs = Vec::new();
                for pair in list.split(',') {
                    let found = survey.inputs.iter().enumerate().find_map(|(i, input)| {
                        Some((i, survey.outputs.iter().position(|output| recording::is_pair(pair, input, output))?))
                    });
                    let Some(found) = found else {
                        return Err(Failure::usage(format!(
                            "--non-negative: `{pair}` is no pair of an input ({}) and an output ({})",
                            survey.inputs.join(", "),
                            survey.outputs.join(", ")
                        )));
                    };
                    pairs.push(found);
                }
                Ok(Signs::Positive(pairs))
            }
        }
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let records: Vec<&Path> = arguments.records.iter().map(PathBuf::as_path).collect();
    let written = [arguments.output_file.as_deref(), arguments.picture.path(), arguments.report.as_deref()];
    crate::output::keep(&records, &written)?;
    if let Some(path) = &arguments.output_file {
        crate::output::writable(path, "a model", "json")?;
    }
    if let Some(path) = &arguments.report {
        crate::output::writable(path, "a report", "html")?;
    }
    if arguments.records.iter().any(|path| is_gram(path)) {
        return identify_sums(arguments);
    }
    let (selection, gas) = arguments.model.selection();
    let mut stream = RecordStream::open_all(&named(&arguments.records)?, &selection).map_err(Failure::usage)?;
    let options = arguments.model.options(stream.survey(), gas)?;
    let canvas = arguments.picture.canvas()?;
    let mut fits = FitRecorder::new(canvas.is_some() || arguments.report.is_some(), stream.survey());
    let model = identify(&mut stream, &options, &mut progress_bar(), &mut |seen| fits.see(seen))?;
    if let Some(path) = &arguments.output_file {
        model.write(path).map_err(Failure::work)?;
    }
    let fits = fits.fits(model.outputs.iter().map(|output| &output.whiteness));
    let notes = &stream.survey().notes;
    let report = IdentifyReport { model: &model, notes, written: arguments.output_file.as_deref() };
    if let Some(path) = &arguments.report {
        crate::output::write_text(path, &identify_page::page(&report, &figure(&model, &fits))?)?;
    }
    if let Some(canvas) = canvas {
        canvas.draw(&figure(&model, &fits)).map_err(Failure::work)?;
    }
    crate::output::print_report(&report, arguments.json)
}

/// The files that patterns name: no shell knows the names of objects.
pub fn named(files: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let named: Result<Vec<_>, _> = files.iter().map(|path| recording::named_by(path)).collect();
    Ok(named.map_err(Failure::usage)?.concat())
}

/// Whether a file has sums by its name.
pub fn is_gram(path: &Path) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case("gram"))
}

/// The model of a record of which the sums are at hand.
fn identify_sums(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(record) = arguments.records.iter().find(|path| !is_gram(path)) {
        return Err(Failure::in_file(record, "is no .gram file, as others are: name sums or records, not both"));
    }
    if arguments.picture.path().is_some() || arguments.report.is_some() {
        return Err(Failure::usage(
            "pictures and reports show rows, which sums do not have: leave out --plot and --report",
        ));
    }
    arguments.model.refuse_any("anemo identify")?;
    let (plan, sums) = join_files(&named(&arguments.records)?)?;
    refuse_incomplete(&plan, &sums)?;
    let model = identify_parts(&plan, sums, &mut progress_bar())?;
    if let Some(path) = &arguments.output_file {
        model.write(path).map_err(Failure::work)?;
    }
    let report = IdentifyReport { model: &model, notes: plan.notes(), written: arguments.output_file.as_deref() };
    crate::output::print_report(&report, arguments.json)
}
