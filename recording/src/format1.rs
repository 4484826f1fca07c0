//! Names of format 1, the files of before 0.2: `power_w:sector1`, `answer_x_m_s`, and the
//! simulation's wind as `wind_x_m_s`. They get their names of today where a file is opened; nothing
//! else knows them.
//!
//! A file is of format 1 if it has the column `answer_x_m_s`, or does not say `format = 2` and has
//! a column `power_w:…` or `temperature_c:…`. Any other file keeps its names, whatever they are.

use std::borrow::Cow;

use crate::names::{GIVEN_WIND, POWER, QUANTITIES, TEMPERATURE, TRUE_WIND, column_name, in_columns};
use crate::wind::{DIRECTION_UNCERTAINTY, ESTIMATED_GAS, QUALITY_FLAGS, SPEED_UNCERTAINTY};

/// Key of a file's metadata that counts changes of the columns, and its value in what is written
/// today.
pub(crate) const FORMAT: (&str, &str) = ("format", "2");

/// Columns of the wind estimate whose names changed by more than their first word.
const RENAMED: [(&str, &str); 4] = [
    ("answer_speed_error_m_s", SPEED_UNCERTAINTY),
    ("answer_direction_error_deg", DIRECTION_UNCERTAINTY),
    ("answer_gas_c", ESTIMATED_GAS),
    ("answer_doubts", QUALITY_FLAGS),
];
/// The others: `answer_x_m_s` became `wind_x_m_s`.
const REWORDED: [&str; 6] = ["x_m_s", "y_m_s", "z_m_s", "speed_m_s", "across_m_s", "chi_square"];

/// Splits `power_w:sector1` into the quantity of today and the element.
fn of_element(name: &str) -> Option<(&'static str, &str)> {
    let (quantity, element) = name.split_once(':').filter(|(_, element)| !element.is_empty())?;
    let quantity = QUANTITIES.into_iter().find(|today| today.strip_suffix('_') == Some(quantity))?;
    Some((quantity, element))
}

/// Today's name of a column that can only be of format 1; any other name as it is. `wind_x_m_s` is
/// not translated.
pub fn current_name(name: &str) -> Cow<'_, str> {
    if let Some((quantity, element)) = of_element(name) {
        return Cow::Owned(column_name(quantity, element));
    }
    if let Some((_, today)) = RENAMED.iter().find(|(before, _)| *before == name) {
        return Cow::Borrowed(today);
    }
    match name.strip_prefix("answer_").filter(|rest| REWORDED.contains(rest)) {
        Some(rest) => Cow::Owned(format!("wind_{rest}")),
        None => Cow::Borrowed(name),
    }
}

/// Whether these are the columns of a file of format 1 that does not say its format.
pub fn is_format_1<'a>(names: impl IntoIterator<Item = &'a str>) -> bool {
    let ours = |name: &str| of_element(name).is_some_and(|(quantity, _)| [POWER, TEMPERATURE].contains(&quantity));
    names.into_iter().any(|name| ours(name) || name == "answer_x_m_s")
}

/// Today's name of a column of a file of format 1.
pub fn renamed(name: &str) -> Cow<'_, str> {
    match GIVEN_WIND.iter().position(|truth| *truth == name) {
        Some(at) => Cow::Borrowed(TRUE_WIND[at]),
        None => current_name(name),
    }
}

/// Gives the columns of a file their names of today, if it is one of format 1.
pub(crate) fn rename_columns(names: &mut [String], metadata: &crate::Metadata) {
    let says_format = metadata.iter().any(|(key, value)| (key.as_str(), value.trim()) == FORMAT);
    let estimates = names.iter().any(|name| name == "answer_x_m_s");
    if estimates || !says_format && is_format_1(names.iter().map(String::as_str)) {
        for name in names {
            *name = renamed(name).into_owned();
        }
    }
}

/// Whether `text` names the pair of these two, as `input:output`: by today's names, by those of
/// format 1, or with the hyphens of elements' names.
pub fn is_pair(text: &str, input: &str, output: &str) -> bool {
    let is = |text: &str, name: &str| text == name || current_name(text) == name || in_columns(text) == name;
    text.match_indices(':').any(|(at, _)| is(&text[..at], input) && is(&text[at + 1..], output))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn renamed_columns(names: &[&str], metadata: &[(&str, &str)]) -> Vec<String> {
        let mut names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        let metadata = metadata.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
        rename_columns(&mut names, &metadata);
        names
    }

    #[test]
    fn columns_of_before_get_the_names_of_today() {
        let before = ["time_s", "temperature_c:card1-die2", "heater:a", "equivalent_power_w:a", "wind_x_m_s", "my:own"];
        let today =
            ["time_s", "temperature_c_card1_die2", "heater_a", "equivalent_power_w_a", "true_wind_x_m_s", "my:own"];
        assert_eq!(renamed_columns(&before, &[("head", "B")]), today);
        let before = [
            "answer_x_m_s",
            "answer_speed_error_m_s",
            "answer_direction_error_deg",
            "answer_across_m_s",
            "answer_chi_square",
            "answer_gas_c",
            "raw_w_k:a",
            "answer_doubts",
            "wind_z_m_s",
            "answer_to_all",
        ];
        let today = [
            "wind_x_m_s",
            "wind_speed_u_m_s",
            "wind_direction_u_deg",
            "wind_across_m_s",
            "wind_chi_square",
            "wind_gas_temperature_c",
            "raw_w_k_a",
            "quality_flags",
            "true_wind_z_m_s",
            "answer_to_all",
        ];
        assert_eq!(renamed_columns(&before, &[("format", "2")]), today);
    }

    #[test]
    fn a_foreign_table_keeps_its_names() {
        for names in [
            &["event", "wind_x_m_s", "wind_y_m_s", "wind_z_m_s"][..],
            &["time_s", "wind_x_m_s", "power_w", "temperature_c"],
            &["time_s", "heater:1", "wind_x_m_s", "answer_time_s"],
            &["time_s", "power_w:", "wind_x_m_s", "answer_doubts"],
        ] {
            assert_eq!(renamed_columns(names, &[]), names);
        }
        let named_again = ["time_s", "power_w:a", "wind_x_m_s"];
        assert_eq!(renamed_columns(&named_again, &[("format", "2")]), named_again);
    }

    #[test]
    fn a_pair_is_found_in_either_spelling() {
        let names = ("power_w_a", "temperature_c_b_1");
        for text in ["power_w:a:temperature_c:b-1", "power_w_a:temperature_c_b_1", "power_w:a:temperature_c_b_1"] {
            assert!(is_pair(text, names.0, names.1), "{text}");
        }
        assert!(!is_pair("power_w_a", names.0, names.1) && !is_pair("power_w:b:temperature_c:b-1", names.0, names.1));
        assert!(is_pair("card1-die1:card1-die2", "card1_die1", "card1_die2") && is_pair("u-v:y", "u-v", "y"));
        assert!(is_pair("u:y:z", "u:y", "z") && is_pair("u:y:z", "u", "y:z"));
    }
}
