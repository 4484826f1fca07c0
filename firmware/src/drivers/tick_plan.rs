//! How many conversions make one tick, and at which data rate.
//!
//! n = T_s · f_DR must be a whole number, because the tick *is* n data-ready edges; and n ≥ 4,
//! because the ADC's sinc³ filter remembers three conversions and only the fourth after a change of
//! level knows nothing of the level before (ADS131E0x data sheet, "Input signal step": settled data
//! on the fourth data-ready).
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | T_s | sample period, one tick | µs |
//! | f_DR | data rate of the ADC | conversions/s |
//! | n | conversions in a tick | 1 |
//!
//! Each conversion looks back over three periods: the new level must have settled one conversion
//! after the edge that ended the tick before.
//!
//! 4 kSPS is taken for ticks under 100 ms: the three conversions that are discarded then cost 0.75
//! ms. From 100 ms on, 1 kSPS throws away 3 % of the tick at most and asks the processor for a
//! quarter of the transfers. The period is an integer number of microseconds, so that no rounding
//! decides whether it fits.

use dr_core::{ConfigError, Parameter, ParameterProblem};

/// Conversions that the filter needs to forget the level before: the order of its sinc.
pub const SETTLING_CONVERSIONS: u32 = 3;

/// Shortest tick that is read at the slow rate, µs.
const SLOW_TICK_US: u32 = 100_000;

/// Every tick is a multiple of one conversion at the fast rate, µs.
const UNIT_US: u32 = DataRate::Sps4000.conversion_us();
/// Shortest tick, µs: one settled conversion.
const SHORTEST_TICK_US: u32 = (SETTLING_CONVERSIONS + 1) * UNIT_US;
/// Longest tick, µs: the controller takes none above 10 s.
const LONGEST_TICK_US: u32 = 10_000_000;

/// Relative distance of neighbouring f32, 2⁻²³: what is nearer than this to a whole number of
/// microseconds was meant so.
const F32_RESOLUTION: f64 = 1.0 / 8_388_608.0;

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
    /// A period under four conversions at 4 kSPS or above 10 s, or no multiple of one conversion.
    pub const fn new(sample_period_us: u32) -> Result<Self, ConfigError> {
        if sample_period_us < SHORTEST_TICK_US || sample_period_us > LONGEST_TICK_US {
            return Err(refused(OUT_OF_RANGE));
        }
        if !sample_period_us.is_multiple_of(UNIT_US) {
            return Err(refused(NOT_A_MULTIPLE));
        }
        let slow =
            sample_period_us >= SLOW_TICK_US && sample_period_us.is_multiple_of(DataRate::Sps1000.conversion_us());
        let rate = if slow { DataRate::Sps1000 } else { DataRate::Sps4000 };
        Ok(Self { rate, conversions: sample_period_us / rate.conversion_us() })
    }

    /// Length of a tick, µs.
    pub const fn tick_us(self) -> u32 {
        self.conversions * self.rate.conversion_us()
    }

    /// Plans ticks of `sample_period_s` s, as commands carry it.
    ///
    /// # Errors
    /// As [`new`](Self::new); what is no whole number of microseconds within what an f32 can tell
    /// is no multiple either.
    pub fn from_seconds(sample_period_s: f32) -> Result<Self, ConfigError> {
        if !sample_period_s.is_finite() {
            return Err(refused(ParameterProblem::NotFinite));
        }
        let exact_us = f64::from(sample_period_s) * 1e6;
        // The cast saturates: what is out of range stays so.
        let sample_period_us = (exact_us + 0.5) as u32;
        let plan = Self::new(sample_period_us)?;
        let difference_us = (exact_us - f64::from(sample_period_us)).abs();
        if difference_us > exact_us * F32_RESOLUTION {
            return Err(refused(NOT_A_MULTIPLE));
        }
        Ok(plan)
    }

    /// The data rate to give the ADC.
    pub const fn rate(self) -> DataRate {
        self.rate
    }

    /// Conversions in one tick, settling ones included.
    pub const fn conversions(self) -> u32 {
        self.conversions
    }
}

const OUT_OF_RANGE: ParameterProblem =
    ParameterProblem::OutOfRange { least: SHORTEST_TICK_US as f32 * 1e-6, most: LONGEST_TICK_US as f32 * 1e-6 };
const NOT_A_MULTIPLE: ParameterProblem = ParameterProblem::NotAMultiple { of: UNIT_US as f32 * 1e-6 };

const fn refused(problem: ParameterProblem) -> ConfigError {
    ConfigError { parameter: Parameter::SamplePeriodS, problem }
}

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
    fn refuses_a_tick_in_which_nothing_settles_or_that_the_controller_would_not_take() {
        for sample_period_us in [0, 250, 750, 999, 10_000_250, u32::MAX] {
            assert_eq!(TickPlan::new(sample_period_us), Err(refused(OUT_OF_RANGE)), "{sample_period_us}");
        }
    }

    #[test]
    fn refuses_a_period_that_is_no_whole_number_of_conversions() {
        for sample_period_us in [1_001, 1_100, 9_999, 100_100] {
            assert_eq!(TickPlan::new(sample_period_us), Err(refused(NOT_A_MULTIPLE)), "{sample_period_us}");
        }
    }

    #[test]
    fn the_refusal_says_what_would_be_right() {
        let says = |sample_period_us| TickPlan::new(sample_period_us).unwrap_err().to_string();
        assert_eq!(says(1_100), "`sample_period_s` must be a whole multiple of 0.00025");
        assert_eq!(says(750), "`sample_period_s` must lie between 0.001 and 10");
    }

    #[test]
    fn takes_the_seconds_that_commands_carry() {
        for (sample_period_s, sample_period_us) in
            [(0.001, 1_000), (0.01, 10_000), (0.0125, 12_500), (0.1, 100_000), (10.0, 10_000_000)]
        {
            assert_eq!(TickPlan::from_seconds(sample_period_s), TickPlan::new(sample_period_us));
            assert!(TickPlan::new(sample_period_us).is_ok());
        }
    }

    #[test]
    fn refuses_seconds_that_are_no_plan() {
        for (sample_period_s, problem) in [
            (0.001_000_4, NOT_A_MULTIPLE),
            (0.0, OUT_OF_RANGE),
            (-0.01, OUT_OF_RANGE),
            (1e6, OUT_OF_RANGE),
            (f32::NAN, ParameterProblem::NotFinite),
            (f32::INFINITY, ParameterProblem::NotFinite),
        ] {
            assert_eq!(TickPlan::from_seconds(sample_period_s), Err(refused(problem)), "{sample_period_s}");
        }
    }
}
