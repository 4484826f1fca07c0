//! A head that stands in balance, of which every answer is known in closed form.
//!
//! One relaxation an element, R at a rate of 1 rad/s, surface share m: T = rest + R (P − m q), so
//! that a head that is said to have stood for long has
//!
//! ```text
//! q = (P − (T − rest)/R) / m        Ts = rest + m (T − rest)
//! G = gain · (q + G_0 (Ts − T_ref)) / (Ts − T_gas)
//! ```
//!
//! The powers are those that a wind takes, by these equations the other way round.

use super::*;
use crate::control::{Cause, Heaters, RunState, Tick, Trip};
use crate::wind::SurfaceConfig;
use std::sync::OnceLock;

/// Four parts, and a thermometer that the network does not know.
pub const ELEMENTS: usize = 5;
pub const PERIOD_S: f32 = 1.0 / 1024.0;
pub const GAS_C: f32 = -52.0;
const REST_C: f32 = -53.0;
const REFERENCE_C: f32 = -50.0;
const PRESSURE_PA: f32 = 700.0;
const WINDLESS_W_K: f32 = 1.7e-4;
const PATIENT: [f32; 2] = [0.5, 1.5];
const FORWARD_W_K: f32 = 0.2;
const VARIANCE_W2: f32 = 1e-8;

/// By part.
const R_K_PER_W: [f32; 4] = [400.0, 380.0, 420.0, 390.0];
const SURFACE: [f32; 4] = [1.0, 0.9, 0.95, 1.1];
const GAIN: [f32; 4] = [1.0, 1.2, 0.8, 1.1];
pub const TEMPERATURE_C: [f32; ELEMENTS] = [-30.0, -29.0, -31.0, -28.0, -52.5];
pub const WIND_M_S: [f32; 3] = [3.0, -4.0, 1.0];

pub fn config() -> WindOutputConfig {
    WindOutputConfig {
        surfaces: 4,
        diameter_m: DIAMETER_M,
        reynolds: Some([1.0, 200.0]),
        direction_error_max_rad: 0.5,
        output_interval_ticks: 1,
        reference: None,
        smoothing_s: [1.0 / 16.0, 1.0 / 32.0],
        reference_gas_c: REFERENCE_C,
    }
}

pub fn own(part: usize) -> NetworkSelfHeatingConfig {
    let mut r_k_per_w = [0.0; 8];
    r_k_per_w[0] = R_K_PER_W[part];
    NetworkSelfHeatingConfig {
        mesh_rad_s: mesh::geometric(1.0, 400.0).unwrap(),
        r_k_per_w,
        surface: [SURFACE[part]; 8],
        rest_c: REST_C,
        gains: GainsConfig {
            correction_w_per_k: [0.0; 8],
            convection_w_per_k: FORWARD_W_K,
            weights: PATIENT,
            variance_w2: VARIANCE_W2 * (1 + part) as f32,
        },
        alarm: None,
    }
}

/// All that such a head is told before its `Output`, with these surfaces and no more parts than
/// they are.
pub fn told_of(surfaces: &[SurfaceConfig]) -> Anemometer<ELEMENTS> {
    let mut anemometer = Anemometer::default();
    let mut tell = |command| anemometer.handle(&command, PERIOD_S).unwrap();
    for element in 0..4_u8 {
        tell(WindCommand::SelfHeating { element, config: own(usize::from(element)) });
    }
    for (point, amplitudes) in (0_u8..).zip(nusselt().amplitudes) {
        tell(WindCommand::NusseltPoint { point, amplitudes });
    }
    for (element, surface) in (0_u8..).zip(surfaces) {
        let gain = GAIN[usize::from(element)];
        let config = HeadSurface { element, surface: *surface, gain, windless_w_k: WINDLESS_W_K };
        tell(WindCommand::Surface { surface: element, config });
    }
    tell(WindCommand::GasLaw(law()));
    anemometer
}

pub fn gas(temperature_c: Option<f32>) -> WindCommand {
    WindCommand::Gas { pressure_pa: PRESSURE_PA, temperature_c }
}

/// Four sectors, ready to answer.
pub fn sectors(config: &WindOutputConfig) -> Anemometer<ELEMENTS> {
    let mut anemometer = told_of(&sphere::tetrahedral_sectors(DIAMETER_M));
    anemometer.handle(&WindCommand::Output(*config), PERIOD_S).unwrap();
    anemometer.handle(&gas(Some(GAS_C)), PERIOD_S).unwrap();
    anemometer
}

