//! Six bodies whose network is known, in a wind that is known. Minutes of them take seconds.

use super::*;
use crate::control::{Drive, ElementConfig, HardwareLimits, Limits, Refusal};
use crate::model::{AlarmConfig, NetworkCrossHeatingConfig};
use crate::sensor::{Channel, Platinum, Reading};
use crate::{Command, Instrument};
use std::sync::OnceLock;
use std::vec::Vec;

const ELEMENTS: usize = 6;
const CAPACITY_J_K: f64 = 0.12;
const LOSS_W_K: f64 = 1e-3;
const WINDLESS_W_K: f32 = 1.7e-4;
const GAS_C: f32 = -53.0;
const PERIOD_S: f32 = 1e-3;
const VOLT_PER_CODE: f32 = 4.0 / 8_388_608.0;
const CURRENT_A: [f32; 2] = [3e-3, 16e-3];
/// Heat enough for 23 K, and for what is lost on the way in nearly quiescent gas.
const WARM_UP_TICKS: u32 = 130_000;

fn answer() -> WindOutputConfig {
    WindOutputConfig {
        surfaces: SECTORS as u8,
        diameter_m: DIAMETER_M,
        reynolds: Some([1.0, 200.0]),
        direction_error_max_rad: 0.5,
        output_interval_ticks: 10,
        reference: None,
        smoothing_s: [0.1, 0.03],
        reference_gas_c: GAS_C,
    }
}

fn channel() -> Channel {
    Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), VOLT_PER_CODE, CURRENT_A[0], CURRENT_A[1]).unwrap()
}

/// Four sectors and two cores, each a body of one capacity and one conductance to where it hangs.
#[derive(Clone)]
struct AnemometerBench {
    instrument: Instrument<ELEMENTS>,
    temperature_c: [f64; ELEMENTS],
    heaters: usize,
    gas_c: f64,
    wind_m_s: [f32; 3],
    absent: usize,
}

impl AnemometerBench {
    /// Held at its set-points. Most want the same one, and its minutes are lived only once.
    fn new(config: &WindOutputConfig) -> Self {
        static WARM: OnceLock<AnemometerBench> = OnceLock::new();
        if *config == answer() { WARM.get_or_init(|| Self::warm(config)).clone() } else { Self::warm(config) }
    }

    fn warm(answer: &WindOutputConfig) -> Self {
        let mut bench = Self::cold(answer);
        let wind_m_s = std::mem::replace(&mut bench.wind_m_s, [0.1, 0.0, 0.0]);
        bench.run(WARM_UP_TICKS);
        Self { wind_m_s, ..bench }
    }

    /// Running for no time yet, after a long standby.
    fn cold(answer: &WindOutputConfig) -> Self {
        let mut instrument = Instrument::new(&HardwareLimits::SIMULATED);
        let mut tell = |command| instrument.handle(command).unwrap();
        tell(Command::SamplePeriod { sample_period_s: PERIOD_S });
        for element in 0..ELEMENTS as u8 {
            tell(Command::Element { element, config: ElementConfig { channel: channel(), limits: Limits::SPHERE_B } });
            tell(Command::Drive { element, drive: Drive::Temperature { target_c: -30.0 } });
            let mut r_k_per_w = [0.0; 8];
            r_k_per_w[0] = (1.0 / LOSS_W_K) as f32;
            let config = NetworkSelfHeatingConfig {
                mesh_rad_s: mesh::geometric((LOSS_W_K / CAPACITY_J_K) as f32, 400.0).unwrap(),
                r_k_per_w,
                surface: [1.0; 8],
                rest_c: GAS_C,
                gains: GainsConfig {
                    correction_w_per_k: [7.0; 8],
                    convection_w_per_k: if usize::from(element) < SECTORS { 0.2 } else { 0.0 },
                    weights: [0.2, 1.0],
                    variance_w2: 1e-8,
                },
                alarm: Some(AlarmConfig { smoothing_s: 0.02, threshold_k: 0.01 }),
            };
            tell(Command::Wind(WindCommand::SelfHeating { element, config }));
        }
        tell(Command::Wind(WindCommand::CrossHeating(NetworkCrossHeatingConfig {
            from: 0,
            to: 1,
            mesh_rad_s: mesh::geometric(0.01, 1.0).unwrap(),
            r_k_per_w: [0.0; 4],
            surface: [1.0; 4],
        })));
        if answer.reynolds.is_some() {
            for (point, amplitudes) in (0_u8..).zip(nusselt().amplitudes) {
                tell(Command::Wind(WindCommand::NusseltPoint { point, amplitudes }));
            }
        }
        for (part, surface) in (0_u8..).zip(sphere::tetrahedral_sectors(DIAMETER_M)) {
            let config = HeadSurface { element: part, surface, gain: 1.0, windless_w_k: WINDLESS_W_K };
            tell(Command::Wind(WindCommand::Surface { surface: part, config }));
        }
        tell(Command::Wind(WindCommand::GasLaw(law())));
        tell(Command::Wind(WindCommand::Output(*answer)));
        tell(Command::Wind(WindCommand::Gas { pressure_pa: 700.0, temperature_c: Some(GAS_C) }));
        tell(Command::Arm { window_s: 1.0 });
        tell(Command::Start);
        Self {
            instrument,
            temperature_c: [f64::from(GAS_C); ELEMENTS],
            heaters: 0,
            gas_c: f64::from(GAS_C),
            wind_m_s: [3.0, -4.0, 1.0],
            absent: 0,
        }
    }

