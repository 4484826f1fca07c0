//! What the parts of a record must know of the whole, so that their sums add up.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::checksum::{PartChecksums, RowChecksum};
use super::summed::{BatchStart, SummedDesigns, SummedRows, batch_from};
use crate::identify::delay::{self, PathDecision};
use crate::identify::folds::FOLDS;
use crate::identify::gas_source::GasSource;
use crate::identify::labels::labels;
use crate::identify::options::{IdentifyOptions, Losses, Progress};
use crate::identify::panels::BATCH;
use crate::identify::pass::{Facts, pass};
use crate::identify::record::{Block, InBlocks, RecordError, RecordSource, RecordStream, Selection, Survey};
use crate::identify::symbol::{asked_of, plan::SymbolPlan};
use crate::identify::validate_options;
use crate::identify::whole_batches::WholeBatches;
use crate::model::Structure;

/// What the user should know.
const UNTOLD: &str = "from sums of parts: losses that grow with temperature, and single rows that stand out behind the first 240, are not looked for";

/// A part of a record, and its place in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartPlace {
    /// Its file, as the plan found it.
    pub path: PathBuf,
    /// Counted from 0.
    pub first_row: u64,
    /// How many rows it has.
    pub rows: u64,
    /// Time of its first row, s.
    pub first_time_s: f64,
    /// Time of its last row, s.
    pub last_time_s: f64,
    /// Of its numbers.
    pub(super) checksum: u64,
}

/// What is known of a record as a whole, and what is tried for it: the same for all its parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GramPlan {
    pub(super) survey: Survey,
    pub(super) options: IdentifyOptions,
    pub(super) classes: Vec<String>,
    pub(super) path: PathDecision,
    /// With any initial state.
    pub(super) open_path: PathDecision,
    pub(super) facts: Facts,
    pub(super) output_shift: Vec<f64>,
    selection: Selection,
    /// In the order of their rows.
    pub parts: Vec<PartPlace>,
}

/// By part, the states with which its first whole batch begins; none for a part without any.
pub type PartStarts = Vec<Option<BatchStart>>;

impl GramPlan {
    /// Plans the sums of a record whose parts are these files, in their order. Every file is read
    /// four times, without any sums.
    ///
    /// # Errors
    /// As [`crate::identify::identify`]; or if the record or the options ask for what sums cannot
    /// tell.
    pub fn of_files(
        paths: &[PathBuf],
        selection: &Selection,
        options: &IdentifyOptions,
        progress: &mut Progress<'_>,
    ) -> Result<(Self, PartStarts), RecordError> {
        let mut whole = RecordStream::open_all(paths, selection)?;
        let own = named(selection, whole.survey());
        let (mut parts, mut first_row) = (Vec::new(), 0);
        for path in paths {
            let part = RecordStream::open(path, &own)?;
            let Survey { rows, first_time_s, last_time_s, .. } = *part.survey();
            parts.push(PartPlace { path: path.clone(), first_row, rows, first_time_s, last_time_s, checksum: 0 });
            first_row += rows;
        }
        if let Some(sentence) = whole.mended() {
            return Err(whole.survey().refuse(sentence));
        }
        Self::of(&mut InBlocks::of(&mut whole), own, parts, options, progress)
    }

