//! Setting an instrument up for a run, command by command in the order that it needs.

use super::error::InstrumentError;
use super::port::InstrumentPort;
use dr_core::control::{Drive, ElementConfig, GuardConfig, Refusal, Trip};
use dr_core::model::SelfHeatingConfig;
use dr_core::wind::WindCommand;
use dr_core::{Command, Reply};

/// Sent before any command that heats: time enough for the next command to be repeated until it
/// arrives.
pub const ARM: Command = Command::Arm { window_s: 30.0 };

/// The set-up of an instrument for a run.
#[derive(Debug, Clone, PartialEq)]
pub struct InstrumentSetup {
    /// Length of a tick, s.
    pub sample_period_s: f32,
    /// Limits of the guard.
    pub guard: GuardConfig,
    /// Whether the observers run on what is measured, and the samples carry their powers.
    pub observe: bool,
    /// The elements, in order.
    pub elements: Vec<ElementSetup>,
    /// What the anemometer has to know; nothing for a head without a calibration.
    pub wind: Vec<WindCommand>,
}

/// One element of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementSetup {
    /// Its name, for people.
    pub name: String,
    /// Wiring and limits.
    pub config: ElementConfig,
    /// Its diffusive model, if there is one.
    pub model: Option<SelfHeatingConfig>,
    /// What it shall do.
    pub drive: Drive,
}

/// Brings an instrument from whatever it does to running this set-up.
///
/// # Errors
/// The first command that is refused; the instrument is in standby then, or tripped as it was
/// before.
pub fn start(instrument: &mut dyn InstrumentPort, setup: &InstrumentSetup) -> Result<Reply, InstrumentError> {
    configure(instrument, setup)?;
    instrument.command(ARM)?;
    Ok(match instrument.command(Command::Start)? {
        // It runs, but what it said got lost: that much is known here as well.
        Reply::Done => judged(setup),
        started @ Reply::Started { .. } => started,
    })
}

/// Brings an instrument from whatever it does to standby, knowing this set-up.
///
/// # Errors
/// As [`start`].
pub fn configure(instrument: &mut dyn InstrumentPort, setup: &InstrumentSetup) -> Result<(), InstrumentError> {
    let board = usize::from(instrument.identity().elements);
    if setup.elements.len() > board {
        return Err(InstrumentError::TooManyElements { head: setup.elements.len(), board });
    }
    instrument.command(Command::Stop)?;
    instrument.command(Command::Clear)?;
    instrument.command(Command::SamplePeriod { sample_period_s: setup.sample_period_s })?;
    instrument.command(Command::Guard(setup.guard))?;
    if setup.observe {
        instrument.command(Command::Observe { on: true })?;
    }
    for (element, of) in (0_u8..).zip(&setup.elements) {
        instrument.command(Command::Element { element, config: of.config })?;
        if let Some(model) = of.model {
            instrument.command(Command::Model { element, model })?;
        }
        instrument.command(Command::Drive { element, drive: of.drive })?;
    }
    for wind in &setup.wind {
        instrument.command(Command::Wind(*wind))?;
    }
    Ok(())
}

/// Brings a tripped instrument back to standby; one that is not tripped stays as it is.
///
/// # Errors
/// If the instrument cannot be reached.
pub fn acknowledge(instrument: &mut dyn InstrumentPort) -> Result<(), InstrumentError> {
    match instrument.command(Command::Acknowledge) {
        Ok(_) | Err(InstrumentError::Refused(Refusal::NotTripped)) => Ok(()),
        Err(error) => Err(error),
    }
}

/// How many set-points a model has judged, and how many none could.
fn judged(setup: &InstrumentSetup) -> Reply {
    let (with, without): (Vec<_>, Vec<_>) = (setup.elements.iter())
        .filter(|element| element.drive.target_range_c().is_some())
        .partition(|element| element.model.is_some());
    Reply::Started { judged: with.len() as u8, unjudged: without.len() as u8 }
}

/// A trip in words.
pub fn tripped(trip: Trip, setup: &InstrumentSetup) -> InstrumentError {
    let names: Vec<&str> = setup.elements.iter().map(|element| &*element.name).collect();
    InstrumentError::Tripped { cause: trip.cause.name(), element: place(trip, &names) }
}

/// What of a head tripped, for people.
pub fn place(trip: Trip, names: &[&str]) -> String {
    match trip.element {
        None => "the whole instrument".to_owned(),
        Some(element) => {
            names.get(usize::from(element)).map_or_else(|| format!("element {element}"), |&name| name.to_owned())
        }
    }
}

/// Names the element that a refusal is about, which the instrument knows by number only.
pub fn name_element(refusal: &Refusal, setup: &InstrumentSetup) -> Option<String> {
    let element = match *refusal {
        Refusal::NoSuchElement { element }
        | Refusal::NotConfigured { element }
        | Refusal::Unreachable { element, .. } => element,
        Refusal::Invalid { element, .. } => element?,
        _ => return None,
    };
    setup.elements.get(usize::from(element)).map(|element| element.name.clone())
}
