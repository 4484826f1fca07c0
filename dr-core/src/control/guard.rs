//! The guard: the conditions that a reading must meet for its heater to be on.
//!
//! | cause | when | after |
//! |---|---|---|
//! | `Open` | code at the ADC's upper end, or resistance above its limit | 1 tick |
//! | `Short` | resistance below its limit | 1 tick |
//! | `OutOfRange` | code at the ADC's lower end; of a capacitor at either, or a voltage shift beyond its limit | 1 tick |
//! | `OverTemperature` | temperature above its limit | 1 tick |
//! | `NonFinite` | a number inside is not one | 1 tick |
//! | `Missing`, `Stale` | no reading, or none newer than the last tick's | `missing_limit_ticks`; low level meanwhile, of a capacitor the same symbol |
//! | `Unreachable` | a regulating drive has requested the high level (of a capacitor one symbol) all the time, or a power lies outside the levels | `unreachable_limit_ticks` |
//! | `Unreachable` | an element at the high level, in any drive, has not become warmer | the board's [`no_rise_s`](super::HardwareLimits::no_rise_s) |
//! | `Stuck` | a driven element's code has not changed at all: the converter repeats itself | `stuck_limit_ticks` |
//! | `PullIn` | a capacitance above its limit: the membrane lies on the dielectric | 1 tick |
//! | `Energy` | an element's energy exceeds its budget ([`energy`](super::energy)) | 1 tick |
//! | `BitFlip` | a checksum fails (`checksum.rs`) | 1 tick; a drive's or a model's, within as many ticks as there are elements |
//!
//! The board reports the other causes: `Deadline`, levels that were not updated in time; `Heater`,
//! a pin that could not be set, or has another level; `HostTimeout`, no frame of a host for too
//! long while heating; after an unrequested start `Panic`, `Fault`, `Watchdog`, `BrownOut`, and
//! `Restart` after a reset that neither the firmware nor its watchdog made, as a debug probe's; by
//! its proof tests `Memory`, `Clock`, and `ProofTest` for the dead-man timer or the watchdog; and
//! `AdcRegister`, a register of the ADC that has changed.
//!
//! A trip is latched by the controller until it is acknowledged.

use super::energy::EnergyLimit;
use crate::error::{self, ConfigError, Parameter};
use crate::sensor::{Channel, Level, Platinum, Reading};
use core::fmt;

/// Why the heaters went off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::FromRepr, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(missing_docs)] // the table above is the documentation
pub enum Cause {
    Open,
    Short,
    OutOfRange,
    OverTemperature,
    NonFinite,
    Missing,
    Stale,
    Unreachable,
    Stuck,
    BitFlip,
    #[strum(to_string = "deadline-missed")]
    Deadline,
    #[strum(to_string = "heater-pin")]
    Heater,
    Panic,
    #[strum(to_string = "processor-fault")]
    Fault,
    Watchdog,
    BrownOut,
    Memory,
    Clock,
    #[strum(to_string = "proof-test")]
    ProofTest,
    HostTimeout,
    OtherHead,
    AdcRegister,
    #[strum(to_string = "energy-budget")]
    Energy,
    PullIn,
    Restart,
}

impl Cause {
    /// The name in recordings and logs.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A trip: its cause and the element that showed it, if it is one element's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Trip {
    /// Why.
    pub cause: Cause,
    /// Element, from 0; none if it is the whole instrument's.
    pub element: Option<u8>,
}

impl Trip {
    /// A trip of one element.
    pub const fn of(element: usize, cause: Cause) -> Self {
        Self { cause, element: Some(element as u8) }
    }

    /// A trip of the whole instrument.
    pub const fn whole(cause: Cause) -> Self {
        Self { cause, element: None }
    }
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.cause.name())?;
        self.element.map_or(Ok(()), |element| write!(f, ", element {element}"))
    }
}

/// Plausible range of one element.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Below it the resistor counts as shorted, Ω.
    pub resistance_min_ohm: f32,
    /// Above it the resistor counts as open, Ω.
    pub resistance_max_ohm: f32,
    /// Above it the element is too hot, °C.
    pub temperature_max_c: f32,
    /// Codes from here up (or from its negative down) are the ends of the ADC's range, not
    /// readings.
    pub code_max: i32,
    /// Power and energy that it bears; without it, what the board grants.
    pub energy: Option<EnergyLimit>,
}