    /// Plans the sums of a record that is cut so.
    pub(super) fn of(
        source: &mut dyn RecordSource,
        selection: Selection,
        parts: Vec<PartPlace>,
        options: &IdentifyOptions,
        progress: &mut Progress<'_>,
    ) -> Result<(Self, PartStarts), RecordError> {
        let mut survey = source.survey().clone();
        let mut options = options.clone();
        refuse(&survey, &options)?;
        validate_options::refuse(&survey, &options)?;
        // What is not asked for is not looked for.
        options.losses = Losses::None;
        let classes = labels(source, progress)?;
        let path = delay::decide(source, &options.constraints)?;
        // Where the record contradicts a state that is asked for, any other is tried.
        let is_asked = options.asks_for_an_initial_state();
        let open = options.with_any_initial_state().constraints;
        let open_path = if is_asked { delay::decide(source, &open)? } else { path.clone() };
        let is_same = (path.delay, path.feed_through) == (open_path.delay, open_path.feed_through);
        survey.refuse_if(
            !is_same,
            format_args!(
                "has a dead time of {} samples with the initial state that is asked for, and of {} with any: say which with --dead-time and --feed-through, or leave out --initial-state",
                path.delay, open_path.delay
            ),
        )?;
        survey.refuse_if(
            path.delay as u64 >= survey.rows / FOLDS as u64,
            format_args!(
                "has a dead time of {} samples, more than a tenth of its rows: identify it as a whole",
                path.delay
            ),
        )?;
        let mut tell = |done| progress("planning", done, survey.rows);
        let passed = pass(source, &[], FOLDS, GasSource::Constant(0.0), u64::MAX, &mut tell)?;
        survey.refuse_if(
            parts.iter().map(|part| part.rows).sum::<u64>() != survey.rows,
            "has other rows as a whole than in its parts: cut it where no row is left out, or identify it as a whole",
        )?;
        let (facts, output_shift) = (passed.facts, passed.output_shift);
        survey.notes.push(UNTOLD.to_owned());
        let mut plan = Self { survey, options, classes, path, open_path, facts, output_shift, selection, parts };
        let (starts, checksums) = plan.starts(source, progress)?;
        plan.parts.iter_mut().zip(checksums).for_each(|(part, checksum)| part.checksum = checksum);
        Ok((plan, starts))
    }

    /// The states with which every part begins, and checksums of the parts, from one reading
    /// without sums.
    fn starts(
        &self,
        source: &mut dyn RecordSource,
        progress: &mut Progress<'_>,
    ) -> Result<(PartStarts, Vec<u64>), RecordError> {
        let designs = self.designs()?;
        let (mut run, mut batches) = (designs.following(), WholeBatches::default());
        let mut starts = vec![None; self.parts.len()];
        // A part in which no batch begins needs none.
        let begins =
            |part: &PartPlace| Some(batch_from(part.first_row)).filter(|row| *row < part.first_row + part.rows);
        let begins: Vec<Option<u64>> = self.parts.iter().map(begins).collect();
        let mut next = 0;
        let mut checksums = PartChecksums::new(self.parts.iter().map(|part| part.first_row + part.rows).collect());
        source.restart()?;
        while let Some(block) = source.next_block()? {
            checksums.push(block);
            batches.push(block, &mut |rows| {
                for from in (0..rows.len()).step_by(BATCH) {
                    let row = run.row();
                    while begins.get(next).is_some_and(|begin| begin.is_none_or(|begin| begin <= row)) {
                        starts[next] = (begins[next] == Some(row)).then(|| run.state());
                        next += 1;
                    }
                    run.push(&rows.rows(from..rows.len().min(from + BATCH)));
                }
            });
            progress("following states", run.row(), self.survey.rows);
        }
        while next < begins.len() {
            starts[next] = (begins[next] == Some(run.row())).then(|| run.state());
            next += 1;
        }
        Ok((starts, checksums.finish()))
    }

    /// What is summed of every part.
    pub(super) fn designs(&self) -> Result<SummedDesigns, RecordError> {
        let survey = asked_of(&self.survey, &self.options);
        let tried = SymbolPlan::of(survey, self.classes.clone(), self.path.clone(), &self.options)?;
        let first_gas_c = self.facts.gas.map(|gas| gas.from);
        Ok(SummedDesigns::of(
            tried.designs,
            self.survey.sample_period_s,
            self.survey.rows,
            &self.output_shift,
            first_gas_c,
        ))
    }

    /// The file of the record.
    pub fn record(&self) -> &Path {
        &self.survey.path
    }

    /// What was found remarkable in the record, and what sums do not tell.
    pub fn notes(&self) -> &[String] {
        &self.survey.notes
    }

    /// Rows of the whole record.
    pub const fn rows(&self) -> u64 {
        self.survey.rows
    }

    /// Sums a part of the record.
    ///
    /// # Errors
    /// If the file is none of the parts, or cannot be read.
    pub fn sum_file(
        &self,
        starts: &PartStarts,
        path: &Path,
        progress: &mut Progress<'_>,
    ) -> Result<SummedRows, RecordError> {
        let mut source = RecordStream::open(path, &self.selection)?;
        if let Some(sentence) = source.mended() {
            return Err(source.survey().refuse(sentence));
        }
        let place = self.place_of(source.survey())?;
        self.sum(&mut source, starts, place, progress)
    }

