//! Nodes, links and elements of a body, read from its table with every name resolved.
//!
//! Names may stand for several: `card[1-3]-die[1-4]` are twelve, the last number running fastest,
//! and `core1,core2` are two.

use std::collections::BTreeMap;

use anyhow::bail;
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource};

use super::super::element::HeadElement;
use super::parts::{BodyLink, BodyNode};
use super::table::{BodyTable, LinkTable};

/// The fixed temperature that links may lead to.
const SUPPORT: &str = "support";
/// More nodes take too long.
const MOST_NODES: usize = 1000;
const MOST_LINKS: usize = 10_000;
/// Cells of a rod.
const CELLS: std::ops::RangeInclusive<f64> = 1.0..=100.0;
/// W/K, J/K, W/(m²·K), W: beyond, somebody mistook a unit.
pub(super) const GREATEST: f64 = 1e6;
/// Least of the same, and of lengths in m.
pub(super) const LEAST: f64 = 1e-12;
/// Slope of a heat capacity, 1/K: solids have some 1e-3, and none becomes negative.
const SLOPE_PER_K: std::ops::RangeInclusive<f64> = -1e-3..=5e-3;
/// A length, m.
pub(super) const LONGEST_M: f64 = 10.0;

/// A node, or none for the support.
type End = Option<usize>;

/// A body on the way from its table.
pub struct BodyReader<'a> {
    pub source: &'a TomlSource,
    pub heads: &'a [HeadElement],
    pub nodes: Vec<BodyNode>,
    numbers: BTreeMap<String, usize>,
}

impl<'a> BodyReader<'a> {
    pub fn new(source: &'a TomlSource, heads: &'a [HeadElement]) -> Self {
        Self { source, heads, nodes: Vec::new(), numbers: BTreeMap::new() }
    }

    pub fn all(&self, key: &str, pattern: &str) -> Result<Vec<String>, FileError> {
        expanded(pattern).map_err(|error| self.source.refuse(key, error.to_string()))
    }

    pub fn positive(&self, key: &str, value: f64, most: f64, unit: &str) -> Result<f64, FileError> {
        self.source.positive(key, value, unit)?;
        self.source.within(key, value, LEAST..=most, unit)
    }

    fn add(&mut self, key: &str, node: BodyNode) -> Result<(), FileError> {
        let refuse = |sentence: String| Err(self.source.refuse(key, sentence));
        if node.name == SUPPORT {
            return refuse(format!("is `{SUPPORT}`, which has a fixed temperature and is always there"));
        }
        if self.numbers.contains_key(&node.name) {
            return refuse(format!("names `{}`, which is a node already", node.name));
        }
        if self.nodes.len() == MOST_NODES {
            return refuse(format!("is one too many: a body has at most {MOST_NODES} nodes"));
        }
        self.numbers.insert(node.name.clone(), self.nodes.len());
        self.nodes.push(node);
        Ok(())
    }

    /// The nodes, and behind them the cells of all rods.
    pub fn add_nodes(&mut self, table: &BodyTable) -> Result<(), FileError> {
        for (i, node) in table.nodes.iter().enumerate() {
            let key = format!("body.nodes[{i}]");
            let capacity_j_k = self.positive(&format!("{key}.capacity_j_k"), node.capacity_j_k, GREATEST, "J/K")?;
            let slope_per_k = node.capacity_slope_per_k;
            self.source.within(&format!("{key}.capacity_slope_per_k"), slope_per_k, SLOPE_PER_K, "1/K")?;
            for name in self.all(&format!("{key}.name"), &node.name)? {
                let node = BodyNode { name, capacity_j_k, capacity_slope_per_k: slope_per_k };
                self.add(&format!("{key}.name"), node)?;
            }
        }
        for (i, link) in table.links.iter().enumerate() {
            let Some(rod) = &link.rod else { continue };
            let key = format!("body.links[{i}]");
            let (Some(capacity_j_k), Some(cells)) = (link.capacity_j_k, link.cells) else {
                return Err(self.source.refuse(&key, "is a rod without `capacity_j_k` and `cells`"));
            };
            self.positive(&format!("{key}.capacity_j_k"), capacity_j_k, GREATEST, "J/K")?;
            self.source.within(&format!("{key}.cells"), cells as f64, CELLS, "")?;
            for cell in 1..=cells {
                let capacity_j_k = capacity_j_k / cells as f64;
                let node = BodyNode { name: format!("{rod}{cell}"), capacity_j_k, capacity_slope_per_k: 0.0 };
                self.add(&format!("{key}.rod"), node)?;
            }
        }
        Ok(())
    }

    pub fn node(&self, key: &str, name: &str) -> Result<usize, FileError> {
        self.numbers.get(name).copied().ok_or_else(|| {
            let hint = suggest(name, self.numbers.keys().map(String::as_str));
            self.source.refuse(key, format!("names `{name}`, which is no node; {hint}"))
        })
    }

