//! Heads of other sizes than the sphere's six, as lists of elements without any sensor around them:
//! host and emulated board alike.

use anemo_tests::{experiment, firmware, sensor};
use dr_core::Command;
use dr_core::control::{self, Drive, ElementConfig, GuardConfig, Heaters, Limits, Refusal, RunState};
use dr_core::model::{SelfHeatingConfig, mesh};
use dr_core::sensor::{Channel, Level, Platinum, Reading};
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentError, InstrumentPort, LockStep, LockStepController, setup};
use wire::MOST_ELEMENTS;

const VOLT_PER_CODE: f32 = 4.0 / 8_388_608.0;
const GAS_C: f32 = -50.0;

/// So many elements, the drives in turn, each with a model.
fn head(elements: usize, observe: bool) -> Vec<Command> {
    let platinum = Platinum::linear(175.0, 0.0031).unwrap();
    let channel = Channel::new(platinum, VOLT_PER_CODE, 3e-3, 16e-3).unwrap();
    let drives = [
        Drive::Temperature { target_c: -30.0 },
        Drive::Power { power_w: 0.01 },
        Drive::Prbs { order: 10, seed: 1, ticks_per_bit: 2 },
        Drive::Setpoints { low_c: -45.0, high_c: -35.0, dwell_ticks: 50, seed: 1 },
        Drive::Level(Level::High),
        Drive::Passive,
    ];
    let mut commands = vec![Command::SamplePeriod { sample_period_s: 0.01 }, Command::Guard(GuardConfig::default())];
    commands.extend(observe.then_some(Command::Observe { on: true }));
    for i in 0..elements {
        let element = i as u8;
        let model = SelfHeatingConfig {
            mesh_rad_s: mesh::geometric(0.003, 30.0).unwrap(),
            r_k_per_w: [600.0 + i as f32, 20.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1],
            reference_c: GAS_C,
        };
        commands.extend([
            Command::Element { element, config: ElementConfig { channel, limits: Limits::SPHERE_B } },
            Command::Model { element, model },
            Command::Drive { element, drive: drives[i % drives.len()] },
        ]);
    }
    commands
}

/// A body set up for a head and running. The sensor is only there because an instrument has one: no
/// time passes for it.
fn running<B: LockStepController>(body: B, head: &[Command]) -> LockStep<B> {
    let mut instrument = LockStep::new(body, sensor(&experiment("gusts.toml")));
    setup::start(&mut instrument, head).unwrap();
    instrument
}

/// One first-order body an element, each of its own, in °C.
struct Bodies(Vec<f32>);

impl Bodies {
    fn read(&self, heaters: Heaters, tick: u32) -> Vec<Reading> {
        let read = |(i, &temperature_c): (usize, &f32)| match (tick % 100, i % 8) {
            (98, 3) => Reading::Missing,
            (99, 4) => Reading::Stale,
            _ => {
                let current_a = if heaters.is_high(i) { 16e-3 } else { 3e-3 };
                Reading::Code((175.0 * (1.0 + 0.0031 * temperature_c) * current_a / VOLT_PER_CODE) as i32)
            }
        };
        self.0.iter().enumerate().map(read).collect()
    }

    fn live(&mut self, power_w: &[f32]) {
        for (i, (temperature_c, power_w)) in self.0.iter_mut().zip(power_w).enumerate() {
            *temperature_c += (0.01 + 0.001 * i as f32) * (GAS_C + 600.0 * power_w - *temperature_c);
        }
    }
}

/// Both bodies side by side, up to the first difference.
fn side_by_side(elements: usize, observe: bool, ticks: u32, way: Way) -> u64 {
    let head = head(elements, observe);
    let mut host = running(InProcess::new(), &head);
    let mut board = running(Emulated::start(&firmware(), way).unwrap(), &head);
    assert_eq!(usize::from(board.identity().elements), MOST_ELEMENTS);
    let (mut bodies, mut heaters, mut ever_high) = (Bodies(vec![GAS_C; elements]), Heaters::default(), 0);
    for tick in 0..ticks {
        let readings = bodies.read(heaters, tick);
        let told = host.body_mut().exchange(&readings).unwrap();
        assert_eq!(told, board.body_mut().exchange(&readings).unwrap(), "{elements} elements, tick {tick}");
        assert_eq!(host.body().digests(), board.body().digests(), "{elements} elements: states differ at tick {tick}");
        assert_eq!((told.sample.tick, told.sample.state), (tick, RunState::Running));
        assert_eq!((told.sample.temperature_c.len(), told.sample.power_w.len()), (elements, elements));
        assert_eq!(told.equivalent_power_w.map(|list| list.len()), observe.then_some(elements));
        heaters = told.sample.heaters;
        ever_high |= heaters.0;
        bodies.live(&told.sample.power_w);
    }
    // All but the passive ones have heated, to the last.
    let passive = (0..elements).filter(|i| i % 6 == 5).fold(0, |mask, i| mask | 1 << i);
    assert_eq!(ever_high, ((1 << elements) - 1) & !passive);
    let account = InstrumentPort::finish(Box::new(board)).unwrap();
    assert_eq!((account.link.lost, account.link.damaged, account.link.repeated), (0, 0, 0));
    host.body().digests().control.value()
}

