//! The Reynolds numbers of a set of winds, in groups.

use super::super::compared::ReynoldsRange;
use super::readings::CheckedWind;

/// Winds within this ratio have one speed: what a tunnel scatters, not what somebody has set.
const SAME: f64 = 1.15;
const OCTAVE: f64 = 2.0;

/// Winds that are not still, slowest first.
pub fn ascending(winds: &[CheckedWind]) -> Vec<&CheckedWind> {
    let mut moving: Vec<&CheckedWind> = winds.iter().filter(|wind| !wind.is_quiescent()).collect();
    moving.sort_by(|a, b| a.reynolds.total_cmp(&b.reynolds));
    moving
}

/// The speeds that were set: winds of one speed each, slowest first. What is given ascends.
pub fn distinct<'a>(ascending: &[&'a CheckedWind]) -> Vec<Vec<&'a CheckedWind>> {
    let mut groups: Vec<Vec<&CheckedWind>> = Vec::new();
    for wind in ascending {
        match groups.last_mut() {
            Some(group) if wind.reynolds <= SAME * group[0].reynolds => group.push(wind),
            _ => groups.push(vec![wind]),
        }
    }
    groups
}

/// The range of these winds (ascending, not empty) in like surfaces of an octave at most, if
/// `most_octaves` is 1.
pub fn classes(ascending: &[&CheckedWind], most_octaves: f64) -> Vec<ReynoldsRange> {
    let (first, last) = (ascending[0], ascending[ascending.len() - 1]);
    let octaves = (last.reynolds / first.reynolds).ln() / OCTAVE.ln();
    // A little more than a whole number of octaves is that number.
    let count = (octaves / most_octaves - 0.1).ceil().max(1.0);
    let speed_per_reynolds = |reynolds: f64| {
        // By the wind next to it: pressures may differ between runs.
        let near = |wind: &&&CheckedWind| (wind.reynolds / reynolds).ln().abs();
        let nearest = ascending.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
        nearest.map_or(f64::NAN, |wind| wind.speed_m_s / wind.reynolds)
    };
    let edge = |j: f64| first.reynolds * (last.reynolds / first.reynolds).powf(j / count);
    (0..count as usize)
        .map(|j| {
            let (mut from, mut to) = (edge(j as f64), edge(j as f64 + 1.0));
            let speed_m_s = [from, to].map(|r| r * speed_per_reynolds(r));
            if j == 0 {
                from *= 1.0 - 1e-9;
            }
            if j + 1 == count as usize {
                to *= 1.0 + 1e-9;
            }
            ReynoldsRange { reynolds: [from, to], speed_m_s }
        })
        .collect()
}
