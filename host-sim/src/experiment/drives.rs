//! Drives of the elements of an experiment, at first and later.

use std::collections::BTreeMap;

use dr_core::Parameter;
use dr_core::control::Drive;
use dr_core::sensor::Level;

use super::grid::TickGrid;
use super::table::{ChangeTable, DriveTable, OverheatAlternationTable};
use anemometry::head::{Head, HeadElement};
use recording::text::{suggest, tidy};
use recording::toml_file::FileError;

/// Between which temperatures the gas is, °C: the same twice for one that does not swing.
#[derive(Debug, Clone, Copy)]
pub(super) struct GasRange {
    pub coldest_c: f64,
    pub hottest_c: f64,
}

impl GasRange {
    /// Words of a sentence, without unit.
    fn words(self) -> String {
        if self.coldest_c == self.hottest_c {
            return self.coldest_c.to_string();
        }
        format!("{} to {}", tidy(self.coldest_c), tidy(self.hottest_c))
    }
}

/// Limit of a head that ends the set-points.
fn beyond_limit(hottest_c: f32, limit: Parameter) -> String {
    match limit {
        Parameter::TemperatureMaxC => format!("the head's limit is {hottest_c} °C"),
        Parameter::ResistanceMaxOhm => {
            format!("the element counts as open above {hottest_c:.1} °C, by the head's `resistance_max_ohm`")
        }
        _ => format!("the converter's range ends at {hottest_c:.1} °C with the high current: lower the current"),
    }
}

/// Drives of elements from a tick on.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveChange {
    /// The first sample period of the new drives.
    pub tick: u32,
    /// Place of the element in the head, and its new drive. The others go on.
    pub drives: Vec<(usize, Drive)>,
}

/// Reads drives for the elements of a head in a gas.
pub(super) struct DriveReader<'a> {
    pub grid: &'a TickGrid<'a>,
    pub head: &'a Head,
    pub gas: GasRange,
}

