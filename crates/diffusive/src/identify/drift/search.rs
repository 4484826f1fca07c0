//! Kind and size of a drift, by the marginal likelihood of a record.
//!
//! ```text
//! −2 ln p(y) = (n − m) ln s² + ln|G + P| − ln|P|,     s² = (yᵀy − bᵀθ)/(n − m)
//! ```
//!
//! on filtered columns, for m parameters without a prior (the offset). The filter's own determinant
//! is one.

use nalgebra::{Cholesky, DMatrix};

use super::columns::PoleColumns;
use super::filter::{NoiseFilter, Section};
use super::{DriftGiven, DriftKind};
use crate::identify::design::RegressionDesign;
use crate::identify::gram::{Gram, Starts};
use crate::identify::normal_equations::ModelTerm;
use crate::identify::prior::{Prior, Scales};
use crate::identify::segment::held;

/// Evidence, in nats, that a drift of chosen kind and size must have over none. Twice the excess of
/// one that is not there follows χ² with one or two degrees of freedom.
pub const WORTH: f64 = 4.0;

/// Evidence that a walk must have before others are tried, nats.
const SCREEN: f64 = 1.0;

/// The model with which drifts are compared.
pub struct DriftCase<'a> {
    pub gram: &'a Gram,
    pub columns: &'a PoleColumns,
    pub terms: &'a [ModelTerm],
    pub output: usize,
    pub scales: &'a Scales,
    pub priors: &'a [Prior],
    /// Rates of what later segments begin with.
    pub starts_rad_s: &'a [f64],
    /// Poles that filters may have, ascending.
    pub poles_rad_s: &'a [f64],
}

impl DriftCase<'_> {
    /// Filters that were tried, each with its evidence over none and what its kind was worth
    /// before: all kinds the same, and within a kind all zeros the same. The best first; those
    /// within `counts` nats of it.
    pub fn search(&self, given: DriftGiven, counts: f64) -> Vec<(NoiseFilter, f64)> {
        let kinds = match given {
            DriftGiven::None => return Vec::new(),
            DriftGiven::Auto => DriftKind::ALL.to_vec(),
            DriftGiven::Kind(kind) => vec![kind],
        };
        let plain = self.evidence(None);
        if given == DriftGiven::Auto {
            // Whatever moves, a walk of some size explains better than an offset that stands.
            let walks = self.weighed(self.poles_rad_s.iter().map(|&pole| NoiseFilter::walk(pole)));
            if walks.iter().all(|(_, evidence)| *evidence < plain + SCREEN) {
                return Vec::new();
            }
        }
        let mut all: Vec<(NoiseFilter, f64)> = kinds.into_iter().flat_map(|kind| self.tried(kind)).collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        let most = all.first().map_or(f64::NEG_INFINITY, |best| best.1);
        all.retain(|(_, evidence)| *evidence > most - counts);
        all.iter_mut().for_each(|(_, evidence)| *evidence -= plain);
        all
    }

    /// Evidence of a filter, at its best prior.
    pub fn evidence(&self, filter: Option<&NoiseFilter>) -> f64 {
        self.by_prior(filter).into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Evidence of a filter with each of the priors.
    pub fn by_prior(&self, filter: Option<&NoiseFilter>) -> Vec<f64> {
        let (terms, problem) = self.columns.problem(self.gram, self.terms, self.output, filter);
        let of_starts =
            |filter| starts_evidence(self.gram.starts, self.starts_rad_s, filter, self.columns.sample_period_s());
        let starts = filter.map_or(0.0, of_starts);
        let of = |prior: &Prior| problem.evidence(&self.scales.penalty(*prior, &terms, &problem)) + starts;
        self.priors.iter().map(of).collect()
    }

    fn weighed(&self, filters: impl Iterator<Item = NoiseFilter>) -> Vec<(NoiseFilter, f64)> {
        let of = |filter: NoiseFilter| {
            let evidence = self.evidence(Some(&filter));
            (filter, evidence)
        };
        filters.map(of).collect()
    }

    fn tried(&self, kind: DriftKind) -> Vec<(NoiseFilter, f64)> {
        let poles = self.poles_rad_s;
        let of = |sections: Vec<Section>| NoiseFilter { kind, sections };
        match kind {
            DriftKind::RandomWalk => {
                let coarse = self.weighed(poles.iter().map(|&pole| NoiseFilter::walk(pole)));
                let between = self.between(&coarse);
                [coarse, between].concat()
            }
            DriftKind::IntegratedWalk => {
                let pairs = (0..poles.len()).flat_map(|at| [at + 1, at + 2].map(|next| (at, next)));
                let section = |at: usize| Section { pole_rad_s: poles[at], zero_rad_s: 0.0 };
                let pairs = pairs.filter(|(_, next)| *next < poles.len());
                self.weighed(pairs.map(|(at, next)| of(vec![section(at), section(next)])))
            }
            DriftKind::Correlated => {
                // From one over the record on, as far as a pole allows.
                let slowest = 0.25 * poles.first().copied().unwrap_or(1.0);
                let zeros: Vec<f64> = (0..40).map(|step| slowest * libm::pow(10.0, 0.2 * f64::from(step))).collect();
                let zeros_of = |pole: f64| zeros.iter().copied().take_while(move |zero| *zero < 0.7 * pole);
                let pairs = poles.iter().flat_map(|&pole| zeros_of(pole).map(move |zero| (pole, zero)));
                let section = |(pole_rad_s, zero_rad_s)| of(vec![Section { pole_rad_s, zero_rad_s }]);
                let coarse = self.weighed(pairs.map(section));
                let between = self.between(&coarse);
                let mut all = [coarse, between].concat();
                let worth = libm::log(zeros.len() as f64);
                all.iter_mut().for_each(|(_, evidence)| *evidence -= worth);
                all
            }
        }
    }

    /// Filters whose pole stands between that of the best and a neighbour.
    fn between(&self, coarse: &[(NoiseFilter, f64)]) -> Vec<(NoiseFilter, f64)> {
        let Some((best, most)) = coarse.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return Vec::new() };
        let own = best.sections[0];
        let at = self.poles_rad_s.iter().position(|pole| *pole == own.pole_rad_s).unwrap_or_default();
        let neighbours = [at.wrapping_sub(1), at + 1];
        let neighbours = neighbours.into_iter().filter_map(|at| self.poles_rad_s.get(at).copied());
        let zeros: Vec<f64> = coarse
            .iter()
            .filter(|(filter, evidence)| *evidence > most - 8.0 && filter.sections[0].pole_rad_s == own.pole_rad_s)
            .map(|(filter, _)| filter.sections[0].zero_rad_s)
            .collect();
        let between = neighbours.flat_map(|neighbour| {
            let zeros = &zeros;
            [0.25_f64, 0.5, 0.75].into_iter().flat_map(move |part| {
                // The effective pole is both poles over the zero between them.
                let middle = libm::pow(neighbour, 1.0 - part) * libm::pow(own.pole_rad_s, part);
                let second = Section { pole_rad_s: neighbour, zero_rad_s: middle };
                let first = move |&zero_rad_s: &f64| Section { zero_rad_s, ..own };
                zeros.iter().map(move |zero| NoiseFilter { kind: best.kind, sections: vec![first(zero), second] })
            })
        });
        self.weighed(between)
    }
}

