//! A panic, a fault and a full stack in each task while a heater is high: heaters low, restart,
//! tripped, and the crash is recorded.
//!
//! No task can panic (`cargo xtask safety`), so the model has it jump to the panic handler: in its
//! first instruction, and later inside.

use crate::crashes::{after_reset, heat, heating};
use crate::rig::Rig;
use dr_core::control::Cause;
use silicon::machine::Machine;
use silicon::processor::bus::ProcessorBus;
use silicon::processor::nvic::{FIRST_INTERRUPT, SYSTICK};
use silicon::soc::rcc::ResetSource;
use silicon::time::us;
use wire::{Crash, CrashKind};

/// Tasks and their exceptions, as `firmware/src/main.rs` binds them; 0 is the idle loop.
const TASKS: [(&str, u16); 10] = [
    ("idle", 0),
    ("dead_man", FIRST_INTERRUPT + 50),
    ("control", FIRST_INTERRUPT + 10),
    ("estimate", FIRST_INTERRUPT + 53),
    ("receive", FIRST_INTERRUPT + 38),
    ("filled", FIRST_INTERRUPT + 16),
    ("transmit", FIRST_INTERRUPT + 51),
    ("sent", FIRST_INTERRUPT + 17),
    ("health", SYSTICK),
    ("serve_settings", FIRST_INTERRUPT + 36),
];
/// Cycles after the beginning of a task, at the most; some tasks end earlier.
const DEPTHS: [u64; 3] = [0, 60, 400];
/// Heaters have to be low so long after a crash. A task with a full stack may end before it needs
/// any, and what comes next finds it: the next conversion at the latest.
const LOW_WITHIN: u64 = us(300);

/// A place in the RAM that the stack never reaches.
const FREE: u32 = 0x2000_1000;
const FILE: &str = "src/a_task.rs";
const LINE: u32 = 1234;
/// Nothing is there.
const NOWHERE: u32 = 0x3000_0000;

/// Jumps to the panic handler. A `PanicInfo` is two references and two flags, in an order that the
/// compiler chooses: both references are to the place here. The handler looks at nothing else.
pub fn panic(machine: &mut Machine) {
    let place = [FREE + 64, FILE.len() as u32, LINE, 1];
    let words = [FREE + 16, FREE + 16, 0, 0].into_iter().chain(place);
    let bytes: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
    let core = machine.core_mut();
    core.write_memory(FREE, &bytes).unwrap();
    core.write_memory(FREE + 64, FILE.as_bytes()).unwrap();
    core.jump(Rig::function("rust_begin_unwind"), FREE).unwrap();
}

pub fn fault(machine: &mut Machine) {
    machine.core_mut().jump(NOWHERE, 0).unwrap();
}

pub fn fill_stack(machine: &mut Machine) {
    machine.core_mut().set_stack_pointer(0x2000_0010).unwrap();
}

/// Brings a task to its beginning and so many cycles further; false if it has ended by then.
pub fn enter(machine: &mut Machine, exception: u16, depth: u64) -> bool {
    // Something else may just wait that goes first.
    loop {
        while machine.core_mut().handled() != 0 {
            machine.run_for(us(5)).unwrap();
        }
        if exception == 0 {
            break;
        }
        machine.board_mut().nvic().pend(exception);
        // An entry takes longer than a cycle: it stops at the first instruction.
        machine.run_for(1).unwrap();
        if machine.core_mut().handled() == exception {
            break;
        }
    }
    if depth > 0 {
        machine.run_for(depth).unwrap();
    }
    machine.core_mut().handled() == exception
}

/// Does this in every task, and expects this crash.
fn in_each_task(harm: fn(&mut Machine), expected: fn(&Crash) -> bool) {
    let rig = Rig::of(&heating());
    heat(&rig);
    let heated = rig.machine().snapshot().unwrap();
    for ((task, exception), depth) in TASKS.into_iter().flat_map(|task| DEPTHS.map(|depth| (task, depth))) {
        let what = format!("{task}, {depth} cycles inside");
        rig.machine().restore(&heated).unwrap();
        assert_eq!(rig.machine().board().heaters(), 1);
        if !enter(&mut rig.machine(), exception, depth) {
            assert!(depth > 0, "{what}");
            continue;
        }
        let at = rig.machine().now();
        harm(&mut rig.machine());
        rig.machine().run_for(LOW_WITHIN).unwrap();
        assert_eq!(rig.machine().board().heaters(), 0, "{what}");
        let (identity, cause) = after_reset(&rig);
        let low = *rig.machine().pins().last().unwrap();
        assert!(low.levels == 0 && low.cycle <= at + LOW_WITHIN, "{what}: {low:?} after {at}");
        let resets = rig.machine().resets().to_vec();
        assert_eq!(resets.len(), 1, "{what}");
        assert_eq!(resets[0].source, ResetSource::Software, "{what}");
        let crash = identity.crash.unwrap_or_else(|| panic!("{what}: no crash is recorded"));
        assert!(expected(&crash), "{what}: {crash:?}");
        assert_eq!(cause, Some(if crash.kind == CrashKind::Panic { Cause::Panic } else { Cause::Fault }), "{what}");
        rig.assert_no_complaint();
    }
}

#[test]
fn a_panic_in_any_task_lowers_the_heaters_and_is_recorded() {
    in_each_task(panic, |crash| {
        crash.kind == CrashKind::Panic && FILE.ends_with(crash.file.as_str()) && crash.at == LINE
    });
}

#[test]
fn a_fault_in_any_task_lowers_the_heaters_and_is_recorded() {
    in_each_task(fault, |crash| crash.kind == CrashKind::Fault && crash.at == NOWHERE);
}

#[test]
fn a_full_stack_in_any_task_lowers_the_heaters_and_is_recorded() {
    in_each_task(fill_stack, |crash| crash.kind == CrashKind::Fault);
}
