//! A head by its file alone: where its surfaces look, the network behind them, and the power that
//! each element needs by wind.

use std::collections::VecDeque;

use crate::engine::axis::Scale;
use crate::engine::chart::{Chart, Figure};
use crate::engine::trace::Trace;

/// Height of the views and of the network, mm.
const VIEW: f64 = 52.0;
const NETWORK: f64 = 60.0;
/// More nodes of one column than this have no names.
const NAMED: usize = 16;
/// Reach of an axis of a view: a normal has the length 1, and a name stands behind its tip.
const REACH: f64 = 1.3;

/// Speed in m/s, and the least and greatest power over directions, mW.
pub type NeededPower = (f64, f64, f64);

/// Sketch of a head.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeadSketch {
    /// Name of the head.
    pub name: String,
    /// Under the title: gas and overheat.
    pub conditions: String,
    /// Surfaces in the wind: name, outward unit vector (none where all directions are alike), node.
    pub surfaces: Vec<(String, Option<[f64; 3]>, usize)>,
    /// Names of the nodes.
    pub nodes: Vec<String>,
    /// Ends of every link; none is the support.
    pub links: Vec<(usize, Option<usize>)>,
    /// Powers of every held element.
    pub powers_mw: Vec<(String, Vec<NeededPower>)>,
    /// Power of the lowest high level, mW.
    pub high_mw: Option<f64>,
}

/// Its picture.
pub fn figure(sketch: &HeadSketch) -> Figure {
    let mut figure = Figure::new(format!("Head {}", sketch.name)).subtitle(sketch.conditions.clone());
    if sketch.surfaces.iter().any(|(_, normal, _)| normal.is_some()) {
        figure = figure.row([
            view(sketch, "Surfaces from above", ["x", "y"], [0, 1]),
            view(sketch, "Surfaces from the side", ["x", "z"], [0, 2]),
        ]);
    }
    figure.stack([network(sketch), powers(sketch)])
}

/// Normals in a plane of two axes.
fn view(sketch: &HeadSketch, caption: &str, [across, up]: [&str; 2], [i, j]: [usize; 2]) -> Chart {
    // One arrow for all surfaces that look alike.
    let mut seen: Vec<((f64, f64), Vec<&str>)> = Vec::new();
    for (name, normal, _) in &sketch.surfaces {
        let Some(normal) = normal else { continue };
        let tip = (normal[i], normal[j]);
        let near = |other: &(f64, f64)| (other.0 - tip.0).abs() < 0.02 && (other.1 - tip.1).abs() < 0.02;
        match seen.iter_mut().find(|(other, _)| near(other)) {
            Some((_, names)) => names.push(name),
            None => seen.push((tip, vec![name])),
        }
    }
    let stems = seen.iter().map(|&((x, y), _)| {
        let line = if x < 0.0 { vec![(x, y), (0.0, 0.0)] } else { vec![(0.0, 0.0), (x, y)] };
        Trace::line("", line).colour(0)
    });
    let tips = Trace::points("", seen.iter().map(|(tip, _)| *tip).collect())
        .names(seen.iter().map(|(_, names)| listed(names)).collect())
        .colour(0);
    Chart::new(caption, "")
        .height(VIEW)
        .x(Scale::Linear, "")
        .x_title(across)
        .y_title(up)
        .x_range(-REACH, REACH)
        .range(-REACH, REACH)
        .traces(stems)
        .trace(tips)
}

