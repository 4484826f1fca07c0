//! The columns as Arrow describes them: where pyarrow, Polars and others look for the unit and the
//! meaning of each, for which Parquet's own schema has no room.
//!
//! Under the key `ARROW:schema` stands, in base64, an encapsulated message of the Arrow format with
//! the flatbuffer table `Schema` (<https://arrow.apache.org/docs/format/Columnar.html>,
//! `Schema.fbs` and `Message.fbs`, whose fields are numbered from 0 in the order of these files).
//!
//! Unit and meaning follow from the names of the columns.

use crate::column::{ColumnKind, Metadata};
use crate::names::{
    BITS, CONDUCTANCE, EQUIVALENT_POWER, EVENT, GAS_TEMPERATURE, HEATER, OFFSET_CAPACITANCE, POWER, RAW_CONDUCTANCE,
    STATE, SYMBOL, SYMBOL_CAPACITANCE, TEMPERATURE, TIME, TRUE_OFFSET_CAPACITANCE, TRUE_VOLTAGE_SHIFT, TRUE_WIND,
    UNKNOWN_HEAT, UTC, VOLTAGE_SHIFT, element_of,
};
use crate::wind::{
    DIRECTION_UNCERTAINTY, ESTIMATED_GAS, QUALITY_FLAGS, SPEED_UNCERTAINTY, WIND_ESTIMATE, WIND_FROM, WIND_SPEED,
    WIND_UP,
};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flatbuffers::{FlatBufferBuilder, TableFinishedWIPOffset, VOffsetT, WIPOffset};

/// Where Arrow's readers look.
pub(super) const KEY: &str = "ARROW:schema";

/// `MetadataVersion::V5`, `MessageHeader::Schema`, `Precision`, `TimeUnit::MICROSECOND`.
const V5: i16 = 4;
const HEADER_IS_SCHEMA: u8 = 1;
const MICROSECOND: i16 = 2;

type Table = WIPOffset<TableFinishedWIPOffset>;

/// Place of a table's n-th field.
const fn field(n: VOffsetT) -> VOffsetT {
    4 + 2 * n
}

/// The value of the key. These readers take the file's own metadata from here, too.
pub(super) fn encoded(columns: &[(String, ColumnKind)], metadata: &Metadata) -> String {
    let mut builder = FlatBufferBuilder::new();
    let fields: Vec<Table> = columns.iter().map(|(name, kind)| column(&mut builder, name, *kind)).collect();
    let fields = builder.create_vector(&fields);
    let metadata: Vec<Table> = metadata.iter().map(|(key, value)| pair(&mut builder, key, value)).collect();
    let metadata = builder.create_vector(&metadata);
    let start = builder.start_table();
    builder.push_slot_always(field(1), fields);
    builder.push_slot_always(field(2), metadata);
    let schema = builder.end_table(start);
    let start = builder.start_table();
    builder.push_slot_always(field(0), V5);
    builder.push_slot_always(field(1), HEADER_IS_SCHEMA);
    builder.push_slot_always(field(2), schema);
    builder.push_slot_always(field(3), 0_i64);
    let message = builder.end_table(start);
    builder.finish(message, None);
    let content = builder.finished_data();
    let padding = content.len().next_multiple_of(8) - content.len();
    let length = (content.len() + padding) as u32;
    let message = [&u32::MAX.to_le_bytes(), &length.to_le_bytes(), content, &vec![0; padding]].concat();
    STANDARD.encode(message)
}

fn pair(builder: &mut FlatBufferBuilder<'_>, key: &str, value: &str) -> Table {
    let (key, value) = (builder.create_string(key), builder.create_string(value));
    let start = builder.start_table();
    builder.push_slot_always(field(0), key);
    builder.push_slot_always(field(1), value);
    builder.end_table(start)
}

fn column(builder: &mut FlatBufferBuilder<'_>, name: &str, kind: ColumnKind) -> Table {
    let (type_number, of_type) = data_type(builder, kind);
    let pairs: Vec<Table> = described(name)
        .into_iter()
        .flat_map(|(unit, what)| [("unit", unit.to_owned()), ("description", what)])
        .map(|(key, value)| pair(builder, key, &value))
        .collect();
    let pairs = builder.create_vector(&pairs);
    let children = builder.create_vector::<Table>(&[]);
    let name = builder.create_string(name);
    let start = builder.start_table();
    builder.push_slot_always(field(0), name);
    builder.push_slot_always(field(1), kind.is_optional());
    builder.push_slot_always(field(2), type_number);
    builder.push_slot_always(field(3), of_type);
    builder.push_slot_always(field(5), children);
    builder.push_slot_always(field(6), pairs);
    builder.end_table(start)
}

/// The number of a type in the union `Type`, and its table.
fn data_type(builder: &mut FlatBufferBuilder<'_>, kind: ColumnKind) -> (u8, Table) {
    let zone = (kind == ColumnKind::Utc).then(|| builder.create_string("UTC"));
    let start = builder.start_table();
    let number = match kind {
        ColumnKind::Bit | ColumnKind::Flags => {
            builder.push_slot_always(field(0), if kind == ColumnKind::Bit { 8_i32 } else { 32 });
            builder.push_slot_always(field(1), false);
            2
        }
        ColumnKind::Number | ColumnKind::Wide => {
            builder.push_slot_always(field(0), if kind == ColumnKind::Number { 1_i16 } else { 2 });
            3
        }
        ColumnKind::Text => 5,
        ColumnKind::Utc => {
            builder.push_slot_always(field(0), MICROSECOND);
            zone.into_iter().for_each(|zone| builder.push_slot_always(field(1), zone));
            10
        }
    };
    (number, builder.end_table(start))
}

