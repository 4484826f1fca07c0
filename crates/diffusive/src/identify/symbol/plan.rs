//! What is tried for a record: which banks of relaxations its inputs and classes need, and on which
//! meshes.

use dr_core::model::mesh::thesis_edges_rad_s;

use super::super::candidates::{self, CandidateMesh, MeshPart};
use super::super::delay::PathDecision;
use super::super::design::{BankDrive, GasSource, RegressionDesign, RelaxationBank};
use super::super::drift::DriftGiven;
use super::super::folds::FOLDS;
use super::super::options::{Constraints, IdentifyOptions, InitialState, Progress};
use super::super::pass::{Passed, pass};
use super::super::prior::Scales;
use super::super::record::{RecordError, RecordSource, Survey};
use super::super::support;

/// Unknowns beyond which only the smallest mesh is tried: the search takes time with their third
/// power.
const MOST_UNKNOWNS: usize = 300;

/// A bank's part: which input drives it in which class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BankPart {
    pub input: usize,
    pub class: usize,
}

/// Meshes that allow for an offset that moves, behind the others; none where they are more than the
/// machine should be asked for, or no choice is left.
fn meshes_besides(
    survey: &Survey,
    classes: usize,
    options: &IdentifyOptions,
    ordinary: &[CandidateMesh],
) -> Vec<CandidateMesh> {
    let (duration_s, period_s, given) = (survey.longest_s(), survey.sample_period_s, &options.constraints);
    let is_plain = options.drift == DriftGiven::None || options.no_drift_for(classes).is_some();
    let mut meshes = Vec::new();
    if !is_plain {
        meshes.push(candidates::drifting(duration_s, period_s, &ordinary[0], given));
    }
    if !is_plain && !given.has_mesh() && given.ridge.is_none() && options.structure.is_none() {
        meshes.extend(candidates::averaged(duration_s, period_s));
    }
    let width =
        |mesh: &CandidateMesh| (mesh.rates_rad_s.len() + mesh.poles_rad_s.len()) * (survey.driven_banks(classes) + 1);
    let most = (survey.rows / 3).min(MOST_UNKNOWNS as u64) as usize;
    if meshes.iter().any(|mesh| width(mesh) > most) { Vec::new() } else { meshes }
}

/// Every input, in every class if there are several.
fn parts(inputs: usize, classes: usize) -> Vec<BankPart> {
    (0..inputs).flat_map(|input| (0..classes).map(move |class| BankPart { input, class })).collect()
}

/// Meshes that the record's rows can determine, and that the machine can search.
///
/// # Errors
/// If the rows are too few, or the unknowns too many.
fn meshes(survey: &Survey, classes: usize, given: &Constraints) -> Result<Vec<CandidateMesh>, RecordError> {
    let (rows, banks) = (survey.rows, survey.driven_banks(classes));
    let mut meshes = candidates::meshes(survey.longest_s(), survey.sample_period_s, classes, given);
    if survey.segments > 1 && given.edges_rad_s.is_none() {
        // Those far below the thesis' edge win by chance: what a segment began with hides them.
        meshes.retain(|mesh| mesh.factor > 0.49);
    }
    let unknowns = |mesh: &CandidateMesh| mesh.rates_rad_s.len() * (banks + 1) + 1;
    let fewest = meshes.iter().map(unknowns).min().unwrap_or(0);
    support::solvable(survey, fewest)?;
    // What the rows cannot determine well is not worth a trial, nor what takes too long, unless it
    // is the only one.
    let most = (rows / 3).min(MOST_UNKNOWNS as u64).max(fewest as u64);
    meshes.retain(|mesh| unknowns(mesh) as u64 <= most);
    let all: Vec<usize> = meshes.iter().map(unknowns).collect();
    support::affordable(survey, &all, classes)?;
    Ok(meshes)
}

/// What is tried for one record, and what all its designs have in common.
pub struct SymbolPlan {
    pub survey: Survey,
    pub classes: Vec<String>,
    /// Dead time and feed-through.
    pub path: PathDecision,
    pub meshes: Vec<CandidateMesh>,
    /// By mesh.
    pub designs: Vec<RegressionDesign>,
    /// By bank; a bank of the surroundings stands behind them.
    pub parts: Vec<BankPart>,
}

/// What is tried, and the sums of one reading on which all of it is.
pub struct SymbolReading {
    pub plan: SymbolPlan,
    pub passed: Passed,
    pub scales: Scales,
    /// What drove each bank in the first row.
    pub first_drives: Vec<f64>,
}

