//! A device in which an identified model stands for the charge: what a prediction runs on.

use diffusive::model::{Forward, Model};

use crate::device::Device;
use crate::experiment::DeviceExperiment;
use crate::port::{DevicePort, PortError, SymbolReadings};
use crate::symbol::{ChargeSymbol, SymbolShape};

/// A share of the second part of a symbol so small that nothing is interpolated: the model gives
/// the voltage shift as it was read.
const SECOND_SHARE: f64 = 0.001;

/// A device whose voltage shift is a model's output.
pub(super) struct ModelledDevice {
    device: Device,
    forward: Forward,
}

impl ModelledDevice {
    /// At rest: nothing has been applied yet.
    pub fn new(model: &Model, device: &Device, symbol_time_s: f64) -> Self {
        Self { device: device.clone(), forward: Forward::at_rest(model, symbol_time_s) }
    }

    /// The experiment as it runs on the model.
    pub fn experiment(experiment: &DeviceExperiment) -> DeviceExperiment {
        let shape = SymbolShape { second_share: SECOND_SHARE, ..experiment.shape };
        DeviceExperiment { shape, ..experiment.clone() }
    }
}

impl DevicePort for ModelledDevice {
    fn apply(&mut self, symbol: Option<ChargeSymbol>, shape: &SymbolShape) -> Result<SymbolReadings, PortError> {
        let input = match symbol {
            None => 0.0,
            Some(ChargeSymbol::Bit0) => -1.0,
            Some(ChargeSymbol::Bit1) => 1.0,
        };
        let mut shift_v = [0.0];
        self.forward.row(&[input], 0, f64::NAN, &mut shift_v);
        self.forward.outputs(&mut shift_v);
        let parts = symbol.map_or([(0.0, 0.0); 2], |symbol| shape.parts(symbol));
        Ok(parts
            .map(|(bias_v, _)| Some(self.device.offset_f + self.device.curvature_f_v2 * (bias_v - shift_v[0]).powi(2))))
    }

    fn release(&mut self) -> Result<(), PortError> {
        Ok(())
    }
}
