//! Wind estimates beside the true wind, one by one and as means of winds.
//!
//! The direction error is the angle between two vectors; of a head that reports one angle only, the
//! difference of these angles. Of a card, a cylinder or wires only the wind in their plane counts.

use anemometry::head::calibration::checked::plane_normal;
use anemometry::vector::{across, angle_deg, cross, dot, length, unit};
use dr_core::wind::HeadForm;
use recording::Recording;
use recording::wind::PLANE_NORMAL;

use super::columns::number;

/// Slower winds have no direction, and no relative error, m/s.
const SLOWEST_M_S: f64 = 0.3;
/// From this number of winds on they are drawn one by one.
const MANY_WINDS: usize = 40;
/// Share of a wind's time, from its end, over which it is averaged.
const SETTLED: f64 = 0.5;
/// A plane is that of x and y where its normal is z but for rounding.
const IS_Z: f64 = 1.0 - 1e-9;
/// Closer normals to the x axis leave no direction of it in their plane.
const NEARLY_X: f64 = 0.9;

/// An estimate beside its truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindBesideTruth {
    pub time_s: f64,
    /// Estimated, with its standard uncertainty, m/s.
    pub speed_m_s: f64,
    pub speed_u_m_s: f64,
    pub truth_m_s: f64,
    /// Where the true wind goes to, from x towards y, or in the plane of the head, °.
    pub azimuth_deg: f64,
    /// Angle between estimate and truth, and its standard uncertainty, °; NaN without a direction.
    /// Of a wind's mean, uncertainties are the standard deviations of its single estimates.
    pub angle_deg: f64,
    pub angle_u_deg: f64,
    pub wind_m_s: [f64; 3],
    pub true_wind_m_s: [f64; 3],
}

impl WindBesideTruth {
    pub fn error_m_s(&self) -> f64 {
        self.speed_m_s - self.truth_m_s
    }
}

/// Angle that is compared, and what is compared at all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Comparison {
    /// Axis of a head that reports the angle to it only.
    pub axis: Option<[f64; 3]>,
    /// Normal of a head that outputs the wind in a plane only.
    pub normal: Option<[f64; 3]>,
}

impl Comparison {
    /// Comparison that the head of a recording, or the combination that made it, allows.
    pub fn of_recording(recording: &Recording) -> Self {
        if let Some(normal) = recording.metadata(PLANE_NORMAL) {
            let numbers: Vec<f64> = normal.split(' ').filter_map(|of| of.parse().ok()).collect();
            let normal: Option<[f64; 3]> = numbers.try_into().ok();
            return Self { axis: None, normal: normal.filter(|normal| length(*normal) > 0.0).map(unit) };
        }
        let head: Option<toml::Table> = recording.metadata("head").and_then(|text| text.parse().ok());
        let Some(calibration) = head.as_ref().and_then(|head| head.get("calibration")) else { return Self::default() };
        let surfaces = calibration.get("surfaces").and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
        let Some(axis) = surfaces.first().and_then(|first| direction(first, "axis")) else { return Self::default() };
        let corner = direction(&surfaces[0], "corner").unwrap_or_default();
        let form = calibration.get("form").and_then(|form| form.clone().try_into().ok()).unwrap_or_default();
        let normal = plane_normal(form, calibration.get("card").is_some(), axis, corner);
        let is_two_hemispheres = form == HeadForm::Sphere && surfaces.len() == 2;
        Self {
            axis: (is_two_hemispheres && length(axis) > 0.0).then(|| unit(axis)),
            normal: normal.filter(|normal| length(*normal) > 0.0).map(unit),
        }
    }

    /// Part of a wind that the head can output: of a plane the wind in it.
    pub fn visible(self, wind_m_s: [f64; 3]) -> [f64; 3] {
        self.normal.map_or(wind_m_s, |normal| across(wind_m_s, normal))
    }