/// What a filter is worth where the starts are averaged out of a likelihood: −½ (ln|(FD)ᵀFD| −
/// ln|DᵀD|), by which likelihoods of the same rows are compared (H. D. Patterson and R.
/// Thompson, *Biometrika* 58 (1971) 545). All segments count as of the same length.
fn starts_evidence(starts: Starts, rates_rad_s: &[f64], filter: &NoiseFilter, sample_period_s: f64) -> f64 {
    if starts.segments == 0.0 {
        return 0.0;
    }
    let poles: Vec<f64> = filter.sections.iter().map(|section| section.pole_rad_s).collect();
    let design = RegressionDesign {
        banks: Vec::new(),
        initial_rad_s: [rates_rad_s, &poles].concat(),
        outputs: 0,
        from_rest: false,
    };
    let (columns, width) = (PoleColumns::of(&design, sample_period_s), design.width());
    let (offset, rows) = (width - 1, starts.rows / starts.segments);
    // Σ_n e^(−(ξ + ζ) n Ts)
    let rate = |column: usize| design.initial_rad_s.get(column).copied().unwrap_or(0.0);
    let sum = |i: usize, j: usize| {
        let both = (rate(i) + rate(j)) * sample_period_s;
        if both > 0.0 { libm::expm1(-both * rows) / libm::expm1(-both) } else { rows }
    };
    let sums = DMatrix::from_fn(width, width, sum);
    let own: Vec<usize> = (0..rates_rad_s.len()).chain([offset]).collect();
    let mut map = DMatrix::zeros(width, own.len());
    for (k, &column) in own.iter().enumerate() {
        for (at, weight) in columns.innovations(&[(column, 1.0)], filter) {
            map[(at, k)] += weight;
        }
    }
    let plain = DMatrix::from_fn(own.len(), own.len(), |i, j| sums[(own[i], own[j])]);
    let held = DMatrix::from_diagonal(&plain.diagonal().map(held));
    let log = |sums: DMatrix<f64>| {
        let factor = Cholesky::new(sums + &held);
        factor.map_or(0.0, |factor| factor.l_dirty().diagonal().iter().map(|pivot| libm::log(*pivot)).sum::<f64>())
    };
    starts.segments * (log(plain) - log(map.tr_mul(&(sums * &map))))
}
