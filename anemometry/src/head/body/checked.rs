//! A body with every name resolved and every number found possible. Refusals name the key and line
//! of the head file.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

use super::correlation::Correlation;
use super::names;
use super::table::{BodyGas, BodyTable, ConvectionTable, LinkTable, SurfaceTable, Tolerances};
use crate::gas::IdealGas;
use crate::gas::ZERO_CELSIUS_K;
use crate::head::element::HeadElement;
use crate::vector::length;
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource};

/// The fixed temperature that links may lead to.
const SUPPORT: &str = "support";
/// More nodes take too long.
const MOST_NODES: usize = 1000;
const MOST_LINKS: usize = 10_000;
/// Cells of a rod.
const CELLS: std::ops::RangeInclusive<f64> = 1.0..=100.0;
/// W/K, J/K, W/(m²·K), W: beyond, somebody mistook a unit.
const GREATEST: f64 = 1e6;
/// Least of the same, and of lengths in m.
const LEAST: f64 = 1e-12;
/// Of a heat capacity, 1/K: solids have some 1e-3, and none becomes negative.
const SLOPE_PER_K: std::ops::RangeInclusive<f64> = -1e-3..=5e-3;
/// A length, m.
const LONGEST_M: f64 = 10.0;
/// A standard deviation, %.
const MOST_PERCENT: f64 = 30.0;

/// A checked body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// All nodes; those of rods stand behind the others.
    pub nodes: Vec<BodyNode>,
    /// In the order of the file.
    pub links: Vec<BodyLink>,
    /// Node of every element of the head, in its order.
    pub elements: Vec<usize>,
    /// What the wind sees.
    pub convection: Vec<Convection>,
    /// The gas that the head is meant for.
    pub gas: Option<BodyGas>,
    /// How much a specimen differs.
    pub tolerances: Option<Tolerances>,
}

/// A lump of one temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyNode {
    /// Its name.
    pub name: String,
    /// Heat capacity at 0 °C, J/K.
    pub capacity_j_k: f64,
    /// How much of that it gains with each kelvin, 1/K.
    pub capacity_slope_per_k: f64,
}

/// An element as the body knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyElement {
    /// As the head file has it.
    pub name: String,
    /// Outward unit vector of what the wind sees of it; none inside, nor where all winds see the
    /// same.
    pub normal: Option<[f64; 3]>,
}

/// A way between nodes; `to` is none where it leads to the support.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyLink {
    /// Of a conductance that stays.
    Solid {
        /// A node.
        from: usize,
        /// Another, or the support.
        to: Option<usize>,
        /// W/K
        conductance_w_k: f64,
    },
    /// Filled with the gas, by whose conductivity at the temperature between its ends it conducts.
    Gap {
        /// A node.
        from: usize,
        /// Another.
        to: usize,
        /// Area over width, m.
        area_over_width_m: f64,
    },
    /// A rod, whose near end several nodes may share.
    Rod {
        /// Nodes at its near end.
        from: Vec<usize>,
        /// Node at its far end, or the support.
        to: Option<usize>,
        /// Nodes of its cells, from the near end on.
        cells: Range<usize>,
        /// From end to end, W/K.
        conductance_w_k: f64,
    },
}

/// A law, and what loses heat by it.
#[derive(Clone, Debug, PartialEq)]
pub struct Convection {
    /// The law.
    pub correlation: Correlation,
    /// The surfaces, in the order of the file.
    pub surfaces: Vec<BodySurface>,
}

/// A surface in the wind.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySurface {
    /// Its name.
    pub name: String,
    /// Its node.
    pub node: usize,
    /// The element that heats it, by its number.
    pub element: Option<usize>,
    /// Outward unit vector, where the law needs one.
    pub normal: Option<[f64; 3]>,
    /// In place of that of the law's shape, m².
    pub area_m2: Option<f64>,
    /// Its area over what the file has: 1, but in a specimen.
    pub area_factor: f64,
    /// 0 radiates nothing.
    pub emissivity: f64,
    /// Nodes on the way from it to its element, which count as its own: their heat is stored in it.
    pub carries: Vec<usize>,
}