    /// True conductances of the sectors, W/K.
    fn conductances(&self) -> [f64; SECTORS] {
        let gas = GasLaw::new(&law()).unwrap().at(700.0, self.gas_c as f32).unwrap();
        let given = vector().conductances(&gas, self.wind_m_s);
        core::array::from_fn(|i| f64::from(given[i].conductance_w_k))
    }

    fn tick(&mut self) -> Option<WindTick> {
        let platinum = *channel().platinum();
        let readings = core::array::from_fn(|i| {
            if self.absent >> i & 1 == 1 {
                return Reading::Missing;
            }
            let current_a = CURRENT_A[self.heaters >> i & 1];
            let volt = platinum.resistance_ohm(self.temperature_c[i] as f32) * current_a;
            Reading::Code((volt / VOLT_PER_CODE).round() as i32)
        });
        let tick = self.instrument.tick(&readings);
        let told = self.instrument.sense(&tick);
        self.heaters = tick.heaters.0;
        let conductances = self.conductances();
        for (i, temperature_c) in self.temperature_c.iter_mut().enumerate() {
            let windless_w_k = if i < SECTORS { f64::from(WINDLESS_W_K) } else { 0.0 };
            let to_gas_w_k = conductances.get(i).copied().unwrap_or(0.0);
            let lost_w = (LOSS_W_K - windless_w_k) * (*temperature_c - f64::from(GAS_C))
                + to_gas_w_k * (*temperature_c - self.gas_c);
            *temperature_c += f64::from(PERIOD_S) / CAPACITY_J_K * (f64::from(tick.power_w[i]) - lost_w);
        }
        told
    }

    /// The answers of so many ticks.
    fn run(&mut self, ticks: u32) -> Vec<WindTick> {
        (0..ticks).filter_map(|_| self.tick()).collect()
    }
}

/// Mean of the last half of some answers, and the greatest distance from it.
fn mean(told: &[WindTick]) -> [f32; 3] {
    let half = &told[told.len() / 2..];
    core::array::from_fn(|k| half.iter().map(|told| told.wind.wind_m_s[k]).sum::<f32>() / half.len() as f32)
}

#[test]
fn the_wind_is_found_from_bits_and_temperatures() {
    let mut bench = AnemometerBench::new(&answer());
    let told = bench.run(1500);
    let last = told.last().unwrap();
    std::println!("{:?}", last);
    for (found, truth) in last.conductance_w_k.iter().zip(bench.conductances()) {
        assert!((f64::from(*found) / truth - 1.0).abs() < 0.03, "{found} for {truth}");
    }
    let found = mean(&told);
    assert!(off(found, bench.wind_m_s) < 0.1, "{found:?}");
}

#[test]
fn a_changing_gas_is_followed_by_its_given_temperature() {
    let mut bench = AnemometerBench::new(&answer());
    bench.run(1500);
    for step in 1..=20 {
        bench.gas_c = f64::from(GAS_C) + 0.25 * f64::from(step);
        let told = Some(bench.gas_c as f32);
        let gas = Command::Wind(WindCommand::Gas { pressure_pa: 700.0, temperature_c: told });
        bench.instrument.handle(gas).unwrap();
        bench.run(100);
    }
    let found = mean(&bench.run(1000));
    assert!(off(found, bench.wind_m_s) < 0.15, "{found:?}");
}

