//! Surfaces of a body that the wind sees, read from its table: laws with possible sizes, surfaces
//! with the normals that a law needs.

use recording::toml_file::FileError;

use super::super::element::direction;
use super::parts::{BodyLink, BodySurface, Convection, way};
use super::reader::{BodyReader, GREATEST, LEAST, LONGEST_M};
use super::table::{BodySurfaceTable, ConvectionTable, Correlation};

use crate::vector::{cross, length, unit};

impl BodyReader<'_> {
    pub fn convection(
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
            let across = |normal: [f64; 3]| length(cross(unit(shape.axis), normal)) > 0.1;
            if let Some(end) = surfaces.iter().find(|of| needs_normals && !of.normal.is_some_and(across)) {
                return refuse(format!("`{}` looks along the axis: sectors look away from it", end.name));
            }
        }
        Ok(Convection { correlation: table.correlation.clone(), surfaces })
    }

    fn surface(
        &self,
        key: &str,
        table: &BodySurfaceTable,
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
                Some(normal) => Some(direction(self.source, &at("normal"), normal)?),
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

    fn correlation(&self, key: &str, of: &Correlation) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.correlation.{name}");
        let positive =
            |name: &str, value: f64, most: f64, unit: &str| self.positive(&at(name), value, most, unit).map(drop);
        let sizes =
            |sizes: &[(&str, f64)]| sizes.iter().try_for_each(|(name, size_m)| positive(name, *size_m, LONGEST_M, "m"));
        let within = |name: &str, value: f64, [least, most]: [f64; 2]| {
            self.source.within(&at(name), value, least..=most, "").map(drop)
        };
        let yaw = |axis: Option<[f64; 3]>, factor: f64| {
            axis.map(|axis| direction(self.source, &at("axis"), axis)).transpose()?;
            within("yaw_factor", factor, [0.0, 1.0])
        };
        let gravity = |m_s2: Option<f64>| m_s2.map_or(Ok(()), |m_s2| positive("gravity_m_s2", m_s2, 1e3, "m/s²"));
        match of {
            Correlation::Sphere { diameter_m } => sizes(&[("diameter_m", *diameter_m)]),
            Correlation::Cylinder(of) => {
                sizes(&[("diameter_m", of.diameter_m), ("length_m", of.length_m)])?;
                yaw(Some(of.axis), of.yaw_factor)?;
                gravity(of.gravity_m_s2)
            }
            Correlation::Plate(of) => {
                sizes(&[("length_m", of.length_m), ("width_m", of.width_m)])?;
                within("faces", f64::from(of.faces), [1.0, 2.0])?;
                gravity(of.gravity_m_s2)
            }
            Correlation::Wire(of) => {
                sizes(&[("diameter_m", of.diameter_m), ("length_m", of.length_m)])?;
                yaw(Some(of.axis), of.yaw_factor)
            }
            Correlation::King(of) => {
                positive("a_w_k", of.a_w_k, GREATEST, "W/K")?;
                positive("b_w_k", of.b_w_k, GREATEST, "W/K")?;
                within("exponent", of.exponent, [0.1, 1.0])?;
                yaw(of.axis, of.yaw_factor)
            }
            Correlation::Table(of) => {
                sizes(&[("length_m", of.length_m)])?;
                positive("area_m2", of.area_m2, LONGEST_M * LONGEST_M, "m²")?;
                positive("nusselt_at_rest", of.nusselt_at_rest, GREATEST, "")?;
                self.ascending(&at("reynolds"), &of.reynolds, LEAST..=1e9, 2)?;
                self.ascending(&at("angles_deg"), &of.angles_deg, 0.0..=180.0, 1)?;
                let (rows, columns) = (of.reynolds.len(), of.angles_deg.len());
                if of.nusselt.len() != rows || of.nusselt.iter().any(|row| row.len() != columns) {
                    let sentence = format!("has not {rows} rows of {columns} numbers, one for every angle");
                    return Err(self.source.refuse(&at("nusselt"), sentence));
                }
                of.nusselt.iter().flatten().try_for_each(|&nusselt| positive("nusselt", nusselt, GREATEST, ""))
            }
            Correlation::Boom(shape) => {
                sizes(&[
                    ("die_side_m", shape.die_side_m),
                    ("die_thickness_m", shape.die_thickness_m),
                    ("card_length_m", shape.card_length_m),
                    ("card_width_m", shape.card_width_m),
                    ("head_diameter_m", shape.head_diameter_m),
                    ("head_length_m", shape.head_length_m),
                    ("shank_diameter_m", shape.shank_diameter_m),
                    ("shank_length_m", shape.shank_length_m),
                ])?;
                within("shade", shape.shade, [0.0, 1.0])?;
                // A die in the corner has twice that less, which must leave some cooling.
                within("front_to_rear", shape.front_to_rear, [0.0, 0.49])
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
