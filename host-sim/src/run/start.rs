//! Setting an instrument up for an experiment: the same steps for a rehearsal in this process and
//! for the run itself.
//!
//! A refusal becomes a sentence about the key of the experiment that asks for it.

use dr_core::control::{Drive, Refusal};
use dr_core::model::Reachability;
use dr_core::{Command, Parameter};
use wire::BoardKind;

use super::error::RunError;
use crate::experiment::{DriveChange, Experiment};
use crate::instrument::in_process::{self, InProcess};
use crate::instrument::setup::{self, fits_boards};
use crate::instrument::{InstrumentError, InstrumentPort, LockStep};

/// Number of set-points of an experiment, those of its changes included, that can be held by a
/// model, and how many have no model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct SetPointJudgement {
    /// Set-points that a model says can be held.
    pub judged: u32,
    /// Set-points without a model.
    pub unjudged: u32,
}

/// Lets a controller in this process judge the set-up and all changes before any instrument is
/// touched: one that grants what a board of this kind does, or all that there can be without one.
pub fn rehearse(experiment: &Experiment, board: Option<BoardKind>) -> Result<SetPointJudgement, RunError> {
    // The sensor around it does not matter: no time passes.
    let sensor = experiment.simulated(&experiment.sensor_config().unwrap_or_default())?;
    let mut instrument = match board {
        Some(board) => Box::new(LockStep::new(InProcess::of(board), sensor)),
        None => in_process::of_head(experiment.head.elements.len(), sensor),
    };
    let judgement = start(experiment, instrument.as_mut())?;
    if board.is_some() {
        fits_boards(&setup_of(experiment)?).map_err(|error| of_the_head(experiment, &error))?;
    }
    for change in &experiment.changes {
        change_drives(experiment, instrument.as_mut(), change, &mut |_, _| ())?;
    }
    Ok(judgement)
}

/// Sets an instrument up for an experiment and starts it.
///
/// A refusal names the key of the file where the user can do something about it.
pub fn start(experiment: &Experiment, instrument: &mut dyn InstrumentPort) -> Result<SetPointJudgement, RunError> {
    let names = experiment.head.names();
    setup::start(instrument, &setup_of(experiment)?).map_err(|error| match &error {
        InstrumentError::Refused(Refusal::Tripped(trip)) => {
            InstrumentError::Tripped { cause: trip.cause.name(), element: setup::place(*trip, &names) }.into()
        }
        InstrumentError::Refused(Refusal::Invalid { element, error }) if is_of_the_head(error.parameter) => {
            let of = element.map(usize::from).and_then(|element| Some((element, *names.get(element)?)));
            let (key, of) = match of {
                Some((element, name)) if is_of_the_currents(experiment, element, error.parameter) => {
                    (format!("currents.{name}"), String::new())
                }
                Some((_, name)) => ("head".to_owned(), format!("{name}: ")),
                None => ("head".to_owned(), String::new()),
            };
            experiment.source.refuse(&key, format!("asks for what this board does not grant: {of}{error}")).into()
        }
        InstrumentError::Refused(refusal) => match element_of(refusal).and_then(|element| names.get(element)) {
            // It names the key where the user can do something about it.
            Some(name) => experiment.source.refuse(&format!("drives.{name}"), of_a_drive(experiment, refusal)).into(),
            None => error.into(),
        },
        InstrumentError::TooManyElements { .. } => of_the_head(experiment, &error),
        _ => RunError::from(error),
    })?;
    let mut judgement = SetPointJudgement::default();
    let later = experiment.changes.iter().flat_map(|change| &change.drives).map(|(element, drive)| (*element, drive));
    for (element, drive) in experiment.drives.iter().enumerate().chain(later) {
        match (drive.target_range_c(), experiment.model(element)) {
            (None, _) => {}
            (Some(_), Some(_)) => judgement.judged += 1,
            (Some(_), None) => judgement.unjudged += 1,
        }
    }
    Ok(judgement)
}

/// The refusal of a head that is too large.
fn of_the_head(experiment: &Experiment, error: &InstrumentError) -> RunError {
    experiment.source.refuse("head", format!("cannot be used: {error}")).into()
}

/// The element that a refusal is about.
fn element_of(refusal: &Refusal) -> Option<usize> {
    match *refusal {
        Refusal::NoSuchElement { element }
        | Refusal::NotConfigured { element }
        | Refusal::Unreachable { element, .. } => Some(element.into()),
        Refusal::Invalid { element, .. } => element.map(usize::from),
        _ => None,
    }
}

