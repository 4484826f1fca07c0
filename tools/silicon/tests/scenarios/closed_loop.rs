//! Experiments from the host to the sensor and back.

use crate::rig::{Rig, experiment};
use dr_core::control::Drive;
use host_sim::experiment::Experiment;
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentPort, LockStep};
use host_sim::run::{run, start};
use silicon::time::{ms, us};

#[test]
fn an_element_is_held_at_its_temperature() {
    let mut experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 1_000) };
    let warmer_c = experiment.sensor().unwrap().truth().element_temperature_c[0] as f32 + 0.5;
    experiment.drives[0] = Drive::Temperature { target_c: warmer_c };
    let rig = Rig::of(&experiment);
    let mut temperatures_c = Vec::new();
    let summary = run(&experiment, Box::new(rig.instrument()), &mut |row| {
        temperatures_c.push(row.temperature_c[0]);
        Ok(())
    })
    .unwrap();
    assert_eq!((summary.lost, summary.damaged, summary.late), (0, 0, 0));
    rig.assert_no_complaint();
    // 45 mW heat a sector by some 0.3 K/s, so it is there within 5 s. From then on it moves by a
    // tick's heating, and of its mean nothing is left.
    let held = &temperatures_c[500..];
    let mean_c = held.iter().sum::<f32>() / held.len() as f32;
    assert!((mean_c - warmer_c).abs() < 0.01, "{mean_c} for {warmer_c}");
    assert!(held.iter().all(|temperature_c| (temperature_c - warmer_c).abs() < 0.1), "{held:?}");
    // The board says what the simulation knows.
    let truth_c = rig.machine().board().plant.truth().element_temperature_c[0] as f32;
    assert!((truth_c - warmer_c).abs() < 0.1, "{truth_c}");
}

#[test]
fn pseudo_random_bits_are_those_of_a_controller_in_this_process() {
    let experiment = Experiment { sample_period_s: 0.01, ..experiment("prbs.toml", 300) };
    let levels = |instrument: Box<dyn InstrumentPort>| {
        let mut levels = Vec::new();
        run(&experiment, instrument, &mut |row| {
            levels.push(row.heaters);
            Ok(())
        })
        .unwrap();
        levels
    };
    let rig = Rig::of(&experiment);
    let on_silicon = levels(Box::new(rig.instrument()));
    let in_process = levels(Box::new(LockStep::new(InProcess::new(), experiment.sensor().unwrap())));
    assert_eq!(on_silicon.len(), 300);
    assert!(on_silicon == in_process);
    // And the pins are what is said of them: as many changes, each in its tick.
    let changes = in_process.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let pins = rig.machine().pins().len();
    // Pins that fall are written before pins that rise: up to six changes a tick, and at the run's
    // end.
    assert!((changes..=6 * changes + 12).contains(&pins), "{pins} for {changes}");
    rig.assert_no_complaint();
}

#[test]
fn a_run_goes_on_without_a_host_and_is_as_it_was_when_the_host_returns() {
    let experiment = experiment("held.toml", 100);
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    Rig::observe(&mut instrument, 10, |_| {});
    drop(instrument);
    rig.machine().run_for(ms(2_000)).unwrap();
    let mut again = rig.instrument();
    assert_eq!(again.identity().starts, 1);
    let tick = again.observe().unwrap().sample.tick;
    assert!((45..60).contains(&tick), "{tick}");
    Box::new(again).finish().unwrap();
    rig.assert_no_complaint();
}

#[test]
fn the_pins_have_the_levels_that_samples_report() {
    let experiment = Experiment { sample_period_s: 0.01, ..experiment("prbs.toml", 100) };
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    let mut seen = 0;
    // A sample is with the host some two milliseconds after its tick.
    Rig::observe(&mut instrument, 100, |sample| {
        assert_eq!(usize::from(rig.machine().board().heaters()), sample.heaters.0, "tick {}", sample.tick);
        seen |= sample.heaters.0;
    });
    assert_eq!(seen, 0b1111);
    // They change some 70 µs after a conversion is there: in the first of the three periods that
    // the filter needs to forget the level before.
    let machine = rig.machine();
    let (next, period) = (machine.board().adc.next_event(), us(250));
    let ages = machine.pins()[1..].iter().map(|change| period - (next - change.cycle) % period);
    let oldest = ages.max().unwrap();
    assert!((us(30)..us(100)).contains(&oldest), "{oldest}");
    drop(machine);
    rig.assert_no_complaint();
}
