//! Names of settings, as people write them: `guard`, `element.3`, `cross.0-2`, and of the plain
//! ones among them how a value is written.

use std::collections::BTreeMap;

use dr_core::Command;
use dr_core::control::GuardConfig;
use dr_core::wind::WindCommand;
use recording::text::suggest;
use wire::settings::{KeyNumber, SettingKey, SettingKind};
use wire::{Name, Setting};

/// Keys that `set` takes with a value.
pub const PLAIN: [&str; 11] = [
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

/// The name of a key, or its number if this program does not know it.
pub fn of(number: KeyNumber) -> String {
    let Some(SettingKey { kind, which }) = SettingKey::of_number(number) else { return format!("{number:#06x}") };
    let name = kind.name();
    match kind {
        SettingKind::Element
        | SettingKind::Model
        | SettingKind::Drive
        | SettingKind::SelfHeating
        | SettingKind::NusseltPoint
        | SettingKind::Surface
        | SettingKind::Tested
        | SettingKind::TestedAtStart => {
            format!("{name}.{which}")
        }
        SettingKind::FasterGains | SettingKind::CrossHeating => format!("{name}.{}-{}", which >> 4, which & 15),
        _ if which == 0 => name.to_owned(),
        _ => format!("{name}.{which}"),
    }
}

/// The number of a name, if it is one.
pub fn number(name: &str) -> Option<KeyNumber> {
    let (kind, which) = name.split_once('.').unwrap_or((name, "0"));
    let which = match which.split_once('-') {
        Some((high, low)) => {
            let (high, low): (u8, u8) = (high.parse().ok()?, low.parse().ok()?);
            (high < 16 && low < 16).then_some(high << 4 | low)?
        }
        None => which.parse().ok()?,
    };
    let number = SettingKey { kind: kind.parse().ok()?, which }.number();
    (of(number) == name).then_some(number)
}

/// Whether a key belongs to a head, and goes with it.
pub fn is_of_head(number: KeyNumber) -> bool {
    SettingKey::of_number(number).is_some_and(|key| (SettingKind::Fingerprint..SettingKind::Gas).contains(&key.kind))
}

/// Whether a key is of what the board writes by itself.
pub fn is_the_boards(number: KeyNumber) -> bool {
    SettingKey::of_number(number)
        .is_some_and(|key| matches!(key.kind, SettingKind::Tested | SettingKind::TestedAtStart))
}

/// Changes a plain setting.
///
/// # Errors
/// What is wrong with key or value, and what would be right.
pub fn set(settings: &mut BTreeMap<KeyNumber, Setting>, key: &str, value: &str) -> Result<(), SettingsError> {
    let setting = match key {
        "name" => {
            let (bytes, most) = (value.len(), Name::new().capacity());
            let long =
                |_| SettingsError(format!("name: {value:?} has {bytes} bytes, and a name has {most} at the most"));
            Setting::Name(Name::try_from(value).map_err(long)?)
        }
        "telemetry_every" => Setting::TelemetryEvery(parse(key, value, "a whole number of ticks from 0 to 65535")?),
        "sample_period_s" => {
            Setting::Command(Command::SamplePeriod { sample_period_s: parse(key, value, "a number of seconds")? })
        }
        "observe" => Setting::Command(Command::Observe { on: parse(key, value, "true or false")? }),
        "host_timeout_s" => {
            Setting::Command(Command::HostTimeout { timeout_s: parse(key, value, "a number of seconds, 0 for ever")? })
        }
        "fingerprint" if value == "measured" => fingerprint(settings)?,
        "fingerprint" => return Err(SettingsError(format!("fingerprint: {value:?} is not `measured`"))),
        "guard.missing_limit_ticks" | "guard.unreachable_limit_ticks" | "guard.stuck_limit_ticks" => {
            let mut guard = guard(settings);
            let ticks = parse(key, value, "a whole number of ticks that is not negative")?;
            match key {
                "guard.missing_limit_ticks" => guard.missing_limit_ticks = ticks,
                "guard.stuck_limit_ticks" => guard.stuck_limit_ticks = ticks,
                _ => guard.unreachable_limit_ticks = ticks,
            }
            Setting::Command(Command::Guard(guard))
        }
        "gas.pressure_pa" => gas(settings, Some(parse(key, value, "a number of Pa")?), None)?,
        "gas.temperature_c" => gas(settings, None, Some(parse(key, value, "a number of °C")?))?,
        _ => return Err(unknown(key)),
    };
    if let Some(key) = setting.key() {
        settings.insert(key.number(), setting);
    }
    Ok(())
}

fn unknown(key: &str) -> SettingsError {
    if number(key).is_some_and(is_of_head) {
        return SettingsError(format!(
            "`{key}` is not set by itself: `anemo board settings set --head FILE` sets a whole head"
        ));
    }
    SettingsError(format!("unknown key `{key}`; {}", suggest(key, PLAIN)))
}

fn parse<T: std::str::FromStr>(key: &str, value: &str, right: &str) -> Result<T, SettingsError> {
    value.parse().map_err(|_| SettingsError(format!("{key}: {value:?} is not {right}")))
}

fn guard(settings: &BTreeMap<KeyNumber, Setting>) -> GuardConfig {
    let kept = settings.values().find_map(|setting| match setting {
        Setting::Command(Command::Guard(guard)) => Some(*guard),
        _ => None,
    });
    kept.unwrap_or_default()
}

/// The resistances that the self-test of the last start has found.
fn fingerprint(settings: &BTreeMap<KeyNumber, Setting>) -> Result<Setting, SettingsError> {
    let (mut resistance_ohm, mut elements) = ([0.0; wire::MOST_ELEMENTS], 0);
    for setting in settings.values() {
        let Setting::Command(Command::Element { element, config }) = setting else { continue };
        let tested = SettingKey { kind: SettingKind::TestedAtStart, which: *element }.number();
        let found_c = settings.get(&tested).and_then(|tested| match tested {
            Setting::Tested(record) if record.finding.faults.is_none() => record.finding.temperature_c,
            _ => None,
        });
        let missing = || format!("fingerprint: element {element} has not passed a self-test since the last start");
        let found_c = found_c.ok_or_else(|| SettingsError(missing()))?;
        let slot = resistance_ohm.get_mut(usize::from(*element));
        *slot.ok_or_else(|| SettingsError(missing()))? = config.channel.platinum().resistance_ohm(found_c);
        elements += 1;
    }
    if elements == 0 {
        return Err(SettingsError(
            "fingerprint: no head is kept: `anemo board settings set --head FILE` first".to_owned(),
        ));
    }
    Ok(Setting::Command(Command::Fingerprint { resistance_ohm }))
}

fn gas(
    settings: &BTreeMap<KeyNumber, Setting>,
    new_pa: Option<f32>,
    new_c: Option<f32>,
) -> Result<Setting, SettingsError> {
    let kept = settings.values().find_map(|setting| match setting {
        Setting::Command(Command::Wind(WindCommand::Gas { pressure_pa, temperature_c })) => {
            Some((*pressure_pa, *temperature_c))
        }
        _ => None,
    });
    let pressure_pa = new_pa.or(kept.map(|(pressure_pa, _)| pressure_pa));
    let pressure_pa =
        pressure_pa.ok_or_else(|| SettingsError("gas.temperature_c: set gas.pressure_pa first".to_owned()))?;
    let temperature_c = new_c.or(kept.and_then(|(_, temperature_c)| temperature_c));
    Ok(Setting::Command(Command::Wind(WindCommand::Gas { pressure_pa, temperature_c })))
}

/// Names the key, what is wrong with it, and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SettingsError(pub(super) String);

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::control::{ElementConfig, Limits, SelfTestFinding};
    use dr_core::sensor::{Channel, Platinum};
    use wire::settings::TestRecord;

    #[test]
    fn every_key_has_a_name_that_leads_back_to_it() {
        let keys: Vec<SettingKey> = (0..=KeyNumber::MAX).filter_map(SettingKey::of_number).collect();
        assert_eq!(keys.len(), 25 * 256);
        for number in keys.iter().map(|key| key.number()) {
            assert_eq!(super::number(&of(number)), Some(number), "{}", of(number));
        }
        assert_eq!(of(0x2212), "cross.1-2");
        assert_eq!(of(0x7712), "0x7712");
        assert_eq!([number("cross.16-0"), number("elements.0"), number("guard.x")], [None; 3]);
    }

    #[test]
    fn a_fingerprint_is_what_the_self_test_of_the_start_has_measured() {
        let mut settings = BTreeMap::new();
        let mut put = |setting: Setting| settings.insert(setting.key().unwrap().number(), setting);
        let platinum = Platinum::iec60751(1000.0).unwrap();
        let channel = Channel::new(platinum, 1e-6, 1e-3, 3e-3).unwrap();
        let limits = Limits {
            resistance_min_ohm: 500.0,
            resistance_max_ohm: 1500.0,
            temperature_max_c: 70.0,
            code_max: 8_000_000,
            energy: None,
        };
        put(Setting::Command(Command::Element { element: 0, config: ElementConfig { channel, limits } }));
        let mut tested =
            TestRecord { unix_s: None, firmware: Name::new(), starts: 1, finding: SelfTestFinding::default() };
        tested.finding.temperature_c = Some(100.0);
        put(Setting::Tested(tested.clone()));
        assert!(set(&mut settings, "fingerprint", "guessed").unwrap_err().to_string().contains("`measured`"));
        set(&mut settings, "fingerprint", "measured").unwrap();
        let mut expected = [0.0; wire::MOST_ELEMENTS];
        expected[0] = platinum.resistance_ohm(100.0);
        assert_eq!(
            settings.get(&number("fingerprint").unwrap()),
            Some(&Setting::Command(Command::Fingerprint { resistance_ohm: expected }))
        );
        tested.finding.faults.0 = 4;
        settings.insert(number("tested_at_start.0").unwrap(), Setting::Tested(tested));
        let refused = set(&mut settings, "fingerprint", "measured").unwrap_err().to_string();
        assert!(refused.contains("element 0 has not passed a self-test"), "{refused}");
        let nothing = set(&mut BTreeMap::new(), "fingerprint", "measured").unwrap_err().to_string();
        assert!(nothing.contains("set --head FILE"), "{nothing}");
    }

    #[test]
    fn what_cannot_be_set_is_said_with_what_can() {
        let mut settings = BTreeMap::new();
        let mut refused = |key: &str, value: &str| set(&mut settings, key, value).unwrap_err().to_string();
        assert_eq!(refused("nmae", "x"), "unknown key `nmae`; did you mean `name`?");
        assert!(refused("element.0", "x").contains("set --head FILE"));
        assert!(refused("name", &"x".repeat(33)).contains("has 33 bytes, and a name has 32"));
        assert_eq!(refused("observe", "yes"), "observe: \"yes\" is not true or false");
        assert!(refused("guard.missing_limit_ticks", "-1").contains("is not a whole number of ticks"));
        assert!(refused("gas.temperature_c", "-53").contains("gas.pressure_pa first"));
        set(&mut settings, "guard.missing_limit_ticks", "7").unwrap();
        set(&mut settings, "guard.unreachable_limit_ticks", "70").unwrap();
        set(&mut settings, "guard.stuck_limit_ticks", "9").unwrap();
        let expected = GuardConfig { missing_limit_ticks: 7, unreachable_limit_ticks: 70, stuck_limit_ticks: 9 };
        assert_eq!(guard(&settings), expected);
    }
}
