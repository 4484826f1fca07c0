//! The sweep file: which experiments, which keys take which values, what is done with each run.
//! Read strictly; what cannot be meant is refused with its line.

use std::path::{Path, PathBuf};

use glob::Pattern;
use serde::Deserialize;
use toml::Value;

use crate::error::EntryError;
use crate::key::KeyPath;
use crate::sampling::{Points, SampleSet};
use crate::step::StepCommand;
use recording::text::count;
use recording::toml_file::{FileError, TomlSource};

/// More runs than this are a mistake.
const MOST_RUNS: usize = 1_000_000;
/// A value farther than this from the median is an outlier, in units of 1.4826 times the median
/// deviation: the standard deviation of a normal distribution.
const DISTANCE: f64 = 5.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepFileTable {
    title: Option<String>,
    experiment: Option<Value>,
    #[serde(default)]
    set: SampleSet,
    count: Option<usize>,
    #[serde(default)]
    seed: u64,
    #[serde(default)]
    recordings: bool,
    #[serde(default)]
    then: Vec<String>,
    #[serde(default)]
    vary: Vec<VaryTable>,
    outliers: Option<OutlierTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VaryTable {
    key: Value,
    values: Option<Vec<Value>>,
    files: Option<String>,
    range: Option<[f64; 2]>,
    #[serde(default)]
    scale: RangeScale,
    #[serde(default)]
    whole: bool,
    steps: Option<usize>,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RangeScale {
    #[default]
    Linear,
    Log,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OutlierTable {
    columns: Vec<String>,
    #[serde(default)]
    by: Vec<String>,
    distance: Option<f64>,
}

/// What a value is put into.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum VariedPlace {
    /// The file of the experiment itself.
    ExperimentFile,
    /// The file of the head.
    HeadFile,
    /// The file of the models.
    ModelsFile,
    /// A recording in place of an experiment.
    RecordingFile,
    /// A key of the experiment.
    Experiment(KeyPath),
    /// A key of the head.
    Head(KeyPath),
    /// A key of the models.
    Models(KeyPath),
}

/// Keys that take the same value, and which values that may be.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct VariedKey {
    /// As it is written; of several the first.
    pub name: String,
    /// As a column of the results.
    pub column: String,
    pub places: Vec<VariedPlace>,
    pub points: Points,
}

/// Which numbers are held against those of other runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OutlierSearch {
    pub columns: Vec<Pattern>,
    /// Places of the keys of which only equal ones are compared.
    pub by: Vec<usize>,
    pub distance: f64,
}

/// A sweep file, checked.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SweepFile {
    pub source: TomlSource,
    pub title: String,
    /// Paths from the working folder.
    pub experiments: Vec<PathBuf>,
    pub set: SampleSet,
    pub count: usize,
    pub seed: u64,
    pub keeps_recordings: bool,
    pub then: Vec<StepCommand>,
    pub keys: Vec<VariedKey>,
    pub outliers: Option<OutlierSearch>,
}

