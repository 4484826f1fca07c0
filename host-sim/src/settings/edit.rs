//! Settings as one record: its bytes, and its values by their keys.

use dr_core::Command;
use dr_core::control::GuardConfig;
use dr_core::wind::WindCommand;
use recording::text::suggest;
use serde_json::Value;
use wire::settings::{Preface, command_bytes, take_command};
use wire::{Name, TestRecord, Unusable};

use crate::instrument::setup::fits_boards;
use anemometry::head::{Head, WindOutput};

/// Keys of the values, in the order of a set-up.
pub const KEYS: [&str; 9] =
    ["name", "telemetry_every", "sample_period_s", "guard", "observe", "host_timeout_s", "fingerprint", "head", "gas"];

/// Keys that [`Settings::set`] takes with a value.
const PLAIN: [&str; 11] = [
    "name",
    "telemetry_every",
    "sample_period_s",
    "guard.missing_limit_ticks",
    "guard.unreachable_limit_ticks",
    "guard.stuck_limit_ticks",
    "observe",
    "host_timeout_s",
    "fingerprint",
    "gas.pressure_pa",
    "gas.temperature_c",
];

/// Settings of a board.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// Name and telemetry.
    pub preface: Preface,
    /// Commands that set the instrument up.
    commands: Vec<Command>,
}

/// Names the key, what is wrong with it, and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SettingsError(pub(super) String);

/// The key of a command of a set-up.
pub(super) const fn key(command: &Command) -> &'static str {
    match command {
        Command::SamplePeriod { .. } => "sample_period_s",
        Command::Guard(_) => "guard",
        Command::Observe { .. } => "observe",
        Command::HostTimeout { .. } => "host_timeout_s",
        Command::Fingerprint { .. } => "fingerprint",
        Command::Wind(WindCommand::Gas { .. }) => "gas",
        _ => "head",
    }
}

impl Settings {
    /// Settings without a command.
    pub const fn new(preface: Preface) -> Self {
        Self { preface, commands: Vec::new() }
    }

    /// Commands that set the instrument up, in their order.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// Encodes the record.
    ///
    /// # Errors
    /// If a command is longer than any may be.
    pub fn bytes(&self) -> Result<Vec<u8>, SettingsError> {
        let error = |error| SettingsError(format!("settings cannot be encoded: {error}"));
        let mut bytes = self.preface.bytes().map_err(error)?.to_vec();
        for command in &self.commands {
            bytes.extend(command_bytes(command).map_err(error)?);
        }
        Ok(bytes)
    }

