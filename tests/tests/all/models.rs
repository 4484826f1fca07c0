//! The models that judge set-points, held against the simulated sphere: an open-loop record of
//! pseudo-random heating, one element at a time, in the still gas that the models are for.

use anemo_tests::{changed, in_process, start};
use dr_core::model::{ORDER, RelaxationState, SelfHeating};
use dr_core::sensor::Level;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;

/// The controller starts its models at rest, as if nothing had ever been heated, while the sphere
/// has stood by at the low level for long. The difference, 2 K at most, is gone after four of the
/// slowest time constants of 500 s.
const FORGOTTEN_S: f64 = 2000.0;

/// One element under pseudo-random bits of 50 s, the others passive, no wind. Bits that long swing
/// it far.
fn open_loop(element: &str) -> Experiment {
    let head = "head = \"../heads/sphere-b.toml\"";
    let models = format!("{head}\nmodels = \"../heads/models/sphere-b-mars-still.toml\"");
    let drive = format!("{element} = {{ prbs = {{ order = 12, bit_time_s = 50.0, seed = 1 }} }}");
    changed(
        "prbs.toml",
        &[
            (head, &models),
            ("sector1 = { prbs = { order = 20, bit_time_s = 0.1, seed = 1 } }", &drive),
            ("sector2 = { prbs = { order = 20, bit_time_s = 0.1, seed = 345678 } }", ""),
            ("sector3 = { prbs = { order = 20, bit_time_s = 0.1, seed = 654321 } }", ""),
            ("sector4 = { prbs = { order = 20, bit_time_s = 0.1, seed = 987654 } }", ""),
            ("speed_m_s = 1.0", "speed_m_s = 0.0"),
        ],
    )
}

/// Largest and root-mean-square deviation.
#[derive(Default)]
struct Deviation {
    largest_k: f64,
    squares_k2: f64,
    count: u32,
}

impl Deviation {
    fn take(&mut self, deviation_k: f64) {
        self.largest_k = self.largest_k.max(deviation_k.abs());
        self.squares_k2 += deviation_k * deviation_k;
        self.count += 1;
    }

    fn rms_k(&self) -> f64 {
        (self.squares_k2 / f64::from(self.count)).sqrt()
    }
}

/// Runs the record and holds three predictions of every temperature against it, each from the
/// recorded powers alone.
fn follows(name: &str, element: usize, bound_k: f64) {
    let experiment = open_loop(name);
    let mut instrument = in_process(&experiment);
    start(&experiment, &mut *instrument);
    let model = SelfHeating::new(&experiment.model(element).unwrap(), experiment.sample_period_s as f32).unwrap();

    let mut from_rest = RelaxationState::<ORDER>::default();
    // In a steady state every x_k has become the power itself.
    let standby_c = instrument.truth().element_temperature_c[element];
    let standby_w = experiment.head.elements[element].power_w(standby_c, Level::Low) as f32;
    let mut from_standby = RelaxationState { x: [standby_w; ORDER], excess: [0.0; ORDER] };

    let (mut coldest_c, mut hottest_c) = (f64::MAX, f64::MIN);
    let (mut all, mut late, mut controllers) = (Deviation::default(), Deviation::default(), Deviation::default());
    for tick in 0..experiment.ticks {
        let said_by_controller = instrument.body().model_temperature_c(element).unwrap();
        let sample = instrument.observe().unwrap().sample;
        let temperature_c = f64::from(sample.temperature_c[element]);
        (coldest_c, hottest_c) = (coldest_c.min(temperature_c), hottest_c.max(temperature_c));

        // The controller's own model is this very one, to the bit, started at rest.
        assert_eq!(said_by_controller, model.temperature_c(&from_rest), "tick {tick}");
        let deviation_k = f64::from(model.temperature_c(&from_standby)) - temperature_c;
        all.take(deviation_k);
        if experiment.time_s(tick) >= FORGOTTEN_S {
            late.take(deviation_k);
            controllers.take(f64::from(said_by_controller) - temperature_c);
        }
        model.step(&mut from_rest, sample.power_w[element]);
        model.step(&mut from_standby, sample.power_w[element]);
    }
    println!("{name}: {:.0} s of pseudo-random heating, swing {:.1} K", experiment.duration_s(), hottest_c - coldest_c);
    for (which, deviation) in [
        ("model from standby, all along     ", &all),
        ("model from standby, after 2000 s  ", &late),
        ("controller's model, after 2000 s  ", &controllers),
    ] {
        println!("  {which} largest {:.3} K, rms {:.3} K", deviation.largest_k, deviation.rms_k());
        assert!(deviation.largest_k <= bound_k, "{name}, {which}: {} K", deviation.largest_k);
    }
}

#[test]
fn a_sector_follows_its_model() {
    // A quarter of a percent of a 43 K swing: radiation and convection are not quite linear.
    follows("sector1", 0, 0.1);
}

#[test]
fn a_core_follows_its_model() {
    // Less than two percent of a 17 K swing: what eight rates on a given mesh miss of a body behind
    // four others.
    follows("core1", 4, 0.3);
}
