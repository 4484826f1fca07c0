//! Random lives of a controller: whatever it is told and given to read, in whatever order, the
//! invariant of the heaters holds after every tick, and what is refused changes nothing. What
//! exactly, says [`anemo_tests::fuzz::watched`].
//!
//! The lives are the same every time (`SEED`). One that ends badly is made as short as possible and
//! printed; it belongs into a unit test then. For lives of any length, found by what they reach:
//! `cargo xtask fuzz command`.

use anemo_tests::fuzz::command::{element, set_up};
use anemo_tests::fuzz::watched::{ELEMENTS, Watched};
use dr_core::Command;
use dr_core::control::controller::bit_flips::FLIPPABLE;
use dr_core::control::{Drive, ElementConfig, EnergyLimit, GuardConfig, Limits, RunState, SelfTestPlan};
use dr_core::model::SelfHeatingConfig;
use dr_core::sensor::{Channel, Level, Platinum, Reading};
use dr_core::wind::{WindCommand, WindOutputConfig};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const SEED: u64 = 20_261_122;
/// Lives, and steps of one: a few seconds.
const LIVES: u32 = 3_000;
const STEPS: usize = 60;

fn lives() -> ProptestConfig {
    ProptestConfig {
        cases: LIVES,
        rng_seed: RngSeed::Fixed(SEED),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Step of a controller's life.
#[derive(Debug, Clone)]
enum Step {
    Tell(Command),
    /// So many ticks with these readings.
    Tick(u8, [Read; ELEMENTS]),
    /// A bit flips.
    Upset(usize, usize, u32),
}

/// Reading of an element.
#[derive(Debug, Clone, Copy)]
enum Read {
    /// So far between its limits of resistance.
    Between(f64),
    Code(i32),
    Stale,
    Missing,
}

/// A number that somebody might send for one between these.
fn number(least: f32, most: f32) -> impl Strategy<Value = f32> {
    let special = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        f32::EPSILON,
        0.0,
        -0.0,
        1e-40,
        -1e30,
    ];
    prop_oneof![20 => least..most, 1 => proptest::sample::select(special.to_vec()), 1 => any::<f32>()]
}

fn count(most: u32) -> impl Strategy<Value = u32> {
    prop_oneof![8 => 0..most, 1 => Just(u32::MAX), 1 => any::<u32>()]
}

/// An element; mostly one that there is.
fn which() -> impl Strategy<Value = u8> {
    prop_oneof![12 => 0..ELEMENTS as u8, 1 => any::<u8>()]
}

fn drive() -> impl Strategy<Value = Drive> {
    prop_oneof![
        Just(Drive::Passive),
        Just(Drive::Level(Level::High)),
        Just(Drive::Level(Level::Low)),
        number(0.002, 0.03).prop_map(|power_w| Drive::Power { power_w }),
        number(-60.0, 60.0).prop_map(|target_c| Drive::Temperature { target_c }),
        (0..35_u8, any::<u32>(), count(4)).prop_map(|(order, seed, ticks_per_bit)| Drive::Prbs {
            order,
            seed,
            ticks_per_bit
        }),
        (number(-60.0, 0.0), number(0.0, 60.0), count(9), any::<u32>())
            .prop_map(|(low_c, high_c, dwell_ticks, seed)| Drive::Setpoints { low_c, high_c, dwell_ticks, seed }),
        (number(-60.0, 0.0), number(0.0, 60.0), count(9)).prop_map(|(low_c, high_c, half_ticks)| Drive::Alternation {
            low_c,
            high_c,
            half_ticks
        }),
    ]
}

/// Elements whose numbers no constructor has seen, as they come over a link: by their postcard
/// encoding.
fn config() -> impl Strategy<Value = ElementConfig> {
    let numbers =
        (number(10.0, 1000.0), number(0.001, 0.01), number(1e-8, 1e-5), number(1e-3, 4e-3), number(4e-3, 0.1));
    let limits = (number(1.0, 100.0), number(100.0, 300.0), number(0.0, 250.0), any::<i32>(), any::<bool>());
    let energy = (number(1e-4, 0.1), number(1e-4, 10.0), any::<bool>());
    (numbers, limits, energy).prop_map(|(numbers, limits, (sustained_power_w, energy_j, any_energy))| {
        let ((r0, alpha, volt, low, high), (least, most, hottest, code_max, any_code)) = (numbers, limits);
        let good = element();
        let code_max = if any_code { code_max } else { good.limits.code_max };
        let limits = Limits {
            resistance_min_ohm: least,
            resistance_max_ohm: most,
            temperature_max_c: hottest,
            code_max,
            energy: any_energy.then_some(EnergyLimit { sustained_power_w, energy_j }),
        };
        let mut bytes = [0; 64];
        let length = postcard::to_slice(&good.channel, &mut bytes).expect("there is room").len();
        for (number, other) in [(175.0_f32, r0), (0.0031, alpha), (4.768e-7, volt), (3e-3, low), (16e-3, high)] {
            let place = bytes.windows(4).position(|bytes| bytes == number.to_le_bytes()).expect("it is in there");
            bytes[place..place + 4].copy_from_slice(&other.to_le_bytes());
        }
        ElementConfig { channel: postcard::from_bytes(&bytes[..length]).unwrap_or(good.channel), limits }
    })
}

fn good_config() -> impl Strategy<Value = ElementConfig> {
    (50.0_f32..500.0, 1e-3_f32..4e-3, 5e-3_f32..0.05).prop_map(|(r0, low_a, high_a)| {
        let platinum = Platinum::iec60751(r0).expect("a resistor");
        let channel = Channel::new(platinum, 4.768e-7, low_a, high_a).expect("a channel");
        let limits = Limits { resistance_min_ohm: 0.5 * r0, resistance_max_ohm: 1.5 * r0, ..element().limits };
        ElementConfig { channel, limits }
    })
}

fn model() -> impl Strategy<Value = SelfHeatingConfig> {
    (number(-90.0, 30.0), number(0.0, 1000.0), number(0.001, 0.1)).prop_map(|(reference_c, r, slowest)| {
        let mesh_rad_s = std::array::from_fn(|k| slowest * 3_f32.powi(k as i32));
        SelfHeatingConfig { mesh_rad_s, r_k_per_w: std::array::from_fn(|k| r / (1.0 + k as f32)), reference_c }
    })
}

fn wind() -> impl Strategy<Value = WindCommand> {
    let answer = (0..6_u8, number(0.005, 0.05), 0..9_u16, number(-90.0, 30.0));
    prop_oneof![
        (number(1.0, 1e5), proptest::option::of(number(-90.0, 40.0)))
            .prop_map(|(pressure_pa, temperature_c)| WindCommand::Gas { pressure_pa, temperature_c }),
        (any::<u8>(), number(-1.0, 1.0))
            .prop_map(|(point, amplitude)| WindCommand::NusseltPoint { point, amplitudes: [amplitude; 6] }),
        answer.prop_map(|(parts, diameter_m, output_interval_ticks, reference_gas_c)| WindCommand::Output(
            WindOutputConfig {
                surfaces: parts,
                diameter_m,
                reynolds: None,
                direction_error_max_rad: 1.0,
                output_interval_ticks,
                reference: None,
                smoothing_s: [1.0; 2],
                reference_gas_c,
            }
        )),
    ]
}

fn self_test() -> impl Strategy<Value = SelfTestPlan> {
    (proptest::option::of(number(0.05, 0.5)), any::<Option<u32>>())
        .prop_map(|(pulse_s, unix_s)| SelfTestPlan { pulse_s, unix_s })
}

fn command() -> impl Strategy<Value = Command> {
    prop_oneof![
        1 => Just(Command::Clear),
        2 => number(0.001, 0.1).prop_map(|sample_period_s| Command::SamplePeriod { sample_period_s }),
        2 => (count(5), count(50), count(20)).prop_map(|(missing_limit_ticks, unreachable_limit_ticks, stuck_limit_ticks)| {
            Command::Guard(GuardConfig { missing_limit_ticks, unreachable_limit_ticks, stuck_limit_ticks })
        }),
        3 => (which(), config()).prop_map(|(element, config)| Command::Element { element, config }),
        3 => (which(), good_config()).prop_map(|(element, config)| Command::Element { element, config }),
        3 => (which(), model()).prop_map(|(element, model)| Command::Model { element, model }),
        8 => (which(), drive()).prop_map(|(element, drive)| Command::Drive { element, drive }),
        6 => number(0.01, 600.0).prop_map(|window_s| Command::Arm { window_s }),
        1 => Just(Command::Disarm),
        6 => Just(Command::Start),
        2 => Just(Command::Stop),
        4 => Just(Command::Acknowledge),
        1 => any::<bool>().prop_map(|on| Command::Observe { on }),
        2 => wind().prop_map(Command::Wind),
        4 => self_test().prop_map(Command::SelfTest),
    ]
}

fn read() -> impl Strategy<Value = Read> {
    let extreme = [0, 1, -1, i32::MAX, i32::MIN, i32::MIN + 1, 8_388_606, 8_388_607, -8_388_608];
    prop_oneof![
        // Not too hot for the limit of temperature.
        150 => (0.05..0.75_f64).prop_map(Read::Between),
        1 => (-0.1..1.1_f64).prop_map(Read::Between),
        1 => proptest::sample::select(extreme.to_vec()).prop_map(Read::Code),
        1 => any::<i32>().prop_map(Read::Code),
        3 => Just(Read::Stale),
        3 => Just(Read::Missing),
    ]
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        12 => command().prop_map(Step::Tell),
        12 => (1..9_u8, [read(), read(), read()]).prop_map(|(times, of)| Step::Tick(times, of)),
        1 => quiet(),
    ]
}

