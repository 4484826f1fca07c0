//! Parts of a model that its record does not support, in short: for commands that work with a model
//! and do not judge it.

use super::content::{Model, Pair};

impl Model {
    /// Extent to which the record supports the model, unless it does so in every respect.
    pub fn reservation(&self) -> Option<&'static str> {
        match (self.supported, self.warnings.is_empty()) {
            (false, _) => Some("the record does not support this model"),
            (true, false) => Some("the record supports this model with a reservation"),
            (true, true) => None,
        }
    }

    /// A warning, if there is any: what its file warns of first, of one pair or of all. The others
    /// are counted.
    pub fn support_warning(&self, pair: Option<&Pair>) -> Option<String> {
        let verdict = self.reservation()?;
        let names = || self.inputs.iter().chain(self.outputs.iter().map(|output| &output.name));
        let speaks_of = |warning: &str, name: &str| warning.contains(&format!("`{name}`"));
        let concerns = |warning: &&String| {
            pair.is_none_or(|pair| {
                let own = speaks_of(warning, &pair.input) || speaks_of(warning, &pair.output);
                own || !names().any(|name| speaks_of(warning, name))
            })
        };
        let own: Vec<&String> = self.warnings.iter().filter(concerns).collect();
        match own[..] {
            [] if self.warnings.is_empty() => Some(verdict.to_owned()),
            [] => None,
            [only] => Some(format!("{verdict}: {only}")),
            [first, ..] => Some(format!("{verdict}: {first} (and {} more in its `warnings`)", own.len() - 1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing;

    #[test]
    fn a_pair_hears_of_its_own_columns_and_of_what_names_none() {
        let mut model = testing::model(&[0.5], &[10.0]);
        assert_eq!(model.support_warning(None), None);
        let (own, pair) = (model.outputs[0].name.clone(), model.pairs[0].clone());
        let mut other = model.outputs[0].clone();
        other.name = "temperature_c_other".to_owned();
        model.outputs.push(other);
        model.supported = false;
        model.warnings = vec!["`temperature_c_other` is 3 in all rows".to_owned()];
        assert_eq!(model.support_warning(Some(&pair)), None);
        assert!(model.support_warning(None).unwrap().ends_with("is 3 in all rows"));
        model.warnings.extend([format!("`{own}`: coloured"), "too short".to_owned()]);
        let said = model.support_warning(Some(&pair)).unwrap();
        assert!(said.contains("coloured (and 1 more in its `warnings`)"), "{said}");
        assert!(said.starts_with("the record does not support this model: "), "{said}");
        model.supported = true;
        let said = model.support_warning(Some(&pair)).unwrap();
        assert!(said.starts_with("the record supports this model with a reservation: "), "{said}");
    }
}
