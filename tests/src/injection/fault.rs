//! Faults: kinds, and faults of a kind as a seed draws them.

use diffusive::random::StandardNormal;
use dr_core::Command;
use dr_core::control::{Drive, GuardConfig};
use dr_core::sensor::{Level, Reading};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use rand_distr::Distribution;
use wire::{MAX_FRAME, Provocation, ToBoard, encode};

/// Kinds of faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Open,
    Short,
    TooHot,
    Drift,
    StuckCode,
    NoiseBurst,
    FlippedCode,
    DroppedOnce,
    DroppedLong,
    StaleOnce,
    StaleLong,
    LateOnce,
    Silent,
    Garbage,
    Truncated,
    Damaged,
    Oversized,
    Repeated,
    Foreign,
    Replayed,
    Upset,
    Reset,
    Panic,
    ProcessorFault,
    PowerCut,
}

impl Kind {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 25] = [
        Self::Open,
        Self::Short,
        Self::TooHot,
        Self::Drift,
        Self::StuckCode,
        Self::NoiseBurst,
        Self::FlippedCode,
        Self::DroppedOnce,
        Self::DroppedLong,
        Self::StaleOnce,
        Self::StaleLong,
        Self::LateOnce,
        Self::Silent,
        Self::Garbage,
        Self::Truncated,
        Self::Damaged,
        Self::Oversized,
        Self::Repeated,
        Self::Foreign,
        Self::Replayed,
        Self::Upset,
        Self::Reset,
        Self::Panic,
        Self::ProcessorFault,
        Self::PowerCut,
    ];

    /// For the table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Open => "open resistor",
            Self::Short => "shorted resistor",
            Self::TooHot => "element beyond its greatest temperature",
            Self::Drift => "readings that drift by 2 to 10 % a tick",
            Self::StuckCode => "a converter that repeats one code",
            Self::NoiseBurst => "1 to 10 ticks of noise, 0.1 to 30 %",
            Self::FlippedCode => "1 to 4 flipped bits in one code",
            Self::DroppedOnce => "one reading dropped",
            Self::DroppedLong => "2 to 10 readings dropped",
            Self::StaleOnce => "one reading stale",
            Self::StaleLong => "2 to 10 readings stale",
            Self::LateOnce => "a tick without the front end",
            Self::Silent => "2 to 10 ticks without the front end",
            Self::Garbage => "garbage on the link",
            Self::Truncated => "a truncated command",
            Self::Damaged => "a command with a flipped bit",
            Self::Oversized => "a frame without an end",
            Self::Repeated => "a command twice under one number",
            Self::Foreign => "a command of another version",
            Self::Replayed => "an old command again",
            Self::Upset => "a bit in what decides",
            Self::Reset => "reset",
            Self::Panic => "panic",
            Self::ProcessorFault => "processor fault",
            Self::PowerCut => "supply gone while settings are written",
        }
    }

    /// Ticks after which it must have shown.
    pub const fn window_ticks(self) -> u32 {
        match self {
            // The heads' limit, and what the loop takes to ask for the level at which the code is
            // impossible.
            Self::StuckCode => 400,
            _ => 60,
        }
    }

    /// Tells whether a link has to count such a fault; whatever comes of `Replayed` is the
    /// controller's to refuse.
    pub const fn is_counted(self) -> bool {
        matches!(
            self,
            Self::Garbage | Self::Truncated | Self::Damaged | Self::Oversized | Self::Repeated | Self::Foreign
        )
    }

    /// Harm to the whole instrument.
    pub const fn harm(self) -> Option<Provocation> {
        match self {
            Self::Reset => Some(Provocation::Reset),
            Self::Panic => Some(Provocation::Panic),
            Self::ProcessorFault => Some(Provocation::Fault),
            _ => None,
        }
    }
}

/// One fault.
#[derive(Debug, Clone)]
pub struct Fault {
    pub kind: Kind,
    pub element: usize,
    /// Relative size, for those that have one.
    size: f64,
    /// Ticks that it lasts.
    ticks: u32,
    /// Random bits of its own.
    pub bits: u32,
    /// The code at which it sticks.
    stuck: Option<i32>,
    noise: ChaCha8Rng,
}

/// Greatest code of 24 bit.
const TOP: i32 = 8_388_607;

impl Fault {
    /// A fault of this kind to one of so many elements.
    pub fn draw(kind: Kind, elements: usize, random: &mut ChaCha8Rng) -> Self {
        let share = |random: &mut ChaCha8Rng| f64::from(random.next_u32()) / f64::from(u32::MAX);
        let element = random.next_u32() as usize % elements;
        let size = match kind {
            Kind::TooHot => 1.42 + 0.13 * share(random),
            Kind::Drift => (0.02 + 0.08 * share(random)) * if random.next_u32() & 1 == 0 { 1.0 } else { -1.0 },
            Kind::NoiseBurst => 0.001 * libm::pow(300.0, share(random)),
            _ => share(random),
        };
        let ticks = match kind {
            Kind::NoiseBurst => 1 + random.next_u32() % 10,
            Kind::DroppedLong | Kind::StaleLong | Kind::Silent => 2 + random.next_u32() % 9,
            Kind::DroppedOnce | Kind::StaleOnce | Kind::LateOnce | Kind::FlippedCode => 1,
            _ => u32::MAX,
        };
        let noise = random.clone();
        Self { kind, element, size, ticks, bits: random.next_u32(), stuck: None, noise }
    }