/// Number `n` of ticks in which nothing changes: all held, all at the low level.
pub fn tick(n: u32) -> Tick<ELEMENTS> {
    Tick {
        tick: n,
        elements: ELEMENTS as u8,
        heaters: Heaters(0),
        valid: 0b1_1111,
        temperature_c: TEMPERATURE_C,
        power_w: power_w(),
        equivalent_power_w: None,
        state: RunState::Running,
        trip: None,
    }
}

/// Power that the surfaces take in [`WIND_M_S`]; the thermometer takes nothing.
pub fn power_w() -> [f32; ELEMENTS] {
    static POWER_W: OnceLock<[f32; ELEMENTS]> = OnceLock::new();
    *POWER_W.get_or_init(|| power_of(&vector().conductances(&gas_there(), WIND_M_S).map(|of| of.conductance_w_k)))
}

pub fn gas_there() -> GasState {
    GasLaw::new(&law()).unwrap().at(PRESSURE_PA, GAS_C).unwrap()
}

/// Power that the first parts take at these conductances.
pub fn power_of(conductance_w_k: &[f32]) -> [f32; ELEMENTS] {
    let mut power_w = [0.0; ELEMENTS];
    for (part, &of) in conductance_w_k.iter().enumerate().take(SECTORS) {
        let (rise_k, surface_c) = warm(part);
        let flow_w = f64::from(of) / f64::from(GAIN[part]) * (surface_c - f64::from(GAS_C));
        let q = flow_w - f64::from(WINDLESS_W_K) * (surface_c - f64::from(REFERENCE_C));
        power_w[part] = (rise_k / f64::from(R_K_PER_W[part]) + f64::from(SURFACE[part]) * q) as f32;
    }
    power_w
}

/// The anemometer follows a tick, having stood for long under these powers.
pub fn follow(anemometer: &mut Anemometer<ELEMENTS>, tick: &Tick<ELEMENTS>) -> Option<WindTick> {
    let standing_w = power_w();
    anemometer.step(tick, |element, _| standing_w[element])
}

/// Rise of a surface over rest, K, and its temperature, °C.
fn warm(part: usize) -> (f64, f64) {
    let rise_k = f64::from(TEMPERATURE_C[part] - REST_C);
    (rise_k, f64::from(REST_C) + f64::from(SURFACE[part]) * rise_k)
}

/// Surface's temperature and conductance of a surface, by the equations above from the power as it
/// was rounded.
pub fn by_hand(part: usize) -> (f64, f64) {
    let (rise_k, surface_c) = warm(part);
    let [r, m, gain] = [R_K_PER_W[part], SURFACE[part], GAIN[part]].map(f64::from);
    let q = (f64::from(power_w()[part]) - rise_k / r) / m;
    let flow_w = q + f64::from(WINDLESS_W_K) * (surface_c - f64::from(REFERENCE_C));
    (surface_c, gain * flow_w / (surface_c - f64::from(GAS_C)))
}

fn near(found: f32, truth: f64, share: f64) -> bool {
    (f64::from(found) - truth).abs() <= share * truth.abs()
}

#[test]
fn conductances_are_those_of_the_balance() {
    let told = follow(&mut sectors(&config()), &tick(0)).unwrap();
    assert_eq!((told.surfaces, told.gas_c), (4, GAS_C));
    for (part, &found) in told.conductance_w_k.iter().enumerate().take(SECTORS) {
        // The model's temperature is rounded by 4 µK, of which the first reading makes 0.4 µW, of
        // some 10 mW.
        assert!(near(found, by_hand(part).1, 1e-4), "{part}: {found} for {}", by_hand(part).1);
    }
}

#[test]
fn the_wind_is_the_one_that_took_the_powers() {
    let told = follow(&mut sectors(&config()), &tick(0)).unwrap();
    assert!(off(told.wind.wind_m_s, WIND_M_S) < 5e-3, "{told:?}");
    // Its errors are those of the conductances, which are those of q.
    let measured: [_; SECTORS] = core::array::from_fn(|part| {
        let (surface_c, conductance_w_k) = by_hand(part);
        let share = f64::from(GAIN[part]) / (surface_c - f64::from(GAS_C));
        // All readings are at the low level.
        let variance = share * share * f64::from(VARIANCE_W2 * (1 + part) as f32 / PATIENT[0]);
        Some(MeasuredConductance { conductance_w_k: conductance_w_k as f32, variance_w2_k2: variance as f32 })
    });
    let wind = vector().step(&mut WindState::default(), &gas_there(), &measured);
    for (found, truth) in told.wind.covariance_m2_s2.as_flattened().iter().zip(wind.covariance_m2_s2.as_flattened()) {
        assert!((found - truth).abs() < 1e-2 * wind.covariance_m2_s2[0][0], "{found} {truth}");
    }
}

