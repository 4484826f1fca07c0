//! A host that says anything, and a front end that reads anything.
//!
//! The first byte: odd, the station knows nothing; even, it has been set up with three elements of
//! prototype B, and runs. Then one step after the other, by the remainder of its first byte by 4:
//!
//! | | what | bytes |
//! |---|---|---|
//! | 0, 1 | a command | its postcard encoding |
//! | 2 | a tick | for each element 0 (missing), 1 (stale), 2 and a code of 4 bytes, or a byte from 3 on: so far between the limits |
//! | 3 | ticks | how many, 1 … 256, and the same reading byte for all elements in all of them |
//!
//! The input ends with the first step that is none.

use super::bytes::Bytes;
use super::watched::{ELEMENTS, Watched};
use dr_core::Command;
use dr_core::control::{Drive, ElementConfig, Limits};
use dr_core::sensor::{Channel, Level, Platinum, Reading};

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    let mut bytes = Bytes(bytes);
    let mut watched = Watched::new();
    match bytes.byte() {
        None => return false,
        Some(mode) if mode % 2 == 0 => set_up(&mut watched),
        Some(_) => {}
    }
    let mut taken = false;
    while step(&mut bytes, &mut watched, &mut taken).is_some() {}
    taken
}

fn step(bytes: &mut Bytes<'_>, watched: &mut Watched, taken: &mut bool) -> Option<()> {
    match bytes.byte()? % 4 {
        0 | 1 => {
            let (command, rest) = postcard::take_from_bytes::<Command>(bytes.0).ok()?;
            bytes.0 = rest;
            *taken |= watched.tell(command).is_ok();
        }
        2 => {
            let mut readings = [Reading::Missing; ELEMENTS];
            for (i, reading) in readings.iter_mut().enumerate() {
                *reading = match bytes.byte()? {
                    0 => Reading::Missing,
                    1 => Reading::Stale,
                    2 => Reading::Code(i32::from_le_bytes(bytes.array()?)),
                    share => between(watched, i, share),
                };
            }
            watched.tick(&readings);
        }
        _ => {
            let (times, share) = (bytes.byte()?, bytes.byte()?);
            for _ in 0..=times {
                let readings = std::array::from_fn(|i| between(watched, i, share));
                watched.tick(&readings);
            }
        }
    }
    Some(())
}

fn between(watched: &Watched, element: usize, share: u8) -> Reading {
    // A little beyond either limit, too.
    Reading::Code(watched.code(element, (f64::from(share) - 8.0) / 240.0))
}

/// An element of prototype B.
pub fn element() -> ElementConfig {
    let channel = Platinum::linear(175.0, 0.0031).and_then(|platinum| Channel::new(platinum, 4.768e-7, 3e-3, 16e-3));
    ElementConfig { channel: channel.expect("prototype B has been built"), limits: Limits::SPHERE_B }
}

/// Three elements that are driven in three ways.
///
/// # Panics
/// If a station does not take them.
pub fn set_up(watched: &mut Watched) {
    let mut commands = vec![Command::SamplePeriod { sample_period_s: 0.01 }];
    for element in 0..ELEMENTS as u8 {
        commands.push(Command::Element { element, config: self::element() });
    }
    let drives = [Drive::Temperature { target_c: -20.0 }, Drive::Power { power_w: 0.02 }, Drive::Level(Level::High)];
    commands.extend((0_u8..).zip(drives).map(|(element, drive)| Command::Drive { element, drive }));
    commands.extend([Command::Arm { window_s: 600.0 }, Command::Start]);
    for command in commands {
        watched.tell(command).expect("this is how it is done");
    }
}
