//! The models that are tried: meshes, initial states and priors.
//!
//! | family | mesh | begins | prior |
//! |---|---|---|---|
//! | any initial state | from ξ_T or ξ_T/2 to π/Ts, 1.5 to 3 rates a decade; 5 or 7 for a second opinion (`whiteness`) | free, settled or at rest | tapered |
//! | known initial state | from 0.3 ξ_T, 3 or 4 rates a decade | settled or at rest | tapered |
//! | smooth | guard rates on both sides of ξ_T … π/Ts | settled or at rest | smooth |
//!
//! ξ_T = 2πJ/T is the thesis' lower edge. Below it, a free initial state and a slow pole explain
//! the same drift, so that records with a free initial state are not offered meshes that reach far
//! below. Orders or edges that the user gives replace those of the table.

use dr_core::model::mesh;

use super::design::Role;
use super::drift;
use super::normal_equations::ModelTerm;
use super::options::{Constraints, InitialState};
use super::prior::Prior;

/// How much wider than the thesis' a smooth mesh is on either side, and its rates a decade (two of
/// them beyond each edge).
const GUARD: f64 = 7.197;
const SMOOTH_PER_DECADE: f64 = 7.0 / 3.0;
/// Rates a decade that are tried, and whether they are so many that they must earn it.
const PER_DECADE: [(f64, bool); 5] = [(1.5, false), (2.0, false), (3.0, false), (5.0, true), (7.0, true)];
/// More rates than that tell nothing apart and cost time.
pub const MOST_RATES: usize = 40;

/// A mesh that is tried.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidateMesh {
    pub rates_rad_s: Vec<f64>,
    /// ξ_1 / ξ_T
    pub factor: f64,
    /// Whether the prior is the smooth one.
    pub smooth: bool,
    /// Whether a free initial state is tried with it.
    pub free: bool,
    /// Whether it is so fine that it must leave white residuals, or, if it is slow as well, half
    /// the error of others, to be taken.
    pub fine: bool,
    pub part: MeshPart,
    /// Rates that its banks have besides, for poles of filters.
    pub poles_rad_s: Vec<f64>,
}

impl CandidateMesh {
    /// Its rates and poles, ascending.
    pub fn all_rad_s(&self) -> Vec<f64> {
        let mut all = [&self.rates_rad_s[..], &self.poles_rad_s].concat();
        all.sort_by(f64::total_cmp);
        all
    }
}

/// What a mesh is tried for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshPart {
    /// The choice where the offset stands.
    Ordinary,
    /// The choice where it moves.
    Drifting,
    /// An average of many.
    Averaged,
    /// What an average stands on; nothing is read for it.
    Union,
}

fn geometric(first: f64, last: f64, order: usize) -> Vec<f64> {
    (0..order).map(|k| mesh::rate_rad_s(first, last, k, order)).collect()
}

fn order_for(first: f64, last: f64, per_decade: f64) -> usize {
    ((libm::log10(last / first) * per_decade).round() as usize + 1).clamp(2, MOST_RATES)
}

/// The meshes worth trying for a record of `duration_s` with `classes` event classes.
pub fn meshes(duration_s: f64, sample_period_s: f64, classes: usize, given: &Constraints) -> Vec<CandidateMesh> {
    let (first, last) = mesh::thesis_edges_rad_s(duration_s, sample_period_s, classes as u32);
    let single = |first: f64, last: f64, order: usize| CandidateMesh {
        rates_rad_s: geometric(first, last, order),
        factor: first / (std::f64::consts::TAU * classes as f64 / duration_s),
        smooth: false,
        free: true,
        fine: false,
        part: MeshPart::Ordinary,
        poles_rad_s: Vec::new(),
    };
    let by_decades = |first: f64, last: f64| {
        PER_DECADE
            .map(|(per_decade, fine)| CandidateMesh { fine, ..single(first, last, order_for(first, last, per_decade)) })
    };
    match (given.order, given.edges_rad_s) {
        (Some(order), Some((first, last))) => vec![single(first, last, order)],
        (None, Some((first, last))) => by_decades(first, last).to_vec(),
        (Some(order), None) => [1.0, 0.5].map(|factor| single(factor * first, last, order)).to_vec(),
        (None, None) => {
            let mut meshes = [1.0, 0.5].map(|factor| by_decades(factor * first, last)).concat();
            let slow = 0.3 * first;
            let (low, high) = (first / GUARD, last * GUARD);
            meshes.push(CandidateMesh {
                free: false,
                smooth: true,
                ..single(low, high, order_for(low, high, SMOOTH_PER_DECADE))
            });
            for (per_decade, fine) in [(3.0, false), (4.0, true)] {
                meshes.push(CandidateMesh {
                    free: false,
                    fine,
                    ..single(slow, last, order_for(slow, last, per_decade))
                });
            }
            meshes
        }
    }
}