impl SweepFile {
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::from_source(TomlSource::read(path)?)
    }

    fn from_source(source: TomlSource) -> Result<Self, FileError> {
        let table: SweepFileTable = source.parse()?;
        let folder = source.path.parent().unwrap_or(Path::new("")).to_owned();
        let is_grid = table.set == SampleSet::Grid;
        let mut keys = Vec::with_capacity(table.vary.len());
        for (place, vary) in table.vary.into_iter().enumerate() {
            keys.push(varied(&source, &folder, place, vary, is_grid)?);
        }
        if keys.is_empty() {
            return Err(source.refuse("vary", "is missing: a `[[vary]]` names a key and its values"));
        }
        let column_of = |key: &VariedKey| key.column.clone();
        for (place, key) in keys.iter().enumerate() {
            if keys[..place].iter().any(|before| column_of(before) == key.column) {
                let sentence = format!("gives a second column `{}`: every key stands once", key.column);
                return Err(source.refuse(&format!("vary[{place}].key"), sentence));
            }
        }
        let experiments = match &table.experiment {
            None => Vec::new(),
            Some(value) => experiments(&folder, value).map_err(|wrong| source.refuse("experiment", wrong))?,
        };
        let repeated = (1..experiments.len())
            .find(|n| experiments[..*n].iter().any(|before| before.file_stem() == experiments[*n].file_stem()));
        if let Some(repeated) = repeated {
            let file = experiments[repeated].display();
            let sentence = format!("has a second file of the name of {file}: names tell recordings apart");
            return Err(source.refuse("experiment", sentence));
        }
        let has = |place: &VariedPlace| keys.iter().any(|key| key.places.contains(place));
        let given = [!experiments.is_empty(), has(&VariedPlace::ExperimentFile), has(&VariedPlace::RecordingFile)];
        if given.iter().filter(|given| **given).count() != 1 {
            let sentence = "must be given once: as `experiment = \"…\"`, as a varied key `experiment`, or as a varied key `recording` in its place";
            return Err(source.refuse("experiment", sentence));
        }
        if given[2] && table.then.is_empty() {
            return Err(source.refuse("then", "is missing: nothing is done with the recordings"));
        }
        let count = count_of(&source, table.set, table.count, &keys)?;
        let then = table.then.iter().enumerate().map(|(place, line)| {
            StepCommand::parse(line).map_err(|wrong| source.refuse(&format!("then[{place}]"), wrong))
        });
        let then = StepCommand::named(then.collect::<Result<_, _>>()?);
        let outliers = table.outliers.map(|table| outlier_search(&source, table, &keys)).transpose()?;
        let name = source.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self {
            title: table.title.unwrap_or(name),
            experiments,
            set: table.set,
            count,
            seed: table.seed,
            keeps_recordings: table.recordings,
            then,
            keys,
            outliers,
            source,
        })
    }
}

/// The number of runs.
fn count_of(source: &TomlSource, set: SampleSet, given: Option<usize>, keys: &[VariedKey]) -> Result<usize, FileError> {
    let of_grid = keys.iter().try_fold(1_usize, |all, key| all.checked_mul(key.points.count()));
    let (key, runs) = match (set, given) {
        (SampleSet::Grid, None) => ("vary", of_grid.unwrap_or(usize::MAX)),
        (SampleSet::Grid, Some(_)) => {
            return Err(source.refuse("count", "is given, but a grid has as many runs as its values combine to"));
        }
        (_, Some(given @ 1..)) => ("count", given),
        (_, Some(0)) => return Err(source.refuse("count", "is 0: at least one run")),
        (_, None) => {
            return Err(source.refuse("count", "is missing: how many runs a random or Latin-hypercube set has"));
        }
    };
    if runs > MOST_RUNS {
        return Err(source.refuse(key, format!("comes to more than {}", count(MOST_RUNS, "run"))));
    }
    Ok(runs)
}

/// A text, or a list of texts.
fn words(value: &Value) -> Option<Vec<String>> {
    match value {
        Value::String(word) => Some(vec![word.clone()]),
        Value::Array(list) if !list.is_empty() => list.iter().map(|item| item.as_str().map(str::to_owned)).collect(),
        _ => None,
    }
}