#[test]
fn raw_conductances_are_of_powers_smoothed_over_their_time() {
    let mut anemometer = sectors(&config());
    for n in 0..200 {
        let told = follow(&mut anemometer, &tick(n)).unwrap();
        // Exactly sampled: 1 − e^(−t/τ) after t = (n + 1) ticks.
        let share = -libm::expm1(-f64::from(n + 1) * f64::from(PERIOD_S) * 32.0);
        for (part, &raw) in told.raw_w_k.iter().enumerate().take(SECTORS) {
            let truth = share * f64::from(power_w()[part]) / f64::from(TEMPERATURE_C[part] - GAS_C);
            assert!(near(raw, truth, 1e-5), "tick {n}, {part}: {raw} for {truth}");
        }
    }
    let mut prompt = sectors(&WindOutputConfig { smoothing_s: [0.0; 2], ..config() });
    let told = follow(&mut prompt, &tick(0)).unwrap();
    assert!(near(told.raw_w_k[2], f64::from(power_w()[2]) / 21.0, 1e-6), "not smoothed at all");
}

#[test]
fn a_reading_counts_by_the_level_at_which_it_was_read() {
    // A part that is suddenly warmer: q falls by ℓ w δ, its surface's temperature is still the
    // model's.
    let rise_k = 0.01;
    for (heaters, weight) in [(0b0000, PATIENT[0]), (0b0010, PATIENT[1]), (0b1101, PATIENT[0])] {
        let mut anemometer = sectors(&config());
        follow(&mut anemometer, &Tick { heaters: Heaters(heaters), ..tick(0) });
        let mut warmer = tick(1);
        warmer.temperature_c[1] += rise_k;
        let told = follow(&mut anemometer, &warmer).unwrap();
        let (surface_c, still_w_k) = by_hand(1);
        let per_k = f64::from(GAIN[1]) / (surface_c - f64::from(GAS_C));
        // The first reading was at the low level.
        let mean_weight = f64::from(PATIENT[0]) + f64::from(weight - PATIENT[0]) / 64.0;
        let truth = still_w_k - per_k * f64::from(FORWARD_W_K * weight * rise_k) / mean_weight;
        // See above; the other weight would be off by a tenth.
        assert!(near(told.conductance_w_k[1], truth, 5e-4), "{heaters:b}: {} for {truth}", told.conductance_w_k[1]);
        assert!(near(told.conductance_w_k[0], by_hand(0).1, 2e-4));
    }
}

#[test]
fn an_answer_comes_every_so_many_ticks() {
    let mut anemometer = sectors(&WindOutputConfig { output_interval_ticks: 7, ..config() });
    for n in 0..50 {
        assert_eq!(follow(&mut anemometer, &tick(n)).is_some(), n % 7 == 0, "tick {n}");
    }
}

#[test]
fn it_is_starting_for_ten_smoothing_times() {
    let mut anemometer = sectors(&config());
    // 10/32 s of 1/1024 s each.
    for n in 0..400 {
        let told = follow(&mut anemometer, &tick(n)).unwrap();
        assert_eq!(told.quality_flags.has(QualityFlags::STARTING), n + 1 < 320, "tick {n}");
        assert!(
            told.quality_flags == if n + 1 < 320 { QualityFlags::STARTING } else { QualityFlags::default() },
            "{}",
            told.quality_flags
        );
    }
    anemometer.restart();
    assert!(follow(&mut anemometer, &tick(400)).unwrap().quality_flags.has(QualityFlags::STARTING));
}

