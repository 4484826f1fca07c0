//! Rows as the text that other programs read: pure functions of a row.
//!
//! Direction is *from*, clockwise from north; the horizontal speed goes with it.
//!
//! ASCII strings of Gill's two-axis anemometers, which many loggers decode (WindSonic user manual,
//! doc. 1405 PS 0019, sections 9.1 and 9.2).
//!
//! | mode | string | numbers |
//! |---|---|---|
//! | polar | `<STX>A,229,002.74,M,00,<ETX>CC` | direction from which it blows, °; speed |
//! | UV | `<STX>A,+001.59,-002.74,M,00,<ETX>CC` | towards north, towards west |
//!
//! M is m/s, CC the exclusive or of all between `<STX>` and `<ETX>`. Status 00 is good, 04 (`sample
//! failure`) anything else: then the numbers are empty.
//!
//! NMEA 0183, sentence MWV: wind speed and angle.
//!
//! `$WIMWV,191.0,R,000.55,M,A*19`: talker WI (weather instrument), angle in degrees from which it
//! blows, R as it is measured (relative to the mark that the instrument's mounting points north),
//! speed, M for m/s, A for valid, and after the star the exclusive or of all between `$` and `*`.

use crate::feed::FeedWind;

pub mod home_assistant;

pub use home_assistant::FeedColumns;

/// Bytes combined by exclusive or, as NMEA 0183 and Gill's strings check themselves.
fn xor(text: &str) -> u8 {
    text.bytes().fold(0, |sum, byte| sum ^ byte)
}

/// A direction rounded to `digits` behind the point: below 360 after rounding, too.
fn rounded_deg(from_deg: f64, digits: i32) -> f64 {
    let unit = 10_f64.powi(digits);
    (from_deg * unit).round() / unit % 360.0
}

/// Speed and direction, with CR LF. The direction alone is empty where there is none, as Gill's are
/// below their least speed.
pub fn polar(wind: &FeedWind) -> String {
    if !wind.is_valid() {
        return framed("A,,,M,04,");
    }
    let direction = match wind.has_direction() {
        true => format!("{:03.0}", rounded_deg(wind.from_deg, 0)),
        false => String::new(),
    };
    framed(&format!("A,{direction},{:06.2},M,00,", wind.horizontal_m_s))
}

/// The two components, with CR LF.
pub fn uv(wind: &FeedWind) -> String {
    if !wind.has_direction() {
        return framed("A,,,M,04,");
    }
    let (sin, cos) = libm::sincos(wind.from_deg.to_radians());
    let speed_m_s = wind.horizontal_m_s;
    // There is no −0: added to zero, it is +0.
    let rounded = |number: f64| (number * 100.0).round() / 100.0 + 0.0;
    framed(&format!("A,{:+07.2},{:+07.2},M,00,", rounded(-speed_m_s * cos), rounded(speed_m_s * sin)))
}

fn framed(body: &str) -> String {
    format!("\x02{body}\x03{:02X}\r\n", xor(body))
}

/// One sentence with its CR LF. Of a wind that is not valid, or has no direction, the fields are
/// empty and the flag is V, so that no reader takes a number of it.
pub fn mwv(wind: &FeedWind) -> String {
    let fields = if wind.has_direction() {
        format!("{:05.1},R,{:06.2},M,A", rounded_deg(wind.from_deg, 1), wind.horizontal_m_s)
    } else {
        ",R,,M,V".to_owned()
    };
    let body = format!("WIMWV,{fields}");
    format!("${body}*{:02X}\r\n", xor(&body))
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
        let (sin, cos) = libm::sincosf(from_deg.to_radians());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::examples::wind;
    use dr_core::wind::QualityFlags;

    const GOOD: QualityFlags = QualityFlags(0);

    /// The polar example of section 9.1. The one of section 9.2 has blanks and is of other bytes.
    #[test]
    fn the_checksum_is_that_of_the_manuals_example() {
        assert_eq!(xor("Q,229,002.74,M,00,"), 0x16);
    }

    #[test]
    fn polar_strings_have_the_manuals_widths() {
        let body = "A,229,002.74,M,00,";
        assert_eq!(polar(&wind(2.74, 229.0, GOOD)), format!("\x02{body}\x03{:02X}\r\n", xor(body)));
        assert!(polar(&wind(2.74, 359.6, GOOD)).starts_with("\x02A,000,"));
        assert!(polar(&wind(0.01, 10.0, QualityFlags::NO_DIRECTION)).starts_with("\x02A,,000.01,M,00,\x03"));
        assert!(polar(&wind(2.0, 10.0, QualityFlags::FAILED)).starts_with("\x02A,,,M,04,\x03"));
    }

    #[test]
    fn u_is_positive_for_a_south_wind_and_v_for_an_east_wind() {
        assert!(uv(&wind(1.5, 180.0, GOOD)).starts_with("\x02A,+001.50,+000.00,M,00,\x03"));
        assert!(uv(&wind(1.5, 90.0, GOOD)).starts_with("\x02A,+000.00,+001.50,M,00,\x03"));
        assert!(uv(&wind(2.0, 330.0, GOOD)).starts_with("\x02A,-001.73,-001.00,M,00,\x03"));
        assert!(uv(&wind(2.0, 330.0, QualityFlags::FAILED)).starts_with("\x02A,,,M,04,\x03"));
    }

    #[test]
    fn a_wind_is_a_sentence_with_its_checksum() {
        // The checksum of a published sentence: `$IIMWV,191,R,000.55,M,A*19`.
        assert_eq!(xor("IIMWV,191,R,000.55,M,A"), 0x19);
        let sentence = mwv(&wind(0.55, 191.0, QualityFlags::default()));
        assert_eq!(sentence, format!("$WIMWV,191.0,R,000.55,M,A*{:02X}\r\n", xor("WIMWV,191.0,R,000.55,M,A")));
        assert!(sentence.ends_with("*19\r\n"), "{sentence}");
    }

    #[test]
    fn a_north_wind_is_never_360() {
        assert!(mwv(&wind(12.0, 359.97, QualityFlags::default())).starts_with("$WIMWV,000.0,R,012.00,M,A*"));
    }

    #[test]
    fn what_is_no_wind_is_flagged_and_has_no_numbers() {
        for flags in [QualityFlags::FAILED, QualityFlags::NO_DIRECTION] {
            assert_eq!(mwv(&wind(0.5, 10.0, flags)), format!("$WIMWV,,R,,M,V*{:02X}\r\n", xor("WIMWV,,R,,M,V")));
        }
    }
}
