//! The rows in which a record has not begun to heat: physics that is known before any fit.
//!
//! Where nothing heats and nothing moves, an output stands at its offset. An estimate that
//! contradicts it comes of the model's structure, of losses that grow or of a drift, and is no
//! surer than the difference.

use recording::text::{estimate, short};

use super::record::Block;
use super::spread::ValueSpread;
use crate::model::ModelOutput;

/// Rows that show that an output stands, whatever it began with.
const ENOUGH: u64 = 5;
/// Standard errors by which an offset contradicts.
const FAR: f64 = 3.0;
/// Spread of an output that stands, in units of what its model leaves.
const STANDS: f64 = 2.0;

/// Outputs in the rows before the first power.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct QuietStart {
    is_over: bool,
    outputs: Vec<ValueSpread>,
}

impl QuietStart {
    /// Reads on, until an input is not zero.
    pub fn add(&mut self, block: &Block) {
        if self.is_over {
            return;
        }
        let quiet = |values: &Vec<f64>| values.iter().take_while(|value| **value == 0.0).count();
        let rows = block.inputs.iter().map(quiet).min().unwrap_or(0);
        self.is_over = rows < block.len();
        if self.outputs.is_empty() {
            self.outputs = block.outputs.iter().map(|values| ValueSpread::from(values[0])).collect();
        }
        for (spread, values) in self.outputs.iter_mut().zip(&block.outputs) {
            spread.add(&values[..rows]);
        }
    }

    /// Widens the standard error of an offset that these rows contradict, and says so. A model that
    /// began `at_rest` states that it stood; else the rows must show it.
    pub fn held_against(&self, place: usize, at_rest: bool, output: &mut ModelOutput) -> Option<String> {
        let fewest = if at_rest { 1 } else { ENOUGH };
        let spread = self.outputs.get(place).filter(|spread| self.is_over && spread.count >= fewest)?;
        let stands_c = spread.from + spread.sum / spread.count as f64;
        let se_k = spread.sd().max(output.residual_rms) / (spread.count as f64).sqrt();
        let apart_k = output.offset_c - stands_c;
        let is_far = apart_k.abs() > FAR * libm::hypot(output.se_offset_c, se_k).max(output.residual_rms / 10.0);
        if !is_far || spread.sd() > STANDS * output.residual_rms {
            return None;
        }
        let found = estimate(output.offset_c, output.se_offset_c);
        output.se_offset_c = libm::hypot(output.se_offset_c, apart_k);
        Some(format!(
            "`{}`: the offset {found} contradicts the {} rows before the first power, at {}: a drift, losses that grow, or heat before the record; record again from rest",
            output.name,
            spread.count,
            short(stands_c, 4)
        ))
    }
}
