//! Bits that flip anywhere in the emulated board's RAM, one a board, and what came of each.
//!
//! Every flip hits a board of its own that runs, between two ticks: while it waits for its host.
//! From then on a twin in this process is given the same readings; the two say the same to the bit,
//! so that whatever the board says else is the flip's doing. The judge of the heaters knows nothing
//! of the twin.

use super::judge::Judge;
use super::memory::{Flip, Memory, Region};
use crate::readings;
use dr_core::Command;
use dr_core::control::RunState;
use host_sim::experiment::Experiment;
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentError, LockStepController, TickReport};
use host_sim::sensor::Sensor;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

/// Ticks for which a board is watched after a flip, before it is told to stop.
const WATCHED_TICKS: u32 = 120;

/// A board that has not answered for so long does not answer any more. One that does takes less
/// than a millisecond.
const TIMEOUT: Duration = Duration::from_millis(1500);

/// End of a flip. Of two the later one counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    /// It ran on, said what its twin said, and stopped when it was told to.
    AsBefore,
    /// It ran on, but some messages did not come: they are numbered, so that whoever waits for them
    /// knows.
    Dropped,
    /// It heated as its twin did, and told another wind.
    WrongWind,
    /// It heated as its twin did, and told another number that is no wind.
    WrongNumber,
    /// It heated otherwise than its twin, by valid readings.
    HeatedOtherwise,
    /// It ran on by valid readings, and did not hear that it was told to stop.
    Deaf,
    /// It tripped, for this cause.
    Tripped(&'static str),
    /// It started anew, heaters low, and was in this state then.
    Restarted(&'static str),
    /// It says nothing any more to readings; of ticks without readings it still hears, and the dead
    /// man's handle lowers its heaters.
    DeadMan,
    /// It says nothing any more, or nothing that answers. The emulator has neither watchdog nor the
    /// timer of the dead man's handle.
    NoAnswer,
}

/// All flips of a region.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Upsets {
    pub region: Region,
    pub ends: BTreeMap<End, u32>,
    /// Ticks from the flip until all heaters were low for good, at most; of those that tripped.
    pub ticks_to_safe: u32,
    /// Where it did not end as before and was no trip: how it ended, what was hit, what was seen.
    pub notable: Vec<(End, String, String)>,
}

impl Upsets {
    /// Number that ended so.
    pub fn count(&self, which: impl Fn(End) -> bool) -> u32 {
        self.ends.iter().filter(|(end, _)| which(**end)).map(|(_, count)| count).sum()
    }
}

/// A sensor that is as warm as the experiment wants it, after so many ticks.
pub fn warm(experiment: &Experiment, ticks: u32) -> Sensor {
    let mut sensor = crate::sensor(experiment);
    let mut body = InProcess::new();
    start(experiment, &mut body);
    for _ in 0..ticks {
        let told = body.exchange(&readings(&sensor)).expect("a healthy instrument runs");
        sensor.advance(told.sample.heaters.0);
    }
    // A board that has just been started expects this.
    sensor.advance(0);
    sensor
}

fn start(experiment: &Experiment, body: &mut dyn LockStepController) {
    host_sim::run::start(experiment, &mut super::campaign::AsInstrument(body)).expect("the experiment is not refused");
}

/// Flips so many bits of a region, each on a board of its own around such a sensor.
///
/// # Panics
/// If the invariant is broken.
pub fn upsets(
    firmware: &Path,
    experiment: &Experiment,
    warm: &Sensor,
    region: Region,
    flips: u32,
    seed: u64,
) -> Upsets {
    let memory = Memory::of(firmware);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(region as u64);
    let mut all = Upsets { region, ends: BTreeMap::new(), ticks_to_safe: 0, notable: Vec::new() };
    for _ in 0..flips {
        let flip = memory.draw(region, &mut random);
        // Where the stack holds more than the loop that waits: an interrupt's frame.
        let way = if region == Region::Stack && random.next_u32() & 1 == 0 { Way::Usart } else { Way::Fifo };
        let board = Emulated::start(firmware, way).expect("the emulated board starts");
        let mut trial = Trial::new(experiment, board, warm.clone());
        trial.run_well(5 + random.next_u32() % 30);
        let (end, ticks_to_safe) = trial.suffer(&flip);
        *all.ends.entry(end).or_default() += 1;
        match end {
            End::Tripped(_) => all.ticks_to_safe = all.ticks_to_safe.max(ticks_to_safe),
            End::AsBefore => {}
            end => all.notable.push((end, flip.what, trial.seen())),
        }
    }
    all
}

/// A board, its twin, and the sensor around both.
struct Trial {
    board: Emulated,
    twin: InProcess,
    sensor: Sensor,
    judge: Judge,
    /// Ticks in which something else was told than the twin told, how many of these had a mark of
    /// it, and the last of them.
    wrong: (u32, u32, u32),
    /// Why there was no answer.
    error: String,
}

/// Message of a tick.
enum Told {
    Report(Box<TickReport>),
    /// Nothing that can be understood.
    Nothing,
    StartedAnew,
}

impl Trial {
    fn new(experiment: &Experiment, mut board: Emulated, sensor: Sensor) -> Self {
        let mut twin = InProcess::new();
        start(experiment, &mut board);
        start(experiment, &mut twin);
        board.set_timeout(TIMEOUT);
        Self { board, twin, sensor, judge: Judge::new(experiment), wrong: (0, 0, 0), error: String::new() }
    }

