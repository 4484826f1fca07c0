//! One fault after the other to an instrument that runs, and what came of them.
//!
//! Every fault must end in one of three ways: the readings are told as they are again while the
//! instrument runs on (`correct`), it trips, or, of what comes over the link, it is dropped and
//! counted. Whatever else happens fails the campaign, and so does a heater that is on against the
//! invariant at any tick on the way.

use super::fault::Fault;
use super::judge::Judge;
use super::{Kind, Subject};
use crate::{readings, sensor};
use dr_core::control::{Cause, Heaters, RunState, SelfTestFinding};
use dr_core::{Command, Reply, RunDigests};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentError, InstrumentPort, LinkReport, LockStepController, Observation};
use host_sim::sensor::Sensor;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::BTreeMap;
use wire::{Identity, LinkCounters};

/// Ticks in a row that have to be told as they are before a fault counts as over: more than there
/// are elements, whose models are looked at in turn.
const WELL_TICKS: u32 = 20;

/// Outcomes of all faults of a kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    pub kind: Kind,
    pub faults: u32,
    /// Faults after which it ran on and told readings as they are.
    pub correct: u32,
    /// Trips by their cause.
    pub trips: BTreeMap<&'static str, u32>,
    /// Frames that the link dropped and counted.
    pub dropped: u32,
    /// Ticks from the first that was wrong until the element's heater was low for good, at most; of
    /// those that tripped. All heaters, where it is not one element's fault.
    pub ticks_to_safe: u32,
}

/// Tells whether frames have been dropped.
fn dropped(counters: &LinkCounters) -> u32 {
    counters.damaged + counters.oversized + counters.repeated + counters.foreign
}

/// Injects so many faults of a kind into a subject around which the experiment's sensor is put.
///
/// # Panics
/// If the invariant is broken, or a fault ends in none of the three ways.
pub fn campaign<S: Subject>(subject: &mut S, experiment: &Experiment, kind: Kind, faults: u32, seed: u64) -> Row {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(kind as u64);
    let mut lab = Lab { sensor: sensor(experiment), judge: Judge::new(experiment), subject, experiment };
    lab.start();
    // Warm enough that the loops have begun to switch.
    for _ in 0..3000 {
        lab.tick(|_| ()).expect("a healthy instrument runs");
    }
    let mut row = Row { kind, faults, correct: 0, trips: BTreeMap::new(), dropped: 0, ticks_to_safe: 0 };
    // The number of ticks depends on the machine: where it is not needed, the campaign is the same
    // every time.
    let before = kind.is_counted().then(|| lab.counted());
    for n in 0..faults {
        let fault = Fault::draw(kind, experiment.head.elements.len(), &mut random);
        for _ in 0..5 + random.next_u32() % 30 {
            assert_eq!(lab.tick(|_| ()), Ok(true), "{kind:?} {n}: not well before it");
        }
        match lab.suffer(fault, &format!("{} {n}", kind.name())) {
            Ended::Correct => row.correct += 1,
            Ended::Tripped(cause, ticks) => {
                *row.trips.entry(cause.name()).or_default() += 1;
                row.ticks_to_safe = row.ticks_to_safe.max(ticks);
                lab.subject.command(Command::Acknowledge).expect("a trip can be acknowledged");
                lab.rest();
                lab.start();
            }
            Ended::Reset => {
                row.correct += 1;
                lab.start();
                // A self-test of its start may have ended by that: the first reading is still of
                // something else then.
                lab.tick(|_| ()).ok();
            }
        }
    }
    if let Some(before) = before {
        row.dropped = dropped(&lab.counted()) - dropped(&before);
        assert!(row.dropped >= faults, "{kind:?}: {} of {faults} have been counted", row.dropped);
    }
    row
}

/// End of a fault.
enum Ended {
    Correct,
    Tripped(Cause, u32),
    /// In standby, as after any reset.
    Reset,
}

/// A subject with a sensor around it, and somebody who judges.
struct Lab<'a, S> {
    subject: &'a mut S,
    experiment: &'a Experiment,
    sensor: Sensor,
    judge: Judge,
}

