//! Charge in a dielectric is held by the firmware as by this process: the same bits, the same rows.

use anemo_tests::{file, firmware};
use dielectric::experiment::DeviceExperiment;
use dielectric::run::{DeviceRunSummary, run};
use host_sim::instrument::LockStepController;
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::in_process::InProcess;
use recording::toml_file::TomlSource;

fn run_on(experiment: &DeviceExperiment, controller: Box<dyn LockStepController>) -> (DeviceRunSummary, Vec<u32>) {
    let (mut device, mut bits) = (experiment.simulated().unwrap(), Vec::new());
    let summary = run(experiment, controller, &mut device, &mut |row| {
        bits.extend(row.estimate.iter().map(|number| number.to_bits()));
        Ok(())
    });
    (summary.unwrap(), bits)
}

#[test]
fn host_and_emulated_board_hold_a_charge_with_the_same_bits() {
    let mut source = TomlSource::read(&file("experiments/mems/hold.toml")).unwrap();
    let drives = [
        "{ hold = { shift_v = 0.1, order = 1 } }",
        "{ hold = { shift_v = -0.05, order = 2, gain = 0.07 } }",
        "{ prbs = { order = 9, bit_time_s = 3.0, seed = 5 } }",
        "{ mean_symbol = -0.37 }",
    ];
    let shipped = "drive = { hold = { shift_v = 0.25, order = 2 } }";
    assert!(source.text.contains(shipped) && source.text.contains("duration_s = 20000.0"));
    source.text = source.text.replace(shipped, &format!("drive = {}", drives[0])).replace("20000.0", "1600.0");
    for (n, drive) in drives.iter().enumerate().skip(1) {
        source.text += &format!("\n[[changes]]\nstart_s = {:?}\ndrive = {drive}\n", 400.0 * n as f64);
    }
    let experiment = DeviceExperiment::from_source(source).unwrap();
    let (host, rows) = run_on(&experiment, Box::new(InProcess::new()));
    assert!(host.complete && host.ticks == 1599);
    for way in [Way::Fifo, Way::Usart] {
        let (board, of_board) = run_on(&experiment, Box::new(Emulated::start(&firmware(), way).unwrap()));
        assert_eq!((board.hash, of_board.len()), (host.hash.clone(), rows.len()));
        assert!(of_board == rows, "{way:?}");
    }
}
