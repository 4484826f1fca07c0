//! A row as named numbers, under the names of a recording's columns.

use crate::feed::{FeedLayout, FeedRow};
use recording::{EQUIVALENT_POWER, GAS_TEMPERATURE, POWER, TEMPERATURE, TRUE_WIND, column_name, wind};

/// Names of a row's numbers, made once for all rows.
#[derive(Debug, Clone)]
pub struct FeedColumns {
    names: Vec<String>,
    surfaces: usize,
}

impl FeedColumns {
    /// The names for rows of this layout.
    pub fn new(layout: &FeedLayout) -> Self {
        let of = |quantity: &'static str, elements: &[String]| -> Vec<String> {
            elements.iter().map(|element| column_name(quantity, element)).collect()
        };
        let mut names = of(TEMPERATURE, &layout.elements);
        names.extend(of(POWER, &layout.elements));
        names.extend(of(EQUIVALENT_POWER, &layout.observed));
        names.extend(TRUE_WIND.map(str::to_owned));
        names.push(GAS_TEMPERATURE.to_owned());
        names.extend(wind::columns(&layout.surfaces));
        names.push(wind::WIND_FROM.to_owned());
        Self { names, surfaces: layout.surfaces.len() }
    }

    /// The numbers that a row has, with their names: those that are missing are left out. A row of
    /// another layout has none.
    pub fn numbers(&self, row: &FeedRow) -> impl Iterator<Item = (&str, f64)> {
        let mut numbers: Vec<f64> = Vec::with_capacity(self.names.len());
        numbers.extend(row.temperature_c.iter().chain(&row.power_w).chain(&row.equivalent_power_w).map(plain));
        numbers.extend(row.true_wind_m_s.unwrap_or([f64::NAN; 3]));
        numbers.push(row.gas_temperature_c.unwrap_or(f64::NAN));
        numbers.extend(wind::numbers(row.wind.as_ref().map(|wind| &wind.estimate), self.surfaces).iter().map(plain));
        let directed = row.wind.as_ref().filter(|wind| wind.has_direction());
        // Hundredths are finer than any head.
        numbers.push(directed.map_or(f64::NAN, |wind| super::rounded_deg(wind.from_deg, 2)));
        let is_of_layout = numbers.len() == self.names.len();
        let names = self.names.iter().filter(move |_| is_of_layout);
        names.map(String::as_str).zip(numbers).filter(|(_, number)| number.is_finite())
    }
}

/// The shortest decimal of a number of 32 bit: 60.1 rather than 60.099998474.
fn plain(number: &f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::examples;
    use dr_core::wind::QualityFlags;
    use std::collections::HashMap;

    #[test]
    fn numbers_have_the_names_of_columns_and_missing_ones_none() {
        let columns = FeedColumns::new(&examples::layout());
        let row = examples::row(Some(examples::wind(2.0, 270.0, QualityFlags::default())));
        let numbers: HashMap<_, _> = columns.numbers(&row).collect();
        assert_eq!(numbers["temperature_c_sector_1"], 60.1);
        assert_eq!((numbers["power_w_core"], numbers["wind_speed_m_s"]), (0.5, 2.0));
        assert_eq!((numbers["wind_from_deg"], numbers["quality_flags"]), (270.0, 0.0));
        assert!(!numbers.contains_key("temperature_c_core") && !numbers.contains_key("gas_temperature_c"));
        let failed = examples::row(Some(examples::wind(2.0, 270.0, QualityFlags::FAILED)));
        let numbers: HashMap<_, _> = columns.numbers(&failed).collect();
        assert!(!numbers.contains_key("wind_from_deg") && !numbers.contains_key("wind_speed_m_s"));
        assert_eq!(numbers["quality_flags"], 1.0);
    }

    #[test]
    fn a_row_of_other_lengths_than_the_layout_is_no_shift_of_names() {
        let columns = FeedColumns::new(&examples::layout());
        let mut row = examples::row(None);
        row.temperature_c.pop();
        assert!(columns.numbers(&row).next().is_none());
    }
}
