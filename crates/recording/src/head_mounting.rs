//! Mounting of a head: from the vector in its own frame to east, north and up, and to the direction
//! from which the wind blows.
//!
//! With u the unit vector that points up, in the head's frame, and x its x axis:
//!
//! a = (x − (x·u) u) / |x − (x·u) u|, horizontal, towards the compass direction h (`heading_deg`),
//! b = u × a, horizontal, a quarter turn to the left, towards h − 90°,
//! east = v·a sin h − v·b cos h, north = v·a cos h + v·b sin h, up = v·u,
//! from = atan2(−east, −north), clockwise from north in 0 … 360° (WMO-No. 8, part I, 5.1.1).
//!
//! Each component of u is the sine of the angle of that axis above the horizontal, as a level laid
//! along it shows. The x axis may not be nearer to the vertical than 5°, where its compass
//! direction means nothing.

use dr_core::wind::QualityFlags;
use wire::WindSample;

use crate::column::Metadata;

/// Key of a head file and of a recording's metadata: compass direction of the head's x axis, °.
pub const HEADING: &str = "heading_deg";
/// Key of a head file and of a recording's metadata: direction that points up, in the head's frame.
pub const UP: &str = "up";

/// Least angle between the x axis and the vertical, °.
const LEAST_DEG: f64 = 5.0;

/// A head's frame on the earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadMounting {
    /// Compass direction of the x axis, degrees clockwise from north.
    heading_deg: f64,
    up: [f64; 3],
    ahead: [f64; 3],
    left: [f64; 3],
}

/// A mounting that cannot be: the key, and what is wrong with it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{key}` {sentence}")]
pub struct MountingError {
    /// `heading_deg` or `up`.
    pub key: &'static str,
    /// Sentence: what is wrong with its value.
    pub sentence: String,
}

/// The x axis points north, the z axis up.
impl Default for HeadMounting {
    fn default() -> Self {
        Self { heading_deg: 0.0, up: [0.0, 0.0, 1.0], ahead: [1.0, 0.0, 0.0], left: [0.0, 1.0, 0.0] }
    }
}

impl HeadMounting {
    /// Mounting by a compass direction of the x axis, and of what points up (by default the z
    /// axis).
    ///
    /// # Errors
    /// If the direction is not within 0 and 360°, or `up` is no direction, or too near to the x
    /// axis.
    pub fn new(heading_deg: f64, up: Option<[f64; 3]>) -> Result<Self, MountingError> {
        let refuse = |key, sentence| Err(MountingError { key, sentence });
        if !(0.0..=360.0).contains(&heading_deg) {
            return refuse(HEADING, format!("is {heading_deg} °: it must lie between 0 and 360 °"));
        }
        let Some(up) = up else { return Ok(Self { heading_deg, ..Self::default() }) };
        let length = dot(up, up).sqrt();
        if !(length.is_finite() && length > 0.0) {
            return refuse(UP, format!("is {up:?}: three numbers of a direction are wanted, such as [0, 0, 1]"));
        }
        let up = up.map(|of| of / length);
        let level = [1.0 - up[0] * up[0], -up[0] * up[1], -up[0] * up[2]];
        let length = dot(level, level).sqrt();
        if length < libm::sin(LEAST_DEG.to_radians()) {
            return refuse(
                UP,
                format!(
                    "is {up:?}: the x axis is less than {LEAST_DEG}° from the vertical and has no compass direction; give the head's frame another x axis"
                ),
            );
        }
        let ahead = level.map(|of| of / length);
        let left = [
            up[1] * ahead[2] - up[2] * ahead[1],
            up[2] * ahead[0] - up[0] * ahead[2],
            up[0] * ahead[1] - up[1] * ahead[0],
        ];
        Ok(Self { heading_deg, up, ahead, left })
    }

