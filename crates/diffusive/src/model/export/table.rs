//! Tables as CSV: lines `# key: value` on where the numbers come from, then a head of names with
//! units, then rows.

use std::fmt::Write as _;

use nalgebra::Complex;

use super::cauer::{cauer, structure_function};
use super::{foster, response, symbol};
use crate::model::ModelError;
use crate::model::pair_class::PairClass;

/// Named columns of numbers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ExportTable {
    /// Keys and values above the head of the table.
    #[serde(skip)]
    pub metadata: Vec<(&'static str, String)>,
    /// Names with units.
    pub columns: Vec<&'static str>,
    /// Numbers, one a column.
    pub rows: Vec<Vec<f64>>,
}

impl ExportTable {
    fn new(part: &PairClass, form: &str, columns: &[&'static str], rows: Vec<Vec<f64>>) -> Self {
        let mut metadata = vec![
            ("form", form.to_owned()),
            ("input", part.pair.input.clone()),
            ("output", part.pair.output.clone()),
            ("class", part.label.to_owned()),
            ("steady_gain_k_per_w", number(part.class.steady_gain_k_per_w)),
            ("feed_through_k_per_w", number(part.class.feed_through_k_per_w)),
            ("dead_time_s", number(part.dead_time_s())),
            ("offset_c", number(part.offset_c())),
            ("sample_period_s", number(part.model.sample_period_s)),
            ("records", part.model.provenance.records.join(", ")),
        ];
        if let Some(conductance) = part.wind_w_per_k {
            metadata.push(("wind_w_per_k", number(conductance)));
        }
        if let Some(warning) = part.warning() {
            metadata.push(("warning", warning));
        }
        Self { metadata, columns: columns.to_vec(), rows }
    }

    /// The table as a CSV file.
    pub fn to_csv(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        for (key, value) in &self.metadata {
            let _ = writeln!(text, "# {key}: {}", value.replace(['\n', '\r'], " "));
        }
        let _ = writeln!(text, "{}", self.columns.join(","));
        for row in &self.rows {
            let fields: Vec<String> = row.iter().copied().map(number).collect();
            let _ = writeln!(text, "{}", fields.join(","));
        }
        text
    }
}

/// The shortest text that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// Cells of the Foster network.
///
/// # Errors
/// In a wind that has no symbol of its own.
pub fn foster_table(part: &PairClass) -> Result<ExportTable, ModelError> {
    part.refuse_wind()?;
    let rows = foster::foster(&part.pair.mesh_rad_s, &part.class.r_k_per_w).into_iter().map(|cell| {
        vec![
            cell.rate_rad_s,
            cell.time_constant_s(),
            cell.resistance_k_per_w,
            cell.capacitance_j_per_k(),
            cell.symbol_k_per_j(),
        ]
    });
    let columns = ["rate_rad_s", "time_constant_s", "resistance_k_per_w", "capacitance_j_per_k", "symbol_k_per_j"];
    Ok(ExportTable::new(part, "foster", &columns, rows.collect()))
}

/// Sections of the Cauer ladder.
///
/// # Errors
/// If the pair has none.
pub fn cauer_table(part: &PairClass) -> Result<ExportTable, ModelError> {
    part.refuse_wind()?;
    let sections = cauer(&part.pair.mesh_rad_s, &part.class.r_k_per_w)?.into_iter();
    let rows = sections.map(|section| vec![section.resistance_k_per_w, section.capacitance_j_per_k]);
    Ok(ExportTable::new(part, "cauer", &["resistance_k_per_w", "capacitance_j_per_k"], rows.collect()))
}

/// The cumulative structure function.
///
/// # Errors
/// If the pair has none.
pub fn structure_table(part: &PairClass) -> Result<ExportTable, ModelError> {
    part.refuse_wind()?;
    let steps = structure_function(&part.pair.mesh_rad_s, &part.class.r_k_per_w)?;
    let rows = steps.into_iter().map(|(resistance, capacitance)| vec![resistance, capacitance]).collect();
    let columns = ["cumulative_resistance_k_per_w", "cumulative_capacitance_j_per_k"];
    Ok(ExportTable::new(part, "structure", &columns, rows))
}

/// The symbol, discrete and continuous, with standard errors.
///
/// # Errors
/// If there is one rate only, or in a wind that has no symbol of its own.
pub fn symbol_table(part: &PairClass) -> Result<ExportTable, ModelError> {
    part.refuse_wind()?;
    let (mesh, class) = (&part.pair.mesh_rad_s, part.class);
    let spacing = symbol::log_spacing(mesh)?;
    let continuous = symbol::continuous_symbol(mesh, &class.r_k_per_w)?;
    let row = |k: usize| {
        vec![
            mesh[k],
            mesh[k] / std::f64::consts::TAU,
            class.r_k_per_w[k],
            class.se_k_per_w[k],
            mesh[k] * class.r_k_per_w[k],
            continuous[k],
            class.se_k_per_w[k] / spacing[k],
        ]
    };
    let columns = [
        "rate_rad_s",
        "frequency_hz",
        "r_k_per_w",
        "se_k_per_w",
        "symbol_k_per_j",
        "continuous_symbol_k_per_w",
        "se_continuous_symbol_k_per_w",
    ];
    Ok(ExportTable::new(part, "symbol", &columns, (0..mesh.len()).map(row).collect()))
}

/// The frequency response at so many frequencies.
///
/// # Errors
/// If the class has none.
pub fn response_table(part: &PairClass, points: usize) -> Result<ExportTable, ModelError> {
    let row = |omega: f64| {
        let Complex { re, im } = response::response_in_class(part.model, part.pair, part.label, omega)
            .ok_or_else(|| model_error!("class `{}` has no response", part.label))?;
        Ok(vec![omega / std::f64::consts::TAU, libm::hypot(re, im), libm::atan2(im, re).to_degrees(), re, im])
    };
    let frequencies = response::frequencies_rad_s(part.model, part.pair, points);
    let rows = frequencies.into_iter().map(row).collect::<Result<_, ModelError>>()?;
    let columns = ["frequency_hz", "magnitude_k_per_w", "phase_deg", "real_k_per_w", "imag_k_per_w"];
    Ok(ExportTable::new(part, "response", &columns, rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::testing;

    #[test]
    fn a_table_says_where_it_comes_from_and_reads_back_exactly() {
        let model = testing::model(&[0.1, 2.5], &[10.0, 0.3]);
        let part = PairClass::find(&model, None, None).unwrap();
        let text = foster_table(&part).unwrap().to_csv();
        assert!(text.contains("# input: power_w_a\n") && text.contains("# offset_c: 20\n"), "{text}");
        let rows: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(rows[0], "rate_rad_s,time_constant_s,resistance_k_per_w,capacitance_j_per_k,symbol_k_per_j");
        assert_eq!(rows[1], "0.1,10,10,1,1");
        let values: Vec<f64> = rows[2].split(',').map(|field| field.parse().unwrap()).collect();
        assert_eq!(values, [2.5, 0.4, 0.3, 1.0 / 0.75, 0.75]);
    }

    #[test]
    fn magnitude_and_phase_are_those_of_real_and_imaginary_part() {
        let model = testing::model(&[0.1, 2.5], &[10.0, 0.3]);
        let table = response_table(&PairClass::find(&model, None, None).unwrap(), 30).unwrap();
        assert_eq!(table.rows.len(), 30);
        for row in &table.rows {
            let phase = row[2].to_radians();
            // roundings of 10 K/W
            assert!(
                (row[1] * libm::cos(phase) - row[3]).abs() < 1e-13
                    && (row[1] * libm::sin(phase) - row[4]).abs() < 1e-13
            );
        }
    }

    #[test]
    fn a_model_that_its_record_does_not_support_says_so_in_every_form() {
        let mut model = testing::model(&[0.1, 2.5], &[10.0, 0.3]);
        model.supported = false;
        model.warnings = vec!["the record is too short".to_owned()];
        let part = PairClass::find(&model, None, None).unwrap();
        let texts = [
            foster_table(&part).unwrap().to_csv(),
            super::super::spice::netlist(&part, super::super::spice::SpiceNetwork::Foster).unwrap(),
            super::super::source::source(&part, super::super::source::Language::C).unwrap(),
        ];
        for text in texts {
            assert!(text.contains("does not support this model: the record is too short"), "{text}");
        }
    }

    #[test]
    fn a_wind_has_a_response_but_no_tables_of_poles() {
        let mut model = testing::model(&[0.1, 2.5], &[10.0, 0.3]);
        testing::add_wind(&mut model, "gust", 0.2);
        let part = PairClass::find(&model, None, Some("gust")).unwrap();
        for refused in [foster_table(&part), cauer_table(&part), structure_table(&part), symbol_table(&part)] {
            assert!(refused.unwrap_err().to_string().contains("no symbol of its own"));
        }
        let lowest = &response_table(&part, 10).unwrap().rows[0];
        // At ξ_1/10 the rise is within 1 % of the steady one, 1/(1/10.3 + 0.2)
        assert!((lowest[1] * (1.0 / 10.3 + 0.2) - 1.0).abs() < 0.01);
    }
}
