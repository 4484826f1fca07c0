//! A record with the losses that grow with temperature taken out of its inputs, or beside them.
//!
//! ```text
//! taken:   w_i = u_i − Σ g (T_o − T_0)²            beside:   u_1 … u_I | (T_o − T_0)² …
//! ```

use super::super::record::{Block, RecordError, RecordSource, Survey};
use crate::model::PlacedLoss;

/// A loss as it is searched for: with the temperature that it counts from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchedLoss {
    pub placed: PlacedLoss,
    /// T_0: the offset, as far as it is known, °C.
    pub origin_c: f64,
}

impl SearchedLoss {
    /// (T_o − T_0)² in the rows of a block, K². Where surroundings are measured, T_0 moves with
    /// them from what they were in the record's first row.
    fn squares<'b>(&self, block: &'b Block, first_gas_c: Option<f64>) -> impl Iterator<Item = f64> + use<'b> {
        let origin_c = self.origin_c;
        block.outputs[self.placed.output].iter().enumerate().map(move |(row, temperature_c)| {
            let ambient_k = first_gas_c.map_or(0.0, |first_c| block.gas[row] - first_c);
            let rise_k = temperature_c - origin_c - ambient_k;
            rise_k * rise_k
        })
    }
}

/// What becomes of the losses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LossColumns {
    /// They are taken out of the inputs.
    Taken,
    /// Their squares are inputs more, one a loss, in W a W/K².
    Beside,
}

/// The inner record with its losses.
pub struct LossSource<'a> {
    inner: &'a mut dyn RecordSource,
    losses: &'a [SearchedLoss],
    columns: LossColumns,
    survey: Survey,
    block: Block,
    /// Whether the gas is a surrounding from which losses count, and what it was in the first row.
    follow_ambient: bool,
    first_gas_c: Option<f64>,
}

impl<'a> LossSource<'a> {
    pub fn new(
        inner: &'a mut dyn RecordSource,
        losses: &'a [SearchedLoss],
        columns: LossColumns,
        follow_ambient: bool,
    ) -> Self {
        let mut survey = inner.survey().clone();
        if columns == LossColumns::Beside {
            survey.inputs.extend((0..losses.len()).map(|at| format!("loss {at}")));
        }
        Self { inner, losses, columns, survey, block: Block::default(), follow_ambient, first_gas_c: None }
    }
}

impl RecordSource for LossSource<'_> {
    fn survey(&self) -> &Survey {
        &self.survey
    }

    fn next_block(&mut self) -> Result<Option<&Block>, RecordError> {
        let Some(block) = self.inner.next_block()? else {
            // The end of a reading may know more.
            let survey = self.inner.survey();
            (self.survey.rows, self.survey.notes) = (survey.rows, survey.notes.clone());
            return Ok(None);
        };
        self.block.clone_from(block);
        if self.follow_ambient {
            self.first_gas_c = self.first_gas_c.or(block.gas.first().copied());
        }
        for loss in self.losses {
            match self.columns {
                LossColumns::Taken => {
                    let input = &mut self.block.inputs[loss.placed.input];
                    let g = loss.placed.g_w_per_k2;
                    input
                        .iter_mut()
                        .zip(loss.squares(block, self.first_gas_c))
                        .for_each(|(input, square)| *input -= g * square);
                }
                LossColumns::Beside => self.block.inputs.push(loss.squares(block, self.first_gas_c).collect()),
            }
        }
        Ok(Some(&self.block))
    }

    fn restart(&mut self) -> Result<(), RecordError> {
        self.inner.restart()
    }

    fn classes(&self) -> &[String] {
        self.inner.classes()
    }
}
