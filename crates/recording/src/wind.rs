//! The columns of a wind estimate, in recordings of a calibrated head.
//!
//! | column | meaning | unit |
//! |---|---|---|
//! | `wind_x_m_s`, `wind_y_m_s`, `wind_z_m_s` | wind vector: where the gas goes to | m/s |
//! | `wind_speed_m_s` | speed | m/s |
//! | `wind_across_m_s` | its component in the directions that the head does not resolve | m/s |
//! | `wind_speed_u_m_s`, `wind_direction_u_deg` | standard uncertainties by the noise of the readings | m/s, ° |
//! | `wind_chi_square` | misfit of the conductances | |
//! | `wind_gas_temperature_c` | temperature of the gas that the estimate uses | °C |
//! | `conductance_w_k_<element>` | conductance to the gas, without conduction into the structure | W/K |
//! | `raw_w_k_<element>` | power over overheat | W/K |
//! | `quality_flags` | sum of the bits below; 0 for an estimate as good as its uncertainties | |
//! | `wind_from_deg` | direction from which it blows, clockwise from north, of a head with a heading | ° |
//! | `wind_up_m_s` | vertical wind, of such a head | m/s |
//!
//! | bit | flag | bit | flag |
//! |---|---|---|---|
//! | 1 | failed: no wind | 128 | uncalibrated |
//! | 2 | refused: a conductance made no sense | 256 | no-gas: temperature or pressure unknown |
//! | 4 | degraded: surfaces are missing | 512 | not-running |
//! | 8 | ambiguous: another wind fits as well | 1024 | saturated: a loop is at one level |
//! | 16 | undetermined: the head does not resolve all directions | 2048 | starting |
//! | 32 | no-direction | 4096 | cold: a surface is no warmer than the gas |
//! | 64 | extrapolated: beyond the calibration | 8192 | inconsistent: measurements contradict each other |
//! | | | 16384 | below-calibration: slower than its slowest wind |
//!
//! Numbers are missing in rows without an estimate, and those of the wind where it failed.

use dr_core::wind::QualityFlags;
use wire::WindSample;

use crate::names::{CONDUCTANCE, GIVEN_WIND, RAW_CONDUCTANCE, column_name};

/// The wind vector.
pub const WIND_ESTIMATE: [&str; 3] = GIVEN_WIND;
/// The speed.
pub const WIND_SPEED: &str = "wind_speed_m_s";
/// Standard uncertainty of the speed.
pub const SPEED_UNCERTAINTY: &str = "wind_speed_u_m_s";
/// Standard uncertainty of the direction.
pub const DIRECTION_UNCERTAINTY: &str = "wind_direction_u_deg";
/// Temperature of the gas that the estimate uses.
pub const ESTIMATED_GAS: &str = "wind_gas_temperature_c";
/// Quality flags, a sum of bits.
pub const QUALITY_FLAGS: &str = "quality_flags";
/// Direction from which the wind blows, clockwise from north.
pub const WIND_FROM: &str = "wind_from_deg";
/// Vertical wind.
pub const WIND_UP: &str = "wind_up_m_s";
/// Columns of the wind on the earth, by a head whose mounting is known.
pub const EARTH: [&str; 2] = [WIND_FROM, WIND_UP];
/// Key of the metadata: the normal of the plane in which all winds are, three numbers.
pub const PLANE_NORMAL: &str = "wind_plane_normal";
const CHI_SQUARE: &str = "wind_chi_square";
/// Columns of a wind by several instruments.
pub const COMBINED: [&str; 8] = [
    WIND_ESTIMATE[0],
    WIND_ESTIMATE[1],
    WIND_ESTIMATE[2],
    WIND_SPEED,
    SPEED_UNCERTAINTY,
    DIRECTION_UNCERTAINTY,
    CHI_SQUARE,
    QUALITY_FLAGS,
];
const OTHERS: [&str; 5] = ["wind_across_m_s", SPEED_UNCERTAINTY, DIRECTION_UNCERTAINTY, CHI_SQUARE, ESTIMATED_GAS];