    /// Decodes a record; an empty one has the defaults.
    ///
    /// # Errors
    /// If it cannot be used.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Unusable> {
        if bytes.is_empty() {
            return Ok(Self::default());
        }
        let (preface, mut rest) = Preface::take(bytes)?;
        let mut commands = Vec::new();
        while !rest.is_empty() {
            let (command, after) = take_command(rest)?;
            commands.push(command);
            rest = after;
        }
        Ok(Self { preface, commands })
    }

    /// Adds a command. Of each key but the head there is one.
    pub fn put(&mut self, command: Command) {
        let key = key(&command);
        if key != "head" {
            self.commands.retain(|kept| self::key(kept) != key);
        }
        self.commands.push(command);
        self.commands.sort_by_key(|command| KEYS.iter().position(|key| *key == self::key(command)));
    }

    /// The values that hold for keys of which there is none.
    pub(super) fn defaults() -> Self {
        let mut defaults = Self::default();
        defaults.put(Command::Guard(GuardConfig::default()));
        defaults.put(Command::Observe { on: false });
        defaults.put(Command::HostTimeout { timeout_s: dr_core::HOST_TIMEOUT_S });
        defaults
    }

    /// The value of a key, as JSON.
    pub(super) fn value(&self, key: &str) -> Option<Value> {
        let mut of_key = self.commands.iter().filter(|command| self::key(command) == key);
        match key {
            "name" => Some(self.preface.name.as_str().into()),
            "telemetry_every" => Some(self.preface.telemetry_every.into()),
            "head" => {
                let commands: Vec<&Command> = of_key.collect();
                let elements = commands.iter().filter(|command| matches!(command, Command::Element { .. })).count();
                let is_calibrated = commands.iter().any(|command| matches!(command, Command::Wind(_)));
                let calibrated = if is_calibrated { ", calibrated" } else { "" };
                (!commands.is_empty()).then(|| format!("{elements} elements{calibrated}").into())
            }
            _ => of_key.next().map(content),
        }
    }

    /// Changes the value of a key.
    ///
    /// # Errors
    /// What is wrong with key or value, and what would be right.
    pub fn set(&mut self, key: &str, value: &str, at_start: Option<&TestRecord>) -> Result<(), SettingsError> {
        let command = match key {
            "name" => {
                let (bytes, most) = (value.len(), Name::new().capacity());
                let long =
                    |_| SettingsError(format!("name: {value:?} has {bytes} bytes, and a name has {most} at the most"));
                self.preface.name = Name::try_from(value).map_err(long)?;
                return Ok(());
            }
            "telemetry_every" => {
                self.preface.telemetry_every = parse(key, value, "a whole number of ticks from 0 to 65535")?;
                return Ok(());
            }
            "sample_period_s" => Command::SamplePeriod { sample_period_s: parse(key, value, "a number of seconds")? },
            "observe" => Command::Observe { on: parse(key, value, "true or false")? },
            "host_timeout_s" => {
                Command::HostTimeout { timeout_s: parse(key, value, "a number of seconds, 0 for ever")? }
            }
            "fingerprint" if value == "measured" => self.fingerprint(at_start)?,
            "fingerprint" => return Err(SettingsError(format!("fingerprint: {value:?} is not `measured`"))),
            "guard.missing_limit_ticks" | "guard.unreachable_limit_ticks" | "guard.stuck_limit_ticks" => {
                let guard = |command: &Command| if let Command::Guard(guard) = command { Some(*guard) } else { None };
                let mut guard = self.commands.iter().find_map(guard).unwrap_or_default();
                let ticks = parse(key, value, "a whole number of ticks that is not negative")?;
                match key {
                    "guard.missing_limit_ticks" => guard.missing_limit_ticks = ticks,
                    "guard.stuck_limit_ticks" => guard.stuck_limit_ticks = ticks,
                    _ => guard.unreachable_limit_ticks = ticks,
                }
                Command::Guard(guard)
            }
            "gas.pressure_pa" => self.gas(Some(parse(key, value, "a number of Pa")?), None)?,
            "gas.temperature_c" => self.gas(None, Some(parse(key, value, "a number of °C")?))?,
            "head" => {
                return Err(SettingsError(
                    "`head` is set as a whole: `anemo board settings set --head FILE`".to_owned(),
                ));
            }
            _ => return Err(SettingsError(format!("unknown key `{key}`; {}", suggest(key, PLAIN)))),
        };
        self.put(command);
        Ok(())
    }

    /// Removes the value of a key: its default holds then. The fingerprint goes with its head.
    ///
    /// # Errors
    /// If there is no such key.
    pub fn erase(&mut self, key: &str) -> Result<(), SettingsError> {
        match key {
            "name" => self.preface.name = Preface::default().name,
            "telemetry_every" => self.preface.telemetry_every = Preface::default().telemetry_every,
            _ if !KEYS.contains(&key) => {
                return Err(SettingsError(format!("unknown key `{key}`; {}", suggest(key, KEYS))));
            }
            "head" => self.commands.retain(|command| !["head", "fingerprint"].contains(&self::key(command))),
            _ => self.commands.retain(|command| self::key(command) != key),
        }
        Ok(())
    }

    /// Puts a head in the place of the one before: guard, elements and calibration.
    ///
    /// # Errors
    /// If the calibration cannot be used at this sample period, or boards have no room for the head.
    pub fn set_head(&mut self, head: &Head, sample_period_s: f64) -> Result<(), SettingsError> {
        let mut commands = vec![
            Command::SamplePeriod { sample_period_s: sample_period_s as f32 },
            Command::Guard(head.guard_config(sample_period_s)),
        ];
        for (element, of) in (0_u8..).zip(&head.elements) {
            commands.push(Command::Element { element, config: of.config });
        }
        if let Some(calibration) = &head.calibration {
            let answering = WindOutput::new(None, None, false, sample_period_s);
            let made = calibration.commands(&answering, sample_period_s);
            let (wind, _) = made.map_err(|error| SettingsError(error.to_string()))?;
            commands.extend(wind.into_iter().map(Command::Wind));
        }
        fits_boards(&commands).map_err(|error| SettingsError(error.to_string()))?;
        self.erase("head")?;
        commands.into_iter().for_each(|command| self.put(command));
        Ok(())
    }

    /// The sample period, s.
    pub fn sample_period_s(&self) -> Option<f32> {
        self.commands.iter().find_map(|command| match command {
            Command::SamplePeriod { sample_period_s } => Some(*sample_period_s),
            _ => None,
        })
    }

    /// The resistances that the self-test of the last start has found.
    fn fingerprint(&self, at_start: Option<&TestRecord>) -> Result<Command, SettingsError> {
        let (mut resistance_ohm, mut elements) = ([0.0; wire::MOST_ELEMENTS], 0);
        for command in &self.commands {
            let Command::Element { element, config } = command else { continue };
            let finding = at_start.and_then(|test| test.findings.iter().find(|finding| finding.element == *element));
            let found_c = finding.filter(|finding| finding.faults.is_none()).and_then(|finding| finding.temperature_c);
            let missing = || {
                SettingsError(format!("fingerprint: element {element} has not passed a self-test since the last start"))
            };
            let slot = resistance_ohm.get_mut(usize::from(*element)).ok_or_else(missing)?;
            *slot = config.channel.platinum().resistance_ohm(found_c.ok_or_else(missing)?);
            elements += 1;
        }
        if elements == 0 {
            return Err(SettingsError(
                "fingerprint: no head is kept: `anemo board settings set --head FILE` first".to_owned(),
            ));
        }
        Ok(Command::Fingerprint { resistance_ohm })
    }

    fn gas(&self, new_pa: Option<f32>, new_c: Option<f32>) -> Result<Command, SettingsError> {
        let kept = self.commands.iter().find_map(|command| match command {
            Command::Wind(WindCommand::Gas { pressure_pa, temperature_c }) => Some((*pressure_pa, *temperature_c)),
            _ => None,
        });
        let pressure_pa = new_pa.or(kept.map(|(pressure_pa, _)| pressure_pa));
        let pressure_pa =
            pressure_pa.ok_or_else(|| SettingsError("gas.temperature_c: set gas.pressure_pa first".to_owned()))?;
        let temperature_c = new_c.or(kept.and_then(|(_, temperature_c)| temperature_c));
        Ok(Command::Wind(WindCommand::Gas { pressure_pa, temperature_c }))
    }
}

