//! Reading an experiment: every number of its file is checked, and refused with its line.

use std::path::Path;

use super::checked::Experiment;
use super::grid::TickGrid;
use super::models::Models;
use super::table::{AnswerTable, ExperimentTable, FaultTable, WindOutputTable};
use super::{drives, sweep, wind};
use crate::sensor::{GasSwing, TimedFault, construction_of};
use anemometry::gas::Species;
use anemometry::head::{Head, WindOutput};
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource};

/// Sample periods between 1 kHz and 1 Hz.
const SAMPLE_PERIODS_S: std::ops::RangeInclusive<f64> = 1e-3..=1.0;

impl Experiment {
    /// Reads an experiment, its head and its models.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::from_source(TomlSource::read(path)?)
    }

    /// Checks an experiment; paths count from the folder of its file.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn from_source(source: TomlSource) -> Result<Self, FileError> {
        let table: ExperimentTable = source.parse()?;
        let folder = source.path.parent().unwrap_or(Path::new(""));
        // A file that is not there is the experiment's mistake; one that is wrong is its own.
        let place = |key: &'static str| {
            let source = &source;
            move |error: FileError| match error.line {
                None => source.refuse(key, format!("cannot be used: {error}")),
                Some(_) => error,
            }
        };
        let mut head = Head::read(&folder.join(&table.head)).map_err(place("head"))?;
        let mut currents = Vec::with_capacity(table.currents.len());
        for (name, levels) in &table.currents {
            let place = head
                .set_currents(name, levels.low_a, levels.high_a)
                .map_err(|error| source.refuse(&format!("currents.{name}"), error.to_string()))?;
            currents.push(place);
        }
        currents.sort_unstable();
        of_one_gas(&source, &head, table.gas.species)?;
        let models = table.models.map(|path| Models::read(&folder.join(path), &head)).transpose();
        let models = models.map_err(place("models"))?;

        let sample_period_s = source.within("sample_period_s", table.sample_period_s, SAMPLE_PERIODS_S, "s")?;
        let grid = TickGrid { source: &source, sample_period_s };
        let ticks = grid.whole_ticks("duration_s", table.duration_s)?;
        let gas_temperature_c = table.gas.temperature_c;
        let gas_swing = table.gas.swing.map(GasSwing::from);
        swing_starts(&grid, gas_swing.as_ref(), table.duration_s)?;
        let drive_tables = table.drives;
        let wind_output = wind_output(&grid, table.wind_output, table.answer, &head)?;
        let mut experiment = Self {
            wind: match &table.sweep {
                Some(sweep) if table.wind.is_empty() && table.tunnel.is_none() => {
                    sweep::entries(&grid, sweep, table.seed, ticks)?
                }
                Some(_) => {
                    let sentence = "is given besides [[wind]] or [tunnel]: the wind comes from one of them";
                    return Err(source.refuse("sweep", sentence));
                }
                None => wind::entries(&grid, table.wind, table.tunnel, ticks)?,
            },
            faults: faults(&grid, &table.faults, &head, table.duration_s)?,
            title: table.title,
            construction: construction_of(&head)?,
            head,
            models,
            observe: table.observe,
            wind_output,
            sample_period_s,
            ticks,
            seed: table.seed,
            species: table.gas.species,
            pressure_pa: table.gas.pressure_pa,
            gas_temperature_c,
            gas_swing,
            support_temperature_c: table.support.map_or(gas_temperature_c, |support| support.temperature_c),
            imperfections: table.front_end.into(),
            currents,
            drives: Vec::new(),
            changes: Vec::new(),
            source: source.clone(),
        };
        if experiment.observe && experiment.observed().is_empty() {
            let sentence =
                "needs a model to observe, and no element has one: name a file with `models`, or leave it out";
            return Err(source.refuse("observe", sentence));
        }
        // Drives are judged by the gas's temperature, which has to be one first.
        experiment.check_conditions()?;
        experiment.drives = drives::of_all(&grid, &drive_tables, &experiment.head, experiment.gas_range())?;
        experiment.changes = drives::changes(&grid, &table.changes, &experiment.head, experiment.gas_range(), ticks)?;
        Ok(experiment)
    }
}

