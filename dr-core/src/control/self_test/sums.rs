//! Running sums of a self-test, so that no reading has to be stored.

use crate::arithmetic::sqrt;

/// Readings of one element at the low level: mean, and noise by second differences, which neither
/// drift nor a steady cooling moves.
///
/// ```text
/// σ² = Σ (x_n − 2 x_{n−1} + x_{n−2})² / (6 (N − 2))
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Quiet {
    /// So that small numbers are summed.
    first: f32,
    last: [f32; 2],
    count: u32,
    sum: f32,
    squares: f32,
}

impl Quiet {
    /// One more.
    pub fn take(&mut self, value: f32) {
        if self.count == 0 {
            self.first = value;
        }
        let [before, last] = self.last;
        if self.count >= 2 {
            let second = value - 2.0 * last + before;
            self.squares += second * second;
        }
        self.last = [last, value];
        self.sum += value - self.first;
        self.count += 1;
    }

    /// Number of them.
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// The mean, if there was any.
    pub fn mean(&self) -> Option<f32> {
        (self.count > 0).then(|| self.first + self.sum / self.count as f32)
    }

    /// Standard deviation of one, if there were three.
    pub fn noise(&self) -> Option<f32> {
        let seconds = self.count.checked_sub(2).filter(|&seconds| seconds > 0)?;
        Some(sqrt(self.squares / (6.0 * seconds as f32)))
    }
}

/// Readings of an element in its pulse: measured temperatures T_c against those of its model m_c.
///
/// ```text
/// ratio = Σ (T − T̄)(m − m̄) / Σ (m − m̄)²,      at the model's start: T̄ − ratio m̄
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Pulse {
    /// The last reading before it, °C.
    before_c: f32,
    /// Readings at the high level, the first and the last, °C.
    first_c: f32,
    last_c: f32,
    first_m: f32,
    last_m: f32,
    count: u32,
    sum_t: f32,
    sum_m: f32,
    sum_mm: f32,
    sum_mt: f32,
}

impl Pulse {
    /// One that begins now.
    pub fn starting(before_c: f32) -> Self {
        Self { before_c, ..Self::default() }
    }

    /// A reading at the high level, and the model's rise at that time.
    pub fn take(&mut self, temperature_c: f32, model_k: f32) {
        if self.count == 0 {
            (self.first_c, self.first_m) = (temperature_c, model_k);
        }
        (self.last_c, self.last_m) = (temperature_c, model_k);
        let (t, m) = (temperature_c - self.first_c, model_k - self.first_m);
        self.count += 1;
        self.sum_t += t;
        self.sum_m += m;
        self.sum_mm += m * m;
        self.sum_mt += m * t;
    }

    /// Rise over the pulse by the readings, K.
    pub fn rise_k(&self) -> f32 {
        self.last_c - self.first_c
    }

    /// The same by the model, K.
    pub fn expected_k(&self) -> f32 {
        self.last_m - self.first_m
    }

    /// Measured over expected, and what the readings have at the model's start beyond the reading
    /// before, K; none where the model expects nothing.
    pub fn against_model(&self) -> Option<(f32, f32)> {
        let count = self.count as f32;
        let spread = self.sum_mm - self.sum_m * self.sum_m / count;
        // Without readings it is none.
        if spread.is_nan() || spread <= 0.0 {
            return None;
        }
        let ratio = (self.sum_mt - self.sum_m * self.sum_t / count) / spread;
        // The model's rise began at 0; `first_m` had come by the first reading.
        let at_start_c = self.first_c + (self.sum_t - ratio * self.sum_m) / count - ratio * self.first_m;
        Some((ratio, at_start_c - self.before_c))
    }
}