/// The set-up of an instrument for an experiment, in the order that it needs.
///
/// # Errors
/// If the head's calibration cannot output the wind as the experiment asks.
pub fn setup_of(experiment: &Experiment) -> Result<Vec<Command>, RunError> {
    let sample_period_s = experiment.sample_period_s;
    let mut commands = vec![
        Command::SamplePeriod { sample_period_s: sample_period_s as f32 },
        Command::Guard(experiment.head.guard_config(sample_period_s)),
    ];
    commands.extend(experiment.host_timeout_s.map(|timeout_s| Command::HostTimeout { timeout_s }));
    commands.extend(experiment.observe.then_some(Command::Observe { on: true }));
    for (i, (of, &drive)) in experiment.head.elements.iter().zip(&experiment.drives).enumerate() {
        let element = i as u8;
        commands.push(Command::Element { element, config: of.config });
        commands.extend(experiment.model(i).map(|model| Command::Model { element, model }));
        commands.push(Command::Drive { element, drive });
    }
    commands.extend(experiment.wind_commands()?.into_iter().map(Command::Wind));
    Ok(commands)
}

/// Sets what the elements of an instrument do from now on. In lock-step that is the tick that comes
/// next, on a board one soon after.
///
/// `taken` is called with every drive that begins.
///
/// # Errors
/// A refusal, by its key in the file; none of a tripped instrument, which keeps its heaters low.
pub fn change_drives(
    experiment: &Experiment,
    instrument: &mut dyn InstrumentPort,
    change: &DriveChange,
    taken: &mut dyn FnMut(usize, Drive),
) -> Result<(), RunError> {
    if change.drives.iter().any(|(_, drive)| drive.can_heat()) {
        match instrument.command(setup::ARM) {
            Ok(_) | Err(InstrumentError::Refused(Refusal::Tripped(_))) => {}
            Err(error) => return Err(error.into()),
        }
    }
    for &(place, drive) in &change.drives {
        match instrument.command(Command::Drive { element: place as u8, drive }) {
            Ok(_) => taken(place, drive),
            // Heaters stay low from the trip on, whatever the experiment asks for; the samples
            // report it.
            Err(InstrumentError::Refused(Refusal::Tripped(_))) => return Ok(()),
            Err(InstrumentError::Refused(refusal)) => {
                let at = experiment.changes.iter().position(|own| own == change).unwrap_or_default();
                let name = &experiment.head.elements[place].name;
                let sentence = of_a_drive(experiment, &refusal);
                return Err(experiment.source.refuse(&format!("changes[{at}].drives.{name}"), sentence).into());
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// A refused drive in words, for the key that asks for it.
fn of_a_drive(experiment: &Experiment, refusal: &Refusal) -> String {
    unreachable(experiment, refusal).unwrap_or_else(|| format!("is refused: {}", without_number(refusal)))
}

/// Tells whether a number stands in the head's file, and has passed its check: only the board can
/// mind.
const fn is_of_the_head(parameter: Parameter) -> bool {
    use Parameter as P;
    matches!(
        parameter,
        P::VoltPerCode
            | P::CurrentLowA
            | P::CurrentHighA
            | P::TemperatureMaxC
            | P::ResistanceMaxOhm
            | P::SustainedPowerW
            | P::EnergyJ
            | P::StuckLimitTicks
    )
}

/// Tells whether a number is a current that the experiment sets in place of the head's.
fn is_of_the_currents(experiment: &Experiment, element: usize, parameter: Parameter) -> bool {
    matches!(parameter, Parameter::CurrentLowA | Parameter::CurrentHighA) && experiment.currents.contains(&element)
}

/// The instrument knows elements by number; the key of the file has the name.
fn without_number(refusal: &Refusal) -> String {
    let words = refusal.to_string();
    match words.strip_prefix("element ").and_then(|rest| rest.split_once(' ')) {
        Some((number, rest)) if number.ends_with(':') => rest.to_owned(),
        Some((_, rest)) => format!("it {rest}"),
        None => words,
    }
}

/// A model's verdict in temperatures, and whose verdict it is.
fn unreachable(experiment: &Experiment, refusal: &Refusal) -> Option<String> {
    let Refusal::Unreachable { element, target_c, verdict } = *refusal else { return None };
    let reference_c = experiment.model(usize::from(element))?.reference_c;
    let bound = match verdict {
        Reachability::LowLevelTooWarm { least_rise_k } => {
            format!("even at the low level it ends at {:.1} °C", reference_c + least_rise_k)
        }
        Reachability::HighLevelTooCold { most_rise_k } => {
            format!("at the high level it ends at {:.1} °C", reference_c + most_rise_k)
        }
        Reachability::Reachable { .. } => return None,
    };
    let models = experiment.models.as_ref()?;
    Some(format!(
        "asks for {target_c} °C, which cannot be held: {bound}, by {} (for {})",
        models.source.path.display(),
        models.conditions
    ))
}