fn parse<T: std::str::FromStr>(key: &str, value: &str, right: &str) -> Result<T, SettingsError> {
    value.parse().map_err(|_| SettingsError(format!("{key}: {value:?} is not {right}")))
}

/// The values of a command, without its name; a single value without its own.
fn content(command: &Command) -> Value {
    if let Command::Fingerprint { resistance_ohm } = command {
        // Elements that are compared come first.
        return resistance_ohm.iter().copied().take_while(|&of_element| of_element > 0.0).collect();
    }
    let mut value = serde_json::to_value(command).unwrap_or_default();
    while let Value::Object(parts) = &value
        && parts.len() == 1
        && let Some(inner) = parts.values().next()
    {
        value = inner.clone();
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::control::{ElementConfig, HardwareLimits, Limits, SelfTestFaults, SelfTestFinding};
    use dr_core::sensor::{Channel, Platinum};

    fn head(path: &str) -> Head {
        Head::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)).unwrap()
    }

    #[test]
    fn a_head_of_more_elements_than_a_board_has_is_refused() {
        let mut head = head("heads/sphere-b.toml");
        let first = head.elements[0].clone();
        head.elements.resize(24, first);
        let refused = Settings::default().set_head(&head, 0.01).unwrap_err();
        assert_eq!(refused.to_string(), "the head has 24 elements, boards have room for 16");
    }

    #[test]
    fn a_head_replaces_all_of_the_one_before_and_nothing_else() {
        let mut settings = Settings::default();
        settings.set("name", "north \"mast\" ° 1", None).unwrap();
        settings.set("gas.pressure_pa", "700", None).unwrap();
        settings.set_head(&head("tests/fixtures/sphere-b-calibrated.toml"), 0.001).unwrap();
        settings.put(Command::Fingerprint { resistance_ohm: [1000.0; wire::MOST_ELEMENTS] });
        assert!(settings.commands().len() > 80, "{}", settings.commands().len());
        crate::settings::rehearse(&settings, &HardwareLimits::SIMULATED).unwrap();
        assert_eq!(Settings::from_bytes(&settings.bytes().unwrap()), Ok(settings.clone()));
        assert_eq!(settings.value("head"), Some("7 elements, calibrated".into()));
        settings.set_head(&head("heads/sphere-b.toml"), 0.002).unwrap();
        let mut expected = Settings::default();
        expected.set_head(&head("heads/sphere-b.toml"), 0.002).unwrap();
        expected.set("name", "north \"mast\" ° 1", None).unwrap();
        expected.set("gas.pressure_pa", "700", None).unwrap();
        assert_eq!(settings, expected);
        for key in KEYS {
            settings.erase(key).unwrap();
        }
        assert_eq!(settings, Settings::default());
    }

    #[test]
    fn a_fingerprint_is_what_the_self_test_of_the_start_has_measured() {
        let mut settings = Settings::default();
        let platinum = Platinum::iec60751(1000.0).unwrap();
        let channel = Channel::new(platinum, 1e-6, 1e-3, 3e-3).unwrap();
        let limits = Limits {
            resistance_min_ohm: 500.0,
            resistance_max_ohm: 1500.0,
            temperature_max_c: 70.0,
            code_max: 8_000_000,
            energy: None,
        };
        let finding = SelfTestFinding { temperature_c: Some(100.0), ..SelfTestFinding::default() };
        let mut test =
            TestRecord { unix_s: None, firmware: Name::new(), starts: 1, findings: [finding].into_iter().collect() };
        let nothing = settings.set("fingerprint", "measured", Some(&test)).unwrap_err().to_string();
        assert!(nothing.contains("set --head FILE"), "{nothing}");
        settings.put(Command::Element { element: 0, config: ElementConfig { channel, limits } });
        assert!(settings.set("fingerprint", "guessed", Some(&test)).unwrap_err().to_string().contains("`measured`"));
        settings.set("fingerprint", "measured", Some(&test)).unwrap();
        let mut resistance_ohm = [0.0; wire::MOST_ELEMENTS];
        resistance_ohm[0] = platinum.resistance_ohm(100.0);
        assert_eq!(settings.commands()[0], Command::Fingerprint { resistance_ohm });
        test.findings[0].faults = SelfTestFaults(4);
        for test in [Some(&test), None] {
            let refused = settings.set("fingerprint", "measured", test).unwrap_err().to_string();
            assert!(refused.contains("element 0 has not passed a self-test"), "{refused}");
        }
    }

    #[test]
    fn what_cannot_be_set_is_said_with_what_can() {
        let mut settings = Settings::default();
        let mut refused = |key: &str, value: &str| settings.set(key, value, None).unwrap_err().to_string();
        assert_eq!(refused("nmae", "x"), "unknown key `nmae`; did you mean `name`?");
        assert!(refused("head", "x").contains("set --head FILE"));
        assert!(refused("name", &"x".repeat(33)).contains("has 33 bytes, and a name has 32"));
        assert_eq!(refused("observe", "yes"), "observe: \"yes\" is not true or false");
        assert!(refused("guard.missing_limit_ticks", "-1").contains("is not a whole number of ticks"));
        assert!(refused("gas.temperature_c", "-53").contains("gas.pressure_pa first"));
        assert!(settings.erase("gurad").unwrap_err().to_string().contains("did you mean `guard`?"));
        settings.set("guard.missing_limit_ticks", "7", None).unwrap();
        settings.set("guard.unreachable_limit_ticks", "70", None).unwrap();
        settings.set("guard.stuck_limit_ticks", "9", None).unwrap();
        let guard = GuardConfig { missing_limit_ticks: 7, unreachable_limit_ticks: 70, stuck_limit_ticks: 9 };
        assert_eq!(settings.commands(), [Command::Guard(guard)]);
    }
}