impl Body {
    /// The body of a table.
    ///
    /// # Errors
    /// The key and line of what is not known, stands twice or cannot be.
    pub fn from_table(source: &TomlSource, table: &BodyTable, elements: &[HeadElement]) -> Result<Self, FileError> {
        let mut body = BodyReader { source, heads: elements, nodes: Vec::new(), numbers: BTreeMap::new() };
        body.add_nodes(table)?;
        let links = body.links(&table.links)?;
        let nodes_of = body.elements(&table.elements)?;
        let mut convection = Vec::new();
        for (i, group) in table.convection.iter().enumerate() {
            convection.push(body.convection(&format!("body.convection[{i}]"), group, &nodes_of, &links)?);
        }
        let checked = Self {
            nodes: body.nodes,
            links,
            elements: nodes_of,
            convection,
            gas: table.gas,
            tolerances: table.tolerances,
        };
        checked.check(source)?;
        Ok(checked)
    }

    /// All surfaces, in the order in which a simulation counts them.
    pub fn surfaces(&self) -> impl Iterator<Item = &BodySurface> {
        self.convection.iter().flat_map(|group| &group.surfaces)
    }

    fn check(&self, source: &TomlSource) -> Result<(), FileError> {
        let mut names: Vec<&str> = Vec::new();
        let mut heated: Vec<usize> = Vec::new();
        for surface in self.surfaces() {
            if names.contains(&surface.name.as_str()) {
                let sentence = format!("names the surface `{}` twice", surface.name);
                return Err(source.refuse("body.convection", sentence));
            }
            if let Some(element) = surface.element.filter(|element| heated.contains(element)) {
                let sentence = format!("gives element {} two surfaces: one of them is heated by it", element + 1);
                return Err(source.refuse("body.convection", sentence));
            }
            names.push(&surface.name);
            heated.extend(surface.element);
        }
        if let Some(node) = self.insulated() {
            let sentence = format!(
                "leave `{}` without any way to the gas or the `support`: its temperature would rise for ever",
                self.nodes[node].name
            );
            return Err(source.refuse("body.links", sentence));
        }
        if let Some(gas) = self.gas {
            let known = IdealGas::new(gas.species, gas.pressure_pa, gas.temperature_c + ZERO_CELSIUS_K);
            known.map_err(|error| source.refuse("body.gas", format!("cannot be: {error}")))?;
        }
        if let Some(of) = self.tolerances {
            for (key, percent) in [
                ("capacity_percent", of.capacity_percent),
                ("conductance_percent", of.conductance_percent),
                ("area_percent", of.area_percent),
                ("normal_deg", of.normal_deg),
            ] {
                source.within(&format!("body.tolerances.{key}"), percent, 0.0..=MOST_PERCENT, "")?;
            }
        }
        Ok(())
    }

    /// Ends of every link: nodes, or none for the support.
    pub fn ways(&self) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
        ways(&self.links)
    }

    /// A node that no heat can leave.
    fn insulated(&self) -> Option<usize> {
        let mut open: Vec<bool> = vec![false; self.nodes.len()];
        let mut reached: VecDeque<usize> = self.surfaces().map(|surface| surface.node).collect();
        reached.extend(self.ways().filter(|(_, to)| to.is_none()).map(|(from, _)| from));
        while let Some(node) = reached.pop_front() {
            if !std::mem::replace(&mut open[node], true) {
                reached.extend(neighbours(&self.links, node));
            }
        }
        open.iter().position(|open| !open)
    }
}

/// Ends of every link.
fn ways(links: &[BodyLink]) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
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

fn neighbours(links: &[BodyLink], node: usize) -> impl Iterator<Item = usize> + '_ {
    ways(links).filter_map(move |(from, to)| match to? {
        to if from == node => Some(to),
        to if to == node => Some(from),
        _ => None,
    })
}

