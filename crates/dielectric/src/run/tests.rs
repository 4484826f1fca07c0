//! Runs in this process: what they record, how they end.

use super::*;
use crate::port::DeviceTruth;
use crate::port::PortError;
use crate::port::SymbolShape;
use host_sim::instrument::in_process::InProcess;
use recording::RecordingRow;
use recording::toml_file::TomlSource;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/mems/");

fn experiment(drive: &str, duration_s: f64) -> DeviceExperiment {
    let text = format!(
        "title = \"test\"\ndevice = \"../../heads/devices/mems.toml\"\nsymbol_time_s = 1.0\nduration_s = {duration_s:?}\nseed = 5\n{drive}\n"
    );
    let path = std::path::Path::new(FOLDER).join("test.toml");
    DeviceExperiment::from_source(TomlSource { path, text }).unwrap()
}

const SYMBOLS: &str = "[symbols]\npositive_v = 8.0\nnegative_v = -8.0\nsecond_share = 0.2\n";

fn held(target_v: f64, order: u8) -> String {
    format!("drive = {{ hold = {{ shift_v = {target_v:?}, order = {order} }} }}\n{SYMBOLS}")
}

fn conducted(experiment: &DeviceExperiment, port: &mut dyn DevicePort) -> (DeviceRunSummary, Vec<Vec<f32>>) {
    let mut rows = Vec::new();
    let mut keep = |row: &RecordingRow| {
        rows.push(row.estimate.to_vec());
        Ok(())
    };
    (run(experiment, Box::new(InProcess::new()), port, &mut keep).unwrap(), rows)
}

#[test]
fn both_orders_hold_a_set_point_and_the_summary_has_it() {
    for order in [1, 2] {
        let experiment = experiment(&held(0.25, order), 6000.0);
        let (summary, rows) = conducted(&experiment, &mut experiment.simulated().unwrap());
        assert!(summary.complete, "{summary:?}");
        assert_eq!((summary.ticks, rows.len(), summary.without_reading), (5999, 5999, 0));
        let phase = &summary.phases[0];
        assert!(
            (phase.mean_voltage_shift_v.unwrap() - 0.25).abs() < [0.01, 1e-3][usize::from(order) - 1],
            "{order}: {phase:?}"
        );
        assert!(phase.reached_s.unwrap() > 10.0);
        // The meter's noise, and the squares of a shift that moves between the readings.
        assert!(summary.shift_rms_error_v.unwrap() < 3e-4, "{summary:?}");
    }
}

#[test]
fn a_phase_counts_its_own_symbols_and_no_other() {
    let text = format!(
        "drive = {{ symbol = 1 }}\n{SYMBOLS}[[changes]]\nstart_s = 10.0\ndrive = \"zero\"\n[[changes]]\nstart_s = 20.0\ndrive = {{ symbol = -1 }}\n"
    );
    let experiment = experiment(&text, 30.0);
    let (summary, rows) = conducted(&experiment, &mut experiment.simulated().unwrap());
    let means: Vec<_> = summary.phases.iter().map(|phase| phase.mean_symbol.unwrap()).collect();
    assert_eq!(means, [1.0, 0.0, -1.0]);
    assert_eq!((rows.len(), summary.without_reading), (29, 10));
}

/// A device that fails at its n-th symbol.
struct Failing {
    symbols: u32,
    at: u32,
    is_released: bool,
    released: u32,
}

impl DevicePort for Failing {
    fn apply(&mut self, symbol: Option<ChargeSymbol>, _: &SymbolShape) -> Result<SymbolReadings, PortError> {
        self.symbols += 1;
        if self.symbols == self.at {
            return Err(PortError { sentence: "the meter is gone".to_owned(), is_released: false });
        }
        let capacitance_f = |bias_v: f64| Some(1.2e-12 + 2e-15 * bias_v * bias_v);
        Ok(symbol.map_or([capacitance_f(0.0); 2], |_| [capacitance_f(8.0); 2]))
    }

    fn release(&mut self) -> Result<(), PortError> {
        self.released += 1;
        if self.is_released {
            Ok(())
        } else {
            Err(PortError { sentence: "the meter is gone".to_owned(), is_released: false })
        }
    }

