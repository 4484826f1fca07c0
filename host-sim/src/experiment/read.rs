//! Reading an experiment: every number of its file is checked, and refused with its line.

use std::path::Path;

use super::checked::Experiment;
use super::drives::DriveReader;
use super::grid::TickGrid;
use super::models::Models;
use super::table::{ExperimentTable, FaultTable, WindOutputTable};
use super::{sweep, wind};
use crate::sensor::field::FieldEffects;
use crate::sensor::{TimedFault, construction_of};
use anemometry::gas::Species;
use anemometry::head::{Head, WindOutput};
use dr_core::LONGEST_HOST_TIMEOUT_S;
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
        Self::with_head(source, None)
    }

    /// The same with a head that is at hand, whatever file the experiment names.
    ///
    /// # Errors
    /// As [`from_source`](Self::from_source).
    pub fn of_head(source: TomlSource, head: Head) -> Result<Self, FileError> {
        Self::with_head(source, Some(head))
    }

    fn with_head(source: TomlSource, head: Option<Head>) -> Result<Self, FileError> {
        let table: ExperimentTable = source.parse()?;
        let folder = source.path.parent().unwrap_or(Path::new(""));
        let read = || Head::read(&folder.join(&table.head)).map_err(|error| source.unusable("head", error));
        let mut head = head.map_or_else(read, Ok)?;
        let mut currents = Vec::with_capacity(table.currents.len());
        for (name, levels) in &table.currents {
            let place = head
                .set_currents(name, levels.low_a, levels.high_a)
                .map_err(|error| source.refuse(&format!("currents.{name}"), error.to_string()))?;
            currents.push(place);
        }
        currents.sort_unstable();
        for name in table.front_end.current_ratio_error_ppm.keys() {
            if !head.names().contains(&name.as_str()) {
                let hint = suggest(name, head.names());
                let key = format!("front_end.current_ratio_error_ppm.{name}");
                return Err(source.refuse(&key, format!("is no element of head `{}`; {hint}", head.name)));
            }
        }
        of_one_gas(&source, &head, table.gas.species)?;
        let models = table.models.map(|path| Models::read(&folder.join(path), &head)).transpose();
        let models = models.map_err(|error| source.unusable("models", error))?;

        let sample_period_s = source.within("sample_period_s", table.sample_period_s, SAMPLE_PERIODS_S, "s")?;
        let grid = TickGrid::new(&source, sample_period_s, table.duration_s)?;
        let gas_temperature_c = table.gas.temperature_c;
        if let Some(swing) = &table.gas.swing {
            grid.check_start("gas.swing.start_s", swing.start_s)?;
        }
        let wind_output = wind_output(&grid, table.wind_output, &head)?;
        let mut experiment = Self {
            wind: match (&table.sweep, &table.tunnel, &table.wind[..]) {
                (Some(sweep), None, []) => sweep::entries(&grid, sweep, table.seed)?,
                (Some(_), _, _) => {
                    let sentence = "is given besides [[wind]] or [tunnel]: the wind comes from one of them";
                    return Err(source.refuse("sweep", sentence));
                }
                (None, Some(tunnel), []) => wind::tunnel_entries(&grid, tunnel)?,
                (None, Some(_), _) => {
                    let sentence = "is given besides [[wind]]: the wind comes from one of them";
                    return Err(source.refuse("tunnel", sentence));
                }
                (None, None, tables) => wind::held_entries(&grid, tables)?,
            },
            field: FieldEffects {
                surface_heat: table.surface_heat,
                sun: table.sun,
                sky: table.sky,
                drifts: table.drifts,
                gas_properties: table.gas.properties,
                buoyancy: table.buoyancy,
                stem: table.stem,
            },
            faults: faults(&grid, &table.faults, &head)?,
            title: table.title,
            construction: construction_of(&head)?,
            head,
            models,
            observe: table.observe,
            host_timeout_s: table.host_timeout_s,
            wind_output,
            sample_period_s,
            ticks: grid.ticks,
            seed: table.seed,
            species: table.gas.species,
            pressure_pa: table.gas.pressure_pa,
            gas_temperature_c,
            gas_swing: table.gas.swing,
            support_temperature_c: table.support.as_ref().map_or(gas_temperature_c, |support| support.temperature_c),
            support_swing: table.support.and_then(|support| support.swing),
            imperfections: table.front_end,
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
        if let Some(timeout_s) = experiment.host_timeout_s
            && !(0.0..=LONGEST_HOST_TIMEOUT_S).contains(&timeout_s)
        {
            let sentence = format!("must lie between 0, for ever, and {LONGEST_HOST_TIMEOUT_S} s");
            return Err(source.refuse("host_timeout_s", sentence));
        }
        // Drives are judged by the gas's temperature, which has to be one first.
        experiment.check_conditions()?;
        let drives = DriveReader { grid: &grid, head: &experiment.head, gas: experiment.gas_range() };
        let (mut at_first, mut later) = (drives.all(&table.drives)?, drives.changes(&table.changes)?);
        if let Some(alternation) = &table.overheat_alternation {
            drives.alternate(alternation, &mut at_first, &mut later)?;
        }
        (experiment.drives, experiment.changes) = (at_first, later);
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

/// Output of the wind estimate of a head with a calibration.
fn wind_output(grid: &TickGrid, table: Option<WindOutputTable>, head: &Head) -> Result<Option<WindOutput>, FileError> {
    let source = grid.source;
    if head.calibration.is_none() {
        let sentence = "is given, but the head has no calibration: `anemo calibrate` makes one";
        return table.map_or(Ok(None), |_| Err(source.refuse("wind_output", sentence)));
    }
    let WindOutputTable { bandwidth_hz, interval_s, fixed } = table.unwrap_or_default();
    if let Some(bandwidth_hz) = bandwidth_hz {
        source.within("wind_output.bandwidth_hz", bandwidth_hz, WindOutput::BANDWIDTHS_HZ, "Hz")?;
    }
    if let Some(interval_s) = interval_s {
        grid.whole_ticks("wind_output.interval_s", interval_s)?;
    }
    Ok(Some(WindOutput::new(bandwidth_hz, interval_s, fixed, grid.sample_period_s)))
}

fn faults(grid: &TickGrid, tables: &[FaultTable], head: &Head) -> Result<Vec<TimedFault>, FileError> {
    let names = head.names();
    let fault = |(index, table): (usize, &FaultTable)| {
        let element = names.iter().position(|name| *name == table.element).ok_or_else(|| {
            let hint = suggest(&table.element, names.iter().copied());
            let sentence = format!("is `{}`, which is no element of head `{}`; {hint}", table.element, head.name);
            grid.source.refuse(&format!("faults[{index}].element"), sentence)
        })?;
        grid.check_start(&format!("faults[{index}].start_s"), table.start_s)?;
        Ok(TimedFault { element, fault: table.kind, start_s: table.start_s })
    };
    tables.iter().enumerate().map(fault).collect()
}