impl Limits {
    /// Limits of an element of sphere B, 175 Ω at 0 °C, on a converter of 24 bit. For tests.
    pub const SPHERE_B: Self = Self {
        resistance_min_ohm: 50.0,
        resistance_max_ohm: 260.0,
        temperature_max_c: 70.0,
        code_max: 8_388_000,
        energy: None,
    };

    /// The limits, if they make sense for this resistor: above the end of its law, an inverse may
    /// give any temperature.
    ///
    /// # Errors
    /// Names the limit that is not finite, not positive, not above its counterpart, or beyond the
    /// resistor's law.
    pub fn checked(self, platinum: &Platinum) -> Result<Self, ConfigError> {
        let (coldest_c, hottest_c) = platinum.range_c();
        error::positive(Parameter::ResistanceMinOhm, self.resistance_min_ohm)?;
        error::ascending(
            (Parameter::ResistanceMinOhm, self.resistance_min_ohm),
            (Parameter::ResistanceMaxOhm, self.resistance_max_ohm),
        )?;
        let most_ohm = platinum.resistance_ohm(hottest_c);
        error::within(Parameter::ResistanceMaxOhm, self.resistance_max_ohm, 0.0, most_ohm)?;
        error::within(Parameter::TemperatureMaxC, self.temperature_max_c, coldest_c, hottest_c)?;
        error::within(Parameter::CodeMax, self.code_max as f32, 1.0, 8_388_607.0)?;
        self.energy.map(EnergyLimit::checked).transpose()?;
        Ok(self)
    }
}

/// Limits of the guard, in ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GuardConfig {
    /// Ticks in a row without a fresh reading that are accepted; one more trips.
    pub missing_limit_ticks: u32,
    /// Ticks in a row that a regulating drive may request the same level; one more trips.
    pub unreachable_limit_ticks: u32,
    /// Ticks in a row that a driven element may read the very same code; one more trips. 0: for
    /// ever, for converters that show no noise. The board has bounds for it.
    pub stuck_limit_ticks: u32,
}

impl Default for GuardConfig {
    /// One missing reading; 200 000 ticks (33 min at 100 Hz) for set-points; any converter.
    fn default() -> Self {
        Self { missing_limit_ticks: 1, unreachable_limit_ticks: 200_000, stuck_limit_ticks: 0 }
    }
}

/// Judgement of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReadingJudgement {
    /// The reading is usable.
    Good {
        /// Measured value: resistance, Ω, or offset of the capacitance, F.
        raw: f32,
        /// Temperature, °C, or voltage shift, V.
        value: f32,
    },
    /// There is none: accepted for a limited time, at the low level.
    Absent(Cause),
    /// The reading must not be used: trip.
    Bad(Cause),
}

