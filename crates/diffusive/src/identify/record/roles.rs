//! Which columns of a record are time, inputs, outputs, event and gas: as the user names them, or
//! by default.
//!
//! | record | inputs | outputs |
//! |---|---|---|
//! | ours (`power_w_<element>` beside `temperature_c_<element>`) | powers that vary | temperatures of the same elements |
//! | of a MEMS capacitor (`symbol_<device>` beside `voltage_shift_v_<device>`) | the symbol | the voltage shift |
//! | any other | the numeric columns before the last, as far as they vary | the last numeric column |
//!
//! `time_role` says which column is the time. The event class is in the column `event` if that
//! holds text; in a record that is not ours, also in a column that is called as classes are and
//! holds a few whole numbers. A power varies if its range is above 1 % of the largest one's: the
//! current that only measures heats a little, and by the element's resistance.

use std::path::Path;

use super::columns::FileColumns;
use super::error::RecordError;
use super::source::Selection;
use super::time_role::TimeRole;
use recording::{EVENT, POWER, STATE, SYMBOL, TEMPERATURE, VOLTAGE_SHIFT};

/// The part of the largest power's range below which an element is only measured.
const MEASURED_ONLY: f64 = 0.01;

/// Inputs that are guessed at most: the work grows by the cube of their number.
const MOST_GUESSED: usize = 16;

#[derive(Debug, Clone, Default)]
pub(super) struct Roles {
    pub time: TimeRole,
    pub inputs: Vec<usize>,
    pub outputs: Vec<usize>,
    pub event: Option<usize>,
    pub event_was_named: bool,
    pub gas: Option<usize>,
    /// The state of our instrument, read along to say where it was not running.
    pub state: Option<usize>,
    pub notes: Vec<String>,
}

impl Roles {
    pub(super) fn choose(path: &Path, selection: &Selection) -> Result<Self, RecordError> {
        let columns = FileColumns::of(path, &selection.columns)?;
        let elements = columns.elements();
        if selection.inputs.is_empty() {
            let numbers = columns.text.iter().filter(|is_text| !**is_text).count();
            // Time, output, gas and what numbers rows or conditions are no inputs.
            let [candidates, count] = match elements.len() {
                0 => [4, 2].map(|others| numbers.saturating_sub(others)),
                powers => [powers; 2],
            };
            refuse_if!(candidates > MOST_GUESSED, too_many(&columns, count));
        }
        let time = TimeRole::choose(&columns, selection)?;
        let mut roles = Self { notes: time.notes.clone(), time, ..Self::default() };
        roles.event = match &selection.event {
            Some(name) => Some(columns.named(name, &[])?),
            None => columns.position(EVENT).filter(|&event| columns.text[event]),
        };
        roles.event_was_named = selection.event.is_some();
        roles.gas = selection.gas.as_ref().map(|name| columns.named(name, &[TEMPERATURE])).transpose()?;
        roles.state = columns.position(STATE).filter(|&state| !elements.is_empty() && columns.text[state]);
        roles.inputs = columns.all_named(&selection.inputs, POWER)?;
        roles.outputs = columns.all_named(&selection.outputs, TEMPERATURE)?;

        if !elements.is_empty() {
            roles.choose_ours(&columns, &elements)?;
        } else if !roles.choose_device(&columns) {
            roles.choose_foreign(&columns)?;
        }
        roles.check(&columns)?;
        Ok(roles)
    }

    /// A recording of our instrument.
    fn choose_ours(&mut self, columns: &FileColumns, elements: &[(usize, usize)]) -> Result<(), RecordError> {
        if self.inputs.is_empty() {
            let powers: Vec<usize> = elements.iter().map(|&(power, _)| power).collect();
            self.inputs = columns.varying(&powers, MEASURED_ONLY)?;
            let inputs = columns.list(&self.inputs);
            self.notes.push(match self.inputs.len() {
                1 => format!("{inputs} varies and is taken for the input"),
                _ => format!("{inputs} vary and are taken for the inputs"),
            });
        }
        if self.outputs.is_empty() {
            let temperature = |input: &usize| {
                let element = recording::element_of(&columns.names[*input])?;
                columns.position(&recording::column_name(TEMPERATURE, element))
            };
            let outputs: Option<Vec<usize>> = self.inputs.iter().map(temperature).collect();
            self.outputs = outputs.ok_or_else(|| {
                columns.refuse(format!(
                    "no temperature belongs to the input {}: name an output",
                    columns.list(&self.inputs)
                ))
            })?;
        }
        Ok(())
    }

    /// A recording of a MEMS capacitor; false if it is none.
    fn choose_device(&mut self, columns: &FileColumns) -> bool {
        let Some(shift) = columns.names.iter().position(|name| name.starts_with(VOLTAGE_SHIFT)) else { return false };
        let device = &columns.names[shift][VOLTAGE_SHIFT.len()..];
        let Some(symbol) = columns.position(&recording::column_name(SYMBOL, device)) else { return false };
        if self.inputs.is_empty() {
            self.inputs.push(symbol);
            self.notes.push(format!("{} is taken for the input", columns.list(&self.inputs)));
        }
        if self.outputs.is_empty() {
            self.outputs.push(shift);
        }
        true
    }

