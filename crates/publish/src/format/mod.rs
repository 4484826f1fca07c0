//! Rows as the text that other programs read: pure functions of a row.
//!
//! Direction is *from*, clockwise from north; the horizontal speed goes with it.

pub mod gill;
pub mod home_assistant;
pub mod nmea;
mod numbers;

pub use numbers::FeedColumns;

/// Bytes combined by exclusive or, as NMEA 0183 and Gill's strings check themselves.
fn xor(text: &str) -> u8 {
    text.bytes().fold(0, |sum, byte| sum ^ byte)
}

/// A direction rounded to `digits` behind the point: below 360 after rounding, too.
fn rounded_deg(from_deg: f64, digits: i32) -> f64 {
    let unit = 10_f64.powi(digits);
    (from_deg * unit).round() / unit % 360.0
}

#[cfg(test)]
pub(crate) mod examples {
    use crate::feed::{FeedLayout, FeedRow, FeedWind};
    use dr_core::wind::QualityFlags;
    use recording::head_mounting::HeadMounting;
    use std::time::{Duration, SystemTime};

    /// 2026-11-23 12:00:00.25 UTC.
    pub fn utc() -> SystemTime {
        SystemTime::UNIX_EPOCH + Duration::from_millis(1_795_435_200_250)
    }

    /// A head of one surface whose x axis points north.
    pub fn layout() -> FeedLayout {
        FeedLayout {
            title: "mast".to_owned(),
            head: "sphere, silver".to_owned(),
            elements: vec!["sector-1".to_owned(), "core".to_owned()],
            surfaces: vec!["sector-1".to_owned()],
            sample_period_s: 0.01,
            firmware: "anemo 0.2.0".to_owned(),
            unique_id: [0x1, 0xabcd, 0xffff_ffff],
            ..FeedLayout::default()
        }
    }

    /// A wind of `speed_m_s` from `from_deg`.
    pub fn wind(speed_m_s: f32, from_deg: f32, quality_flags: QualityFlags) -> FeedWind {
        let (sin, cos) = from_deg.to_radians().sin_cos();
        let estimate = wire::WindSample {
            quality_flags,
            wind_m_s: [-speed_m_s * cos, speed_m_s * sin, 0.0],
            speed_m_s,
            across_m_s: 0.0,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.25,
            direction_error_rad: 0.1,
            chi_square: 1.0,
            gas_c: 20.0,
            conductance_w_k: [0.001].into_iter().collect(),
            raw_w_k: [0.002].into_iter().collect(),
        };
        FeedWind::new(estimate, &HeadMounting::default())
    }

    /// A row of [`layout`]; the reading of the core is missing.
    pub fn row(wind: Option<FeedWind>) -> FeedRow {
        FeedRow {
            time_s: 12.5,
            utc: utc(),
            temperature_c: vec![60.1, f32::NAN],
            power_w: vec![0.05, 0.5],
            equivalent_power_w: vec![],
            heaters: 0b10,
            state: "running".into(),
            wind,
            true_wind_m_s: None,
            gas_temperature_c: None,
        }
    }
}
