//! Random lives: commands, faults of the converter and the sensor, crashes, resets, cuts of the
//! supply at any moment, noise and damage on the line, in any order. Whatever happens, no heater is
//! high against what was asked for or without a fresh code of its element
//! ([`silicon::witness`]), and the board answers in the end.
//!
//! A life is a list of random numbers, each of which is a deed. Of a life that fails, deeds are
//! left out one by one as long as it fails.

use crate::crashes_in_tasks::{fault, fill_stack, panic};
use crate::rig::{Rig, experiment};
use crate::settings::{ERASE, every};
use dr_core::Command;
use dr_core::control::{Drive, SelfTestPlan};
use dr_core::sensor::Level;
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentError, InstrumentPort};
use host_sim::run::setup_of;
use host_sim::sensor::{ResistorFault, TimedFault};
use host_sim::settings;
use silicon::adc::AdcFault;
use silicon::complaint::{BrokenRule, Complaint};
use silicon::plant::SensorPlant;
use silicon::soc::power::NOMINAL_MV;
use silicon::soc::rcc::ResetSource;
use silicon::time::{ms, us};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use wire::ToBoard;

/// Lives of a test; `ANEMO_LIVES` asks for others, `ANEMO_LIFE` for this one alone.
const LIVES: u64 = 50;
const DEEDS: usize = 16;

/// Rules that the firmware does not break itself.
const KNOWN: [(&str, BrokenRule); 3] = [
    // A crash before the heaters' port has its clock: pins float, low, and are lowered once more.
    ("GPIOC", BrokenRule::ClockOff),
    // A host that speaks to a board whose crystal has just failed, or that is just starting.
    ("USART2_BRR", BrokenRule::UsartBaud),
    ("USART2_DR", BrokenRule::UsartOverrun),
];

/// A generator that is the same everywhere (xorshift).
pub struct Chance(u64);

impl Chance {
    pub const fn of(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    const fn word(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub const fn below(&mut self, end: u64) -> u64 {
        (self.word() >> 16) % end
    }

    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }
}

/// A board and what its host knows.
struct Life<'a> {
    rig: &'a Rig,
    experiment: &'a Experiment,
    /// Everything that is sent gets a number of its own.
    number: u16,
    /// Frames that crossed a conversion because the crystal failed, or a debugger held the core.
    slowed: u32,
}

