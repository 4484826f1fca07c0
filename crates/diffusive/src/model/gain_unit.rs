//! The unit of a model's resistances, as far as the names of its columns state it.

use super::ModelError;
use super::content::Model;
use recording::stated_unit;

/// The unit of the resistances from all inputs to an output: K/W of a temperature in °C and powers
/// in W. `None` if a name states no unit, or two inputs have different ones.
pub fn gain_unit(model: &Model, output: &str) -> Option<String> {
    let mut inputs = model.pairs.iter().filter(|pair| pair.output == output).map(|pair| stated_unit(&pair.input));
    let input = inputs.next()??;
    let rise = rise_unit(output)?;
    inputs.all(|other| other == Some(input)).then(|| format!("{rise}/{input}"))
}

/// The unit of differences of a column, if its name states one: a rise of temperature is in K.
pub fn rise_unit(column: &str) -> Option<&str> {
    match stated_unit(column)? {
        "°C" => Some("K"),
        other => Some(other),
    }
}

/// Refuses a model in other units than W and °C, where numbers have these units: in loops and on
/// the board.
///
/// # Errors
/// If the name of a column states another unit.
pub fn refuse_other_units(model: &Model) -> Result<(), ModelError> {
    let inputs = model.inputs.iter().map(|name| (name, ["W"; 2]));
    let outputs = model.outputs.iter().map(|output| (&output.name, ["°C", "K"]));
    let stated = inputs.chain(outputs).filter_map(|(name, right)| Some((name, stated_unit(name)?, right)));
    match { stated }.find(|(_, unit, right)| !right.contains(unit)) {
        Some((name, unit, right)) => Err(model_error!(
            "column `{name}` is in {unit}, where {} is needed: identify again with powers in W and temperatures in °C",
            right[0]
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::testing;

    #[test]
    fn milliwatts_are_not_taken_for_watts() {
        for (input, output, refused) in [
            ("Heater (mW)", "T1 [°C]", Some("column `Heater (mW)` is in mW, where W is needed")),
            ("power_mw", "T_degC", Some("column `power_mw` is in mW")),
            ("power_w", "T/mK (mK)", Some("column `T/mK (mK)` is in mK, where °C is needed")),
            ("power_w_film", "temperature_c_film", None),
            ("heater", "T", None),
        ] {
            let mut model = testing::model(&[1.0], &[2.0]);
            (model.inputs[0], model.outputs[0].name) = (input.to_owned(), output.to_owned());
            let sentence = refuse_other_units(&model).err().map(|error| error.to_string());
            assert_eq!(sentence.is_some(), refused.is_some(), "{input}: {sentence:?}");
            assert!(sentence.unwrap_or_default().starts_with(refused.unwrap_or_default()));
        }
    }

    #[test]
    fn names_of_columns_state_the_unit_or_nothing_does() {
        let unit = |input: &str, output: &str| {
            let mut model = testing::model(&[1.0], &[2.0]);
            (model.pairs[0].input, model.pairs[0].output) = (input.to_owned(), output.to_owned());
            gain_unit(&model, output)
        };
        assert_eq!(unit("power_w", "temperature_c").as_deref(), Some("K/W"));
        assert_eq!(unit("Heizleistung [mW]", "Temperatur (degC)").as_deref(), Some("K/mW"));
        assert_eq!(unit("power_mw", "T_degC").as_deref(), Some("K/mW"));
        assert_eq!(unit("P/uW", "oven/°C").as_deref(), Some("K/µW"));
        assert_eq!(unit("Heater (W)", "Bridge (V)").as_deref(), Some("V/W"));
        for (input, output) in [("heater", "temperature_c"), ("power_w", "T"), ("power_w", "T (at the far end)")] {
            assert_eq!(unit(input, output), None, "{input}, {output}");
        }
    }

    #[test]
    fn inputs_of_two_units_have_no_common_one() {
        let mut model = testing::model(&[1.0], &[2.0]);
        let mut other = model.pairs[0].clone();
        other.input = "current_ma (mA)".to_owned();
        model.pairs.push(other);
        assert_eq!(gain_unit(&model, &model.pairs[0].output), None);
    }
}
