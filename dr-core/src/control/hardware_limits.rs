//! Grants of a board: limits that no message can lift.
//!
//! A board hands them to its controller when it makes it. A head may be stricter; a configuration
//! beyond them is refused by the name of its number, with the bounds. Times are judged in ticks of
//! the configured period.
//!
//! | number | bound of the sensor board | reason |
//! |---|---|---|
//! | V a code | 4 V / 2²³ ± 1 % | reference of the ADS131E06 |
//! | currents | 3 and 16 mA, ± 2 % each | R_S and divider of 0.1 %, and room for calibration |
//! | high by low current | 1.5 | a level that stays high is read as low: at −60 °C as 71 °C or more |
//! | temperature, resistance | 70 °C, 260 Ω | the head's silver and solder joints; full scale |
//! | resistance at the temperature limit | 220 Ω | 213 Ω at 70 °C and 3 % between specimens: whatever law is stated, an element of 175 Ω trips below 83 °C |
//! | tick | 1 s | reaction times count in ticks |
//! | no rise at the high level | 22.5 s | process safety time, 90 s, by 4: `control/rise.rs` |
//! | equal codes | 3 … 1000 | noise exceeds a code |
//! | mean power of an element, energy above it | 32 mW, 12 J | [`energy`](super::energy) |
//!
//! The process safety time is that of `docs/explanation/single-faults.md`: in the simulated sphere
//! B in quiescent gas of 20 °C, the worst single fault lets a sector pass 70 °C after 90 s, all six
//! elements high after 127 s (CO₂ of 1000 Pa). A board that is built for another body, or with
//! other resistors, has other limits: this table and no other place.

use super::energy::EnergyLimit;
use super::guard::GuardConfig;
use super::state::ElementConfig;
use crate::error::{self, ConfigError, Parameter};
use crate::sensor::Level;

/// Limits of a board, each from least to most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardwareLimits {
    /// Voltage of a code, V.
    pub volt_per_code: (f32, f32),
    /// Low current, A.
    pub current_low_a: (f32, f32),
    /// High current, A.
    pub current_high_a: (f32, f32),
    /// The high current is at least so many times the low one.
    pub current_ratio_min: f32,
    /// Highest `temperature_max_c` of an element, °C.
    pub temperature_max_c: f32,
    /// Highest `resistance_max_ohm` of an element, Ω.
    pub resistance_max_ohm: f32,
    /// Highest resistance of an element at its `temperature_max_c`, Ω, by the law that is stated.
    pub resistance_hot_ohm: f32,
    /// Longest sample period, s.
    pub sample_period_s: f32,
    /// `stuck_limit_ticks` of a guard; 0 as the least allows any converter.
    pub stuck_limit_ticks: (u32, u32),
    /// Longest time at the high level without a rise of the reading, s.
    pub no_rise_s: f32,
    /// Energy that an element may have whose head does not state less.
    pub energy: EnergyLimit,
    /// Highest bias of a capacitor, either way, V; 0 without such elements.
    pub bias_max_v: f32,
}

impl HardwareLimits {
    /// The sensor board with a head of sphere B.
    pub const SENSOR_BOARD: Self = Self {
        volt_per_code: (0.99 * 4.0 / 8_388_608.0, 1.01 * 4.0 / 8_388_608.0),
        current_low_a: (2.94e-3, 3.06e-3),
        current_high_a: (15.68e-3, 16.32e-3),
        current_ratio_min: 1.5,
        temperature_max_c: 70.0,
        resistance_max_ohm: 260.0,
        resistance_hot_ohm: 220.0,
        sample_period_s: 1.0,
        stuck_limit_ticks: (3, 1000),
        no_rise_s: 90.0 / 4.0,
        energy: EnergyLimit { sustained_power_w: 0.032, energy_j: 12.0 },
        bias_max_v: 0.0,
    };

    /// Simulated electronics, which any head fits, and any converter, with or without noise. The
    /// slowest body, the boom of REMS, needs minutes for a kelvin. What a head bears it states.
    pub const SIMULATED: Self = Self {
        volt_per_code: (0.0, 1.0),
        current_low_a: (0.0, 1.0),
        current_high_a: (0.0, 1.0),
        temperature_max_c: 850.0,
        resistance_max_ohm: 1e6,
        resistance_hot_ohm: f32::MAX,
        sample_period_s: 10.0,
        stuck_limit_ticks: (0, u32::MAX),
        no_rise_s: 2000.0,
        energy: EnergyLimit { sustained_power_w: 1e3, energy_j: 1e6 },
        bias_max_v: 200.0,
        ..Self::SENSOR_BOARD
    };

