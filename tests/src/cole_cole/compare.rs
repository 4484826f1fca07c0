//! Identification of Cole and Cole's system, held against what is exact.

use super::case::ColeColeCase;
use super::exact::{THESIS_ORDER, symbol, thesis_mesh_rad_s};
use diffusive::model::export::continuous_symbol;
use diffusive::model::{Forward, Model, ModelError};

/// One rate of an identified symbol.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SymbolValue {
    /// ξ
    pub rate_rad_s: f64,
    /// η(ξ) as it is.
    pub exact: f64,
    /// R_k / ln r.
    pub identified: f64,
    /// Identified over exact, less one.
    pub relative_error: f64,
    /// Standard error of the identified value.
    pub se: f64,
    /// The rate lies from the second to the seventh of the thesis' mesh, where the experiment can
    /// see it.
    pub interior: bool,
}

/// A model against the truth.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ColeColeComparison {
    /// Rate by rate.
    pub symbol: Vec<SymbolValue>,
    /// Largest |relative error| of the interior rates; NaN if there are none.
    pub largest_interior_error: f64,
    /// Number of identified values below zero.
    pub negative_values: usize,
    /// Root mean square difference of the model, run forward from rest, to the clean output.
    pub output_rmse: f64,
}

/// Compares the first pair of a model, and its output, with what `case` is made of.
///
/// # Errors
/// If the model has one rate only, which makes no continuous symbol.
pub fn compare(model: &Model, case: &ColeColeCase) -> Result<ColeColeComparison, ModelError> {
    let mut symbol = Vec::new();
    if let Some(pair) = model.pairs.first()
        && let Some(class) = pair.classes.values().next()
    {
        let identified = continuous_symbol(&pair.mesh_rad_s, &class.r_k_per_w)?;
        let errors = continuous_symbol(&pair.mesh_rad_s, &class.se_k_per_w)?;
        let rates = pair.mesh_rad_s.iter().copied();
        symbol = rates.zip(identified).zip(errors).map(|((rate, value), se)| one(rate, value, se)).collect();
    }
    let interior = symbol.iter().filter(|value| value.interior).map(|value| value.relative_error.abs());
    Ok(ColeColeComparison {
        largest_interior_error: interior.fold(f64::NAN, f64::max),
        negative_values: symbol.iter().filter(|value| value.identified < 0.0).count(),
        output_rmse: output_rmse(model, case),
        symbol,
    })
}

fn one(rate_rad_s: f64, identified: f64, se: f64) -> SymbolValue {
    let exact = symbol(rate_rad_s);
    SymbolValue {
        rate_rad_s,
        exact,
        identified,
        relative_error: identified / exact - 1.0,
        se,
        interior: is_interior(rate_rad_s),
    }
}

/// A thousandth is left for rounded edges.
fn is_interior(rate_rad_s: f64) -> bool {
    let mesh = thesis_mesh_rad_s();
    rate_rad_s > mesh[1] * 0.999 && rate_rad_s < mesh[THESIS_ORDER - 2] * 1.001
}

fn output_rmse(model: &Model, case: &ColeColeCase) -> f64 {
    let squares: f64 = predicted(model, case).zip(&case.clean).map(|(y, clean)| (y - clean).powi(2)).sum();
    (squares / case.clean.len() as f64).sqrt()
}

/// The model's first output for the case's input, from rest.
pub fn predicted(model: &Model, case: &ColeColeCase) -> impl Iterator<Item = f64> {
    let mut forward = Forward::at_rest(model, case.sample_period_s);
    let mut outputs = vec![0.0; model.outputs.len().max(1)];
    case.input.iter().map(move |&u| {
        forward.row(&[u], 0, f64::NAN, &mut outputs);
        outputs[0]
    })
}
