//! A machine that is put back goes the same way again.

use crate::rig::{Rig, experiment};
use host_sim::run::start;
use silicon::time::ms;

#[test]
fn a_machine_that_is_restored_does_the_same_to_the_bit() {
    let experiment = experiment("prbs.toml", 100);
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    Rig::observe(&mut instrument, 5, |_| {});
    drop(instrument);
    // In the middle of a conversion, of a frame, of anything.
    let snapshot = rig.machine().snapshot().unwrap();
    let go_on = || {
        let mut machine = rig.machine();
        machine.run_for(ms(300)).unwrap();
        let frames: Vec<_> = machine.board_mut().host.frames().collect();
        (machine.now(), frames, machine.pins().to_vec(), machine.core_mut().ram().unwrap())
    };
    let first = go_on();
    rig.machine().restore(&snapshot).unwrap();
    assert!(first == go_on());
    // In another machine, too.
    let other = Rig::of(&experiment);
    other.machine().restore(&snapshot).unwrap();
    other.machine().run_for(ms(300)).unwrap();
    assert_eq!(other.machine().pins(), first.2);
}