    /// The guard until a message sets another.
    pub(super) fn guard(&self) -> GuardConfig {
        let (least, most) = self.stuck_limit_ticks;
        GuardConfig { stuck_limit_ticks: if least == 0 { 0 } else { most }, ..GuardConfig::default() }
    }

    /// Refuses a guard that is laxer.
    pub(super) fn check_guard(&self, guard: &GuardConfig) -> Result<(), ConfigError> {
        let (least, most) = self.stuck_limit_ticks;
        if (least..=most).contains(&guard.stuck_limit_ticks) {
            Ok(())
        } else {
            Err(error::out_of_range(Parameter::StuckLimitTicks, least as f32, most as f32))
        }
    }

    /// Refuses an element that the board does not have, or that is limited less than it allows.
    pub(super) fn check_element(&self, element: &ElementConfig) -> Result<(), ConfigError> {
        let (channel, limits) = (&element.channel, &element.limits);
        let (current_low_a, current_high_a) = (channel.current_a(Level::Low), channel.current_a(Level::High));
        let bounded = |parameter, value, (least, most)| error::within(parameter, value, least, most).map(|_| ());
        bounded(Parameter::VoltPerCode, channel.volt(1.0), self.volt_per_code)?;
        bounded(Parameter::CurrentLowA, current_low_a, self.current_low_a)?;
        let (least_a, most_a) = self.current_high_a;
        let least_a = least_a.max(self.current_ratio_min * current_low_a);
        bounded(Parameter::CurrentHighA, current_high_a, (least_a, most_a))?;
        let platinum = channel.platinum();
        bounded(Parameter::Resistance0cOhm, platinum.resistance_ohm(0.0), (0.0, self.resistance_hot_ohm))?;
        let (coldest_c, _) = platinum.range_c();
        let hottest_c = platinum.temperature_c(self.resistance_hot_ohm).min(self.temperature_max_c);
        bounded(Parameter::TemperatureMaxC, limits.temperature_max_c, (coldest_c, hottest_c))?;
        bounded(Parameter::ResistanceMaxOhm, limits.resistance_max_ohm, (0.0, self.resistance_max_ohm))?;
        limits.energy.map_or(Ok(()), |energy| energy.check_within(&self.energy))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::control::Limits;
    use crate::sensor::{Channel, Platinum};
    use std::string::ToString;

    const BOARD: HardwareLimits = HardwareLimits::SENSOR_BOARD;

    fn element(current_low_a: f32, current_high_a: f32) -> ElementConfig {
        let platinum = Platinum::linear(175.0, 0.0031).unwrap();
        ElementConfig {
            channel: Channel::new(platinum, 4.0 / 8_388_608.0, current_low_a, current_high_a).unwrap(),
            limits: Limits::SPHERE_B,
        }
    }

    fn refused(board: &HardwareLimits, element: &ElementConfig) -> Parameter {
        board.check_element(element).unwrap_err().parameter
    }

    #[test]
    fn an_element_may_be_stricter_and_nothing_of_it_laxer() {
        let good = element(3e-3, 16e-3);
        assert_eq!(BOARD.check_element(&good), Ok(()));
        let of = |limits| ElementConfig { limits, ..good };
        assert_eq!(BOARD.check_element(&of(Limits { temperature_max_c: 40.0, ..good.limits })), Ok(()));
        assert_eq!(BOARD.check_element(&of(Limits { resistance_max_ohm: 200.0, ..good.limits })), Ok(()));
        let hot = of(Limits { temperature_max_c: 70.1, ..good.limits });
        assert_eq!(refused(&BOARD, &hot), Parameter::TemperatureMaxC);
        let open = of(Limits { resistance_max_ohm: 261.0, ..good.limits });
        assert_eq!(refused(&BOARD, &open), Parameter::ResistanceMaxOhm);
        assert_eq!(refused(&BOARD, &element(2.9e-3, 16e-3)), Parameter::CurrentLowA);
        assert_eq!(refused(&BOARD, &element(3.1e-3, 16e-3)), Parameter::CurrentLowA);
        assert_eq!(refused(&BOARD, &element(3e-3, 15.6e-3)), Parameter::CurrentHighA);
        assert_eq!(refused(&BOARD, &element(3e-3, 16.4e-3)), Parameter::CurrentHighA);
        let bearing = |sustained_power_w, energy_j| {
            of(Limits { energy: Some(EnergyLimit { sustained_power_w, energy_j }), ..good.limits })
        };
        assert_eq!(BOARD.check_element(&bearing(0.02, 3.0)), Ok(()));
        assert_eq!(refused(&BOARD, &bearing(0.033, 3.0)), Parameter::SustainedPowerW);
        assert_eq!(refused(&BOARD, &bearing(0.02, 12.1)), Parameter::EnergyJ);
        let channel = Channel::new(*good.channel.platinum(), 4.1 / 8_388_608.0, 3e-3, 16e-3).unwrap();
        assert_eq!(refused(&BOARD, &ElementConfig { channel, ..good }), Parameter::VoltPerCode);
        let sentence = BOARD.check_element(&hot).unwrap_err().to_string();
        assert!(sentence.starts_with("`temperature_max_c` must lie between ") && sentence.ends_with(" and 70"));
    }

    #[test]
    fn a_law_by_which_an_element_would_be_hotter_than_it_reads_is_refused() {
        let good = element(3e-3, 16e-3);
        let of = |platinum: Platinum, temperature_max_c| {
            let channel = Channel::new(platinum, 4.0 / 8_388_608.0, 3e-3, 16e-3).unwrap();
            ElementConfig { channel, limits: Limits { temperature_max_c, ..good.limits } }
        };
        let linear = |ohm, coefficient_per_c| Platinum::linear(ohm, coefficient_per_c).unwrap();
        // 3 % between specimens, and any law that reads hotter than it is.
        for platinum in [linear(180.0, 0.0031), linear(175.0, 0.0036), linear(100.0, 0.0031)] {
            assert_eq!(BOARD.check_element(&of(platinum, 70.0)), Ok(()));
        }
        assert_eq!(BOARD.check_element(&of(Platinum::iec60751(100.0).unwrap(), 70.0)), Ok(()));
        assert_eq!(refused(&BOARD, &of(linear(1e6, 0.0031), 70.0)), Parameter::Resistance0cOhm);
        for (platinum, temperature_max_c) in [
            (linear(182.0, 0.0031), 70.0),
            (linear(175.0, 0.0037), 70.0),
            (linear(130.0, 0.01), 70.0),
            (Platinum::iec60751(175.0).unwrap(), 67.0),
        ] {
            assert_eq!(refused(&BOARD, &of(platinum, temperature_max_c)), Parameter::TemperatureMaxC);
            // Its own limit may be lower.
            assert_eq!(BOARD.check_element(&of(platinum, 40.0)), Ok(()));
        }
        // Claims of the table.
        assert!(linear(175.0, 0.0031).temperature_c(BOARD.resistance_hot_ohm) < 83.0);
    }

    #[test]
    fn currents_between_which_a_stuck_level_would_not_show_are_refused() {
        let any = HardwareLimits::SIMULATED;
        assert_eq!(any.check_element(&element(10e-3, 15.1e-3)), Ok(()));
        assert_eq!(refused(&any, &element(10e-3, 14.9e-3)), Parameter::CurrentHighA);
        assert_eq!(refused(&any, &element(15.9e-3, 16e-3)), Parameter::CurrentHighA);
        // Claim of the table's sentence, in the coldest gas of any experiment.
        let platinum = Platinum::linear(175.0, 0.0031).unwrap();
        assert!(platinum.temperature_c(1.5 * platinum.resistance_ohm(-60.0)) > BOARD.temperature_max_c);
    }

    #[test]
    fn a_guard_may_not_believe_one_code_for_ever() {
        let checked = |stuck_limit_ticks| {
            BOARD.check_guard(&GuardConfig { stuck_limit_ticks, ..GuardConfig::default() }).map_err(|e| e.parameter)
        };
        assert_eq!([3, 200, 1000].map(checked), [Ok(()); 3]);
        assert_eq!([0, 2, 1001, u32::MAX].map(checked), [Err(Parameter::StuckLimitTicks); 4]);
        assert_eq!(BOARD.check_guard(&BOARD.guard()), Ok(()));
        assert_eq!(HardwareLimits::SIMULATED.guard(), GuardConfig::default());
    }
}
