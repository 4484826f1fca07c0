//! What a head may carry of the slow errors of a recording.

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;

use super::correction::FieldCorrection;
use super::smoother::SlowErrorsAt;

impl FieldCorrection {
    /// Corrections that a head may carry, on top of those that it carries: means over the winds
    /// that said something, with what the errors move by in their uncertainties; none where the
    /// errors do not explain what contradicts.
    pub fn constant(&self, former: Option<&[SurfaceCorrection; SECTORS]>) -> Option<[SurfaceCorrection; SECTORS]> {
        let former = former.copied().unwrap_or_default();
        let count = self.known().count().max(1) as f64;
        let mean = |of: &dyn Fn(&SlowErrorsAt) -> f64| self.known().map(|(_, at)| of(at)).sum::<f64>() / count;
        let number = |error: usize| {
            let value = mean(&|at| at.errors[error]);
            let square = mean(&|at| at.covariance[(error, error)].max(0.0) + (at.errors[error] - value).powi(2));
            [value, square.sqrt()]
        };
        let correction = |i: usize| {
            let [offset_w, offset_u_w] = number(i).map(|mw| (1e-3 * mw) as f32);
            let [gain, gain_u] = number(SECTORS + i).map(|percent| (1e-2 * percent) as f32);
            SurfaceCorrection { offset_w, gain, offset_u_w, gain_u }.on_top_of(&former[i])
        };
        self.explains().then(|| core::array::from_fn(correction))
    }
}
