//! Input of a calibration, checked: a head as drawn, and its readings in steady, known winds.
//!
//! ```text
//! c_i (q_i + G0_i a_i) = θ_i (k A_i / d) Nu_i(r)          r = R v ρ d / µ
//! ```
//!
//! | symbol | field | meaning |
//! |---|---|---|
//! | v | `wind_m_s` | known wind, where the gas goes to, in the tunnel's frame |
//! | ρ, µ, k | `gas` | properties of the gas during the reading |
//! | q_i | `power_w` | convective power of surface i beyond that of quiescent gas at the reference, as the quiescent-gas observer reads it off |
//! | θ_i | `overheat_k` | surface over gas, now |
//! | a_i | `above_reference_k` | surface over the gas temperature of the identification |
//!
//! Readings that cannot be meant are refused here by the label of their wind; whether the winds are
//! well spread is for [`spread`](super::spread).
//!
//! Winds are sorted into groups of one speed each, and have the stream that a sphere meets in them.

use dr_core::wind::free_stream::STEM_CHORD;
use dr_core::wind::{FreeStream, HeadForm, NusseltSurface, SurfaceConfig};
use recording::text::{count, tidy};

use super::super::cross_validation::ReynoldsRange;
use super::super::steady_wind::{CalibrateError, SteadyWind, SurfaceReading};
use super::family::seen_orders;
use super::sought::SoughtConvection;

use crate::vector::{across, cross, dot, length};

/// Reynolds numbers that a calibration takes; those of dr-core's amplitudes are wider.
const REYNOLDS: std::ops::RangeInclusive<f64> = 1e-2..=1e5;

/// Volume that three axes span at least, if they are in no plane.
const LEAST_VOLUME: f64 = 0.1;

/// Greatest share of a wind that may blow along a cylinder or across the plane of wires.
const MOST_ACROSS: f64 = 0.1;

/// A head as drawn: its surfaces in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnSurfaces {
    /// Form that they belong to.
    pub form: HeadForm,
    /// Dependence of their loss on the speed.
    pub law: LossLaw,
    /// Diameter, m.
    pub diameter_m: f64,
    /// Surfaces, at least as many as the form has.
    pub surfaces: Vec<DrawnSurface>,
    /// Convection that is sought.
    pub convection: SoughtConvection,
}

/// Dependence of the convective loss on the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LossLaw {
    /// Smoothly and rising.
    Spline,
    /// By King's law.
    King {
        /// Its exponent, if it is known.
        exponent: Option<f64>,
    },
}

/// A surface as drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnSurface {
    /// Name of its element, such as `sector3`.
    pub name: String,
    /// Its geometry.
    pub config: SurfaceConfig,
}

/// The head, checked.
#[derive(Debug, Clone)]
pub struct SurfaceGeometry<'a> {
    /// Surfaces as drawn.
    pub drawn: &'a DrawnSurfaces,
    /// Surfaces, checked by dr-core.
    pub surfaces: Vec<NusseltSurface>,
    /// The orders of amplitudes that at least one surface sees.
    pub orders: Vec<usize>,
}

/// One wind, checked, in the numbers that the model takes.
#[derive(Debug, Clone)]
pub struct CheckedWind {
    /// Label of the wind.
    pub label: String,
    /// Place among the readings that were given.
    pub given: usize,
    /// |v|, m/s.
    pub speed_m_s: f64,
    /// Re; zero in quiescent gas.
    pub reynolds: f64,
    /// Re of 1 m/s, s/m.
    pub reynolds_per_speed: f64,
    /// Mean overheat of the surfaces, K.
    pub overheat_k: f64,
    /// Temperature of the gas, K.
    pub gas_k: f64,
    /// Diameter of the body, m.
    pub diameter_m: f64,
    /// v/|v|; zero in quiescent gas.
    pub towards: [f64; 3],
    /// Readings, one a surface.
    pub rows: Vec<CheckedReading>,
}

/// Reading of a surface, checked.
#[derive(Debug, Clone, Copy)]
pub struct CheckedReading {
    /// Reading as it was taken.
    pub reading: SurfaceReading,
    /// k A / d: conductance at a Nusselt number of one, W/K.
    pub unit_w_k: f64,
}