/// Judges one reading that was taken while `level` was on.
#[inline(always)] // into the tick, where time counts
pub fn judge(limits: &Limits, channel: &Channel, reading: Reading, level: Level) -> ReadingJudgement {
    let code = match reading {
        Reading::Code(code) => code,
        Reading::Stale => return ReadingJudgement::Absent(Cause::Stale),
        Reading::Missing => return ReadingJudgement::Absent(Cause::Missing),
    };
    if code >= limits.code_max {
        return ReadingJudgement::Bad(Cause::Open);
    }
    if code <= -limits.code_max {
        return ReadingJudgement::Bad(Cause::OutOfRange);
    }
    let resistance_ohm = channel.resistance_ohm(code, level);
    if resistance_ohm > limits.resistance_max_ohm {
        return ReadingJudgement::Bad(Cause::Open);
    }
    if resistance_ohm < limits.resistance_min_ohm {
        return ReadingJudgement::Bad(Cause::Short);
    }
    let temperature_c = channel.platinum().temperature_c(resistance_ohm);
    if !temperature_c.is_finite() {
        ReadingJudgement::Bad(Cause::NonFinite)
    } else if temperature_c > limits.temperature_max_c {
        ReadingJudgement::Bad(Cause::OverTemperature)
    } else {
        ReadingJudgement::Good { raw: resistance_ohm, value: temperature_c }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::control::state::RunState;
    use std::string::ToString;

    const LIMITS: Limits = Limits::SPHERE_B;

    fn verdict(reading: Reading, level: Level) -> ReadingJudgement {
        let channel = Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), 4.0 / 8_388_608.0, 3e-3, 16e-3).unwrap();
        judge(&LIMITS, &channel, reading, level)
    }

    fn code(resistance_ohm: f64, level: Level) -> Reading {
        let current_a = if level == Level::High { 16e-3 } else { 3e-3 };
        Reading::Code((resistance_ohm * current_a / 4.0 * 8_388_608.0) as i32)
    }

    #[test]
    fn a_plausible_reading_passes_at_either_level() {
        for level in [Level::Low, Level::High] {
            match verdict(code(175.0, level), level) {
                ReadingJudgement::Good { value, .. } => assert!(value.abs() < 1e-3),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn every_electrical_fault_has_its_cause() {
        let low = Level::Low;
        assert_eq!(verdict(Reading::Code(8_388_607), low), ReadingJudgement::Bad(Cause::Open));
        assert_eq!(verdict(code(300.0, low), low), ReadingJudgement::Bad(Cause::Open));
        assert_eq!(verdict(code(0.1, low), low), ReadingJudgement::Bad(Cause::Short));
        assert_eq!(verdict(Reading::Code(-1000), low), ReadingJudgement::Bad(Cause::Short));
        assert_eq!(verdict(Reading::Code(-8_388_608), low), ReadingJudgement::Bad(Cause::OutOfRange));
        // 215 Ω is 73.7 °C
        assert_eq!(verdict(code(215.0, low), low), ReadingJudgement::Bad(Cause::OverTemperature));
        assert_eq!(verdict(Reading::Stale, low), ReadingJudgement::Absent(Cause::Stale));
        assert_eq!(verdict(Reading::Missing, low), ReadingJudgement::Absent(Cause::Missing));
    }

    #[test]
    fn the_limits_themselves_are_where_they_say() {
        let low = Level::Low;
        let end = LIMITS.code_max;
        assert_eq!(verdict(Reading::Code(end), low), ReadingJudgement::Bad(Cause::Open));
        assert_eq!(verdict(Reading::Code(-end), low), ReadingJudgement::Bad(Cause::OutOfRange));
        assert_eq!(verdict(Reading::Code(1 - end), low), ReadingJudgement::Bad(Cause::Short));
        // 70 °C is 212.975 Ω; a code is 0.16 mΩ at the low level.
        assert!(matches!(verdict(code(212.974, low), low), ReadingJudgement::Good { .. }));
        assert_eq!(verdict(code(212.976, low), low), ReadingJudgement::Bad(Cause::OverTemperature));
        assert!(matches!(verdict(code(50.001, low), low), ReadingJudgement::Good { .. }));
        assert_eq!(verdict(code(49.999, low), low), ReadingJudgement::Bad(Cause::Short));
    }

    #[test]
    fn a_reading_at_the_wrong_level_is_no_reading() {
        // A high current taken for the low one looks five times too resistive: seen as open, not as
        // hot.
        assert_eq!(verdict(code(162.0, Level::High), Level::Low), ReadingJudgement::Bad(Cause::Open));
        assert_eq!(verdict(code(162.0, Level::Low), Level::High), ReadingJudgement::Bad(Cause::Short));
    }

    #[test]
    fn refuses_limits_that_exclude_everything() {
        let platinum = Platinum::linear(175.0, 0.0031).unwrap();
        let refused = |limits: Limits| limits.checked(&platinum).unwrap_err().parameter;
        assert_eq!(LIMITS.checked(&platinum), Ok(LIMITS));
        assert_eq!(refused(Limits { resistance_max_ohm: 40.0, ..LIMITS }), Parameter::ResistanceMaxOhm);
        assert_eq!(refused(Limits { resistance_min_ohm: f32::NAN, ..LIMITS }), Parameter::ResistanceMinOhm);
        assert_eq!(refused(Limits { temperature_max_c: f32::NAN, ..LIMITS }), Parameter::TemperatureMaxC);
        // The law ends at 300 °C, 337.75 Ω.
        assert_eq!(refused(Limits { temperature_max_c: 301.0, ..LIMITS }), Parameter::TemperatureMaxC);
        assert_eq!(refused(Limits { resistance_max_ohm: 338.0, ..LIMITS }), Parameter::ResistanceMaxOhm);
        assert_eq!(refused(Limits { code_max: 0, ..LIMITS }), Parameter::CodeMax);
        let bearing = |sustained_power_w, energy_j| {
            refused(Limits { energy: Some(EnergyLimit { sustained_power_w, energy_j }), ..LIMITS })
        };
        assert_eq!([bearing(f32::NAN, 1.0), bearing(0.0, 1.0)], [Parameter::SustainedPowerW; 2]);
        assert_eq!([bearing(0.01, f32::INFINITY), bearing(0.01, -1.0)], [Parameter::EnergyJ; 2]);
    }

    #[test]
    fn every_cause_has_a_name_of_its_own() {
        // In the order of their declaration, which is the one on the wire.
        const ALL: [Cause; 25] = [
            Cause::Open,
            Cause::Short,
            Cause::OutOfRange,
            Cause::OverTemperature,
            Cause::NonFinite,
            Cause::Missing,
            Cause::Stale,
            Cause::Unreachable,
            Cause::Stuck,
            Cause::BitFlip,
            Cause::Deadline,
            Cause::Heater,
            Cause::Panic,
            Cause::Fault,
            Cause::Watchdog,
            Cause::BrownOut,
            Cause::Memory,
            Cause::Clock,
            Cause::ProofTest,
            Cause::HostTimeout,
            Cause::OtherHead,
            Cause::AdcRegister,
            Cause::Energy,
            Cause::PullIn,
            Cause::Restart,
        ];
        let names = ALL.map(Cause::name);
        for (place, name) in names.iter().enumerate() {
            assert_eq!((ALL[place] as usize, Cause::from_repr(place)), (place, Some(ALL[place])));
            for trip in [Trip::whole(ALL[place]), Trip::of(15, ALL[place])] {
                assert_eq!(RunState::tripped_of(RunState::Tripped(trip).word()), Some(trip));
            }
            assert!(!name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c == '-'), "{name}");
            assert!(!names[..place].contains(name), "{name} is there twice");
        }
        assert_eq!(Trip::of(2, Cause::OverTemperature).to_string(), "over-temperature, element 2");
        assert_eq!(Trip::whole(Cause::BrownOut).to_string(), "brown-out");
    }

    #[test]
    fn a_temperature_that_is_none_is_not_acted_upon() {
        // A resistor whose coefficient is so small that what is divided by it overflows, which no
        // sound channel has.
        let tiny = Platinum::linear(1e-3, 1e-38).unwrap();
        let channel = Channel::new(tiny, 4.0 / 8_388_608.0, 3e-3, 16e-3).unwrap();
        let verdict = judge(&LIMITS, &channel, code(175.0, Level::Low), Level::Low);
        assert_eq!(verdict, ReadingJudgement::Bad(Cause::NonFinite));
    }

    #[test]
    fn a_number_on_its_limit_is_still_good() {
        // All powers of two, so that resistance and temperature are exact: 2⁻¹² Ω a code, T = 2 (R
        // − 128).
        let platinum = Platinum::linear(128.0, 1.0 / 256.0).unwrap();
        let channel = Channel::new(platinum, 1.0 / 1_048_576.0, 1.0 / 256.0, 1.0 / 64.0).unwrap();
        let limits = Limits { temperature_max_c: 264.0, ..LIMITS };
        let at = |limits: &Limits, ohm_4096: i32| judge(limits, &channel, Reading::Code(ohm_4096), Level::Low);
        let good = |ohm: f32| ReadingJudgement::Good { raw: ohm, value: 2.0 * (ohm - 128.0) };
        assert_eq!(at(&limits, 260 * 4096), good(260.0));
        assert_eq!(at(&limits, 260 * 4096 + 1), ReadingJudgement::Bad(Cause::Open));
        assert_eq!(at(&limits, 50 * 4096), good(50.0));
        assert_eq!(at(&limits, 50 * 4096 - 1), ReadingJudgement::Bad(Cause::Short));
        let cool = Limits { temperature_max_c: 70.0, ..limits };
        assert_eq!(at(&cool, 163 * 4096), good(163.0));
        assert_eq!(at(&cool, 163 * 4096 + 1), ReadingJudgement::Bad(Cause::OverTemperature));
    }
}
