//! A head as drawn: what its surfaces belong to, and which part of it each of them is.

use std::f64::consts::PI;

use dr_core::ConfigError;
use dr_core::wind::nusselt::ORDERS;
use dr_core::wind::{HeadForm, MOST_SURFACES, NusseltSurface, SurfaceConfig, sphere};
use recording::text::suggest;

use super::steady_wind::CalibratorError;
use super::surfaces::readings::{DrawnSurface, DrawnSurfaces, LossLaw};
use super::surfaces::sought::{Gravity, SoughtConvection};

use crate::head::body::Correlation;
use crate::head::file::Head;
use crate::vector::{across, cross, dot, length, unit};

/// Sine below which two directions are one.
const LEAST_SINE: f64 = 0.1;
/// Sizes of a head that neither its file nor anybody states, m.
const USUAL_M: f64 = 0.01;
/// Points of a sphere over which the means of its parts are taken.
const POINTS: usize = 200_000;

/// Statements about a head beside its file.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnOptions {
    /// Names of its surfaces; none for all elements with a normal.
    pub elements: Vec<String>,
    /// Form that its surfaces belong to; by default what their normals and its body say.
    pub form: Option<HeadForm>,
    /// Diameter of sphere, cylinder or wire, m.
    pub diameter_m: Option<f64>,
    /// Length of cylinder or wires, m.
    pub length_m: Option<f64>,
    /// Side of a die, if they are those of a card, m.
    pub die_m: f64,
    /// Share of the way from the gas to the surfaces at which its properties are taken; by default
    /// half of it, or what winds of several temperatures say.
    pub film_share: Option<f64>,
    /// Gravity in the tunnel.
    pub gravity: Gravity,
    /// Outward along the stem.
    pub stem: [f64; 3],
}

impl Default for DrawnOptions {
    fn default() -> Self {
        Self {
            elements: Vec::new(),
            form: None,
            diameter_m: None,
            length_m: None,
            die_m: 1.5e-3,
            film_share: None,
            gravity: Gravity { m_s2: 9.81, up: [0.0, 0.0, 1.0] },
            stem: [0.0, 0.0, -1.0],
        }
    }
}

/// Form, diameter and length by the first law of a body's convection that is about a shape, m.
fn stated(head: &Head) -> Option<(HeadForm, f64, Option<f64>)> {
    let mut laws = head.body.iter().flat_map(|body| &body.convection).map(|of| &of.correlation);
    laws.find_map(|law| match law {
        Correlation::Sphere { diameter_m } => Some((HeadForm::Sphere, *diameter_m, None)),
        Correlation::Cylinder(shape) => Some((HeadForm::Cylinder, shape.diameter_m, Some(shape.length_m))),
        Correlation::Wire(shape) => Some((HeadForm::Wires, shape.diameter_m, Some(shape.length_m))),
        Correlation::Plate(_) | Correlation::King(_) | Correlation::Table(_) | Correlation::Boom(_) => None,
    })
}

/// Places of elements in a head, in the order of their names.
///
/// # Errors
/// If a name is of none, or stands twice.
pub fn named(head: &Head, elements: &[String]) -> Result<Vec<usize>, CalibratorError> {
    let names = head.names();
    let mut places = Vec::new();
    for name in elements {
        let refuse = |sentence: String| CalibratorError::Options(format!("--elements{sentence}"));
        let place = names.iter().position(|known| known == name).ok_or_else(|| {
            let hint = suggest(name, names.iter().copied());
            refuse(format!(": `{name}` is no element of head `{}`; {hint}", head.name))
        })?;
        if places.contains(&place) {
            return Err(refuse(format!(" names `{name}` twice")));
        }
        if head.elements[place].surface_normal().is_none() {
            let head = &head.name;
            return Err(refuse(format!(
                ": `{name}` of head `{head}` is no surface: it has no `normal`, or only senses"
            )));
        }
        places.push(place);
    }
    Ok(places)
}

