//! A table of Arrow batches: read like a recording, made of one, and handed on without a copy.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use arrow_array::cast::AsArray as _;
use arrow_array::types::{
    Date32Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, TimestampMicrosecondType,
    TimestampMillisecondType, TimestampNanosecondType, TimestampSecondType, UInt8Type, UInt16Type, UInt32Type,
    UInt64Type,
};
use arrow_array::{Array, ArrayRef, ArrowPrimitiveType, DictionaryArray, Float64Array, RecordBatch, StringArray};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef, TimeUnit};
use recording::in_memory::{ForeignType, MemoryColumns, MemoryTable};
use recording::{ColumnValues, ColumnWords, Metadata};

/// Under this key pandas says which columns are its index.
const PANDAS: &str = "pandas";

/// A column in two units.
#[derive(Debug, thiserror::Error)]
#[error(
    "the table: column `{column}` is in {stated} by its metadata and in {named} by its name: convert it, or rename it"
)]
pub struct ContraryUnit {
    column: String,
    stated: String,
    named: String,
}

/// Batches of one schema.
#[derive(Debug, Clone)]
pub struct ArrowTable {
    pub schema: SchemaRef,
    pub batches: Vec<RecordBatch>,
}

impl ArrowTable {
    /// The columns of a recording; numbers are moved, not copied.
    pub fn of_columns(recording: MemoryColumns) -> Self {
        let mut fields = Vec::new();
        let mut arrays: Vec<ArrayRef> = Vec::new();
        for column in recording.columns {
            let array: ArrayRef = match column.values {
                ColumnValues::Numbers(numbers) => Arc::new(Float64Array::from(numbers)),
                ColumnValues::Words(words) => {
                    let codes = words.codes().iter().map(|&code| code as i32).collect::<Vec<i32>>();
                    let dictionary = StringArray::from_iter_values(words.dictionary());
                    // Every code is one of the dictionary's.
                    let array = DictionaryArray::<Int32Type>::try_new(codes.into(), Arc::new(dictionary));
                    Arc::new(array.expect("codes of words"))
                }
            };
            let unit = recording::stated_unit(&column.name).map(|unit| ("unit".to_owned(), unit.to_owned()));
            let field = Field::new(column.name, array.data_type().clone(), true);
            fields.push(field.with_metadata(unit.into_iter().collect::<HashMap<_, _>>()));
            arrays.push(array);
        }
        let schema =
            Arc::new(Schema::new_with_metadata(fields, recording.metadata.into_iter().collect::<HashMap<_, _>>()));
        let batch = RecordBatch::try_new(Arc::clone(&schema), arrays).expect("columns of equal length");
        Self { schema, batches: vec![batch] }
    }

    /// The table of a pandas frame as its owner sees it: an index that says something (times, or
    /// with a name) is the first column, where a record has its times; mere numbers of rows are
    /// none.
    pub fn with_index_first(self) -> Result<Self, ArrowError> {
        let Some(about) = self.schema.metadata().get(PANDAS) else { return Ok(self) };
        let about: serde_json::Value = serde_json::from_str(about).unwrap_or_default();
        let index: Vec<&str> =
            about["index_columns"].as_array().into_iter().flatten().filter_map(|of| of.as_str()).collect();
        let is_index = |column: &usize| index.contains(&self.schema.field(*column).name().as_str());
        let says = |column: &usize| {
            let field = self.schema.field(*column);
            !field.name().starts_with("__index_level_") || matches!(field.data_type(), DataType::Timestamp(..))
        };
        let all = || 0..self.schema.fields().len();
        let first = all().filter(|column| is_index(column) && says(column));
        let order: Vec<usize> = first.chain(all().filter(|column| !is_index(column))).collect();
        let mut metadata: HashMap<String, String> = self.metadata().into_iter().collect();
        metadata.remove(PANDAS);
        let schema = Arc::new(self.schema.project(&order)?.with_metadata(metadata));
        let batches = self.batches.iter().map(|batch| batch.project(&order)).collect::<Result<_, _>>()?;
        Self { batches, schema: Arc::clone(&self.schema) }.with_schema(schema)
    }

    /// The same columns with other metadata.
    pub fn with_schema(self, schema: SchemaRef) -> Result<Self, ArrowError> {
        let renamed = |batch: RecordBatch| RecordBatch::try_new(Arc::clone(&schema), batch.columns().to_vec());
        let batches = self.batches.into_iter().map(renamed).collect::<Result<_, _>>()?;
        Ok(Self { batches, schema })
    }

    /// Rows in all batches.
    pub fn len(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    /// Column of a name.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.schema.fields().iter().position(|field| field.name() == name)
    }

    /// Refuses a column whose metadata state another unit than its name does.
    pub fn check_units(&self) -> Result<(), ContraryUnit> {
        for field in self.schema.fields() {
            let stated = field.metadata().get("unit").map(String::as_str);
            let named = recording::stated_unit(field.name());
            if let (Some(stated), Some(named)) = (stated, named)
                && stated != named
            {
                let [column, stated, named] = [field.name(), stated, named].map(str::to_owned);
                return Err(ContraryUnit { column, stated, named });
            }
        }
        Ok(())
    }
}

impl MemoryTable for ArrowTable {
    fn names(&self) -> Vec<String> {
        self.schema.fields().iter().map(|field| field.name().clone()).collect()
    }

    fn rows(&self) -> usize {
        self.len()
    }