    fn choose_foreign(&mut self, columns: &FileColumns) -> Result<(), RecordError> {
        let taken = |roles: &Self, column: usize| {
            Some(column) == roles.time.column
                || roles.time.left_out.contains(&column)
                || Some(column) == roles.event
                || Some(column) == roles.gas
        };
        let by_default = |&column: &usize| !columns.text[column] && !taken(self, column);
        let mut free: Vec<usize> = (0..columns.names.len()).filter(by_default).collect();
        if self.event.is_none() {
            self.choose_worded_classes(columns);
        }
        if self.event.is_none() {
            self.choose_numbered_classes(columns, &mut free)?;
        }
        let (no_inputs, no_outputs) = (self.inputs.is_empty(), self.outputs.is_empty());
        if no_outputs {
            let last = free.iter().rev().find(|column| !self.inputs.contains(column));
            self.outputs.extend(last);
        }
        if no_inputs {
            self.inputs = free.iter().copied().filter(|column| !self.outputs.contains(column)).collect();
            refuse_if!(self.inputs.len() > MOST_GUESSED, too_many(columns, self.inputs.len()));
        }
        if self.inputs.is_empty() || self.outputs.is_empty() {
            return Err(columns.refuse(format!(
                "has {}: a record needs the time, an input and an output, as columns of numbers",
                columns.list(&(0..columns.names.len()).collect::<Vec<_>>())
            )));
        }
        if no_inputs && self.inputs.len() > 1 {
            let varying = columns.varying(&self.inputs, 0.0)?;
            let constant: Vec<usize> = self.inputs.iter().copied().filter(|column| !varying.contains(column)).collect();
            if !constant.is_empty() {
                self.notes.push(format!("{} left out: constant", columns.list(&constant)));
            }
            self.inputs = varying;
        }
        let inputs = format!("input{} {}", plural(&self.inputs), columns.list(&self.inputs));
        let outputs = format!("output{} {}", plural(&self.outputs), columns.list(&self.outputs));
        match (no_inputs, no_outputs) {
            (true, true) => self.notes.push(format!("{inputs} and {outputs} taken in order")),
            (true, false) => self.notes.push(format!("{inputs} taken in order")),
            (false, true) => self.notes.push(format!("{outputs} taken: the last column of numbers")),
            (false, false) => {}
        }
        Ok(())
    }

    /// Takes a column of text for the event class, if its name says that; mentions others, which
    /// nothing is made of.
    fn choose_worded_classes(&mut self, columns: &FileColumns) {
        let texts: Vec<usize> = (0..columns.names.len())
            .filter(|&column| columns.text[column] && Some(column) != self.time.column)
            .collect();
        let is_called = |column: &usize| columns.is_called_a_class(*column);
        match (&texts[..], texts.iter().copied().find(is_called)) {
            ([], _) => {}
            (_, Some(column)) => {
                self.event = Some(column);
                self.notes.push(format!("`{}` holds text and is taken for the event class", columns.names[column]));
            }
            (_, None) => self.notes.push(format!(
                "{} left out: text; a column that labels conditions is named by --event",
                columns.list(&texts)
            )),
        }
    }

    /// Takes a column of numbered conditions for the event class, if an input and an output are
    /// left without it.
    fn choose_numbered_classes(&mut self, columns: &FileColumns, free: &mut Vec<usize>) -> Result<(), RecordError> {
        let named = |column: &usize| self.inputs.contains(column) || self.outputs.contains(column);
        let is_called = |column: &usize| columns.is_called_a_class(*column) && !named(column);
        let called: Vec<usize> = free.iter().copied().filter(is_called).collect();
        let missing = usize::from(self.inputs.is_empty()) + usize::from(self.outputs.is_empty());
        let others = free.iter().filter(|column| !named(column)).count();
        let &[column] = &called[..] else { return Ok(()) };
        if missing == 0 || others <= missing || !columns.holds_few_whole_numbers(column)? {
            return Ok(());
        }
        free.retain(|free| *free != column);
        self.event = Some(column);
        self.notes.push(format!(
            "`{name}` holds a few whole numbers and is taken for the event class; if it is none, name inputs and outputs with --input and --output",
            name = columns.names[column]
        ));
        Ok(())
    }

    /// No column plays two parts that exclude each other, and numbers are where they belong.
    fn check(&self, columns: &FileColumns) -> Result<(), RecordError> {
        let name = |column: usize| &columns.names[column];
        let mut parts: Vec<_> = self.time.column.map(|time| (time, "the time")).into_iter().collect();
        parts.extend(self.event.map(|event| (event, "the event class")));
        parts.extend(self.inputs.iter().map(|&input| (input, "an input")));
        parts.extend(self.outputs.iter().map(|&output| (output, "an output")));
        for (at, &(column, part)) in parts.iter().enumerate() {
            if let Some((_, before)) = parts[..at].iter().find(|(other, _)| *other == column) {
                let sentence = if *before == part {
                    format!("column `{}` is named twice as {part}: once is enough", name(column))
                } else {
                    format!("column `{}` cannot be {before} and {part} at once: name another one", name(column))
                };
                return Err(columns.refuse(sentence));
            }
        }
        if let Some(gas) = self.gas.filter(|gas| self.time.column == Some(*gas)) {
            return Err(columns
                .refuse(format!("column `{}` cannot be the time and the gas at once: name another one", name(gas))));
        }
        let numbers = self.inputs.iter().chain(&self.outputs).chain(&self.gas);
        match numbers.copied().find(|&column| columns.text[column]) {
            Some(column) => {
                let sentence = format!("column `{}` holds text where numbers belong: name another one", name(column));
                Err(columns.refuse(sentence))
            }
            None => Ok(()),
        }
    }
}

fn too_many(columns: &FileColumns, count: usize) -> RecordError {
    columns.refuse(format!(
        "{count} columns of numbers could be inputs, and no more than {MOST_GUESSED} are taken unasked: name those that heat by --input, and what they warm by --output"
    ))
}

fn plural(columns: &[usize]) -> &'static str {
    if columns.len() == 1 { "" } else { "s" }
}
