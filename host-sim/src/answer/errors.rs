//! Answers beside a wind that is known.
//!
//! | figure | over |
//! |---|---|
//! | speed | root mean square of (|v̂| − |v|)/|v| |
//! | direction | root mean square of the angle between v̂ and v, of answers that have a direction |
//! | linear | the same angle of the linear inverse −Σ G_i n_i, for heads with axes in all directions |

use dr_core::control::Doubts;
use wire::WindSample;

/// Winds slower than this have no direction to speak of, and no relative speed, m/s.
pub const SLOWEST_M_S: f64 = 0.3;

/// What is added up.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    speed: Sum,
    direction_deg: Sum,
    linear_deg: Sum,
    /// Answers beside a true wind that counts.
    pub count: u64,
    /// Of these, how many had no wind, and how many no direction.
    pub failed: u64,
    pub no_direction: u64,
    /// Outward normal of a card: only what lies in its plane is asked for.
    plane: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    count: u64,
    squares: f64,
    sum: f64,
    worst: f64,
}

impl Sum {
    fn add(&mut self, value: f64) {
        self.count += 1;
        self.squares += value * value;
        self.sum += value;
        self.worst = self.worst.max(value.abs());
    }

    fn worst(&self) -> Option<f64> {
        (self.count > 0).then_some(self.worst)
    }

    fn rms(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares / self.count as f64).sqrt())
    }
}

impl Errors {
    /// Of a head that tells the wind in the plane across `normal` only; of any other without one.
    pub fn in_plane(normal: Option<[f64; 3]>) -> Self {
        Self { plane: normal, ..Self::default() }
    }

    /// Takes an answer in; `axes` are those of the parts, outward.
    pub fn add(&mut self, answer: &WindSample, axes: &[[f64; 3]], truth_m_s: [f64; 3]) {
        let truth_m_s = match self.plane {
            Some(normal) => {
                let share = (0..3).map(|k| truth_m_s[k] * normal[k]).sum::<f64>() / length(normal).powi(2);
                std::array::from_fn(|k| truth_m_s[k] - share * normal[k])
            }
            None => truth_m_s,
        };
        let speed_m_s = length(truth_m_s);
        if speed_m_s < SLOWEST_M_S {
            return;
        }
        self.count += 1;
        if answer.doubts.has(Doubts::FAILED) {
            self.failed += 1;
            return;
        }
        self.speed.add(f64::from(answer.speed_m_s) / speed_m_s - 1.0);
        if answer.doubts.has(Doubts::NO_DIRECTION) {
            self.no_direction += 1;
        } else if self.plane.is_some() || !answer.doubts.has(Doubts::UNDETERMINED) {
            self.direction_deg.add(angle_deg(answer.wind_m_s.map(f64::from), truth_m_s));
        }
        if axes.len() > 3 && self.plane.is_none() {
            self.linear_deg.add(angle_deg(linear(answer, axes), truth_m_s));
        }
    }

    /// Relative.
    pub fn speed_rms(&self) -> Option<f64> {
        self.speed.rms()
    }

    pub fn speed_bias(&self) -> Option<f64> {
        (self.speed.count > 0).then(|| self.speed.sum / self.speed.count as f64)
    }

    pub fn speed_worst(&self) -> Option<f64> {
        self.speed.worst()
    }

    pub fn direction_rms_deg(&self) -> Option<f64> {
        self.direction_deg.rms()
    }

    pub fn direction_worst_deg(&self) -> Option<f64> {
        self.direction_deg.worst()
    }

    pub fn linear_rms_deg(&self) -> Option<f64> {
        self.linear_deg.rms()
    }
}

/// Where the gas goes to by the linear inverse: away from the parts that lose most.
fn linear(answer: &WindSample, axes: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (axis, &conductance_w_k) in axes.iter().zip(&answer.conductance_w_k) {
        for (sum, component) in sum.iter_mut().zip(axis) {
            *sum -= f64::from(conductance_w_k) * component;
        }
    }
    sum
}

pub fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Angle between two vectors, °.
pub fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    length(cross).atan2(dot).to_degrees()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn answer(wind_m_s: [f32; 3]) -> WindSample {
        WindSample {
            doubts: Doubts::default(),
            wind_m_s,
            speed_m_s: wind_m_s.iter().map(|v| v * v).sum::<f32>().sqrt(),
            across_m_s: 0.0,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.0,
            direction_error_rad: 0.0,
            chi_square: 0.0,
            gas_c: 0.0,
            conductance_w_k: [1.0, 1.0, 1.0, 2.0].into_iter().collect(),
            raw_w_k: [1.0; 4].into_iter().collect(),
        }
    }

    #[test]
    fn of_a_card_only_what_lies_in_its_plane_is_asked_for() {
        let mut errors = Errors::in_plane(Some([0.0, 0.0, 1.0]));
        let told = WindSample { doubts: Doubts::UNDETERMINED, ..answer([0.0, 2.0, 0.0]) };
        errors.add(&told, &[], [2.0, 0.0, 5.0]);
        assert!(errors.speed_rms().unwrap() < 1e-9);
        assert!((errors.direction_rms_deg().unwrap() - 90.0).abs() < 1e-9);
    }

    #[test]
    fn errors_are_those_of_the_answers_that_count() {
        let axes = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let mut errors = Errors::default();
        assert_eq!((errors.speed_worst(), errors.direction_worst_deg()), (None, None));
        errors.add(&answer([0.0, 2.2, 0.0]), &axes, [0.0, 2.0, 0.0]);
        errors.add(&answer([0.0, 1.8, 0.0]), &axes, [2.0, 0.0, 0.0]);
        errors.add(&answer([9.0, 9.0, 9.0]), &axes, [0.1, 0.0, 0.0]);
        errors.add(&WindSample { doubts: Doubts::FAILED, ..answer([0.0; 3]) }, &axes, [1.0, 0.0, 0.0]);
        let flat = WindSample { doubts: Doubts::NO_DIRECTION, ..answer([0.0, 0.0, 1.0]) };
        errors.add(&flat, &axes, [0.0, 0.0, -1.0]);
        assert_eq!((errors.count, errors.failed, errors.no_direction), (4, 1, 1));
        assert!((errors.speed_rms().unwrap() - (0.02_f64 / 3.0).sqrt()).abs() < 1e-6);
        assert!((errors.direction_rms_deg().unwrap() - (8100.0_f64 / 2.0).sqrt()).abs() < 1e-9);
        // The fourth part loses most: the wind goes away from it.
        assert!((angle_deg(linear(&answer([1.0; 3]), &axes), [1.0, 1.0, -1.0])).abs() < 1e-6);
    }
}