impl CheckedWind {
    /// Tells whether the gas is quiescent.
    pub fn is_quiescent(&self) -> bool {
        self.reynolds == 0.0
    }
}

impl SurfaceGeometry<'_> {
    /// Form that the surfaces belong to.
    pub fn form(&self) -> HeadForm {
        self.drawn.form
    }

    /// Tells whether the axes of its surfaces span space, so that it determines all of a wind.
    pub fn is_complete(&self) -> bool {
        let axes: Vec<[f64; 3]> = self.surfaces.iter().map(|of| of.axis().map(f64::from)).collect();
        let spans = |a: &[f64; 3], b: &[f64; 3]| axes.iter().any(|c| dot(cross(*a, *b), *c).abs() > LEAST_VOLUME);
        self.form().is_sphere() && axes.iter().any(|a| axes.iter().any(|b| spans(a, b)))
    }
}

/// Checks a head.
///
/// # Errors
/// Names the surface whose geometry is not one.
pub fn ready(head: &DrawnSurfaces) -> Result<SurfaceGeometry<'_>, CalibrateError> {
    let refuse = CalibrateError::Head;
    if !(head.diameter_m.is_finite() && head.diameter_m > 0.0) {
        return Err(refuse(format!("the diameter is {} m; it must be a positive length", head.diameter_m)));
    }
    if head.surfaces.len() < *head.form.surfaces().start() {
        let given = count(head.surfaces.len(), "surface");
        return Err(refuse(format!("{given} given; a head that tells a direction has at least two")));
    }
    let surfaces = head
        .surfaces
        .iter()
        .map(|of| NusseltSurface::new(head.form, &of.config).map_err(|error| refuse(format!("{}: {error}", of.name))));
    let orders = match head.form {
        HeadForm::Single => vec![0],
        _ => seen_orders(head.surfaces.iter().map(|of| &of.config)),
    };
    Ok(SurfaceGeometry { drawn: head, surfaces: surfaces.collect::<Result<_, _>>()?, orders })
}

/// Checks all readings of a head.
///
/// # Errors
/// The label of the first wind that cannot be meant, and why.
pub fn winds(head: &SurfaceGeometry<'_>, steady: &[SteadyWind]) -> Result<Vec<CheckedWind>, CalibrateError> {
    steady.iter().enumerate().map(|(given, steady)| wind(head, given, steady)).collect()
}

fn wind(head: &SurfaceGeometry<'_>, given: usize, steady: &SteadyWind) -> Result<CheckedWind, CalibrateError> {
    if steady.surfaces.len() != head.surfaces.len() {
        let (read, known) = (count(steady.surfaces.len(), "surface"), head.surfaces.len());
        return Err(steady.refuse(format!("{read} read, but the head has {known}")));
    }
    if let Some(bad) = steady.wind_m_s.iter().find(|v| !v.is_finite()) {
        return Err(steady.refuse(format!("a component of the wind is {bad}; it must be a number in m/s")));
    }
    if let Some(problem) = head.drawn.surfaces.iter().zip(&steady.surfaces).find_map(|(of, read)| fault(&of.name, read))
    {
        return Err(steady.refuse(problem));
    }
    let gas = steady.core_gas(head.drawn.convection.film_share)?;
    let diameter_m = head.drawn.diameter_m as f32;
    let wind_m_s = in_plane(head, steady)?;
    let speed_m_s = length(wind_m_s);
    let reynolds_per_speed = f64::from(gas.reynolds_per_speed(diameter_m));
    let reynolds = speed_m_s * reynolds_per_speed;
    if speed_m_s > 0.0 && !REYNOLDS.contains(&reynolds) {
        let (least, most) = (*REYNOLDS.start(), *REYNOLDS.end());
        return Err(steady.refuse(format!(
            "{speed_m_s} m/s make a Reynolds number of {reynolds:.3e}; it must lie within {least:e} and {most:e}, or the wind be zero"
        )));
    }
    let rows = steady.surfaces.iter().zip(&head.surfaces).map(|(reading, of)| {
        let unit_w_k = f64::from(gas.conductance_per_nusselt_w_k(diameter_m, of.area_m2()));
        CheckedReading { reading: *reading, unit_w_k }
    });
    Ok(CheckedWind {
        label: steady.label.clone(),
        given,
        speed_m_s,
        reynolds,
        reynolds_per_speed,
        overheat_k: steady.overheat_k(),
        gas_k: steady.gas.temperature_k,
        diameter_m: head.drawn.diameter_m,
        towards: if speed_m_s > 0.0 { wind_m_s.map(|v| v / speed_m_s) } else { [0.0; 3] },
        rows: rows.collect(),
    })
}