    /// Nodes by name; none stands for the support.
    fn ends(&self, key: &str, pattern: &str) -> Result<Vec<End>, FileError> {
        let end = |name: String| if name == SUPPORT { Ok(None) } else { self.node(key, &name).map(Some) };
        self.all(key, pattern)?.into_iter().map(end).collect()
    }

    pub fn links(&self, tables: &[LinkTable]) -> Result<Vec<BodyLink>, FileError> {
        let mut links = Vec::new();
        let mut each = tables.iter().enumerate();
        each.try_for_each(|(i, table)| self.link(&format!("body.links[{i}]"), table, &mut links))?;
        Ok(links)
    }

    fn link(&self, key: &str, table: &LinkTable, links: &mut Vec<BodyLink>) -> Result<(), FileError> {
        let refuse = |sentence: &str| Err(self.source.refuse(key, sentence));
        if let Some(rod) = &table.rod {
            let (Some(from), Some(to), Some(conductance_w_k)) = (&table.from, &table.to, table.conductance_w_k) else {
                return refuse("is a rod without `from`, `to` and `conductance_w_k`");
            };
            self.positive(&format!("{key}.conductance_w_k"), conductance_w_k, GREATEST, "W/K")?;
            let from: Option<Vec<usize>> = self.ends(&format!("{key}.from"), from)?.into_iter().collect();
            let to = self.ends(&format!("{key}.to"), to)?;
            let (Some(from), &[to]) = (from, &to[..]) else {
                return refuse("is a rod: it leads from nodes to one node or the `support`");
            };
            let first = self.node(&format!("{key}.rod"), &format!("{rod}1"))?;
            let cells = first..first + table.cells.unwrap_or_default();
            links.push(BodyLink::Rod { from, to, cells, conductance_w_k });
            return Ok(());
        }
        if table.capacity_j_k.is_some() || table.cells.is_some() {
            return refuse("has `capacity_j_k` or `cells` without a `rod`, which names the cells");
        }
        for (from, to) in self.pairs(key, table)? {
            let (Some(from), false) = (from, from == to) else {
                return refuse("leads from a node to itself, or from the `support`: write that end as `to`");
            };
            if links.len() == MOST_LINKS {
                return refuse("is one too many: a body has at most 10 000 links");
            }
            links.push(self.of_kind(key, table, from, to)?);
        }
        Ok(())
    }

    fn pairs(&self, key: &str, table: &LinkTable) -> Result<Vec<(End, End)>, FileError> {
        match (&table.from, &table.to, &table.among) {
            (Some(from), Some(to), None) => {
                let (from, to) = (self.ends(&format!("{key}.from"), from)?, self.ends(&format!("{key}.to"), to)?);
                match (from.len(), to.len()) {
                    (_, 1) => Ok(from.into_iter().map(|from| (from, to[0])).collect()),
                    (1, _) => Ok(to.into_iter().map(|to| (from[0], to)).collect()),
                    (some, others) if some == others => Ok(from.into_iter().zip(to).collect()),
                    (some, others) => {
                        let sentence =
                            format!("joins {some} nodes with {others}: as many as there are, or each with one");
                        Err(self.source.refuse(key, sentence))
                    }
                }
            }
            (None, None, Some(among)) => {
                let all = self.ends(&format!("{key}.among"), among)?;
                Ok((0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| (all[i], all[j])).collect())
            }
            _ => Err(self.source.refuse(key, "needs `from` and `to`, or `among`")),
        }
    }

    fn of_kind(&self, key: &str, table: &LinkTable, from: usize, to: Option<usize>) -> Result<BodyLink, FileError> {
        let at = |name: &str| format!("{key}.{name}");
        match (table.conductance_w_k, table.area_m2, table.contact_w_m2_k, table.gap_m) {
            (Some(conductance_w_k), None, None, None) => {
                self.positive(&at("conductance_w_k"), conductance_w_k, GREATEST, "W/K")?;
                Ok(BodyLink::Solid { from, to, conductance_w_k })
            }
            (None, Some(area_m2), Some(contact_w_m2_k), None) => {
                self.positive(&at("area_m2"), area_m2, LONGEST_M * LONGEST_M, "m²")?;
                self.positive(&at("contact_w_m2_k"), contact_w_m2_k, 1e9, "W/(m²·K)")?;
                Ok(BodyLink::Solid { from, to, conductance_w_k: area_m2 * contact_w_m2_k })
            }
            (None, Some(area_m2), None, Some(gap_m)) => {
                self.positive(&at("area_m2"), area_m2, LONGEST_M * LONGEST_M, "m²")?;
                self.positive(&at("gap_m"), gap_m, LONGEST_M, "m")?;
                let to = to.ok_or_else(|| self.source.refuse(key, "is a gap to the `support`: gaps join two nodes"))?;
                Ok(BodyLink::Gap { from, to, area_over_width_m: area_m2 / gap_m })
            }
            _ => Err(self.source.refuse(
                key,
                "needs one of `conductance_w_k`, `area_m2` with `contact_w_m2_k`, and `area_m2` with `gap_m`",
            )),
        }
    }

