//! What of a row the page draws: a list of channels, and their values.

use crate::feed::{FeedLayout, FeedRow, FeedWind};

/// One number of every row.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct PageChannel {
    /// What it is, with its unit: the beginning of the recording's column.
    pub quantity: &'static str,
    /// Of which element or surface; empty for the whole instrument.
    pub of: String,
    /// For people.
    pub name: String,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Which of the head's elements it is of, for its colour.
    pub place: Option<usize>,
    /// Whether its noise has a meaning.
    pub noisy: bool,
}

/// The channels of a feed; the true wind is one where a simulation knows it.
pub fn channels(layout: &FeedLayout, has_true_wind: bool) -> Vec<PageChannel> {
    let of = |quantity: &'static str, word: &str, unit, noisy, names: &[String]| -> Vec<PageChannel> {
        let channel = |of: &String| PageChannel {
            quantity,
            of: of.clone(),
            name: format!("{word} {of}").trim().to_owned(),
            unit,
            place: layout.elements.iter().position(|element| element == of),
            noisy,
        };
        names.iter().map(channel).collect()
    };
    let whole = [String::new()];
    let estimates: &[String] = if layout.surfaces.is_empty() { &[] } else { &whole };
    [
        of("temperature_c", "temperature", "K", true, &layout.elements),
        of("power_w", "power", "W", true, &layout.elements),
        of("heater", "heater", "", false, &layout.elements),
        of("conductance_w_k", "conductance", "W/K", true, &layout.surfaces),
        of("wind_speed_m_s", "wind speed", "m/s", true, estimates),
        of("wind_x_m_s", "wind x", "m/s", true, estimates),
        of("wind_y_m_s", "wind y", "m/s", true, estimates),
        of("wind_z_m_s", "wind z", "m/s", true, estimates),
        of("true_wind_speed_m_s", "true wind speed", "m/s", false, if has_true_wind { &whole } else { &[] }),
    ]
    .concat()
}

/// The values of a row, in the order of [`channels`]; NaN where there is none.
pub fn values(layout: &FeedLayout, row: &FeedRow, values: &mut Vec<f32>) {
    let number = |list: &[f32], i: usize| list.get(i).copied().unwrap_or(f32::NAN);
    let elements = layout.elements.len();
    values.clear();
    values.extend((0..elements).map(|i| number(&row.temperature_c, i)));
    values.extend((0..elements).map(|i| number(&row.power_w, i)));
    let bit = |i| row.heaters.checked_shr(i).map_or(f32::NAN, |bits| f32::from(bits & 1 == 1));
    values.extend((0..elements as u32).map(bit));
    if !layout.surfaces.is_empty() {
        let wind: Option<&FeedWind> = row.wind.as_ref();
        let estimate = wind.map(|wind| &wind.estimate);
        let valid = wind.filter(|wind| wind.is_valid()).map(|wind| &wind.estimate);
        // Zero stands for a surface that was not measured.
        let conductance = |i| estimate.map_or(f32::NAN, |estimate| number(&estimate.conductance_w_k, i));
        values.extend((0..layout.surfaces.len()).map(conductance).map(|w_k| if w_k == 0.0 { f32::NAN } else { w_k }));
        values.push(valid.map_or(f32::NAN, |estimate| estimate.speed_m_s));
        values.extend((0..3).map(|i| valid.map_or(f32::NAN, |estimate| estimate.wind_m_s[i])));
    }
    values.extend(row.true_wind_m_s.map(|wind| wind.iter().map(|x| x * x).sum::<f64>().sqrt() as f32));
}
