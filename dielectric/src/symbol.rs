//! The two symbols: how one bit becomes two voltages in turn.

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