    /// Node of every element of the head.
    pub fn elements(&self, given: &BTreeMap<String, String>) -> Result<Vec<usize>, FileError> {
        let mut nodes: BTreeMap<String, usize> = BTreeMap::new();
        for (pattern, node_pattern) in given {
            let key = format!("body.elements.{pattern}");
            let (elements, to) = (self.all("body.elements", pattern)?, self.all("body.elements", node_pattern)?);
            if elements.len() != to.len() {
                let sentence = format!("puts {} elements on {} nodes: one belongs on each", elements.len(), to.len());
                return Err(self.source.refuse("body.elements", sentence));
            }
            for (element, node) in elements.into_iter().zip(to) {
                self.element(&key, &element)?;
                let node = self.node("body.elements", &node)?;
                if nodes.insert(element.clone(), node).is_some() {
                    return Err(self.source.refuse("body.elements", format!("puts `{element}` on two nodes")));
                }
            }
        }
        let mut all = Vec::new();
        for element in self.heads {
            let node = nodes.get(&element.name).or_else(|| self.numbers.get(&element.name)).copied();
            let node = node.ok_or_else(|| {
                let hint = format!("name one so, or write `{} = \"…\"` under [body.elements]", element.name);
                self.source.refuse("body", format!("has no node for the element `{}`: {hint}", element.name))
            })?;
            if let Some(place) = all.iter().position(|other| *other == node) {
                let (one, other) = (&element.name, &self.heads[place].name);
                let sentence = format!("puts `{other}` and `{one}` on one node: each needs its own");
                return Err(self.source.refuse("body.elements", sentence));
            }
            all.push(node);
        }
        Ok(all)
    }

    pub fn element(&self, key: &str, name: &str) -> Result<usize, FileError> {
        self.heads.iter().position(|element| element.name == name).ok_or_else(|| {
            let hint = suggest(name, self.heads.iter().map(|element| element.name.as_str()));
            self.source.refuse(key, format!("names `{name}`, which is no element of the head; {hint}"))
        })
    }
}

/// More names than a body can use.
const MOST_NAMES: usize = 4096;

/// All that a pattern stands for, in order.
///
/// # Errors
/// If a part of it is no word or no range, or stands for too many.
fn expanded(pattern: &str) -> anyhow::Result<Vec<String>> {
    let mut names = Vec::new();
    pattern.split(',').try_for_each(|part| expand(part.trim(), String::new(), &mut names))?;
    Ok(names)
}

fn expand(rest: &str, before: String, names: &mut Vec<String>) -> anyhow::Result<()> {
    let Some((plain, behind)) = rest.split_once('[') else {
        let name = before + rest;
        if name.is_empty() || name.contains(|c: char| c.is_whitespace() || "[]:\"".contains(c)) {
            bail!("has the name {name:?}: a word without brackets, `:` and quotation marks belongs here");
        }
        if names.len() == MOST_NAMES {
            bail!("stands for more than {MOST_NAMES} names");
        }
        names.push(name);
        return Ok(());
    };
    let range = behind.split_once(']').and_then(|(range, behind)| {
        let (first, last) = range.split_once('-')?;
        Some((first.parse::<u16>().ok()?, last.parse::<u16>().ok()?, behind))
    });
    match range {
        Some((first, last, behind)) if first <= last => {
            (first..=last).try_for_each(|number| expand(behind, format!("{before}{plain}{number}"), names))
        }
        _ => bail!("has `[{behind}`, which is no range: write `[1-4]` for the numbers 1 to 4"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_run_like_the_digits_of_a_number() {
        assert_eq!(expanded("a[1-2]-b[3-4]").unwrap(), ["a1-b3", "a1-b4", "a2-b3", "a2-b4"]);
        assert_eq!(expanded("core1, core2,x[9-10]y").unwrap(), ["core1", "core2", "x9y", "x10y"]);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for (pattern, expected) in [
            ("a[4-1]", "has `[4-1]`, which is no range"),
            ("a[1", "has `[1`, which is no range"),
            ("a[x-y]", "is no range"),
            ("a]", "has the name \"a]\""),
            ("a,,b", "has the name \"\""),
            ("", "has the name \"\""),
            ("a[0-9][0-9][0-9][0-9]", "stands for more than 4096 names"),
        ] {
            let sentence = expanded(pattern).unwrap_err().to_string();
            assert!(sentence.contains(expected), "{pattern}: {sentence}");
        }
    }
}
