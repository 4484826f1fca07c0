//! How many conversions make one tick, and at which data rate.
//!
//! n = T_s · f_DR must be a whole number, because the tick *is* n data-ready edges; and n ≥ 4, because the ADC's sinc³
//! filter remembers three conversions and only the fourth after a change of level knows nothing of the level before
//! (ADS131E0x data sheet, "Input signal step": settled data on the fourth data-ready).
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | T_s | sample period, one tick | µs |
//! | f_DR | data rate of the ADC | conversions/s |
//! | n | conversions in a tick | 1 |
//!
//! 4 kSPS is taken for ticks under 100 ms: the three conversions that are discarded then cost 0.75 ms. From 100 ms on,
//! 1 kSPS throws away 3 % of the tick at most and asks the processor for a quarter of the transfers. The period is an
//! integer number of microseconds, so that no rounding decides whether it fits.

use core::fmt;

/// Conversions that the filter needs to forget the level before: the order of its sinc.
pub const SETTLING_CONVERSIONS: u32 = 3;

/// Shortest tick that is read at the slow rate, µs.
const SLOW_TICK_US: u32 = 100_000;

/// The data rates in use; both deliver 24 bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DataRate {
    /// 1000 conversions a second.
    Sps1000,
    /// 4000 conversions a second.
    Sps4000,
}

impl DataRate {
    /// Time from one data-ready to the next, µs.
    pub const fn conversion_us(self) -> u32 {
        match self {
            Self::Sps1000 => 1000,
            Self::Sps4000 => 250,
        }
    }
}

/// A sample period that fits the ADC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TickPlan {
    rate: DataRate,
    conversions: u32,
}

impl TickPlan {
    /// Plans ticks of `sample_period_us` µs.
    ///
    /// # Errors
    /// A period that is shorter than four conversions at 4 kSPS, or no multiple of one conversion.
    pub const fn new(sample_period_us: u32) -> Result<Self, PeriodRefused> {
        let slow =
            sample_period_us >= SLOW_TICK_US && sample_period_us.is_multiple_of(DataRate::Sps1000.conversion_us());
        let rate = if slow { DataRate::Sps1000 } else { DataRate::Sps4000 };
        let conversions = sample_period_us / rate.conversion_us();
        if conversions <= SETTLING_CONVERSIONS || !sample_period_us.is_multiple_of(rate.conversion_us()) {
            return Err(PeriodRefused { sample_period_us });
        }
        Ok(Self { rate, conversions })
    }

    /// The data rate to give the ADC.
    pub const fn rate(self) -> DataRate {
        self.rate
    }

    /// Conversions in one tick, settling ones included.
    pub const fn conversions(self) -> u32 {
        self.conversions
    }

    /// Time after the tick's last data-ready by which the new level must have settled, µs.
    ///
    /// Each conversion looks back over three conversion periods, so the first that counts, the fourth, begins to look one
    /// period after the edge that ended the tick before.
    pub const fn deadline_us(self) -> u32 {
        self.rate.conversion_us()
    }
}

/// A sample period that the ADC cannot keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PeriodRefused {
    /// The period that was asked for, µs.
    pub sample_period_us: u32,
}

impl fmt::Display for PeriodRefused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit_us = DataRate::Sps4000.conversion_us();
        write!(
            f,
            "sample period of {} µs does not fit the ADC: choose a multiple of {} µs (one conversion at 4 kSPS), at least {} µs",
            self.sample_period_us,
            unit_us,
            (SETTLING_CONVERSIONS + 1) * unit_us
        )
    }
}

impl core::error::Error for PeriodRefused {}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned(sample_period_us: u32) -> (DataRate, u32) {
        let plan = TickPlan::new(sample_period_us).unwrap();
        (plan.rate(), plan.conversions())
    }

    #[test]
    fn a_period_becomes_its_number_of_conversions() {
        // n = T_s · f_DR
        assert_eq!(planned(1_000), (DataRate::Sps4000, 4));
        assert_eq!(planned(10_000), (DataRate::Sps4000, 40));
        assert_eq!(planned(99_750), (DataRate::Sps4000, 399));
        assert_eq!(planned(100_000), (DataRate::Sps1000, 100));
        assert_eq!(planned(1_000_000), (DataRate::Sps1000, 1000));
    }

    #[test]
    fn a_slow_tick_that_is_no_whole_millisecond_keeps_the_fast_rate() {
        assert_eq!(planned(100_250), (DataRate::Sps4000, 401));
    }

    #[test]
    fn refuses_a_tick_in_which_nothing_settles() {
        for sample_period_us in [0, 250, 750] {
            assert_eq!(TickPlan::new(sample_period_us), Err(PeriodRefused { sample_period_us }));
        }
    }

    #[test]
    fn refuses_a_period_that_is_no_whole_number_of_conversions() {
        for sample_period_us in [1_001, 1_100, 9_999, 100_100, u32::MAX] {
            assert_eq!(TickPlan::new(sample_period_us), Err(PeriodRefused { sample_period_us }));
        }
    }

    #[test]
    fn the_refusal_says_what_would_be_right() {
        assert_eq!(
            TickPlan::new(1_100).unwrap_err().to_string(),
            "sample period of 1100 µs does not fit the ADC: choose a multiple of 250 µs (one conversion at 4 kSPS), at least 1000 µs"
        );
    }

    #[test]
    fn the_new_level_must_stand_within_one_conversion() {
        assert_eq!(TickPlan::new(10_000).unwrap().deadline_us(), 250);
        assert_eq!(TickPlan::new(200_000).unwrap().deadline_us(), 1000);
    }
}