    fn holds_text(&self, column: usize) -> bool {
        is_text(self.schema.field(column).data_type())
    }

    fn metadata(&self) -> Metadata {
        let mut pairs: Metadata = self.schema.metadata().clone().into_iter().collect();
        pairs.sort();
        pairs
    }

    fn values(&self, column: usize, rows: Range<usize>) -> Result<ColumnValues, ForeignType> {
        let holds_text = self.holds_text(column);
        let (mut numbers, mut words) = (Vec::with_capacity(rows.len()), ColumnWords::default());
        let mut first = 0;
        for batch in &self.batches {
            let own = rows.start.max(first)..rows.end.min(first + batch.num_rows());
            if !own.is_empty() {
                let slice = batch.column(column).slice(own.start - first, own.len());
                if holds_text { push_words(&slice, &mut words)? } else { push_numbers(&slice, &mut numbers)? }
            }
            first += batch.num_rows();
        }
        Ok(if holds_text { ColumnValues::Words(words) } else { ColumnValues::Numbers(numbers) })
    }
}

fn is_text(data_type: &DataType) -> bool {
    match data_type {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => true,
        DataType::Dictionary(_, values) => is_text(values),
        _ => false,
    }
}

/// Numbers of an array, NaN for a null; moments in seconds since 1970.
fn push_numbers(array: &ArrayRef, numbers: &mut Vec<f64>) -> Result<(), ForeignType> {
    fn push<T: ArrowPrimitiveType>(array: &ArrayRef, numbers: &mut Vec<f64>, convert: impl Fn(T::Native) -> f64) {
        let array = array.as_primitive::<T>();
        if array.null_count() == 0 {
            numbers.extend(array.values().iter().map(|&value| convert(value)));
        } else {
            numbers.extend(array.iter().map(|value| value.map_or(f64::NAN, &convert)));
        }
    }
    match array.data_type() {
        DataType::Float64 => push::<Float64Type>(array, numbers, |value| value),
        DataType::Float32 => push::<Float32Type>(array, numbers, f64::from),
        DataType::Int8 => push::<Int8Type>(array, numbers, f64::from),
        DataType::Int16 => push::<Int16Type>(array, numbers, f64::from),
        DataType::Int32 => push::<Int32Type>(array, numbers, f64::from),
        DataType::Int64 => push::<Int64Type>(array, numbers, |value| value as f64),
        DataType::UInt8 => push::<UInt8Type>(array, numbers, f64::from),
        DataType::UInt16 => push::<UInt16Type>(array, numbers, f64::from),
        DataType::UInt32 => push::<UInt32Type>(array, numbers, f64::from),
        DataType::UInt64 => push::<UInt64Type>(array, numbers, |value| value as f64),
        DataType::Timestamp(TimeUnit::Second, _) => push::<TimestampSecondType>(array, numbers, |value| value as f64),
        DataType::Timestamp(TimeUnit::Millisecond, _) => {
            push::<TimestampMillisecondType>(array, numbers, |value| value as f64 * 1e-3);
        }
        DataType::Timestamp(TimeUnit::Microsecond, _) => {
            push::<TimestampMicrosecondType>(array, numbers, |value| value as f64 * 1e-6);
        }
        DataType::Timestamp(TimeUnit::Nanosecond, _) => {
            push::<TimestampNanosecondType>(array, numbers, |value| value as f64 * 1e-9);
        }
        DataType::Date32 => push::<Date32Type>(array, numbers, |days| f64::from(days) * 86_400.0),
        DataType::Null => numbers.resize(numbers.len() + array.len(), f64::NAN),
        DataType::Boolean => {
            numbers.extend(array.as_boolean().iter().map(|value| value.map_or(f64::NAN, |bit| u8::from(bit).into())));
        }
        other => return Err(ForeignType(other.to_string())),
    }
    Ok(())
}

/// Texts of an array, empty for a null.
fn push_words(array: &ArrayRef, words: &mut ColumnWords) -> Result<(), ForeignType> {
    match array.data_type() {
        DataType::Utf8 => array.as_string::<i32>().iter().for_each(|word| words.push(word.unwrap_or_default())),
        DataType::LargeUtf8 => array.as_string::<i64>().iter().for_each(|word| words.push(word.unwrap_or_default())),
        DataType::Utf8View => array.as_string_view().iter().for_each(|word| words.push(word.unwrap_or_default())),
        DataType::Dictionary(..) => {
            let dictionary = array.as_any_dictionary();
            let mut known = ColumnWords::default();
            push_words(dictionary.values(), &mut known)?;
            // An empty dictionary has no word, and its rows are all null.
            let keys = dictionary.normalized_keys_or_none();
            keys.into_iter().for_each(|key| words.push(key.map_or("", |key| known.word(key))));
        }
        other => return Err(ForeignType(other.to_string())),
    }
    Ok(())
}

trait KeysOrNone {
    /// Keys into the dictionary, `None` for a null.
    fn normalized_keys_or_none(&self) -> Vec<Option<usize>>;
}

impl KeysOrNone for dyn arrow_array::array::AnyDictionaryArray + '_ {
    fn normalized_keys_or_none(&self) -> Vec<Option<usize>> {
        let keys = self.keys();
        if self.values().is_empty() {
            return vec![None; keys.len()];
        }
        let normalized = self.normalized_keys();
        normalized.into_iter().enumerate().map(|(row, key)| keys.is_valid(row).then_some(key)).collect()
    }
}
