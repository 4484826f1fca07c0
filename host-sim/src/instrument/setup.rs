//! What an instrument is told before a run, in the order in which it has to be told.

use super::{Instrument, InstrumentError};
use dr_core::control::{Command, Drive, ElementConfig, GuardConfig, Refusal, Reply};
use dr_core::model::SelfHeatingConfig;

/// Everything that an instrument has to know of an experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Length of a tick, s.
    pub sample_period_s: f32,
    /// Patience of the guard.
    pub guard: GuardConfig,
    /// The elements, in order.
    pub elements: Vec<ElementSetup>,
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
/// The first command that is refused; the instrument is in standby then, or tripped as it was before.
pub fn start(instrument: &mut dyn Instrument, setup: &Setup) -> Result<Reply, InstrumentError> {
    let board = usize::from(instrument.identity().elements);
    if setup.elements.len() > board {
        return Err(InstrumentError::TooManyElements { head: setup.elements.len(), board });
    }
    instrument.command(Command::Stop)?;
    instrument.command(Command::Clear)?;
    instrument.command(Command::SamplePeriod { sample_period_s: setup.sample_period_s })?;
    instrument.command(Command::Guard(setup.guard))?;
    for (element, of) in (0_u8..).zip(&setup.elements) {
        instrument.command(Command::Element { element, config: of.config })?;
        if let Some(model) = of.model {
            instrument.command(Command::Model { element, model })?;
        }
        instrument.command(Command::Drive { element, drive: of.drive })?;
    }
    instrument.command(Command::Start)
}

/// Names the element that a refusal is about, which the instrument knows by number only.
pub fn name_element(refusal: &Refusal, setup: &Setup) -> Option<String> {
    let element = match *refusal {
        Refusal::NoSuchElement { element }
        | Refusal::NotConfigured { element }
        | Refusal::Unreachable { element, .. } => element,
        Refusal::Invalid { element, .. } => element?,
        Refusal::Tripped(trip) => trip.element,
        Refusal::NotInStandby | Refusal::NotTripped | Refusal::NoSamplePeriod => return None,
    };
    setup.elements.get(usize::from(element)).map(|element| element.name.clone())
}
