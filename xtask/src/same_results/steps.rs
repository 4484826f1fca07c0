//! The chain of analyses, from recordings to a calibrated head that measures wind.

/// One analysis. Arguments may name `{experiments}`, `{recordings}`, `{fixtures}` (those of the
/// tests) and `{work}`, the folder for all that is written.
pub struct AnalysisStep {
    pub name: &'static str,
    /// The subcommand, by its older name.
    pub command: &'static str,
    pub arguments: &'static [&'static str],
    /// A table of comma-separated values that it writes into `{work}`.
    pub table: Option<&'static str>,
    /// Whether it takes minutes, or stands on one that does: left out unless it is asked for.
    pub is_long: bool,
}

const fn step(name: &'static str, command: &'static str, arguments: &'static [&'static str]) -> AnalysisStep {
    AnalysisStep { name, command, arguments, table: None, is_long: false }
}

const fn step_with_table(
    name: &'static str,
    command: &'static str,
    arguments: &'static [&'static str],
    table: &'static str,
) -> AnalysisStep {
    AnalysisStep { name, command, arguments, table: Some(table), is_long: false }
}

const fn long(step: AnalysisStep) -> AnalysisStep {
    AnalysisStep { is_long: true, ..step }
}

const PRBS: &str = "{recordings}/prbs.parquet";
const WINDS: &str = "{recordings}/thesis-sphere-b-prbs.parquet";
const DICE: &str = "card1-die1,card1-die2,card1-die3,card1-die4";
const SYMBOL: &str = "{work}/symbol.json";
const CLASSES: &str = "{work}/classes.json";
const CONDUCTANCE: &str = "{work}/conductance.json";
const FREE: &str = "{work}/free.json";