impl SymbolPlan {
    pub fn of(
        survey: Survey,
        classes: Vec<String>,
        path: PathDecision,
        options: &IdentifyOptions,
    ) -> Result<Self, RecordError> {
        let (inputs, outputs) = (survey.inputs.len(), survey.outputs.len());
        let mut meshes = meshes(&survey, classes.len(), &options.constraints)?;
        meshes.extend(meshes_besides(&survey, classes.len(), options, &meshes));
        let parts = parts(inputs, classes.len());
        let bank = |part: &BankPart, mesh: &CandidateMesh| RelaxationBank {
            drive: match classes.len() > 1 {
                true => BankDrive::Gated { input: part.input, class: part.class },
                false => BankDrive::Input(part.input),
            },
            rates_rad_s: mesh.all_rad_s(),
            delay: path.delay,
            feed_through: path.feed_through,
        };
        // At rest nothing decays; but whether the record agrees is asked, where there is a choice.
        let may_begin =
            options.constraints.initial_state != Some(InitialState::Rest) || options.asks_for_an_initial_state();
        let means = |mesh: &CandidateMesh| {
            let of = |output| RelaxationBank {
                drive: BankDrive::Output(output),
                rates_rad_s: mesh.poles_rad_s.clone(),
                delay: 0,
                feed_through: false,
            };
            let count = if mesh.poles_rad_s.is_empty() { 0 } else { outputs };
            (0..count).map(of).collect::<Vec<_>>()
        };
        let ambient = |mesh: &CandidateMesh| {
            survey.gas_column.as_ref().map(|_| RelaxationBank {
                drive: BankDrive::Gas,
                rates_rad_s: mesh.all_rad_s(),
                delay: 0,
                feed_through: false,
            })
        };
        let design = |mesh: &CandidateMesh| RegressionDesign {
            banks: parts.iter().map(|part| bank(part, mesh)).chain(ambient(mesh)).chain(means(mesh)).collect(),
            // A filter needs the decays at its poles, whatever the record began with.
            initial_rad_s: if may_begin { mesh.all_rad_s() } else { mesh.poles_rad_s.clone() },
            outputs,
            from_rest: path.from_rest,
        };
        let designs = meshes.iter().map(design).collect();
        Ok(Self { survey, classes, path, meshes, designs, parts })
    }

    /// One reading of the record for all designs.
    pub fn read(
        self,
        source: &mut dyn RecordSource,
        options: &IdentifyOptions,
        progress: &mut Progress<'_>,
    ) -> Result<SymbolReading, RecordError> {
        let mut tell = |done| progress("reading", done, self.survey.rows);
        let is_read = |mesh: &&CandidateMesh| mesh.part != MeshPart::Union;
        let read = self.meshes.iter().filter(is_read).count();
        let passed = pass(source, &self.designs[..read], FOLDS, GasSource::Constant(0.0), u64::MAX, &mut tell)?;
        let from_rest = options.constraints.initial_state == Some(InitialState::Rest);
        support::refuse(&self.survey, &passed.facts, &self.classes, self.is_gated(), from_rest)?;
        if let (Some(column), Some(gas)) = (&self.survey.gas_column, &passed.facts.gas) {
            self.survey.refuse_if(
                gas.sd() == 0.0,
                format_args!("column `{column}` is {} in all rows: surroundings that never move are in the offset; leave out --ambient", gas.least),
            )?;
        }
        let duration_s = self.survey.longest_s();
        let classes = self.classes.len() as u32;
        let (thesis_rad_s, _) = thesis_edges_rad_s(duration_s, self.survey.sample_period_s, classes);
        // All meshes have the same banks.
        let scales = Scales::of(&self.designs[0], &passed.facts, thesis_rad_s);
        let first_drives = passed.facts.first_drives(&self.designs[0]);
        Ok(SymbolReading { plan: self, passed, scales, first_drives })
    }

    /// Whether models with feed-through columns are tried, and models without.
    pub fn feed_throughs(&self, given: &Constraints) -> &'static [bool] {
        match (self.path.feed_through, given.feed_through) {
            (false, _) => &[false],
            (true, None) => &[false, true],
            (true, Some(_)) => &[true],
        }
    }

    /// Rates of a bank that a model has: filters' poles are none of it.
    pub fn rates_of(&self, mesh: usize, bank: usize) -> Vec<f64> {
        let poles = &self.meshes[mesh].poles_rad_s;
        let rates = self.designs[mesh].banks[bank].rates_rad_s.iter().copied();
        rates.filter(|rate| !poles.contains(rate)).collect()
    }

    /// The bank of measured surroundings.
    pub fn ambient_bank(&self) -> Option<usize> {
        self.survey.gas_column.is_some().then_some(self.parts.len())
    }

    /// Whether a bank is a part of a model: filters' means are of none.
    pub fn is_seen(&self, bank: usize) -> bool {
        self.ambient_bank() == Some(bank) || bank < self.parts.len()
    }

    /// Whether inputs drive only in their class.
    pub fn is_gated(&self) -> bool {
        self.classes.len() > 1
    }
}
