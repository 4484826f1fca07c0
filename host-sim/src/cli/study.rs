//! `anemo study`: the numbers that the instrument has to reach, measured on the simulated sensors.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::Failure;
use crate::study::wind::{self, Measured, page};
use crate::thesis::StudyError;

/// Measure the numbers that the whole instrument has to reach, on the simulated sensors.
///
/// The study of the wind identifies and calibrates both spheres, and judges their answers in 500 winds that they have not seen, in steps,
/// turbulence and a gas that swings: speed and direction, response, drift, coherence. It takes some minutes, and two cores.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo study wind
  anemo study wind -o out --heads out/heads --json")]
pub struct Arguments {
    /// What is studied.
    #[arg(value_name = "wind")]
    name: Name,
    /// The folder for the page, which is written anew.
    #[arg(short, long, value_name = "FOLDER", default_value = "docs/results")]
    output: PathBuf,
    /// The folder with the experiments of the spheres.
    #[arg(long, value_name = "FOLDER", default_value = "experiments/wind")]
    experiments: PathBuf,
    /// Also write the calibrated heads into this folder.
    #[arg(long, value_name = "FOLDER")]
    heads: Option<PathBuf>,
    /// Print one JSON object instead of the tables.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Name {
    Wind,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Name::Wind = arguments.name;
    if !arguments.experiments.is_dir() {
        return Err(Failure::usage(format!(
            "{}: no folder of experiments; run it from the project's own, or say where with --experiments",
            arguments.experiments.display()
        )));
    }
    for folder in [Some(&arguments.output), arguments.heads.as_ref()].into_iter().flatten() {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::usage(format!("{}: cannot be made: {error}", folder.display())))?;
    }
    let terminal = std::io::stderr().is_terminal();
    let told = |what: &str| {
        if terminal {
            eprintln!("  {what}");
        }
    };
    let all = wind::both(&arguments.experiments, &told).map_err(|error| match error {
        StudyError::File(error) => error.into(),
        StudyError::Run(error) => error.into(),
        other => Failure::work(other),
    })?;
    super::write_text(&arguments.output.join("wind.md"), &page::page(&all))?;
    if let Some(folder) = &arguments.heads {
        for of in &all {
            super::write_text(&folder.join(format!("{}-calibrated.toml", of.sphere.folder)), &of.text)?;
        }
    }
    if arguments.json {
        let of = |of: &Measured| (of.sphere.folder.to_owned(), as_json(of));
        return super::print_json(&Value::Object(all.iter().map(of).collect()));
    }
    super::print(&page::page(&all))
}

fn as_json(of: &Measured) -> Value {
    let found = page::findings(of);
    let (bars, met) = found.score();
    let findings = found.findings.iter().map(|finding| {
        json!({
            "what": finding.what, "bar": finding.bar, "measured": finding.ours,
            "beside": finding.published, "met": finding.met,
        })
    });
    let winds = of.directions.iter().map(|row| {
        json!({
            "bandwidth_hz": row.mode.bandwidth_hz, "fixed": row.mode.fixed,
            "winds": row.winds,
            "speed_rms_error": row.errors.speed_rms(),
            "direction_rms_error_deg": row.errors.direction_rms_deg(),
            "linear_direction_rms_error_deg": row.errors.linear_rms_deg(),
        })
    });
    let steps = of.steps.iter().flat_map(|steps| {
        steps.ways.iter().map(|way| {
            json!({
                "bandwidth_hz": steps.mode.bandwidth_hz,
                "fixed": steps.mode.fixed,
                "to_m_s": way.to_m_s,
                "mean_response_s": way.mean_response_s,
                "single_response_s": way.single_response_s,
                "noise": way.noise,
                "outside": way.outside,
            })
        })
    });
    let turbulence = of.turbulence.iter().flat_map(|row| {
        row.bands.iter().map(|band| {
            json!({
                "bandwidth_hz": row.mode.bandwidth_hz, "fixed": row.mode.fixed, "from_hz": band.from_hz, "to_hz": band.to_hz,
                "coherence": band.coherence, "gain": band.gain,
            })
        })
    });
    json!({
        "bars": bars,
        "met": met,
        "findings": findings.collect::<Vec<_>>(),
        "winds": winds.collect::<Vec<_>>(),
        "steps": steps.collect::<Vec<_>>(),
        "drift": of.drift.answer,
        "raw_drift": of.drift.raw,
        "raw_response_s": of.drift.raw_response_s,
        "turbulence": turbulence.collect::<Vec<_>>(),
        "gas_swing_worst_error": of.swing.speed_worst,
        "conductance_noise_w_k": of.noise_w_k.iter().map(|(hz, w_k)| json!({"bandwidth_hz": hz, "value": w_k})).collect::<Vec<_>>(),
    })
}