impl Life<'_> {
    fn run_for(&self, cycles: u64) {
        let mut machine = self.rig.machine();
        machine.run_for(cycles).unwrap();
        machine.board_mut().host.frames().for_each(drop);
    }

    fn frame(&mut self, message: &ToBoard) -> Vec<u8> {
        let mut buffer = [0; wire::MAX_FRAME];
        self.number = self.number.wrapping_add(1);
        wire::encode(self.number, message, &mut buffer).unwrap().to_vec()
    }

    fn receive(&self, bytes: &[u8]) {
        self.rig.machine().board_mut().receive(bytes);
    }

    fn send(&mut self, message: &ToBoard) {
        let frame = self.frame(message);
        self.receive(&frame);
    }

    /// Commands as a host sends them that does not wait for replies.
    fn command(&mut self, commands: impl IntoIterator<Item = Command>) {
        for command in commands {
            self.send(&ToBoard::Command(command));
            self.run_for(ms(3));
        }
    }

    fn store(&mut self, value: u64) {
        for request in settings::write_requests(&every(value as u16)).unwrap() {
            self.send(&ToBoard::Settings(request));
        }
    }

    /// Does something, and says what.
    fn act(&mut self, chance: &mut Chance) -> &'static str {
        match chance.below(27) {
            0..=4 => {
                let setup = setup_of(self.experiment).unwrap();
                let run = setup.into_iter().chain([Command::Arm { window_s: 5.0 }, Command::Start]);
                self.command([Command::Acknowledge, Command::Stop, Command::Clear].into_iter().chain(run));
                "run"
            }
            5 => {
                self.command([Command::Acknowledge]);
                "acknowledge"
            }
            6 => {
                self.command([Command::Stop]);
                "stop"
            }
            7 => {
                let sample_period_s = chance.one_of(&[0.001, 0.002, 0.01, 0.1, 0.5]);
                self.command([Command::SamplePeriod { sample_period_s }]);
                "sample period"
            }
            8 => {
                let drive = chance.one_of(&[
                    Drive::Level(Level::Low),
                    Drive::Level(Level::High),
                    Drive::Power { power_w: 0.012 },
                    Drive::Prbs { order: 7, seed: 5, ticks_per_bit: 3 },
                    Drive::Temperature { target_c: -20.0 },
                ]);
                self.command([Command::Drive { element: chance.below(6) as u8, drive }]);
                "drive"
            }
            9 => {
                let pulse_s = chance.one_of(&[None, Some(0.1)]);
                let test = Command::SelfTest(SelfTestPlan { pulse_s, unix_s: Some(1_800_000_000) });
                self.command([Command::Stop, Command::Arm { window_s: 5.0 }, test]);
                "self-test"
            }
            10 | 11 => {
                let faults = [AdcFault::Silent, AdcFault::Stuck, AdcFault::Garbage, AdcFault::LowEnd, AdcFault::Dead];
                let fault = chance.one_of(&[faults.map(Some).as_slice(), &[None, None]].concat());
                self.rig.machine().board_mut().set_adc_fault(fault);
                "converter"
            }
            12 => {
                let element = chance.below(4) as usize;
                let fault = chance.one_of(&[ResistorFault::Open, ResistorFault::Shorted]);
                let faults = vec![TimedFault { element, fault, start_s: 0.001 * chance.below(30) as f64 }];
                let faulty = Experiment { faults, ..self.experiment.clone() };
                let sensor = if chance.below(2) == 0 { &faulty } else { self.experiment };
                let plant = SensorPlant::new(&sensor.sensor_config().unwrap()).unwrap();
                self.rig.machine().board_mut().connect(plant);
                "sensor"
            }
            13 => {
                let source = chance.one_of(&[ResetSource::Pin, ResetSource::PowerOn]);
                self.rig.machine().reset_by(source).unwrap();
                "reset"
            }
            14 => {
                self.rig.machine().mask_interrupts().unwrap();
                "interrupts masked"
            }
            15 => {
                // A start pushes nothing for long: it would find a full stack much later, together
                // with another fault.
                let has_started = self.rig.machine().board().witness.state().is_some();
                let crashes = [panic, fault, fill_stack];
                let crash = chance.one_of(if has_started { &crashes } else { &crashes[..2] });
                crash(&mut self.rig.machine());
                "crash"
            }
            16 => {
                self.slow(|life| life.rig.machine().board_mut().fail_crystal());
                "crystal"
            }
            17 => {
                self.rig.machine().board_mut().watchdog.oscillator_hz = chance.one_of(&[17_000, 32_000, 47_000]);
                "oscillator"
            }
            18 => {
                self.store(chance.below(4));
                "setting"
            }
            19 => {
                self.rig.machine().board_mut().flash.erase_time = ms(chance.one_of(&[250, 500]));
                self.send(&ToBoard::Settings(ERASE));
                "erase"
            }
            20 => {
                self.store(chance.below(4));
                self.run_for(us(300 + chance.below(4_000)));
                self.rig.machine().reset_by(ResetSource::PowerOn).unwrap();
                "supply cut while writing"
            }
            21 => {
                let noise: Vec<u8> = (0..chance.below(200)).map(|_| chance.below(256) as u8).collect();
                self.receive(&noise);
                "noise"
            }
            22 => {
                let command = chance.one_of(&[Command::Start, Command::Stop, Command::Acknowledge, Command::Clear]);
                let mut frame = self.frame(&ToBoard::Command(command));
                match chance.below(3) {
                    0 => frame.truncate(chance.below(frame.len() as u64) as usize),
                    1 => frame = [frame.as_slice(), &frame].concat(),
                    _ => {
                        let bit = chance.below(8 * frame.len() as u64) as usize;
                        frame[bit / 8] ^= 1 << (bit % 8);
                    }
                }
                self.receive(&frame);
                "frame cut, twice or damaged"
            }
            23 => {
                self.rig.machine().board_mut().set_supply(chance.one_of(&[2_900, 3_000]));
                self.run_for(ms(chance.below(60)));
                self.rig.machine().board_mut().set_supply(NOMINAL_MV);
                "supply falls"
            }
            24 => {
                self.rig.machine().dip(chance.one_of(&[0, 1_500, 2_500]), ms(1 + chance.below(9))).unwrap();
                "supply gone"
            }
            25 => {
                self.slow(|life| {
                    life.rig.machine().board_mut().hold_core(true);
                    life.run_for(ms(chance.below(1_200)));
                    life.rig.machine().board_mut().hold_core(false);
                });
                "debugger"
            }
            _ => {
                self.run_for(ms(chance.below(700)));
                "host gone"
            }
        }
    }

    /// Fault by the end.
    fn judge(&self) -> Result<(), String> {
        self.rig.machine().board_mut().set_adc_fault(None);
        // Without it a board that starts waits for it, heaters low.
        self.rig.machine().board_mut().mend_crystal();
        // It may have to wait for its watchdog, at its slowest, and to start: half of the time that
        // the instrument waits for an answer.
        let mut instrument = self.rig.try_instrument().map_err(|error| format!("it does not answer: {error}"))?;
        match instrument.command(Command::Stop) {
            Ok(_) | Err(InstrumentError::Refused(_)) => {}
            Err(error) => return Err(format!("it does not answer to `Stop`: {error}")),
        }
        let complaints = self.rig.complaints();
        let is_fault = |of: &&Complaint| !KNOWN.contains(&(of.register, of.rule)) && !self.is_of_what_slows(of);
        let sentences: Vec<_> = complaints.iter().filter(is_fault).map(ToString::to_string).collect();
        if sentences.is_empty() { Ok(()) } else { Err(sentences.join("; ")) }
    }
}