impl DriveReader<'_> {
    /// One drive an element of the head, in its order; one without is passive.
    pub(super) fn all(&self, tables: &BTreeMap<String, DriveTable>) -> Result<Vec<Drive>, FileError> {
        let mut drives = vec![Drive::Passive; self.head.elements.len()];
        for (element, drive) in self.named("drives", tables)? {
            drives[element] = drive;
        }
        Ok(drives)
    }

    /// The changes of an experiment.
    pub(super) fn changes(&self, tables: &[ChangeTable]) -> Result<Vec<DriveChange>, FileError> {
        let grid = self.grid;
        let mut changes: Vec<DriveChange> = Vec::with_capacity(tables.len());
        for (index, table) in tables.iter().enumerate() {
            let key = format!("changes[{index}]");
            let start_key = format!("{key}.start_s");
            let tick = grid.whole_ticks(&start_key, table.start_s)?;
            if tick >= grid.ticks {
                return Err(grid.over(&start_key, table.start_s));
            }
            if let Some(before) = changes.last().filter(|before| before.tick >= tick) {
                let (before_s, next_s) = (grid.time_s(before.tick), grid.time_s(before.tick + 1));
                let sentence = format!(
                    "is {} s: changes must come in the order of their start, one at a time, and the one before starts at {before_s} s, so that {next_s} s or later would do",
                    table.start_s
                );
                return Err(grid.source.refuse(&start_key, sentence));
            }
            if table.drives.is_empty() {
                return Err(grid.source.refuse(&key, "changes nothing: give it `drives`, one line an element"));
            }
            changes.push(DriveChange { tick, drives: self.named(&format!("{key}.drives"), &table.drives)? });
        }
        Ok(changes)
    }

    /// The drives of a table, by their elements' places in the head.
    fn named(&self, key: &str, tables: &BTreeMap<String, DriveTable>) -> Result<Vec<(usize, Drive)>, FileError> {
        let known = self.head.names();
        let of = |(name, table): (&String, &DriveTable)| {
            let key = format!("{key}.{name}");
            let Some(place) = known.iter().position(|own| own == name) else {
                let hint = suggest(name, known.iter().copied());
                let sentence = format!("is no element of head `{}`; {hint}", self.head.name);
                return Err(self.grid.source.refuse(&key, sentence));
            };
            Ok((place, self.drive(&key, table, &self.head.elements[place])?))
        };
        tables.iter().map(of).collect()
    }

    /// One drive, whose key in the file is `key`.
    fn drive(&self, key: &str, table: &DriveTable, element: &HeadElement) -> Result<Drive, FileError> {
        let (grid, source, gas) = (self.grid, self.grid.source, self.gas);
        if element.only_senses && !matches!(table, DriveTable::Passive | DriveTable::Level(Level::Low)) {
            let sentence = format!("drives `{}`, which only senses (`only_senses` of the head)", element.name);
            return Err(source.refuse(key, sentence));
        }
        Ok(match *table {
            DriveTable::Passive => Drive::Passive,
            DriveTable::Level(level) => Drive::Level(level),
            DriveTable::PowerW(power_w) => {
                // Nothing gets colder than the gas, and a platinum resistor that warms up takes
                // more power. In a gas that swings both levels have to do at every time.
                let least = element.power_w(gas.hottest_c, Level::Low);
                let most = element.power_w(gas.coldest_c, Level::High);
                if !(least..=most).contains(&power_w) {
                    let sentence = format!(
                        "is {power_w} W: the levels of {} reach from {least:.5} to {most:.5} W at the gas's {} °C",
                        element.name,
                        gas.words()
                    );
                    return Err(source.refuse(&format!("{key}.power_w"), sentence));
                }
                Drive::Power { power_w: power_w as f32 }
            }
            DriveTable::TemperatureC(target_c) => {
                let (key, stated) = (format!("{key}.temperature_c"), format!("{target_c} °C"));
                Drive::Temperature { target_c: self.set_point(&key, target_c, &stated, element)? }
            }
            DriveTable::Prbs { order, bit_time_s, seed } => {
                grid.prbs(&format!("{key}.prbs"), order, bit_time_s, seed)?
            }
            DriveTable::Alternation { low_c, high_c, half_s } => {
                let key = format!("{key}.alternation");
                let [low_c, high_c] = self.pair(&key, [low_c, high_c], None, element)?;
                let half_ticks = grid.whole_ticks(&format!("{key}.half_s"), half_s)?;
                Drive::Alternation { low_c, high_c, half_ticks }
            }
            DriveTable::Setpoints { low_c, high_c, dwell_s, seed } => {
                let [low_c, high_c] = self.pair(&format!("{key}.setpoints"), [low_c, high_c], None, element)?;
                let dwell_ticks = grid.whole_ticks(&format!("{key}.setpoints.dwell_s"), dwell_s)?;
                Drive::Setpoints { low_c, high_c, dwell_ticks, seed }
            }
        })
    }

    /// Two set-points, the lowest first, as the file states them in °C, or in K above this
    /// temperature.
    fn pair(
        &self,
        key: &str,
        both: [f64; 2],
        gas_c: Option<f64>,
        element: &HeadElement,
    ) -> Result<[f32; 2], FileError> {
        let (end, unit) = if gas_c.is_some() { ("k", "K") } else { ("c", "°C") };
        let set_point = |which: &str, value: f64| {
            let celsius = value + gas_c.unwrap_or(0.0);
            let stated = format!("{value} {unit}");
            let stated =
                if gas_c.is_some() { format!("{stated} above the gas, {} °C", tidy(celsius)) } else { stated };
            self.set_point(&format!("{key}.{which}_{end}"), celsius, &stated, element)
        };
        let [low, high] = both;
        let both_c = [set_point("low", low)?, set_point("high", high)?];
        if both_c[0] >= both_c[1] {
            let sentence = format!("is {high} {unit}: it must lie above `low_{end}`, {low} {unit}");
            return Err(self.grid.source.refuse(&format!("{key}.high_{end}"), sentence));
        }
        Ok(both_c)
    }

    /// Every element that holds a temperature, from its start or a change on, alternates between
    /// two overheats above the mean of the gas.
    pub(super) fn alternate(
        &self,
        table: &OverheatAlternationTable,
        drives: &mut [Drive],
        changes: &mut [DriveChange],
    ) -> Result<(), FileError> {
        let half_key = "overheat_alternation.half_s";
        let half_ticks = self.grid.whole_ticks(half_key, table.half_s)?;
        if half_ticks >= self.grid.ticks {
            let sentence = format!("is {} s, as long as the run or longer: six halves show heat", table.half_s);
            return Err(self.grid.source.refuse(half_key, sentence));
        }
        let gas_c = 0.5 * (self.gas.coldest_c + self.gas.hottest_c);
        let places = drives.iter_mut().enumerate();
        let later = changes.iter_mut().flat_map(|of| &mut of.drives).map(|(place, drive)| (*place, drive));
        let mut count = 0;
        for (place, drive) in places.chain(later) {
            if matches!(drive, Drive::Temperature { .. }) {
                let (both_k, element) = ([table.low_k, table.high_k], &self.head.elements[place]);
                let [low_c, high_c] = self.pair("overheat_alternation", both_k, Some(gas_c), element)?;
                *drive = Drive::Alternation { low_c, high_c, half_ticks };
                count += 1;
            }
        }
        if count == 0 {
            let sentence = "alternates nothing: no element has a `temperature_c` in `drives`";
            return Err(self.grid.source.refuse("overheat_alternation", sentence));
        }
        Ok(())
    }

    /// A temperature that an element can have, in words as `stated`: above the gas at every time,
    /// and below its limit.
    fn set_point(&self, key: &str, celsius: f64, stated: &str, element: &HeadElement) -> Result<f32, FileError> {
        let (hottest_c, limit) = element.config.hottest_set_point();
        let sentence = if celsius.is_nan() || celsius > f64::from(hottest_c) {
            format!("is {stated}: {}", beyond_limit(hottest_c, limit))
        } else if celsius <= self.gas.hottest_c {
            let gas = self.gas.words();
            format!("is {stated}, but the gas has {gas} °C and a heater cannot cool: it must lie above")
        } else {
            return Ok(celsius as f32);
        };
        Err(self.grid.source.refuse(key, sentence))
    }
}