#[test]
fn what_is_wrong_is_said_in_every_answer() {
    let after = |change: &dyn Fn(&mut AnemometerBench), config: &WindOutputConfig| {
        let mut bench = AnemometerBench::new(config);
        bench.run(1500);
        change(&mut bench);
        *bench.run(200).last().unwrap()
    };
    let good = after(&|_| (), &answer());
    assert_eq!(good.quality_flags, QualityFlags::default(), "{}", good.quality_flags);

    let uncalibrated = after(&|_| (), &WindOutputConfig { reynolds: None, ..answer() });
    assert!(
        uncalibrated.quality_flags.has(QualityFlags::UNCALIBRATED)
            && uncalibrated.quality_flags.has(QualityFlags::FAILED)
    );
    assert!(uncalibrated.conductance_w_k[..SECTORS].iter().all(|&w_k| w_k > 0.0), "conductances need no calibration");

    let gasless = |bench: &mut AnemometerBench| {
        let gas = WindCommand::Gas { pressure_pa: 700.0, temperature_c: None };
        bench.instrument.handle(Command::Wind(gas)).unwrap();
    };
    let gasless = after(&gasless, &answer());
    assert!(gasless.quality_flags.has(QualityFlags::NO_GAS) && gasless.quality_flags.has(QualityFlags::FAILED));
    assert_eq!(gasless.conductance_w_k, [0.0; MOST_SURFACES]);

    // An open element trips the controller; three sectors go on, cooling.
    let open = after(&|bench| bench.absent = 0b10, &answer());
    assert!(
        open.quality_flags.has(QualityFlags::DEGRADED) && open.quality_flags.has(QualityFlags::NOT_RUNNING),
        "{}",
        open.quality_flags
    );
    assert!(!open.quality_flags.has(QualityFlags::FAILED));
    assert!(open.wind.direction_error_rad > 1.1 * good.wind.direction_error_rad, "{}", open.wind.direction_error_rad);

    let stuck = after(
        &|bench| {
            let drive = Drive::Temperature { target_c: 20.0 };
            bench.instrument.handle(Command::Arm { window_s: 1.0 }).unwrap();
            for element in 0..6 {
                bench.instrument.handle(Command::Drive { element, drive }).unwrap();
            }
            bench.run(1200);
        },
        &answer(),
    );
    assert!(stuck.quality_flags.has(QualityFlags::SATURATED), "{}", stuck.quality_flags);

    let mut begins = AnemometerBench::cold(&answer());
    assert!(begins.run(20).last().unwrap().quality_flags.has(QualityFlags::STARTING));
    assert!(!begins.run(500).last().unwrap().quality_flags.has(QualityFlags::STARTING));
}

#[test]
fn on_a_warm_head_it_is_starting_until_the_slowest_rate_has_settled() {
    let mut bench = AnemometerBench::new(&answer());
    for command in [Command::Stop, Command::Arm { window_s: 1.0 }, Command::Start] {
        bench.instrument.handle(command).unwrap();
    }
    // Three times C/G of a body, 360 s.
    let told = bench.run(358_000);
    assert!(told.iter().all(|told| told.quality_flags.has(QualityFlags::STARTING)));
    assert!(!bench.run(4_000).last().unwrap().quality_flags.has(QualityFlags::STARTING));
}

#[test]
fn numbers_that_are_none_make_it_begin_anew() {
    let mut bench = AnemometerBench::new(&answer());
    let mut tick = bench.instrument.tick(&[Reading::Missing; ELEMENTS]);
    tick.valid = 0b11_1111;
    tick.power_w[1] = f32::NAN;
    bench.instrument.sense(&tick);
    let told = bench.run(3000);
    let is_finite = |told: &WindTick| {
        told.conductance_w_k.iter().chain(&told.raw_w_k).chain(&told.wind.wind_m_s).all(|number| number.is_finite())
    };
    assert!(told.iter().all(is_finite));
    assert!(told[0].quality_flags.has(QualityFlags::STARTING));
    assert!(off(mean(&told), bench.wind_m_s) < 0.1, "{:?}", mean(&told));
}

