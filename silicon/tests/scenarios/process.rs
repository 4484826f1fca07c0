//! A board in a process of its own, as `anemo run … --on silicon` has it.

use crate::rig::{Rig, experiment, image};
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::instrument::virtual_line;
use host_sim::run::run;
use silicon::machine::MachineConfig;
use std::path::Path;

#[test]
fn a_board_in_another_process_gives_the_rows_of_one_in_this_process() {
    let experiment = experiment("prbs.toml", 40);
    let rows = |experiment: &Experiment, instrument: Box<dyn InstrumentPort>| {
        let mut rows = Vec::new();
        let summary = run(experiment, instrument, &mut |row| {
            rows.push((row.heaters, row.temperature_c.to_vec(), row.power_w.to_vec()));
            Ok(())
        });
        assert_eq!(summary.unwrap().lost, 0);
        rows
    };
    let program = Path::new(env!("CARGO_BIN_EXE_anemo-silicon"));
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/prbs.toml");
    let there = rows(&experiment, Box::new(virtual_line::start(program, &image(), &file).unwrap()));
    let sensor = experiment.sensor_config().unwrap();
    let rig = Rig::new(&MachineConfig { sensor, ..MachineConfig::default() });
    let here = rows(&experiment, Box::new(rig.instrument()));
    assert_eq!(here.len(), 40);
    assert!(there == here);
}

#[test]
fn a_program_that_cannot_be_started_is_named() {
    let nowhere = Path::new("/nowhere/anemo-silicon");
    let error = virtual_line::start(nowhere, &image(), Path::new("e.toml")).err().unwrap().to_string();
    assert!(error.starts_with("the simulated board /nowhere/anemo-silicon cannot be started"), "{error}");
}
