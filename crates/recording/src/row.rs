//! Columns of a recording's rows.

use std::path::Path;

use crate::column::RowCell;
use crate::error::RecordingError;
use crate::names::{
    EQUIVALENT_POWER, EVENT, GAS_TEMPERATURE, HEATER, POWER, STATE, TEMPERATURE, TIME, TRUE_WIND, UNKNOWN_HEAT,
    column_name, shared_column,
};
use crate::wind;

/// Columns of a recording's rows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordingLayout {
    /// Names of the elements, in the order of the rows' slices.
    pub elements: Vec<String>,
    /// The rows carry the true wind.
    pub true_wind: bool,
    /// The rows carry the true temperature of the gas.
    pub gas: bool,
    /// Names of the elements whose rows carry the equivalent power of an observer.
    pub observed: Vec<String>,
    /// Names of the elements of a head that outputs wind estimates; none if it does not.
    pub estimates: Vec<String>,
    /// The rows carry a wind by several instruments, in place of such estimates.
    pub combined_wind: bool,
    /// The wind of the head is followed by that of the earth, [`wind::EARTH`].
    pub earth_wind: bool,
    /// Names of the elements without a surface, whose unknown heat ends a row; none if it does not.
    pub cores: Vec<String>,
    /// Names of further columns of numbers, which end a row.
    pub numbers: Vec<String>,
}

/// One tick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RecordingRow<'a> {
    /// Time, s.
    pub time_s: f64,
    /// At `time_s`, one an element; NaN where the reading was no temperature.
    pub temperature_c: &'a [f32],
    /// Held until the next row, one an element.
    pub power_w: &'a [f32],
    /// At `time_s`, one an observed element.
    pub equivalent_power_w: &'a [f32],
    /// Bit i set: element i is held at its high level until the next row.
    pub heaters: usize,
    /// Label of the conditions.
    pub event: &'a str,
    /// State of the instrument.
    pub state: &'a str,
    /// Wind of the simulation, held until the next row.
    pub true_wind_m_s: Option<[f64; 3]>,
    /// Held until the next row.
    pub gas_temperature_c: Option<f64>,
    /// The wind estimate, as [`wind::numbers`] has it, with the earth's wind, unknown heats and
    /// further numbers.
    pub estimate: &'a [f32],
}

impl RecordingRow<'_> {
    /// The row's cells, in the order of [`RecordingLayout::columns`].
    pub(crate) fn cells(&self) -> impl Iterator<Item = RowCell<'_>> {
        let heaters = (0..self.temperature_c.len()).map(|i| RowCell::Number(f64::from(self.heaters >> i & 1 == 1)));
        let conditions = self.true_wind_m_s.into_iter().flatten().chain(self.gas_temperature_c);
        std::iter::once(RowCell::Number(self.time_s))
            .chain(numbers(self.temperature_c))
            .chain(numbers(self.power_w))
            .chain(numbers(self.equivalent_power_w))
            .chain(heaters)
            .chain([RowCell::Text(self.event), RowCell::Text(self.state)])
            .chain(conditions.map(RowCell::Number))
            .chain(numbers(self.estimate))
    }
}

/// Cells of numbers.
fn numbers<'a>(numbers: &'a [f32]) -> impl Iterator<Item = RowCell<'a>> {
    numbers.iter().map(|&number| RowCell::Number(number.into()))
}

impl RecordingLayout {
    /// Names of the columns, in the order in which they are written.
    pub(crate) fn columns(&self) -> Vec<String> {
        let of = |quantity: &'static str, elements: &[String]| -> Vec<String> {
            elements.iter().map(|element| column_name(quantity, element)).collect()
        };
        let mut columns = vec![TIME.to_owned()];
        columns.extend(of(TEMPERATURE, &self.elements));
        columns.extend(of(POWER, &self.elements));
        columns.extend(of(EQUIVALENT_POWER, &self.observed));
        columns.extend(of(HEATER, &self.elements));
        columns.extend([EVENT, STATE].map(str::to_owned));
        if self.true_wind {
            columns.extend(TRUE_WIND.map(str::to_owned));
        }
        if self.gas {
            columns.push(GAS_TEMPERATURE.to_owned());
        }
        columns.extend(self.wind_columns());
        columns
    }

    /// Names of the columns of the wind.
    fn wind_columns(&self) -> Vec<String> {
        let mut columns = match self.combined_wind {
            true => wind::COMBINED.map(str::to_owned).to_vec(),
            false => wind::columns(&self.estimates),
        };
        if self.earth_wind {
            columns.extend(wind::EARTH.map(str::to_owned));
        }
        columns.extend(self.cores.iter().map(|core| column_name(UNKNOWN_HEAT, core)));
        columns.extend(self.numbers.iter().cloned());
        columns
    }

    /// Refuses elements that the rows cannot carry.
    pub(crate) fn check_elements(&self, path: &Path) -> Result<(), RecordingError> {
        let fault = match self.elements.len() {
            count if count > usize::BITS as usize => {
                Some(format!("{count} elements do not fit: {} do at most", usize::BITS))
            }
            _ => shared_column(self.elements.iter().map(String::as_str)),
        };
        fault.map_or(Ok(()), |sentence| Err(RecordingError::new(path, sentence)))
    }

    pub(crate) fn check(&self, row: &RecordingRow) -> Result<(), RecordingError> {
        let (elements, estimates) = (self.elements.len(), self.wind_columns().len());
        let counts = [
            (row.temperature_c.len(), "temperatures for", elements, "elements"),
            (row.power_w.len(), "powers for", elements, "elements"),
            (row.equivalent_power_w.len(), "equivalent powers for", self.observed.len(), "observed elements"),
            (row.estimate.len(), "numbers of a wind estimate where", estimates, "belong"),
        ];
        let refuse = |sentence: &str| Err(RecordingError::row(row.time_s, sentence));
        if let Some((given, what, wanted, of)) = counts.into_iter().find(|(given, _, wanted, _)| given != wanted) {
            return refuse(&format!("{given} {what} {wanted} {of}"));
        }
        if row.true_wind_m_s.is_some() != self.true_wind {
            return refuse("the wind belongs in every row or in none");
        }
        if row.gas_temperature_c.is_some() != self.gas {
            return refuse("the temperature of the gas belongs in every row or in none");
        }
        if !row.time_s.is_finite() {
            return refuse("its time is not finite");
        }
        Ok(())
    }
}