/// Refuses a gas in which the head was not calibrated.
fn of_one_gas(source: &TomlSource, head: &Head, species: Species) -> Result<(), FileError> {
    match &head.calibration {
        Some(calibration) if calibration.table.species != species => Err(source.refuse(
            "gas.species",
            format!(
                "is `{}`, but head `{}` is calibrated for {}: another gas is another calibration",
                species.name(),
                head.name,
                calibration.table.species.name()
            ),
        )),
        _ => Ok(()),
    }
}

/// How the wind estimate of a head with a calibration is output, by `[wind_output]` or the older
/// `[answer]`.
fn wind_output(
    grid: &TickGrid,
    table: Option<WindOutputTable>,
    older: Option<AnswerTable>,
    head: &Head,
) -> Result<Option<WindOutput>, FileError> {
    let source = grid.source;
    if table.is_some() && older.is_some() {
        return Err(source.refuse("answer", "is given besides [wind_output], which is its name now: keep one of them"));
    }
    let (key, interval_key) = if older.is_some() { ("answer", "every_s") } else { ("wind_output", "interval_s") };
    let table = table.or(older.map(WindOutputTable::from));
    if head.calibration.is_none() {
        return match table {
            None => Ok(None),
            Some(_) => {
                let sentence = "is given, but the head has no calibration: `anemo calibrate` makes one";
                Err(source.refuse(key, sentence))
            }
        };
    }
    let (bandwidth_hz, interval_s) =
        table.as_ref().map_or((None, None), |table| (table.bandwidth_hz, table.interval_s));
    let fixed = table.is_some_and(|table| table.fixed);
    if let Some(bandwidth_hz) = bandwidth_hz {
        source.within(&format!("{key}.bandwidth_hz"), bandwidth_hz, WindOutput::BANDWIDTHS_HZ, "Hz")?;
    }
    if let Some(interval_s) = interval_s {
        grid.whole_ticks(&format!("{key}.{interval_key}"), interval_s)?;
    }
    Ok(Some(WindOutput::new(bandwidth_hz, interval_s, fixed, grid.sample_period_s)))
}

/// A swing begins with a tick, and before the end.
fn swing_starts(grid: &TickGrid, swing: Option<&GasSwing>, duration_s: f64) -> Result<(), FileError> {
    let Some(swing) = swing else { return Ok(()) };
    grid.instant("gas.swing.start_s", swing.start_s)?;
    if swing.start_s >= duration_s {
        let sentence = format!("is {} s, but the experiment is over at {duration_s} s", swing.start_s);
        return Err(grid.source.refuse("gas.swing.start_s", sentence));
    }
    Ok(())
}

fn faults(grid: &TickGrid, tables: &[FaultTable], head: &Head, duration_s: f64) -> Result<Vec<TimedFault>, FileError> {
    let names = head.names();
    let fault = |(index, table): (usize, &FaultTable)| {
        let element = names.iter().position(|name| *name == table.element).ok_or_else(|| {
            let hint = suggest(&table.element, names.iter().copied());
            let sentence = format!("is `{}`, which is no element of head `{}`; {hint}", table.element, head.name);
            grid.source.refuse(&format!("faults[{index}].element"), sentence)
        })?;
        let key = format!("faults[{index}].start_s");
        grid.instant(&key, table.start_s)?;
        if table.start_s >= duration_s {
            let sentence = format!("is {} s, but the experiment is over at {duration_s} s", table.start_s);
            return Err(grid.source.refuse(&key, sentence));
        }
        Ok(TimedFault { element, fault: table.kind.into(), start_s: table.start_s })
    };
    tables.iter().enumerate().map(fault).collect()
}
