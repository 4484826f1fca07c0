//! One reading of the record for one reference class, and every candidate solved on its sums.

use super::super::candidates::{CandidateMesh, initial_states};
use super::super::design::{GasSource, RegressionDesign, Role};
use super::super::folds::{FOLDS, Score, score};
use super::super::gram::Gram;
use super::super::normal_equations::NormalEquations;
use super::super::options::{GasGiven, IdentifyOptions, InitialState, Progress};
use super::super::pass::{Passed, pass};
use super::super::prior::{Prior, Scales};
use super::super::record::{RecordError, RecordSource, Survey};
use super::super::spread::ValueSpread;
use super::super::support;
use super::plan::{self, GasBanks};
use super::solver::Solver;
use super::terms::{ClassConductances, ConductanceColumns};

/// A mesh, initial state and prior with the winds found for it.
pub(super) struct ConductanceTrial {
    pub(super) mesh: usize,
    pub(super) initial_state: InitialState,
    pub(super) prior: Prior,
    pub(super) follows: bool,
    pub(super) winds: ClassConductances,
    pub(super) scores: Vec<Score>,
}

impl ConductanceTrial {
    /// The geometric mean of the outputs' scores, K².
    pub(super) fn overall(&self) -> f64 {
        let logs = self.scores.iter().map(|score| libm::log(score.overall().max(1e-300)));
        libm::exp(logs.sum::<f64>() / self.scores.len() as f64)
    }
}

/// All candidates for one reference class, and the sums that they were solved on.
pub(super) struct WindSearch {
    pub(super) survey: Survey,
    pub(super) classes: Vec<String>,
    pub(super) reference: usize,
    pub(super) gas: GasSource,
    pub(super) meshes: Vec<CandidateMesh>,
    pub(super) designs: Vec<RegressionDesign>,
    pub(super) passed: Passed,
    pub(super) trials: Vec<ConductanceTrial>,
    /// Which of the trials predicts held-out stretches best.
    best: usize,
    roles: Vec<Vec<Role>>,
    banks: GasBanks,
}

impl WindSearch {
    pub(super) fn of(
        source: &mut dyn RecordSource,
        options: &IdentifyOptions,
        classes: &[String],
        reference: usize,
        progress: &mut Progress<'_>,
    ) -> Result<Self, RecordError> {
        let survey = source.survey().clone();
        let (banks, rows) = (GasBanks::of(options, &survey), survey.rows);
        let gas = match options.gas {
            GasGiven::Unknown => GasSource::Constant(0.0),
            GasGiven::ConstantC(gas_c) => GasSource::Constant(gas_c),
            GasGiven::Column => GasSource::Column,
        };
        let meshes = plan::meshes(survey.longest_s(), survey.sample_period_s, options);
        let design = |mesh| plan::design(mesh, survey.inputs.len(), classes.len(), reference, banks);
        let designs: Vec<RegressionDesign> = meshes.iter().map(design).collect();
        let roles: Vec<Vec<Role>> = designs.iter().map(RegressionDesign::roles).collect();
        let unknowns = roles.iter().map(Vec::len).min().unwrap_or(0);
        support::solvable(&survey, unknowns)?;
        let mut tell = |done| progress("reading", done, rows);
        let passed = pass(source, &designs, FOLDS, gas, u64::MAX, &mut tell)?;
        support::refuse(&survey, &passed.facts, classes, false, false)?;

        progress("choosing", 0, 1);
        let classes = classes.to_vec();
        let (trials, best) = (Vec::new(), 0);
        let mut search = Self { survey, classes, reference, gas, meshes, designs, passed, trials, best, roles, banks };
        search.trials = search.try_all(options);
        let trials = search.trials.iter().enumerate();
        let best = trials.min_by(|a, b| a.1.overall().total_cmp(&b.1.overall())).map(|(best, _)| best);
        search.best = best.ok_or_else(|| search.survey.refuse("gives no candidate"))?;
        Ok(search)
    }

    pub(super) fn best(&self) -> &ConductanceTrial {
        &self.trials[self.best]
    }

    /// The class with the least conductance of the best candidate, summed over elements.
    pub(super) fn weakest_class(&self) -> usize {
        let winds = &self.best().winds;
        let of = |class: usize| winds.conductance.iter().map(|element| element[class]).sum::<f64>();
        (0..self.classes.len()).min_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap_or(self.reference)
    }

    /// How far the warmest output is above the gas, in the middle of its range.
    pub(super) fn greatest_rise_k(&self, gas_c: f64) -> f64 {
        let over_k = |of: &ValueSpread| (f64::midpoint(of.least, of.greatest) - gas_c).abs();
        self.passed.facts.outputs.iter().map(over_k).fold(0.0, f64::max)
    }

    /// What solves a mesh with a prior, an initial state, and structures that follow the gas or do
    /// not.
    pub(super) fn solver<'a>(
        &'a self,
        mesh: usize,
        initial_state: InitialState,
        prior: Prior,
        follows: bool,
        options: &'a IdentifyOptions,
    ) -> Solver<'a> {
        let survey = &self.survey;
        Solver {
            places: ConductanceColumns {
                roles: &self.roles[mesh],
                elements: survey.inputs.len(),
                classes: self.classes.len(),
                reference: self.reference,
                gates: self.banks == GasBanks::Gates,
                follows,
            },
            scales: Scales::of(&self.designs[mesh], &self.passed.facts, std::f64::consts::TAU / survey.longest_s()),
            prior,
            initial_state,
            sample_period_s: survey.sample_period_s,
            signs: &options.signs,
        }
    }

    fn try_all(&self, options: &IdentifyOptions) -> Vec<ConductanceTrial> {
        let mut trials = Vec::new();
        for mesh in 0..self.meshes.len() {
            let total = Gram::total(&self.passed.folds[mesh]);
            for initial_state in initial_states(options.constraints.initial_state, &[]) {
                for follows in plan::followings(self.banks, &self.passed) {
                    let conductance = vec![vec![0.0; self.classes.len()]; self.survey.inputs.len()];
                    let gas_c = plan::gas_guess(options, &self.passed);
                    let mut start = ClassConductances { conductance, gas_c };
                    for prior in plan::priors(options) {
                        let solver = self.solver(mesh, initial_state, prior, follows, options);
                        let winds = solver.solve(&total, start);
                        // The next prior is near: so is its answer.
                        start = winds.clone();
                        let scores = self.scores(mesh, &total, &solver, &winds);
                        trials.push(ConductanceTrial { mesh, initial_state, prior, follows, winds, scores });
                    }
                }
            }
        }
        trials
    }

    /// Of every output, with the winds of the whole record.
    fn scores(&self, mesh: usize, total: &Gram, solver: &Solver<'_>, winds: &ClassConductances) -> Vec<Score> {
        let terms = solver.places.terms(solver.initial_state, winds);
        let of = |output: usize| {
            let of = |fold: &Gram| NormalEquations::of(fold, &terms, solver.places.elements, output);
            let folds: Vec<NormalEquations> = self.passed.folds[mesh].iter().map(of).collect();
            let whole = of(total);
            let positive = solver.positive(&terms, output);
            score(&folds, &whole, &solver.penalty(&terms, &whole), positive.as_deref())
        };
        (0..solver.places.elements).map(of).collect()
    }
}