/// Part of a wind that the head sees.
fn in_plane(head: &SurfaceGeometry<'_>, steady: &SteadyWind) -> Result<[f64; 3], CalibrateError> {
    let wind_m_s = steady.wind_m_s;
    let (HeadForm::Cylinder | HeadForm::Wires, Some(first)) = (head.form(), head.surfaces.first()) else {
        return Ok(wind_m_s);
    };
    let normal = first.corner().map(f64::from);
    let along_m_s = dot(wind_m_s, normal);
    if along_m_s.abs() > MOST_ACROSS * length(wind_m_s) {
        return Err(steady.refuse(format!(
            "{along_m_s:.2} m/s of it blow across the plane of the surfaces' normals, along ({:.2}, {:.2}, {:.2}): such a head is \
             calibrated in winds of that plane",
            normal[0], normal[1], normal[2]
        )));
    }
    Ok(across(wind_m_s, normal))
}

/// The first number of a reading that cannot be meant.
fn fault(surface: &str, reading: &SurfaceReading) -> Option<String> {
    let overheat_k = reading.overheat_k;
    if overheat_k.is_finite() && overheat_k <= 0.0 {
        return Some(format!(
            "{surface} is {} K colder than the gas: a surface that gives off heat is warmer; look at the gas temperature and at the network of quiescent gas",
            tidy(-overheat_k)
        ));
    }
    [
        ("power_w", reading.power_w, f64::MIN, "a number"),
        ("above_reference_k", reading.above_reference_k, f64::MIN, "a number"),
        ("overheat_k", reading.overheat_k, f64::MIN_POSITIVE, "a number greater than zero"),
        ("variance_w2", reading.variance_w2, f64::MIN_POSITIVE, "a number greater than zero"),
    ]
    .into_iter()
    .find(|(_, value, least, _)| !(least..=&f64::MAX).contains(&value))
    .map(|(key, value, _, must_be)| format!("{surface}: `{key}` is {value}; it must be {must_be}"))
}

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
    let octaves = libm::log(last.reynolds / first.reynolds) / libm::log(OCTAVE);
    // A little more than a whole number of octaves is that number.
    let count = (octaves / most_octaves - 0.1).ceil().max(1.0);
    let speed_per_reynolds = |reynolds: f64| {
        // By the wind next to it: pressures may differ between runs.
        let near = |wind: &&&CheckedWind| libm::log(wind.reynolds / reynolds).abs();
        let nearest = ascending.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
        nearest.map_or(f64::NAN, |wind| wind.speed_m_s / wind.reynolds)
    };
    let edge = |j: f64| first.reynolds * libm::pow(last.reynolds / first.reynolds, j / count);
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

/// The stream that a head meets in a wind, m/s in the tunnel's frame.
pub fn met_m_s(stream: &FreeStream, wind: &CheckedWind) -> [f64; 3] {
    let v = wind.towards.map(|x| (x * wind.speed_m_s) as f32);
    let rise = stream.rise_speed_m_s(wind.overheat_k as f32, wind.gas_k as f32, wind.diameter_m as f32);
    stream.met(v, rise).map(f64::from)
}

/// Chord between a direction from which a wind comes and the stem.
pub fn chord(towards: [f64; 3], axis: [f64; 3]) -> f64 {
    (2.0 + 2.0 * dot(towards, axis)).max(0.0).sqrt()
}

/// Tells whether a wind comes from where a stem may matter.
pub fn is_behind(wind: &CheckedWind, axis: [f64; 3]) -> bool {
    !wind.is_quiescent() && chord(wind.towards, axis) < f64::from(STEM_CHORD)
}
