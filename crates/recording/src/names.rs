//! Names of a recording's columns: a quantity with its unit, and the element that it belongs to.
//!
//! `power_w_sector1` is the quantity [`POWER`] of the element `sector1`. A hyphen in an element's
//! name is an underscore in its columns, so that every column is an identifier in Python, SQL and
//! the like: the die `card1-die2` has the column `temperature_c_card1_die2`.

/// Key of a file's metadata that counts changes of the columns, and its value.
pub(crate) const FORMAT: (&str, &str) = ("format", "2");

/// Time of a row, s.
pub const TIME: &str = "time_s";
/// When a row arrived at the host.
pub const UTC: &str = "utc";
/// Label of the conditions, text.
pub const EVENT: &str = "event";
/// State of the instrument, text.
pub const STATE: &str = "state";
/// Temperature of the simulated gas, °C.
pub const GAS_TEMPERATURE: &str = "gas_temperature_c";
/// Wind of the simulation, m/s: where the gas goes to.
pub const TRUE_WIND: [&str; 3] = ["true_wind_x_m_s", "true_wind_y_m_s", "true_wind_z_m_s"];
/// Wind in a table of given winds, m/s: where the gas goes to.
pub const GIVEN_WIND: [&str; 3] = ["wind_x_m_s", "wind_y_m_s", "wind_z_m_s"];

/// Temperature of an element, °C.
pub const TEMPERATURE: &str = "temperature_c_";
/// Heating power of an element, W.
pub const POWER: &str = "power_w_";
/// Power that an element's structure takes by its observer, W.
pub const EQUIVALENT_POWER: &str = "equivalent_power_w_";
/// Heater bit of an element, 0 or 1.
pub const HEATER: &str = "heater_";
/// Conductance from an element's surface to the gas, W/K.
pub const CONDUCTANCE: &str = "conductance_w_k_";
/// Power over overheat of an element, W/K.
pub const RAW_CONDUCTANCE: &str = "raw_w_k_";
/// Heat that an element without a surface gains from its support, or by its stem, beyond what it
/// did in the identification, W.
pub const UNKNOWN_HEAT: &str = "unknown_heat_w_";

/// Voltage shift of a MEMS capacitor, V.
pub const VOLTAGE_SHIFT: &str = "voltage_shift_v_";
/// Symbol that drives it, −1 or +1; 0 at 0 V.
pub const SYMBOL: &str = "symbol_";
/// The same as two inputs: 1 while a symbol 1, or a symbol −1, is held, else 0.
pub const BITS: [&str; 2] = ["bit1_", "bit0_"];
/// Offset C₀ of its capacitance, F.
pub const OFFSET_CAPACITANCE: &str = "offset_capacitance_f_";
/// Its capacitance at the ends of the two parts of a symbol, F.
pub const SYMBOL_CAPACITANCE: [&str; 2] = ["first_capacitance_f_", "second_capacitance_f_"];
/// Voltage shift of the simulation, V.
pub const TRUE_VOLTAGE_SHIFT: &str = "true_voltage_shift_v_";
/// Offset of the capacitance of the simulation, F.
pub const TRUE_OFFSET_CAPACITANCE: &str = "true_offset_capacitance_f_";

/// Quantities that stand before an element's name.
pub(crate) const QUANTITIES: [&str; 7] =
    [TEMPERATURE, POWER, EQUIVALENT_POWER, HEATER, CONDUCTANCE, RAW_CONDUCTANCE, UNKNOWN_HEAT];

/// More characters in brackets are a remark, and no unit.
const MOST_UNIT: usize = 8;

/// Name of the element that measures the gas beside the head.
pub const REFERENCE: &str = "reference";

/// An element's name as it stands in columns: with underscores for hyphens.
pub fn in_columns(element: &str) -> String {
    element.replace('-', "_")
}

/// The column of a quantity of an element: `power_w_` and `sector1` give `power_w_sector1`.
pub fn column_name(quantity: &str, element: &str) -> String {
    format!("{quantity}{}", in_columns(element))
}

