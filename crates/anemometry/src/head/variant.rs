//! A head with another name, or with other values of the numbers that nobody has published.

use toml::Value;
use toml::de::DeTable;

use super::body::unknown::place;
use super::file::Head;
use recording::toml_file::{FileError, TomlSource};

impl Head {
    /// The same head by another name, its file otherwise to the letter.
    ///
    /// # Errors
    /// If it cannot be read again.
    pub fn named(&self, name: &str) -> Result<Head, FileError> {
        let mut text = self.source.text.clone();
        let place = DeTable::parse(&text).ok().and_then(|of| Some(of.get_ref().get("name")?.span()));
        if let Some(place) = place {
            text.replace_range(place, &Value::from(name).to_string());
        }
        Head::from_source(TomlSource { path: self.source.path.clone(), text })
    }

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