    /// In words.
    fn seen(&self) -> String {
        let ((ticks, marked, last), levels) = (self.wrong, self.judge.levels().0);
        format!("{ticks} ticks differ, {marked} of them marked, the last is {last}; levels {levels:#b} {}", self.error)
    }

    fn run_well(&mut self, ticks: u32) {
        for _ in 0..ticks {
            let given = readings(&self.sensor);
            let [told, twins] = [&mut self.board as &mut dyn LockStepController, &mut self.twin]
                .map(|body| body.exchange(&given).expect("a healthy instrument runs"));
            assert_eq!(told, twins, "board and twin say the same");
            assert_eq!(told.sample.state, RunState::Running);
            assert!(self.judge.tick(&given, &told, "before the flip"), "all temperatures are told as they are");
            self.sensor.advance(told.sample.heaters.0);
        }
    }

    fn tell(&mut self) -> Told {
        match self.board.exchange(&readings(&self.sensor)) {
            Ok(report) => Told::Report(Box::new(report)),
            Err(InstrumentError::Restarted(_)) => Told::StartedAnew,
            Err(error) => self.nothing(&error),
        }
    }

    fn nothing(&mut self, error: &InstrumentError) -> Told {
        self.error = error.to_string();
        Told::Nothing
    }

    /// A tick of which only the levels are wanted; whether they are told.
    fn tells_levels(&mut self, what: &str) -> bool {
        let given = readings(&self.sensor);
        match self.board.exchange_levels(&given) {
            Ok(told) => {
                self.judge.levels_told(&given, told.heaters, what);
                self.sensor.advance(told.heaters.0);
                true
            }
            Err(error) => {
                self.nothing(&error);
                false
            }
        }
    }

    /// Outcome of a flip, and after how many ticks all heaters were low.
    fn suffer(&mut self, flip: &Flip) -> (End, u32) {
        let what = &flip.what;
        if self.board.provoke(flip.harm).is_err() {
            return (self.without_readings(what), 1);
        }
        let (mut end, mut safe_after, mut are_told) = (End::AsBefore, 1, true);
        for t in 0..WATCHED_TICKS {
            if are_told {
                let given = readings(&self.sensor);
                match self.tell() {
                    Told::Report(told) => {
                        self.judge.tick(&given, &told, what);
                        if let RunState::Tripped(trip) = told.sample.state {
                            return (End::Tripped(trip.cause.name()), safe_after);
                        }
                        let twins = self.twin.exchange(&given).expect("the twin is well");
                        end = end.max(self.compare(t, &told, &twins));
                        self.sensor.advance(self.judge.levels().0);
                    }
                    Told::StartedAnew => return (self.started_anew(what), 1),
                    Told::Nothing => (are_told, end) = (false, end.max(End::Dropped)),
                }
            }
            // No time passes on a board that waits for readings: it is given them again.
            if !are_told && !self.tells_levels(what) {
                return (self.without_readings(what), 1);
            }
            if self.judge.levels().0 != 0 {
                safe_after = t + 2;
            }
        }
        match self.board.command(Command::Stop) {
            Ok(_) => {}
            Err(InstrumentError::Restarted(_)) => return (self.started_anew(what), 1),
            Err(error) => {
                self.nothing(&error);
                return (if self.tells_levels(what) { End::Deaf } else { self.without_readings(what) }, 1);
            }
        }
        if !self.tells_levels(what) {
            return (self.without_readings(what), 1);
        }
        assert_eq!(self.judge.levels().0, 0, "{what}: stopped, and heats");
        (end, safe_after)
    }

    /// Compares the boards.
    fn compare(&mut self, t: u32, told: &TickReport, twins: &TickReport) -> End {
        if told == twins {
            return End::AsBefore;
        }
        // Another doubt than the twin's, or errors that are beyond belief at so few degrees of
        // freedom.
        let is_marked = told.wind.as_ref().zip(twins.wind.as_ref()).is_some_and(|(told, twins)| {
            told.quality_flags != twins.quality_flags || (told.chi_square > 30.0 && twins.chi_square < 30.0)
        });
        self.wrong = (self.wrong.0 + 1, self.wrong.1 + u32::from(is_marked), t);
        if told.sample.heaters != twins.sample.heaters {
            End::HeatedOtherwise
        } else if (&told.sample, &told.equivalent_power_w) != (&twins.sample, &twins.equivalent_power_w) {
            End::WrongNumber
        } else {
            End::WrongWind
        }
    }

    /// A board that has started anew says so, with its heaters low.
    fn started_anew(&mut self, what: &str) -> End {
        if self.board.reborn().is_err() {
            return End::NoAnswer;
        }
        self.judge.started_anew();
        let given = readings(&self.sensor);
        let Told::Report(told) = self.tell() else { return End::NoAnswer };
        self.judge.tick(&given, &told, what);
        End::Restarted(match told.sample.state {
            RunState::Standby => "standby",
            RunState::Running => "running",
            RunState::Testing => "testing",
            RunState::Tripped(trip) => trip.cause.name(),
        })
    }

    /// A board that has nothing to say to readings any more: ticks pass without them.
    fn without_readings(&mut self, what: &str) -> End {
        for _ in 0..2 {
            match self.board.silence() {
                Ok(told) => self.judge.silence(told.heaters, what),
                Err(InstrumentError::Restarted(_)) => return self.started_anew(what),
                Err(_) => return End::NoAnswer,
            }
        }
        End::DeadMan
    }
}
