//! What the firmware does wrong today. Each scenario asserts what happens, and says what should; it
//! turns into its opposite as the firmware is mended.

use crate::rig::{Rig, experiment};
use dr_core::Command;
use dr_core::control::RunState;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;
use silicon::complaint::BrokenRule;
use silicon::machine::MachineConfig;
use silicon::time::{ms, us};

/// The watchdog's counter is reloaded while the register of its reload value is still being taken
/// over, at the end of the start. It should wait for RVU.
#[test]
fn the_watchdog_is_reloaded_before_its_new_period_counts() {
    let rig = Rig::new(&MachineConfig::default());
    rig.instrument();
    let machine = rig.machine();
    let complaints = machine.board().complaints.all();
    assert_eq!(complaints.len(), 1);
    assert_eq!((complaints[0].register, complaints[0].rule), ("IWDG_KR", BrokenRule::WatchdogReloadedEarly));
}

/// `Stop` is answered, and standby reported, at once, while the pins follow at the next tick: of a
/// tick of 50 ms they may be high for as long. Pins should fall with the command.
#[test]
fn heaters_stay_high_until_the_next_tick_after_a_stop() {
    let experiment = experiment("held.toml", 10);
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    // A cold sector is heated in every tick; this is just behind one.
    Rig::observe(&mut instrument, 5, |_| {});
    instrument.command(Command::Stop).unwrap();
    rig.machine().run_for(us(1_000)).unwrap();
    assert_eq!(rig.machine().board().witness.state(), Some(RunState::Standby));
    assert_eq!(rig.machine().board().heaters(), 1);
    rig.machine().run_for(ms(50)).unwrap();
    assert_eq!(rig.machine().board().heaters(), 0);
    rig.assert_no_complaint();
}
