//! Reading and changing what a board keeps, and the rehearsal before anything is written.

use std::collections::BTreeMap;

use dr_core::control::{HardwareLimits, Refusal};
use dr_core::{Command, Instrument};
use wire::settings::KeyNumber;
use wire::{MOST_ELEMENTS, Setting, SettingsRefusal, SettingsReply, SettingsRequest};

use super::kept::KeptSetting;
use super::names::{self, SettingsError};
use crate::instrument::setup::fits_boards;
use crate::instrument::{InstrumentError, SettingsPort};
use anemometry::head::Head;
use anemometry::head::WindOutput;

/// All that a board keeps, and whether it is what was written to it.
///
/// # Errors
/// If the board cannot be reached, or cannot read its flash.
pub fn read_all(board: &mut dyn SettingsPort) -> Result<(Vec<KeptSetting>, bool), InstrumentError> {
    let whole = match board.ask_settings(&SettingsRequest::Check) {
        Ok(_) => true,
        Err(InstrumentError::Settings(SettingsRefusal::NotWhole)) => false,
        Err(error) => return Err(error),
    };
    let (mut all, mut after) = (Vec::new(), None);
    while let SettingsReply::Value { key, value, unusable } = board.ask_settings(&SettingsRequest::Next { after })? {
        if after.is_some_and(|after| key <= after) {
            return Err(InstrumentError::Protocol(format!("key {key:#06x} came after {after:#06x?}")));
        }
        after = Some(key);
        let setting = unusable.map_or_else(|| Setting::read(key, &value), Err);
        all.push(KeptSetting { number: key, value, setting });
    }
    Ok((all, whole))
}

/// The settings that can be used, by their keys.
pub fn usable(kept: &[KeptSetting]) -> BTreeMap<KeyNumber, Setting> {
    kept.iter().filter_map(|kept| Some((kept.number, kept.setting.clone().ok()?))).collect()
}

/// Sets a controller of this process up by all of it, as a board with these limits would be
/// set up.
///
/// # Errors
/// The first that it does not take, or what boards have no room for.
pub fn rehearse(settings: &BTreeMap<KeyNumber, Setting>, limits: &'static HardwareLimits) -> Result<(), SettingsError> {
    let commands = settings.values().filter_map(|setting| match setting {
        Setting::Command(command) => Some(command),
        _ => None,
    });
    fits_boards(commands).map_err(|error| SettingsError(error.to_string()))?;
    let mut station = Instrument::<MOST_ELEMENTS>::new(limits);
    for (&number, setting) in settings {
        let Setting::Command(command) = setting else { continue };
        station.handle(*command).map_err(|refusal| {
            let first = if refusal == Refusal::NoSamplePeriod { "; set sample_period_s first" } else { "" };
            SettingsError(format!("{}: {refusal}{first}", names::of(number)))
        })?;
    }
    Ok(())
}

/// Changes what a board keeps from one set to another, and sets it up by that. Returns how many
/// values were written and how many erased. What the board writes by itself stays.
///
/// Each value changes by itself: should the supply fail meanwhile, each is the old one or the new
/// one, and doing it again goes on.
///
/// # Errors
/// If the board cannot be reached, or refuses.
pub fn change(
    board: &mut dyn SettingsPort,
    from: &[KeptSetting],
    to: &BTreeMap<KeyNumber, Setting>,
) -> Result<(usize, usize), InstrumentError> {
    let (mut written, mut erased) = (0, 0);
    for kept in from.iter().filter(|kept| !to.contains_key(&kept.number) && !names::is_the_boards(kept.number)) {
        board.ask_settings(&SettingsRequest::Erase { key: kept.number })?;
        erased += 1;
    }
    for (&key, setting) in to {
        if names::is_the_boards(key) {
            continue;
        }
        let value = setting.value().map_err(|error| InstrumentError::Protocol(error.to_string()))?;
        if from.iter().any(|kept| kept.number == key && kept.value == value) {
            continue;
        }
        board.ask_settings(&SettingsRequest::Store { key, value })?;
        written += 1;
    }
    board.ask_settings(&SettingsRequest::Load)?;
    Ok((written, erased))
}

/// A head as settings: guard, elements and calibration, in place of all that is kept of another
/// head.
///
/// # Errors
/// If the calibration cannot be used at this sample period, or boards have no room for the head.
pub fn of_head(
    head: &Head,
    sample_period_s: f64,
    settings: &mut BTreeMap<KeyNumber, Setting>,
) -> Result<(), SettingsError> {
    settings.retain(|&number, _| !names::is_of_head(number));
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
    for command in commands {
        let setting = Setting::Command(command);
        if let Some(key) = setting.key() {
            settings.insert(key.number(), setting);
        }
    }
    Ok(())
}

/// The sample period among some settings, s.
pub fn sample_period_s(settings: &BTreeMap<KeyNumber, Setting>) -> Option<f32> {
    settings.values().find_map(|setting| match setting {
        Setting::Command(Command::SamplePeriod { sample_period_s }) => Some(*sample_period_s),
        _ => None,
    })
}
