//! The native half of the Python package `anemo`: commands in process, tables without copies,
//! models as numpy arrays. Everything that computes stands in the crates that the command line has.

mod arrow_table;
mod commands;
mod error;
mod model;
mod table;

use pyo3::prelude::*;

/// Functions for `anemo/*.py`; not for others.
#[pymodule]
mod _anemo {
    #[pymodule_export]
    use super::commands::{Text, forked, main, perform};
    #[pymodule_export]
    use super::model::PyModel;
    #[pymodule_export]
    use super::table::PyTable;
}
