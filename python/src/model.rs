//! `anemo.Model`: a diffusive model, its forms as numpy arrays.

use std::path::PathBuf;

use diffusive::identify::report::IdentifyReport;
use diffusive::model::certainty::steady_gain_error;
use diffusive::model::export::{ExportForm, ExportReport, impulse_response, response_in_class, state_space};
use diffusive::model::{ModelError, PairClass};
use numpy::{AllowTypeChange, Complex64, IntoPyArray as _, PyArray1, PyArray2, PyArrayLike1};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::error;

/// A diffusive model: how heating powers lead to temperatures, with standard errors.
#[pyclass(name = "Model", module = "anemo", frozen, eq, dict)]
#[derive(Clone, PartialEq)]
pub struct PyModel {
    pub inner: diffusive::model::Model,
}

fn refused(py: Python<'_>) -> impl Fn(ModelError) -> PyErr {
    move |reason| error(py, 2, &reason)
}

/// Pair and class of a model.
struct PartName<'a> {
    pair: Option<&'a str>,
    class: Option<&'a str>,
}

impl PyModel {
    fn part<'m>(&'m self, py: Python<'_>, of: &PartName<'m>) -> PyResult<PairClass<'m>> {
        PairClass::find(&self.inner, of.pair, of.class).map_err(refused(py))
    }

    fn form<'py>(&self, py: Python<'py>, of: &PartName<'_>, form: ExportForm) -> PyResult<Bound<'py, PyDict>> {
        let part = self.part(py, of)?;
        let report = ExportReport::new(&part, form, None).map_err(refused(py))?;
        if let Some(warning) = part.warning() {
            let warning = std::ffi::CString::new(warning).unwrap_or_default();
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &warning, 1)?;
        }
        let columns = PyDict::new(py);
        let names = report.table().map_or(&[][..], |table| &table.columns);
        for (at, name) in names.iter().enumerate() {
            let column: Vec<f64> = report.table().iter().flat_map(|table| &table.rows).map(|row| row[at]).collect();
            columns.set_item(name, column.into_pyarray(py))?;
        }
        Ok(columns)
    }
}

/// A, B, C, D, the sample period in s, and what they leave out.
type Matrices<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    f64,
    Option<String>,
);

