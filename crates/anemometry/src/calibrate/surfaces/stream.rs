//! The stream that a sphere meets in the winds of a calibration.

use dr_core::wind::FreeStream;
use dr_core::wind::free_stream::STEM_CHORD;

use super::readings::CheckedWind;
use crate::vector::dot;

/// The stream that a head meets in a wind, m/s in the tunnel's frame.
pub fn met_m_s(stream: &FreeStream, wind: &CheckedWind) -> [f64; 3] {
    let v = wind.towards.map(|x| (x * wind.speed_m_s) as f32);
    let rise = stream.rise_speed_m_s(wind.overheat_k as f32, wind.gas_k as f32, wind.diameter_m as f32);
    stream.met(v, rise).map(f64::from)
}

/// Chord between a direction from which a wind comes and the stem.
pub fn chord(towards: [f64; 3], axis: [f64; 3]) -> f64 {
    (2.0 + 2.0 * dot(towards, axis)).max(0.0).sqrt()
}

/// Whether a wind comes from where a stem may matter.
pub fn is_behind(wind: &CheckedWind, axis: [f64; 3]) -> bool {
    !wind.is_quiescent() && chord(wind.towards, axis) < f64::from(STEM_CHORD)
}
