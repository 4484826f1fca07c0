//! Times of an experiment in whole sample periods.

use recording::toml_file::{FileError, TomlSource};

/// Times in ticks.
pub(super) struct TickGrid<'a> {
    pub source: &'a TomlSource,
    pub sample_period_s: f64,
}

impl TickGrid<'_> {
    /// Time of a tick in s.
    pub fn time_s(&self, tick: u32) -> f64 {
        let rate_hz = (1.0 / self.sample_period_s).round();
        if (rate_hz * self.sample_period_s - 1.0).abs() < 1e-12 {
            f64::from(tick) / rate_hz
        } else {
            f64::from(tick) * self.sample_period_s
        }
    }

    /// A moment at which something begins: at the start, or a whole number of ticks later.
    pub fn instant(&self, key: &str, time_s: f64) -> Result<(), FileError> {
        // Whether it may be negative or not a number is for those to say who use it.
        if time_s > 0.0 { self.whole_ticks(key, time_s).map(drop) } else { Ok(()) }
    }

    pub fn whole_ticks(&self, key: &str, time_s: f64) -> Result<u32, FileError> {
        self.source.positive(key, time_s, "s")?;
        let period_s = self.sample_period_s;
        let ticks = time_s / period_s;
        if ticks > f64::from(u32::MAX) {
            let most = f64::from(u32::MAX) * period_s;
            return Err(self.source.refuse(
                key,
                format!("is {time_s} s: at sample periods of {period_s} s it can be {most:.0} s at most"),
            ));
        }
        let whole = ticks.round();
        if whole < 1.0 {
            return Err(self
                .source
                .refuse(key, format!("is {time_s} s: it must last at least one sample period, {period_s} s")));
        }
        if (ticks - whole).abs() > 1e-6 * whole.max(1.0) {
            let (below, above) = (ticks.floor().max(1.0) * period_s, ticks.ceil() * period_s);
            let right = if below < time_s {
                format!("{} s or {} s", tidy(below), tidy(above))
            } else {
                format!("{} s", tidy(above))
            };
            let sentence = format!(
                "is {time_s} s, which is not a whole number of sample periods of {period_s} s: {right} would be"
            );
            return Err(self.source.refuse(key, sentence));
        }
        Ok(whole as u32)
    }
}

/// Twelve digits of a product, so that 3 × 0.01 is written 0.03.
fn tidy(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}
