//! Which banks of relaxations a record's inputs and classes ask for, and on which meshes.

use super::super::candidates::{self, Given, Mesh};
use super::super::design::{Bank, Design, Drive};

/// Unknowns beyond which only the smallest mesh is tried: the search takes time with their third power.
const MOST_UNKNOWNS: usize = 300;

/// A bank's part: which input drives it in which class, and whether it belongs to the element's own heat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    pub input: usize,
    pub class: usize,
    pub kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// For every output.
    Any,
    /// For the output of the same number only, or for all others.
    Own,
    Cross,
}

impl Part {
    pub fn is_seen_by(self, output: usize) -> bool {
        match self.kind {
            Kind::Any => true,
            Kind::Own => self.input == output,
            Kind::Cross => self.input != output,
        }
    }
}

/// Every input, in every class if there are several.
pub fn parts(inputs: usize, classes: usize, kind: Kind) -> Vec<Part> {
    (0..inputs).flat_map(|input| (0..classes).map(move |class| Part { input, class, kind })).collect()
}

/// Meshes that the record's rows can determine, and that the machine can search.
///
/// # Errors
/// The rest of a sentence that begins with the record.
pub fn meshes(
    rows: u64,
    sample_period_s: f64,
    inputs: usize,
    classes: usize,
    given: &Given,
) -> Result<Vec<Mesh>, String> {
    let mut meshes = candidates::meshes(rows as f64 * sample_period_s, sample_period_s, classes, given);
    let unknowns = |mesh: &Mesh| mesh.rates_rad_s.len() * (inputs * classes + 1) + 1;
    let fewest = meshes.iter().map(unknowns).min().unwrap_or(0);
    if fewest as u64 >= rows {
        return Err(format!("has {rows} rows for {fewest} unknowns: record longer, or ask for fewer with --order"));
    }
    // What the rows cannot determine well is not worth a trial, nor what takes too long, unless it is the only one.
    let most = (rows / 3).min(MOST_UNKNOWNS as u64).max(fewest as u64);
    meshes.retain(|mesh| unknowns(mesh) as u64 <= most);
    let all: Vec<usize> = meshes.iter().map(unknowns).collect();
    super::super::support::affordable(&all, inputs, classes)?;
    Ok(meshes)
}

/// What all designs of a record have in common.
pub struct Layout<'a> {
    pub parts: &'a [Part],
    /// Rates of cross-heating, if they have their own.
    pub cross_rad_s: Option<Vec<f64>>,
    /// Whether inputs drive only in their class.
    pub gated: bool,
    pub lag: usize,
    pub feed_through: bool,
    /// Whether the record may begin with anything but rest.
    pub initial: bool,
    pub outputs: usize,
}

impl Layout<'_> {
    pub fn design(&self, mesh: &Mesh) -> Design {
        let bank = |part: &Part| Bank {
            drive: match self.gated {
                true => Drive::Gated { input: part.input, class: part.class },
                false => Drive::Input(part.input),
            },
            rates_rad_s: match (&self.cross_rad_s, part.kind) {
                (Some(cross), Kind::Cross) => cross.clone(),
                _ => mesh.rates_rad_s.clone(),
            },
            delay: self.lag,
            feed_through: self.feed_through && part.kind != Kind::Cross,
        };
        Design {
            banks: self.parts.iter().map(bank).collect(),
            initial_rad_s: if self.initial { mesh.rates_rad_s.clone() } else { Vec::new() },
            outputs: self.outputs,
        }
    }
}

/// Rates of cross-heating: what is not given is as on the first mesh.
pub fn cross_rates(given: &Given, meshes: &[Mesh], duration_s: f64, sample_period_s: f64, classes: usize) -> Vec<f64> {
    let own = &meshes[0].rates_rad_s;
    let edges = given.edges_rad_s.or(Some((own[0], own[own.len() - 1])));
    let order = given.order.or(Some(own.len()));
    let given = Given { order, edges_rad_s: edges, ..Given::default() };
    candidates::meshes(duration_s, sample_period_s, classes, &given).remove(0).rates_rad_s
}
