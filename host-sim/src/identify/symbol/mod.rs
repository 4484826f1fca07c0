//! Structure `symbol`: a symbol for every pair of input and output and every event class (thesis 2.13–2.21).
//!
//! One class: columns are the states of the inputs. Several: the states of the inputs *gated* to a class, which go on decaying while
//! another class holds; all classes share what the record began with.

mod layout;
mod reasons;
mod report;

use std::collections::BTreeMap;

use super::candidates::Beginning;
use super::choose::{Choice, Field};
use super::delay;
use super::design::{Design, Drive};
use super::folds::FOLDS;
use super::looks::look_at_all;
use super::pass::{GasSource, pass};
use super::prior::Scales;
use super::record::Source;
use super::tied::Ties;
use super::whiter::{is_white, prefer_white};
use super::{IdentifyError, Options, Progress, Sight, support};
use crate::model::{Model, Structure};
use layout::{Kind, Layout, Part, cross_rates};
use reasons::chosen;
pub(super) use reasons::{chosen_by, doubts};
use report::Found;
pub(super) use report::{class_of, decays};

pub fn identify(
    source: &mut dyn Source,
    options: &Options,
    progress: &mut Progress<'_>,
    sight: &mut Sight<'_>,
) -> Result<Model, IdentifyError> {
    let survey = source.survey().clone();
    let rows = survey.rows;
    let classes = labels(source, progress)?;
    let gated = classes.len() > 1;
    let duration_s = rows as f64 * survey.sample_period_s;

    let mut reasons = Vec::new();
    let inputs: Vec<Drive> = (0..survey.inputs.len()).map(Drive::Input).collect();
    let path = delay::decide(source, &inputs, &options.given)?;
    reasons.extend(path.reason);
    let (lag, feed_through) = (path.delay, path.feed_through);

    let meshes = layout::meshes(rows, survey.sample_period_s, survey.inputs.len(), classes.len(), &options.given)
        .map_err(|sentence| IdentifyError::unfit(source, sentence))?;
    let parts_of = |kind| layout::parts(survey.inputs.len(), classes.len(), kind);
    let (parts, cross_rad_s) = match &options.cross {
        None => (parts_of(Kind::Any), None),
        Some(given) => {
            let parts = [parts_of(Kind::Own), parts_of(Kind::Cross)].concat();
            (parts, Some(cross_rates(given, &meshes, duration_s, survey.sample_period_s, classes.len())))
        }
    };
    let layout = Layout {
        parts: &parts,
        cross_rad_s,
        gated,
        lag,
        feed_through,
        initial: options.given.beginning != Some(Beginning::Rest),
        outputs: survey.outputs.len(),
    };
    let designs: Vec<Design> = meshes.iter().map(|mesh| layout.design(mesh)).collect();
    let mut tell = |done| progress("reading", done, rows);
    let passed = pass(source, &designs, FOLDS, GasSource::Constant(0.0), u64::MAX, &mut tell)?;
    let facts = &passed.facts;
    let from_rest = options.given.beginning == Some(Beginning::Rest);
    support::refuse(&survey, facts, &classes, gated, from_rest)
        .map_err(|sentence| IdentifyError::unfit(source, sentence))?;

    let (thesis_rad_s, _) =
        dr_core::model::mesh::thesis_edges_rad_s(duration_s, survey.sample_period_s, classes.len() as u32);
    let first_drive = |part: &Part| match gated && facts.first_class != part.class {
        true => 0.0,
        false => facts.first_inputs[part.input],
    };
    let first_drives: Vec<f64> = parts.iter().map(first_drive).collect();
    let bank_input: Vec<usize> = parts.iter().map(|part| part.input).collect();
    let scales = Scales { drive: bank_input.iter().map(|&input| facts.input_scale(input)).collect(), thesis_rad_s };
    let with_or_without: &[bool] = match (feed_through, options.given.feed_through) {
        (false, _) => &[false],
        (true, None) => &[false, true],
        (true, Some(_)) => &[true],
    };
    progress("choosing", 0, 1);
    let sights: Vec<_> = (0..survey.outputs.len())
        .map(|output| {
            let parts = &parts;
            move |bank: usize| parts[bank].is_seen_by(output)
        })
        .collect();
    let field = |output: usize| Field {
        meshes: &meshes,
        designs: &designs,
        folds: &passed.folds,
        scales: &scales,
        first_drives: &first_drives,
        bank_input: &bank_input,
        outputs: survey.outputs.len(),
        output_shift: &passed.output_shift,
        sees: &sights[output],
        feed_through: with_or_without,
    };
    let choose = |output| field(output).choose(&options.given, &options.signs, output);
    let choices: Vec<Choice> = (0..survey.outputs.len()).map(choose).collect();
    let choices = prefer_white(
        source,
        &designs,
        &passed.output_shift,
        choices,
        &|output, choice| field(output).best_rival(choice, &options.given, &options.signs, output),
        &mut |row| tell_now_and_then(progress, "looking at residuals", row, rows),
    )?;

    let (choices, against_ties) = if options.tie {
        let ties = Ties {
            designs: &designs,
            folds: &passed.folds,
            scales: &scales,
            first_drives: &first_drives,
            parts: &parts.iter().map(|part| (part.input, part.class)).collect::<Vec<_>>(),
            sees: &|output, bank: usize| parts[bank].is_seen_by(output),
        };
        let tied = ties.tie(choices);
        reasons.push(tied.reason);
        (tied.choices, tied.warning)
    } else {
        (choices, None)
    };

    let mut row = |seen: &super::residuals::Seen<'_>| {
        tell_now_and_then(progress, "residuals", seen.row, rows);
        sight(seen);
    };
    let looks = look_at_all(source, &designs, &passed.output_shift, &choices, &mut row)?;

    let mut warnings = support::warnings(&survey, facts);
    warnings.extend(against_ties);
    let found = Found { designs: &designs, parts: &parts, classes: &classes, choices: &choices, looks: &looks };
    let outputs = found.outputs(&survey, &passed.output_shift);
    let pairs = found.pairs(&survey, lag);
    for (output, choice) in choices.iter().enumerate() {
        warnings.extend(doubts(&survey.outputs[output], choice, facts, output, duration_s, &pairs));
    }
    for (output, name) in survey.outputs.iter().enumerate() {
        if let Some((row, part)) = looks[output].looked.residuals[output].lonely_row() {
            warnings.push(format!(
                "`{name}`: row {} alone makes {:.0} % of all squared residuals: a reading that went wrong? correct it, or cut the record there",
                row + lag as u64,
                100.0 * part
            ));
        }
    }
    let chosen = chosen(&choices[0], is_white(&looks[0], 0), &meshes, lag, reasons, &options.given);
    Ok(Model {
        format: crate::model::FORMAT.to_owned(),
        version: crate::model::VERSION,
        structure: Structure::Symbol,
        sample_period_s: survey.sample_period_s,
        inputs: survey.inputs.clone(),
        offset_c: outputs[0].offset_c,
        residual_rms: outputs[0].residual_rms,
        fit_percent: outputs[0].fit_percent,
        outputs,
        pairs,
        event_column: survey.event_column.clone().filter(|_| gated),
        classes: classes.clone(),
        conductance_w_per_k: BTreeMap::new(),
        wind: None,
        supported: warnings.is_empty(),
        warnings,
        chosen,
        provenance: facts.provenance(&survey),
        end: Some(found.end(survey.inputs.len())),
    })
}

/// The labels of all classes: a record with an event column is read once for them.
pub(super) fn labels(source: &mut dyn Source, progress: &mut Progress<'_>) -> Result<Vec<String>, IdentifyError> {
    if source.survey().event_column.is_some() {
        source.restart()?;
        let (mut done, rows) = (0, source.survey().rows);
        while let Some(block) = source.next_block()? {
            done += block.len() as u64;
            progress("looking for events", done, rows);
        }
    }
    Ok(source.classes().to_vec())
}

fn tell_now_and_then(progress: &mut Progress<'_>, what: &'static str, row: u64, rows: u64) {
    if row.is_multiple_of(65_536) {
        progress(what, row, rows);
    }
}
