//! A station that is watched: whatever it is told and given, what has to hold is looked at after
//! every tick and every command.
//!
//! **After a tick.** A heater is at its high level only while the instrument runs, or alone in a
//! self-test, and only if its element's reading of that very tick is one that a resistor as it was
//! configured can have within its limits; that is worked out here in f64 from the commands that
//! were taken. Of every valid reading temperature and power are numbers, and so is a wind that is
//! not said to have failed.
//!
//! **After a command.** One that was refused has changed nothing.

use dr_core::control::{Cause, ElementConfig, HardwareLimits, Heaters, Refusal, RunState, SelfTestPlan, Tick, Trip};
use dr_core::sensor::{Level, Reading};
use dr_core::wind::QualityFlags;
use dr_core::{Command, Instrument, Reply};

/// Number of elements that the watched station has room for.
pub const ELEMENTS: usize = 3;

/// The station, and what is known of it from outside.
pub struct Watched {
    station: Instrument<ELEMENTS>,
    /// Last configuration of each element.
    configs: [Option<ElementConfig>; ELEMENTS],
    /// Levels since the last tick, at which the next readings are taken.
    levels: Heaters,
}

impl Default for Watched {
    fn default() -> Self {
        Self::new()
    }
}

impl Watched {
    /// One that knows nothing yet.
    pub fn new() -> Self {
        Self { station: Instrument::new(&HardwareLimits::SIMULATED), configs: [None; ELEMENTS], levels: Heaters(0) }
    }

    /// To look at.
    pub const fn station(&self) -> &Instrument<ELEMENTS> {
        &self.station
    }

    /// Levels as they stand.
    pub const fn levels(&self) -> Heaters {
        self.levels
    }

    /// The code of an element at this share of the way between its limits of resistance, at the
    /// level that it has.
    pub fn code(&self, element: usize, share: f64) -> i32 {
        let Some(config) = self.config(element) else { return 0 };
        let level = if self.levels.is_high(element) { Level::High } else { Level::Low };
        let (least, most) = (f64::from(config.limits.resistance_min_ohm), f64::from(config.limits.resistance_max_ohm));
        let volt = (least + share * (most - least)) * f64::from(config.channel.current_a(level));
        (volt / volt_per_code(config)) as i32
    }

    /// Configuration of an element.
    pub fn config(&self, element: usize) -> Option<&ElementConfig> {
        self.configs.get(element)?.as_ref()
    }

    /// Tells it something.
    ///
    /// # Errors
    /// What it answers.
    ///
    /// # Panics
    /// If a refusal has changed something.
    pub fn tell(&mut self, command: Command) -> Result<Reply, Refusal> {
        let before = self.station.clone();
        let state = before.controller().state();
        let told = self.station.handle(command);
        match (&told, command) {
            (Err(refusal), _) => {
                super::sentences::said(&refusal.to_string());
                // A flipped bit that a command brings to light is the one thing that a refusal
                // changes: it trips.
                let is_upset = self.station.controller().bit_flips() > before.controller().bit_flips();
                assert!(
                    is_upset || same(&self.station, &before),
                    "{command:?} was refused ({refusal}) and yet changed something"
                );
                if is_upset {
                    assert!(matches!(
                        self.station.controller().state(),
                        RunState::Tripped(Trip { cause: Cause::BitFlip, .. })
                    ));
                }
            }
            (Ok(_), Command::Clear) => self.configs = [None; ELEMENTS],
            (Ok(_), Command::Acknowledge) if matches!(state, RunState::Tripped(Trip { cause: Cause::BitFlip, .. })) => {
                self.configs = [None; ELEMENTS];
            }
            (Ok(_), Command::Element { element, config }) => {
                if let Some(place) = self.configs.get_mut(usize::from(element)) {
                    *place = Some(config);
                }
            }
            (Ok(_), Command::Start) => {
                assert!(before.controller().is_armed(), "started without being armed");
                assert_eq!(self.station.controller().state(), RunState::Running);
            }
            (Ok(_), Command::SelfTest(SelfTestPlan { pulse_s: Some(_), .. })) => {
                assert!(before.controller().is_armed(), "a test that heats without being armed");
                assert_eq!(self.station.controller().state(), RunState::Testing);
            }
            (Ok(_), Command::SelfTest(_)) => assert_eq!(self.station.controller().state(), state),
            _ => {}
        }
        told
    }

