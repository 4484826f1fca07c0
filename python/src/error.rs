//! `anemo.Error`, raised from here.

use pyo3::prelude::*;

/// The package's own exception with a sentence and the exit code of the command line.
pub fn error(py: Python<'_>, code: u8, sentence: &dyn std::fmt::Display) -> PyErr {
    let raised =
        py.import("anemo._error").and_then(|module| module.getattr("Error")?.call1((sentence.to_string(), code)));
    raised.map_or_else(|error| error, PyErr::from_value)
}
