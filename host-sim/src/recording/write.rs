//! Writing a recording row by row, in memory that does not grow with its length.

use std::path::{Path, PathBuf};

use super::{
    EQUIVALENT_POWER, EVENT, Format, GAS_TEMPERATURE, HEATER, Metadata, POWER, RecordingError, STATE, TEMPERATURE,
    TIME, Temporary, WIND, answer, comma, duplicate, parquet,
};

/// What a recording's rows consist of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Names of the elements, in the order of the rows' slices.
    pub elements: Vec<String>,
    /// Whether the rows carry the true wind.
    pub wind: bool,
    /// Whether the rows carry the true temperature of the gas.
    pub gas: bool,
    /// Names of the elements whose rows carry what an observer sees.
    pub observed: Vec<String>,
    /// Names of the parts of a head that answers with the wind; none if it does not.
    pub answers: Vec<String>,
}

/// One tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<'a> {
    pub time_s: f64,
    /// At `time_s`, one an element; NaN where the reading was no temperature.
    pub temperature_c: &'a [f32],
    /// Held until the next row, one an element.
    pub power_w: &'a [f32],
    /// At `time_s`, one an observed element.
    pub equivalent_power_w: &'a [f32],
    /// Bit i set: element i is held at its high level until the next row.
    pub heaters: u16,
    pub event: &'a str,
    pub state: &'a str,
    pub wind_m_s: Option<[f64; 3]>,
    /// Held until the next row.
    pub gas_temperature_c: Option<f64>,
    /// What the anemometer says, as [`answer::numbers`] has it.
    pub answer: &'a [f32],
}

impl Row<'_> {
    /// What is known of the conditions, in the order of the columns: wind in m/s, gas in °C, and what the anemometer says of them.
    pub(super) fn conditions(&self) -> impl Iterator<Item = f64> {
        let known = self.wind_m_s.into_iter().flatten().chain(self.gas_temperature_c);
        known.chain(self.answer.iter().map(|&number| f64::from(number)))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Time,
    Number,
    Bit,
    Text,
}

impl Layout {
    /// Names and kinds of the columns, in the order in which they are written.
    pub(super) fn columns(&self) -> Vec<(String, Kind)> {
        let of_elements =
            |prefix: &'static str, kind| self.elements.iter().map(move |element| (format!("{prefix}{element}"), kind));
        let mut columns = vec![(TIME.to_owned(), Kind::Time)];
        columns.extend(of_elements(TEMPERATURE, Kind::Number));
        columns.extend(of_elements(POWER, Kind::Number));
        let observed = self.observed.iter().map(|element| (format!("{EQUIVALENT_POWER}{element}"), Kind::Number));
        columns.extend(observed);
        columns.extend(of_elements(HEATER, Kind::Bit));
        columns.extend([(EVENT.to_owned(), Kind::Text), (STATE.to_owned(), Kind::Text)]);
        if self.wind {
            columns.extend(WIND.map(|name| (name.to_owned(), Kind::Number)));
        }
        if self.gas {
            columns.push((GAS_TEMPERATURE.to_owned(), Kind::Number));
        }
        columns.extend(answer::columns(&self.answers).into_iter().map(|name| (name, Kind::Number)));
        columns
    }

    pub(super) fn check(&self, row: &Row) -> Result<(), RecordingError> {
        let refuse = |sentence: String| Err(RecordingError::Row { time_s: row.time_s, sentence });
        let wanted = self.elements.len();
        for (what, given) in [("temperatures", row.temperature_c.len()), ("powers", row.power_w.len())] {
            if given != wanted {
                return refuse(format!("{given} {what} for {wanted} elements"));
            }
        }
        let (given, wanted) = (row.equivalent_power_w.len(), self.observed.len());
        if given != wanted {
            return refuse(format!("{given} equivalent powers for {wanted} observed elements"));
        }
        if row.wind_m_s.is_some() != self.wind {
            return refuse("the wind belongs in every row or in none".to_owned());
        }
        if row.gas_temperature_c.is_some() != self.gas {
            return refuse("the temperature of the gas belongs in every row or in none".to_owned());
        }
        let (given, wanted) = (row.answer.len(), answer::columns(&self.answers).len());
        if given != wanted {
            return refuse(format!("{given} numbers of an answer where {wanted} belong"));
        }
        if !row.time_s.is_finite() {
            return refuse("its time is not finite".to_owned());
        }
        Ok(())
    }
}

enum Sink {
    Parquet(Box<parquet::Writer>),
    Csv(Box<comma::Writer>),
}

/// A recording that is being written. Dropped before [`RecordingWriter::finish`], it leaves no file.
pub struct RecordingWriter {
    layout: Layout,
    path: PathBuf,
    sink: Sink,
    // Declared after the sink: the file is closed before it is removed.
    temporary: Temporary,
}

impl RecordingWriter {
    /// Starts a recording with what is known of it beforehand.
    pub fn create(path: &Path, layout: Layout, metadata: &Metadata) -> Result<Self, RecordingError> {
        let format = Format::of(path)?;
        let columns = layout.columns();
        if let Some(name) = duplicate(columns.iter().map(|(name, _)| name.as_str())) {
            return Err(RecordingError::content(
                path,
                format!("two columns would be named `{name}`: every element needs its own name"),
            ));
        }
        if layout.elements.len() > 16 {
            return Err(RecordingError::content(
                path,
                format!("{} elements do not fit: 16 do at most", layout.elements.len()),
            ));
        }
        let (temporary, file) = Temporary::create(path).map_err(|error| RecordingError::io(path, "written", &error))?;
        let sink = match format {
            Format::Parquet => Sink::Parquet(Box::new(parquet::Writer::new(file, &columns, metadata, path)?)),
            Format::Csv => Sink::Csv(Box::new(comma::Writer::new(file, &columns, metadata, path)?)),
        };
        Ok(Self { layout, path: path.to_owned(), sink, temporary })
    }

    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn push(&mut self, row: &Row) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        match &mut self.sink {
            Sink::Parquet(writer) => writer.push(row, &self.path),
            Sink::Csv(writer) => writer.push(row, &self.path),
        }
    }

    /// Completes the file with what is known at the end (losses, hash …) and gives it its name.
    pub fn finish(self, metadata: &Metadata) -> Result<(), RecordingError> {
        match self.sink {
            Sink::Parquet(writer) => writer.finish(metadata, &self.path)?,
            Sink::Csv(writer) => writer.finish(metadata, &self.path)?,
        }
        self.temporary.keep().map_err(|error| RecordingError::io(&self.path, "written", &error))
    }
}