/// A mesh from `factor` times ξ_T to π/Ts.
pub fn dense(duration_s: f64, sample_period_s: f64, factor: f64, per_decade: f64) -> CandidateMesh {
    let (first, last) = mesh::thesis_edges_rad_s(duration_s, sample_period_s, 1);
    let first = factor * first;
    let rates_rad_s = geometric(first, last, order_for(first, last, per_decade));
    let (part, poles_rad_s) = (MeshPart::Ordinary, Vec::new());
    CandidateMesh { rates_rad_s, factor, smooth: false, free: true, fine: false, part, poles_rad_s }
}

/// Factors of ξ_T and rates a decade of what is averaged.
const AVERAGED: [(f64, f64); 2] = [(0.1, 1.5), (0.25, 2.5)];
/// The rate of the slow walk that an average allows for, in units of one over the record's length.
const SLOW_WALK: f64 = 12.0;
/// The mesh on which a drift is looked for.
const DRIFTING: (f64, f64) = (1.0, 4.0);

/// The mesh for records whose offset moves.
pub fn drifting(duration_s: f64, sample_period_s: f64, ordinary: &CandidateMesh, given: &Constraints) -> CandidateMesh {
    let (factor, per_decade) = DRIFTING;
    let own = if given.has_mesh() { ordinary.clone() } else { dense(duration_s, sample_period_s, factor, per_decade) };
    let poles_rad_s = drift::poles(&own.rates_rad_s, duration_s, sample_period_s);
    CandidateMesh { part: MeshPart::Drifting, poles_rad_s, ..own }
}

/// The meshes of an average, and the one that has the rates of all.
pub fn averaged(duration_s: f64, sample_period_s: f64) -> Vec<CandidateMesh> {
    let of = |(factor, per_decade)| {
        let own = dense(duration_s, sample_period_s, factor, per_decade);
        let middles = own.rates_rad_s.windows(2).map(|two| (two[0] * two[1]).sqrt());
        let apart = |rate: &f64| libm::log(rate * duration_s / SLOW_WALK).abs();
        let pole = middles.min_by(|a, b| apart(a).total_cmp(&apart(b)));
        CandidateMesh { part: MeshPart::Averaged, poles_rad_s: pole.into_iter().collect(), ..own }
    };
    let mut meshes: Vec<CandidateMesh> = AVERAGED.map(of).to_vec();
    let mut rates_rad_s: Vec<f64> = meshes.iter().flat_map(|mesh| mesh.rates_rad_s.clone()).collect();
    rates_rad_s.sort_by(f64::total_cmp);
    rates_rad_s.dedup();
    let union = CandidateMesh { rates_rad_s, part: MeshPart::Union, poles_rad_s: Vec::new(), ..meshes[0].clone() };
    meshes.push(union);
    meshes
}

/// Priors to try on a mesh, the most cautious first: from the strongest to the weakest, or the
/// other way round on a mesh that the user gave.
pub fn priors(mesh: &CandidateMesh, given: &Constraints) -> Vec<Prior> {
    if let Some(ridge) = given.ridge {
        return vec![Prior::Columns(ridge)];
    }
    if mesh.smooth {
        return (0..=36).map(|step| Prior::Smooth(libm::pow(10.0, 0.5 * f64::from(-step)))).collect();
    }
    let mut priors = [1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12].map(Prior::Tapered).to_vec();
    // Who gives the mesh has said what is likely: then a prior must earn its place. It would cost
    // the standard errors their truth, since what it pulls the resistances by is not what it allows
    // for.
    if given.mesh_is_fixed() {
        priors.reverse();
    }
    priors
}

