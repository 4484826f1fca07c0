//! The two symbols, each two voltages in turn, and the port that applies them to a device.

/// Two capacitances in F, read at the ends of the two parts of a symbol; none where the meter has
/// brought no reading, as at an overload.
pub type SymbolReadings = [Option<f64>; 2];

/// A device that takes symbols.
pub trait DevicePort {
    /// Applies one symbol, or 0 V for a symbol time, and reads the capacitance at the end of each
    /// part.
    ///
    /// # Errors
    /// If the device cannot be reached, or does not do so. The port has tried to leave
    /// it at 0 V.
    fn apply(&mut self, symbol: Option<ChargeSymbol>, shape: &SymbolShape) -> Result<SymbolReadings, PortError>;

    /// Leaves the device at 0 V.
    ///
    /// # Errors
    /// If that cannot be made sure of.
    fn release(&mut self) -> Result<(), PortError>;

    /// Values that the readings of the last symbol should have shown, where it is simulated.
    fn truth(&self) -> Option<DeviceTruth> {
        None
    }
}

/// Values that a simulated device had at the readings of a symbol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceTruth {
    /// V_sh, the mean of both, V.
    pub shift_v: f64,
    /// C₀ at the first, F.
    pub offset_f: f64,
}

/// Why a device takes no symbol.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{sentence}{}", if *is_released { "; the bias is 0 V" } else { "; that the bias is 0 V is not certain: take it off by hand" })]
pub struct PortError {
    /// Sentence: what is wrong, and what would be right.
    pub sentence: String,
    /// The device is known to be at 0 V.
    pub is_released: bool,
}

/// One bit of the stream that drives the charge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChargeSymbol {
    /// V₋ for (1 − δ) T_s, then V₊ for δ T_s.
    Bit0,
    /// V₊ for (1 − δ) T_s, then V₋ for δ T_s.
    Bit1,
}

/// Voltages and times of the symbols.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SymbolShape {
    /// V₊, V.
    pub positive_v: f64,
    /// V₋, V.
    pub negative_v: f64,
    /// Share δ of the second part, above 0 and below 1.
    pub second_share: f64,
    /// T_s, s.
    #[serde(skip)]
    pub symbol_time_s: f64,
}

impl SymbolShape {
    /// The two parts of a symbol: voltage in V and length in s of each.
    pub fn parts(&self, symbol: ChargeSymbol) -> [(f64, f64); 2] {
        let [first_v, second_v] = match symbol {
            ChargeSymbol::Bit0 => [self.negative_v, self.positive_v],
            ChargeSymbol::Bit1 => [self.positive_v, self.negative_v],
        };
        let second_s = self.second_share * self.symbol_time_s;
        [(first_v, self.symbol_time_s - second_s), (second_v, second_s)]
    }
}
