//! Part of an experiment that a model can predict: its elements and drives in its winds.

use diffusive::model::pair_class::element;
use diffusive::model::{ALL, Model};
use diffusive::predict::loop_model::of_another_gas;
use diffusive::predict::scenario::{Heated, Heater, Scenario};
use dr_core::control::Drive;
use recording::text::suggest;

use super::checked::Experiment;

/// Why a model cannot predict an experiment, and what could be done.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct ScenarioError(String);

/// An experiment as a model sees it, and notes for the user.
///
/// # Errors
/// Inputs that are no elements of the head, winds that the model has not seen, drives that change,
/// a gas that swings.
pub fn scenario(experiment: &Experiment, model: &Model) -> Result<(Scenario, Vec<String>), ScenarioError> {
    let names = experiment.head.names();
    let mut notes = Vec::new();
    if let Some(change) = experiment.changes.first() {
        return Err(ScenarioError(format!(
            "the experiment changes its drives at {} s, and a prediction is of drives that stay: predict its parts one by one",
            experiment.time_s(change.tick)
        )));
    }
    for (of, swing) in [("gas", experiment.gas_swing), ("support", experiment.support_swing)] {
        let Some(swing) = swing else { continue };
        return Err(ScenarioError(format!(
            "the {of} of the experiment swings by {} K, and a prediction is of a {of} that stays: leave out `{of}.swing`, or predict for the {of} of one moment",
            swing.amplitude_k
        )));
    }
    if experiment.wind.is_empty() {
        return Err(ScenarioError(
            "the experiment has no wind, and a prediction is of one: write one [[wind]]".to_owned(),
        ));
    }
    let mut elements = Vec::with_capacity(model.inputs.len());
    for input in &model.inputs {
        let name = element(input);
        let Some(at) = names.iter().position(|known| recording::in_columns(known) == name) else {
            let (head, hint) = (&experiment.head.name, suggest(name, names.iter().copied()));
            return Err(ScenarioError(format!("the model's input `{input}` is no element of head `{head}`; {hint}")));
        };
        let heater = Heater::Resistor(experiment.head.elements[at].config.channel);
        elements.push(Heated { name: names[at].to_owned(), drive: experiment.drives[at], heater });
    }
    let strangers: Vec<&str> = (names.iter().zip(&experiment.drives))
        .filter(|(name, drive)| **drive != Drive::Passive && !elements.iter().any(|own| own.name == **name))
        .map(|(name, _)| *name)
        .collect();
    if !strangers.is_empty() {
        notes.push(format!("the model knows nothing of {}, which are heated as well", strangers.join(", ")));
    }
    let follows = model.wind.as_ref().is_some_and(|wind| wind.following.is_some());
    let another_gas = of_another_gas(model, Some(experiment.gas_temperature_c));
    if let Some(own) = &model.provenance.conditions {
        let differences = own.differences(&experiment.conditions(), !follows && another_gas.is_none());
        if !differences.is_empty() {
            notes.push(format!(
                "the experiment runs {}: the model's resistances and offset are of its own record, and do not change with that",
                differences.join(", ")
            ));
        }
    }
    notes.extend(another_gas);
    if let [first, ..] = experiment.field.keys()[..] {
        notes.push(format!("effects of the field are left out, such as `{first}`: a model is of one surrounding"));
    }
    if let Some(fault) = experiment.faults.first() {
        notes.push(format!("faults are left out: {} breaks at {} s", names[fault.element], fault.start_s));
    }
    let mut winds = Vec::with_capacity(experiment.wind.len());
    for entry in &experiment.wind {
        let first = (entry.start_s.max(0.0) / experiment.sample_period_s).round() as usize;
        winds.push((first, class(model, &entry.label, experiment.wind.len())?));
        if let Some(what) = entry.planned().first() {
            return Err(ScenarioError(format!(
                "the wind `{}` of the experiment has a `{what}`, and a class of the model is a steady wind: leave it out, or step from wind to wind",
                entry.label
            )));
        }
        if entry.turbulence.is_some() && !notes.iter().any(|note| note.starts_with("turbulence")) {
            notes.push("turbulence is left out: a class of the model is a steady wind".to_owned());
        }
    }
    let scenario = Scenario {
        sample_period_s: experiment.sample_period_s,
        ticks: experiment.ticks as usize,
        winds,
        elements,
        gas_c: Some(experiment.gas_temperature_c),
    };
    Ok((scenario, notes))
}