#[test]
fn on_a_head_too_warm_for_its_power_it_is_starting_for_three_of_its_slowest_times() {
    // A part that takes heat from the gas, though warmer: beyond what quiescent gas a kelvin off
    // would give.
    let starting = |flow_w: f32| {
        let mut anemometer = sectors(&config());
        let rise_k = TEMPERATURE_C[0] - REST_C;
        let power_w = flow_w - WINDLESS_W_K * (TEMPERATURE_C[0] - REFERENCE_C) + rise_k / R_K_PER_W[0];
        let mut still = tick(0);
        still.power_w[0] = power_w;
        let mut ticks = 0;
        for n in 0..3100 {
            let told = anemometer.step(&Tick { tick: n, ..still }, |element, _| still.power_w[element]).unwrap();
            ticks += u32::from(told.quality_flags.has(QualityFlags::STARTING));
        }
        ticks
    };
    assert_eq!(starting(-0.98 * WINDLESS_W_K), 319);
    // 3 / (1 − e^(−1/1024)), of which the last tick is none.
    let slowest_ticks = -1.0 / libm::expm1(-1.0_f64 / 1024.0);
    assert_eq!(starting(-1.02 * WINDLESS_W_K), (3.0 * slowest_ticks) as u32 - 1);
}

#[test]
fn no_flow_at_all_is_no_heat_that_it_cannot_have() {
    // A part that no wind cools has q = 0, exactly; and here nothing of quiescent gas.
    let mut anemometer = sectors(&config());
    let mut sheltered = own(0);
    sheltered.gains.convection_w_per_k = 0.0;
    let surface = sphere::tetrahedral_sectors(DIAMETER_M)[0];
    for command in [
        WindCommand::SelfHeating { element: 0, config: sheltered },
        WindCommand::Surface { surface: 0, config: HeadSurface { element: 0, surface, gain: 1.0, windless_w_k: 0.0 } },
    ] {
        anemometer.handle(&command, PERIOD_S).unwrap();
    }
    let starting =
        (0..400).map(|n| follow(&mut anemometer, &tick(n)).unwrap().quality_flags.has(QualityFlags::STARTING));
    assert_eq!(starting.filter(|&is_starting| is_starting).count(), 319);
}

#[test]
fn a_loop_is_saturated_after_a_second_at_one_level() {
    let saturated = |element: usize, levels: &dyn Fn(u32) -> bool, state: RunState| {
        // Without calibration there is no wind to be worked out, which takes its time.
        let mut anemometer = sectors(&WindOutputConfig { reynolds: None, ..config() });
        let at = |n| {
            let heaters = Heaters(usize::from(levels(n)) << element);
            follow(&mut anemometer, &Tick { heaters, state, ..tick(n) })
                .unwrap()
                .quality_flags
                .has(QualityFlags::SATURATED)
        };
        (0..3000).map(at).position(|is_saturated| is_saturated)
    };
    let running = RunState::Running;
    // The first tick changes the level; a second is 1024 ticks, and one more is too many.
    assert_eq!(saturated(0, &|_| true, running), Some(1025));
    assert_eq!(saturated(3, &|n| n == 0, running), Some(1 + 1025));
    assert_eq!(saturated(3, &|n| n % 1000 < 500, running), None, "it still chooses");
    assert_eq!(saturated(0, &|_| false, running), None, "never heated, so nothing holds it");
    assert_eq!(saturated(4, &|_| true, running), None, "none of the network's");
    assert_eq!(saturated(0, &|_| true, RunState::Standby), None);
    assert_eq!(saturated(0, &|_| true, RunState::Tripped(Trip::whole(Cause::Fault))), None);
}

#[test]
fn what_is_not_held_is_said() {
    let mut anemometer = sectors(&WindOutputConfig { smoothing_s: [0.0; 2], ..config() });
    assert_eq!(follow(&mut anemometer, &tick(0)).unwrap().quality_flags, QualityFlags::default());
    let standing = Tick { state: RunState::Standby, ..tick(1) };
    assert_eq!(follow(&mut anemometer, &standing).unwrap().quality_flags, QualityFlags::NOT_RUNNING);
}

#[test]
fn a_part_that_is_not_read_is_left_out_after_a_twentieth_of_a_second() {
    let mut anemometer = sectors(&config());
    follow(&mut anemometer, &tick(0));
    for n in 1..100 {
        let told = follow(&mut anemometer, &Tick { valid: 0b1_1101, ..tick(n) }).unwrap();
        // 51.2 ticks; its power is known all the same.
        assert_eq!(told.conductance_w_k[1] == 0.0, n > 51, "tick {n}");
        assert_eq!(told.quality_flags.has(QualityFlags::DEGRADED), n > 51, "tick {n}");
        assert!(told.raw_w_k[1] > 0.0 && told.conductance_w_k[2] > 0.0);
    }
    let told = follow(&mut anemometer, &tick(100)).unwrap();
    assert!(told.conductance_w_k[1] > 0.0 && !told.quality_flags.has(QualityFlags::DEGRADED), "one reading is enough");
}

