//! A calibration of a sphere as text.

use std::fmt;

use super::calibration::SphereCalibration;
use crate::wind::comparison::length;
use recording::text::estimate;

impl fmt::Display for SphereCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} winds ({} of quiescent gas), Re {:.1} to {:.1}, {} coefficients an amplitude",
            self.winds, self.quiescent, self.curves.least_reynolds, self.curves.most_reynolds, self.coefficients
        )?;
        writeln!(
            f,
            "residuals {:.3} % rms of the convective power; χ² {:.0} for {:.0} degrees of freedom; worst {} {} with {:+.1} σ",
            100.0 * self.residual_rms,
            self.chi_square,
            self.degrees_of_freedom,
            self.worst.label,
            self.worst.surface,
            self.worst.errors
        )?;
        let degrees = |v: [f64; 3]| v.map(f64::to_degrees);
        let ([x, y, z], [ex, ey, ez]) = (degrees(self.rotation_rad), degrees(self.rotation_error_rad));
        writeln!(
            f,
            "mounting turned by {:.2}°: ({}, {}, {})°",
            length(self.rotation_rad).to_degrees(),
            estimate(x, ex),
            estimate(y, ey),
            estimate(z, ez)
        )?;
        writeln!(f, "{:<12} {:>23} {:>23}", "surface", "gain", "G0 mW/K")?;
        for surface in &self.surfaces {
            writeln!(
                f,
                "{:<12} {:>23} {:>23}",
                surface.name,
                estimate(surface.gain, surface.gain_error),
                estimate(1e3 * surface.quiescent_w_k, 1e3 * surface.quiescent_error_w_k)
            )?;
        }
        Ok(())
    }
}
