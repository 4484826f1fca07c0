//! How fast the clock of a board runs by that of its host: a straight line by least squares through
//! the moments at which rows arrived.
//!
//! ```text
//! utc_n − time_n = o + d · time_n + e_n      d̂ = S_ty / S_tt      u(d̂) = s / √S_tt
//! ```
//!
//! `d` is the drift, positive where the board is slow; `s` is the scatter of the arrivals about the
//! line, which rows wait for the cable and the system. The uncertainty takes these waits for
//! independent; a step of the host's clock shows as scatter.

use crate::column::Metadata;

/// Sums about running means, as Welford has them, so that a long recording loses no digits.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ClockFit {
    /// The first row: time and UTC, s.
    first: Option<(f64, f64)>,
    count: f64,
    mean_t: f64,
    mean_y: f64,
    s_tt: f64,
    s_ty: f64,
    s_yy: f64,
}

impl ClockFit {
    /// Adds a row that arrived at this moment, s since 1970.
    pub fn add(&mut self, time_s: f64, utc_s: f64) {
        let (time_0_s, utc_0_s) = *self.first.get_or_insert((time_s, utc_s));
        let t = time_s - time_0_s;
        let y = (utc_s - utc_0_s) - t;
        self.count += 1.0;
        let (dt, dy) = (t - self.mean_t, y - self.mean_y);
        self.mean_t += dt / self.count;
        self.mean_y += dy / self.count;
        self.s_tt += dt * (t - self.mean_t);
        self.s_ty += dt * (y - self.mean_y);
        self.s_yy += dy * (y - self.mean_y);
    }

    /// The estimate, for the end of a file; nothing of fewer than three rows.
    pub fn metadata(&self) -> Metadata {
        if self.count < 3.0 || self.s_tt <= 0.0 {
            return Metadata::new();
        }
        let drift = self.s_ty / self.s_tt;
        let scatter_s = ((self.s_yy - drift * self.s_ty).max(0.0) / (self.count - 2.0)).sqrt();
        let ppm = |number: f64| format!("{:.3}", number * 1e6);
        [
            ("clock_drift_ppm", ppm(drift)),
            ("clock_drift_u_ppm", ppm(scatter_s / self.s_tt.sqrt())),
            ("clock_scatter_s", format!("{scatter_s:.6}")),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_board_is_found_within_the_uncertainty_that_is_stated() {
        let mut fit = ClockFit::default();
        // 80 ppm slow; rows wait 0 to 10 ms by turns of 11.
        for n in 0..60_000_u32 {
            let wait_s = f64::from(n * 7 % 11) * 1e-3;
            let time_s = 5e6 + f64::from(n) * 0.01;
            fit.add(time_s, 1.793e9 + f64::from(n) * 0.01 * (1.0 + 80e-6) + wait_s);
        }
        let metadata = fit.metadata();
        let [drift, u, scatter_s] = [0, 1, 2].map(|at: usize| metadata[at].1.parse::<f64>().unwrap());
        assert!((drift - 80.0).abs() < 2.0 * u.max(0.01), "{drift} {u}");
        // 3.16 ms, the deviation of eleven equal steps, over 173 s · √60 000.
        assert!((scatter_s - 3.162e-3).abs() < 1e-5 && (u - 0.0745).abs() < 1e-3, "{scatter_s} {u}");
        let mut short = ClockFit::default();
        short.add(0.0, 1.0);
        assert!(short.metadata().is_empty());
    }
}
