//! What the hot paths cost: an image that calls each of them with inputs that cover its ways, for
//! `cargo xtask cost`.
//!
//! A kernel is an uninlined function whose name stands in the table of `tools/xtask/src/cost.rs`; all
//! between call and return is counted. Inputs go through `black_box`, so that the compiler cannot
//! know them. Nothing here is timed: the emulator counts, and needs no clock.

#![no_std]
#![no_main]

#[allow(dead_code, reason = "no file is used here")]
#[path = "../mcu/emulated/semihosting.rs"]
mod semihosting;

use core::hint::black_box;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use dr_core::control::{Controller, Drive, ElementConfig, HardwareLimits, Heaters, Limits, Tick};
use dr_core::model::{
    AlarmConfig, GainsConfig, NetworkCrossHeatingConfig, NetworkSelfHeatingConfig, RelaxationState, Relaxations,
    SelfHeatingConfig, Symbol, mesh,
};
use dr_core::sensor::{Channel, Level, Platinum, Reading};
use dr_core::signal::{Decimator, DecimatorState, Prbs, SigmaDelta};
use dr_core::wind::{
    self, CalibrationUncertainty, ConvectionConfig, GasLawConfig, GasState, HeadForm, HeadSurface, MOST_SURFACES,
    MeasuredConductance, NusseltConfig, RiseConfig, StemConfig, WindCommand, WindEstimate, WindOutputConfig, WindState,
    WindVector,
};
use dr_core::{Command, Decider, Estimated, Estimator, Handover};
use semihosting::exit;
// For the table of interrupts, of which none is used.
use stm32f4xx_hal as _;

/// Of the sensor board's controller; the virtual board's has room for 16.
const ELEMENTS: usize = 6;
const SAMPLE_PERIOD_S: f32 = 0.01;
/// Of the ADC: 4 V full scale, 24 bit.
const VOLT_PER_CODE: f32 = 4.0 / 8_388_608.0;
const CURRENT_LOW_A: f32 = 3e-3;
const CURRENT_HIGH_A: f32 = 16e-3;
/// Long enough for every drive to change its mind, short enough for a log of every instruction.
const CONTROL_TICKS: u32 = 400;
/// Output interval of the wind estimate, ticks.
const OUTPUT_INTERVAL: u16 = 10;

type OfSectors = [Option<MeasuredConductance>; MOST_SURFACES];

