//! What the parts of a record must know of the whole, so that their sums add up.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::checksum::RowChecksum;
use super::designs::{RecordFrame, SummedDesigns};
use super::follow::FollowedRecord;
use super::place::{PartPlace, PartStarts};
use super::summed::SummedRows;
use crate::identify::delay::{self, PathDecision};
use crate::identify::folds::FOLDS;
use crate::identify::labels::labels;
use crate::identify::options::{IdentifyOptions, Losses, Progress};
use crate::identify::pass::{Facts, output_means};
use crate::identify::record::{Block, InBlocks, RecordError, RecordSource, RecordStream, Selection, Survey};
use crate::identify::segment::start_rates;
use crate::identify::symbol::{asked_of, plan::SymbolPlan};
use crate::identify::validate_options;
use crate::model::Structure;

/// What the user should know.
const NOT_LOOKED_FOR: &str = "from sums of parts: losses that grow with temperature, and single rows that stand out behind the first 240 of a segment, are not looked for";

/// Each leaves some ten to a hundred kilobytes in the sums.
const MOST_SEGMENTS: u64 = 500;
/// Why the rows of a part are not those for which the plan was made.
const CHANGED: &str = "was changed since the plan was made: make the plan anew, of the parts as they are";

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
    /// First row of every segment.
    segments: Vec<u64>,
    selection: Selection,
    /// In the order of their rows.
    pub parts: Vec<PartPlace>,
}

