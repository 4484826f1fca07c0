//! Which nodes a body's links join.

use std::collections::{BTreeMap, VecDeque};

use super::parts::BodyLink;

/// Ends of every link.
pub fn ways(links: &[BodyLink]) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
    links.iter().flat_map(|link| match link {
        BodyLink::Solid { from, to, .. } => vec![(*from, *to)],
        BodyLink::Gap { from, to, .. } => vec![(*from, Some(*to))],
        BodyLink::Rod { from, to, cells, .. } => {
            let near = from.iter().map(|&node| (node, Some(cells.start)));
            let along = cells.clone().skip(1).map(|cell| (cell - 1, Some(cell)));
            near.chain(along).chain([(cells.end - 1, *to)]).collect()
        }
    })
}

pub fn neighbours(links: &[BodyLink], node: usize) -> impl Iterator<Item = usize> + '_ {
    ways(links).filter_map(move |(from, to)| match to? {
        to if from == node => Some(to),
        to if to == node => Some(from),
        _ => None,
    })
}

/// Nodes on the shortest way from one node to another, the last one included.
pub fn way(links: &[BodyLink], from: usize, to: usize) -> Vec<usize> {
    let mut before: BTreeMap<usize, usize> = BTreeMap::from([(from, from)]);
    let mut reached = VecDeque::from([from]);
    while let Some(node) = reached.pop_front().filter(|node| *node != to) {
        for next in neighbours(links, node) {
            before.entry(next).or_insert_with(|| {
                reached.push_back(next);
                node
            });
        }
    }
    let mut way = Vec::new();
    let mut node = to;
    while let Some(&previous) = before.get(&node).filter(|_| node != from) {
        way.push(node);
        node = previous;
    }
    way.reverse();
    way
}