/// Nodes in columns by their distance from the gas.
fn network(sketch: &HeadSketch) -> Chart {
    let support = sketch.nodes.len();
    let links: Vec<(usize, usize)> = sketch.links.iter().map(|&(from, to)| (from, to.unwrap_or(support))).collect();
    let mut column: Vec<Option<usize>> = vec![None; support + 1];
    let mut reached: VecDeque<(usize, usize)> = sketch.surfaces.iter().map(|(_, _, node)| (*node, 0)).collect();
    if reached.is_empty() {
        reached.push_back((0, 0));
    }
    while let Some((node, depth)) = reached.pop_front() {
        if column[node].is_some() {
            continue;
        }
        column[node] = Some(depth);
        let next = links.iter().filter_map(|&(a, b)| match node {
            _ if a == node => Some(b),
            _ if b == node => Some(a),
            _ => None,
        });
        reached.extend(next.map(|next| (next, depth + 1)));
    }
    let mut column: Vec<usize> = column.into_iter().map(Option::unwrap_or_default).collect();
    // Whatever leads there, the support is at the end.
    column[support] = column[..support].iter().max().map_or(0, |last| last + 1);
    let of_column = |depth: usize| column.iter().filter(move |other| **other == depth).count();
    let place = |node: usize| {
        let before = column[..node].iter().filter(|other| **other == column[node]).count();
        (column[node] as f64, -(before as f64 + 0.5) / of_column(column[node]) as f64)
    };
    let is_used = |node: &usize| *node < support || links.iter().any(|(_, to)| *to == support);
    let all: Vec<usize> = (0..=support).filter(is_used).collect();
    let name = |node: usize| match sketch.nodes.get(node) {
        Some(_) if of_column(column[node]) > NAMED => String::new(),
        Some(name) => name.clone(),
        None => "support".to_owned(),
    };
    let lines = links.iter().map(|&(a, b)| {
        let (one, other) = (place(a), place(b));
        let line = if one.0 <= other.0 { vec![one, other] } else { vec![other, one] };
        Trace::line("", line).colour(7).width(0.6)
    });
    let last = column.iter().max().copied().unwrap_or(0) as f64;
    let dots = Trace::points("", all.iter().map(|&node| place(node)).collect())
        .names(all.iter().map(|&node| name(node)).collect())
        .colour(0);
    let chart = Chart::new("Network", "")
        .note("from the surfaces that the wind cools, at the left, to the support")
        .height(NETWORK)
        .x(Scale::Linear, "")
        .x_range(-0.2, last + 0.8)
        .range(-1.0, 0.0)
        .bare()
        .traces(lines)
        .trace(dots);
    // Columns have no numbers.
    Chart { x_labels: false, ..chart }
}

/// Needed power by wind, between the directions that take least and most.
fn powers(sketch: &HeadSketch) -> Chart {
    let mut chart = Chart::new("Power that holds the set-point", "mW")
        .note("least and greatest over directions")
        .x(Scale::Log, "m/s")
        .x_title("Wind speed")
        .height(45.0);
    // Elements that need the same, as sectors do, share their curves.
    let mut alike: Vec<(Vec<&str>, &[NeededPower])> = Vec::new();
    for (name, points) in &sketch.powers_mw {
        match alike.iter_mut().find(|(_, other)| same(other, points)) {
            Some((names, _)) => names.push(name),
            None => alike.push((vec![name], points)),
        }
    }
    for (number, (names, points)) in alike.iter().enumerate() {
        let least = points.iter().map(|&(speed, least, _)| (speed, least)).collect();
        let most = points.iter().map(|&(speed, _, most)| (speed, most)).collect();
        chart =
            chart.trace(Trace::line("", least).colour(number)).trace(Trace::line(listed(names), most).colour(number));
    }
    match sketch.high_mw {
        Some(high_mw) => chart.limit(high_mw),
        None => chart,
    }
}

/// Tells whether two elements need the same within what a line is wide.
fn same(one: &[NeededPower], other: &[NeededPower]) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 0.02 * a.abs();
    one.iter().zip(other).all(|(a, b)| near(a.1, b.1) && near(a.2, b.2))
}

/// The first and the last of some names.
fn listed(names: &[&str]) -> String {
    match names {
        [one] => (*one).to_owned(),
        [first, .., last] => format!("{first} … {last}"),
        [] => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_shows_its_surfaces_nodes_and_support_by_name() {
        let sketch = HeadSketch {
            name: "tube".to_owned(),
            conditions: "air".to_owned(),
            surfaces: vec![
                ("film1".to_owned(), Some([1.0, 0.0, 0.0]), 0),
                ("film2".to_owned(), Some([-0.5, 0.866, 0.0]), 1),
            ],
            nodes: vec!["film1".to_owned(), "film2".to_owned(), "core".to_owned()],
            links: vec![(0, Some(2)), (1, Some(2)), (2, None)],
            powers_mw: vec![("film1".to_owned(), vec![(0.1, 5.0, 6.0), (1.0, 9.0, 14.0)])],
            high_mw: Some(40.0),
        };
        let svg = figure(&sketch).svg();
        for word in ["film1", "film2", "core", "support", "Surfaces from above", "Wind speed (m/s)"] {
            assert!(svg.contains(word), "{word}");
        }
        // Without normals there is nothing to see from above.
        let blind = HeadSketch { surfaces: vec![("wire".to_owned(), None, 0)], ..sketch };
        assert!(!figure(&blind).svg().contains("Surfaces from above"));
    }
}