impl Life<'_> {
    /// A crystal that fails, or a debugger, slows the bus in the middle of a frame, which then
    /// crosses the next conversion. It is dropped, as late frames are, and no decision comes of it.
    fn slow(&mut self, deed: impl FnOnce(&Self)) {
        let before = self.frames_across_update();
        deed(self);
        self.run_for(ms(2));
        self.slowed += (self.frames_across_update() - before).min(1);
    }

    fn frames_across_update(&self) -> u32 {
        let complaints = self.rig.complaints();
        let crossing = complaints.iter().find(|of| of.rule == BrokenRule::AdcFrameAcrossUpdate);
        crossing.map_or(0, |of| of.times)
    }

    fn is_of_what_slows(&self, of: &Complaint) -> bool {
        of.rule == BrokenRule::AdcFrameAcrossUpdate && of.times <= self.slowed
    }
}

/// Lives these deeds; gives their names, and what was wrong.
fn live(rig: &Rig, experiment: &Experiment, deeds: &[u64]) -> (Vec<&'static str>, Result<(), String>) {
    rig.begin_anew(experiment);
    let mut life = Life { rig, experiment, number: 100, slowed: 0 };
    let mut names = Vec::new();
    for &deed in deeds {
        let mut chance = Chance::of(deed);
        names.push(life.act(&mut chance));
        life.run_for(us(1_000 + chance.below(40_000)));
    }
    (names, life.judge())
}

/// Leaves out whatever is not needed for a life to fail; tells of the rest.
fn shrink(rig: &Rig, experiment: &Experiment, mut deeds: Vec<u64>) -> String {
    for place in (0..deeds.len()).rev() {
        let mut fewer = deeds.clone();
        fewer.remove(place);
        if live(rig, experiment, &fewer).1.is_err() {
            deeds = fewer;
        }
    }
    let (names, outcome) = live(rig, experiment, &deeds);
    format!("{names:?}: {}", outcome.err().unwrap_or_default())
}

pub fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}

#[test]
fn no_life_leaves_a_heater_on_or_ends_deaf() {
    let experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 10) };
    let (first, last) = match number("ANEMO_LIFE") {
        Some(seed) => (seed, seed),
        None => (1, number("ANEMO_LIVES").unwrap_or(LIVES)),
    };
    let (next, failures) = (AtomicU64::new(first), Mutex::new(Vec::new()));
    let work = || {
        let rig = Rig::of(&experiment);
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed > last {
                return;
            }
            let mut chance = Chance::of(seed);
            let deeds: Vec<u64> = (0..DEEDS).map(|_| chance.word()).collect();
            if live(&rig, &experiment, &deeds).1.is_err() {
                let failure = format!("life {seed}: {}", shrink(&rig, &experiment, deeds));
                println!("{failure}");
                failures.lock().unwrap().push(failure);
            }
            if seed % 100 == 0 {
                println!("{seed} of {last} lives");
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, Into::into) {
            scope.spawn(work);
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(
        failures.is_empty(),
        "ANEMO_LIFE=NUMBER in the environment of this test repeats one of them alone\n{}",
        failures.join("\n")
    );
    println!("{} lives: no heater high against the invariant, none ended deaf", last - first + 1);
}
