//! Cross-validation over winds: which are held out together.
//!
//! A wind that is held out while its neighbour stays would be known from it. So neighbours go together, in two ways that ask two questions:
//!
//! | scheme | held out together | question |
//! |---|---|---|
//! | directions | all winds, of whatever speed, from one region of directions: those nearest to one of K of them that lie far apart | does it know directions that it has not seen? |
//! | speeds | all winds, from wherever, of a band of neighbouring speeds; the slowest and the fastest always stay, for beyond them nothing is claimed | does it know speeds that it has not seen? |
//!
//! Still gas always stays. Every fold is fitted from nothing.

use super::run::Wind;
use super::speeds::{ascending, distinct};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    Directions,
    Speeds,
}

impl Scheme {
    pub fn name(self) -> &'static str {
        match self {
            Self::Directions => "directions",
            Self::Speeds => "speeds",
        }
    }
}

/// Places of the winds, as given, that are held out together: at most `count` folds, none empty.
pub fn folds(winds: &[Wind], scheme: Scheme, count: usize) -> Vec<Vec<usize>> {
    let moving = ascending(winds);
    let mut folds = match scheme {
        Scheme::Directions => directions(&moving, count),
        Scheme::Speeds => speeds(&moving, count),
    };
    folds.retain(|fold| !fold.is_empty());
    folds
}

fn directions(moving: &[&Wind], count: usize) -> Vec<Vec<usize>> {
    let cosine = |a: &Wind, b: &Wind| (0..3).map(|k| a.towards[k] * b.towards[k]).sum::<f64>();
    let nearness = |wind: &Wind, seeds: &[&Wind]| seeds.iter().map(|seed| cosine(wind, seed)).fold(-1.0, f64::max);
    let mut seeds: Vec<&Wind> = moving.iter().take(1).copied().collect();
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

fn speeds(moving: &[&Wind], count: usize) -> Vec<Vec<usize>> {
    let groups = distinct(moving);
    let inner = groups.get(1..groups.len().saturating_sub(1)).unwrap_or_default();
    let count = count.min(inner.len());
    let mut folds = vec![Vec::new(); count];
    for (j, group) in inner.iter().enumerate() {
        folds[j * count / inner.len()].extend(group.iter().map(|wind| wind.given));
    }
    folds
}

#[cfg(test)]
mod tests {
    use super::super::run::{ready, winds};
    use super::super::tests::tunnel::{Tunnel, speeds as progression};
    use super::*;

    #[test]
    fn neighbours_go_together_and_every_wind_is_held_out_once() {
        let tunnel = Tunnel::sectors();
        let head = ready(&tunnel.head()).unwrap();
        let winds = winds(&head, &tunnel.readings(&progression(0.5, 14.0, 12), 10, 1e-3, 1)).unwrap();
        for (scheme, expected) in [(Scheme::Directions, 120), (Scheme::Speeds, 100)] {
            let folds = folds(&winds, scheme, 5);
            let mut all = folds.concat();
            all.sort_unstable();
            all.dedup();
            assert_eq!((folds.len(), all.len(), folds.concat().len()), (5, expected, expected));
            for fold in &folds {
                for wind in winds.iter().filter(|wind| !wind.is_still() && !fold.contains(&wind.given)) {
                    for &out in fold {
                        let same_direction = (0..3).all(|k| (winds[out].towards[k] - wind.towards[k]).abs() < 1e-9);
                        let same_speed = (winds[out].reynolds / wind.reynolds - 1.0).abs() < 1e-9;
                        assert!(!(if scheme == Scheme::Speeds { same_speed } else { same_direction }));
                    }
                }
            }
        }
        // Bands of two neighbouring speeds of the ten inner ones.
        let bands = folds(&winds, Scheme::Speeds, 5);
        let reynolds = |fold: &[usize]| fold.iter().map(|&out| winds[out].reynolds).collect::<Vec<_>>();
        assert!(bands.windows(2).all(|pair| {
            let [below, above] = [reynolds(&pair[0]), reynolds(&pair[1])];
            below.iter().all(|b| above.iter().all(|a| b < a))
        }));
    }
}
