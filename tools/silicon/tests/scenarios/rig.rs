//! A machine with an image, and the ordinary instrument at the end of its line.

use dr_core::control::{RunState, Trip};
use host_sim::experiment::Experiment;
use host_sim::instrument::serial::Serial;
use host_sim::instrument::{InstrumentError, InstrumentPort};
use silicon::complaint::Complaint;
use silicon::image::FlashImage;
use silicon::machine::{Machine, MachineConfig, Snapshot};
use silicon::plant::SensorPlant;
use silicon::stream::MachineStream;
use silicon::time::{ms, seconds};
use std::cell::{RefCell, RefMut};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::{Arc, LazyLock};

/// The image, read once for all scenarios.
static IMAGE: LazyLock<Arc<FlashImage>> = LazyLock::new(|| {
    let path = image();
    Arc::new(FlashImage::read(&path).unwrap_or_else(|error| panic!("{error}")))
});

/// A board that has just started, which most scenarios begin with.
static STARTED: LazyLock<Snapshot> = LazyLock::new(|| {
    let mut machine = Machine::power_on_image(Arc::clone(&IMAGE), &MachineConfig::default()).unwrap();
    machine.run_until(ms(450)).unwrap();
    machine.snapshot().unwrap()
});

/// The sensor board's firmware.
pub fn image() -> PathBuf {
    let built = || {
        let test = std::env::current_exe().unwrap();
        // A test stands in `release/deps`.
        test.ancestors().nth(3).unwrap().join("thumbv7em-none-eabihf/firmware/firmware-sensor-board.elf")
    };
    let path = std::env::var_os("ANEMO_SENSOR_FIRMWARE").map_or_else(built, PathBuf::from);
    assert!(path.exists(), "no firmware at {}: `cargo xtask test` builds it and then runs these tests", path.display());
    path
}

/// A shipped experiment, cut to so many ticks.
pub fn experiment(name: &str, ticks: u32) -> Experiment {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments").join(name);
    Experiment { ticks, ..Experiment::read(&path).unwrap() }
}

/// Result of a run.
#[derive(Debug)]
pub struct EndOfRun {
    /// The trip.
    pub trip: Trip,
    /// When its sample was there.
    pub cycle: u64,
    /// When the pins became low, if any was high since the fault.
    pub low_since: u64,
}

/// A machine and its instrument.
pub struct Rig {
    machine: Rc<RefCell<Machine>>,
}

impl Rig {
    /// A board that has just been switched on.
    pub fn new(config: &MachineConfig) -> Self {
        let machine = Machine::power_on_image(Arc::clone(&IMAGE), config).unwrap();
        Self { machine: Rc::new(RefCell::new(machine)) }
    }

    /// A board with a defect in its flash, switched on.
    pub fn with_flash(change: impl FnOnce(&mut [u8])) -> Self {
        let mut image = FlashImage::clone(&IMAGE);
        change(&mut image.flash);
        let machine = Machine::power_on_image(Arc::new(image), &MachineConfig::default()).unwrap();
        Self { machine: Rc::new(RefCell::new(machine)) }
    }

    /// A board that has started already, in the wind tunnel of an experiment.
    pub fn of(experiment: &Experiment) -> Self {
        let rig = Self::new(&MachineConfig::default());
        rig.begin_anew(experiment);
        rig
    }

    /// The same with the machine that is there, which knows the image's instructions already.
    pub fn begin_anew(&self, experiment: &Experiment) {
        let mut machine = self.machine();
        machine.restore(&STARTED).unwrap();
        machine.board_mut().connect(SensorPlant::new(&experiment.sensor_config().unwrap()).unwrap());
    }

    /// The machine, between two messages.
    pub fn machine(&self) -> RefMut<'_, Machine> {
        self.machine.borrow_mut()
    }

    /// The instrument at the other end; waits until the board answers.
    pub fn instrument(&self) -> Serial<MachineStream> {
        self.try_instrument().unwrap()
    }

    /// The same, if it answers.
    pub fn try_instrument(&self) -> Result<Serial<MachineStream>, InstrumentError> {
        Serial::over(MachineStream::new(Rc::clone(&self.machine)))
    }

    /// Address of a function of the image.
    pub fn function(ending: &str) -> u32 {
        IMAGE.function(ending).unwrap_or_else(|| panic!("the image has no {ending}"))
    }

    /// Samples until this one, whose levels and state `judge` sees.
    pub fn observe(
        instrument: &mut dyn InstrumentPort,
        ticks: u32,
        mut judge: impl FnMut(&host_sim::instrument::TickSample),
    ) {
        for _ in 0..ticks {
            judge(&instrument.observe().unwrap().sample);
        }
    }

    /// Waits for a trip, for so many ticks; pins must be low then, and stay so.
    #[track_caller]
    pub fn until_trip(&self, instrument: &mut dyn InstrumentPort, ticks: u32) -> EndOfRun {
        for _ in 0..ticks {
            let RunState::Tripped(trip) = instrument.observe().unwrap().sample.state else { continue };
            let mut machine = self.machine();
            let cycle = machine.now();
            machine.run_for(ms(200)).unwrap();
            let last = *machine.pins().last().unwrap();
            assert_eq!(last.levels, 0);
            assert!(last.cycle <= cycle, "a pin has moved after the trip");
            return EndOfRun { trip, cycle, low_since: last.cycle };
        }
        panic!("no trip within {ticks} ticks");
    }

    /// Complaints of the models.
    pub fn complaints(&self) -> Vec<Complaint> {
        self.machine().board().complaints.all().to_vec()
    }

    /// Nothing is wrong.
    #[track_caller]
    pub fn assert_no_complaint(&self) {
        let complaints = self.complaints();
        let sentences: Vec<String> = complaints.iter().map(ToString::to_string).collect();
        assert!(complaints.is_empty(), "at {:.3} s: {sentences:#?}", seconds(self.machine().now()));
    }
}

/// A scenario that fails shows what the models have complained of, whatever it was that failed.
impl Drop for Rig {
    fn drop(&mut self) {
        if std::thread::panicking()
            && let Ok(machine) = self.machine.try_borrow()
        {
            machine.board().complaints.all().iter().for_each(|complaint| eprintln!("{complaint}"));
        }
    }
}