#[test]
fn a_part_less_than_a_kelvin_above_the_gas_is_left_out() {
    // Surface 1 is colder than its element: −31.4 °C; part 3 a warmer one, −25.5 °C.
    let told = |gas_c: f32| {
        let mut anemometer = sectors(&config());
        anemometer.handle(&gas(Some(gas_c)), PERIOD_S).unwrap();
        follow(&mut anemometer, &tick(0)).unwrap()
    };
    let (just, beyond) = (told(-32.41), told(-32.39));
    assert!(just.conductance_w_k[1] > 0.0 && just.raw_w_k[1] > 0.0);
    assert!(beyond.conductance_w_k[1] == 0.0 && beyond.raw_w_k[1] == 0.0);
    assert!(beyond.quality_flags.has(QualityFlags::COLD) && beyond.conductance_w_k[3] > 0.0);
    let (just, beyond) = (told(-29.01), told(-28.99));
    assert!(just.raw_w_k[3] > 0.0 && just.conductance_w_k[3] > 0.0);
    // 1 K less than its power says, although its surface is warm enough.
    assert!(beyond.raw_w_k[3] == 0.0 && beyond.conductance_w_k[3] > 0.0);
}

#[test]
fn a_whole_kelvin_is_enough() {
    // To the bit: the surface is where the network says, the gas 1 K below it, and there the step
    // of an f32 is the same.
    let mut anemometer = sectors(&config());
    let (still, power_w) = (tick(0), power_w());
    let input = TickInput {
        temperature_c: &still.temperature_c,
        valid: still.valid,
        read_high: 0,
        power_w: &power_w,
        standing_w: &power_w,
    };
    let surface_c = anemometer.network.step(&mut ConvectionObserverState::default(), &input).unwrap().surface_c[0];
    for (gas_c, is_enough) in [(surface_c - 1.0, true), (f32::from_bits((surface_c - 1.0).to_bits() - 1), false)] {
        anemometer.handle(&gas(Some(gas_c)), PERIOD_S).unwrap();
        anemometer.restart();
        let told = follow(&mut anemometer, &still).unwrap();
        assert_eq!(told.conductance_w_k[0] > 0.0, is_enough, "{surface_c} {gas_c}");
    }
    // The readings, too.
    let read_c = TEMPERATURE_C[0];
    for (gas_c, is_enough) in [(read_c - 1.0, true), (f32::from_bits((read_c - 1.0).to_bits() - 1), false)] {
        let mut warmer = anemometer.clone();
        warmer.handle(&gas(Some(gas_c)), PERIOD_S).unwrap();
        warmer.restart();
        // Its surface may be colder by roundings of the model: it is made 1 K warmer.
        let mut config = own(0);
        config.surface = [1.05; 8];
        warmer.handle(&WindCommand::SelfHeating { element: 0, config }, PERIOD_S).unwrap();
        assert_eq!(follow(&mut warmer, &still).unwrap().raw_w_k[0] > 0.0, is_enough, "{gas_c}");
    }
}

#[test]
fn the_gas_is_what_its_thermometer_says_smoothed() {
    let mut anemometer = sectors(&WindOutputConfig { reference: Some(4), ..config() });
    assert_eq!(follow(&mut anemometer, &tick(0)).unwrap().gas_c, TEMPERATURE_C[4], "the first reading as it is");
    for n in 1..100 {
        let mut warmer = tick(n);
        warmer.temperature_c[4] += 2.0;
        let told = follow(&mut anemometer, &warmer).unwrap();
        let truth = f64::from(TEMPERATURE_C[4]) - 2.0 * libm::expm1(-f64::from(n) * f64::from(PERIOD_S) * 16.0);
        // A hundred roundings at 50 °C, each of 2 µK at the most.
        assert!((f64::from(told.gas_c) - truth).abs() < 2e-4, "tick {n}: {} for {truth}", told.gas_c);
    }
}

