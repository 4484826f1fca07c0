//! NMEA 0183, sentence MWV: wind speed and angle.
//!
//! `$WIMWV,191.0,R,000.55,M,A*19`: talker WI (weather instrument), angle in degrees from which it
//! blows, R as it is measured (relative to the mark that the instrument's mounting points north),
//! speed, M for m/s, A for valid, and after the star the exclusive or of all between `$` and `*`.

use super::{rounded_deg, xor};
use crate::feed::FeedWind;

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
mod tests {
    use super::*;
    use crate::format::examples::wind;
    use dr_core::wind::QualityFlags;

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
