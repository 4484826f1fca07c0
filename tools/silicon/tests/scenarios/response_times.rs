//! Times of the tasks: measured ones are those of the table of tasks, and the longest paths through
//! the image are longer, but not by much.

use crate::rig::{Rig, image};
use crate::wind;
use dr_core::Command;
use dr_core::control::Drive;
use host_sim::run::start;
use image_analysis::bounds::PATHS;
use image_analysis::code::ImageCode;
use image_analysis::paths::{MemoryModel, Paths};
use image_analysis::source_places::SourcePlaces;
use image_analysis::tasks::{EXCEPTION_CYCLES, TASKS, Takes};
use silicon::machine::MachineConfig;
use silicon::processor::nvic::FIRST_INTERRUPT;
use silicon::time::{ms, us};
use std::collections::BTreeMap;
use wire::{MAX_FRAME, ToBoard, encode};

const CONTROL: u16 = FIRST_INTERRUPT + 10;
const DEAD_MAN: u16 = FIRST_INTERRUPT + 50;
const SUPPLY_LOW: u16 = FIRST_INTERRUPT + 1;
/// A longest path is at most so many times what was observed.
const LARGEST_RATIO: f64 = 3.0;

/// Ticks of a millisecond with six elements, models and the wind in each, and commands at all
/// moments of a tick. The time of the set-up does not count: no heater is high then.
fn longest_of_a_run() -> BTreeMap<u16, u64> {
    let experiment = wind::experiment(0.001);
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    rig.machine().core_mut().forget_handler_times();
    for n in 0..600_u16 {
        let drive = Drive::Temperature { target_c: 20.0 + f32::from(n % 7) };
        let command = match n % 2 {
            0 => Command::Arm { window_s: 2.0 },
            _ => Command::Drive { element: (n % 6) as u8, drive },
        };
        let mut buffer = [0; MAX_FRAME];
        rig.machine().board_mut().receive(encode(1_000 + n, &ToBoard::Command(command), &mut buffer).unwrap());
        rig.machine().run_for(us(1_000 + 7 * u64::from(n % 143))).unwrap();
        rig.machine().board_mut().pins.clear();
    }
    let longest = rig.machine().handler_times().clone();
    rig.assert_no_complaint();
    longest
}

/// The dead-man timer expires as it is proved at the start, and the supply falls.
fn longest_of_priority_6() -> BTreeMap<u16, u64> {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().run_for(ms(1_500)).unwrap();
    rig.machine().dip(2_880, ms(1)).unwrap();
    rig.machine().run_for(ms(10)).unwrap();
    rig.machine().handler_times().clone()
}

#[test]
fn tasks_take_no_longer_than_their_table_says() {
    let run = longest_of_a_run();
    println!("cycles at most in a run: {run:?}");
    for work in TASKS {
        if let Takes::Measured { exception, cycles } = work.takes {
            let measured = run.get(&exception).copied().unwrap_or(0);
            println!("{}: {measured} of {cycles} cycles", work.name);
            assert!(
                measured <= cycles,
                "{} takes {measured} cycles: put them into tools/image-analysis/src/tasks.rs",
                work.name
            );
        }
    }
    let elf = std::fs::read(image()).unwrap();
    let (code, places) = (ImageCode::read(&image()).unwrap(), SourcePlaces::read(&elf).unwrap());
    let priority_6 = longest_of_priority_6();
    for (name, observed) in [
        ("dead_man", priority_6.get(&DEAD_MAN)),
        ("supply_low", priority_6.get(&SUPPLY_LOW)),
        ("control: tick and a command", run.get(&CONTROL)),
    ] {
        let observed = *observed.unwrap_or_else(|| panic!("{name} was not executed"));
        let path = PATHS.iter().find(|path| path.name == name).unwrap();
        let longest = Paths::new(&code, &places, path.rules, MemoryModel::Immediate).longest(path.vector).unwrap();
        let ratio = (longest + EXCEPTION_CYCLES) as f64 / observed as f64;
        println!("{name}: {longest} cycles by analysis, {observed} observed with entry and return, ratio {ratio:.2}");
        assert!((1.0..=LARGEST_RATIO).contains(&ratio), "{name}: {ratio:.2}");
    }
}