/// Initial states to try, the most cautious first. Where nothing drives the first row, settled is
/// at rest.
pub fn initial_states(given: Option<InitialState>, first_drives: &[f64]) -> Vec<InitialState> {
    let drives = first_drives.iter().any(|&drive| drive != 0.0);
    match given {
        Some(initial_state) => vec![initial_state],
        None if drives => vec![InitialState::Rest, InitialState::Settled, InitialState::Free],
        None => vec![InitialState::Rest, InitialState::Free],
    }
}

/// The parameters of a design with a given initial state. `first_drives` is what drove each bank in
/// the first row.
pub fn terms(roles: &[Role], initial_state: InitialState, feed_through: bool, first_drives: &[f64]) -> Vec<ModelTerm> {
    let initial =
        |rate: f64| roles.iter().position(|role| matches!(role, Role::Initial { rate_rad_s } if *rate_rad_s == rate));
    let mut terms = Vec::new();
    for (column, &role) in roles.iter().enumerate() {
        let mut of = vec![(column, 1.0)];
        match role {
            Role::Relaxation { bank, rate_rad_s, .. } => {
                // Settled at u: x(0) = u, which adds u e^(−ξt) to what starts at zero.
                let first = first_drives.get(bank).copied().unwrap_or(0.0);
                if initial_state == InitialState::Settled && first != 0.0 {
                    of.extend(initial(rate_rad_s).map(|column| (column, first)));
                }
            }
            Role::FeedThrough { .. } if !feed_through => continue,
            Role::Initial { .. } if initial_state != InitialState::Free => continue,
            Role::FeedThrough { .. } | Role::Initial { .. } | Role::Offset | Role::DriftStart { .. } => {}
        }
        terms.push(ModelTerm { of, role });
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smooth_mesh_has_two_guards_a_side_of_the_thesis_edges() {
        let meshes = meshes(1000.0, 5e-4, 1, &Constraints::default());
        let smooth = meshes.iter().find(|mesh| mesh.smooth).unwrap();
        assert_eq!(smooth.rates_rad_s.len(), 19);
        let (first, last) = mesh::thesis_edges_rad_s(1000.0, 5e-4, 1);
        assert_eq!(smooth.rates_rad_s.iter().filter(|&&rate| rate < first * 0.999).count(), 2);
        assert_eq!(smooth.rates_rad_s.iter().filter(|&&rate| rate > last * 1.001).count(), 2);
    }

    #[test]
    fn what_the_user_gives_is_the_only_mesh() {
        let given = Constraints { order: Some(8), edges_rad_s: Some((0.1, 10.0)), ..Constraints::default() };
        let meshes = meshes(1000.0, 0.1, 1, &given);
        assert_eq!(meshes.len(), 1);
        assert_eq!((meshes[0].rates_rad_s.len(), meshes[0].rates_rad_s[0], meshes[0].rates_rad_s[7]), (8, 0.1, 10.0));
    }

    #[test]
    fn between_edges_that_are_given_stand_few_rates_and_many() {
        let given = Constraints { edges_rad_s: Some((0.1, 10.0)), ..Constraints::default() };
        let meshes = meshes(1000.0, 0.1, 1, &given);
        let counted: Vec<_> = meshes.iter().map(|mesh| (mesh.rates_rad_s.len(), mesh.fine)).collect();
        assert_eq!(counted, [(4, false), (5, false), (7, false), (11, true), (15, true)]);
        assert!(meshes.iter().all(|mesh| mesh.rates_rad_s[0] == 0.1 && mesh.rates_rad_s.last() == Some(&10.0)));
    }

    #[test]
    fn a_settled_initial_state_is_its_own_initial_decay() {
        let roles =
            [Role::Relaxation { bank: 0, k: 0, rate_rad_s: 2.0 }, Role::Initial { rate_rad_s: 2.0 }, Role::Offset];
        let settled = terms(&roles, InitialState::Settled, false, &[3.0]);
        assert_eq!(settled.len(), 2);
        assert_eq!(settled[0].of, vec![(0, 1.0), (1, 3.0)]);
        assert_eq!(terms(&roles, InitialState::Rest, false, &[3.0])[0].of, vec![(0, 1.0)]);
        assert_eq!(terms(&roles, InitialState::Free, false, &[3.0]).len(), 3);
    }
}