#[pymethods]
impl PyModel {
    /// Reads a model's .json file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(Self { inner: diffusive::model::Model::read(&path).map_err(refused(py))? })
    }

    /// Reads a model from the text of its file.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        Ok(Self { inner: diffusive::model::Model::from_json(text).map_err(refused(py))? })
    }

    /// The text of its file.
    fn to_json(&self) -> String {
        self.inner.to_json()
    }

    /// Writes its .json file, in whole or not at all.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.inner.write(&path).map_err(refused(py))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((py.get_type::<Self>().getattr("from_json")?, (self.to_json(),)))
    }

    /// Columns that heat.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inner.inputs.clone()
    }

    /// Columns that are heated.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.outputs.iter().map(|output| output.name.clone()).collect()
    }

    /// Labels of the event classes, `["all"]` without events.
    #[getter]
    fn classes(&self) -> Vec<String> {
        self.inner.classes.clone()
    }

    /// Sample period of the record, s.
    #[getter]
    fn sample_period_s(&self) -> f64 {
        self.inner.sample_period_s
    }

    /// Fit of the first output, %.
    #[getter]
    fn fit_percent(&self) -> f64 {
        self.inner.fit_percent
    }

    /// Temperature of the first output without heating, °C.
    #[getter]
    fn offset_c(&self) -> f64 {
        self.inner.offset_c
    }

    /// Tells whether the record supports predictions by this model.
    #[getter]
    fn supported(&self) -> bool {
        self.inner.supported
    }

    /// A sentence for everything that the record does not show.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.inner.warnings.clone()
    }

    /// Steady gain of a pair and its standard error, in which coloured residuals count, K/W.
    #[pyo3(signature = (pair = None, class_ = None))]
    fn steady_gain(&self, py: Python<'_>, pair: Option<&str>, class_: Option<&str>) -> PyResult<(f64, f64)> {
        let part = self.part(py, &PartName { pair, class: class_ })?;
        Ok((part.class.steady_gain_k_per_w, steady_gain_error(&self.inner, part.pair, part.class)))
    }

    /// Time-constant spectrum (diffusive symbol): rate_rad_s, frequency_hz, r_k_per_w, se_k_per_w,
    /// symbol_k_per_j, continuous_symbol_k_per_w, se_continuous_symbol_k_per_w.
    #[pyo3(signature = (pair = None, class_ = None))]
    fn spectrum<'py>(&self, py: Python<'py>, pair: Option<&str>, class_: Option<&str>) -> PyResult<Bound<'py, PyDict>> {
        self.form(py, &PartName { pair, class: class_ }, ExportForm::Symbol)
    }

    /// Foster network: rate_rad_s, time_constant_s, resistance_k_per_w, capacitance_j_per_k,
    /// symbol_k_per_j.
    #[pyo3(signature = (pair = None, class_ = None))]
    fn foster<'py>(&self, py: Python<'py>, pair: Option<&str>, class_: Option<&str>) -> PyResult<Bound<'py, PyDict>> {
        self.form(py, &PartName { pair, class: class_ }, ExportForm::Foster)
    }

    /// Cauer ladder from the heater outwards: resistance_k_per_w, capacitance_j_per_k.
    #[pyo3(signature = (pair = None, class_ = None))]
    fn cauer<'py>(&self, py: Python<'py>, pair: Option<&str>, class_: Option<&str>) -> PyResult<Bound<'py, PyDict>> {
        self.form(py, &PartName { pair, class: class_ }, ExportForm::Cauer)
    }

    /// Cumulative structure function: cumulative_resistance_k_per_w,
    /// cumulative_capacitance_j_per_k.
    #[pyo3(signature = (pair = None, class_ = None))]
    fn structure<'py>(
        &self,
        py: Python<'py>,
        pair: Option<&str>,
        class_: Option<&str>,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.form(py, &PartName { pair, class: class_ }, ExportForm::Structure)
    }

    /// Impulse response at times in s, K/J; a feed-through is not in it.
    #[pyo3(signature = (time_s, pair = None, class_ = None))]
    fn impulse<'py>(
        &self,
        py: Python<'py>,
        time_s: PyArrayLike1<'py, f64, AllowTypeChange>,
        pair: Option<&str>,
        class_: Option<&str>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let part = self.part(py, &PartName { pair, class: class_ })?;
        let time_s = time_s.as_array().to_vec();
        Ok(impulse_response(&part, &time_s).map_err(refused(py))?.into_pyarray(py))
    }

    /// Thermal impedance Z_th(jω) at angular frequencies in rad/s, K/W, complex.
    #[pyo3(signature = (omega_rad_s, pair = None, class_ = None))]
    fn frequency_response<'py>(
        &self,
        py: Python<'py>,
        omega_rad_s: PyArrayLike1<'py, f64, AllowTypeChange>,
        pair: Option<&str>,
        class_: Option<&str>,
    ) -> PyResult<Bound<'py, PyArray1<Complex64>>> {
        let part = self.part(py, &PartName { pair, class: class_ })?;
        let at = |omega_rad_s: &f64| {
            let value = response_in_class(&self.inner, part.pair, part.label, *omega_rad_s);
            value.map(|value| Complex64::new(value.re, value.im))
        };
        let values: Option<Vec<Complex64>> = omega_rad_s.as_array().iter().map(at).collect();
        let missing = || error(py, 2, &format!("class `{}` has no response", part.label));
        Ok(values.ok_or_else(missing)?.into_pyarray(py))
    }

    /// Matrices A, B, C, D in discrete time, the sample period in s, and what they leave out.
    #[pyo3(signature = (class_ = None, dt = None))]
    fn _state_space<'py>(&self, py: Python<'py>, class_: Option<&str>, dt: Option<f64>) -> PyResult<Matrices<'py>> {
        let space = state_space(&self.inner, class_, dt).map_err(refused(py))?;
        let array = |matrix: &nalgebra::DMatrix<f64>| {
            let rows: Vec<Vec<f64>> = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
            if rows.is_empty() {
                Ok(PyArray2::zeros(py, [0, matrix.ncols()], false))
            } else {
                PyArray2::from_vec2(py, &rows)
            }
        };
        let failed = |reason: numpy::FromVecError| error(py, 1, &reason);
        let [a, b, c, d] = [&space.a, &space.b, &space.c, &space.d].map(array);
        Ok((
            a.map_err(failed)?,
            b.map_err(failed)?,
            c.map_err(failed)?,
            d.map_err(failed)?,
            space.sample_period_s,
            space.warning,
        ))
    }

    /// The model as python-control's StateSpace in discrete time, exact for inputs that are held
    /// between samples; `dt` in s, by default the record's sample period.
    #[pyo3(signature = (class_ = None, dt = None))]
    fn to_control<'py>(slf: &Bound<'py, Self>, class_: Option<&str>, dt: Option<f64>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("anemo._control")?.call_method1("to_control", (slf, class_, dt))
    }

    /// The picture of a model, as SVG.
    fn svg(&self) -> String {
        plot::model::figure(&self.inner, &[]).svg()
    }

    fn __repr__(&self) -> String {
        let model = &self.inner;
        let rates: Vec<String> = model.pairs.iter().map(|pair| pair.mesh_rad_s.len().to_string()).collect();
        format!(
            "<anemo.Model {} → {}: {} rates, fit {:.2} %{}>",
            model.inputs.join(", "),
            self.outputs().join(", "),
            rates.join(", "),
            model.fit_percent,
            if model.supported { "" } else { ", not supported by its record" }
        )
    }

    /// The summary that the command line prints.
    fn __str__(&self) -> String {
        IdentifyReport { model: &self.inner, notes: &[], written: None }.to_string()
    }

    fn _repr_html_(&self) -> String {
        format!("<p>{}</p>{}", self.__repr__().replace('<', "&lt;").replace('>', "&gt;"), self.svg())
    }
}