#[test]
fn saturated_is_a_loop_at_one_level_whatever_is_known_of_the_gas() {
    let stuck = |element: u8, then: &dyn Fn(&mut AnemometerBench)| {
        let mut bench = AnemometerBench::new(&answer());
        bench.instrument.handle(Command::Arm { window_s: 1.0 }).unwrap();
        bench.instrument.handle(Command::Drive { element, drive: Drive::Temperature { target_c: 20.0 } }).unwrap();
        then(&mut bench);
        bench.run(1500).last().unwrap().quality_flags
    };
    assert!(stuck(0, &|_| ()).has(QualityFlags::SATURATED));
    assert!(!stuck(5, &|_| ()).has(QualityFlags::SATURATED), "a core does no harm");
    let gas = Command::Wind(WindCommand::Gas { pressure_pa: 700.0, temperature_c: None });
    let gasless = stuck(0, &|bench| assert!(bench.instrument.handle(gas).is_ok()));
    assert!(gasless.has(QualityFlags::SATURATED) && gasless.has(QualityFlags::NO_GAS), "{gasless}");
    let tripped = stuck(0, &|bench| bench.absent = 0b10);
    assert!(tripped.has(QualityFlags::NOT_RUNNING) && !tripped.has(QualityFlags::SATURATED), "{tripped}");
}

#[test]
fn a_part_as_cold_as_the_gas_is_left_out() {
    let mut bench = AnemometerBench::new(&answer());
    bench.run(500);
    bench.gas_c = -31.0;
    let gas = WindCommand::Gas { pressure_pa: 700.0, temperature_c: Some(-30.5) };
    bench.instrument.handle(Command::Wind(gas)).unwrap();
    let told = *bench.run(20).last().unwrap();
    assert!(
        told.quality_flags.has(QualityFlags::COLD) && told.quality_flags.has(QualityFlags::FAILED),
        "{}",
        told.quality_flags
    );
}

#[test]
fn a_reference_that_falls_silent_is_not_believed() {
    let config = WindOutputConfig { reference: Some(5), ..answer() };
    let mut bench = AnemometerBench::new(&config);
    // A core in the place of a thermometer: as cold as the gas, and not heated.
    bench.instrument.handle(Command::Drive { element: 5, drive: Drive::Passive }).unwrap();
    bench.temperature_c[5] = f64::from(GAS_C);
    let told = *bench.run(1000).last().unwrap();
    assert!(
        (told.gas_c - GAS_C).abs() < 2.0 && !told.quality_flags.has(QualityFlags::NO_GAS),
        "{} {}",
        told.gas_c,
        told.quality_flags
    );
    bench.absent = 1 << 5;
    let told = *bench.run(1500).last().unwrap();
    assert!(
        told.quality_flags.has(QualityFlags::NO_GAS) && told.quality_flags.has(QualityFlags::FAILED),
        "{}",
        told.quality_flags
    );
}

#[test]
fn its_head_is_set_up_in_standby_and_piece_by_piece() {
    let mut bench = AnemometerBench::new(&answer());
    let cross = NetworkCrossHeatingConfig {
        from: 0,
        to: 0,
        mesh_rad_s: [1.0, 2.0, 3.0, 4.0],
        r_k_per_w: [0.0; 4],
        surface: [1.0; 4],
    };
    let refused = bench.instrument.handle(Command::Wind(WindCommand::CrossHeating(cross)));
    assert_eq!(refused, Err(Refusal::NotInStandby));
    bench.instrument.handle(Command::Stop).unwrap();
    assert!(matches!(
        bench.instrument.handle(Command::Wind(WindCommand::CrossHeating(cross))),
        Err(Refusal::Invalid { .. })
    ));

    let mut instrument = Instrument::<ELEMENTS>::new(&HardwareLimits::SIMULATED);
    let answer = Command::Wind(WindCommand::Output(answer()));
    assert_eq!(instrument.handle(answer), Err(Refusal::NoSamplePeriod));
    instrument.handle(Command::SamplePeriod { sample_period_s: PERIOD_S }).unwrap();
    let parameter = |refused| match refused {
        Err(Refusal::Invalid { error, .. }) => error.parameter,
        other => panic!("{other:?}"),
    };
    assert_eq!(parameter(instrument.handle(answer)), crate::Parameter::Parts);
}
