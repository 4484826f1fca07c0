//! A device in which an identified model stands for the charge: what a prediction runs on.

use diffusive::model::{Forward, Model, ModelError, Pair};
use recording::BITS;

use super::locking::{ResponsePart, SymbolResponse};
use crate::device::{Device, MemsCapacitor};
use crate::port::{ChargeSymbol, SymbolShape};
use crate::port::{DevicePort, PortError, SymbolReadings};

/// Inputs by which a model takes symbols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SymbolInputs {
    /// One input of −1 and +1.
    Symbol,
    /// Two inputs of 0 and 1, with the place of that of symbol 1.
    Bits(usize),
}

impl SymbolInputs {
    /// Inputs of a model of one output.
    pub fn of(model: &Model) -> Result<Self, ModelError> {
        let refused = |what: String| {
            ModelError::new(format!(
                "{what}, where a model of charge has the voltage shift as its only output and one input `symbol_…`, or two, `bit1_…` and `bit0_…`"
            ))
        };
        let listed = || format!("has inputs {} and {} outputs", model.inputs.join(", "), model.outputs.len());
        if model.outputs.len() != 1 || model.classes.len() != 1 || model.wind.is_some() {
            return Err(refused(listed()));
        }
        let at_once = |pair: &Pair| {
            pair.dead_time_samples == 0 && pair.classes.values().any(|class| class.feed_through_k_per_w != 0.0)
        };
        if model.pairs.iter().any(at_once) {
            return Err(ModelError::new(
                "answers a symbol before it is applied (a feed-through without a dead time), so that no loop can be predicted from it: identify it from a recording of `anemo run`, whose shifts are those before the symbol",
            ));
        }
        match model.inputs.as_slice() {
            [_] => Ok(Self::Symbol),
            [first, second] if first.starts_with(BITS[0]) && second.starts_with(BITS[1]) => Ok(Self::Bits(0)),
            [first, second] if first.starts_with(BITS[1]) && second.starts_with(BITS[0]) => Ok(Self::Bits(1)),
            _ => Err(refused(listed())),
        }
    }

    /// Values of the inputs under a symbol, or at 0 V.
    fn values(self, symbol: Option<ChargeSymbol>) -> Vec<f64> {
        let is = |of: ChargeSymbol| if symbol == Some(of) { 1.0 } else { 0.0 };
        let (one, zero) = (is(ChargeSymbol::Bit1), is(ChargeSymbol::Bit0));
        match self {
            Self::Symbol => vec![one - zero],
            Self::Bits(0) => vec![one, zero],
            Self::Bits(_) => vec![zero, one],
        }
    }

    /// Response of a model to symbols that never cease: of two inputs b and 1 − b, half the
    /// difference of their gains to ±1, and half their sum for good.
    pub fn response(self, model: &Model, symbol_time_s: f64) -> SymbolResponse {
        let offset_v = model.outputs.first().map_or(0.0, |output| output.offset_c);
        let mut response = SymbolResponse { offset_v, parts: Vec::new(), symbol_time_s };
        for (pair, class) in model.pairs.iter().flat_map(|pair| pair.classes.values().map(move |class| (pair, class))) {
            let is_one = match self {
                Self::Symbol => None,
                Self::Bits(one) => Some(model.inputs.get(one) == Some(&pair.input)),
            };
            let weight = match is_one {
                None => 1.0,
                Some(true) => 0.5,
                Some(false) => -0.5,
            };
            let steady_v = class.r_k_per_w.iter().sum::<f64>() + class.feed_through_k_per_w;
            response.offset_v += if is_one.is_some() { 0.5 * steady_v } else { 0.0 };
            response.parts.push(ResponsePart {
                rates_rad_s: pair.mesh_rad_s.clone(),
                gains_v: class.r_k_per_w.iter().map(|gain| weight * gain).collect(),
                feed_through_v: weight * class.feed_through_k_per_w,
                dead_time: (pair.dead_time_samples as f64 * model.sample_period_s / symbol_time_s).round() as usize,
            });
        }
        response
    }
}

/// A device whose voltage shift is a model's output.
pub(super) struct ModelledDevice {
    device: Device,
    forward: Forward,
    inputs: SymbolInputs,
}

impl ModelledDevice {
    /// At rest: nothing has been applied yet.
    pub fn new(model: &Model, inputs: SymbolInputs, device: &Device, symbol_time_s: f64) -> Self {
        Self { device: device.clone(), forward: Forward::at_rest(model, symbol_time_s), inputs }
    }
}

impl DevicePort for ModelledDevice {
    fn apply(&mut self, symbol: Option<ChargeSymbol>, shape: &SymbolShape) -> Result<SymbolReadings, PortError> {
        let mut shift_v = [0.0];
        self.forward.row(&self.inputs.values(symbol), 0, f64::NAN, &mut shift_v);
        self.forward.outputs(&mut shift_v);
        let parts = symbol.map_or([(0.0, 0.0); 2], |symbol| shape.parts(symbol));
        let MemsCapacitor { curvature_f_v2, offset_f, .. } = self.device.capacitor;
        Ok(parts.map(|(bias_v, _)| Some(offset_f + curvature_f_v2 * (bias_v - shift_v[0]).powi(2))))
    }

    fn release(&mut self) -> Result<(), PortError> {
        Ok(())
    }
}
