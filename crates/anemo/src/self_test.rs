//! `anemo self-test`: has an instrument test itself, and reports what it found.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{SystemTime, UNIX_EPOCH};

use dr_core::control::self_test::plan::PULSE_LEAST_TICKS;
use dr_core::control::{SelfTestFault, SelfTestPlan};

use crate::instrument::{InstrumentArguments, On, OpenBoard};
use crate::output::{Failure, warn};
use crate::progress::{on_interrupt, progress};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentPort, setup};
use host_sim::self_test::{self, SelfTestReport, StoredSelfTests, currents};
use host_sim::settings;

/// Test an instrument: offsets, references, elements, noise.
///
/// The response of each element to a short pulse of heat is a part of the test.
/// Without an experiment the instrument keeps the set-up of its settings. The pulse is compared
/// with the element's model, where the experiment names one. A board keeps the result in its flash,
/// with date and firmware; it also tests itself, without heat, at each start.
///
/// With --currents it measures the ratio of the two currents of each element instead, from a minute
/// of random heat at 1 kHz. If the ratio is off by 1 000 ppm, readings at the high level are off
/// against those at the low one by 0.3 K; no loop, network or calibration bears that. With -o the
/// head is written with the currents that go with what was found.
#[derive(clap::Args)]
#[command(after_help = "\
Verdicts, and what to look at:
  offset, reference      the converter, its supply, its reference voltage
  continuity             the element's four wires (why: in brackets)
  noise, frozen          shielding and ground; a converter that repeats itself
  no-response, response  heater's current, loose element, model of another head
  levels                 the two currents, as the head's file has them
  crossed                heaters that are not where their sensors are
  interrupted            the instrument has tripped (why: in brackets)

Verdicts of --currents, within 10 ppm:
  off                    write the head with -o, or measure the currents
  uncertain, unknown     more seconds, less wind, a cooler head

Exit code 0: pass, or a head written by -o with all ratios known;
1: at least one fault.

Examples:
  anemo self-test experiments/gusts.toml --on sim
  anemo self-test experiments/gusts.toml --on serial:/dev/ttyACM0 --pulse 0.5
  anemo self-test --on serial:/dev/ttyACM0 --no-heat
  anemo self-test --on serial:/dev/ttyACM0 --stored
  anemo self-test experiments/gusts.toml --on sim --currents -o head.toml")]
pub struct Arguments {
    /// The experiment whose head, sample period and models the instrument gets: a TOML file.
    experiment: Option<PathBuf>,
    #[command(flatten)]
    instrument: InstrumentArguments,
    /// Length of the pulse of heat, s, from 8 ticks to 10 s; by default 1 s, or 8 ticks if longer.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pulse: Option<f32>,
    /// Heat nothing; tests a tripped instrument, too.
    #[arg(long, conflicts_with = "pulse")]
    no_heat: bool,
    /// Test nothing: show the result that the board keeps.
    #[arg(long, conflicts_with_all = ["pulse", "no_heat"])]
    stored: bool,
    /// Measure the ratio of the two currents of each element, at 1 kHz.
    #[arg(long, requires = "experiment", conflicts_with_all = ["pulse", "no_heat", "stored"])]
    currents: bool,
    /// How long --currents heats, s, 3 to 600.
    #[arg(long, value_name = "S", default_value_t = 60, requires = "currents",
        value_parser = clap::value_parser!(u32).range(3..=600))]
    seconds: u32,
    /// Write the head with the currents that --currents has found to this .toml file.
    #[arg(short, long = "output-file", value_name = "FILE", requires = "currents")]
    output: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