#[test]
fn a_thermometer_that_is_silent_for_a_second_is_not_believed() {
    let mut anemometer = sectors(&WindOutputConfig { reference: Some(4), ..config() });
    follow(&mut anemometer, &tick(0));
    for n in 1..1100 {
        let mut silent = Tick { valid: 0b0_1111, ..tick(n) };
        silent.temperature_c[4] = 20.0;
        let told = follow(&mut anemometer, &silent).unwrap();
        assert_eq!(told.quality_flags.has(QualityFlags::NO_GAS), n > 1024, "tick {n}");
        assert_eq!(told.gas_c, if n > 1024 { 0.0 } else { TEMPERATURE_C[4] });
    }
}

#[test]
fn without_pressure_there_is_no_wind_but_conductances() {
    let mut anemometer = told_of(&sphere::tetrahedral_sectors(DIAMETER_M));
    assert!(follow(&mut anemometer, &tick(0)).is_none() && anemometer.output.is_none());
    let config = WindOutputConfig { reference: Some(4), ..config() };
    anemometer.handle(&WindCommand::Output(config), PERIOD_S).unwrap();
    assert!(anemometer.output.is_some());
    let told = follow(&mut anemometer, &tick(0)).unwrap();
    assert!(told.quality_flags.has(QualityFlags::NO_GAS) && told.wind == WindEstimate::none());
    assert!(told.conductance_w_k[..SECTORS].iter().all(|&w_k| w_k > 0.0));
}

#[test]
fn a_power_that_is_none_is_not_smoothed_in() {
    let mut anemometer = sectors(&config());
    for n in 0..50 {
        follow(&mut anemometer, &tick(n));
    }
    let mut none = tick(50);
    none.power_w[2] = f32::NAN;
    follow(&mut anemometer, &none);
    let told = (51..60).filter_map(|n| follow(&mut anemometer, &tick(n))).last().unwrap();
    assert!(
        told.raw_w_k[..SECTORS].iter().chain(&told.conductance_w_k[..SECTORS]).all(|w_k| w_k.is_finite() && *w_k > 0.0),
        "{told:?}"
    );
}

#[test]
fn corrections_by_command_take_heat_and_dust_out_and_widen_the_uncertainty() {
    let clean = follow(&mut sectors(&config()), &tick(0)).unwrap();
    // Sun of 3 mW on the first surface, which needs so much less power.
    let (heat_w, dust) = (3e-3, 0.95);
    let mut sunny = tick(0);
    sunny.power_w[0] -= heat_w * SURFACE[0];
    let (mut plain, mut corrected) = (sectors(&config()), sectors(&config()));
    let none = SurfaceCorrection::default();
    let first = SurfaceCorrection { offset_w: heat_w, offset_u_w: 1e-3, ..none };
    corrected.handle(&WindCommand::Correction([first, none, none, none]), PERIOD_S).unwrap();
    let [before, after] = [&mut plain, &mut corrected]
        .map(|anemometer| anemometer.step(&sunny, |element, _| sunny.power_w[element]).unwrap());
    assert!(off(before.wind.wind_m_s, WIND_M_S) > 0.2, "{:?}", before.wind);
    assert!(off(after.wind.wind_m_s, clean.wind.wind_m_s) < 2e-3, "{:?} {:?}", after.wind, clean.wind);
    assert!(after.wind.speed_error_m_s > 1.1 * clean.wind.speed_error_m_s, "{:?}", after.wind);
    // The reported noise is that of the readings.
    assert!((after.variance_w2_k2[0] / clean.variance_w2_k2[0] - 1.0).abs() < 1e-5);
    // The gain of a surface.
    let gain = SurfaceCorrection { gain: 1.0 / dust - 1.0, ..none };
    corrected.handle(&WindCommand::Correction([none, gain, none, none]), PERIOD_S).unwrap();
    corrected.restart();
    let dusty = follow(&mut corrected, &tick(0)).unwrap();
    assert!((dusty.conductance_w_k[1] * dust / clean.conductance_w_k[1] - 1.0).abs() < 1e-6);
    let bad = SurfaceCorrection { offset_w: f32::NAN, ..none };
    let refused = corrected.handle(&WindCommand::Correction([none, none, none, bad]), PERIOD_S).unwrap_err();
    assert_eq!(refused.parameter, Parameter::SurfaceCorrection);
    assert_eq!(corrected.corrections(), Some(&[none, gain, none, none]));
}