/// Places in the head and geometry of its surfaces: the driven elements with an outward normal, or
/// the named ones of them.
///
/// # Errors
/// If they are none, too many, or not those of the form.
pub fn drawn(
    head: &Head,
    options: &DrawnOptions,
    law: LossLaw,
) -> Result<(Vec<usize>, DrawnSurfaces), CalibratorError> {
    let places = match &options.elements[..] {
        [] => (0..head.elements.len()).collect(),
        names => named(head, names)?,
    };
    let outward: Vec<(usize, [f64; 3])> =
        places.into_iter().filter_map(|at| Some((at, head.elements[at].surface_normal()?))).collect();
    let normals: Vec<[f64; 3]> = outward.iter().map(|(_, normal)| *normal).collect();
    let refuse = |sentence: String| CalibratorError::Head(format!("head `{}` {sentence}", head.name));
    if normals.is_empty() || normals.len() > MOST_SURFACES {
        return Err(refuse(format!(
            "has {} elements with a `normal`: those that the wind cools have one, outward or for a wire towards the wind, and a \
             calibration is of 1 to {MOST_SURFACES} of them",
            normals.len()
        )));
    }
    let body = stated(head);
    let form = match options.form {
        Some(form) => form,
        None => form_of(&normals, body.map(|(form, ..)| form)).ok_or_else(|| {
            refuse(format!(
                "has {} surfaces whose normals are those of no head: --form says whether they are of a sphere, round a cylinder or wires \
                 in a plane",
                normals.len()
            ))
        })?,
    };
    let twice = |n: usize| normals[..n].contains(&normals[n]);
    if form != HeadForm::Wires && (1..normals.len()).any(twice) {
        let sentence = "elements with a `normal`, and some look the same way, as parts of one body do not: --elements names those of one \
                        instrument";
        return Err(refuse(format!("has {} {sentence}", normals.len())));
    }
    let diameter_m = options.diameter_m.or(body.map(|(_, diameter_m, _)| diameter_m)).unwrap_or(USUAL_M);
    let length_m = options.length_m.or(body.and_then(|(.., length_m)| length_m)).unwrap_or(USUAL_M);
    let configs = surfaces_of(form, &normals, diameter_m, length_m);
    let configs = configs.map_err(|error| refuse(format!("has surfaces that cannot be: {error}")))?;
    if form == HeadForm::Single && normals.len() > 1 {
        let given = format!("has {} elements with a `normal`", normals.len());
        return Err(refuse(format!("{given}, and a single element is one: --elements NAME says which")));
    }
    let places: Vec<usize> = outward.into_iter().map(|(place, _)| place).collect();
    let name = |place: &usize| head.elements[*place].name.clone();
    let surfaces = places.iter().map(name).zip(configs).map(|(name, config)| DrawnSurface { name, config }).collect();
    Ok((places, DrawnSurfaces { form, law, diameter_m, surfaces, convection: SoughtConvection::default() }))
}

/// Surfaces with these unit normals, one at least.
///
/// # Errors
/// If dr-core refuses one of them.
pub fn surfaces_of(
    form: HeadForm,
    normals: &[[f64; 3]],
    diameter_m: f64,
    length_m: f64,
) -> Result<Vec<SurfaceConfig>, ConfigError> {
    Ok(match form {
        HeadForm::Sphere | HeadForm::Cube => parts_of_sphere(form, normals, diameter_m)?,
        HeadForm::Cylinder => parts_of_cylinder(normals, diameter_m, length_m),
        HeadForm::Wires => wires(normals, diameter_m, length_m),
        HeadForm::Single => vec![single(normals[0], diameter_m, length_m)],
    })
}

/// Form that normals belong to, if it is clear.
fn form_of(normals: &[[f64; 3]], stated: Option<HeadForm>) -> Option<HeadForm> {
    match (normals, stated, plane_of(normals)) {
        ([_], ..) => Some(HeadForm::Single),
        (_, Some(HeadForm::Wires), Some(_)) => Some(HeadForm::Wires),
        ([a, b], stated, _) if length(cross(*a, *b)) < LEAST_SINE && dot(*a, *b) < 0.0 => {
            Some(stated.filter(|form| *form == HeadForm::Cylinder).unwrap_or(HeadForm::Sphere))
        }
        ([_, _], None, _) => Some(HeadForm::Wires),
        (_, Some(HeadForm::Cylinder) | None, Some(_)) => Some(HeadForm::Cylinder),
        (_, _, None) if is_cube(normals) => Some(HeadForm::Cube),
        (_, _, None) if normals.len() > 3 => Some(HeadForm::Sphere),
        _ => None,
    }
}

/// The normal of the plane in which all of them lie, if they span one.
fn plane_of(normals: &[[f64; 3]]) -> Option<[f64; 3]> {
    let first = *normals.first()?;
    let plane = normals.iter().map(|other| cross(first, *other)).find(|plane| length(*plane) > LEAST_SINE)?;
    let plane = unit(plane);
    normals.iter().all(|normal| dot(*normal, plane).abs() < LEAST_SINE).then_some(plane)
}

/// Tells whether normals are those of the faces of a cube.
fn is_cube(normals: &[[f64; 3]]) -> bool {
    let along = |a: &[f64; 3], b: &[f64; 3]| dot(*a, *b).abs();
    let square = |cosine: f64| !(LEAST_SINE..1.0 - LEAST_SINE).contains(&cosine);
    normals.len() == 6
        && normals.iter().all(|a| normals.iter().all(|b| square(along(a, b))))
        && normals.iter().all(|a| normals.iter().filter(|b| along(a, b) > 0.5).count() == 2)
}