impl<S: Subject> Lab<'_, S> {
    fn start(&mut self) {
        host_sim::run::start(self.experiment, &mut AsInstrument(self.subject)).expect("the experiment is not refused");
    }

    /// Ten minutes pass in standby, in ticks of ten seconds, so that the trips of a campaign do not
    /// lock the instrument.
    fn rest(&mut self) {
        let slow = Command::SamplePeriod { sample_period_s: 10.0 };
        self.subject.command(slow).expect("it is in standby");
        let given = readings(&self.sensor);
        for _ in 0..61 {
            self.subject.exchange(&given).expect("the instrument answers");
        }
    }

    /// One tick, its readings changed on the way; whether all were told as they are, or else the
    /// trip.
    fn tick(&mut self, change: impl FnOnce(&mut [dr_core::sensor::Reading])) -> Result<bool, Cause> {
        let mut given = readings(&self.sensor);
        change(&mut given);
        let told = self.subject.exchange(&given).expect("the instrument answers");
        let all_told = self.judge.tick(&given, &told, "tick");
        self.sensor.advance(self.judge.levels().0);
        match told.sample.state {
            RunState::Tripped(trip) => Err(trip.cause),
            state => Ok(all_told && state == RunState::Running),
        }
    }

    /// The supply fails while settings are written: they are the old or the new ones then, and no
    /// heater is on before or after.
    fn lose_power(&mut self, fault: &Fault, what: &str) -> Ended {
        self.subject.command(Command::Stop).expect("it can always be stopped");
        assert_eq!((self.tick(|_| ()), self.judge.levels()), (Ok(false), Heaters(0)), "{what}: stopped");
        let old = self.subject.kept().expect("it keeps settings");
        let (mut new, (command, after)) = (old.clone(), fault.interrupted());
        new.put(command);
        // The erase of a sector, header and mark count, too.
        let bytes = new.bytes().expect("a head fits").len() as u32 + 36;
        let after_bytes = after % bytes;
        let failed = self.subject.store_with_a_cut(&new, after_bytes).expect("it comes back");
        assert_eq!((self.tick(|_| ()), self.judge.levels()), (Ok(false), Heaters(0)), "{what}: before it is started");
        let now = self.subject.kept().expect("they are whole");
        assert!(now == new || failed && now == old, "{what}: neither old nor new, cut after {after_bytes} bytes");
        Ended::Reset
    }

    /// A fault from its beginning to its end.
    fn suffer(&mut self, mut fault: Fault, what: &str) -> Ended {
        let kind = fault.kind;
        if kind == Kind::PowerCut {
            return self.lose_power(&fault, what);
        }
        if let Some(bytes) = fault.bytes() {
            self.subject.hear(&bytes).expect("the link takes anything");
        }
        if kind == Kind::Upset {
            let places = dr_core::control::controller::bit_flips::FLIPPABLE;
            let mut which = fault.bits as usize % places;
            while !self.subject.upset(which, fault.element, fault.bits / 64).expect("it is there") {
                which = (which + 1) % places;
            }
        }
        if let Some(harm) = kind.harm() {
            self.subject.harm(harm).expect("it comes back");
            // The heaters have been low since.
            self.judge.started_anew();
            self.sensor.advance(0);
            return match self.tick(|_| ()) {
                Err(cause) => Ended::Tripped(cause, 0),
                Ok(_) => Ended::Reset,
            };
        }
        let (mut well, mut safe_after) = (0, 1);
        for t in 0..kind.window_ticks() {
            if fault.is_silent(t) {
                let levels = self.subject.silence().expect("the instrument answers");
                self.judge.silence(levels, what);
                self.sensor.advance(levels.0);
                if levels.0 != 0 {
                    safe_after = t + 2;
                }
                continue;
            }
            match self.tick(|readings| fault.apply(t, readings)) {
                Err(cause) => return Ended::Tripped(cause, safe_after),
                Ok(all_told) => well = if all_told && !is_wrong(&fault, t) { well + 1 } else { 0 },
            }
            let levels = self.judge.levels();
            let is_heated = if fault.changes_readings() { levels.is_high(fault.element) } else { levels.0 != 0 };
            if is_heated {
                safe_after = t + 2;
            }
            if well == WELL_TICKS {
                return Ended::Correct;
            }
        }
        panic!("{what}: neither correct again, nor tripped, after {} ticks: {fault:?}", kind.window_ticks())
    }

    /// Counters of the link, the last fault included.
    fn counted(&mut self) -> LinkCounters {
        // The second status from now on has seen all that came before.
        let (from_s, _) = self.subject.counted().expect("it is there");
        loop {
            let (uptime_s, counters) = self.subject.counted().expect("it is there");
            if uptime_s >= from_s + 2 {
                return counters;
            }
            self.tick(|_| ()).ok();
        }
    }
}

/// Tells whether the readings themselves are wrong in a tick, however well they are told.
fn is_wrong(fault: &Fault, t: u32) -> bool {
    fault.is_on(t) && fault.changes_readings()
}

/// A subject as that to which commands are given.
pub(super) struct AsInstrument<'a, S: ?Sized>(pub &'a mut S);

impl<S: LockStepController + ?Sized> InstrumentPort for AsInstrument<'_, S> {
    fn identity(&self) -> &Identity {
        self.0.identity()
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        self.0.command(command)
    }

    fn observe(&mut self) -> Result<Observation, InstrumentError> {
        Err(InstrumentError::Protocol("it is only set up this way".to_owned()))
    }

    fn findings(&mut self) -> Vec<SelfTestFinding> {
        Vec::new()
    }

    fn digests(&self) -> Option<RunDigests> {
        None
    }

    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        Ok(LinkReport::default())
    }
}

/// The table of a campaign.
pub fn table(rows: &[Row]) -> String {
    let mut text =
        "| fault | injected | correct again | tripped | frames dropped and counted | ticks to heaters low, at most |\n\
                    |---|--:|--:|---|--:|--:|\n"
            .to_owned();
    for row in rows {
        let trips: Vec<String> = row.trips.iter().map(|(cause, count)| format!("{count} {cause}")).collect();
        let or_none = |number: u32| if number == 0 { String::new() } else { number.to_string() };
        text += &format!(
            "| {} | {} | {} | {} | {} | {} |\n",
            row.kind.name(),
            row.faults,
            row.correct,
            trips.join(", "),
            or_none(row.dropped),
            or_none(row.ticks_to_safe),
        );
    }
    let all: u32 = rows.iter().map(|row| row.faults).sum();
    text + &format!("\n{all} faults. No heater was on against the invariant at any tick.\n")
}