    /// Tells whether something is wrong with the readings in the tick that is its `t`-th.
    pub const fn is_on(&self, t: u32) -> bool {
        t < self.ticks
    }

    /// Tells whether it changes readings, in the ticks in which it is on.
    pub const fn changes_readings(&self) -> bool {
        let is_elsewhere = matches!(self.kind, Kind::Replayed | Kind::Upset | Kind::PowerCut);
        !self.kind.is_counted() && !is_elsewhere && self.kind.harm().is_none()
    }

    /// Tells whether the front end says anything at all then.
    pub const fn is_silent(&self, t: u32) -> bool {
        self.is_on(t) && matches!(self.kind, Kind::LateOnce | Kind::Silent)
    }

    /// Readings as they become by it.
    pub fn apply(&mut self, t: u32, readings: &mut [Reading]) {
        let (bits, size) = (self.bits, self.size);
        let Some(reading) = readings.get_mut(self.element).filter(|_| t < self.ticks) else { return };
        let Reading::Code(code) = *reading else { return };
        let scaled = |factor: f64| Reading::Code((f64::from(code) * factor).clamp(-8_388_608.0, f64::from(TOP)) as i32);
        *reading = match self.kind {
            Kind::Open => Reading::Code(TOP),
            Kind::Short => Reading::Code((bits % 2000) as i32),
            Kind::TooHot => scaled(size),
            Kind::Drift => scaled((1.0 + size).powi(t as i32 + 1)),
            Kind::StuckCode => Reading::Code(*self.stuck.get_or_insert(code)),
            Kind::NoiseBurst => {
                let normal: f64 = StandardNormal.sample(&mut self.noise);
                scaled(1.0 + size * normal)
            }
            Kind::FlippedCode => {
                // Bits 0 … 23; two of the four draws may be the same, and undo each other.
                let flips = (0..=(bits >> 20) % 4).fold(0_i32, |flips, n| flips ^ 1 << ((bits >> (5 * n)) % 24));
                Reading::Code((code ^ flips) << 8 >> 8)
            }
            Kind::DroppedOnce | Kind::DroppedLong => Reading::Missing,
            Kind::StaleOnce | Kind::StaleLong => Reading::Stale,
            _ => return,
        };
    }

    /// The command that new settings have when the supply fails, and a number that says when.
    pub fn interrupted(&self) -> (Command, u32) {
        let ticks = self.bits / 64;
        let command = if self.bits & 1 == 0 {
            let guard = GuardConfig { missing_limit_ticks: ticks, unreachable_limit_ticks: 100, stuck_limit_ticks: 0 };
            Command::Guard(guard)
        } else {
            let drive = Drive::Temperature { target_c: -20.0 - self.size as f32 };
            Command::Drive { element: self.element as u8, drive }
        };
        (command, ticks)
    }

    /// Bytes that come over the link by it; none if it is not one of those.
    pub fn bytes(&mut self) -> Option<Vec<u8>> {
        let commands = [
            Command::Stop,
            Command::Drive { element: self.element as u8, drive: Drive::Level(Level::High) },
            Command::Start,
            Command::Clear,
            Command::Acknowledge,
            Command::SamplePeriod { sample_period_s: 0.001 },
        ];
        // Stopping is always obeyed, and would not be a fault.
        let dangerous = ToBoard::Command(commands[1 + self.bits as usize % (commands.len() - 1)]);
        let frame = |message: &ToBoard| {
            encode(self.bits as u16, message, &mut [0; MAX_FRAME]).expect("it fits a frame").to_vec()
        };
        let mut bytes = frame(&dangerous);
        // No zero within.
        let mut any =
            |count: usize| -> Vec<u8> { (0..count).map(|_| (self.noise.next_u32() % 255) as u8 + 1).collect() };
        match self.kind {
            Kind::Garbage => bytes = [any(5 + self.bits as usize % 200), vec![0]].concat(),
            Kind::Truncated => {
                bytes.truncate(1 + self.bits as usize % (bytes.len() - 2));
                bytes.push(0);
            }
            Kind::Damaged => {
                let place = self.bits as usize % (bytes.len() - 1);
                let before = bytes[place];
                // A zero would cut the frame in two, which is the fault before this one.
                let bit = (0..8).map(|n| 1 << ((self.bits as usize / 64 + n) % 8)).find(|bit| before ^ bit != 0);
                bytes[place] ^= bit.unwrap_or(0);
            }
            Kind::Oversized => bytes = [any(MAX_FRAME + self.bits as usize % 500), vec![0]].concat(),
            Kind::Repeated => {
                let harmless = frame(&ToBoard::Telemetry { every: 1 });
                bytes = [harmless.clone(), harmless].concat();
            }
            Kind::Foreign => bytes = crate::foreign_frame(&[1, 6]),
            Kind::Replayed => {}
            _ => return None,
        }
        Some(bytes)
    }
}