#[test]
fn thirteen_elements_are_the_same_to_the_bit() {
    let plain = side_by_side(13, false, 10_000, Way::Fifo);
    println!("13 elements, 10 000 ticks: {plain:016x}");
    assert_ne!(side_by_side(13, true, 10_000, Way::Fifo), plain);
}

#[test]
fn one_and_four_and_sixteen_elements_are_the_same_to_the_bit() {
    for elements in [1, 4, MOST_ELEMENTS] {
        for observe in [false, true] {
            side_by_side(elements, observe, 2_000, Way::Fifo);
        }
    }
}

/// A controller with all the room of a host.
fn roomy() -> InProcess<{ control::MOST_ELEMENTS }> {
    InProcess::with_room()
}

#[test]
fn sixty_four_elements_run_in_process() {
    const ELEMENTS: usize = control::MOST_ELEMENTS;
    let mut host = running(roomy(), &head(ELEMENTS, true));
    let (mut bodies, mut heaters) = (Bodies(vec![GAS_C; ELEMENTS]), Heaters::default());
    let (mut ever_high, mut ever_low) = (0, 0);
    for tick in 0..2_000 {
        let told = host.body_mut().exchange(&bodies.read(heaters, tick)).unwrap();
        assert_eq!((told.sample.state, told.sample.power_w.len()), (RunState::Running, ELEMENTS));
        heaters = told.sample.heaters;
        ever_high |= heaters.0;
        ever_low |= !heaters.0;
        bodies.live(&told.sample.power_w);
    }
    let of_drive = |drive: usize| (0..ELEMENTS).filter(|i| i % 6 == drive).fold(0, |mask, i| mask | 1 << i);
    // Drive 4 asks for the high level all the time, 5 for none.
    assert_eq!((ever_high, ever_low | of_drive(4)), (!of_drive(5), usize::MAX));
}

#[test]
fn room_for_more_elements_changes_no_digest() {
    let head = head(13, true);
    let (mut narrow, mut wide) = (running(InProcess::new(), &head), running(roomy(), &head));
    let (mut bodies, mut heaters) = (Bodies(vec![GAS_C; 13]), Heaters::default());
    for tick in 0..2_000 {
        let readings = bodies.read(heaters, tick);
        let told = narrow.body_mut().exchange(&readings).unwrap();
        assert_eq!(told, wide.body_mut().exchange(&readings).unwrap());
        assert_eq!(narrow.body().digests(), wide.body().digests());
        heaters = told.sample.heaters;
        bodies.live(&told.sample.power_w);
    }
}

#[test]
fn the_usart_carries_sixteen_elements() {
    assert_eq!(side_by_side(16, true, 500, Way::Usart), side_by_side(16, true, 500, Way::Fifo));
}

#[test]
fn the_board_tells_margins_of_as_many_elements_as_it_has() {
    let mut board = running(Emulated::start(&firmware(), Way::Fifo).unwrap(), &head(13, false));
    let bodies = Bodies(vec![GAS_C; 13]);
    let mut heaters = Heaters::default();
    // Statuses come by the emulated clock, which goes on while ticks are exchanged.
    let margins = (0..200_000).find_map(|tick| {
        heaters = board.body_mut().exchange(&bodies.read(heaters, tick)).unwrap().sample.heaters;
        board.body().status().map(|status| status.control.margins.clone()).filter(|margins| !margins.is_empty())
    });
    let known: Vec<bool> = margins.unwrap().iter().map(Option::is_some).collect();
    // Drives 0 and 3 of 6 hold a temperature.
    assert_eq!(known, (0..13).map(|i| i % 3 == 0 && i % 6 != 5).collect::<Vec<_>>());
    InstrumentPort::finish(Box::new(board)).unwrap();
}

#[test]
fn more_elements_than_there_can_be_are_refused_and_so_is_a_gap() {
    let refused = |instrument: &mut dyn InstrumentPort| {
        let error = setup::start(instrument, &head(MOST_ELEMENTS + 1, false)).unwrap_err();
        assert_eq!(error.to_string(), "the head has 17 elements, the board can drive 16");
        let head = head(1, false);
        let config = head.iter().find_map(|command| match command {
            Command::Element { config, .. } => Some(*config),
            _ => None,
        });
        instrument.command(Command::Stop).unwrap();
        instrument.command(Command::Clear).unwrap();
        let error = instrument.command(Command::Element { element: 1, config: config.unwrap() }).unwrap_err();
        assert!(matches!(error, InstrumentError::Refused(Refusal::NotConfigured { element: 0 })), "{error}");
    };
    let mut host = running(InProcess::new(), &head(13, false));
    refused(&mut host);
    let mut board = running(Emulated::start(&firmware(), Way::Fifo).unwrap(), &head(13, false));
    refused(&mut board);
    InstrumentPort::finish(Box::new(board)).unwrap();
    let readings = [Reading::Code(0); MOST_ELEMENTS + 1];
    let error = host.body_mut().exchange(&readings).unwrap_err();
    assert!(matches!(error, InstrumentError::TooManyElements { head: 17, board: 16 }), "{error}");
}
