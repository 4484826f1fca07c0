//! Experiments of the thesis on the emulated board: row by row what the controller in this process
//! records.

use anemo_tests::{changed, emulated, experiment, in_process};
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::instrument::emulated::EmulatorLink as Way;
use host_sim::run::RunSummary;
use host_sim::run::{RunError, run};

/// A run with all its rows, as bits.
fn recorded(experiment: &Experiment, instrument: Box<dyn InstrumentPort>) -> (RunSummary, Vec<Vec<u32>>, Vec<String>) {
    let (mut rows, mut labels) = (Vec::new(), Vec::new());
    let summary = run(experiment, instrument, &mut |row| {
        let bits = row.temperature_c.iter().chain(row.power_w).map(|value| value.to_bits());
        rows.push(bits.chain([row.heaters as u32]).collect());
        labels.push(format!("{} {}", row.event, row.state));
        Ok::<(), RunError>(())
    });
    (summary.expect("the run comes to its end"), rows, labels)
}

fn the_same_on_both(name: &str, experiment: &Experiment) {
    let (host, host_rows, host_labels) = recorded(experiment, in_process(experiment));
    let (board, board_rows, board_labels) = recorded(experiment, emulated(experiment, Way::Fifo));
    println!(
        "{name}, {} ticks: host {} board {}",
        host.ticks,
        host.hash.as_ref().unwrap(),
        board.hash.as_ref().unwrap()
    );
    assert_eq!(host_rows.len(), experiment.ticks as usize);
    let differs = host_rows.iter().zip(&board_rows).position(|(host, board)| host != board);
    assert_eq!((differs, host_rows.len()), (None, board_rows.len()), "{name}: the first row that differs");
    assert_eq!(host_labels, board_labels);
    assert_eq!(host.hash, board.hash);
    assert!(host.hash.is_some());
    assert_eq!(host.elements, board.elements);
    assert_eq!((board.ticks, board.lost, board.trips.len()), (experiment.ticks, 0, 0));
    // Something was heated, and by more than one level.
    let heated = host_rows.iter().filter(|row| row[row.len() - 1] & 1 == 1).count();
    assert!(heated > 100 && heated < host_rows.len() - 100, "{name}: the first element is high in {heated} ticks");
}

#[test]
fn self_heating_of_a_die() {
    the_same_on_both("rems-self-still", &experiment("thesis/rems-self-still.toml"));
}

#[test]
fn a_die_held_in_the_linear_tunnel() {
    let experiment = experiment("thesis/rems-loop-wind.toml");
    assert!(experiment.wind.len() > 4);
    the_same_on_both("rems-loop-wind", &experiment);
}

#[test]
fn pseudo_random_heat_for_sphere_b() {
    let shorter = [
        ("duration_s = 3600.0", "duration_s = 240.0"),
        ("start_s = 1200.0", "start_s = 80.0"),
        ("start_s = 2400.0", "start_s = 160.0"),
    ];
    the_same_on_both("sphere-b-prbs", &changed("thesis/sphere-b-prbs.toml", &shorter));
}