pub const STEPS: &[AnalysisStep] = &[
    step_with_table(
        "run, recorded as a table",
        "run",
        &["{experiments}/steady.toml", "--on", "sim", "--json", "-o", "{work}/steady.csv"],
        "steady.csv",
    ),
    step("identify a symbol", "identify", &[PRBS, "--input", "sector1", "--output", "sector1", "--json", "-o", SYMBOL]),
    step(
        "identify a symbol a wind",
        "identify",
        &[WINDS, "--input", "sector1", "--output", "sector1", "--event", "event", "--json", "-o", CLASSES],
    ),
    step(
        "identify a conductance a wind",
        "identify",
        &[
            WINDS,
            "--input",
            "sector1",
            "--output",
            "sector1",
            "--event",
            "event",
            "--structure",
            "conductance",
            "--json",
            "-o",
            CONDUCTANCE,
        ],
    ),
    step(
        "identify free poles",
        "identify",
        &[PRBS, "--input", "sector1", "--output", "sector1", "--free-poles", "3", "--json", "-o", FREE],
    ),
    step(
        "identify crossed pairs",
        "identify",
        &[PRBS, "--input", "sector1", "sector2", "--output", "sector1", "sector2", "--tie", "--order", "12", "--json"],
    ),
    step(
        "identify, an order refused",
        "identify",
        &[PRBS, "--input", "sector1", "--output", "sector1", "--order", "100000", "--json"],
    ),
    step("validate a symbol", "validate", &[SYMBOL, PRBS, "--input", "sector1", "--output", "sector1", "--json"]),
    step(
        "validate a conductance",
        "validate",
        &[CONDUCTANCE, WINDS, "--input", "sector1", "--output", "sector1", "--event", "event", "--json"],
    ),
    step("validate free poles", "validate", &[FREE, PRBS, "--input", "sector1", "--output", "sector1", "--json"]),
    step("analyse a symbol", "analyse", &[SYMBOL, "--json"]),
    step("analyse a symbol a wind", "analyse", &[CLASSES, "--json"]),
    step("design", "design", &[CLASSES, "--target", "10", "--json"]),
    step("reduce", "reduce", &[SYMBOL, "--order", "4", "--json"]),
    step("export", "export", &[CLASSES, "--as", "foster", "--class", "2 m/s", "--json"]),
    step("predict", "predict", &[CLASSES, "{experiments}/thesis/sphere-b-step.toml", "--json"]),
    step(
        "predict, compared",
        "predict",
        &[
            CONDUCTANCE,
            "{experiments}/thesis/sphere-b-step.toml",
            "--against",
            "{recordings}/thesis-sphere-b-step.parquet",
            "--json",
        ],
    ),
    step(
        "network of a card",
        "network",
        &[
            "{recordings}/wind-rems-identify-die1.parquet",
            "{recordings}/wind-rems-identify-die2.parquet",
            "{recordings}/wind-rems-identify-die3.parquet",
            "{recordings}/wind-rems-identify-die4.parquet",
            "--elements",
            DICE,
            "--json",
            "-o",
            "{work}/card.json",
        ],
    ),
    step(
        "calibrate a card",
        "calibrate",
        &[
            "{recordings}/wind-rems-tunnel.parquet",
            "--network",
            "{work}/card.json",
            "--elements",
            DICE,
            "--json",
            "-o",
            "{work}/card.toml",
        ],
    ),
    step_with_table(
        "wind of a card",
        "wind",
        &[
            "{recordings}/wind-rems-winds.parquet",
            "--head",
            "{work}/card.toml",
            "--json",
            "--every",
            "1",
            "-o",
            "{work}/card-wind.csv",
        ],
        "card-wind.csv",
    ),
    step_with_table(
        "wind of a sphere, by an older head",
        "wind",
        &[
            "{recordings}/wind-sphere-b-turbulence.parquet",
            "--head",
            "{fixtures}/sphere-b-calibrated.toml",
            "--json",
            "--every",
            "0.1",
            "-o",
            "{work}/older-head.csv",
        ],
        "older-head.csv",
    ),
    long(step(
        "network of a sphere",
        "network",
        &[
            "{recordings}/wind-sphere-b-identify-sector1.parquet",
            "{recordings}/wind-sphere-b-identify-sector2.parquet",
            "{recordings}/wind-sphere-b-identify-sector3.parquet",
            "{recordings}/wind-sphere-b-identify-sector4.parquet",
            "{recordings}/wind-sphere-b-identify-core1.parquet",
            "{recordings}/wind-sphere-b-identify-core2.parquet",
            "--json",
            "-o",
            "{work}/sphere.json",
        ],
    )),
    long(step(
        "calibrate a sphere",
        "calibrate",
        &[
            "{recordings}/wind-sphere-b-tunnel.parquet",
            "--network",
            "{work}/sphere.json",
            "--json",
            "-o",
            "{work}/sphere.toml",
        ],
    )),
    long(step_with_table(
        "wind of a sphere",
        "wind",
        &[
            "{recordings}/wind-sphere-b-turbulence.parquet",
            "--head",
            "{work}/sphere.toml",
            "--json",
            "--every",
            "0.1",
            "-o",
            "{work}/sphere-wind.csv",
        ],
        "sphere-wind.csv",
    )),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shell;
    use std::collections::BTreeSet;

    #[test]
    fn every_recording_is_of_an_experiment_that_there_is() {
        let experiments = shell::root().join("experiments");
        let files = crate::sources::files_with_extension(&experiments, "toml").expect("the experiments");
        let name = |path: &std::path::PathBuf| {
            path.strip_prefix(&experiments).expect("below").with_extension("").to_string_lossy().replace('/', "-")
        };
        let known: BTreeSet<String> = files.iter().map(name).collect();
        for argument in STEPS.iter().flat_map(|step| step.arguments) {
            if let Some(recording) = argument.strip_prefix("{recordings}/") {
                assert!(known.contains(recording.trim_end_matches(".parquet")), "{recording}");
            }
            if let Some(fixture) = argument.strip_prefix("{fixtures}/") {
                assert!(shell::root().join("tests/fixtures").join(fixture).is_file(), "{fixture}");
            }
            if let Some(experiment) = argument.strip_prefix("{experiments}/") {
                assert!(experiments.join(experiment).is_file(), "{experiment}");
            }
        }
    }
}
