//! What a loop shall do, and which requirement cannot be met.

/// What a loop shall do.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirements {
    /// Lowest and highest set-point that would do, K above the first wind's temperature without
    /// heating.
    pub rise_k: (f64, f64),
    /// Low level that is given, W.
    pub power_low_w: Option<f64>,
    /// High level that is given, W.
    pub power_high_w: Option<f64>,
    /// How far the levels shall stay from u_Q, as a share of it: between 0 and 1.
    pub margin: f64,
    /// Swing of the temperature that is allowed, from peak to peak, K.
    pub ripple_k: f64,
    /// After a change of the wind the power shall be within 2 % of the change in this time, s.
    pub response_s: Option<f64>,
    /// From rest the set-point shall be reached in this time, s.
    pub reach_s: Option<f64>,
}
