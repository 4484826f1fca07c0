//! A model in one of the forms that others use, as `anemo model export` writes it.

use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use super::source::{Language, source};
use super::spice::{SpiceNetwork, netlist};
use super::table::{ExportTable, cauer_table, foster_table, response_table, structure_table, symbol_table};
use crate::model::ModelError;
use crate::model::pair_class::PairClass;

/// The forms of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportForm {
    /// Resistor and capacitor of every pole, side by side and in series.
    Foster,
    /// The ladder of resistors and capacitors with the same impedance.
    Cauer,
    /// A netlist.
    Spice(SpiceNetwork),
    /// Magnitude and phase at so many frequencies.
    Response(usize),
    /// The time-constant spectrum (diffusive symbol), discrete and continuous, with standard
    /// errors.
    Symbol,
    /// Cumulative structure function.
    Structure,
    /// Constant tables in f32 for a program.
    Source(Language),
}

/// An exported pair. It prints as the file that it is, and serialises to the keys of `anemo model export
/// --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportReport {
    /// Column that heats.
    pub input: String,
    /// Column that is heated.
    pub output: String,
    /// Label of the class.
    pub class: String,
    /// The file that holds it, if any.
    pub file: Option<String>,
    #[serde(flatten)]
    content: ExportContent,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
enum ExportContent {
    Table(ExportTable),
    Text { text: String },
}

impl ExportReport {
    /// One pair in one class, in a form.
    ///
    /// # Errors
    /// If it has no such form.
    pub fn new(part: &PairClass, form: ExportForm, file: Option<String>) -> Result<Self, ModelError> {
        let text = |text: String| ExportContent::Text { text };
        let content = match form {
            ExportForm::Foster => foster_table(part).map(ExportContent::Table),
            ExportForm::Cauer => cauer_table(part).map(ExportContent::Table),
            ExportForm::Spice(network) => netlist(part, network).map(text),
            ExportForm::Response(points) => response_table(part, points).map(ExportContent::Table),
            ExportForm::Symbol => symbol_table(part).map(ExportContent::Table),
            ExportForm::Structure => structure_table(part).map(ExportContent::Table),
            ExportForm::Source(language) => source(part, language).map(text),
        }?;
        let (input, output) = (part.pair.input.clone(), part.pair.output.clone());
        Ok(Self { input, output, class: part.label.to_owned(), file, content })
    }

    /// The table, if the form is one.
    pub fn table(&self) -> Option<&ExportTable> {
        match &self.content {
            ExportContent::Table(table) => Some(table),
            ExportContent::Text { .. } => None,
        }
    }

    /// The text of the file.
    pub fn text(&self) -> Cow<'_, str> {
        match &self.content {
            ExportContent::Table(table) => table.to_csv().into(),
            ExportContent::Text { text } => text.into(),
        }
    }
}

impl Display for ExportReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => writeln!(f, "{} → {}, class {}: {file}", self.input, self.output, self.class),
            None => f.write_str(&self.text()),
        }
    }
}
