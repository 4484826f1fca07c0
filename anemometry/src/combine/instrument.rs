//! An instrument that sees a part of the wind.

/// What an instrument says at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstrumentReading {
    /// Where the gas goes to, in the instrument's frame, m/s; of one that only knows the speed
    /// (v, 0, 0), of one that only knows the direction a unit vector.
    pub wind_m_s: [f64; 3],
    /// Standard uncertainty of its speed, m/s.
    pub speed_u_m_s: f64,
    /// Of its direction, rad.
    pub direction_u_rad: f64,
    /// Whether it knows no speed.
    pub is_direction: bool,
}