/// Names of the columns of a head with these surfaces; none for a head that is not calibrated.
pub fn columns(surfaces: &[String]) -> Vec<String> {
    if surfaces.is_empty() {
        return Vec::new();
    }
    let fixed = WIND_ESTIMATE.into_iter().chain([WIND_SPEED]).chain(OTHERS).map(str::to_owned);
    let of_surfaces = |quantity: &'static str| surfaces.iter().map(move |surface| column_name(quantity, surface));
    fixed
        .chain(of_surfaces(CONDUCTANCE))
        .chain(of_surfaces(RAW_CONDUCTANCE))
        .chain([QUALITY_FLAGS.to_owned()])
        .collect()
}

/// The numbers of a row, in the order of the columns.
pub fn numbers(estimate: Option<&WindSample>, surfaces: usize) -> Vec<f32> {
    if surfaces == 0 {
        return Vec::new();
    }
    let Some(estimate) = estimate else { return vec![f32::NAN; columns(&vec![String::new(); surfaces]).len()] };
    let has_wind = !estimate.quality_flags.has(QualityFlags::FAILED);
    let wind = |number: f32| if has_wind { number } else { f32::NAN };
    let gas_c = if estimate.quality_flags.has(QualityFlags::NO_GAS) { f32::NAN } else { estimate.gas_c };
    let mut numbers: Vec<f32> = estimate.wind_m_s.map(wind).to_vec();
    numbers.extend([
        wind(estimate.speed_m_s),
        wind(estimate.across_m_s),
        wind(estimate.speed_error_m_s),
        wind(estimate.direction_error_rad.to_degrees()),
        wind(estimate.chi_square),
        gas_c,
    ]);
    for of in [&estimate.conductance_w_k, &estimate.raw_w_k] {
        // Zero stands for a surface that was not measured.
        let measured = |surface| of.get(surface).copied().filter(|&w_k| w_k != 0.0).unwrap_or(f32::NAN);
        numbers.extend((0..surfaces).map(measured));
    }
    numbers.push(f32::from(estimate.quality_flags.0));
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_number_for_every_column() {
        let surfaces = ["a".to_owned(), "b".to_owned()];
        let estimate = WindSample {
            quality_flags: QualityFlags::DEGRADED,
            wind_m_s: [1.0, 2.0, 3.0],
            speed_m_s: 4.0,
            across_m_s: 0.5,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.1,
            direction_error_rad: 0.5_f32.to_radians(),
            chi_square: 1.5,
            gas_c: -53.0,
            conductance_w_k: [0.001, 0.0].into_iter().collect(),
            raw_w_k: [0.002, 0.003].into_iter().collect(),
        };
        let row = |estimate: Option<&WindSample>| {
            let numbers = numbers(estimate, surfaces.len());
            assert_eq!(numbers.len(), columns(&surfaces).len());
            columns(&surfaces).into_iter().zip(numbers).collect::<std::collections::HashMap<_, _>>()
        };
        let estimated = row(Some(&estimate));
        assert_eq!((estimated["wind_y_m_s"], estimated["wind_speed_m_s"], estimated["quality_flags"]), (2.0, 4.0, 4.0));
        assert!((estimated["wind_direction_u_deg"] - 0.5).abs() < 1e-6);
        assert_eq!((estimated["conductance_w_k_a"], estimated["raw_w_k_b"]), (0.001, 0.003));
        assert!(estimated["conductance_w_k_b"].is_nan(), "not measured");
        let failed = row(Some(&WindSample { quality_flags: QualityFlags(1 | 256), ..estimate }));
        assert!(failed["wind_x_m_s"].is_nan() && failed["wind_gas_temperature_c"].is_nan());
        assert_eq!(failed["quality_flags"], 257.0);
        assert!(row(None).values().all(|number| number.is_nan()));
        assert!(numbers(None, 0).is_empty() && columns(&[]).is_empty());
    }
}
