//! Numbers of a head that nobody has published: free within a range, and marked so.

use serde::Deserialize;
use toml::Value;

use super::parts::UnknownNumber;
use crate::head::Head;
use recording::toml_file::{FileError, TomlSource};

/// An entry of `unknown`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct UnknownTable {
    /// Where it stands in the file: dotted, with `[n]` for the n-th of an array.
    pub of: String,
    /// Least that it can be.
    pub least: f64,
    /// Most that it can be.
    pub most: f64,
}

/// Every entry with the value that the file has.
///
/// # Errors
/// If nothing or no number stands there, or it is beyond its range.
pub fn found(source: &TomlSource, tables: &[UnknownTable]) -> Result<Vec<UnknownNumber>, FileError> {
    let mut document: Value = source.parse()?;
    let mut all = Vec::new();
    for (i, UnknownTable { of, least, most }) in tables.iter().enumerate() {
        let key = format!("body.unknown[{i}]");
        let value = place(&mut document, of).and_then(|value| match value {
            Value::Float(number) => Some(*number),
            Value::Integer(number) => Some(*number as f64),
            _ => None,
        });
        let value = value.ok_or_else(|| source.refuse(&key, format!("names `{of}`, where no number stands")))?;
        if !(least.is_finite() && *least > 0.0 && most.is_finite() && least < most && (*least..=*most).contains(&value))
        {
            let sentence = format!("has `{of}` between {least} and {most}: above 0, and around its {value}");
            return Err(source.refuse(&key, sentence));
        }
        all.push(UnknownNumber { of: of.clone(), value, least: *least, most: *most });
    }
    Ok(all)
}

impl Head {
    /// The same head with other values of its unknown numbers, in their order.
    ///
    /// # Errors
    /// If these make no head.
    pub fn with_unknown(&self, values: &[f64]) -> Result<Head, FileError> {
        let mut document: Value = self.source.parse()?;
        let unknown = self.body.iter().flat_map(|body| &body.unknown);
        for (number, value) in unknown.zip(values) {
            if let Some(place) = place(&mut document, &number.of) {
                *place = Value::Float(*value);
            }
        }
        // The file's own range holds for the file's own value only.
        if let Some(body) = document.get_mut("body").and_then(Value::as_table_mut) {
            body.remove("unknown");
        }
        let path = self.source.path.clone();
        let text = toml::to_string(&document);
        let text = text.map_err(|error| FileError { path: path.clone(), line: None, sentence: error.to_string() })?;
        Head::from_source(TomlSource { path, text })
    }
}

fn place<'a>(document: &'a mut Value, of: &str) -> Option<&'a mut Value> {
    let mut value = document;
    for step in of.split('.') {
        let (name, indices) = step.split_at(step.find('[').unwrap_or(step.len()));
        value = value.get_mut(name)?;
        for index in indices.split(['[', ']']).filter(|index| !index.is_empty()) {
            value = value.get_mut(index.parse::<usize>().ok()?)?;
        }
    }
    Some(value)
}
