//! Reading an experiment: every number is checked, and refused with its line.

use std::path::Path;

use dr_core::control::Drive;
use dr_core::sensor::Level;
use host_sim::experiment::TickGrid;
use recording::toml_file::{FileError, TomlSource};
use serde::Deserialize;

use super::{DeviceExperiment, DevicePhase};
use crate::device::Device;
use crate::port::SymbolShape;
use crate::simulated::SurroundingsPoint;

/// Symbols between 100 Hz and 0.1 Hz, the longest tick of a controller.
const SYMBOL_TIMES_S: std::ops::RangeInclusive<f64> = 0.01..=10.0;
/// Gain of the integrator of a loop of second order, if none is given.
const GAIN: f64 = 0.1;

/// The file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DeviceExperimentTable {
    title: String,
    device: String,
    symbol_time_s: f64,
    duration_s: f64,
    #[serde(default)]
    seed: u64,
    unreachable_after_s: Option<f64>,
    drive: SymbolDriveTable,
    symbols: SymbolShape,
    #[serde(default)]
    changes: Vec<PhaseTable>,
    #[serde(default)]
    surroundings: Vec<SurroundingsPoint>,
}

/// A drive: a word, or a table of one key.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum SymbolDriveTable {
    Zero,
    Symbol(i8),
    MeanSymbol(f64),
    Prbs {
        order: u8,
        bit_time_s: f64,
        seed: u32,
    },
    Hold {
        shift_v: f64,
        #[serde(default = "first")]
        order: u8,
        gain: Option<f64>,
    },
}

const fn first() -> u8 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PhaseTable {
    start_s: f64,
    drive: SymbolDriveTable,
    #[serde(default)]
    label: String,
}

impl DeviceExperiment {
    /// Reads an experiment and its device.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::from_source(TomlSource::read(path)?)
    }

    /// Checks an experiment; its device's path counts from the folder of its file.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn from_source(source: TomlSource) -> Result<Self, FileError> {
        let table: DeviceExperimentTable = source.parse()?;
        let folder = source.path.parent().unwrap_or(Path::new(""));
        let device = Device::read(&folder.join(&table.device)).map_err(|error| source.unusable("device", error))?;
        let symbol_time_s = source.within("symbol_time_s", table.symbol_time_s, SYMBOL_TIMES_S, "s")?;
        let grid = TickGrid::new(&source, symbol_time_s, table.duration_s)?;
        if grid.ticks < 2 {
            let sentence =
                format!("is {} s: the first reading comes after one symbol, so two belong here", table.duration_s);
            return Err(source.refuse("duration_s", sentence));
        }
        let shape = shape(&source, &device, &table, symbol_time_s)?;
        let noise_v = device.shift_noise_v(&shape);
        if noise_v > device.limits.shift_max_v {
            let sentence = format!(
                "is so near `negative_v` that the noise of the meter is {noise_v:.3} V of voltage shift, more than `shift_max_v`: take voltages further apart"
            );
            return Err(source.refuse("symbols.positive_v", sentence));
        }
        let unreachable = table.unreachable_after_s.map(|time_s| grid.whole_ticks("unreachable_after_s", time_s));
        let reader = SymbolDriveReader { grid: &grid, device: &device };
        let mut phases =
            vec![DevicePhase { tick: 0, label: String::new(), drive: reader.drive("drive", &table.drive)? }];
        for (index, change) in table.changes.iter().enumerate() {
            let key = |key: &str| format!("changes[{index}].{key}");
            let tick = grid.whole_ticks(&key("start_s"), change.start_s)?;
            grid.check_start(&key("start_s"), change.start_s)?;
            if phases.last().is_some_and(|before| before.tick >= tick) {
                let sentence = format!("is {} s: changes must come in the order of their start", change.start_s);
                return Err(source.refuse(&key("start_s"), sentence));
            }
            let label = change.label.clone();
            phases.push(DevicePhase { tick, label, drive: reader.drive(&key("drive"), &change.drive)? });
        }
        check_surroundings(&source, &table.surroundings)?;
        Ok(Self {
            title: table.title,
            shape,
            ticks: grid.ticks,
            seed: table.seed,
            unreachable_ticks: unreachable.transpose()?.unwrap_or(u32::MAX - 1),
            phases,
            surroundings: table.surroundings,
            device,
            source,
        })
    }
}