/// Tells whether `text` names this pair, as `input:output`. Elements' names may have their hyphens.
pub fn is_pair(text: &str, input: &str, output: &str) -> bool {
    let is = |text: &str, name: &str| text == name || in_columns(text) == name;
    text.match_indices(':').any(|(at, _)| is(&text[..at], input) && is(&text[at + 1..], output))
}

/// The element that a column belongs to: `sector1` of `power_w_sector1`, none of `time_s`.
pub fn element_of(column: &str) -> Option<&str> {
    QUANTITIES.iter().find_map(|quantity| column.strip_prefix(quantity)).filter(|element| !element.is_empty())
}

/// The unit that a column's name states: that of a recording's temperatures and powers, of an
/// element or not (`power_w`, `temperature_c_probe`), one in brackets at the end, as loggers
/// write it (`Heater [mW]`, `T1 (°C)`), or one of power or temperature after the last `_` or `/`
/// (`power_mw`, `P/mW`, `T_degC`).
pub fn stated_unit(column: &str) -> Option<&str> {
    for (quantity, unit) in [(TEMPERATURE, "°C"), (POWER, "W"), (EQUIVALENT_POWER, "W"), (UNKNOWN_HEAT, "W")] {
        if column.starts_with(quantity) || quantity.strip_suffix('_') == Some(column) {
            return Some(unit);
        }
    }
    let Some(bracketed) = column.strip_suffix([')', ']']) else {
        return match column.rsplit_once(['_', '/'])?.1 {
            "W" => Some("W"),
            "mw" | "mW" => Some("mW"),
            "uw" | "uW" | "µW" => Some("µW"),
            "kw" | "kW" => Some("kW"),
            "degc" | "degC" | "°C" => Some("°C"),
            _ => None,
        };
    };
    let (_, unit) = bracketed.rsplit_once(['(', '['])?;
    match unit.trim() {
        "C" | "degC" | "deg C" => Some("°C"),
        unit => Some(unit).filter(|unit| !unit.is_empty() && unit.chars().count() <= MOST_UNIT),
    }
}

/// A sentence that names two elements that would share a column, if there are such.
pub fn shared_column<'a>(elements: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut known = std::collections::HashMap::new();
    elements.into_iter().find_map(|element| {
        let column = column_name(TEMPERATURE, element);
        let before = known.insert(in_columns(element), element)?;
        Some(match before == element {
            true => format!("two columns would be named `{column}`: every element needs its own name"),
            false => format!(
                "`{before}` and `{element}` would share the column `{column}`, in which a hyphen is an underscore: rename one of them"
            ),
        })
    })
}

/// The first name that stands twice.
pub(crate) fn duplicate<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = std::collections::HashSet::new();
    names.into_iter().find(|name| !seen.insert(*name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_an_underscore_for_every_hyphen_and_is_found_again() {
        assert_eq!(column_name(POWER, "card1-die2"), "power_w_card1_die2");
        assert_eq!(element_of("equivalent_power_w_core1"), Some("core1"));
        assert_eq!(element_of("raw_w_k_card1_die2"), Some("card1_die2"));
        assert_eq!((element_of("time_s"), element_of("gas_temperature_c"), element_of("power_w_")), (None, None, None));
    }

    #[test]
    fn a_pair_is_found_by_columns_and_by_hyphens() {
        assert!(is_pair("power_w_a:temperature_c_b_1", "power_w_a", "temperature_c_b_1"));
        assert!(!is_pair("power_w_a", "power_w_a", "b") && !is_pair("power_w_b:b-1", "power_w_a", "b_1"));
        assert!(is_pair("card1-die1:card1-die2", "card1_die1", "card1_die2") && is_pair("u-v:y", "u-v", "y"));
        assert!(is_pair("u:y:z", "u:y", "z") && is_pair("u:y:z", "u", "y:z"));
    }

    #[test]
    fn names_that_differ_by_a_hyphen_only_are_refused() {
        assert_eq!(shared_column(["a", "b"]), None);
        assert_eq!(
            shared_column(["a-1", "b", "a_1"]).unwrap(),
            "`a-1` and `a_1` would share the column `temperature_c_a_1`, in which a hyphen is an underscore: rename one of them"
        );
    }
}
