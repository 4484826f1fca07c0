//! Names of columns, and a summary as columns: every number of a JSON object has its name from the
//! keys that lead to it.

use serde_json::{Map, Value};

/// A name that needs no quotes in SQL or Python: letters, digits and underscores.
pub(crate) fn identifier(name: &str) -> String {
    let mut made = String::with_capacity(name.len());
    for letter in name.chars() {
        let letter = if letter.is_alphanumeric() { letter } else { '_' };
        if letter != '_' || !(made.is_empty() || made.ends_with('_')) {
            made.push(letter);
        }
    }
    made.trim_end_matches('_').to_owned()
}

/// Puts every number, truth value and text of a JSON value under its name; what is nothing is left
/// out.
pub(crate) fn flatten(name: &str, value: &Value, columns: &mut Map<String, Value>) {
    let inner = |key: &str| if name.is_empty() { identifier(key) } else { format!("{name}_{}", identifier(key)) };
    match value {
        Value::Null => {}
        Value::Object(object) => object.iter().for_each(|(key, value)| flatten(&inner(key), value, columns)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(n, value)| flatten(&inner(&n.to_string()), value, columns));
        }
        plain => {
            columns.insert(name.to_owned(), plain.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers() {
        assert_eq!(identifier("wind[0].speed_m_s"), "wind_0_speed_m_s");
        assert_eq!(identifier("drives.card1-die2.level"), "drives_card1_die2_level");
    }

    #[test]
    fn every_number_has_a_name() {
        let value = serde_json::json!({"pairs": [{"gain": 1.5, "label": "a"}], "ok": true, "none": null});
        let mut columns = Map::new();
        flatten("identify", &value, &mut columns);
        let expected =
            serde_json::json!({"identify_pairs_0_gain": 1.5, "identify_pairs_0_label": "a", "identify_ok": true});
        assert_eq!(Value::Object(columns), expected);
    }
}
