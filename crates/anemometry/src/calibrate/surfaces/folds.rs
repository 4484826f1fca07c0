//! Folds of a cross-validation: winds that are left out together.
//!
//! A wind that is left out while its neighbour stays would be known from it. So neighbours go
//! together, in two ways that ask two questions:
//!
//! | scheme | left out together | question |
//! |---|---|---|
//! | directions | all winds, of whatever speed, from one region of directions: those nearest to one of K of them that lie far apart | does it know directions that it has not seen? |
//! | speeds | all winds, from wherever, of a band of neighbouring speeds; the slowest and the fastest always stay, for beyond them nothing is claimed | does it know speeds that it has not seen? |
//!
//! Of a single element, which has no directions, every n-th wind in the order of speeds is left
//! out. Still gas always stays. Every fold is fitted from nothing.

use super::super::cross_validation::Scheme;
use super::readings::CheckedWind;
use super::speeds::{ascending, distinct};

/// Places of the winds, as given, that are left out together: at most `count` folds, none empty.
pub fn folds(winds: &[CheckedWind], scheme: Scheme, count: usize) -> Vec<Vec<usize>> {
    let moving = ascending(winds);
    let mut folds = match scheme {
        Scheme::Directions => directions(&moving, count),
        Scheme::Speeds => speeds(&moving, count),
        Scheme::EveryNth => {
            let nth = |n: usize| moving.iter().skip(n).step_by(count).map(|wind| wind.given).collect();
            (0..count).map(nth).collect()
        }
    };
    folds.retain(|fold| !fold.is_empty());
    folds
}

fn directions(moving: &[&CheckedWind], count: usize) -> Vec<Vec<usize>> {
    let cosine = |a: &CheckedWind, b: &CheckedWind| (0..3).map(|k| a.towards[k] * b.towards[k]).sum::<f64>();
    let nearness =
        |wind: &CheckedWind, seeds: &[&CheckedWind]| seeds.iter().map(|seed| cosine(wind, seed)).fold(-1.0, f64::max);
    let mut seeds: Vec<&CheckedWind> = moving.iter().take(1).copied().collect();
    while seeds.len() < count {
        // The one farthest from all of them.
        match moving.iter().min_by(|a, b| nearness(a, &seeds).total_cmp(&nearness(b, &seeds))) {
            Some(next) if nearness(next, &seeds) < 1.0 - 1e-6 => seeds.push(next),
            _ => break,
        }
    }
    let mut folds = vec![Vec::new(); seeds.len()];
    for wind in moving {
        let nearest = (0..seeds.len()).max_by(|&a, &b| cosine(wind, seeds[a]).total_cmp(&cosine(wind, seeds[b])));
        if let Some(nearest) = nearest {
            folds[nearest].push(wind.given);
        }
    }
    folds
}

fn speeds(moving: &[&CheckedWind], count: usize) -> Vec<Vec<usize>> {
    let groups = distinct(moving);
    let inner = groups.get(1..groups.len().saturating_sub(1)).unwrap_or_default();
    let count = count.min(inner.len());
    let mut folds = vec![Vec::new(); count];
    for (j, group) in inner.iter().enumerate() {
        folds[j * count / inner.len()].extend(group.iter().map(|wind| wind.given));
    }
    folds
}
