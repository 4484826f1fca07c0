//! Numbers of a model that are meant: those of one pair of input and output, in one event class.

use super::ModelError;
use super::content::{Class, Model, Pair, Structure};
use super::gain_unit::gain_unit;
use recording::is_pair;
use recording::text::suggest;

/// One pair in one class.
#[derive(Debug, Clone, Copy)]
pub struct PairClass<'a> {
    /// The model.
    pub model: &'a Model,
    /// The pair.
    pub pair: &'a Pair,
    /// Label of the class.
    pub label: &'a str,
    /// The symbol: of structure `conductance`, that of the reference.
    pub class: &'a Class,
    /// Conductance by which the wind of this class takes from the element, W/K; `None` where the
    /// class has a symbol of its own.
    pub wind_w_per_k: Option<f64>,
}

impl<'a> PairClass<'a> {
    /// Finds a part. A pair is `INPUT:OUTPUT`, where `power_w_x` and `temperature_c_y` may be
    /// called `x` and `y`. Both may be left out where there is one only; structure `conductance`
    /// then means its reference.
    ///
    /// # Errors
    /// What there is to choose from.
    pub fn find(model: &'a Model, pair: Option<&str>, label: Option<&str>) -> Result<Self, ModelError> {
        let pair = find_pair(model, pair)?;
        let only = || match (&model.wind, &model.classes[..]) {
            (Some(wind), _) => Ok(wind.reference.as_str()),
            (None, [label]) => Ok(label.as_str()),
            (None, labels) => {
                Err(model_error!("the model has {} classes: name one with --class: {}", labels.len(), listed(labels)))
            }
        };
        let label = label.map_or_else(only, Ok)?;
        let Some(known) = model.classes.iter().find(|known| *known == label) else {
            let hint = suggest(label, model.classes.iter().map(String::as_str));
            return Err(model_error!("the model has no class `{label}`; {hint}"));
        };
        if let (Structure::Conductance, Some(wind)) = (model.structure, &model.wind) {
            let class = pair.classes.values().next().ok_or_else(|| model_error!("{} has no class", name(pair)))?;
            let element = model.inputs.iter().position(|input| *input == pair.input).unwrap_or(0);
            let conductance = wind.elements.get(element).and_then(|element| element.get(known)).map(|dg| dg.value);
            let wind_w_per_k = conductance.filter(|_| *known != wind.reference);
            return Ok(Self { model, pair, label: known, class, wind_w_per_k });
        }
        let class = pair.classes.get(known);
        let class = class.ok_or_else(|| unseen(pair, label))?;
        Ok(Self { model, pair, label: known, class, wind_w_per_k: None })
    }

    /// Tells whether output and input belong to the same element, as far as the order of the
    /// columns tells.
    pub fn is_self_heating(&self) -> bool {
        let input = self.model.inputs.iter().position(|input| *input == self.pair.input);
        let output = self.model.outputs.iter().position(|output| output.name == self.pair.output);
        input == output
    }

    /// Refuses a pair whose output is another element's.
    ///
    /// # Errors
    /// If the pair is cross-heating.
    pub fn refuse_cross_heating(&self) -> Result<(), ModelError> {
        let pair = name(self.pair);
        let sentence = "is cross-heating: no loop measures here and heats there";
        if self.is_self_heating() { Ok(()) } else { Err(model_error!("{pair} {sentence}")) }
    }

    /// Refuses a class that is only the reference's symbol in a wind.
    ///
    /// # Errors
    /// If the class has no symbol of its own.
    pub fn refuse_wind(&self) -> Result<(), ModelError> {
        let (Some(w_per_k), Some(wind)) = (self.wind_w_per_k, &self.model.wind) else { return Ok(()) };
        let (label, reference) = (self.label, &wind.reference);
        Err(model_error!(
            "class `{label}` has no symbol of its own: it is that of `{reference}` with {w_per_k} W/K of wind in its input. Name class `{reference}`, or export the response or the netlist, which know the wind"
        ))
    }

    /// Temperature of the output without heating, °C.
    pub fn offset_c(&self) -> f64 {
        let output = self.model.outputs.iter().find(|output| output.name == self.pair.output);
        output.map_or(self.model.offset_c, |output| output.offset_c)
    }

    /// Warning to the reader of an export: that the record could not support the model, or what the
    /// export leaves out.
    pub fn warning(&self) -> Option<String> {
        let linear = self.model.losses.is_some().then(|| {
            "the model's losses grow with temperature, w = u - g (T - T_0)^2, and this is its linear part: the answer to little power".to_owned()
        });
        let both: Vec<String> = self.warning_beside_losses().into_iter().chain(linear).collect();
        (!both.is_empty()).then(|| both.join("; "))
    }

