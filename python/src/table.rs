//! `anemo.Table`: a table that Arrow's libraries take and give, with its columns as numpy arrays.

// The stream of Arrow's C interface is handed over by its address.
#![allow(unsafe_code)]

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::RecordBatchIterator;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use numpy::{IntoPyArray as _, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList};
use recording::in_memory::{MemoryColumns, MemoryTable as _};
use recording::{ColumnValues, Recording, RecordingColumn};

use crate::arrow_table::ArrowTable;
use crate::error::error;

const STREAM: &std::ffi::CStr = c"arrow_array_stream";

/// A table with named columns: a recording, wind estimates, or a data frame of another library.
///
/// pyarrow.table(t), polars.DataFrame(t), pandas.DataFrame.from_arrow(t) and DuckDB take it without
/// a copy. `t["name"]` is a column as numpy array, numbers in f64, missing ones NaN.
#[pyclass(name = "Table", module = "anemo", frozen, dict)]
pub struct PyTable {
    pub inner: Arc<ArrowTable>,
}

impl PyTable {
    pub fn of(table: ArrowTable) -> Self {
        Self { inner: Arc::new(table) }
    }
}

#[pymethods]
impl PyTable {
    /// Takes anything with `__arrow_c_stream__` without a copy, or a mapping of names to arrays.
    #[new]
    #[pyo3(signature = (data, metadata = None))]
    fn new(data: &Bound<'_, PyAny>, metadata: Option<Vec<(String, String)>>) -> PyResult<Self> {
        let mut inner = if data.hasattr("__arrow_c_stream__")? { of_stream(data)? } else { of_mapping(data)? };
        if let Some(metadata) = metadata {
            let metadata: HashMap<_, _> = metadata.into_iter().collect();
            let schema = arrow_schema::Schema::clone(&inner.schema).with_metadata(metadata);
            inner = inner.with_schema(Arc::new(schema)).map_err(|reason| error(data.py(), 2, &reason))?;
        }
        if inner.schema.fields().is_empty() {
            return Err(error(data.py(), 2, &"the table has no columns"));
        }
        inner.check_units().map_err(|reason| error(data.py(), 2, &reason))?;
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Reads a recording or any other table: .parquet, .csv, a folder of segments, or a pattern.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let recording = py.detach(|| Recording::read(&path)).map_err(|reason| error(py, 2, &reason))?;
        let Recording { columns, metadata, .. } = recording;
        Ok(Self::of(ArrowTable::of_columns(MemoryColumns { columns, metadata })))
    }

    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.inner.names()
    }

    /// Metadata of the table: title, head, experiment, hash, and so on.
    #[getter]
    fn metadata(&self) -> HashMap<String, String> {
        self.inner.metadata().into_iter().collect()
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    fn __contains__(&self, name: &str) -> bool {
        self.inner.column(name).is_some()
    }

    /// A column: numbers as a numpy array of f64, text as a numpy array of strings.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let column = self.inner.column(name).ok_or_else(|| {
            let names = self.inner.names();
            let hint = recording::text::suggest(name, names.iter().map(String::as_str));
            PyKeyError::new_err(format!("there is no column `{name}`; {hint}"))
        })?;
        match self.inner.values(column, 0..self.inner.len()) {
            Ok(ColumnValues::Numbers(numbers)) => Ok(numbers.into_pyarray(py).into_any()),
            Ok(ColumnValues::Words(words)) => {
                py.import("numpy")?.call_method1("array", (PyList::new(py, words.iter())?,))
            }
            Err(reason) => Err(error(py, 2, &format!("column `{name}` {reason}"))),
        }
    }

    fn __repr__(&self) -> String {
        format!("<anemo.Table of {} rows: {}>", self.inner.len(), self.inner.names().join(", "))
    }

    /// Arrow's C stream; its columns stay this table's.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A schema is a wish; who wants other types converts them.
        drop(requested_schema);
        let batches = self.inner.batches.clone().into_iter().map(Ok);
        let reader = RecordBatchIterator::new(batches, Arc::clone(&self.inner.schema));
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), STREAM)
    }
}