impl GramPlan {
    /// Plans the sums of a record whose parts are these files, in their order. Every file is read
    /// three times, and once more for events, without any sums.
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
        Self::of(&mut whole, own, parts, options, progress)
    }

    /// Plans the sums of a record that is cut so.
    pub(super) fn of(
        source: &mut dyn RecordSource,
        selection: Selection,
        parts: Vec<PartPlace>,
        options: &IdentifyOptions,
        progress: &mut Progress<'_>,
    ) -> Result<(Self, PartStarts), RecordError> {
        let source = &mut InBlocks::of(source);
        let survey = source.survey().clone();
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
        survey.refuse_if(
            parts.iter().map(|part| part.rows).sum::<u64>() != survey.rows,
            "has other rows as a whole than in its parts: cut it where no row is left out, or identify it as a whole",
        )?;
        let (facts, output_shift, segments) = (Facts::default(), Vec::new(), vec![0]);
        let mut plan =
            Self { survey, options, classes, path, open_path, facts, output_shift, segments, selection, parts };
        let starts = plan.read(source, progress)?;
        plan.survey.notes.push(NOT_LOOKED_FOR.to_owned());
        Ok((plan, starts))
    }

    /// Facts, segments, checksums of the parts, and the states with which each of them begins, from
    /// one reading without sums.
    fn read(&mut self, source: &mut dyn RecordSource, progress: &mut Progress<'_>) -> Result<PartStarts, RecordError> {
        source.restart()?;
        if let Some(first) = source.next_block()? {
            self.output_shift = output_means(first);
            self.facts.add(&first.rows(0..1));
        }
        let (designs, mut facts) = (self.designs()?, Facts::default());
        let mut followed = FollowedRecord::of(&designs, &self.parts);
        source.restart()?;
        while let Some(block) = source.next_block()? {
            let missing = block.missing.first().map(|&at| facts.rows + u64::from(at) + 1);
            self.survey.refuse_if(
                missing.is_some(),
                format_args!(
                    "lacks an output in row {}: fill it, or identify the record as a whole",
                    missing.unwrap_or(0)
                ),
            )?;
            facts.add(block);
            followed.push(block);
            progress("planning", facts.rows, self.survey.rows);
        }
        let (starts, segments, checksums) = followed.finish();
        (self.facts, self.segments) = (facts, segments);
        self.parts.iter_mut().zip(checksums).for_each(|(part, checksum)| part.checksum = checksum);
        Ok(starts)
    }

    /// What is summed of every part.
    pub(super) fn designs(&self) -> Result<SummedDesigns, RecordError> {
        let survey = asked_of(&self.survey, &self.options);
        let tried = SymbolPlan::of(survey, self.classes.clone(), self.path.clone(), &self.options)?;
        let record = RecordFrame {
            sample_period_s: self.survey.sample_period_s,
            rows: self.survey.rows,
            segments: self.segments.clone(),
            starts_rad_s: start_rates(&self.survey),
            output_shift: self.output_shift.clone(),
            first_gas_c: self.facts.gas.map(|gas| gas.from),
        };
        Ok(SummedDesigns::of(tried.designs, record))
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

    /// Its stretches of rows that follow each other in time.
    pub const fn segments(&self) -> usize {
        self.segments.len()
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
        let place = self.place_of(&mut source)?;
        self.sum(&mut source, starts, place, progress)
    }

    /// The place of a part: that of the same rows at the same times. Of several, as recordings of
    /// one length are, that of the same numbers; of copies that of the same name.
    fn place_of(&self, source: &mut dyn RecordSource) -> Result<usize, RecordError> {
        let part = source.survey().clone();
        part.refuse_if(
            part.time_column != self.survey.time_column,
            format_args!(
                "has its times in `{}`, and the record of the plan in `{}`: parts have the columns of the whole",
                part.time_column, self.survey.time_column
            ),
        )?;
        let is_it = |place: &PartPlace| {
            (place.rows, place.first_time_s, place.last_time_s) == (part.rows, part.first_time_s, part.last_time_s)
        };
        let mut alike: Vec<usize> = (0..self.parts.len()).filter(|&at| is_it(&self.parts[at])).collect();
        part.refuse_if(
            alike.is_empty(),
            format_args!(
                "has {} rows from {} s to {} s, as none of the {} parts of the plan: make the plan anew, of the parts as they are",
                part.rows,
                part.first_time_s,
                part.last_time_s,
                self.parts.len()
            ),
        )?;
        if alike.len() > 1 {
            let checksum = self.checksum(source)?;
            alike.retain(|&at| self.parts[at].checksum == checksum);
        }
        let named = alike.iter().find(|&&at| self.parts[at].path.file_name() == part.path.file_name());
        named.or(alike.first()).copied().ok_or_else(|| part.refuse(CHANGED))
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
        let mut summing = designs.summing_part(self.parts[part].first_row, start);
        let (survey, mut done, mut checksum) = (source.survey().clone(), 0, RowChecksum::default());
        source.restart()?;
        while let Some(block) = source.next_block()? {
            let block = block.clone();
            let block = self.in_its_classes(block, source)?;
            done += block.len() as u64;
            checksum.add(&block, 0..block.len());
            summing.push(&block).ok_or_else(|| survey.refuse(CHANGED))?;
            progress("summing", done, survey.rows);
        }
        survey.refuse_if(checksum.finish() != self.parts[part].checksum, CHANGED)?;
        summing.finish().ok_or_else(|| survey.refuse(CHANGED))
    }

    /// The checksum of a part's rows, from a reading.
    fn checksum(&self, source: &mut dyn RecordSource) -> Result<u64, RecordError> {
        let mut checksum = RowChecksum::default();
        source.restart()?;
        while let Some(block) = source.next_block()? {
            let block = block.clone();
            let block = self.in_its_classes(block, source)?;
            checksum.add(&block, 0..block.len());
        }
        Ok(checksum.finish())
    }

    /// Rows of a part with the numbers that classes have in the whole record.
    fn in_its_classes(&self, mut block: Block, part: &dyn RecordSource) -> Result<Block, RecordError> {
        let class_of: Result<Vec<u32>, RecordError> =
            part.classes().iter().map(|label| self.class(part.survey(), label)).collect();
        let class_of = class_of?;
        block.class.iter_mut().for_each(|class| *class = class_of[*class as usize]);
        Ok(block)
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
        survey.segments > MOST_SEGMENTS,
        format_args!(
            "has {} segments, and sums are of {MOST_SEGMENTS} at most: fill short gaps, or identify it as a whole",
            survey.segments
        ),
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