    /// The same of an export that knows growing losses.
    pub fn warning_beside_losses(&self) -> Option<String> {
        let warnings = self.model.warnings.join("; ");
        let unsupported = self.model.reservation().map(|verdict| format!("{verdict}: {warnings}"));
        let still = self.model.following().map(|following| {
            format!(
                "the model follows gas or surroundings, and this is its answer to power only: the offset belongs to surroundings that stay at {} °C",
                following.from_c
            )
        });
        let unit = gain_unit(self.model, &self.pair.output).filter(|unit| unit != "K/W").map(|unit| {
            format!("numbers are in {unit} as the columns of the record, where names of columns here say K/W")
        });
        let both: Vec<String> = unsupported.into_iter().chain(still).chain(unit).collect();
        (!both.is_empty()).then(|| both.join("; "))
    }

    /// Time by which the output is late, s.
    pub fn dead_time_s(&self) -> f64 {
        self.pair.dead_time_samples as f64 * self.model.sample_period_s
    }
}

/// Name of a pair in sentences.
pub fn name(pair: &Pair) -> String {
    format!("pair {} → {}", pair.input, pair.output)
}

/// Part behind the quantity in a column's name, or the whole of it: `sector1` of `power_w_sector1`.
pub fn element(column: &str) -> &str {
    recording::element_of(column).unwrap_or(column)
}

/// The error for a class in which a pair was never seen.
pub fn unseen(pair: &Pair, label: &str) -> ModelError {
    model_error!("{} has no class `{label}`: the record never showed it", name(pair))
}

fn find_pair<'a>(model: &'a Model, wanted: Option<&str>) -> Result<&'a Pair, ModelError> {
    let full = |pair: &Pair| format!("{}:{}", pair.input, pair.output);
    let all: Vec<String> = model.pairs.iter().map(full).collect();
    let Some(wanted) = wanted else {
        return match &model.pairs[..] {
            [only] => Ok(only),
            _ => Err(model_error!("the model has {} pairs: name one with --pair: {}", all.len(), listed(&all))),
        };
    };
    let is_wanted = |pair: &&Pair| {
        is_pair(wanted, &pair.input, &pair.output) || is_pair(wanted, element(&pair.input), element(&pair.output))
    };
    let found = model.pairs.iter().find(is_wanted);
    found.ok_or_else(|| model_error!("the model has no pair `{wanted}`; it has {}", listed(&all)))
}

fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;

    fn two_pairs() -> Model {
        let mut model = testing::model(&[0.5], &[10.0]);
        model.inputs.push("power_w_b".to_owned());
        model.pairs.push(Pair { input: "power_w_b".to_owned(), ..model.pairs[0].clone() });
        model
    }

    #[test]
    fn the_only_pair_and_class_need_no_name() {
        let model = testing::model(&[0.5], &[10.0]);
        let part = PairClass::find(&model, None, None).unwrap();
        assert_eq!((part.label, part.offset_c(), part.is_self_heating()), ("all", 20.0, true));
    }

    #[test]
    fn several_pairs_are_listed_and_found_by_long_and_short_names() {
        let model = two_pairs();
        let sentence = PairClass::find(&model, None, None).unwrap_err().to_string();
        assert_eq!(
            sentence,
            "the model has 2 pairs: name one with --pair: `power_w_a:temperature_c_a`, `power_w_b:temperature_c_a`"
        );
        for name in ["b:a", "power_w_b:temperature_c_a"] {
            let part = PairClass::find(&model, Some(name), None).unwrap();
            assert_eq!(part.pair.input, "power_w_b");
            assert!(!part.is_self_heating());
        }
        assert!(
            PairClass::find(&model, Some("c:a"), None)
                .unwrap_err()
                .to_string()
                .starts_with("the model has no pair `c:a`; it has")
        );
    }

    #[test]
    fn several_classes_are_listed() {
        let mut model = testing::model(&[0.5], &[10.0]);
        model.classes.push("gust".to_owned());
        let own = testing::class(&[8.0]);
        model.pairs[0].classes.insert("gust".to_owned(), own);
        assert_eq!(
            PairClass::find(&model, None, None).unwrap_err().to_string(),
            "the model has 2 classes: name one with --class: `all`, `gust`"
        );
        assert_eq!(PairClass::find(&model, None, Some("gust")).unwrap().class.r_k_per_w, [8.0]);
        assert_eq!(
            PairClass::find(&model, None, Some("gusts")).unwrap_err().to_string(),
            "the model has no class `gusts`; did you mean `gust`?"
        );
    }

    #[test]
    fn a_wind_has_the_symbol_of_its_reference_and_says_so() {
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        assert_eq!(PairClass::find(&model, None, None).unwrap().label, "still");
        let part = PairClass::find(&model, None, Some("gust")).unwrap();
        assert_eq!((part.wind_w_per_k, part.class.r_k_per_w[0]), (Some(0.2), 10.0));
        let refused = part.refuse_wind().unwrap_err().to_string();
        assert!(refused.contains("that of `still` with 0.2 W/K of wind"));
    }

    #[test]
    fn what_follows_a_gas_is_exported_with_the_gas_that_its_offset_belongs_to() {
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        assert_eq!(PairClass::find(&model, None, None).unwrap().warning(), None);
        testing::follow_gas(&mut model, 18.5);
        let warning = PairClass::find(&model, None, None).unwrap().warning().unwrap();
        assert!(warning.contains("surroundings that stay at 18.5 °C"), "{warning}");
    }
}
