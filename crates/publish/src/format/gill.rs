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

use super::{rounded_deg, xor};
use crate::feed::FeedWind;

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
    let (sin, cos) = wind.from_deg.to_radians().sin_cos();
    let speed_m_s = wind.horizontal_m_s;
    // There is no −0: added to zero, it is +0.
    let rounded = |number: f64| (number * 100.0).round() / 100.0 + 0.0;
    framed(&format!("A,{:+07.2},{:+07.2},M,00,", rounded(-speed_m_s * cos), rounded(speed_m_s * sin)))
}

fn framed(body: &str) -> String {
    format!("\x02{body}\x03{:02X}\r\n", xor(body))
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
}
