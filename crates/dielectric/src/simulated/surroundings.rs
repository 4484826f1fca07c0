//! Temperature and humidity around a simulated device, as points between which both go straight.

/// A point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurroundingsPoint {
    /// When, s.
    pub start_s: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Relative humidity, %.
    pub humidity_percent: f64,
}

/// Temperature in °C and humidity in % at a moment; before the first point and after the last,
/// theirs. None without points.
pub fn surroundings_at(points: &[SurroundingsPoint], now_s: f64) -> Option<(f64, f64)> {
    let next = points.partition_point(|point| point.start_s <= now_s);
    let after = points.get(next).or(points.last())?;
    let before = points.get(next.saturating_sub(1))?;
    let length_s = after.start_s - before.start_s;
    let share = if length_s > 0.0 { ((now_s - before.start_s) / length_s).clamp(0.0, 1.0) } else { 0.0 };
    let between = |from: f64, to: f64| from + share * (to - from);
    Some((between(before.temperature_c, after.temperature_c), between(before.humidity_percent, after.humidity_percent)))
}
