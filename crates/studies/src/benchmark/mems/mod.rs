//! Charge in the dielectric of a MEMS: `studies benchmark mems`.
//!
//! The device of an experiment under pseudo-random symbols for a day, from which models are
//! identified; a second day that is set aside; closed loops of both orders, predicted from the
//! model and run on the simulated device.
//!
//! | file | what |
//! |---|---|
//! | [`records`] | a run of the simulated device, in memory |
//! | [`readings`] | quasi-differential against single readings |
//! | [`loops`] | set-points held: predicted and simulated, and for days |
//! | [`plateaus`] | where the loop of first order locks |
//! | [`report`] | the page |

pub mod loops;
pub mod plateaus;
pub mod readings;
pub mod records;
pub mod report;

use anyhow::Result;
use std::path::Path;

use dielectric::experiment::DeviceExperiment;
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::identify::{Constraints, DriftGiven, IdentifyOptions, InitialState, identify};
use plot::Canvas;

pub use report::{MemsReport, TwoSymbolFigures};

/// Identified from, and predicted then, s.
const DAY_S: f64 = 86_400.0;

/// Measures everything on the experiments of a folder, and draws pictures into another.
///
/// # Errors
/// If an experiment is missing or a run fails.
pub fn measure(experiments: &Path, pictures: &Path, progress: &dyn Fn(&str)) -> Result<MemsReport> {
    let read = |name: &str| DeviceExperiment::read(&experiments.join(name));
    let picture = |name: &str| Canvas::create(&pictures.join(name));
    progress("two days of pseudo-random symbols");
    let prbs = read("prbs.toml")?;
    let record = records::run_of(&prbs)?;
    picture("mems-prbs.svg")?.draw(&plot::run::figure(&record.recording)?)?;
    let readings = readings::compare(&prbs, &record);
    progress("the diffusive model");
    let day = (DAY_S / record.symbol_time_s) as usize - 1;
    let options = IdentifyOptions {
        drift: DriftGiven::None,
        constraints: Constraints { initial_state: Some(InitialState::Rest), ..Constraints::default() },
        ..IdentifyOptions::default()
    };
    let model = identify(&mut record.table_of_bits(0..day)?, &options, &mut |_, _, _| {}, &mut |_| {})?;
    let rest = &mut record.table_of_bits(day..record.rows.len())?;
    let two_symbols = validate(&model, rest, ValidationStart::Continue, &mut |_| {})?;
    progress("bias steps");
    let steps = records::run_of(&read("steps.toml")?)?;
    picture("mems-steps.svg")?.draw(&plot::run::figure(&steps.recording)?)?;
    progress("closed loops");
    let held = loops::predicted(&model, &prbs)?;
    let days = loops::days(&read("days.toml")?, &|name, recording| {
        picture(name)?.draw(&plot::run::figure(recording)?)?;
        Ok(())
    })?;
    progress("plateaus");
    let plateaus = plateaus::compare(&read("locking.toml")?)?;
    let two_symbols = TwoSymbolFigures::of(&two_symbols, &model);
    Ok(MemsReport { readings, two_symbols, held, days, plateaus })
}