/// Makes kernels of functions: none is inlined, and each keeps its name in the image.
macro_rules! kernels {
    ($($(#[$about:meta])* fn $name:ident($($argument:ident: $kind:ty),*) -> $result:ty { $body:expr })*) => {
        $($(#[$about])*
        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $name($($argument: $kind),*) -> $result {
            $body
        })*
    };
}

// A `black_box` keeps the linker from merging a kernel with one of the same code.
kernels! {
    /// One compensated step of 8 relaxations, and the temperature that they amount to.
    fn relaxations_8_poles(
        poles: &Relaxations<8>, symbol: &Symbol<8>, state: &mut RelaxationState<8>, input: f32
    ) -> f32 {{
        poles.step(state, input);
        symbol.output(state)
    }}

    /// All that the control task decides in a tick.
    fn control_6_elements(controller: &mut Controller<6>, readings: &[Reading; 6]) -> Tick<6> {
        controller.tick(readings)
    }

    /// The same while the observers run.
    fn control_6_elements_observing(controller: &mut Controller<6>, readings: &[Reading; 6]) -> Tick<6> {
        black_box(controller).tick(readings)
    }

    /// Six elements on a controller that has room for more.
    fn control_6_of_16(controller: &mut Controller<16>, readings: &[Reading; 16]) -> Tick<16> {
        controller.tick(readings)
    }

    /// Thirteen elements.
    fn control_13_of_16(controller: &mut Controller<16>, readings: &[Reading; 16]) -> Tick<16> {
        black_box(controller).tick(readings)
    }

    fn platinum_linear(platinum: &Platinum, resistance_ohm: f32) -> f32 { platinum.temperature_c(resistance_ohm) }

    fn platinum_iec60751(platinum: &Platinum, resistance_ohm: f32) -> f32 {
        black_box(platinum).temperature_c(resistance_ohm)
    }

    fn prbs_step(register: &mut Prbs) -> bool { register.step() }

    fn sigma_delta_step(modulator: &mut SigmaDelta, delta: f32) -> bool { modulator.step(delta) }

    fn decimator_push(decimator: &Decimator<2>, state: &mut DecimatorState<2>, power_w: f32) -> Option<f32> {
        decimator.push(state, power_w)
    }

    /// The wind from the conductances of four sectors.
    fn wind_4_sectors(head: &WindVector, state: &mut WindState, gas: &GasState, measured: &OfSectors) -> WindEstimate {
        head.step(state, gas, measured)
    }

    /// The wind from the three that are left, or that are known well.
    fn wind_3_sectors(head: &WindVector, state: &mut WindState, gas: &GasState, measured: &OfSectors) -> WindEstimate {
        black_box(head).step(state, gas, measured)
    }

    /// Cost of a tick's estimate to the control task: the handover to the other task.
    fn handover_6_elements(decider: &Decider<ELEMENTS>, tick: &Tick<ELEMENTS>) -> Handover<ELEMENTS> {
        decider.handover(tick, false)
    }

    /// The anemometer's half of a tick: quiescent-gas network of six elements with all
    /// cross-heating, and the wind of four sectors in every tick.
    fn anemometer_6_elements(estimator: &mut Estimator<ELEMENTS>, handover: &Handover<ELEMENTS>) -> Estimated {
        estimator.take(handover)
    }

    /// The same in ticks without an output.
    fn anemometer_between_outputs(estimator: &mut Estimator<ELEMENTS>, handover: &Handover<ELEMENTS>) -> Estimated {
        black_box(estimator).take(handover)
    }
}

/// Every kernel, or nothing if a configuration is refused.
fn measure() -> Option<()> {
    let relaxations = Relaxations::new(&mesh::geometric(0.003, 30.0).ok()?, SAMPLE_PERIOD_S).ok()?;
    let symbol = Symbol::new([600.0, 20.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1]).ok()?;
    let mut state = RelaxationState::default();
    for n in 0..20 {
        let input = if n % 3 == 0 { 0.0415 } else { 0.0015 };
        black_box(relaxations_8_poles(black_box(&relaxations), black_box(&symbol), &mut state, black_box(input)));
    }

    let linear = Platinum::linear(175.0, 0.0031).ok()?;
    let iec60751 = Platinum::iec60751(100.0).ok()?;
    for n in 0..50 {
        let temperature_c = -100.0 + 4.0 * n as f32;
        black_box(platinum_linear(black_box(&linear), black_box(linear.resistance_ohm(temperature_c))));
        black_box(platinum_iec60751(black_box(&iec60751), black_box(iec60751.resistance_ohm(temperature_c))));
    }

    let mut register = Prbs::new(31, 1).ok()?;
    let mut modulator = SigmaDelta::default();
    let decimator = Decimator::<2>::new(16).ok()?;
    let mut decimated = DecimatorState::default();
    for _ in 0..64 {
        black_box(prbs_step(&mut register));
        let bit = black_box(sigma_delta_step(&mut modulator, black_box(0.3)));
        black_box(decimator_push(black_box(&decimator), &mut decimated, if bit { 0.0415 } else { 0.0015 }));
    }
    wind()?;
    anemometer()?;
    control(6, false, control_6_elements)?;
    control(6, true, control_6_elements_observing)?;
    control(6, false, control_6_of_16)?;
    control(13, false, control_13_of_16)
}

/// Wiring and limits of every element.
fn element() -> Option<ElementConfig> {
    let platinum = Platinum::linear(175.0, 0.0031).ok()?;
    let channel = Channel::new(platinum, VOLT_PER_CODE, CURRENT_LOW_A, CURRENT_HIGH_A).ok()?;
    Some(ElementConfig { channel, limits: Limits::SPHERE_B })
}

/// What the ADC reads of an element.
fn reading(config: &ElementConfig, temperature_c: f32, is_high: bool) -> Reading {
    let current_a = if is_high { CURRENT_HIGH_A } else { CURRENT_LOW_A };
    Reading::Code((config.channel.platinum().resistance_ohm(temperature_c) * current_a / VOLT_PER_CODE) as i32)
}

/// Of the sphere on which the wind is counted.
const DIAMETER_M: f32 = 0.01;

/// a_0 and a_1 of about the right size; for what it costs no more is needed.
fn nusselt() -> NusseltConfig {
    let mut root = 1.0;
    let amplitudes = core::array::from_fn(|_| {
        root *= 1.089;
        [2.0 + 0.53 * root, 0.55 * root, 0.01 * root, -0.02 * root, 0.01 * root, 0.0]
    });
    NusseltConfig { least_reynolds: 1.0, most_reynolds: 200.0, amplitudes }
}

/// A sphere of 10 mm in carbon dioxide of 700 Pa and 220 K.
fn sphere_in_gas() -> Option<(WindVector, GasState)> {
    let surfaces = wind::sphere::tetrahedral_sectors(DIAMETER_M);
    let vector = WindVector::new(HeadForm::Sphere, &nusselt(), &surfaces, DIAMETER_M, 0.5).ok()?;
    Some((vector, GasState::new(0.0168, 11.05e-6, 10.84e-3).ok()?))
}

/// No wind, where the steps are most, and winds of 1 to 11 m/s from all sides.
fn wind() -> Option<()> {
    let surfaces = wind::sphere::tetrahedral_sectors(DIAMETER_M);
    let (vector, gas) = sphere_in_gas()?;
    let mut state = WindState::default();
    let mut sign = 1.0;
    for n in 0..12_u8 {
        let speed = f32::from(n);
        let part = &surfaces[usize::from(n % 4)];
        let direction = [part.axis[0] + 0.3, 0.7 * part.axis[1], part.axis[2] - 0.2];
        let mut measured = vector.conductances(&gas, direction.map(|x| 0.6 * speed * x)).map(|given| {
            let error = 1e-3 * given.conductance_w_k;
            sign = -sign;
            Some(MeasuredConductance {
                conductance_w_k: given.conductance_w_k + sign * error,
                variance_w2_k2: error * error,
            })
        });
        black_box(wind_4_sectors(black_box(&vector), &mut state, black_box(&gas), black_box(&measured)));
        let mut uneven = measured;
        if let Some(part) = &mut uneven[1] {
            part.variance_w2_k2 *= 1e6;
        }
        black_box(wind_3_sectors(black_box(&vector), &mut state, black_box(&gas), black_box(&uneven)));
        measured[1] = None;
        black_box(wind_3_sectors(black_box(&vector), &mut state, black_box(&gas), black_box(&measured)));
    }
    Some(())
}

/// Six elements with all cross-heating, held by their loops on simple bodies in a wind.
fn anemometer() -> Option<()> {
    const PARTS: u8 = 4;
    const CAPACITY_J_K: f32 = 0.12;
    const LOSS_W_K: f32 = 1e-3;
    const QUIESCENT_W_K: f32 = 1.7e-4;
    const GAS_C: f32 = -53.0;
    let mut decider = Decider::<ELEMENTS>::new(&HardwareLimits::SENSOR_BOARD);
    let mut estimator = Estimator::<ELEMENTS>::default();
    let mut send = |command| {
        let mut done = Some(());
        decider
            .handle(command, |handover| done = estimator.take(&handover).reply.map_or(done, |of| of.ok().map(drop)))
            .ok()?;
        done
    };
    send(Command::SamplePeriod { sample_period_s: 1e-3 })?;
    let config = element()?;
    for element in 0..ELEMENTS as u8 {
        send(Command::Element { element, config })?;
        send(Command::Drive { element, drive: Drive::Temperature { target_c: -30.0 } })?;
        let config = NetworkSelfHeatingConfig {
            // The body's own pole, and others that cost as much and do nothing.
            mesh_rad_s: mesh::geometric(LOSS_W_K / CAPACITY_J_K, 400.0).ok()?,
            r_k_per_w: [1.0 / LOSS_W_K, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            surface: [1.0; 8],
            rest_c: GAS_C,
            gains: GainsConfig {
                correction_w_per_k: [7.0; 8],
                convection_w_per_k: if element < PARTS { 0.2 } else { 0.0 },
                weights: [0.2, 1.8],
                variance_w2: 1e-8,
            },
            alarm: Some(AlarmConfig { smoothing_s: 0.02, threshold_k: 0.01 }),
        };
        send(Command::Wind(WindCommand::SelfHeating { element, config }))?;
    }
    for (from, to) in (0..ELEMENTS as u8).flat_map(|from| (0..ELEMENTS as u8).map(move |to| (from, to))) {
        if from != to {
            let config = NetworkCrossHeatingConfig {
                from,
                to,
                mesh_rad_s: mesh::geometric(0.003, 1.0).ok()?,
                r_k_per_w: [0.0; 4],
                surface: [1.0; 4],
            };
            send(Command::Wind(WindCommand::CrossHeating(config)))?;
        }
    }
    let NusseltConfig { least_reynolds, most_reynolds, amplitudes } = nusselt();
    for (point, amplitudes) in (0_u8..).zip(amplitudes) {
        send(Command::Wind(WindCommand::NusseltPoint { point, amplitudes }))?;
    }
    for (part, surface) in (0_u8..).zip(wind::sphere::tetrahedral_sectors(DIAMETER_M)) {
        let config = HeadSurface { element: part, surface, gain: 1.0, windless_w_k: QUIESCENT_W_K };
        send(Command::Wind(WindCommand::Surface { surface: part, config }))?;
    }
    send(Command::Wind(WindCommand::GasLaw(GasLawConfig {
        gas_constant_j_kg_k: 188.9,
        least_c: -120.0,
        most_c: 100.0,
        viscosity_pa_s: [11.05e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        conductivity_w_m_k: [10.84e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    })))?;
    send(Command::Wind(WindCommand::Uncertainty(CalibrationUncertainty {
        conductance_share: [1e-3; 4],
        speed_share: [2e-3; 4],
        direction_rad: [2e-3; 4],
        chi_square_most: 7.0,
    })))?;
    send(Command::Wind(WindCommand::Convection(ConvectionConfig {
        film_share: 0.5,
        nusselt_at_rest: 2.0,
        slowest_reynolds: least_reynolds,
        gas_c: [GAS_C, GAS_C],
        speed_share_per_k: 1e-3,
        direction_rad_per_k: 1e-3,
        rise: Some(RiseConfig { gravity_m_s2: 3.71, up: [0.0, 0.0, 1.0], at_rest: 0.61, decay: 1.22 }),
        stem: Some(StemConfig {
            axis: [0.0, 0.0, -1.0],
            unknown_chord: 0.3,
            factor: [0.8, 0.82, 0.87, 0.93, 0.98, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
            deflection: [0.4, 0.38, 0.34, 0.25, 0.13, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        }),
    })))?;
    send(Command::Wind(WindCommand::Output(WindOutputConfig {
        surfaces: PARTS,
        diameter_m: DIAMETER_M,
        reynolds: Some([least_reynolds, most_reynolds]),
        direction_error_max_rad: 0.5,
        output_interval_ticks: OUTPUT_INTERVAL,
        reference: None,
        smoothing_s: [1.0, 0.1],
        reference_gas_c: GAS_C,
    })))?;
    send(Command::Wind(WindCommand::Gas { pressure_pa: 700.0, temperature_c: Some(GAS_C) }))?;
    send(Command::Arm { window_s: 1.0 })?;
    send(Command::Start)?;

    let (vector, gas) = sphere_in_gas()?;
    let mut temperature_c = [-30.0_f32; ELEMENTS];
    let mut heaters = Heaters::default();
    for n in 0..CONTROL_TICKS {
        let readings = core::array::from_fn(|i| reading(&config, temperature_c[i], heaters.is_high(i)));
        let conductances = vector.conductances(&gas, [3.0, -4.0 + 0.005 * n as f32, 1.0]);
        let tick = decider.tick(black_box(&readings));
        let handover = handover_6_elements(black_box(&decider), black_box(&tick));
        heaters = tick.heaters;
        let outputs = n % u32::from(OUTPUT_INTERVAL) == 0;
        let sense = if outputs { anemometer_6_elements } else { anemometer_between_outputs };
        black_box(sense(black_box(&mut estimator), black_box(&handover)));
        for (i, (temperature, power_w)) in temperature_c.iter_mut().zip(tick.power_w).enumerate() {
            let wind_w_k = conductances
                .get(i)
                .filter(|_| i < wind::sphere::SECTORS)
                .map_or(0.0, |of| of.conductance_w_k - QUIESCENT_W_K);
            *temperature += 1e-3 / CAPACITY_J_K * (power_w - (LOSS_W_K + wind_w_k) * (*temperature - GAS_C));
        }
    }
    Some(())
}

/// The six drives in turn, one an element, each with its model, on simple bodies; readings fail and
/// at last trip the guard.
fn control<const N: usize>(
    elements: usize,
    observe: bool,
    tick: fn(&mut Controller<N>, &[Reading; N]) -> Tick<N>,
) -> Option<()> {
    let mut controller = Controller::<N>::new(&HardwareLimits::SENSOR_BOARD);
    controller.handle(Command::SamplePeriod { sample_period_s: SAMPLE_PERIOD_S }).ok()?;
    controller.handle(Command::Observe { on: observe }).ok()?;
    let config = element()?;
    let model = SelfHeatingConfig {
        mesh_rad_s: mesh::geometric(0.003, 30.0).ok()?,
        r_k_per_w: [600.0, 20.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1],
        reference_c: -50.0,
    };
    let drives = [
        Drive::Passive,
        Drive::Level(Level::High),
        Drive::Power { power_w: 0.01 },
        Drive::Temperature { target_c: -30.0 },
        Drive::Prbs { order: 10, seed: 1, ticks_per_bit: 2 },
        Drive::Setpoints { low_c: -45.0, high_c: -35.0, dwell_ticks: 50, seed: 1 },
    ];
    for (element, &drive) in (0_u8..).zip(drives.iter().cycle()).take(elements) {
        controller.handle(Command::Element { element, config }).ok()?;
        controller.handle(Command::Model { element, model }).ok()?;
        controller.handle(Command::Drive { element, drive }).ok()?;
    }
    controller.handle(Command::Arm { window_s: 1.0 }).ok()?;
    controller.handle(Command::Start).ok()?;

    let mut temperature_c = [-50.0_f32; N];
    let mut heaters = Heaters::default();
    for n in 0..CONTROL_TICKS {
        let readings = core::array::from_fn(|i| match (n % 100, i) {
            (98, 3) => Reading::Missing,
            (99, 4) => Reading::Stale,
            _ if n + 1 == CONTROL_TICKS && i == 5 => Reading::Code(i32::MAX >> 8),
            _ => reading(&config, temperature_c[i], heaters.is_high(i)),
        });
        let tick = tick(black_box(&mut controller), black_box(&readings));
        heaters = tick.heaters;
        for (temperature, power_w) in temperature_c.iter_mut().zip(tick.power_w) {
            *temperature += 0.02 * (-50.0 + 600.0 * power_w - *temperature);
        }
    }
    Some(())
}

#[entry]
fn main() -> ! {
    exit(measure().is_none().into())
}

#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    exit(1)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    exit(1)
}