    /// The mounting in a recording's metadata, `heading_deg` and `up`, or what is given in place of
    /// them; none without a heading.
    ///
    /// # Errors
    /// As [`Self::new`], and where they are no numbers.
    pub fn from_metadata(
        metadata: &[(String, String)],
        heading_deg: Option<f64>,
        up: Option<[f64; 3]>,
    ) -> Result<Option<Self>, MountingError> {
        let text = |key: &str| metadata.iter().find(|(own, _)| own == key).map(|(_, text)| text.as_str());
        let number = |text: &str| {
            text.parse().map_err(|_| MountingError { key: HEADING, sentence: format!("is `{text}`: no number") })
        };
        let heading_deg = heading_deg.map_or_else(|| text(HEADING).map(number).transpose(), |own| Ok(Some(own)))?;
        let up = up.map_or_else(|| text(UP).map(direction).transpose(), |own| Ok(Some(own)))?;
        heading_deg.map(|heading_deg| Self::new(heading_deg, up)).transpose()
    }

    /// For a recording's metadata: nothing of `up` where the z axis points there.
    pub fn metadata(&self) -> Metadata {
        let mut pairs = vec![(HEADING.to_owned(), self.heading_deg.to_string())];
        if self.up != Self::default().up {
            let [x, y, z] = self.up;
            pairs.push((UP.to_owned(), format!("{x} {y} {z}")));
        }
        pairs
    }

    /// A vector of the head's frame as east, north, up.
    pub fn earth(&self, vector: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.heading_deg.to_radians());
        let (ahead, left) = (dot(vector, self.ahead), dot(vector, self.left));
        [ahead * sin - left * cos, ahead * cos + left * sin, dot(vector, self.up)]
    }

    /// North, in the head's frame.
    pub fn north(&self) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.heading_deg.to_radians());
        std::array::from_fn(|axis| cos * self.ahead[axis] + sin * self.left[axis])
    }

    /// Direction from which a wind with this vector in the head's frame blows, °.
    pub fn from_deg(&self, wind_m_s: [f64; 3]) -> f64 {
        from_deg(self.earth(wind_m_s))
    }
}

/// Direction from which a wind towards (east, north, up) blows, degrees clockwise from north, at
/// least 0 and below 360.
pub fn from_deg([east, north, _]: [f64; 3]) -> f64 {
    let from = libm::atan2(-east, -north).to_degrees().rem_euclid(360.0);
    // The remainder of a tiny negative number rounds to the divisor.
    if from >= 360.0 { 0.0 } else { from }
}

/// The numbers of [`EARTH`](crate::wind::EARTH).
pub fn earth_numbers(estimate: &WindSample, mounting: &HeadMounting) -> [f32; 2] {
    if estimate.quality_flags.has(QualityFlags::FAILED) {
        return [f32::NAN; 2];
    }
    let earth = mounting.earth(estimate.wind_m_s.map(f64::from));
    let has_direction = !estimate.quality_flags.has(QualityFlags::NO_DIRECTION);
    [if has_direction { from_deg(earth) } else { f64::NAN }, earth[2]].map(|number| number as f32)
}