    fn truth(&self) -> Option<DeviceTruth> {
        None
    }
}

#[test]
fn whatever_ends_a_run_the_device_is_released_and_the_rows_are_kept() {
    let experiment = experiment(&held(0.4, 1), 100.0);
    for (is_released, end) in [(true, ""), (false, "; that the bias is 0 V is not certain: take it off by hand")] {
        let mut port = Failing { symbols: 0, at: 20, is_released, released: 0 };
        let (summary, rows) = conducted(&experiment, &mut port);
        assert_eq!((port.released, rows.len(), summary.complete), (1, 19, false));
        assert_eq!(summary.ended.unwrap().to_string(), format!("the meter is gone{end}"));
        // Before the first row there is nothing to keep.
        let mut port = Failing { symbols: 0, at: 1, is_released, released: 0 };
        let error = run(&experiment, Box::new(InProcess::new()), &mut port, &mut |_| Ok(())).unwrap_err();
        assert!(error.to_string().starts_with("the meter is gone"), "{error}");
        assert_eq!(port.released, 1);
    }
    let mut port = Failing { symbols: 0, at: 0, is_released: true, released: 0 };
    let mut rows = 0;
    let interrupted = run(&experiment, Box::new(InProcess::new()), &mut port, &mut |_| {
        rows += 1;
        if rows == 7 { Err(RunError::Interrupted) } else { Ok(()) }
    });
    assert_eq!(interrupted.unwrap().ended.unwrap().to_string(), "interrupted");
    assert_eq!(port.released, 1);
}

#[test]
fn a_set_point_out_of_reach_trips_where_that_is_wanted() {
    let drive = format!("unreachable_after_s = 3000.0\n{}", held(2.4, 1));
    let experiment = experiment(&drive, 8000.0);
    let (summary, _) = conducted(&experiment, &mut experiment.simulated().unwrap());
    assert_eq!(summary.trips[0].cause, "unreachable");
    assert!(!summary.complete);
}

#[test]
fn wrong_files_are_refused_with_their_key() {
    let refused = |drive: &str| {
        let text = format!(
            "title = \"test\"\ndevice = \"../../heads/devices/mems.toml\"\nsymbol_time_s = 1.0\nduration_s = 100.0\n{drive}\n"
        );
        let path = std::path::Path::new(FOLDER).join("test.toml");
        DeviceExperiment::from_source(TomlSource { path, text }).unwrap_err().to_string()
    };
    let of = |symbols: &str| refused(&format!("drive = \"zero\"\n[symbols]\n{symbols}"));
    for (sentence, part) in [
        (
            of("positive_v = 60.0\nnegative_v = -8.0\nsecond_share = 0.2"),
            "`symbols.positive_v` is 60 V: device `mems` bears",
        ),
        (of("positive_v = 8.0\nnegative_v = 9.0\nsecond_share = 0.2"), "must lie below `positive_v`"),
        (of("positive_v = 8.0\nnegative_v = -8.0\nsecond_share = 1.0"), "`symbols.second_share` is 1"),
        (refused(&format!("drive = {{ symbol = 0 }}\n{SYMBOLS}")), "is 0: it is 1 or -1"),
        (refused(&format!("drive = {{ mean_symbol = 1.2 }}\n{SYMBOLS}")), "`drive.mean_symbol` is 1.2"),
        (refused(&format!("drive = {{ hold = {{ shift_v = 99.0 }} }}\n{SYMBOLS}")), "`drive.hold.shift_v` is 99 V"),
        (
            refused(&format!("drive = {{ hold = {{ shift_v = 0.1, order = 3 }} }}\n{SYMBOLS}")),
            "loops are of order 1 or 2",
        ),
        (
            refused(&format!("drive = {{ hold = {{ shift_v = 0.1, gain = 0.2 }} }}\n{SYMBOLS}")),
            "is of a loop of second order",
        ),
        (
            refused(&format!("drive = {{ prbs = {{ order = 9, bit_time_s = 2.5, seed = 1 }} }}\n{SYMBOLS}")),
            "not a whole number",
        ),
    ] {
        assert!(sentence.contains(part), "{part:?} is not in {sentence:?}");
    }
}
