//! MQTT messages, and what makes Home Assistant find the instrument by itself (its documentation:
//! MQTT, device discovery).
//!
//! | topic | message | retained |
//! |---|---|---|
//! | `anemo/<id>/status` | `online`, or `offline` as last will | yes |
//! | `anemo/<id>/state` | JSON: all numbers of a row, speed and direction together | yes |
//! | `anemo/<id>/event` | JSON: what happened | no |
//! | `homeassistant/device/anemo_<id>/config` | JSON: the device and its sensors | yes |
//!
//! `<id>` is the unique number of the chip.
//!
//! Numbers have the names of a recording's columns.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::feed::{FeedEvent, FeedLayout, FeedRow};
use recording::{EQUIVALENT_POWER, GAS_TEMPERATURE, POWER, TEMPERATURE, TRUE_WIND, column_name, wind};
use serde_json::{Map, Value, json};

/// The topics of one instrument.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MqttTopics {
    /// `online` or `offline`.
    pub status: String,
    /// Rows.
    pub state: String,
    /// Events.
    pub event: String,
    /// The discovery document.
    pub discovery: String,
}

impl MqttTopics {
    /// Topics of the instrument with this identifier.
    pub fn new(id: &str) -> Self {
        let topic = |name: &str| format!("anemo/{id}/{name}");
        let discovery = format!("homeassistant/device/anemo_{id}/config");
        Self { status: topic("status"), state: topic("state"), event: topic("event"), discovery }
    }
}

/// A row as a message: its numbers under the names of columns, `state` and `utc_s`.
pub fn state(columns: &FeedColumns, row: &FeedRow) -> String {
    let mut message: Map<String, Value> =
        columns.numbers(row).map(|(name, number)| (name.to_owned(), json!(number))).collect();
    message.insert("state".to_owned(), json!(&*row.state));
    message.insert("utc_s".to_owned(), json!(seconds(row.utc)));
    Value::Object(message).to_string()
}

/// An event as a message: `text` and `utc_s`.
pub fn event(event: &FeedEvent) -> String {
    json!({ "text": event.kind.to_string(), "utc_s": seconds(event.utc) }).to_string()
}

/// Since 1970, s, to a millisecond.
fn seconds(utc: SystemTime) -> f64 {
    utc.duration_since(UNIX_EPOCH).unwrap_or_default().as_millis() as f64 / 1000.0
}

/// The document by which Home Assistant makes a device with its sensors. A sensor is unknown,
/// rather than old, where a message has no number for it.
pub fn discovery(layout: &FeedLayout) -> String {
    let id = layout.id();
    let topics = MqttTopics::new(&id);
    let sensor = |key: &str, name: &str, description: Value| {
        let mut sensor = json!({
            "platform": "sensor",
            "name": name,
            "unique_id": format!("anemo_{id}_{key}"),
            "value_template": format!("{{{{ value_json.{key} | default(None) }}}}"),
        });
        if let (Value::Object(sensor), Value::Object(description)) = (&mut sensor, description) {
            sensor.extend(description);
        }
        (key.to_owned(), sensor)
    };
    let measured = |class: &str, unit: &str| json!({ "device_class": class, "unit_of_measurement": unit, "state_class": "measurement" });
    // Means and spans of an angle go round the circle.
    let direction =
        json!({ "device_class": "wind_direction", "unit_of_measurement": "°", "state_class": "measurement_angle" });
    let mut sensors = vec![sensor("state", "State", json!({}))];
    if !layout.surfaces.is_empty() {
        sensors.extend([
            sensor("wind_speed_m_s", "Wind speed", measured("wind_speed", "m/s")),
            sensor("wind_from_deg", "Wind direction", direction),
        ]);
    }
    sensors.extend(layout.elements.iter().map(|element| {
        let name = format!("Temperature of {element}");
        sensor(&column_name(TEMPERATURE, element), &name, measured("temperature", "°C"))
    }));
    json!({
        "device": {
            "identifiers": [format!("anemo_{id}")],
            "name": format!("Anemometer {}", layout.head),
            "manufacturer": "anemo",
            "model": layout.head,
            "sw_version": layout.firmware,
        },
        "origin": { "name": "anemo", "sw_version": env!("CARGO_PKG_VERSION") },
        "components": sensors.into_iter().collect::<Map<_, _>>(),
        "state_topic": topics.state,
        "availability_topic": topics.status,
    })
    .to_string()
}

/// Names of a row's numbers, made once for all rows.
#[derive(Debug, Clone)]
pub struct FeedColumns {
    names: Vec<String>,
    surfaces: usize,
}