/// The number of ticks that a self-test looks at, at rest.
fn quiet() -> impl Strategy<Value = Step> {
    (190..255_u8, 0.05..0.75_f64).prop_map(|(times, share)| Step::Tick(times, [Read::Between(share); ELEMENTS]))
}

/// An armed self-test with a pulse and time enough for it, and the ticks after.
fn tested() -> impl Strategy<Value = [Step; 5]> {
    (number(0.05, 0.2), quiet(), step()).prop_map(|(pulse_s, quiet, then)| {
        let plan = SelfTestPlan { pulse_s: Some(pulse_s), unix_s: None };
        let commands = [Command::Stop, Command::Arm { window_s: 5.0 }, Command::SelfTest(plan)].map(Step::Tell);
        let [stop, arm, test] = commands;
        [stop, arm, test, quiet, then]
    })
}

/// The same, and now and then a bit flips.
fn harmed() -> impl Strategy<Value = Step> {
    prop_oneof![
        30 => step(),
        1 => (0..FLIPPABLE, 0..ELEMENTS, 0..32_u32).prop_map(|(what, element, bit)| Step::Upset(what, element, bit)),
    ]
}

/// Account of a life.
#[derive(Debug, Default, Clone, Copy)]
struct Account {
    taken: u32,
    refused: u32,
    heated_ticks: u32,
    pulse_ticks: u32,
    trips: u32,
    upsets: u32,
}

