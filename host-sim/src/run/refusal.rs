//! A refused drive as a sentence about the key of the experiment that asks for it.

use dr_core::Parameter;
use dr_core::control::Refusal;
use dr_core::model::Reachability;

use crate::experiment::Experiment;

/// A refused drive in words, for the key that asks for it.
pub(super) fn of_a_drive(experiment: &Experiment, refusal: &Refusal) -> String {
    unreachable(experiment, refusal).unwrap_or_else(|| format!("is refused: {}", without_number(refusal)))
}

/// Whether a number stands in the head's file, and has passed its check: only the board can mind.
pub(super) const fn is_of_the_head(parameter: Parameter) -> bool {
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

/// Whether a number is a current that the experiment sets in place of the head's.
pub(super) fn is_of_the_currents(experiment: &Experiment, element: usize, parameter: Parameter) -> bool {
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