    /// Components of a wind along the two directions between which azimuths are counted, and the
    /// third: x, y and z, or in a tilted plane the direction of x (or y) in it, the one a quarter
    /// of a turn further, and its normal.
    pub fn in_frame(self, wind_m_s: [f64; 3]) -> [f64; 3] {
        let Some(normal) = self.normal.filter(|_| self.is_tilted()) else { return wind_m_s };
        let begin = if normal[0].abs() < NEARLY_X { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let first = unit(across(begin, normal));
        [first, cross(normal, first), normal].map(|axis| dot(wind_m_s, axis))
    }

    /// Tells whether it is in a plane other than that of x and y.
    pub fn is_tilted(self) -> bool {
        self.normal.is_some_and(|normal| normal[2].abs() < IS_Z)
    }

    /// None of a wind that is too slow, or where nothing was estimated. `has_direction` says
    /// whether the angle counts.
    pub fn of(
        self,
        time_s: f64,
        (wind_m_s, speed_m_s): ([f64; 3], f64),
        true_wind_m_s: [f64; 3],
        has_direction: bool,
        [speed_u_m_s, angle_u_deg]: [f64; 2],
    ) -> Option<WindBesideTruth> {
        let true_wind_m_s = self.visible(true_wind_m_s);
        let truth_m_s = length(true_wind_m_s);
        if !(truth_m_s >= SLOWEST_M_S && speed_m_s.is_finite()) {
            return None;
        }
        let angle_deg = if has_direction { self.angle_deg(wind_m_s, true_wind_m_s) } else { f64::NAN };
        let [x, y, _] = self.in_frame(true_wind_m_s);
        let azimuth_deg = libm::atan2(y, x).to_degrees();
        Some(WindBesideTruth {
            time_s,
            speed_m_s,
            speed_u_m_s,
            truth_m_s,
            azimuth_deg,
            angle_deg,
            angle_u_deg,
            wind_m_s,
            true_wind_m_s,
        })
    }

    fn angle_deg(self, wind_m_s: [f64; 3], true_wind_m_s: [f64; 3]) -> f64 {
        self.axis.map_or_else(
            || angle_deg(wind_m_s, true_wind_m_s),
            |axis| (angle_deg(wind_m_s, axis) - angle_deg(true_wind_m_s, axis)).abs(),
        )
    }
}

/// The axis or the corner of a surface.
fn direction(surface: &toml::Value, key: &str) -> Option<[f64; 3]> {
    let components: Option<Vec<f64>> = surface.get(key)?.as_array()?.iter().map(number).collect();
    components?.try_into().ok()
}

/// The means of winds, if there are many: `stretches` are (from, to) as indices into `all`.
pub fn by_wind(
    all: &[Option<WindBesideTruth>],
    stretches: &[(usize, usize)],
    comparison: Comparison,
) -> Vec<WindBesideTruth> {
    let wind = |&(from, to): &(usize, usize)| {
        let settled = from + ((to - from) as f64 * (1.0 - SETTLED)) as usize;
        let of: Vec<&WindBesideTruth> = all.get(settled..to)?.iter().flatten().collect();
        // Vectors of estimates without a direction say nothing of it.
        let directed: Vec<&WindBesideTruth> = of.iter().copied().filter(|of| of.angle_deg.is_finite()).collect();
        let vector = |of: &[&WindBesideTruth], value: fn(&WindBesideTruth) -> [f64; 3]| {
            std::array::from_fn(|k| mean(of, |of| value(of)[k]))
        };
        let deviation = |of: &[&WindBesideTruth], value: fn(&WindBesideTruth) -> f64| {
            let middle = mean(of, value);
            mean(of, |of| (value(of) - middle).powi(2)).sqrt()
        };
        let uncertainties = [deviation(&of, WindBesideTruth::error_m_s), deviation(&directed, |of| of.angle_deg)];
        let estimate = (vector(&directed, |of| of.wind_m_s), mean(&of, |of| of.speed_m_s));
        let truth = vector(&of, |of| of.true_wind_m_s);
        comparison.of(of.first()?.time_s, estimate, truth, !directed.is_empty(), uncertainties)
    };
    let winds: Vec<WindBesideTruth> = stretches.iter().filter_map(wind).collect();
    if winds.len() < MANY_WINDS { Vec::new() } else { winds }
}

fn mean(of: &[&WindBesideTruth], value: impl Fn(&WindBesideTruth) -> f64) -> f64 {
    of.iter().map(|of| value(of)).sum::<f64>() / of.len() as f64
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn compared(comparison: Comparison, wind_m_s: [f64; 3], truth_m_s: [f64; 3]) -> Option<WindBesideTruth> {
        comparison.of(0.0, (wind_m_s, length(wind_m_s)), truth_m_s, true, [0.1, 1.0])
    }

    #[test]
    fn errors_are_those_of_what_the_head_reports() {
        let whole = compared(Comparison::default(), [0.0, 2.2, 0.0], [2.0, 0.0, 0.0]).unwrap();
        assert!((whole.error_m_s() - 0.2).abs() < 1e-12 && (whole.angle_deg - 90.0).abs() < 1e-9);
        // Both blow across the axis.
        let axis = Comparison { axis: Some([0.0, 0.0, 1.0]), normal: None };
        assert!(compared(axis, [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]).unwrap().angle_deg.abs() < 1e-9);
        // Only the wind in the plane of a card counts.
        let card = Comparison { axis: None, normal: Some([0.0, 0.0, 2.0]) };
        let of_card = compared(card, [2.0, 0.0, 0.0], [2.0, 0.0, 5.0]).unwrap();
        assert!(of_card.error_m_s().abs() < 1e-12 && of_card.angle_deg.abs() < 1e-9);
        assert_eq!(compared(card, [2.0, 0.0, 0.0], [0.0, 0.0, 5.0]), None);
    }

    #[test]
    fn azimuths_in_a_tilted_plane_begin_at_x_or_at_y() {
        let azimuth = |normal: [f64; 3], wind_m_s: [f64; 3]| {
            let [x, y, across] = Comparison { axis: None, normal: Some(normal) }.in_frame(wind_m_s);
            (libm::atan2(y, x).to_degrees(), across)
        };
        // The plane of x and y whichever way its normal points.
        assert_eq!(azimuth([0.0, 0.0, -1.0], [0.0, 2.0, 5.0]), (90.0, 5.0));
        // y is normal: from x on, a quarter of a turn about y leads to −z.
        assert_eq!(azimuth([0.0, 1.0, 0.0], [2.0, 5.0, 0.0]), (0.0, 5.0));
        assert_eq!(azimuth([0.0, 1.0, 0.0], [0.0, 5.0, -2.0]), (90.0, 5.0));
        assert_eq!(azimuth([1.0, 0.0, 0.0], [5.0, 0.0, 2.0]), (90.0, 5.0));
    }

    #[test]
    fn winds_are_averaged_over_their_second_half_where_there_are_many() {
        // The first half of each is wrong by a factor of ten.
        let all: Vec<_> = (0..600)
            .map(|i| {
                let wrong = if i % 10 < 5 { 10.0 } else { 1.0 };
                compared(Comparison::default(), [2.0 * wrong, 0.0, 0.0], [2.0, 0.0, 0.0])
            })
            .collect();
        let stretches: Vec<(usize, usize)> = (0..60).map(|n| (10 * n, 10 * n + 10)).collect();
        let winds = by_wind(&all, &stretches, Comparison::default());
        assert_eq!(winds.len(), 60);
        assert!(winds.iter().all(|wind| wind.error_m_s().abs() < 1e-12 && wind.angle_deg < 1e-5));
        assert!(by_wind(&all, &stretches[..20], Comparison::default()).is_empty());
    }

    #[test]
    fn estimates_without_a_direction_leave_the_direction_to_the_others() {
        let estimate = |i: usize| {
            let has_direction = !i.is_multiple_of(3);
            let wind_m_s = if has_direction { [2.0, 0.0, 0.0] } else { [-2.0, 0.0, 0.0] };
            Comparison::default().of(i as f64, (wind_m_s, 2.0), [2.0, 0.0, 0.0], has_direction, [0.1, 1.0])
        };
        let all: Vec<_> = (0..600).map(estimate).collect();
        let stretches: Vec<(usize, usize)> = (0..60).map(|n| (10 * n, 10 * n + 10)).collect();
        let winds = by_wind(&all, &stretches, Comparison::default());
        assert!(winds.len() == 60 && winds.iter().all(|wind| wind.angle_deg < 1e-9 && wind.angle_u_deg < 1e-9));
        let none: Vec<_> =
            all.into_iter().map(|of| of.map(|of| WindBesideTruth { angle_deg: f64::NAN, ..of })).collect();
        assert!(by_wind(&none, &stretches, Comparison::default()).iter().all(|wind| wind.angle_deg.is_nan()));
    }
}
