//! A board in a process of its own, as `anemo run … --on silicon` has it.

use crate::rig::{Rig, experiment, image};
use crate::settings::every;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::instrument::virtual_line::{self, VirtualBoardFiles};
use host_sim::run::run;
use host_sim::settings;
use silicon::machine::MachineConfig;
use std::path::Path;

#[test]
fn a_board_in_another_process_gives_the_rows_of_one_in_this_process() {
    let experiment = experiment("prbs.toml", 40);
    let rows = |experiment: &Experiment, instrument: Box<dyn InstrumentPort>| {
        let mut rows = Vec::new();
        let summary = run(experiment, instrument, &mut |row| {
            rows.push((row.heaters, row.temperature_c.to_vec(), row.power_w.to_vec(), row.true_wind_m_s.unwrap()));
            Ok(())
        });
        assert_eq!(summary.unwrap().lost, 0);
        rows
    };
    let program = Path::new(env!("CARGO_BIN_EXE_anemo-silicon"));
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/prbs.toml");
    let (firmware, flash) = (image(), None);
    let files = VirtualBoardFiles { firmware: &firmware, experiment: Some(&file), flash };
    let there = rows(&experiment, Box::new(virtual_line::start(program, &files).unwrap()));
    let sensor = experiment.sensor_config().unwrap();
    let rig = Rig::new(&MachineConfig { sensor, ..MachineConfig::default() });
    let here = rows(&experiment, Box::new(rig.instrument()));
    assert_eq!(here.len(), 40);
    assert!(there == here);
}

#[test]
fn what_a_board_in_another_process_keeps_is_there_in_the_next_one() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    let program = Path::new(env!("CARGO_BIN_EXE_anemo-silicon"));
    let firmware = image();
    let files = VirtualBoardFiles { firmware: &firmware, experiment: None, flash: Some(&flash) };
    let mut first = virtual_line::start(program, &files).unwrap();
    settings::write(&mut first, &every(3)).unwrap();
    drop(first);
    let mut again = virtual_line::start(program, &files).unwrap();
    assert_eq!(settings::read_all(&mut again).unwrap().settings, Ok(every(3)));
}

#[test]
fn a_program_that_cannot_be_started_is_named() {
    let nowhere = Path::new("/nowhere/anemo-silicon");
    let files = VirtualBoardFiles { firmware: &image(), experiment: None, flash: None };
    let error = virtual_line::start(nowhere, &files).err().unwrap().to_string();
    assert!(error.starts_with("the simulated board /nowhere/anemo-silicon cannot be started"), "{error}");
}
