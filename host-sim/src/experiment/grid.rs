//! Times of an experiment in whole sample periods.

use dr_core::control::Drive;
use dr_core::signal::Prbs;
use recording::toml_file::{FileError, TomlSource};

/// Time of a tick in s, as near as f64 has it: 29 ticks of 0.01 s are 0.29 s and not
/// 0.29000000000000004.
pub fn time_s(tick: u32, sample_period_s: f64) -> f64 {
    time_of(f64::from(tick), sample_period_s)
}

/// Time of a whole number of ticks that may not fit a board's counter, s.
pub(super) fn time_of(ticks: f64, sample_period_s: f64) -> f64 {
    let rate_hz = (1.0 / sample_period_s).round();
    if (rate_hz * sample_period_s - 1.0).abs() < 1e-12 { ticks / rate_hz } else { ticks * sample_period_s }
}

/// Times in ticks, up to the end of the experiment.
pub struct TickGrid<'a> {
    /// The file, which errors name.
    pub source: &'a TomlSource,
    /// Sample period, s.
    pub sample_period_s: f64,
    /// Length of the experiment.
    pub ticks: u32,
}

impl<'a> TickGrid<'a> {
    /// The grid of an experiment.
    ///
    /// # Errors
    /// If `duration_s` is no whole number of sample periods.
    pub fn new(source: &'a TomlSource, sample_period_s: f64, duration_s: f64) -> Result<Self, FileError> {
        let endless = Self { source, sample_period_s, ticks: u32::MAX };
        Ok(Self { ticks: endless.whole_ticks("duration_s", duration_s)?, ..endless })
    }

    /// Time of a tick in s.
    pub fn time_s(&self, tick: u32) -> f64 {
        time_s(tick, self.sample_period_s)
    }

    /// When the experiment is over, s.
    pub fn end_s(&self) -> f64 {
        self.time_s(self.ticks)
    }

    /// Checks a moment.
    ///
    /// # Errors
    /// If it is neither the start nor a whole number of ticks later, or the experiment is over.
    pub fn check_start(&self, key: &str, start_s: f64) -> Result<(), FileError> {
        // Its users refuse what is negative or not a number.
        if start_s > 0.0 {
            self.whole_ticks(key, start_s)?;
        }
        if start_s >= self.end_s() {
            return Err(self.over(key, start_s));
        }
        Ok(())
    }

    /// The error for what would begin when the experiment is over.
    pub fn over(&self, key: &str, start_s: f64) -> FileError {
        self.source.refuse(key, format!("is {start_s} s, but the experiment is over at {} s", self.end_s()))
    }

    /// Number of sample periods in a time that may be 0.
    ///
    /// # Errors
    /// As [`whole_ticks`](Self::whole_ticks).
    pub fn pause_ticks(&self, key: &str, pause_s: f64) -> Result<u32, FileError> {
        if pause_s == 0.0 {
            return Ok(0);
        }
        if !pause_s.is_finite() || pause_s < 0.0 {
            return Err(self.source.refuse(key, format!("is {pause_s} s: it must be finite and 0 s or more")));
        }
        self.whole_ticks(key, pause_s)
    }

    /// A drive by pseudo-random bits, whose table stands under `key`.
    ///
    /// # Errors
    /// Names the key that is wrong.
    pub fn prbs(&self, key: &str, order: u8, bit_time_s: f64, seed: u32) -> Result<Drive, FileError> {
        let ticks_per_bit = self.whole_ticks(&format!("{key}.bit_time_s"), bit_time_s)?;
        // Order and seed are dr-core's to judge; the place is known here.
        self.source.within(&format!("{key}.order"), f64::from(order), 2.0..=32.0, "")?;
        Prbs::new(order, seed).map_err(|error| {
            let sentence = format!("is {seed}: {error}");
            self.source.refuse(&format!("{key}.seed"), sentence.replace("`seed` ", "it "))
        })?;
        Ok(Drive::Prbs { order, seed, ticks_per_bit })
    }

    /// Number of sample periods in a time of at least one.
    ///
    /// # Errors
    /// Names the key and the nearest times that would do.
    pub fn whole_ticks(&self, key: &str, time_s: f64) -> Result<u32, FileError> {
        self.source.positive(key, time_s, "s")?;
        let period_s = self.sample_period_s;
        let ticks = time_s / period_s;
        let whole = ticks.round();
        let sentence = if ticks > f64::from(u32::MAX) {
            let most = f64::from(u32::MAX) * period_s;
            format!("is {time_s} s: at sample periods of {period_s} s it can be {most:.0} s at most")
        } else if whole < 1.0 {
            format!("is {time_s} s: it must last at least one sample period, {period_s} s")
        } else if (ticks - whole).abs() > 1e-6 * whole {
            let [below, above] = [ticks.floor().max(1.0) * period_s, ticks.ceil() * period_s];
            let lower = if below < time_s { format!("{} s or ", tidy(below)) } else { String::new() };
            format!(
                "is {time_s} s, which is not a whole number of sample periods of {period_s} s: {lower}{} s would be",
                tidy(above)
            )
        } else {
            return Ok(whole as u32);
        };
        Err(self.source.refuse(key, sentence))
    }
}

/// Twelve digits of a product, so that 3 × 0.01 is written 0.03.
fn tidy(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}