/// Any direction across this one.
fn any_across(normal: [f64; 3]) -> [f64; 3] {
    let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    std::array::from_fn(|k| if k == least { 1.0 } else { 0.0 })
}

fn narrow(v: [f64; 3]) -> [f32; 3] {
    v.map(|x| x as f32)
}

/// Four sectors of a tetrahedron, two hemispheres, or of others what is nearest to each normal.
fn parts_of_sphere(form: HeadForm, normals: &[[f64; 3]], diameter_m: f64) -> Result<Vec<SurfaceConfig>, ConfigError> {
    // A corner of a sector is opposite to the axis of another.
    let corner = |i: usize| match normals.len() {
        4 => normals[(i + 1) % 4].map(|x| -x),
        2 => any_across(normals[i]),
        _ => {
            let others = normals.iter().filter(|other| dot(**other, normals[i]).abs() < 1.0 - LEAST_SINE);
            let nearest = others.max_by(|a, b| dot(**a, normals[i]).total_cmp(&dot(**b, normals[i])));
            nearest.map_or_else(|| any_across(normals[i]), |nearest| nearest.map(|x| -x))
        }
    };
    let corners: Vec<[f64; 3]> = (0..normals.len()).map(corner).collect();
    let known = match normals.len() {
        4 => sphere::tetrahedral_sectors(diameter_m as f32).to_vec(),
        2 => sphere::hemispheres(diameter_m as f32).to_vec(),
        _ => cells(form, normals, &corners, diameter_m)?,
    };
    let placed = normals.iter().zip(corners).zip(known);
    let placed =
        placed.map(|((normal, corner), of)| SurfaceConfig { axis: narrow(*normal), corner: narrow(corner), ..of });
    Ok(placed.collect())
}

/// The parts of a sphere that are nearest to each normal: areas, means of P_n about their own axes,
/// and their threefold or fourfold parts, by dr-core's own functions. What has another symmetry is
/// left out.
fn cells(
    form: HeadForm,
    normals: &[[f64; 3]],
    corners: &[[f64; 3]],
    diameter_m: f64,
) -> Result<Vec<SurfaceConfig>, ConfigError> {
    let placed = normals.iter().zip(corners).map(|(normal, corner)| SurfaceConfig {
        axis: narrow(*normal),
        corner: narrow(*corner),
        area_m2: 1.0,
        means: [0.0; ORDERS - 1],
        threefold: [0.0; 3],
    });
    // A point whose mean is one, and one whose other part is.
    let points = placed.clone().map(|of| NusseltSurface::new(form, &SurfaceConfig { means: [1.0; ORDERS - 1], ..of }));
    let points = points.collect::<Result<Vec<_>, _>>()?;
    let lobes = placed.clone().map(|of| NusseltSurface::new(form, &SurfaceConfig { threefold: [1.0; 3], ..of }));
    let lobes = lobes.collect::<Result<Vec<_>, _>>()?;
    let mut counts = vec![0.0; normals.len()];
    let mut means = vec![[0.0; ORDERS - 1]; normals.len()];
    let mut folds = vec![[0.0; 3]; normals.len()];
    let golden = PI * (3.0 - 5_f64.sqrt());
    for k in 0..POINTS {
        // Points of equal area on a spiral.
        let z = 1.0 - (2 * k + 1) as f64 / POINTS as f64;
        let (sine, cosine) = libm::sincos(golden * k as f64);
        let across = (1.0 - z * z).sqrt();
        let point = [across * cosine, across * sine, z];
        let cosines = normals.iter().map(|normal| dot(*normal, point)).enumerate();
        let Some((nearest, _)) = cosines.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        counts[nearest] += 1.0;
        let of_means = points[nearest].per_amplitude(narrow(point));
        means[nearest].iter_mut().zip(&of_means[1..]).for_each(|(sum, of)| *sum += f64::from(of.nusselt));
        let of_folds = lobes[nearest].per_amplitude(narrow(point));
        folds[nearest].iter_mut().zip(&of_folds[3..]).for_each(|(sum, of)| *sum += f64::from(of.nusselt));
    }
    // The addition theorem's 2 (n − m)!/(n + m)! for m = 3 or 4, n = 3, 4, 5.
    let m = if form == HeadForm::Cube { 4 } else { 3 };
    let ratio = |n: u32| 2.0 / f64::from((n.saturating_sub(m) + 1..=n + m).product::<u32>());
    let sphere_m2 = PI * diameter_m * diameter_m;
    let cell = |(i, of): (usize, SurfaceConfig)| SurfaceConfig {
        area_m2: (sphere_m2 * counts[i] / POINTS as f64) as f32,
        means: means[i].map(|sum| (sum / counts[i]) as f32),
        threefold: std::array::from_fn(|k| (ratio(k as u32 + 3) * folds[i][k] / counts[i]) as f32),
        ..of
    };
    Ok(placed.enumerate().map(cell).collect())
}