fn varied(
    source: &TomlSource,
    folder: &Path,
    place: usize,
    table: VaryTable,
    is_grid: bool,
) -> Result<VariedKey, FileError> {
    let refuse = |key: &str, sentence: String| source.refuse(&format!("vary[{place}].{key}"), sentence);
    let names = words(&table.key).ok_or_else(|| refuse("key", "is no key and no list of keys".to_owned()))?;
    let places = names.iter().map(|name| place_of(name)).collect::<Result<Vec<_>, _>>();
    let places = places.map_err(|wrong| refuse("key", wrong.0))?;
    let is_file = !matches!(places[0], VariedPlace::Experiment(_) | VariedPlace::Head(_) | VariedPlace::Models(_));
    let points = match (table.values, table.range, table.files) {
        (Some(values), None, None) if !values.is_empty() => Points::Listed(values),
        (None, Some([low, high]), None) => {
            let is_log = table.scale == RangeScale::Log;
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(refuse("range", format!("is [{low}, {high}]: two finite numbers, ascending")));
            }
            if is_log && low <= 0.0 {
                return Err(refuse("range", format!("begins at {low}: on a logarithmic scale it begins above 0")));
            }
            let steps = match (is_grid, table.steps) {
                (true, Some(steps @ 2..)) => steps,
                (true, _) => {
                    return Err(refuse(
                        "steps",
                        "must be given, 2 or more: how many values a grid has of it".to_owned(),
                    ));
                }
                (false, None) => 0,
                (false, Some(_)) => {
                    return Err(refuse("steps", "is for a grid: `count` says how many are drawn".to_owned()));
                }
            };
            Points::Between { low, high, is_log, is_whole: table.whole, steps }
        }
        (None, None, Some(pattern)) if is_file => {
            Points::Listed(files(folder, &pattern).map_err(|wrong| refuse("files", wrong.0))?)
        }
        (None, None, Some(_)) => {
            let sentence = "are for the keys `experiment`, `head`, `models` and `recording`".to_owned();
            return Err(refuse("files", sentence));
        }
        _ => {
            let sentence = "takes one of `values`, `range` and `files`, with something in it".to_owned();
            return Err(refuse("key", sentence));
        }
    };
    if let (true, Points::Listed(values)) = (is_file, &points)
        && values.iter().any(|value| !value.is_str())
    {
        return Err(refuse("values", "are paths in quotes for a file".to_owned()));
    }
    if is_file && matches!(points, Points::Between { .. }) {
        return Err(refuse("range", format!("is for numbers, and `{}` is a file", names[0])));
    }
    Ok(VariedKey { column: crate::columns::identifier(&names[0]), name: names[0].clone(), places, points })
}

fn place_of(name: &str) -> Result<VariedPlace, EntryError> {
    Ok(match name {
        "experiment" => VariedPlace::ExperimentFile,
        "head" => VariedPlace::HeadFile,
        "models" => VariedPlace::ModelsFile,
        "recording" => VariedPlace::RecordingFile,
        _ => match (name.strip_prefix("head."), name.strip_prefix("models.")) {
            (Some(of_head), _) => VariedPlace::Head(KeyPath::parse(of_head)?),
            (_, Some(of_models)) => VariedPlace::Models(KeyPath::parse(of_models)?),
            _ => VariedPlace::Experiment(KeyPath::parse(name)?),
        },
    })
}

/// The experiments of a path, a pattern, or a list of them.
fn experiments(folder: &Path, value: &Value) -> Result<Vec<PathBuf>, EntryError> {
    let named = words(value).ok_or("is no path and no list of paths")?;
    let mut all = Vec::new();
    for name in named {
        if name.contains(['*', '?']) {
            all.extend(files(folder, &name)?.iter().filter_map(Value::as_str).map(|path| folder.join(path)));
        } else {
            all.push(folder.join(name));
        }
    }
    Ok(all)
}

/// The files of a pattern, which counts from the folder of the sweep file, as paths from there.
fn files(folder: &Path, pattern: &str) -> Result<Vec<Value>, EntryError> {
    let refused = |why: String| EntryError(format!("is `{pattern}`: {why}"));
    let whole = Pattern::escape(&folder.to_string_lossy());
    let whole = Path::new(&whole).join(pattern);
    let found = glob::glob(&whole.to_string_lossy()).map_err(|error| refused(error.to_string()))?;
    let mut files = Vec::new();
    for file in found {
        let file = file.map_err(|error| refused(error.to_string()))?;
        // A pattern with `..` leads out of the folder again.
        let from_folder = file.strip_prefix(folder).unwrap_or(&file);
        if file.is_file() {
            files.push(Value::String(from_folder.to_string_lossy().into_owned()));
        }
    }
    if files.is_empty() { Err(refused("there is no such file".to_owned())) } else { Ok(files) }
}