/// Voltages that the device bears, and that differ.
fn shape(
    source: &TomlSource,
    device: &Device,
    table: &DeviceExperimentTable,
    symbol_time_s: f64,
) -> Result<SymbolShape, FileError> {
    let symbols = &table.symbols;
    for (key, bias_v) in [("symbols.positive_v", symbols.positive_v), ("symbols.negative_v", symbols.negative_v)] {
        let most_v = device.limits.bias_max_v;
        if !(-most_v..=most_v).contains(&bias_v) {
            let sentence = format!(
                "is {bias_v} V: device `{}` bears at most {most_v} V either way (`bias_max_v` of its file)",
                device.name
            );
            return Err(source.refuse(key, sentence));
        }
        if bias_v.abs() + device.limits.shift_max_v >= device.capacitor.pull_in_v {
            let sentence = format!(
                "is {bias_v} V: with a voltage shift of up to {} V (`shift_max_v`) that reaches pull-in, {} V; {:.3} V would not",
                device.limits.shift_max_v,
                device.capacitor.pull_in_v,
                device.capacitor.pull_in_v - device.limits.shift_max_v
            );
            return Err(source.refuse(key, sentence));
        }
    }
    if symbols.negative_v >= symbols.positive_v {
        let sentence = format!("is {} V: it must lie below `positive_v`, {} V", symbols.negative_v, symbols.positive_v);
        return Err(source.refuse("symbols.negative_v", sentence));
    }
    source.within("symbols.second_share", symbols.second_share, 0.001..=0.999, "")?;
    Ok(SymbolShape { symbol_time_s, ..*symbols })
}

fn check_surroundings(source: &TomlSource, points: &[SurroundingsPoint]) -> Result<(), FileError> {
    for (index, point) in points.iter().enumerate() {
        let key = |key: &str| format!("surroundings[{index}].{key}");
        source.within(&key("start_s"), point.start_s, 0.0..=f64::MAX, "s")?;
        source.within(&key("temperature_c"), point.temperature_c, -273.15..=1000.0, "°C")?;
        source.within(&key("humidity_percent"), point.humidity_percent, 0.0..=100.0, "%")?;
        if index > 0 && points[index - 1].start_s >= point.start_s {
            let sentence = format!("is {} s: points must come in the order of their start", point.start_s);
            return Err(source.refuse(&key("start_s"), sentence));
        }
    }
    Ok(())
}

struct SymbolDriveReader<'a> {
    grid: &'a TickGrid<'a>,
    device: &'a Device,
}

impl SymbolDriveReader<'_> {
    fn drive(&self, key: &str, table: &SymbolDriveTable) -> Result<Drive, FileError> {
        let source = self.grid.source;
        Ok(match table {
            SymbolDriveTable::Zero => Drive::Passive,
            SymbolDriveTable::Symbol(1) => Drive::Level(Level::High),
            SymbolDriveTable::Symbol(-1) => Drive::Level(Level::Low),
            SymbolDriveTable::Symbol(other) => {
                return Err(source.refuse(&format!("{key}.symbol"), format!("is {other}: it is 1 or -1")));
            }
            SymbolDriveTable::MeanSymbol(mean) => {
                let power_w = source.within(&format!("{key}.mean_symbol"), *mean, -1.0..=1.0, "")? as f32;
                Drive::Power { power_w }
            }
            SymbolDriveTable::Prbs { order, bit_time_s, seed } => {
                self.grid.prbs(&format!("{key}.prbs"), *order, *bit_time_s, *seed)?
            }
            SymbolDriveTable::Hold { shift_v, order, gain } => {
                self.hold(&format!("{key}.hold"), *shift_v, *order, *gain)?
            }
        })
    }

    fn hold(&self, key: &str, shift_v: f64, order: u8, gain: Option<f64>) -> Result<Drive, FileError> {
        let source = self.grid.source;
        let most_v = self.device.limits.shift_max_v;
        let target = source.within(&format!("{key}.shift_v"), shift_v, -most_v..=most_v, "V")? as f32;
        match order {
            1 if gain.is_some() => Err(source
                .refuse(&format!("{key}.gain"), "is of a loop of second order: leave it out, or give `order = 2`")),
            1 => Ok(Drive::Temperature { target_c: target }),
            2 => {
                let gain = source.within(&format!("{key}.gain"), gain.unwrap_or(GAIN), 1e-6..=1.0, "a symbol")?;
                Ok(Drive::SecondOrder { target, gain_per_tick: gain as f32 })
            }
            other => Err(source.refuse(&format!("{key}.order"), format!("is {other}: loops are of order 1 or 2"))),
        }
    }
}
