//! What has another name in the newer build: keys of JSON, columns of tables.

/// Beginnings of columns' names, older and newer; hyphens become `_` in columns.
const COLUMNS: [(&str, &str); 13] = [
    ("power_w:", "power_w_"),
    ("temperature_c:", "temperature_c_"),
    ("heater:", "heater_"),
    ("equivalent_power_w:", "equivalent_power_w_"),
    ("limit_w:", "limit_w_"),
    ("sampled_w:", "sampled_w_"),
    ("conductance_w_k:", "conductance_w_k_"),
    ("raw_w_k:", "raw_w_k_"),
    ("answer_doubts", "quality_flags"),
    ("answer_speed_error_m_s", "wind_speed_u_m_s"),
    ("answer_direction_error_deg", "wind_direction_u_deg"),
    ("answer_", "wind_"),
    ("wind_", "true_wind_"),
];

/// The newer name of a key.
pub fn key(name: &str) -> String {
    match name {
        "doubts" => "quality_flags".to_owned(),
        _ if name.contains(':') => column(name),
        _ => name.to_owned(),
    }
}

/// The newer name of a column.
pub fn column(name: &str) -> String {
    let renamed = COLUMNS.iter().find_map(|(old, new)| Some(format!("{new}{}", name.strip_prefix(old)?)));
    renamed.unwrap_or_else(|| name.to_owned()).replace('-', "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_is_not_taken_for_the_truth() {
        assert_eq!(column("wind_x_m_s"), "true_wind_x_m_s");
        assert_eq!(column("answer_x_m_s"), "wind_x_m_s");
        assert_eq!(column("answer_doubts"), "quality_flags");
        assert_eq!(column("power_w:card1-die1"), "power_w_card1_die1");
        assert_eq!(column("time_s"), "time_s");
        assert_eq!(key("doubts"), "quality_flags");
        assert_eq!(key("card1-die1"), "card1-die1");
    }
}