fn of_stream(data: &Bound<'_, PyAny>) -> PyResult<ArrowTable> {
    let py = data.py();
    let capsule = data.call_method0("__arrow_c_stream__")?;
    let capsule = capsule.cast::<PyCapsule>().map_err(|_| PyTypeError::new_err("no capsule of an Arrow stream"))?;
    let address = capsule.pointer_checked(Some(STREAM))?.as_ptr().cast::<FFI_ArrowArrayStream>();
    // SAFETY: a capsule of that name holds such a stream (Arrow PyCapsule interface). It is moved
    // out and marked as released, so that the capsule does not release it again.
    let stream = unsafe { FFI_ArrowArrayStream::from_raw(address) };
    let damaged = |reason: arrow_schema::ArrowError| error(py, 2, &format!("the table cannot be read: {reason}"));
    let reader = RecordBatchStreamReader::try_new(stream).map_err(damaged)?;
    let schema = arrow_array::RecordBatchReader::schema(&reader);
    let batches = reader.collect::<Result<Vec<_>, _>>().map_err(damaged)?;
    ArrowTable { schema, batches }.with_index_first().map_err(damaged)
}

/// An array without a mask and without units of time: NaN where a value is masked, moments as
/// seconds since 1970, durations as seconds.
fn plain<'py>(py: Python<'py>, asarray: &Bound<'py, PyAny>, values: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    if values.hasattr("mask")? && values.hasattr("filled")? {
        return values.call_method1("astype", ("f8",))?.call_method1("filled", (f64::NAN,));
    }
    let array = asarray.call1((values,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    match kind.as_str() {
        "M" | "m" => {
            let second = numpy.call_method1("timedelta64", (1, "s"))?;
            let since = if kind == "M" {
                array.call_method1("__sub__", (numpy.call_method1("datetime64", (0, "s"))?,))?
            } else {
                array
            };
            since.call_method1("__truediv__", (second,))
        }
        _ => Ok(array),
    }
}

fn of_mapping(data: &Bound<'_, PyAny>) -> PyResult<ArrowTable> {
    let py = data.py();
    let wrong = "a table is a mapping of names to arrays, or has __arrow_c_stream__ (pyarrow, Polars, pandas, DuckDB)";
    let data = data.cast::<PyDict>().map_err(|_| PyTypeError::new_err(wrong))?;
    let asarray = py.import("numpy")?.getattr("asarray")?;
    let mut columns = Vec::new();
    let mut rows = None;
    for (name, values) in data.iter() {
        let name: String = name.extract()?;
        let array = plain(py, &asarray, &values)?;
        let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
        let values = if matches!(kind.as_str(), "U" | "O" | "T") {
            let words: Vec<String> = array.call_method0("tolist")?.extract().map_err(|_| {
                error(py, 2, &format!("column `{name}` holds objects that are neither numbers nor text"))
            })?;
            let mut all = recording::ColumnWords::default();
            words.iter().for_each(|word| all.push(word));
            ColumnValues::Words(all)
        } else {
            let numbers = py.import("numpy")?.call_method1("asarray", (array, "f8"))?;
            let numbers: PyReadonlyArray1<'_, f64> = numbers
                .extract()
                .map_err(|_| error(py, 2, &format!("column `{name}` is no one-dimensional array of numbers")))?;
            ColumnValues::Numbers(numbers.as_array().to_vec())
        };
        let wanted = *rows.get_or_insert(values.len());
        if values.len() != wanted {
            return Err(error(py, 2, &format!("column `{name}` has {} rows where others have {wanted}", values.len())));
        }
        columns.push(RecordingColumn { name, values });
    }
    if columns.is_empty() || rows == Some(0) {
        return Err(error(py, 2, &"the table has no rows"));
    }
    Ok(ArrowTable::of_columns(MemoryColumns { columns, metadata: Vec::new() }))
}
