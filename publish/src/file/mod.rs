//! Recordings as files of other programs.
//!
//! | extension | form | read by |
//! |---|---|---|
//! | `.dat` | TOA5, as Campbell's loggers write tables | LoggerNet, EddyPro, pandas |
//! | `.nc` | NetCDF with the names and units of the CF conventions 1.11 | ncdump, xarray, MetPy |
//! | `.mat` | MATLAB, level 4 | MATLAB, Octave, SciPy |
//!
//! Where the mounting's heading is known, a column `wind_from_deg` is added: the direction from
//! which the wind blows, clockwise from north.

mod matlab;
mod netcdf;
mod table;
mod toa5;

pub use table::{ConvertError, ConvertOptions};

use recording::{Recording, Temporary};
use std::path::Path;
use table::{ConvertedTable, FormError};

/// Writes a recording to `path`, in the form that its extension names.
///
/// # Errors
/// If the recording has no ascending time, or does not say when it started where the form wants
/// that, or the file cannot be written.
pub fn convert(recording: &Recording, options: &ConvertOptions, path: &Path) -> Result<(), ConvertError> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let write = match extension.as_deref() {
        Some("dat") => toa5::write,
        Some("nc") => netcdf::write,
        Some("mat") => matlab::write,
        _ => return Err(ConvertError::Form(path.to_owned())),
    };
    let table = ConvertedTable::new(recording, options)?;
    let failed = |source| ConvertError::Write { path: path.to_owned(), source };
    let (temporary, file) = Temporary::create(path).map_err(failed)?;
    write(&table, file).map_err(|error| match error {
        FormError::Io(source) => failed(source),
        FormError::NoStart => ConvertError::NoStart(recording.path.clone()),
        FormError::Unfit(sentence) => ConvertError::Unfit { path: path.to_owned(), sentence },
    })?;
    temporary.keep().map_err(failed)
}

#[cfg(test)]
mod tests;
