//! Steady winds of a user's own table: a row each, in place of recordings.
//!
//! | column | |
//! |---|---|
//! | `wind_x_m_s`, `wind_y_m_s`, `wind_z_m_s` | where the gas goes to, in the head's frame; or |
//! | `speed_m_s`, and `angle_deg` | 0 is still gas; the angle is that from which it comes, from x towards y of the head. A single element needs none |
//! | `power_w_NAME`, `temperature_c_NAME` | of each element; of a head with one surface also `power_w` and `temperature_c` |
//! | `gas_temperature_c`, `gas_pressure_pa`, `gas_species` | of the gas; species `air` or `co2` |
//! | `event` | label of the row, if there is one |
//!
//! Losses are read off as of recordings, by the observer of the quiescent-gas network: its first
//! step takes the head as standing under the row's powers. A table by itself makes a network, too:
//! that of surfaces that do not warm each other, with one relaxation each, whose rate the user
//! knows. Its conductance is the least of the table, if a row is of still gas, else `HALF` of it:
//! what the network leaves to the wind only moves between King's A and G0.

use std::path::Path;

use diffusive::model::Conditions;
use dr_core::control::MOST_ELEMENTS;
use dr_core::model::{ConvectionObserverState, TickInput};
use dr_core::sensor::Level;
use recording::text::tidy;
use recording::{
    EVENT, GAS_TEMPERATURE, GIVEN_WIND, POWER, Recording, RecordingError, RecordingReader, TEMPERATURE, TIME,
};

use super::steady_wind::{SteadyWind, SurfaceReading};
use super::steady_winds::{BANDWIDTH_HZ, ObservedHead};

use crate::gas::{IdealGas, Species, ZERO_CELSIUS_K};
use crate::head::element::HeadElement;
use crate::head::file::Head;
use crate::network::parameters::{CrossHeatingParameters, QuiescentNetwork, ReadingNoise, SelfHeatingParameters};

const SPEED: &str = "speed_m_s";
const ANGLE: &str = "angle_deg";
const PRESSURE: &str = "gas_pressure_pa";
const SPECIES: &str = "gas_species";
/// Relative uncertainty of a power of a table, at least.
const POWER_ERROR: f64 = 1e-3;
/// Share of the conductance in the slowest wind that is that of still gas, where no row is.
const HALF: f64 = 0.5;
/// Powers of a table beyond so many times an element's own at its high level are in another unit.
const MOST_OF_HIGH: f64 = 10.0;
/// The first step of an observer does not depend on it.
const ANY_PERIOD_S: f64 = 1e-2;

/// Tells whether a file is a table of steady winds: it has winds, and no time.
///
/// # Errors
/// If it cannot be read.
pub fn is_table(path: &Path) -> Result<bool, RecordingError> {
    let reader = RecordingReader::open(path)?;
    let has = |name: &str| reader.names().iter().any(|known| known == name);
    Ok(!has(TIME) && (has(SPEED) || has(GIVEN_WIND[0])))
}

/// A table of steady winds.
pub struct SteadyTable {
    table: Recording,
    species: Species,
}