/// The model's class of a wind. A model without classes answers for an experiment in one wind.
fn class(model: &Model, label: &str, winds: usize) -> Result<usize, ScenarioError> {
    if let Some(class) = model.classes.iter().position(|known| known == label) {
        return Ok(class);
    }
    if model.classes.len() == 1 && model.classes[0] == ALL {
        let sentence = || {
            format!(
                "the experiment has {winds} winds and the model knows of none: identify it from a record with events"
            )
        };
        return (winds == 1).then_some(0).ok_or_else(|| ScenarioError(sentence()));
    }
    let hint = suggest(label, model.classes.iter().map(String::as_str));
    Err(ScenarioError(format!("the wind `{label}` of the experiment is no class of the model; {hint}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffusive::model::testing;
    use recording::toml_file::TomlSource;

    /// A shipped experiment with changes, and a model of `sector1` in its winds.
    fn experiment(name: &str, changes: &[(&str, &str)]) -> Experiment {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments").join(name);
        let mut source = TomlSource::read(&path).unwrap();
        for (from, to) in changes {
            assert!(source.text.contains(from), "{from}");
            source.text = source.text.replace(from, to);
        }
        Experiment::from_source(source).unwrap()
    }

    fn model(input: &str, classes: &[&str]) -> Model {
        let mut model = testing::model(&[0.5], &[10.0]);
        model.inputs = vec![format!("power_w_{input}")];
        let own = model.pairs[0].classes["all"].clone();
        model.classes = classes.iter().map(|label| (*label).to_owned()).collect();
        model.pairs[0].classes = model.classes.iter().map(|label| (label.clone(), own.clone())).collect();
        model
    }

    #[test]
    fn winds_become_classes_and_other_heaters_are_remarked_upon() {
        let experiment = experiment("all-drives.toml", &[]);
        let (scenario, notes) = super::scenario(&experiment, &model("sector2", &["gust", "breeze"])).unwrap();
        assert_eq!(scenario.winds, [(0, 1), (6000, 0)]);
        let classes = scenario.classes();
        assert_eq!((classes.len(), classes[5999], classes[6000]), (12_000, 1, 0));
        assert_eq!((scenario.elements.len(), scenario.elements[0].name.as_str()), (1, "sector2"));
        assert!(matches!(scenario.elements[0].drive, Drive::Power { .. }));
        assert!(notes[0].contains("nothing of sector1, sector3, sector4, core1"), "{notes:?}");
        assert!(notes[1].starts_with("turbulence is left out"), "{notes:?}");
    }

    #[test]
    fn winds_that_change_by_a_plan_are_refused() {
        let gust = "turbulence = { intensity = 0.15, correlation_time_s = 1.5 }";
        for (what, value) in [
            ("gust", "{ start_s = 1.0, duration_s = 2.0, rise_m_s = 1.0 }"),
            ("sine", "{ amplitude_m_s = 1.0, frequency_hz = 1.0 }"),
            ("swing", "{ amplitude_deg = 10.0, frequency_hz = 1.0 }"),
            ("dust_devil", "{ time_s = 1.0, miss_m = 5.0, core_radius_m = 5.0, swirl_m_s = 10.0 }"),
        ] {
            let experiment = experiment("all-drives.toml", &[(gust, &format!("{what} = {value}"))]);
            let sentence =
                super::scenario(&experiment, &model("sector2", &["gust", "breeze"])).unwrap_err().to_string();
            let expected =
                format!("the wind `gust` of the experiment has a `{what}`, and a class of the model is a steady");
            assert!(sentence.contains(&expected), "{sentence}");
        }
        let spectrum = "turbulence = { spectrum = \"kaimal\", intensity = 0.15, height_m = 1.5 }";
        let experiment = experiment("all-drives.toml", &[(gust, spectrum)]);
        let (_, notes) = super::scenario(&experiment, &model("sector2", &["gust", "breeze"])).unwrap();
        assert!(notes.iter().any(|note| note.starts_with("turbulence is left out")), "{notes:?}");
    }

    #[test]
    fn strangers_are_refused_with_the_nearest_that_is_known() {
        let experiment = experiment("all-drives.toml", &[]);
        let refused = |model: &Model| super::scenario(&experiment, model).unwrap_err().to_string();
        assert!(refused(&model("sector9", &["gust", "breeze"])).contains("is no element of head `sphere-b`; "));
        let sentence = refused(&model("sector1", &["gusts", "breeze"]));
        assert!(sentence.contains("wind `gust` of the experiment is no class of the model; did you mean `gusts`?"));
        assert!(refused(&model("sector1", &[ALL])).contains("has 2 winds and the model knows of none"));
    }

    #[test]
    fn a_gas_that_swings_is_refused() {
        let gas =
            ("temperature_c = -53.15\n", "temperature_c = -53.15\nswing = { amplitude_k = 2.0, period_s = 60.0 }\n");
        let sentence = super::scenario(&experiment("all-drives.toml", &[gas]), &model("sector1", &["gust", "breeze"]))
            .unwrap_err()
            .to_string();
        assert!(
            sentence.starts_with("the gas of the experiment swings by 2 K, and a prediction is of a gas"),
            "{sentence}"
        );
    }

    #[test]
    fn another_gas_than_the_records_is_said() {
        let experiment = experiment("all-drives.toml", &[]);
        let mut model = model("sector1", &["gust", "breeze"]);
        let said = |model: &Model| super::scenario(&experiment, model).unwrap().1.join("; ");
        let own = experiment.conditions();
        model.provenance.conditions = Some(own.clone());
        assert!(!said(&model).contains("instead of"));
        model.provenance.conditions = Some(diffusive::model::Conditions { pressure_pa: 700.0, ..own });
        assert!(said(&model).contains("runs at 1000 Pa instead of 700 Pa: the model's resistances and offset"));
    }
}
