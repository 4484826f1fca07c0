//! Any text as a model: refused in one sentence, or a model that is written and read as the same,
//! and can be run, drawn, reduced and exported.

use super::sentences::said;
use diffusive::model::PairClass;
use diffusive::model::export::table;
use diffusive::model::{Forward, Model, reduce};
use plot::model::figure;

/// Work that grows with a model's size says nothing of whether it is sound.
const LONGEST_TEXT: usize = 20_000;
const LONGEST_DELAY: usize = 1_000;

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    match Model::from_json(text) {
        Err(error) => {
            said(&error.to_string());
            false
        }
        Ok(model) => {
            assert_eq!(Model::from_json(&model.to_json()).as_ref(), Ok(&model));
            let delay = model.pairs.iter().map(|pair| pair.dead_time_samples).max().unwrap_or(0);
            if text.len() < LONGEST_TEXT && delay < LONGEST_DELAY {
                make_use_of(&model);
            }
            true
        }
    }
}

fn make_use_of(model: &Model) {
    let (inputs, outputs) = (vec![1.0; model.inputs.len()], vec![0.0; model.outputs.len()]);
    let at_rest = Forward::at_rest(model, model.sample_period_s);
    let going_on = model.end.as_ref().map(|end| Forward::going_on(model, end));
    for mut motion in [Some(at_rest), going_on].into_iter().flatten() {
        let mut row = outputs.clone();
        (0..5).for_each(|_| motion.row(&inputs, 0, 20.0, &mut row));
    }
    figure(model, &[]).svg();
    reduce::reduce(model, 2, reduce::Rates::Free).ok();
    for pair in &model.pairs {
        let name = format!("{}:{}", pair.input, pair.output);
        if let Ok(part) = PairClass::find(model, Some(&name), Some(&model.classes[0])) {
            table::cauer_table(&part).ok();
            table::symbol_table(&part).ok();
            table::response_table(&part, 20).ok();
        }
    }
}
