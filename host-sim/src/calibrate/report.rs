//! A calibration and its held-out errors, to be read.

use std::fmt;

use super::calibration::Calibration;
use super::held_out::{HeldOut, Summary};
use crate::estimate::estimate;

impl fmt::Display for Calibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} winds ({} of still gas), Re {:.1} to {:.1}, {} coefficients an amplitude",
            self.winds, self.still, self.least_reynolds, self.most_reynolds, self.coefficients
        )?;
        writeln!(
            f,
            "residuals {:.3} % rms of the convective power; χ² {:.0} for {:.0} degrees of freedom; worst {} {} with {:+.1} σ",
            100.0 * self.residual_rms,
            self.chi_square,
            self.degrees_of_freedom,
            self.worst.label,
            self.worst.part,
            self.worst.errors
        )?;
        let degrees = |v: [f64; 3]| v.map(f64::to_degrees);
        let ([x, y, z], [ex, ey, ez]) = (degrees(self.rotation_rad), degrees(self.rotation_error_rad));
        writeln!(
            f,
            "mounting turned by {:.2}°: ({}, {}, {})°",
            self.rotation_deg(),
            estimate(x, ex),
            estimate(y, ey),
            estimate(z, ez)
        )?;
        writeln!(f, "{:<12} {:>23} {:>23}", "part", "gain", "G0 mW/K")?;
        for part in &self.parts {
            writeln!(
                f,
                "{:<12} {:>23} {:>23}",
                part.name,
                estimate(part.gain, part.gain_error),
                estimate(1e3 * part.still_w_k, 1e3 * part.still_error_w_k)
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for HeldOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "held out by {}, {} folds", self.scheme.name(), self.folds)?;
        writeln!(f, "{:<32} {:>5} {:>18} {:>20}", "", "winds", "direction rms worst", "speed rms worst")?;
        let row = |f: &mut fmt::Formatter<'_>, name: String, s: &Summary| {
            writeln!(
                f,
                "{name:<32} {:>5} {:>9.2}° {:>7.2}° {:>10.2} % {:>6.2} %",
                s.winds,
                s.direction_rms_deg,
                s.direction_worst_deg,
                100.0 * s.speed_rms,
                100.0 * s.speed_worst
            )
        };
        for (range, summary) in self.by_class() {
            row(f, range.to_string(), &summary)?;
        }
        row(f, "all".into(), &self.overall())?;
        if !self.failed.is_empty() {
            writeln!(f, "no answer: {}", self.failed.join(", "))?;
        }
        Ok(())
    }
}
