//! A model that runs over a record, row by row.

use super::super::record::{RecordError, RecordSource, copy_row};
use super::super::residuals::FitRow;
use crate::model::{Forward, Model, ModelGas};

/// By whose temperatures heat is lost to the wind, and by losses that grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LossesBy {
    Predicted,
    Measured,
}

/// Runs the model over the record, over every segment from what `begin` makes of it. `seen` hears
/// of each row and the segment that it is of; outputs that are missing are NaN, and so is what is
/// predicted where there is no beginning.
pub(super) fn run(
    model: &Model,
    source: &mut dyn RecordSource,
    begin: &mut dyn FnMut(usize) -> Option<Forward>,
    losses: LossesBy,
    seen: &mut dyn FnMut(usize, &FitRow<'_>),
) -> Result<(), RecordError> {
    source.restart()?;
    let event_column = source.survey().event_column.clone().unwrap_or_default();
    let (inputs, outputs) = (model.inputs.len(), model.outputs.len());
    let constant_gas_c = match model.wind.as_ref().map(|wind| &wind.gas) {
        Some(ModelGas::ConstantC(gas_c)) => *gas_c,
        Some(ModelGas::EstimatedC(gas)) => gas.value,
        Some(ModelGas::Column(_)) | None => 0.0,
    };
    let (mut input_row, mut measured, mut predicted) = (vec![0.0; inputs], vec![0.0; outputs], vec![0.0; outputs]);
    let period_s = source.survey().sample_period_s;
    let (mut row, mut segment) = (0_u64, 0);
    let mut forward = begin(segment);
    // Which of the model's classes each of the record's is.
    let mut classes: Vec<usize> = Vec::new();
    while let Some(block) = source.next_block()?.cloned() {
        for label in source.classes().iter().skip(classes.len()) {
            let known = model.classes.iter().position(|known| known == label);
            if known.is_none() && model.classes.len() > 1 {
                return Err(source.survey().refuse(format!(
                    "column `{event_column}`: the model knows no class `{label}`; it was identified for {}",
                    model.classes.join(", ")
                )));
            }
            classes.push(known.unwrap_or(0));
        }
        if block.begins_segment && row > 0 {
            segment += 1;
            forward = begin(segment);
        }
        let mut missing = block.missing.iter().map(|&row| row as usize).peekable();
        for at in 0..block.len() {
            copy_row(&block.inputs, at, &mut input_row);
            copy_row(&block.outputs, at, &mut measured);
            let class = classes[block.class[at] as usize];
            let gas_c = block.gas.get(at).copied().unwrap_or(constant_gas_c);
            match (&mut forward, losses) {
                (None, _) => predicted.fill(f64::NAN),
                (Some(forward), LossesBy::Predicted) => forward.row(&input_row, class, gas_c, &mut predicted),
                (Some(forward), LossesBy::Measured) => {
                    forward.row_of_measured(&input_row, class, gas_c, &measured, &mut predicted);
                }
            }
            if missing.next_if_eq(&at).is_some() {
                measured.fill(f64::NAN);
            }
            let since_s = row as f64 * period_s;
            seen(
                segment,
                &FitRow { row, since_s, class, measured: &measured, predicted: &predicted, drift: &[], drift_se: &[] },
            );
            row += 1;
        }
    }
    source.restart()?;
    Ok(())
}
