//! Dotted keys into TOML documents: `drives.sector1.temperature_c`, `wind[0].speed_m_s`.
//!
//! A list without a number means each of its tables: `wind.speed_m_s` goes into every `[[wind]]`.
//! Tables that are missing on the way are made; whether a key is one that the file may have shows
//! when the result is read, strictly.

use toml::{Table, Value};

use crate::error::EntryError;

/// Where a value goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct KeyPath(Vec<KeyStep>);

/// A name, and which of the list below it.
#[derive(Debug, Clone, PartialEq, Eq)]
struct KeyStep {
    name: String,
    index: Option<usize>,
}

impl KeyPath {
    /// Reads a key.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, EntryError> {
        let step = |step: &str| {
            let (name, index) = match step.split_once('[') {
                Some((name, index)) => (name, Some(index.strip_suffix(']')?.parse().ok()?)),
                None => (step, None),
            };
            (!name.is_empty()).then(|| KeyStep { name: name.to_owned(), index })
        };
        let steps: Option<Vec<KeyStep>> = text.split('.').map(step).collect();
        steps.map(Self).ok_or_else(|| {
            EntryError(format!("is `{text}`: a key reads as `gas.temperature_c` or `wind[0].speed_m_s`"))
        })
    }

    /// Puts a value there.
    ///
    /// # Errors
    /// Where the document has something else on the way.
    pub fn set(&self, document: &mut Table, value: &Value) -> Result<(), EntryError> {
        set(document, &self.0, value)
    }
}

fn set(table: &mut Table, steps: &[KeyStep], value: &Value) -> Result<(), EntryError> {
    let [KeyStep { name, index }, deeper @ ..] = steps else { return Ok(()) };
    if deeper.is_empty() && index.is_none() {
        table.insert(name.clone(), value.clone());
        return Ok(());
    }
    let found = table.entry(name.clone()).or_insert_with(|| Value::Table(Table::new()));
    match (found, index) {
        (Value::Array(list), Some(index)) => {
            let length = list.len();
            let item = list
                .get_mut(*index)
                .ok_or_else(|| EntryError(format!("`{name}` has {length} entries, counted from 0")))?;
            set_in(name, item, deeper, value)
        }
        (Value::Array(list), None) => list.iter_mut().try_for_each(|item| set_in(name, item, deeper, value)),
        (_, Some(index)) => Err(EntryError(format!("`{name}` is no list that could have an entry {index}"))),
        (found, None) => set_in(name, found, deeper, value),
    }
}

/// What stands behind a name becomes the value, or has the rest of the key in it.
fn set_in(name: &str, found: &mut Value, deeper: &[KeyStep], value: &Value) -> Result<(), EntryError> {
    match (deeper, found) {
        ([], found) => {
            *found = value.clone();
            Ok(())
        }
        (_, Value::Table(table)) => set(table, deeper, value),
        ([next, ..], _) => Err(EntryError(format!("`{name}` is no table that could have a key `{}`", next.name))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(text: &str, key: &str, value: impl Into<Value>) -> Result<String, EntryError> {
        let mut document: Table = text.parse().unwrap();
        KeyPath::parse(key)?.set(&mut document, &value.into())?;
        Ok(document.to_string())
    }

    #[test]
    fn a_value_goes_into_a_table_a_list_or_each_table_of_a_list() {
        let text = "a = 1\n[[wind]]\nv = 1.0\n[[wind]]\nv = 2.0\n";
        assert_eq!(after(text, "a", 2).unwrap(), "a = 2\n\n[[wind]]\nv = 1.0\n\n[[wind]]\nv = 2.0\n");
        assert_eq!(after(text, "wind[1].v", 5.0).unwrap(), "a = 1\n\n[[wind]]\nv = 1.0\n\n[[wind]]\nv = 5.0\n");
        assert_eq!(after(text, "wind.v", 5.0).unwrap(), "a = 1\n\n[[wind]]\nv = 5.0\n\n[[wind]]\nv = 5.0\n");
        assert_eq!(after("n = [1, 2]\n", "n[0]", 7).unwrap(), "n = [7, 2]\n");
        assert_eq!(after("", "front_end.noise", 0.5).unwrap(), "[front_end]\nnoise = 0.5\n");
    }

    #[test]
    fn what_leads_nowhere_is_refused_with_its_name() {
        let refused = |key| after("a = 1\nn = [1]\n", key, 2).unwrap_err().0;
        assert_eq!(refused("a.b"), "`a` is no table that could have a key `b`");
        assert_eq!(refused("n[1]"), "`n` has 1 entries, counted from 0");
        assert_eq!(refused("a[1]"), "`a` is no list that could have an entry 1");
        for wrong in ["", "a..b", "a[x]", "a[1", ".a"] {
            assert!(refused(wrong).starts_with(&format!("is `{wrong}`: a key reads as")), "{wrong}");
        }
    }
}
