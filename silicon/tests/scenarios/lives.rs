//! Random lives: commands, faults of the converter, resets, cuts of the supply, noise on the line,
//! in any order. Whatever happens, no heater is high against what the board reports, and the board
//! answers in the end.

use crate::rig::{Rig, experiment};
use dr_core::Command;
use dr_core::control::Drive;
use dr_core::sensor::Level;
use host_sim::run::setup_of;
use silicon::adc::AdcFault;
use silicon::complaint::BrokenRule;
use silicon::soc::rcc::ResetSource;
use silicon::time::ms;
use wire::{Setting, SettingsRequest, ToBoard};

/// Lives of a test; `ANEMO_LIVES` asks for others.
const LIVES: u64 = 12;
const DEEDS: u32 = 30;

/// What the firmware is known to do wrong (`known_defects`), in any order here.
const KNOWN: [BrokenRule; 2] = [BrokenRule::AdcNoData, BrokenRule::AdcFrameAcrossUpdate];

/// A generator that is the same everywhere (xorshift).
struct Chance(u64);

impl Chance {
    fn next(&mut self, below: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) % below
    }
}

/// Everything that is sent in a life gets a number of its own.
fn send(rig: &Rig, number: &mut u16, message: &ToBoard) {
    let mut buffer = [0; wire::MAX_FRAME];
    *number = number.wrapping_add(1);
    let frame = wire::encode(*number, message, &mut buffer).unwrap();
    rig.machine().board_mut().receive(frame);
}

fn live(seed: u64) {
    let experiment = experiment("held.toml", 10);
    let rig = Rig::of(&experiment);
    let mut chance = Chance(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut number = 100;
    let mut deeds = Vec::new();
    for _ in 0..DEEDS {
        let deed = chance.next(16);
        deeds.push(deed);
        match deed {
            0..=4 => {
                let setup = setup_of(&experiment).unwrap();
                let run = setup.into_iter().chain([Command::Arm { window_s: 5.0 }, Command::Start]);
                for command in [Command::Stop, Command::Clear].into_iter().chain(run) {
                    send(&rig, &mut number, &ToBoard::Command(command));
                    rig.machine().run_for(ms(3)).unwrap();
                }
            }
            5 => send(&rig, &mut number, &ToBoard::Command(Command::Acknowledge)),
            6 => send(&rig, &mut number, &ToBoard::Command(Command::Stop)),
            7 => {
                let sample_period_s = [0.001, 0.002, 0.01, 0.1][chance.next(4) as usize];
                send(&rig, &mut number, &ToBoard::Command(Command::SamplePeriod { sample_period_s }));
            }
            8 => {
                let drive = Drive::Level(if chance.next(2) == 0 { Level::Low } else { Level::High });
                send(&rig, &mut number, &ToBoard::Command(Command::Drive { element: 0, drive }));
            }
            9 | 10 => {
                let faults = [AdcFault::Silent, AdcFault::Stuck, AdcFault::Garbage, AdcFault::Dead];
                let fault = faults.get(chance.next(5) as usize).copied();
                rig.machine().board_mut().set_adc_fault(fault);
            }
            11 => {
                let source = [ResetSource::Pin, ResetSource::PowerOn][chance.next(2) as usize];
                rig.machine().reset_by(source).unwrap();
            }
            12 => rig.machine().core_mut().mask_interrupts().unwrap(),
            13 => {
                let setting = Setting::TelemetryEvery(chance.next(4) as u16);
                let key = setting.key().unwrap().number();
                let store = SettingsRequest::Store { key, value: setting.value().unwrap() };
                send(&rig, &mut number, &ToBoard::Settings(store));
            }
            14 => {
                let noise: Vec<u8> = (0..chance.next(200)).map(|_| chance.next(256) as u8).collect();
                rig.machine().board_mut().receive(&noise);
            }
            _ => rig.machine().run_for(ms(chance.next(700))).unwrap(),
        }
        rig.machine().run_for(ms(1 + chance.next(60))).unwrap();
    }
    rig.machine().board_mut().set_adc_fault(None);
    // It may wait for its watchdog, and then starts.
    rig.machine().run_for(ms(1_600)).unwrap();
    rig.instrument();
    let complaints: Vec<_> = rig.complaints().into_iter().filter(|of| !KNOWN.contains(&of.rule)).collect();
    assert!(complaints.is_empty(), "life {seed}, deeds {deeds:?}: {complaints:#?}");
}

#[test]
fn no_life_leaves_a_heater_on_or_ends_deaf() {
    let lives = std::env::var("ANEMO_LIVES").ok().and_then(|lives| lives.parse().ok()).unwrap_or(LIVES);
    (1..=lives).for_each(live);
}
