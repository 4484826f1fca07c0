//! The columns in which a recording has what the anemometer says.
//!
//! | column | meaning | unit |
//! |---|---|---|
//! | `answer_x_m_s`, `answer_y_m_s`, `answer_z_m_s` | the wind, where the gas goes to | m/s |
//! | `answer_speed_m_s` | all of its speed | m/s |
//! | `answer_across_m_s` | its speed in the directions that the head leaves open | m/s |
//! | `answer_speed_error_m_s`, `answer_direction_error_deg` | standard errors by the noise of the readings | m/s, ° |
//! | `answer_chi_square` | whether the conductances fit together | |
//! | `answer_gas_c` | temperature of the gas as the anemometer knows it | °C |
//! | `conductance_w_k:<element>` | conductance to the gas, without what the structure takes | W/K |
//! | `raw_w_k:<element>` | what power over overheat alone would say | W/K |
//! | `answer_doubts` | sum of the bits below; 0 for an answer as good as its errors say | |
//!
//! | bit | doubt | bit | doubt |
//! |---|---|---|---|
//! | 1 | failed: no wind | 128 | uncalibrated |
//! | 2 | refused: a conductance made no sense | 256 | no-gas: temperature or pressure unknown |
//! | 4 | degraded: parts are missing | 512 | not-running |
//! | 8 | ambiguous: another wind fits as well | 1024 | saturated: a loop is at one level |
//! | 16 | undetermined: the head does not see all directions | 2048 | starting |
//! | 32 | no-direction | 4096 | cold: a part is no warmer than the gas |
//! | 64 | extrapolated: beyond the calibration | | |
//!
//! Numbers are missing in rows without an answer, and those of the wind where it failed.

use dr_core::control::Doubts;
use wire::WindSample;

pub const ANSWER: [&str; 3] = ["answer_x_m_s", "answer_y_m_s", "answer_z_m_s"];
pub const ANSWER_SPEED: &str = "answer_speed_m_s";
pub const ANSWER_DOUBTS: &str = "answer_doubts";
pub const CONDUCTANCE: &str = "conductance_w_k:";
pub const RAW_CONDUCTANCE: &str = "raw_w_k:";
const OTHERS: [&str; 5] =
    ["answer_across_m_s", "answer_speed_error_m_s", "answer_direction_error_deg", "answer_chi_square", "answer_gas_c"];

/// Names of the columns of a head with these parts; none for a head that does not answer.
pub fn columns(parts: &[String]) -> Vec<String> {
    if parts.is_empty() {
        return Vec::new();
    }
    let fixed = ANSWER.into_iter().chain([ANSWER_SPEED]).chain(OTHERS).map(str::to_owned);
    let of_parts = |prefix: &'static str| parts.iter().map(move |part| format!("{prefix}{part}"));
    fixed.chain(of_parts(CONDUCTANCE)).chain(of_parts(RAW_CONDUCTANCE)).chain([ANSWER_DOUBTS.to_owned()]).collect()
}

/// The numbers of a row, in the order of the columns.
pub fn numbers(answer: Option<&WindSample>, parts: usize) -> Vec<f32> {
    if parts == 0 {
        return Vec::new();
    }
    let Some(answer) = answer else { return vec![f32::NAN; columns(&vec![String::new(); parts]).len()] };
    let has_wind = !answer.doubts.has(Doubts::FAILED);
    let wind = |number: f32| if has_wind { number } else { f32::NAN };
    let gas_c = if answer.doubts.has(Doubts::NO_GAS) { f32::NAN } else { answer.gas_c };
    let mut numbers: Vec<f32> = answer.wind_m_s.map(wind).to_vec();
    numbers.extend([
        wind(answer.speed_m_s),
        wind(answer.across_m_s),
        wind(answer.speed_error_m_s),
        wind(answer.direction_error_rad.to_degrees()),
        wind(answer.chi_square),
        gas_c,
    ]);
    for of in [&answer.conductance_w_k, &answer.raw_w_k] {
        // Zero is the word for a part that was not measured.
        let measured = |part| of.get(part).copied().filter(|&w_k| w_k != 0.0).unwrap_or(f32::NAN);
        numbers.extend((0..parts).map(measured));
    }
    numbers.push(f32::from(answer.doubts.0));
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_number_for_every_column() {
        let parts = ["a".to_owned(), "b".to_owned()];
        let answer = WindSample {
            doubts: Doubts::DEGRADED,
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
        let row = |answer: Option<&WindSample>| {
            let numbers = numbers(answer, parts.len());
            assert_eq!(numbers.len(), columns(&parts).len());
            columns(&parts).into_iter().zip(numbers).collect::<std::collections::HashMap<_, _>>()
        };
        let told = row(Some(&answer));
        assert_eq!((told["answer_y_m_s"], told["answer_speed_m_s"], told["answer_doubts"]), (2.0, 4.0, 4.0));
        assert!((told["answer_direction_error_deg"] - 0.5).abs() < 1e-6);
        assert_eq!((told["conductance_w_k:a"], told["raw_w_k:b"]), (0.001, 0.003));
        assert!(told["conductance_w_k:b"].is_nan(), "not measured");
        let failed = row(Some(&WindSample { doubts: Doubts(1 | 256), ..answer }));
        assert!(failed["answer_x_m_s"].is_nan() && failed["answer_gas_c"].is_nan());
        assert_eq!(failed["answer_doubts"], 257.0);
        assert!(row(None).values().all(|number| number.is_nan()));
        assert!(numbers(None, 0).is_empty() && columns(&[]).is_empty());
    }
}
