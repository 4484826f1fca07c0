//! Numbers of a body that nobody has published: free within a range, and marked so.

use toml::Value;

use super::parts::UnknownNumber;
use super::table::UnknownTable;
use recording::toml_file::{FileError, TomlSource};

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

/// What stands at a dotted key, with `[n]` for the n-th of an array.
pub fn place<'a>(document: &'a mut Value, of: &str) -> Option<&'a mut Value> {
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