fn live(steps: &[Step], is_set_up: bool) -> Account {
    let (mut watched, mut account) = (Watched::new(), Account::default());
    if is_set_up {
        set_up(&mut watched);
    }
    for step in steps {
        match step {
            Step::Tell(command) => match watched.tell(*command) {
                Ok(_) => account.taken += 1,
                Err(_) => account.refused += 1,
            },
            Step::Upset(what, element, bit) => {
                watched.upset(*what, *element, *bit);
            }
            Step::Tick(times, of) => {
                for _ in 0..*times {
                    let readings = std::array::from_fn(|i| match of[i] {
                        Read::Between(share) => Reading::Code(watched.code(i, share)),
                        Read::Code(code) => Reading::Code(code),
                        Read::Stale => Reading::Stale,
                        Read::Missing => Reading::Missing,
                    });
                    let tick = watched.tick(&readings);
                    account.heated_ticks += u32::from(tick.heaters.0 != 0);
                    account.pulse_ticks += u32::from(tick.heaters.0 != 0 && tick.state == RunState::Testing);
                    account.trips += u32::from(tick.trip.is_some());
                    assert!(tick.trip.is_none() || tick.state != RunState::Running);
                }
            }
        }
    }
    account.upsets = watched.station().controller().bit_flips();
    account
}

proptest! {
    #![proptest_config(lives())]

    #[test]
    fn no_heater_is_high_without_a_reason_whatever_is_said_and_read(
        steps in prop::collection::vec(step(), 1..STEPS),
        is_set_up in prop::bool::weighted(0.7),
    ) {
        let account = live(&steps, is_set_up);
        prop_assert_eq!(account.upsets, 0, "nothing has flipped");
    }

    #[test]
    fn nor_in_a_self_test(tests in prop::collection::vec(tested(), 1..4)) {
        live(&tests.into_iter().flatten().collect::<Vec<_>>(), true);
    }

    #[test]
    fn nor_when_bits_flip_in_between(steps in prop::collection::vec(harmed(), 1..STEPS), is_set_up in prop::bool::weighted(0.7)) {
        live(&steps, is_set_up);
    }
}

/// Lives in which nothing is ever heated, or nothing ever refused, would show nothing.
#[test]
fn these_lives_go_through_all_that_there_is() {
    use proptest::strategy::ValueTree as _;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::new(lives());
    let strategy = (prop::collection::vec(harmed(), 1..STEPS), prop::bool::weighted(0.7));
    let mut sum = Account::default();
    let tests = prop::collection::vec(tested(), 3);
    for _ in 0..100 {
        let steps: Vec<Step> = tests.new_tree(&mut runner).expect("a life").current().into_iter().flatten().collect();
        sum.pulse_ticks += live(&steps, true).pulse_ticks;
    }
    for _ in 0..400 {
        let (steps, is_set_up) = strategy.new_tree(&mut runner).expect("a life").current();
        let account = live(&steps, is_set_up);
        sum.taken += account.taken;
        sum.refused += account.refused;
        sum.heated_ticks += account.heated_ticks;
        sum.trips += account.trips;
        sum.upsets += account.upsets;
    }
    println!("{sum:?}");
    assert!(sum.pulse_ticks > 500);
    assert!(sum.taken > 1_000 && sum.refused > 1_000 && sum.heated_ticks > 1_000 && sum.trips > 100 && sum.upsets > 20);
}
