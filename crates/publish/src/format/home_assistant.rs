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

use super::numbers::FeedColumns;
use crate::feed::{FeedEvent, FeedLayout, FeedRow};
use recording::{TEMPERATURE, column_name};
use serde_json::{Map, Value, json};
use std::time::{SystemTime, UNIX_EPOCH};

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

#[cfg(test)]
mod tests {
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

    /// What the documentation of the integration requires, as a list.
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
}