/// Quantities of an element: unit, meaning.
const OF_ELEMENTS: [(&str, &str, &str); 7] = [
    (TEMPERATURE, "°C", "temperature at time_s"),
    (POWER, "W", "heating power, held until the next row"),
    (EQUIVALENT_POWER, "W", "conduction into the structure, by its observer"),
    (HEATER, "1", "1 at the high level until the next row, else 0"),
    (CONDUCTANCE, "W/K", "conductance to the gas"),
    (RAW_CONDUCTANCE, "W/K", "power over overheat"),
    (UNKNOWN_HEAT, "W", "heat gained on ways that the identification did not have"),
];

/// Quantities of a MEMS capacitor.
const OF_DEVICES: [(&str, &str, &str); 9] = [
    (SYMBOL, "1", "symbol held until the next row, -1 or 1; 0 at 0 V"),
    (BITS[0], "1", "1 while a symbol 1 is held, else 0"),
    (BITS[1], "1", "1 while a symbol -1 is held, else 0"),
    (VOLTAGE_SHIFT, "V", "voltage shift by the readings of the symbol before time_s"),
    (OFFSET_CAPACITANCE, "F", "offset of the capacitance by the same readings"),
    (SYMBOL_CAPACITANCE[0], "F", "capacitance at the end of the first part of the symbol before time_s"),
    (SYMBOL_CAPACITANCE[1], "F", "capacitance at the end of its second part"),
    (TRUE_VOLTAGE_SHIFT, "V", "voltage shift of the simulation"),
    (TRUE_OFFSET_CAPACITANCE, "F", "offset of the capacitance of the simulation"),
];

/// Description of a column of a recording: its unit, and a few words. None for a column of others.
pub(crate) fn described(column: &str) -> Option<(&'static str, String)> {
    if let Some(element) = element_of(column) {
        let of = OF_ELEMENTS.iter().find(|(quantity, ..)| column.strip_prefix(quantity) == Some(element));
        return of.map(|(_, unit, what)| (*unit, format!("{element}: {what}")));
    }
    if let Some((prefix, unit, what)) = OF_DEVICES.iter().find(|(prefix, ..)| column.starts_with(prefix)) {
        return Some((unit, format!("{}: {what}", &column[prefix.len()..])));
    }
    for (prefix, what) in [("min_", "least of: "), ("max_", "greatest of: ")] {
        if let Some((unit, of)) = column.strip_prefix(prefix).and_then(described) {
            return Some((unit, format!("{what}{of}")));
        }
    }
    let (unit, what) = match column {
        TIME => ("s", "time since the start, by the clock of the instrument"),
        UTC => ("UTC", "when the row arrived, by the clock of the host"),
        EVENT => ("", "label of the conditions, or what happened"),
        STATE => ("", "state of the instrument"),
        GAS_TEMPERATURE => ("°C", "gas temperature of the simulation"),
        WIND_SPEED => ("m/s", "wind speed"),
        SPEED_UNCERTAINTY => ("m/s", "standard uncertainty of the wind speed"),
        DIRECTION_UNCERTAINTY => ("°", "standard uncertainty of the wind direction"),
        ESTIMATED_GAS => ("°C", "gas temperature that the estimate uses"),
        QUALITY_FLAGS => ("1", "quality of the wind estimate, a sum of bits; 0 is good"),
        WIND_FROM => ("°", "direction from which the wind blows, clockwise from north"),
        WIND_UP => ("m/s", "vertical wind"),
        "wind_across_m_s" => ("m/s", "wind in the directions that the head does not resolve"),
        "wind_chi_square" => ("1", "misfit of the conductances"),
        name if TRUE_WIND.contains(&name) => ("m/s", "wind vector of the simulation: where the gas goes to"),
        name if WIND_ESTIMATE.contains(&name) => ("m/s", "wind vector: where the gas goes to"),
        name if name.starts_with("duty_") => ("1", "share of the time at the high level"),
        _ => return None,
    };
    Some((unit, what.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::RecordingLayout;

    #[test]
    fn every_column_of_a_recording_says_its_unit_and_what_it_is() {
        let names = || vec!["sector1".to_owned(), "core-1".to_owned()];
        let layout = RecordingLayout {
            elements: names(),
            true_wind: true,
            gas: true,
            observed: names(),
            estimates: names(),
            combined_wind: false,
            earth_wind: true,
            cores: names(),
            numbers: ["symbol_mems", "true_voltage_shift_v_mems"].map(str::to_owned).to_vec(),
        };
        for column in layout.columns().into_iter().chain([UTC.to_owned()]) {
            let (unit, what) = described(&column).unwrap_or_else(|| panic!("{column}"));
            assert!(!what.is_empty() && (unit.is_empty() == [EVENT, STATE].contains(&column.as_str())), "{column}");
        }
        assert_eq!(
            described("power_w_core_1").unwrap(),
            ("W", "core_1: heating power, held until the next row".to_owned())
        );
        assert_eq!(described("voltage"), None);
    }
}