/// The parts of a circumference that are nearest to each normal.
fn parts_of_cylinder(normals: &[[f64; 3]], diameter_m: f64, length_m: f64) -> Vec<SurfaceConfig> {
    let along = plane_of(normals).unwrap_or_else(|| unit(across(any_across(normals[0]), normals[0])));
    let other = cross(along, normals[0]);
    let angle = |normal: [f64; 3]| libm::atan2(dot(normal, other), dot(normal, normals[0])).rem_euclid(2.0 * PI);
    let half_gap = |from: f64, way: f64| {
        let gaps = normals.iter().map(|other| (way * (angle(*other) - from)).rem_euclid(2.0 * PI));
        0.5 * gaps.filter(|gap| *gap > 1e-9).fold(2.0 * PI, f64::min)
    };
    let part = |normal: &[f64; 3]| {
        let (ahead, behind) = (half_gap(angle(*normal), 1.0), half_gap(angle(*normal), -1.0));
        // Means of cos mφ over what is symmetric about the normal.
        let mean =
            |m: usize| (libm::sin(m as f64 * ahead) + libm::sin(m as f64 * behind)) / (m as f64 * (ahead + behind));
        SurfaceConfig {
            axis: narrow(*normal),
            corner: narrow(along),
            area_m2: (0.5 * (ahead + behind) * diameter_m * length_m) as f32,
            means: std::array::from_fn(|m| mean(m + 1) as f32),
            threefold: [0.0; 3],
        }
    };
    normals.iter().map(part).collect()
}

fn wires(normals: &[[f64; 3]], diameter_m: f64, length_m: f64) -> Vec<SurfaceConfig> {
    let plane = plane_of(normals).unwrap_or_else(|| any_across(normals[0]));
    let wire = |normal: &[f64; 3]| SurfaceConfig {
        corner: narrow(plane),
        means: [1.0; ORDERS - 1],
        ..single(*normal, diameter_m, length_m)
    };
    normals.iter().map(wire).collect()
}

fn single(normal: [f64; 3], diameter_m: f64, length_m: f64) -> SurfaceConfig {
    SurfaceConfig {
        axis: narrow(normal),
        corner: narrow(any_across(normal)),
        area_m2: (PI * diameter_m * length_m) as f32,
        means: [0.0; ORDERS - 1],
        threefold: [0.0; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_a_tetrahedron_are_its_sectors() {
        let known = sphere::tetrahedral_sectors(0.01);
        let normals = known.map(|of| unit(of.axis.map(f64::from)));
        let corners = known.map(|of| of.corner.map(f64::from));
        for (cell, known) in cells(HeadForm::Sphere, &normals, &corners, 0.01).unwrap().iter().zip(known) {
            assert!((cell.area_m2 / known.area_m2 - 1.0).abs() < 1e-3);
            let pairs = cell.means.iter().zip(known.means).chain(cell.threefold.iter().zip(known.threefold));
            assert!(pairs.clone().all(|(found, known)| (found - known).abs() < 1e-3), "{cell:?} {known:?}");
        }
    }

    #[test]
    fn normals_say_what_they_belong_to() {
        let x = [1.0, 0.0, 0.0];
        let ring = |count: usize| -> Vec<[f64; 3]> {
            let angle = |i: usize| 2.0 * PI * i as f64 / count as f64;
            (0..count).map(|i| [libm::cos(angle(i)), libm::sin(angle(i)), 0.0]).collect()
        };
        let cube: Vec<[f64; 3]> = (0..6)
            .map(|i| std::array::from_fn(|k| if k == i / 2 { 1.0 - 2.0 * (i % 2) as f64 } else { 0.0 }))
            .collect();
        let tetrahedron = sphere::tetrahedral_sectors(0.01).map(|of| unit(of.axis.map(f64::from)));
        assert_eq!(form_of(&[x], Some(HeadForm::Wires)), Some(HeadForm::Single));
        assert_eq!(form_of(&[x, [-1.0, 0.0, 0.0]], None), Some(HeadForm::Sphere));
        assert_eq!(form_of(&[x, [0.0, 1.0, 0.0]], None), Some(HeadForm::Wires));
        assert_eq!(form_of(&ring(3), None), Some(HeadForm::Cylinder));
        assert_eq!(form_of(&ring(5), Some(HeadForm::Wires)), Some(HeadForm::Wires));
        assert_eq!(form_of(&tetrahedron, Some(HeadForm::Sphere)), Some(HeadForm::Sphere));
        assert_eq!(form_of(&cube, Some(HeadForm::Sphere)), Some(HeadForm::Cube));
        assert_eq!(form_of(&tetrahedron[..3], None), None);
    }
}
