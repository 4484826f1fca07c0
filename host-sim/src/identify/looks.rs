//! Residuals of every output's choice: outputs that chose the same design share a reading.

use std::rc::Rc;

use super::IdentifyError;
use super::choose::Choice;
use super::design::Design;
use super::pass::GasSource;
use super::record::Source;
use super::residuals::{Fitted, Looked, Seen, look};

/// A reading, and which of those that share it an output was.
#[derive(Clone)]
pub struct Look {
    pub place: usize,
    pub looked: Rc<Looked>,
}

/// By output. `seen` hears of every row of every reading.
pub fn look_at_all(
    source: &mut dyn Source,
    designs: &[Design],
    output_shift: &[f64],
    choices: &[Choice],
    seen: &mut dyn FnMut(&Seen<'_>),
) -> Result<Vec<Look>, IdentifyError> {
    let mut looks: Vec<Option<Look>> = vec![None; choices.len()];
    for first in 0..choices.len() {
        if looks[first].is_some() {
            continue;
        }
        let mesh = choices[first].trial.mesh;
        let alike: Vec<usize> = (first..choices.len()).filter(|&other| choices[other].trial.mesh == mesh).collect();
        let fitted: Vec<Fitted> = alike
            .iter()
            .map(|&output| Fitted {
                output,
                theta: in_columns(&choices[output], designs[mesh].width()),
                shift: output_shift[output],
            })
            .collect();
        let looked = Rc::new(look(source, &designs[mesh], GasSource::Constant(0.0), &fitted, seen)?);
        for (place, &output) in alike.iter().enumerate() {
            looks[output] = Some(Look { place, looked: Rc::clone(&looked) });
        }
    }
    Ok(looks.into_iter().flatten().collect())
}

/// Parameters as weights of the design's columns.
pub fn in_columns(choice: &Choice, width: usize) -> Vec<f64> {
    let mut weights = vec![0.0; width];
    for (term, theta) in choice.terms.iter().zip(choice.solution.theta.iter()) {
        for &(column, weight) in &term.of {
            weights[column] += weight * theta;
        }
    }
    weights
}