/// Three numbers with commas or blanks between them.
///
/// # Errors
/// If they are no three numbers.
pub fn direction(text: &str) -> Result<[f64; 3], MountingError> {
    let numbers = text.split([',', ' ']).filter(|word| !word.is_empty()).map(str::parse);
    let numbers: Option<Vec<f64>> = numbers.collect::<Result<_, _>>().ok();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| MountingError { key: UP, sentence: format!("is `{text}`: three numbers are wanted, as 0,0,1") })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) {
        assert!((0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-12), "{a:?} is not {b:?}");
    }

    #[test]
    fn a_wind_comes_from_where_the_compass_says() {
        let from = |wind, heading_deg| HeadMounting::new(heading_deg, None).unwrap().from_deg(wind);
        // Towards the head's x, which points north: a south wind.
        assert_eq!(from([1.0, 0.0, 5.0], 0.0), 180.0);
        // Towards y, a quarter turn to the left of north, which is west: an east wind.
        assert!((from([0.0, 1.0, 0.0], 0.0) - 90.0).abs() < 1e-12);
        // The head is turned so that x points east: towards x is a west wind.
        assert!((from([1.0, 0.0, 0.0], 90.0) - 270.0).abs() < 1e-12);
        assert_eq!(from([-1.0, -1e-18, 0.0], 0.0), 0.0, "never 360");
    }

    #[test]
    fn a_tilted_head_reports_the_wind_of_the_earth() {
        // x rises by 30° above the compass direction 90°: what goes along it goes east, and up.
        let tilted = HeadMounting::new(90.0, Some([0.5, 0.0, 0.75_f64.sqrt()])).unwrap();
        near(tilted.earth([2.0, 0.0, 0.0]), [3.0_f64.sqrt(), 0.0, 1.0]);
        near(tilted.earth([0.0, 2.0, 0.0]), [0.0, 2.0, 0.0]);
        // A pure horizontal wind keeps its length.
        let east = tilted.earth([0.75_f64.sqrt(), 0.0, -0.5]);
        near(east, [1.0, 0.0, 0.0]);
        assert!((from_deg(east) - 270.0).abs() < 1e-12);
    }

    #[test]
    fn a_head_that_hangs_from_above_has_its_y_axis_to_the_right() {
        let hanging = HeadMounting::new(0.0, Some([0.0, 0.0, -2.0])).unwrap();
        near(hanging.earth([0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
        near(hanging.earth([1.0, 0.0, 1.0]), [0.0, 1.0, -1.0]);
        let east = HeadMounting::new(90.0, Some([0.3, 0.1, -2.0])).unwrap();
        near(east.earth(east.north()), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn metadata_give_the_same_mounting_again() {
        let tilted = HeadMounting::new(123.5, Some([0.1, -0.2, 0.9])).unwrap();
        let again = HeadMounting::from_metadata(&tilted.metadata(), None, None).unwrap().unwrap();
        near(again.earth([1.0, 2.0, 3.0]), tilted.earth([1.0, 2.0, 3.0]));
        assert_eq!(HeadMounting::default().metadata().len(), 1);
        assert_eq!(HeadMounting::from_metadata(&[], None, None), Ok(None));
        let turned = HeadMounting::from_metadata(&tilted.metadata(), Some(0.0), None).unwrap().unwrap();
        near(
            turned.earth([1.0, 2.0, 3.0]),
            HeadMounting::new(0.0, Some([0.1, -0.2, 0.9])).unwrap().earth([1.0, 2.0, 3.0]),
        );
    }

    #[test]
    fn a_mounting_that_cannot_be_is_refused_with_its_key() {
        let sentence = |heading_deg, up| HeadMounting::new(heading_deg, Some(up)).unwrap_err().to_string();
        assert_eq!(sentence(400.0, [0.0, 0.0, 1.0]), "`heading_deg` is 400 °: it must lie between 0 and 360 °");
        assert!(sentence(f64::NAN, [0.0, 0.0, 1.0]).starts_with("`heading_deg` is NaN"));
        assert!(sentence(0.0, [0.0; 3]).starts_with("`up` is [0.0, 0.0, 0.0]: three numbers of a direction"));
        assert!(sentence(0.0, [1.0, 0.05, 0.0]).contains("less than 5° from the vertical"));
        assert!(direction("0, 0").unwrap_err().to_string().ends_with("three numbers are wanted, as 0,0,1"));
    }

    #[test]
    fn an_estimate_without_a_direction_keeps_its_vertical_wind() {
        let earth = |quality_flags| {
            let estimate = WindSample {
                quality_flags,
                wind_m_s: [1.0, 2.0, 3.0],
                speed_m_s: 4.0,
                across_m_s: 0.0,
                covariance_m2_s2: [0.0; 6],
                speed_error_m_s: 0.1,
                direction_error_rad: 0.1,
                chi_square: 1.0,
                gas_c: 20.0,
                conductance_w_k: [0.001].into_iter().collect(),
                raw_w_k: [0.001].into_iter().collect(),
            };
            earth_numbers(&estimate, &HeadMounting::default())
        };
        let [from_deg, up_m_s] = earth(QualityFlags::DEGRADED);
        // Towards x and twice y: towards north-west, from 180° less atan 2.
        assert!((from_deg - (180.0 - 63.434_95)).abs() < 1e-4 && up_m_s == 3.0, "{from_deg} {up_m_s}");
        let [from_deg, up_m_s] = earth(QualityFlags::NO_DIRECTION);
        assert!(from_deg.is_nan() && up_m_s == 3.0);
        assert!(earth(QualityFlags::FAILED).iter().all(|number| number.is_nan()));
    }
}
