//! The Reynolds numbers of a set of winds, in groups.

use super::run::Wind;

/// Winds within this ratio have one speed: what a tunnel scatters, not what somebody has set.
const SAME: f64 = 1.15;
const OCTAVE: f64 = 2.0;

/// A range of Reynolds numbers with its speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub reynolds: [f64; 2],
    pub speed_m_s: [f64; 2],
}

impl Range {
    pub fn holds(&self, reynolds: f64) -> bool {
        // A wind on the border belongs to the upper range, but the fastest to the last.
        (self.reynolds[0]..self.reynolds[1]).contains(&reynolds)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([a, b], [from, to]) = (self.speed_m_s, self.reynolds);
        write!(f, "{} to {} m/s (Re {from:.0} to {to:.0})", digits(a), digits(b))
    }
}

/// A speed to a person.
pub fn digits(speed: f64) -> String {
    if speed < 1.0 { format!("{speed:.2}") } else { format!("{speed:.1}") }
}

/// Winds that are not still, slowest first.
pub fn ascending(winds: &[Wind]) -> Vec<&Wind> {
    let mut moving: Vec<&Wind> = winds.iter().filter(|wind| !wind.is_still()).collect();
    moving.sort_by(|a, b| a.reynolds.total_cmp(&b.reynolds));
    moving
}

/// The speeds that were set: winds of one speed each, slowest first. What is given ascends.
pub fn distinct<'a>(ascending: &[&'a Wind]) -> Vec<Vec<&'a Wind>> {
    let mut groups: Vec<Vec<&Wind>> = Vec::new();
    for wind in ascending {
        match groups.last_mut() {
            Some(group) if wind.reynolds <= SAME * group[0].reynolds => group.push(wind),
            _ => groups.push(vec![wind]),
        }
    }
    groups
}

/// The range of these winds (ascending, not empty) in like parts of an octave at most, if `most_octaves` is 1.
pub fn classes(ascending: &[&Wind], most_octaves: f64) -> Vec<Range> {
    let (first, last) = (ascending[0], ascending[ascending.len() - 1]);
    let octaves = (last.reynolds / first.reynolds).ln() / OCTAVE.ln();
    // A little more than a whole number of octaves is that number.
    let count = (octaves / most_octaves - 0.1).ceil().max(1.0);
    let speed_per_reynolds = |reynolds: f64| {
        // By the wind next to it: pressures may differ between runs.
        let near = |wind: &&&Wind| (wind.reynolds / reynolds).ln().abs();
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
            Range { reynolds: [from, to], speed_m_s }
        })
        .collect()
}