/// Length of the pulse unless another is asked for, s.
const PULSE_S: f32 = 1.0;

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let experiment = arguments
        .experiment
        .as_deref()
        .map(|path| crate::output::read_experiment(path, arguments.instrument.on.board()))
        .transpose()?;
    let experiment = experiment.map(|(experiment, _)| experiment);
    if let Some(experiment) = experiment.as_ref().filter(|_| arguments.currents) {
        return test_currents(arguments, experiment.clone());
    }
    let names: Vec<String> = experiment.iter().flat_map(|of| of.head.names()).map(str::to_owned).collect();
    if arguments.stored {
        return show_stored(arguments, names);
    }
    let mut instrument = arguments.instrument.open(arguments.experiment.as_deref(), || {
        let experiment = experiment.as_ref().ok_or_else(|| {
            Failure::usage("the sensor is simulated here, by an experiment: name one, or --on serial:DEVICE")
        })?;
        Ok(experiment.sensor()?)
    })?;
    let mut known = None;
    if let Some(experiment) = &experiment {
        let setup = host_sim::run::setup_of(experiment)?;
        setup::configure(instrument.as_mut(), &setup).map_err(Failure::work)?;
        known = Some((experiment.sample_period_s as f32, experiment.head.elements.len()));
    }
    let least_s = known.map_or(0.0, |(sample_period_s, _)| PULSE_LEAST_TICKS as f32 * sample_period_s);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).ok();
    let plan = SelfTestPlan {
        pulse_s: (!arguments.no_heat).then(|| arguments.pulse.unwrap_or_else(|| PULSE_S.max(least_s))),
        unix_s: now.and_then(|now| now.as_secs().try_into().ok()),
    };
    if let Some((sample_period_s, _)) = known {
        plan.pulse_ticks(sample_period_s).map_err(|error| Failure::usage(format!("--pulse: {error}")))?;
    }
    let interrupted = on_interrupt();
    let bar = progress("self-test", None);
    let report = self_test::run(instrument.as_mut(), plan, known, &mut |tick, of| {
        if let Some(of) = of {
            bar.set_length(of.into());
        }
        bar.set_position(tick.into());
        !interrupted.load(Ordering::Relaxed)
    });
    bar.finish_and_clear();
    let report = SelfTestReport { names, ..ended(instrument, report)? };
    crate::output::print_report(&report, arguments.json)?;
    let is_simulated = !matches!(arguments.instrument.on, On::Serial(_));
    let noise_v_rms = experiment.filter(|_| is_simulated).map(|experiment| experiment.imperfections.noise_v_rms);
    let is_frozen = report.findings.iter().any(|finding| finding.faults.has(SelfTestFault::Frozen));
    let hint = if is_frozen && noise_v_rms == Some(0.0) {
        "; `frozen`: the experiment simulates no noise, give it `front_end.noise_v_rms`, as 1.5e-6"
    } else {
        ""
    };
    report.faults().map_or(Ok(()), |faults| Err(Failure::work(format!("the self-test has found {faults}{hint}"))))
}

/// The report of a test that was not interrupted. The instrument's heaters are low after that,
/// whatever came of the test.
fn ended<R>(instrument: Box<dyn InstrumentPort>, report: Result<Option<R>, impl Display>) -> Result<R, Failure> {
    let finished = instrument.finish();
    let report = report.map_err(Failure::work)?;
    finished.map_err(Failure::work)?;
    report.ok_or_else(|| Failure::work("interrupted: the self-test has been stopped"))
}

/// Measures the ratios of the currents, and writes them into a head.
fn test_currents(arguments: &Arguments, mut experiment: Experiment) -> Result<(), Failure> {
    let mut read = vec![experiment.head.source.path.as_path()];
    read.extend(arguments.experiment.as_deref());
    crate::output::keep(&read, &[arguments.output.as_deref()])?;
    crate::output::writable(arguments.output.as_deref(), "a head", "toml")?;
    experiment.sample_period_s = currents::PERIOD_S;
    let mut instrument = arguments.instrument.open(arguments.experiment.as_deref(), || Ok(experiment.sensor()?))?;
    let interrupted = on_interrupt();
    let ticks = (f64::from(arguments.seconds) / currents::PERIOD_S).round() as u32;
    let bar = progress("currents", Some(ticks.into()));
    let report = currents::test_currents(&experiment.head, instrument.as_mut(), ticks, &mut |tick| {
        bar.set_position(tick.into());
        !interrupted.load(Ordering::Relaxed)
    });
    bar.finish_and_clear();
    let mut report = ended(instrument, report)?;
    let known = report.known();
    if let Some(path) = arguments.output.as_ref().filter(|_| known.iter().any(Option::is_some)) {
        let head = experiment.head.with_current_ratios(&known)?;
        crate::output::write_text(path, &head.source.text)?;
        report.written = Some(path.clone());
        if head.calibration.is_some() {
            warn("the head's calibration is from other currents: identify and calibrate it again with these");
        }
    }
    crate::output::print_report(&report, arguments.json)?;
    if let Some(unknown) = report.unknown() {
        return Err(Failure::work(unknown));
    }
    match report.faults().filter(|_| report.written.is_none()) {
        None => Ok(()),
        Some(faults) => {
            Err(Failure::work(format!("the self-test of the currents has found {faults}; -o HEAD corrects them")))
        }
    }
}

fn show_stored(arguments: &Arguments, names: Vec<String>) -> Result<(), Failure> {
    let InstrumentArguments { on, emulation, .. } = &arguments.instrument;
    let flash = arguments.instrument.flash()?;
    if matches!(on, On::Qemu | On::Silicon) && flash.is_none() {
        return Err(Failure::usage("--stored: an emulated board has kept something in its --flash FILE only"));
    }
    let mut board = OpenBoard::open(on, emulation, flash.unwrap_or(Path::new("")))?;
    let kept = settings::read_all(board.port()).map_err(Failure::work);
    board.close()?;
    let kept = kept?;
    let stored = StoredSelfTests { tests: kept.test.into_iter().chain(kept.test_at_start).collect(), names };
    crate::output::print_report(&stored, arguments.json)?;
    if stored.tests.is_empty() {
        return Err(Failure::work("the board has kept no self-test"));
    }
    stored.faults().map_or(Ok(()), |faults| Err(Failure::work(format!("the kept self-tests have found {faults}"))))
}