    /// The place of a part: that of the same rows at the same times, of the same name if there are
    /// several.
    fn place_of(&self, part: &Survey) -> Result<usize, RecordError> {
        part.refuse_if(
            part.time_column != self.survey.time_column,
            format_args!(
                "has its times in `{}`, and the record of the plan in `{}`: parts have the columns of the whole",
                part.time_column, self.survey.time_column
            ),
        )?;
        let is_it = |place: &&PartPlace| {
            (place.rows, place.first_time_s, place.last_time_s) == (part.rows, part.first_time_s, part.last_time_s)
        };
        let is_named = |place: &&PartPlace| place.path.file_name() == part.path.file_name();
        let alike = || self.parts.iter().enumerate().filter(|(_, place)| is_it(place));
        let place = alike().find(|(_, place)| is_named(place)).or_else(|| alike().next());
        place.map(|(at, _)| at).ok_or_else(|| {
            let (rows, from_s, to_s) = (part.rows, part.first_time_s, part.last_time_s);
            part.refuse(format!(
                "has {rows} rows from {from_s} s to {to_s} s, as none of the {} parts of the plan: make the plan anew, of the parts as they are",
                self.parts.len()
            ))
        })
    }

    /// Sums the rows of a part.
    pub(super) fn sum(
        &self,
        source: &mut dyn RecordSource,
        starts: &PartStarts,
        part: usize,
        progress: &mut Progress<'_>,
    ) -> Result<SummedRows, RecordError> {
        let designs = self.designs()?;
        let start = starts.get(part).and_then(Option::as_ref);
        let mut summing = designs.summing(self.parts[part].first_row, start);
        let (survey, mut done, mut checksum) = (source.survey().clone(), 0, RowChecksum::default());
        source.restart()?;
        while let Some(block) = source.next_block()? {
            refuse_block(&survey, block, done)?;
            done += block.len() as u64;
            checksum.add(block, 0..block.len());
            let mut block = block.clone();
            let class_of: Result<Vec<u32>, RecordError> =
                source.classes().iter().map(|label| self.class(&survey, label)).collect();
            let class_of = class_of?;
            block.class.iter_mut().for_each(|class| *class = class_of[*class as usize]);
            summing.push(&block);
            progress("summing", done, survey.rows);
        }
        survey.refuse_if(
            checksum.finish() != self.parts[part].checksum,
            "was changed since the plan was made: make the plan anew, of the parts as they are",
        )?;
        Ok(summing.finish())
    }

    fn class(&self, part: &Survey, label: &str) -> Result<u32, RecordError> {
        let place = self.classes.iter().position(|known| known == label);
        place.map(|place| place as u32).ok_or_else(|| {
            part.refuse(format!("has rows labelled `{label}`, and the record of the plan has none: make the plan anew"))
        })
    }
}

/// Refuses what sums of parts cannot tell.
fn refuse(survey: &Survey, options: &IdentifyOptions) -> Result<(), RecordError> {
    let asked = [
        (options.free_poles.is_some(), "free poles are searched"),
        (options.structure == Some(Structure::Conductance), "structure `conductance` is fitted"),
        (options.losses == Losses::Growing, "losses that grow with temperature are estimated"),
    ];
    for (_, what) in asked.iter().filter(|(is_asked, _)| *is_asked) {
        survey.refuse_if(
            true,
            format_args!("{what} on rows, and no sums of parts tell them: identify the record as a whole"),
        )?;
    }
    survey.refuse_if(
        survey.segments > 1,
        format_args!(
            "has gaps, and {} segments: parts of one segment add up, several are identified as a whole",
            survey.segments
        ),
    )
}

/// Refuses rows that do not follow each other.
fn refuse_block(survey: &Survey, block: &Block, row: u64) -> Result<(), RecordError> {
    survey
        .refuse_if(block.begins_segment, format_args!("has a gap before row {}: a part is of one segment", row + 1))?;
    let missing = block.missing.first().map(|&at| row + u64::from(at) + 1);
    survey.refuse_if(
        missing.is_some(),
        format_args!("lacks an output in row {}: fill it, or identify the record as a whole", missing.unwrap_or(0)),
    )
}

/// The columns of a record by their names, whatever a part of it would choose.
fn named(selection: &Selection, survey: &Survey) -> Selection {
    Selection {
        inputs: survey.inputs.clone(),
        outputs: survey.outputs.clone(),
        event: survey.event_column.clone(),
        gas: survey.gas_column.clone(),
        ..selection.clone()
    }
}
