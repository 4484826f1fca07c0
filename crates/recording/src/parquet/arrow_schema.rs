//! The columns as Arrow describes them: where pyarrow, Polars and others look for the unit and the
//! meaning of each, for which Parquet's own schema has no room.
//!
//! Under the key `ARROW:schema` stands, in base64, an encapsulated message of the Arrow format with
//! the flatbuffer table `Schema` (<https://arrow.apache.org/docs/format/Columnar.html>, `Schema.fbs`
//! and `Message.fbs`, whose fields are numbered from 0 in the order of these files).

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flatbuffers::{FlatBufferBuilder, TableFinishedWIPOffset, VOffsetT, WIPOffset};

use crate::column::{ColumnKind, Metadata};
use crate::describe::described;

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