impl FeedColumns {
    /// The names for rows of this layout.
    pub fn new(layout: &FeedLayout) -> Self {
        let of = |quantity: &'static str, elements: &[String]| -> Vec<String> {
            elements.iter().map(|element| column_name(quantity, element)).collect()
        };
        let mut names = of(TEMPERATURE, &layout.elements);
        names.extend(of(POWER, &layout.elements));
        names.extend(of(EQUIVALENT_POWER, &layout.observed));
        names.extend(TRUE_WIND.map(str::to_owned));
        names.push(GAS_TEMPERATURE.to_owned());
        names.extend(wind::columns(&layout.surfaces));
        names.push(wind::WIND_FROM.to_owned());
        Self { names, surfaces: layout.surfaces.len() }
    }

    /// The numbers that a row has, with their names: those that are missing are left out. A row of
    /// another layout has none.
    pub fn numbers(&self, row: &FeedRow) -> impl Iterator<Item = (&str, f64)> {
        let mut numbers: Vec<f64> = Vec::with_capacity(self.names.len());
        numbers.extend(row.temperature_c.iter().chain(&row.power_w).chain(&row.equivalent_power_w).map(plain));
        numbers.extend(row.true_wind_m_s.unwrap_or([f64::NAN; 3]));
        numbers.push(row.gas_temperature_c.unwrap_or(f64::NAN));
        numbers.extend(wind::numbers(row.wind.as_ref().map(|wind| &wind.estimate), self.surfaces).iter().map(plain));
        let directed = row.wind.as_ref().filter(|wind| wind.has_direction());
        // Hundredths are finer than any head.
        numbers.push(directed.map_or(f64::NAN, |wind| super::rounded_deg(wind.from_deg, 2)));
        let is_of_layout = numbers.len() == self.names.len();
        let names = self.names.iter().filter(move |_| is_of_layout);
        names.map(String::as_str).zip(numbers).filter(|(_, number)| number.is_finite())
    }
}

/// The shortest decimal of a number of 32 bit: 60.1 rather than 60.099998474.
fn plain(number: &f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::feed::FeedEventKind;
    use crate::format::examples;
    use dr_core::wind::QualityFlags;

    fn parsed(text: &str) -> Value {
        serde_json::from_str(text).expect("it is JSON")
    }

    #[test]
    fn speed_and_direction_come_in_one_message() {
        let columns = FeedColumns::new(&examples::layout());
        let row = examples::row(Some(examples::wind(2.0, 270.0, QualityFlags::default())));
        let message = parsed(&state(&columns, &row));
        assert_eq!((&message["wind_speed_m_s"], &message["wind_from_deg"]), (&json!(2.0), &json!(270.0)));
        assert_eq!((&message["state"], &message["utc_s"]), (&json!("running"), &json!(1_795_435_200.25)));
        let kind = FeedEventKind::Trip { cause: "open".to_owned(), element: Some("core".to_owned()) };
        let message = parsed(&event(&FeedEvent { time_s: 1.0, utc: examples::utc(), kind }));
        assert_eq!(message["text"], "trip: open of core");
    }

    /// Requirements of the documentation of the integration, as a list.
    #[test]
    fn the_document_is_what_home_assistant_takes() {
        let document = parsed(&discovery(&examples::layout()));
        for required in ["device", "origin", "components", "state_topic", "availability_topic"] {
            assert!(!document[required].is_null(), "{required}");
        }
        assert_eq!(document["device"]["identifiers"], json!(["anemo_000000010000abcdffffffff"]));
        let components = document["components"].as_object().expect("a map");
        assert_eq!(components.len(), 1 + 2 + 2);
        for component in components.values() {
            assert_eq!(component["platform"], "sensor");
            assert!(component["unique_id"].is_string() && component["value_template"].is_string(), "{component}");
        }
        let direction = &components["wind_from_deg"];
        let unit_and_class = (&direction["unit_of_measurement"], &direction["state_class"]);
        assert_eq!(unit_and_class, (&json!("°"), &json!("measurement_angle")));
        assert_eq!(components["temperature_c_sector_1"]["name"], "Temperature of sector-1");
    }

    #[test]
    fn a_head_that_outputs_no_wind_has_no_sensor_of_it() {
        let document = parsed(&discovery(&FeedLayout { surfaces: vec![], ..examples::layout() }));
        assert!(document["components"].get("wind_speed_m_s").is_none());
    }

    #[test]
    fn numbers_have_the_names_of_columns_and_missing_ones_none() {
        let columns = FeedColumns::new(&examples::layout());
        let row = examples::row(Some(examples::wind(2.0, 270.0, QualityFlags::default())));
        let numbers: HashMap<_, _> = columns.numbers(&row).collect();
        assert_eq!(numbers["temperature_c_sector_1"], 60.1);
        assert_eq!((numbers["power_w_core"], numbers["wind_speed_m_s"]), (0.5, 2.0));
        assert_eq!((numbers["wind_from_deg"], numbers["quality_flags"]), (270.0, 0.0));
        assert!(!numbers.contains_key("temperature_c_core") && !numbers.contains_key("gas_temperature_c"));
        let failed = examples::row(Some(examples::wind(2.0, 270.0, QualityFlags::FAILED)));
        let numbers: HashMap<_, _> = columns.numbers(&failed).collect();
        assert!(!numbers.contains_key("wind_from_deg") && !numbers.contains_key("wind_speed_m_s"));
        assert_eq!(numbers["quality_flags"], 1.0);
    }

    #[test]
    fn a_row_of_other_lengths_than_the_layout_is_no_shift_of_names() {
        let columns = FeedColumns::new(&examples::layout());
        let mut row = examples::row(None);
        row.temperature_c.pop();
        assert!(columns.numbers(&row).next().is_none());
    }
}