fn outlier_search(source: &TomlSource, table: OutlierTable, keys: &[VariedKey]) -> Result<OutlierSearch, FileError> {
    let pattern = |(place, text): (usize, &String)| {
        Pattern::new(text)
            .map_err(|error| source.refuse(&format!("outliers.columns[{place}]"), format!("is `{text}`: {error}")))
    };
    let by = |(place, name): (usize, &String)| {
        keys.iter().position(|key| key.name == *name).ok_or_else(|| {
            let hint = recording::text::suggest(name, keys.iter().map(|key| key.name.as_str()));
            source.refuse(&format!("outliers.by[{place}]"), format!("is `{name}`, which is not varied; {hint}"))
        })
    };
    Ok(OutlierSearch {
        columns: table.columns.iter().enumerate().map(pattern).collect::<Result<_, _>>()?,
        by: table.by.iter().enumerate().map(by).collect::<Result<_, _>>()?,
        distance: source.positive("outliers.distance", table.distance.unwrap_or(DISTANCE), "")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<SweepFile, String> {
        let source = TomlSource { path: "s.toml".into(), text: text.to_owned() };
        SweepFile::from_source(source).map_err(|error| error.to_string())
    }

    #[test]
    fn a_sweep_file_is_read_with_its_keys() {
        let file = read(
            "experiment = \"a.toml\"\n[[vary]]\nkey = [\"drives.a.temperature_c\", \"drives.b.temperature_c\"]\nvalues = [1, 2]\n[[vary]]\nkey = \"head.kinds.k.energy_j\"\nrange = [1, 100]\nscale = \"log\"\nsteps = 3\n",
        )
        .unwrap();
        assert_eq!((file.title.as_str(), file.count), ("s", 6));
        assert_eq!(file.keys[0].places.len(), 2);
        assert_eq!(file.keys[0].column, "drives_a_temperature_c");
        assert_eq!(file.keys[1].places, [VariedPlace::Head(KeyPath::parse("kinds.k.energy_j").unwrap())]);
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_line_and_key() {
        let vary = "[[vary]]\nkey = \"seed\"\nvalues = [1]\n";
        for (text, expected) in [
            (vary.to_owned(), "s.toml: `experiment` must be given once"),
            ("experiment = \"a.toml\"\n".to_owned(), "s.toml: `vary` is missing"),
            (format!("experiment = \"a.toml\"\ncount = 3\n{vary}"), "line 2: `count` is given, but a grid"),
            (format!("experiment = \"a.toml\"\nset = \"random\"\n{vary}"), "`count` is missing"),
            (format!("experiment = \"a.toml\"\nset = \"sobol\"\n{vary}"), "line 2: unknown choice `sobol` for `set`"),
            (format!("experiment = \"a.toml\"\n{vary}{vary}"), "`vary[1].key` gives a second column `seed`"),
            (format!("experiment = \"a.toml\"\n{vary}range = [1, 2]\n"), "`vary[0].key` takes one of `values`"),
            ("experiment = 3\n[[vary]]\nkey = \"a\"\nvalues = [1]\n".to_owned(), "line 1: `experiment` is no path"),
            (format!("experiment = \"a.toml\"\nthen = [\"identify 'x\"]\n{vary}"), "`then[0]` is"),
            (
                "experiment = \"a.toml\"\n[[vary]]\nkey = \"a\"\nrange = [0, 2]\nscale = \"log\"\nsteps = 2\n"
                    .to_owned(),
                "line 4: `vary[0].range` begins at 0",
            ),
            (
                "experiment = \"a.toml\"\n[[vary]]\nkey = \"a\"\nrange = [1, 2]\n".to_owned(),
                "`vary[0].steps` must be given",
            ),
            (
                "experiment = \"a.toml\"\n[[vary]]\nkey = \"head\"\nfiles = \"none/*.toml\"\n".to_owned(),
                "line 4: `vary[0].files` is `none/*.toml`: there is no such file",
            ),
            ("[[vary]]\nkey = \"recording\"\nvalues = [\"a.parquet\"]\n".to_owned(), "`then` is missing"),
            (
                format!("experiment = \"a.toml\"\n{vary}[outliers]\ncolumns = [\"*\"]\nby = [\"sed\"]\n"),
                "`outliers.by[0]` is `sed`, which is not varied; did you mean `seed`?",
            ),
        ] {
            let sentence = read(&text).unwrap_err();
            assert!(sentence.contains(expected), "{text}: {sentence}");
        }
    }
}