    /// Flips a bit somewhere inside; whether there was one to flip.
    pub fn upset(&mut self, which: usize, element: usize, bit: u32) -> bool {
        self.station.flip_bit(which, element, bit).is_some()
    }

    /// Both halves of a tick.
    ///
    /// # Panics
    /// If something does not hold after it.
    pub fn tick(&mut self, readings: &[Reading; ELEMENTS]) -> Tick<ELEMENTS> {
        let before = self.station.controller().state();
        let tick = self.station.tick(readings);
        let wind = self.station.sense(&tick);
        assert_eq!(tick.state, self.station.controller().state());
        if let Some(trip) = tick.trip {
            assert_eq!(tick.state, RunState::Tripped(trip));
        }
        for heats in [RunState::Running, RunState::Testing] {
            assert!(before == heats || tick.state != heats, "it began to heat by itself: {tick:?}");
        }
        if matches!(tick.state, RunState::Tripped(Trip { cause: Cause::BitFlip, .. })) {
            // Its knowledge is wrong, and so may be its messages; until that is acknowledged it
            // heats nothing.
            assert_eq!(tick.heaters, Heaters(0), "heated after an upset");
            self.levels = tick.heaters;
            return tick;
        }
        let configured = self.configs.iter().flatten().count();
        assert_eq!(usize::from(tick.elements), configured);
        assert_eq!((tick.heaters.0 | tick.valid) >> configured, 0, "an element that there is not");
        assert_eq!(tick.heaters.0 & !tick.valid, 0, "heated without a valid reading: {tick:?}");
        match tick.state {
            RunState::Running => {}
            RunState::Testing => {
                assert!(tick.heaters.0.count_ones() <= 1, "heated more than one in a self-test: {tick:?}")
            }
            state => assert_eq!(tick.heaters, Heaters(0), "heated while {state:?}"),
        }
        for (i, &reading) in readings.iter().enumerate() {
            if tick.valid >> i & 1 == 0 {
                continue;
            }
            assert!(
                self.can_be(i, reading),
                "element {i} is said to be valid with {reading:?} of {:?}",
                self.configs[i]
            );
            let (temperature_c, power_w) = (tick.temperature_c[i], tick.power_w[i]);
            assert!(temperature_c.is_finite() && power_w.is_finite() && power_w >= 0.0, "{tick:?}");
        }
        if let Some(wind) = wind.filter(|wind| !wind.quality_flags.has(QualityFlags::FAILED)) {
            let told = wind.wind;
            assert!(told.wind_m_s.iter().chain([&told.speed_m_s]).all(|number| number.is_finite()), "{wind:?}");
        }
        self.levels = tick.heaters;
        tick
    }

    /// Tells whether a reading is one of an element within its limits.
    fn can_be(&self, i: usize, reading: Reading) -> bool {
        let (Some(config), Reading::Code(code)) = (&self.configs[i], reading) else { return false };
        let level = if self.levels.is_high(i) { Level::High } else { Level::Low };
        let ohm = f64::from(code) * volt_per_code(config) / f64::from(config.channel.current_a(level));
        // On the very limit f32 may decide otherwise.
        let within = 1e-5 * ohm.abs();
        let limits = &config.limits;
        let c = f64::from(config.channel.platinum().temperature_c(ohm as f32));
        code.unsigned_abs() < limits.code_max.unsigned_abs()
            && ohm >= f64::from(limits.resistance_min_ohm) - within
            && ohm <= f64::from(limits.resistance_max_ohm) + within
            && c <= f64::from(limits.temperature_max_c) + 1e-3 * c.abs().max(1.0)
    }
}

/// By the resistance that one code means, V.
pub fn volt_per_code(config: &ElementConfig) -> f64 {
    f64::from(config.channel.resistance_ohm(1, Level::Low)) * f64::from(config.channel.current_a(Level::Low))
}

/// Equal, or of the same words where a number is none and so not equal to itself.
fn same(a: &Instrument<ELEMENTS>, b: &Instrument<ELEMENTS>) -> bool {
    a == b || format!("{a:?}") == format!("{b:?}")
}
