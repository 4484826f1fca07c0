//! A calibrated head on the emulated board, in process, and off line over the recording: the same
//! answers, bit by bit.

use std::path::{Path, PathBuf};

use anemo_tests::calibrated::{blown, blown_with, head};
use anemo_tests::{emulated, in_process};
use anemometry::head::Head;
use dr_core::control::Drive;
use dr_core::wind::slow_errors::SurfaceCorrection;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::instrument::emulated::EmulatorLink as Way;
use host_sim::run::RunSummary;
use host_sim::run::{RunError, run};
use recording::Recording;
use recording::wind::{QUALITY_FLAGS, columns};

/// A gust in the middle, so that the answers are not all of one wind.
const GUST: (&str, &str) =
    ("azimuth_deg = 225.0", "azimuth_deg = 225.0\n\n[[wind]]\nstart_s = 1.5\nspeed_m_s = 9.0\nazimuth_deg = 100.0");

/// A run with its answers, as bits.
fn answered(experiment: &Experiment, instrument: Box<dyn InstrumentPort>) -> (RunSummary, Vec<Vec<u32>>) {
    let mut rows = Vec::new();
    let summary = run(experiment, instrument, &mut |row| {
        rows.push(row.estimate.iter().map(|number| number.to_bits()).collect());
        Ok::<(), RunError>(())
    });
    (summary.expect("the run comes to its end"), rows)
}

#[test]
fn board_and_host_answer_alike() {
    let experiment = blown(4.0, &[GUST]).experiment();
    let (host, host_rows) = answered(&experiment, in_process(&experiment));
    let (board, board_rows) = answered(&experiment, emulated(&experiment, Way::Fifo));
    println!("host {} board {}", host.wind_hash.as_ref().unwrap(), board.wind_hash.as_ref().unwrap());
    let differs = host_rows.iter().zip(&board_rows).position(|(host, board)| host != board);
    assert_eq!((differs, host_rows.len()), (None, board_rows.len()), "the first row that differs");
    let hashes = |of: &RunSummary| [of.hash.clone().unwrap(), of.wind_hash.clone().unwrap()];
    assert_eq!(hashes(&host), hashes(&board));
    assert_eq!((board.ticks, board.lost, board.late), (4000, 0, 0));
    let (own, its) = (host.wind.unwrap(), board.wind.unwrap());
    assert_eq!((own.estimates, &own), (400, &its));
    // Answers of something: a speed between the two winds, and none without a vector once it has
    // begun.
    assert!((4.0..10.0).contains(&own.mean_speed_m_s.unwrap()), "{own:?}");
    // A digest of something: not that of another wind.
    let other = blown(4.0, &[]).experiment();
    assert_ne!(answered(&other, in_process(&other)).0.wind_hash, host.wind_hash);
}

/// The fixture with corrections of its surfaces.
fn corrected(folder: &Path) -> PathBuf {
    let head = Head::read(&head()).expect("the calibrated head can be read");
    let of = |offset_w: f32, gain: f32| SurfaceCorrection { offset_w, gain, offset_u_w: 2e-4, gain_u: 0.01 };
    let corrections = [of(3e-3, 0.0), of(0.0, 0.05), of(-1e-3, -0.02), of(0.0, 0.0)];
    let calibration = head.calibration.as_ref().expect("it is calibrated");
    let (text, _) = calibration.with_corrections(&corrections, "a test", None, &head).expect("they can be");
    let path = folder.join("corrected.toml");
    std::fs::write(&path, text).expect("there is room");
    path
}

#[test]
fn a_head_with_corrections_and_overheats_that_alternate_are_alike_on_board_host_and_off_line() {
    let folder = tempfile::tempdir().unwrap();
    let alternation = (
        "[[wind]]\nstart_s = 0.0",
        "[overheat_alternation]\nlow_k = 20.0\nhigh_k = 22.0\nhalf_s = 0.7\n\n[[wind]]\nstart_s = 0.0",
    );
    let desk = blown_with(&corrected(folder.path()), 3.0, &[alternation]);
    let experiment = desk.experiment();
    assert!(matches!(experiment.drives[0], Drive::Alternation { half_ticks: 700, .. }), "{:?}", experiment.drives);
    let (host, host_rows) = answered(&experiment, in_process(&experiment));
    let (board, board_rows) = answered(&experiment, emulated(&experiment, Way::Fifo));
    assert_eq!((host.hash == board.hash, host.wind_hash.is_some()), (true, true));
    assert_eq!((host.wind_hash == board.wind_hash, host_rows == board_rows), (true, true));
    // Corrections of something: another wind than without them.
    let plain = blown(3.0, &[alternation]).experiment();
    let (_, plain_rows) = answered(&plain, in_process(&plain));
    assert_ne!(plain_rows, host_rows);
    for arguments in
        [&["run", "e.toml", "--on", "sim", "-o", "r.parquet"][..], &["wind", "r.parquet", "-o", "w.parquet"]]
    {
        let output = desk.anemo(arguments, &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let conductances = |name: &str| {
        Recording::read(&desk.path().join(name)).unwrap().numbers("conductance_w_k_sector1").unwrap().to_vec()
    };
    let kept: Vec<f64> = conductances("r.parquet").into_iter().filter(|of| of.is_finite()).collect();
    let told: Vec<f64> = conductances("w.parquet").into_iter().filter(|of| of.is_finite()).collect();
    assert_eq!((kept.len() > 200, &kept), (true, &told));
}

#[test]
fn off_line_the_answers_have_the_bits_of_the_run() {
    let desk = blown(4.0, &[GUST]);
    for arguments in
        [&["run", "e.toml", "--on", "sim", "-o", "r.parquet"][..], &["wind", "r.parquet", "-o", "w.parquet"]]
    {
        let output = desk.anemo(arguments, &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let read = |name: &str| Recording::read(&desk.path().join(name)).unwrap();
    let (run, told) = (read("r.parquet"), read("w.parquet"));
    let parts = desk.experiment().surfaces();
    let has_answer: Vec<bool> =
        run.numbers(QUALITY_FLAGS).unwrap().iter().map(|quality_flags| quality_flags.is_finite()).collect();
    assert_eq!(has_answer.iter().filter(|has| **has).count(), 400);
    for name in columns(&parts) {
        let kept = run.numbers(&name).unwrap().iter().zip(&has_answer).filter(|(_, has)| **has);
        // Numbers of the board are f32. A missing one is as good as another.
        let bits = |number: &f64| if number.is_nan() { None } else { Some((*number as f32).to_bits()) };
        let (kept, told): (Vec<_>, Vec<_>) =
            (kept.map(|(number, _)| bits(number)).collect(), told.numbers(&name).unwrap().iter().map(bits).collect());
        let differs = kept.iter().zip(&told).position(|(kept, told)| kept != told);
        assert_eq!((differs, kept.len()), (None, told.len()), "{name}");
        assert!(kept.iter().any(Option::is_some), "{name} is empty");
    }
}
