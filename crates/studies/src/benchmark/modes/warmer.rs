//! Steady states in a warmer gas, and on a warmer support.
//!
//! The reading r believes the gas as it was. Its error becomes one of the speed by the slope of r
//! between the two winds, in ln r by ln U.

use dr_core::sensor::Level;
use host_sim::sensor::{BodySurvey, construction_of};

use super::compared::{ComparedHead, OperatingMode, WINDS_M_S};
use anemometry::gas::IdealGas;

/// Rise of the temperature, K.
const WARMER_K: f64 = 10.0;

/// Errors of the speed in a mode, %: in a warmer gas, and on a warmer support.
pub fn errors(compared: &mut ComparedHead, mode: OperatingMode) -> [f64; 2] {
    let believed_c = compared.conditions.temperature_c;
    let gas = |warmer_k: f64| compared.conditions.gas().map(|gas| gas.at(gas.temperature_k + warmer_k)).ok();
    let gases = [gas(0.0), gas(WARMER_K)];
    let reading = |gas: Option<IdealGas>, support_c: f64, speed_m_s: f64| {
        let construction = construction_of(&compared.head).ok().flatten()?;
        let mut survey = BodySurvey::new(&construction, &compared.head.elements, &gas?, support_c).ok()?;
        Some(steady(compared, mode, &mut survey, speed_m_s))
    };
    let plain = reading(gases[0], believed_c, WINDS_M_S[0]);
    let faster = reading(gases[0], believed_c, WINDS_M_S[1]);
    let percent = |other: Option<f64>| {
        let (Some(plain), Some(faster), Some(other)) = (plain, faster, other) else { return f64::NAN };
        let slope = libm::log(faster / plain) / libm::log(WINDS_M_S[1] / WINDS_M_S[0]);
        100.0 * (libm::exp(libm::log(other / plain) / slope) - 1.0)
    };
    let warm_support_c = believed_c + WARMER_K;
    [reading(gases[1], believed_c, WINDS_M_S[0]), reading(gases[0], warm_support_c, WINDS_M_S[0])].map(percent)
}

/// r in a steady wind, W/K.
fn steady(compared: &ComparedHead, mode: OperatingMode, survey: &mut BodySurvey, speed_m_s: f64) -> f64 {
    let ComparedHead { head, conditions, held, power_w, .. } = compared;
    let (wind_m_s, set_point_c) = ([-speed_m_s, 0.0, 0.0], conditions.set_point_c());
    let is_held = |i: usize| held.contains(&i);
    let low_w = |i: usize, temperature_c: f64| head.elements[i].power_w(temperature_c, Level::Low);
    let resistance_ohm =
        |i: usize, c: f64| f64::from(head.elements[i].config.channel.platinum().resistance_ohm(c as f32));
    let current2 = |i: usize| power_w[i] / resistance_ohm(i, set_point_c);
    let of_mode = |i: usize, temperature_c: f64| match mode {
        _ if !is_held(i) => low_w(i, temperature_c),
        OperatingMode::Cca => current2(i) * resistance_ohm(i, temperature_c),
        OperatingMode::Cta | OperatingMode::Cpa => power_w[i],
    };
    let (powers_w, temperatures_c) = if mode == OperatingMode::Cta {
        let held_c: Vec<Option<f64>> = (0..head.elements.len()).map(|i| is_held(i).then_some(set_point_c)).collect();
        let powers_w = survey.operating_point(wind_m_s, &held_c).power_w;
        (powers_w, vec![set_point_c; head.elements.len()])
    } else {
        let temperatures_c = survey.temperatures_c(wind_m_s, of_mode);
        ((0..head.elements.len()).map(|i| of_mode(i, temperatures_c[i])).collect(), temperatures_c)
    };
    held.iter().map(|&i| powers_w[i] / (temperatures_c[i] - conditions.temperature_c)).sum()
}