impl SteadyTable {
    /// Reads a table.
    ///
    /// # Errors
    /// If it cannot be read, or has not one gas.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let table = Recording::read(path)?;
        let refuse = |sentence: String| RecordingError::new(path, sentence);
        let words = table.words(SPECIES).map_err(|_| {
            refuse(format!(
                "has no column `{SPECIES}`: `air` or `co2` belongs there, beside `{PRESSURE}` and `{GAS_TEMPERATURE}`"
            ))
        })?;
        let [name] = words.dictionary() else {
            return Err(refuse("has more than one gas: a calibration is of one".to_owned()));
        };
        let species =
            Species::named(name).ok_or_else(|| refuse(format!("has the gas `{name}`; `air` and `co2` are known")))?;
        Ok(Self { table, species })
    }

    /// A network by the table alone, and its conditions: one relaxation for each surface, which
    /// takes `time_constant_s`, and no cross-heating.
    ///
    /// # Errors
    /// If a column is missing, or an element is not warmer than the gas.
    pub fn network(
        &self,
        head: &Head,
        surfaces: &[usize],
        time_constant_s: f64,
    ) -> Result<(QuiescentNetwork, Conditions), RecordingError> {
        let gas_c = self.table.finite(GAS_TEMPERATURE)?;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let rest_c = mean(gas_c);
        let has_still_gas = self.wind_m_s(head, surfaces)?.contains(&[0.0; 3]);
        let rise_share = if has_still_gas { 1.0 } else { HALF.recip() };
        let mesh_rad_s = vec![time_constant_s.recip()];
        let mut own = Vec::new();
        for &element in surfaces {
            let of = &head.elements[element];
            let (power_w, temperature_c) = self.readings(of, surfaces.len())?;
            let rises = power_w.iter().zip(temperature_c).zip(gas_c).map(|((power_w, element_c), gas_c)| {
                let rise_k_per_w = (element_c - gas_c) / power_w;
                (rise_k_per_w.is_finite() && rise_k_per_w > 0.0).then_some(rise_k_per_w)
            });
            let rises: Option<Vec<f64>> = rises.collect();
            let rises = rises.ok_or_else(|| {
                self.refuse(format!("`{}` is in some row without power, or not warmer than the gas", of.name))
            })?;
            let code_k = head.volt_per_code / (of.nominal.current_low_a * of.ohm_per_k(mean(temperature_c)));
            own.push(SelfHeatingParameters {
                element,
                name: of.name.clone(),
                rest_c,
                noise: ReadingNoise::by_low(code_k, &of.nominal),
                mesh_rad_s: mesh_rad_s.clone(),
                r_k_per_w: vec![rise_share * rises.into_iter().fold(0.0, f64::max)],
                surface: Some(vec![1.0]),
                layers: Vec::new(),
            });
        }
        let pairs = own.iter().flat_map(|from| own.iter().map(move |to| (from, to)));
        let cross = pairs.filter(|(from, to)| from.element != to.element).map(|(from, to)| CrossHeatingParameters {
            from: from.element,
            to: to.element,
            from_name: from.name.clone(),
            to_name: to.name.clone(),
            mesh_rad_s: mesh_rad_s.clone(),
            r_k_per_w: vec![0.0],
            surface: vec![1.0],
        });
        let conditions = Conditions {
            species: self.species.name().to_owned(),
            pressure_pa: mean(self.table.finite(PRESSURE)?),
            gas_temperature_c: rest_c,
            support_temperature_c: rest_c,
        };
        Ok((QuiescentNetwork { cross: cross.collect(), own }, conditions))
    }

    /// The steady winds of its rows.
    ///
    /// # Errors
    /// If a column is missing, or a row cannot be meant.
    pub fn winds(&self, observed: &ObservedHead<'_>) -> Result<Vec<SteadyWind>, RecordingError> {
        if self.species != observed.species {
            let (own, known) = (self.species.name(), observed.species.name());
            return Err(self.refuse(format!("is of {own}, and the quiescent-gas network of {known}")));
        }
        let observer = observed.network.observer(BANDWIDTH_HZ, ANY_PERIOD_S);
        let observer = observer.map_err(|error| self.refuse(error.to_string()))?;
        let network = observer.board(ANY_PERIOD_S as f32).map_err(|error| self.refuse(error.to_string()))?;
        let own = &observed.network.own;
        let read = |element: usize| Ok((element, self.readings(&observed.head.elements[element], own.len())?));
        let columns = own.iter().map(|own| read(own.element)).collect::<Result<Vec<_>, RecordingError>>()?;
        let reference = observed.reference.map(|place| &observed.head.elements[place].name);
        let reference = reference.map(|name| recording::column_name(TEMPERATURE, name));
        let reference = reference.filter(|name| self.table.has(name));
        let gas_c = self.table.finite(reference.as_deref().unwrap_or(GAS_TEMPERATURE))?;
        let (pressure_pa, wind_m_s) = (self.table.finite(PRESSURE)?, self.wind_m_s(observed.head, &observed.surfaces)?);
        let labels = self.table.words(EVENT).ok();
        let row = |row: usize| {
            let label = labels.map_or_else(|| format!("row {}", row + 1), |labels| labels.word(row).to_owned());
            let (mut temperature_c, mut power_w) = ([0.0; MOST_ELEMENTS], [0.0; MOST_ELEMENTS]);
            for &(element, (powers_w, temperatures_c)) in &columns {
                (temperature_c[element], power_w[element]) = (temperatures_c[row] as f32, powers_w[row] as f32);
            }
            let input = TickInput {
                temperature_c: &temperature_c,
                valid: usize::MAX,
                read_high: 0,
                power_w: &power_w,
                standing_w: &power_w,
            };
            let convection = network.step(&mut ConvectionObserverState::default(), &input);
            let convection = convection.ok_or_else(|| self.refuse(format!("`{label}`: no loss can be read off")))?;
            let gas = IdealGas::new(self.species, pressure_pa[row], gas_c[row] + ZERO_CELSIUS_K)
                .map_err(|error| self.refuse(format!("`{label}`: {error}")))?;
            let surfaces = observed.surfaces.iter().map(|&place| {
                let surface_c = f64::from(convection.surface_c[place]);
                SurfaceReading {
                    power_w: f64::from(convection.power_w[place]),
                    overheat_k: surface_c - gas_c[row],
                    above_reference_k: surface_c - observed.quiescent.gas_temperature_c,
                    variance_w2: (POWER_ERROR * f64::from(power_w[place])).powi(2),
                }
            });
            Ok(SteadyWind { label, wind_m_s: wind_m_s[row], gas, surfaces: surfaces.collect() })
        };
        (0..self.table.len()).map(row).collect()
    }

    /// Power, W, and temperature, °C, of an element; of an only one also by bare names.
    fn readings(&self, of: &HeadElement, elements: usize) -> Result<(&[f64], &[f64]), RecordingError> {
        let column = |quantity: &str| {
            let bare = quantity.trim_end_matches('_');
            match elements == 1 && self.table.has(bare) {
                true => self.table.finite(bare),
                false => self.table.finite(&recording::column_name(quantity, &of.name)),
            }
        };
        let (power_w, temperature_c) = (column(POWER)?, column(TEMPERATURE)?);
        let high_w = of.power_w(temperature_c[0], Level::High);
        if let Some(row) = power_w.iter().position(|power_w| *power_w > MOST_OF_HIGH * high_w) {
            let (row, is_w, high_w) = (row + 1, tidy(power_w[row]), tidy(high_w));
            let powers = format!("row {row}: `{}` has {is_w} W, and its high level gives {high_w} W", of.name);
            return Err(self.refuse(format!("{powers}: is the power in watts, and the head this one?")));
        }
        Ok((power_w, temperature_c))
    }

    fn wind_m_s(&self, head: &Head, surfaces: &[usize]) -> Result<Vec<[f64; 3]>, RecordingError> {
        if self.table.has(GIVEN_WIND[0]) {
            let [x, y, z] = [0, 1, 2].map(|k| self.table.finite(GIVEN_WIND[k]));
            let (x, y, z) = (x?, y?, z?);
            return Ok((0..self.table.len()).map(|row| [x[row], y[row], z[row]]).collect());
        }
        let speed_m_s = self.table.finite(SPEED)?;
        if let Some(row) = speed_m_s.iter().position(|speed| *speed < 0.0) {
            let (row, speed) = (row + 1, speed_m_s[row]);
            return Err(self.refuse(format!("row {row}: `{SPEED}` is {speed}, and a speed is not negative")));
        }
        if self.table.has(ANGLE) {
            let from = self.table.finite(ANGLE)?.iter().map(|degrees| degrees.to_radians());
            let wind = |(speed, from): (&f64, f64)| [-speed * libm::cos(from), -speed * libm::sin(from), 0.0];
            return Ok(speed_m_s.iter().zip(from).map(wind).collect());
        }
        let [only] = *surfaces else {
            return Err(self.refuse(format!(
                "has no `{ANGLE}`, where the gas comes from: only a head of one surface is calibrated by its speed alone"
            )));
        };
        let towards = head.elements[only].normal.unwrap_or([1.0, 0.0, 0.0]);
        Ok(speed_m_s.iter().map(|speed| towards.map(|component| -speed * component)).collect())
    }

    fn refuse(&self, sentence: String) -> RecordingError {
        RecordingError::new(&self.table.path, sentence)
    }
}
