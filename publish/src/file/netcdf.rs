//! NetCDF-3 with the metadata of the Climate and Forecast conventions (CF 1.11): units, names that
//! CF knows, and meanings of codes and flags (sections 3.3 and 3.5).
//!
//! Columns of text are codes from 0 on with `flag_values` and `flag_meanings`.

use super::table::{ConvertedColumn, ConvertedTable, FormError, unit};
use dr_core::wind::QualityFlags;
use netcdf3::{DataSet, DataType, FileWriter, InvalidDataSet, NC_FILL_F64, Version, WriteError};
use recording::GAS_TEMPERATURE;
use recording::wind::{ESTIMATED_GAS, QUALITY_FLAGS, WIND_FROM, WIND_SPEED};
use std::fs::File;
use std::io;

const TIME: &str = "time";

/// Names of CF for ours.
const STANDARD_NAMES: [(&str, &str); 4] = [
    (WIND_SPEED, "wind_speed"),
    (WIND_FROM, "wind_from_direction"),
    (GAS_TEMPERATURE, "air_temperature"),
    (ESTIMATED_GAS, "air_temperature"),
];

impl From<InvalidDataSet> for FormError {
    fn from(error: InvalidDataSet) -> Self {
        Self::Unfit(format!("NetCDF refuses it: {error:?}"))
    }
}

impl From<WriteError> for FormError {
    fn from(error: WriteError) -> Self {
        Self::Io(io::Error::other(format!("{error:?}")))
    }
}

pub(super) fn write(table: &ConvertedTable, file: File) -> Result<(), FormError> {
    let mut set = DataSet::new();
    set.add_fixed_dim(TIME, table.time_s.len())?;
    for (key, value) in [
        ("Conventions", "CF-1.11"),
        ("title", table.title),
        ("source", &format!("thermal anemometer, head {}", table.head)),
        ("history", concat!("converted by anemo ", env!("CARGO_PKG_VERSION"))),
    ] {
        // An empty attribute says nothing, and some readers stumble over it.
        if !value.is_empty() {
            set.add_global_attr_string(key, value)?;
        }
    }
    set.add_var_f64(TIME, &[TIME])?;
    let start = table.start()?;
    let (date, clock) = (start.date(), start.time());
    let since = format!(
        "seconds since {date} {:02}:{:02}:{:02}.{:06}",
        clock.hour(),
        clock.minute(),
        clock.second(),
        clock.microsecond()
    );
    for (key, value) in [("standard_name", "time"), ("units", &since), ("calendar", "standard"), ("axis", "T")] {
        set.add_var_attr_string(TIME, key, value)?;
    }
    for (name, column) in &table.columns {
        define(&mut set, name, column)?;
    }
    // 64-bit offsets: no limit of 2 GiB for the file.
    let mut writer = FileWriter::open_seek_write("", Box::new(io::BufWriter::new(file)))?;
    writer.set_def(&set, Version::Offset64Bit, 0)?;
    writer.write_var_f64(TIME, table.time_s)?;
    for (name, column) in &table.columns {
        match column {
            ConvertedColumn::Words(words) => {
                writer.write_var_i32(name, &words.codes().iter().map(|&code| code as i32).collect::<Vec<_>>())?;
            }
            ConvertedColumn::Numbers(numbers) if *name == QUALITY_FLAGS => {
                let flags = numbers.iter().map(|flags| if flags.is_finite() { *flags as i32 } else { NO_ESTIMATE });
                writer.write_var_i32(name, &flags.collect::<Vec<_>>())?;
            }
            ConvertedColumn::Numbers(numbers) => {
                let filled = numbers.iter().map(|&number| if number.is_finite() { number } else { NC_FILL_F64 });
                writer.write_var_f64(name, &filled.collect::<Vec<_>>())?;
            }
        }
    }
    Ok(writer.close()?)
}

/// The flags of a row without an estimate.
const NO_ESTIMATE: i32 = -1;

fn define(set: &mut DataSet, name: &str, column: &ConvertedColumn) -> Result<(), FormError> {
    let numbers = |range: std::ops::Range<i32>| range.collect::<Vec<_>>();
    match column {
        ConvertedColumn::Words(words) => {
            set.add_var(name, &[TIME], DataType::I32)?;
            // Meanings are words between blanks, of the characters that the conventions allow.
            let letter = |letter: char| if letter.is_alphanumeric() || "_-.+@".contains(letter) { letter } else { '_' };
            let meaning = |word: &String| match word.as_str() {
                "" => "none".to_owned(),
                word => word.chars().map(letter).collect(),
            };
            let meanings: Vec<_> = words.dictionary().iter().map(meaning).collect();
            set.add_var_attr_i32(name, "flag_values", numbers(0..meanings.len() as i32))?;
            set.add_var_attr_string(name, "flag_meanings", meanings.join(" "))?;
            return Ok(());
        }
        ConvertedColumn::Numbers(_) if name == QUALITY_FLAGS => {
            set.add_var(name, &[TIME], DataType::I32)?;
            set.add_var_attr_i32(name, "_FillValue", vec![NO_ESTIMATE])?;
            let (masks, meanings): (Vec<_>, Vec<_>) =
                QualityFlags::NAMES.iter().map(|(flag, name)| (i32::from(flag.0), *name)).unzip();
            set.add_var_attr_i32(name, "flag_masks", masks)?;
            set.add_var_attr_string(name, "flag_meanings", meanings.join(" "))?;
        }
        ConvertedColumn::Numbers(_) => {
            set.add_var_f64(name, &[TIME])?;
            // NaN, which equals nothing, would make the crate miss the variable.
            set.add_var_attr_f64(name, "_FillValue", vec![NC_FILL_F64])?;
        }
    }
    if !unit(name).is_empty() {
        set.add_var_attr_string(name, "units", unit(name))?;
    }
    if let Some((_, standard)) = STANDARD_NAMES.iter().find(|(known, _)| *known == name) {
        set.add_var_attr_string(name, "standard_name", standard)?;
    }
    Ok(())
}
