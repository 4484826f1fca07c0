//! The same run on host and emulated board: bit by bit the same.

use anemo_tests::{changed, emulated, experiment, in_process, start, summary};
use dr_core::sensor::Level;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::instrument::emulated::EmulatorLink as Way;

/// Runs both bodies side by side, each around its own simulated sphere, and stops at the first
/// difference.
fn side_by_side(name: &str, ticks: u32, way: Way) -> u64 {
    both_bodies(&experiment(name), name, ticks, way)
}

fn both_bodies(experiment: &Experiment, name: &str, ticks: u32, way: Way) -> u64 {
    let mut host = in_process(experiment);
    let mut board = emulated(experiment, way);
    start(experiment, &mut *host);
    start(experiment, &mut *board);
    for tick in 0..ticks {
        let (expected, seen) = (host.observe().unwrap(), board.observe().unwrap());
        assert_eq!(expected, seen, "{name}: samples differ at tick {tick}");
        assert_eq!(host.digests(), board.digests(), "{name}: states differ at tick {tick}");
    }
    let account = InstrumentPort::finish(board).unwrap();
    assert_eq!((account.link.lost, account.link.damaged, account.link.repeated), (0, 0, 0));
    host.digests().unwrap().control.value()
}

#[test]
fn one_hundred_thousand_ticks_of_gusts_are_the_same_to_the_bit() {
    let experiment = experiment("gusts.toml");
    assert_eq!(experiment.ticks, 100_000);
    let host = summary(&experiment, in_process(&experiment));
    let board = summary(&experiment, emulated(&experiment, Way::Fifo));
    println!("gusts, 100 000 ticks: host {} board {}", host.hash.as_ref().unwrap(), board.hash.as_ref().unwrap());
    assert_eq!(host.hash, board.hash);
    assert_eq!(host.elements, board.elements);
    assert_eq!((board.ticks, board.lost, board.trips.len()), (100_000, 0, 0));
    // A digest of something: neither nothing nor another wind's.
    let other = changed("gusts.toml", &[("speed_m_s = 1.0", "speed_m_s = 1.001")]);
    assert_ne!(summary(&other, in_process(&other)).hash, host.hash);
}

#[test]
fn every_drive_is_the_same_to_the_bit() {
    let digest = side_by_side("all-drives.toml", 12_000, Way::Fifo);
    println!("all drives, 12 000 ticks: {digest:016x}");
}

#[test]
fn observers_see_the_same_to_the_bit() {
    for (name, ticks) in [("gusts.toml", 20_000), ("still-gas.toml", 5_000)] {
        let observing = changed(name, &[("duration_s", "observe = true\nduration_s")]);
        let observed = both_bodies(&observing, name, ticks, Way::Fifo);
        println!("observing {name}, {ticks} ticks: {observed:016x}");
        // The digest takes in what observers know.
        assert_ne!(observed, side_by_side(name, ticks, Way::Fifo));
    }
}

#[test]
fn the_board_tells_the_margins_that_the_host_knows() {
    let experiment = experiment("still-gas.toml");
    let mut board = emulated(&experiment, Way::Fifo);
    start(&experiment, &mut *board);
    // Statuses come by the emulated clock, which goes on while ticks are exchanged.
    let mut told = None;
    for _ in 0..200_000 {
        board.observe().unwrap();
        told = board
            .body()
            .status()
            .map(|status| status.control.margins.clone())
            .filter(|margins| margins.iter().any(Option::is_some));
        if told.is_some() {
            break;
        }
    }
    let told = told.expect("the board sends a status each second");
    for (i, margins) in told.iter().enumerate() {
        let margins = margins.expect("every element holds a temperature and has a model");
        // 40 mW between the levels, the set-point somewhere in between.
        let between_w = margins.above_low_w + margins.below_high_w;
        assert!(margins.above_low_w > 0.0 && margins.below_high_w > 0.0, "element {i}: {margins:?}");
        let element = &experiment.head.elements[i].config.channel;
        let resistance_ohm = element.platinum().resistance_ohm(-23.15);
        let levels_w = [Level::Low, Level::High].map(|level| element.power_w(resistance_ohm, level));
        assert!((between_w - (levels_w[1] - levels_w[0])).abs() < 1e-8, "element {i}: {margins:?}");
    }
    InstrumentPort::finish(board).unwrap();
}

#[test]
fn the_usart_carries_the_same_run_as_the_fast_link() {
    let usart = side_by_side("gusts.toml", 1_000, Way::Usart);
    assert_eq!(usart, side_by_side("gusts.toml", 1_000, Way::Fifo));
}

#[test]
fn a_millisecond_tick_is_the_same_to_the_bit() {
    side_by_side("still-gas.toml", 5_000, Way::Fifo);
}