/// Nodes on the shortest way from one node to another, the last one included.
fn way(links: &[BodyLink], from: usize, to: usize) -> Vec<usize> {
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

/// A body on the way from its table.
struct BodyReader<'a> {
    source: &'a TomlSource,
    heads: &'a [HeadElement],
    nodes: Vec<BodyNode>,
    numbers: BTreeMap<String, usize>,
}

impl BodyReader<'_> {
    fn all(&self, key: &str, pattern: &str) -> Result<Vec<String>, FileError> {
        names::all(pattern).map_err(|sentence| self.source.refuse(key, sentence))
    }

    fn positive(&self, key: &str, value: f64, most: f64, unit: &str) -> Result<f64, FileError> {
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
    fn add_nodes(&mut self, table: &BodyTable) -> Result<(), FileError> {
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

    fn node(&self, key: &str, name: &str) -> Result<usize, FileError> {
        self.numbers.get(name).copied().ok_or_else(|| {
            let hint = suggest(name, self.numbers.keys().map(String::as_str));
            self.source.refuse(key, format!("names `{name}`, which is no node; {hint}"))
        })
    }

    /// Nodes by name; none stands for the support.
    fn ends(&self, key: &str, pattern: &str) -> Result<Vec<Option<usize>>, FileError> {
        let end = |name: String| if name == SUPPORT { Ok(None) } else { self.node(key, &name).map(Some) };
        self.all(key, pattern)?.into_iter().map(end).collect()
    }

    fn links(&self, tables: &[LinkTable]) -> Result<Vec<BodyLink>, FileError> {
        let mut links = Vec::new();
        for (i, table) in tables.iter().enumerate() {
            self.link(&format!("body.links[{i}]"), table, &mut links)?;
        }
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

    fn pairs(&self, key: &str, table: &LinkTable) -> Result<Vec<(Option<usize>, Option<usize>)>, FileError> {
        match (&table.from, &table.to, &table.among) {
            (Some(from), Some(to), None) => {
                let (from, to) = (self.ends(&format!("{key}.from"), from)?, self.ends(&format!("{key}.to"), to)?);
                match (from.len(), to.len()) {
                    (_, 1) => Ok(from.into_iter().map(|from| (from, to[0])).collect()),
                    (1, _) => Ok(to.into_iter().map(|to| (from[0], to)).collect()),
                    (some, others) if some == others => Ok(from.into_iter().zip(to).collect()),
                    (some, others) => Err(self.source.refuse(
                        key,
                        format!("joins {some} nodes with {others}: as many as there are, or each with one"),
                    )),
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
    fn elements(&self, given: &BTreeMap<String, String>) -> Result<Vec<usize>, FileError> {
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
                let sentence = format!(
                    "has no node for the element `{}`: name one so, or write `{} = \"…\"` under [body.elements]",
                    element.name, element.name
                );
                self.source.refuse("body", sentence)
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

    fn element(&self, key: &str, name: &str) -> Result<usize, FileError> {
        self.heads.iter().position(|element| element.name == name).ok_or_else(|| {
            let hint = suggest(name, self.heads.iter().map(|element| element.name.as_str()));
            self.source.refuse(key, format!("names `{name}`, which is no element of the head; {hint}"))
        })
    }

    fn convection(
        &self,
        key: &str,
        table: &ConvectionTable,
        nodes_of: &[usize],
        links: &[BodyLink],
    ) -> Result<Convection, FileError> {
        self.correlation(key, &table.correlation)?;
        let mut surfaces = Vec::new();
        for (i, surface) in table.surfaces.iter().enumerate() {
            self.surface(&format!("{key}.surfaces[{i}]"), surface, nodes_of, links, &mut surfaces)?;
        }
        let refuse = |sentence: String| Err(self.source.refuse(&format!("{key}.surfaces"), sentence));
        let count = surfaces.len();
        if count == 0 {
            return refuse("are none: something has to lose heat by it".to_owned());
        }
        let needs_normals = match &table.correlation {
            Correlation::Sphere { .. } | Correlation::Cylinder(_) => count > 1,
            Correlation::Table(grid) => grid.angles_deg.len() > 1,
            Correlation::Boom(_) if count < 17 => {
                return refuse(format!("are {count}: twelve dice, three cards, the head and cells of the shank"));
            }
            _ => false,
        };
        if let Some(blind) = surfaces.iter().find(|surface| needs_normals && surface.normal.is_none()) {
            return refuse(format!("need a `normal` each, but `{}` has none, nor has its element", blind.name));
        }
        for (i, one) in surfaces.iter().enumerate() {
            let same = surfaces[..i].iter().find(|other| {
                needs_normals && !matches!(table.correlation, Correlation::Table(_)) && other.normal == one.normal
            });
            if let Some(same) = same {
                return refuse(format!("`{}` and `{}` look into one direction", same.name, one.name));
            }
        }
        if let Correlation::Cylinder(shape) = &table.correlation {
            let across = |normal: [f64; 3]| length(crate::vector::cross(crate::vector::unit(shape.axis), normal)) > 0.1;
            if let Some(end) = surfaces.iter().find(|of| needs_normals && !of.normal.is_some_and(across)) {
                return refuse(format!("`{}` looks along the axis: sectors look away from it", end.name));
            }
        }
        Ok(Convection { correlation: table.correlation.clone(), surfaces })
    }

    fn surface(
        &self,
        key: &str,
        table: &SurfaceTable,
        nodes_of: &[usize],
        links: &[BodyLink],
        surfaces: &mut Vec<BodySurface>,
    ) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        let names = self.all(&at("name"), &table.name)?;
        let listed = |name: &str, pattern: &Option<String>| -> Result<Option<Vec<String>>, FileError> {
            let Some(pattern) = pattern else { return Ok(None) };
            let all = self.all(&at(name), pattern)?;
            if all.len() == names.len() {
                return Ok(Some(all));
            }
            let sentence = format!("names {} for {} surfaces: one each", all.len(), names.len());
            Err(self.source.refuse(&at(name), sentence))
        };
        let (nodes, elements) = (listed("node", &table.node)?, listed("element", &table.element)?);
        self.source.within(&at("emissivity"), table.emissivity, 0.0..=1.0, "")?;
        if let Some(area_m2) = table.area_m2 {
            self.positive(&at("area_m2"), area_m2, LONGEST_M * LONGEST_M, "m²")?;
        }
        for (i, name) in names.iter().enumerate() {
            let node = match &nodes {
                Some(nodes) => self.node(&at("node"), &nodes[i])?,
                None => self.node(&at("name"), name)?,
            };
            let element = match &elements {
                Some(elements) => Some(self.element(&at("element"), &elements[i])?),
                None => self.heads.iter().position(|element| element.name == *name),
            };
            let normal = match table.normal {
                Some(normal) => Some(self.direction(&at("normal"), normal)?),
                None => element.and_then(|element| self.heads[element].normal),
            };
            let carries = element.map_or(Vec::new(), |element| way(links, node, nodes_of[element]));
            surfaces.push(BodySurface {
                name: name.clone(),
                node,
                element,
                normal,
                area_m2: table.area_m2,
                area_factor: 1.0,
                emissivity: table.emissivity,
                carries,
            });
        }
        Ok(())
    }

    fn direction(&self, key: &str, vector: [f64; 3]) -> Result<[f64; 3], FileError> {
        let size = length(vector);
        if size.is_finite() && size > 1e-9 {
            return Ok(vector.map(|v| v / size));
        }
        Err(self.source.refuse(key, "is no direction: three finite numbers that are not all 0 belong here"))
    }

    fn correlation(&self, key: &str, of: &Correlation) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.correlation.{name}");
        let size = |name: &str, value: f64| self.positive(&at(name), value, LONGEST_M, "m").map(|_| ());
        let share = |name: &str, value: f64| self.source.within(&at(name), value, 0.0..=1.0, "").map(|_| ());
        let gravity = |value: Option<f64>| match value {
            Some(value) => self.positive(&at("gravity_m_s2"), value, 1e3, "m/s²").map(|_| ()),
            None => Ok(()),
        };
        match of {
            Correlation::Sphere { diameter_m } => size("diameter_m", *diameter_m),
            Correlation::Cylinder(of) => {
                size("diameter_m", of.diameter_m)?;
                size("length_m", of.length_m)?;
                self.direction(&at("axis"), of.axis)?;
                share("yaw_factor", of.yaw_factor)?;
                gravity(of.gravity_m_s2)
            }
            Correlation::Plate(of) => {
                size("length_m", of.length_m)?;
                size("width_m", of.width_m)?;
                self.source.within(&at("faces"), f64::from(of.faces), 1.0..=2.0, "")?;
                gravity(of.gravity_m_s2)
            }
            Correlation::Wire(of) => {
                size("diameter_m", of.diameter_m)?;
                size("length_m", of.length_m)?;
                self.direction(&at("axis"), of.axis)?;
                share("yaw_factor", of.yaw_factor)
            }
            Correlation::King(of) => {
                self.positive(&at("a_w_k"), of.a_w_k, GREATEST, "W/K")?;
                self.positive(&at("b_w_k"), of.b_w_k, GREATEST, "W/K")?;
                self.source.within(&at("exponent"), of.exponent, 0.1..=1.0, "")?;
                of.axis.map(|axis| self.direction(&at("axis"), axis)).transpose()?;
                share("yaw_factor", of.yaw_factor)
            }
            Correlation::Table(of) => {
                size("length_m", of.length_m)?;
                self.positive(&at("area_m2"), of.area_m2, LONGEST_M * LONGEST_M, "m²")?;
                self.positive(&at("nusselt_at_rest"), of.nusselt_at_rest, GREATEST, "")?;
                self.ascending(&at("reynolds"), &of.reynolds, LEAST..=1e9, 2)?;
                self.ascending(&at("angles_deg"), &of.angles_deg, 0.0..=180.0, 1)?;
                let (rows, columns) = (of.reynolds.len(), of.angles_deg.len());
                if of.nusselt.len() != rows || of.nusselt.iter().any(|row| row.len() != columns) {
                    let sentence = format!("has not {rows} rows of {columns} numbers, one for every angle");
                    return Err(self.source.refuse(&at("nusselt"), sentence));
                }
                let mut all = of.nusselt.iter().flatten();
                all.try_for_each(|&nusselt| self.positive(&at("nusselt"), nusselt, GREATEST, "").map(|_| ()))
            }
            Correlation::Boom(shape) => {
                for (name, value) in [
                    ("die_side_m", shape.die_side_m),
                    ("die_thickness_m", shape.die_thickness_m),
                    ("card_length_m", shape.card_length_m),
                    ("card_width_m", shape.card_width_m),
                    ("head_diameter_m", shape.head_diameter_m),
                    ("head_length_m", shape.head_length_m),
                    ("shank_diameter_m", shape.shank_diameter_m),
                    ("shank_length_m", shape.shank_length_m),
                ] {
                    size(name, value)?;
                }
                share("shade", shape.shade)?;
                // A die in the corner has twice that less, which must leave some cooling.
                self.source.within(&at("front_to_rear"), shape.front_to_rear, 0.0..=0.49, "").map(|_| ())
            }
        }
    }

    fn ascending(
        &self,
        key: &str,
        values: &[f64],
        range: std::ops::RangeInclusive<f64>,
        least: usize,
    ) -> Result<(), FileError> {
        if values.len() < least {
            return Err(self.source.refuse(key, format!("are {}: at least {least} belong here", values.len())));
        }
        for &value in values {
            self.source.within(key, value, range.clone(), "")?;
        }
        if values.windows(2).all(|pair| pair[0] < pair[1]) {
            return Ok(());
        }
        Err(self.source.refuse(key, "do not ascend"))
    }
}
