//! JSON as a list of places and what stands there, numbers as they are written: read as numbers,
//! two of them might be taken for one.

use std::collections::BTreeMap;

#[derive(Clone, Debug, PartialEq)]
pub enum Leaf {
    Number(String),
    /// `true`, `false` or `null`.
    Word(String),
    Text(String),
}

/// By place, for example `elements.sector1.mean_power_w` or `pairs.0.mesh_rad_s.2`. Nothing if the
/// text is no JSON.
pub fn leaves(text: &str) -> Option<BTreeMap<String, Leaf>> {
    let mut reader = JsonReader { rest: text, leaves: BTreeMap::new() };
    reader.value(String::new())?;
    reader.rest.trim().is_empty().then_some(reader.leaves)
}

struct JsonReader<'a> {
    rest: &'a str,
    leaves: BTreeMap<String, Leaf>,
}

impl JsonReader<'_> {
    fn take(&mut self, mark: char) -> Option<()> {
        self.rest = self.rest.trim_start().strip_prefix(mark)?;
        Some(())
    }

    fn value(&mut self, place: String) -> Option<()> {
        self.rest = self.rest.trim_start();
        let below = |name: &str| if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") };
        match self.rest.chars().next()? {
            '{' => self.list('{', '}', |reader, _| {
                let name = reader.text()?;
                reader.take(':')?;
                reader.value(below(&name))
            }),
            '[' => self.list('[', ']', |reader, index| reader.value(below(&index.to_string()))),
            '"' => {
                let text = self.text()?;
                self.leaves.insert(place, Leaf::Text(text));
                Some(())
            }
            _ => {
                let end = self.rest.find([',', '}', ']']).unwrap_or(self.rest.len());
                let (word, rest) = self.rest.split_at(end);
                let word = word.trim().to_owned();
                let is_number = word.parse::<f64>().is_ok();
                let is_word = ["true", "false", "null"].contains(&word.as_str());
                self.rest = rest;
                let leaf = if is_number { Leaf::Number(word) } else { Leaf::Word(word) };
                self.leaves.insert(place, leaf);
                (is_number || is_word).then_some(())
            }
        }
    }

    fn list(&mut self, open: char, close: char, mut entry: impl FnMut(&mut Self, usize) -> Option<()>) -> Option<()> {
        self.take(open)?;
        if self.take(close).is_some() {
            return Some(());
        }
        for index in 0.. {
            entry(self, index)?;
            if self.take(close).is_some() {
                break;
            }
            self.take(',')?;
        }
        Some(())
    }

    fn text(&mut self) -> Option<String> {
        self.rest = self.rest.trim_start();
        let mut escaped = false;
        let end = self.rest.char_indices().skip(1).find(|&(_, c)| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        let (text, rest) = self.rest.split_at(end?.0 + 1);
        self.rest = rest;
        serde_json::from_str(text).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_all_their_digits_and_their_places() {
        let text = r#" {"a": 0.10000000000000001, "b": [1, {"c": "x, \"y\"}"}, []], "d": {}, "e": null, "f": -1e-9} "#;
        let leaves = leaves(text).expect("JSON");
        let number = |text: &str| Leaf::Number(text.into());
        assert_eq!(leaves["a"], number("0.10000000000000001"));
        assert_eq!(leaves["b.0"], number("1"));
        assert_eq!(leaves["b.1.c"], Leaf::Text("x, \"y\"}".into()));
        assert_eq!(leaves["e"], Leaf::Word("null".into()));
        assert_eq!(leaves["f"], number("-1e-9"));
        assert_eq!(leaves.len(), 5);
    }

    #[test]
    fn what_is_no_json_is_nothing() {
        for text in ["", "a summary", "{\"a\": 1", "{\"a\": what}", "[1 2]", "1 2"] {
            assert_eq!(leaves(text), None, "{text}");
        }
    }
}
