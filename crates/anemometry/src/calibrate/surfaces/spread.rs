//! Check that a set of winds can determine a calibration, before anything is fitted; and if not,
//! which winds are missing.
//!
//! | what the model needs | rule |
//! |---|---|
//! | more readings than unknowns | winds × surfaces ≥ 4 coefficients an amplitude, gains, G0 and turns |
//! | amplitudes at every speed: splines in ln Re do not reach over a gap | the slowest and the fastest wind differ by a factor of 2 at least, neighbouring speeds by 2.2 at most |
//! | amplitudes a_0 … a_5 apart: polynomials of degree 5 in the cosine, which are free beyond the last angle | in every octave of speed *some* surface is within 45° of the front, some within 45° of the rear, and no 60° between are empty |
//! | gain and G0 of every surface apart, and from the amplitudes | *every* surface is within 60° of the front and within 60° of the rear, at low speeds and at high ones (ranges of 2½ octaves at most) |
//! | the tilt of a head that has one axis only: out of a plane of winds it changes their angles by its square alone | winds leave every plane by 20° at least |
//!
//! Angles matter to a sphere and to a cylinder. Of wires the winds' angles to their normals have to
//! differ by 30° at least; orders of amplitudes beyond the number of angles are left out. A single
//! element has no angles.
//!
//! Because all surfaces share the amplitudes, an angle that one surface has seen need not be seen
//! by the others. Angles are those of the head as drawn: they may be wrong by the mounting, for
//! which the bounds have room.
//!
//! Worth of each rule, with 0.1 % of noise (tests `refused`): over a gap from 2.1 to 8 m/s winds of
//! 3 to 5 m/s are estimated 1.1 % and 1.1° wrong, with winds of 4 m/s between 0.2 % and 0.1°. Winds
//! along the edges of sectors alone make 0.4° of direction, with winds onto their axes and backs
//! 0.05°. A sector that is never faced has a gain 1.4 times as uncertain. Two hemispheres in winds
//! of one plane have no best fit that could be found, whereas four sectors lose nothing by it; so a
//! head of several axes may stay on a turntable.

use dr_core::wind::HeadForm;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use recording::text::count;

use super::super::cross_validation::{ReynoldsRange, digits};

use super::family::LEAST_COUNT;
use super::mounting::Mounting;
use super::readings::{CheckedWind, SurfaceGeometry, ascending, classes, distinct};

const LEAST_RANGE: f64 = 2.0;
/// A ratio of neighbouring speeds: an octave, and what a tunnel misses it by.
const WIDEST_STEP: f64 = 2.2;
/// From front or rear, degrees, that some surface reaches in every octave.
const SOME_SURFACE: f64 = 45.0;
/// Between the angles of an octave, degrees.
const WIDEST_ANGLE: f64 = 60.0;
/// From front or rear, degrees, that every surface reaches.
const EVERY_SURFACE: f64 = 60.0;
const LEAST_OUT_OF_PLANE: f64 = 20.0;
/// Octaves in which every surface is to be seen from both sides.
const HALF_OCTAVES: f64 = 2.5;
/// Stands in a sentence for the range of speeds.
const SPEEDS: &str = "{speeds}";

/// Missing winds, a sentence each; nothing if the winds will do.
pub fn lacking(head: &SurfaceGeometry<'_>, winds: &[CheckedWind]) -> Vec<String> {
    let moving = ascending(winds);
    let mut sentences = few(head, winds);
    if moving.is_empty() {
        sentences.push("all readings are of quiescent gas: winds are missing".into());
        return sentences;
    }
    sentences.extend(speeds(&moving));
    match head.form() {
        HeadForm::Single => return sentences,
        HeadForm::Wires => {
            sentences.extend(wires(head, &moving));
            return sentences;
        }
        HeadForm::Sphere | HeadForm::Cube | HeadForm::Cylinder => {}
    }
    if has_one_axis(head) {
        sentences.extend(plane(&moving));
    }
    let of_some = classes(&moving, 1.0).into_iter().map(|class| (class, some_surface(head, &moving, &class)));
    sentences.extend(joined(of_some.collect()));
    let of_every =
        classes(&moving, HALF_OCTAVES).into_iter().map(|class| (class, every_surface(head, &moving, &class)));
    sentences.extend(joined(of_every.collect()));
    sentences
}

/// Winds that are missing from classes of speed, a sentence for every run of neighbouring classes
/// that miss the same.
fn joined(classes: Vec<(ReynoldsRange, Vec<String>)>) -> Vec<String> {
    let mut runs: Vec<(ReynoldsRange, usize, String)> = Vec::new();
    for (at, (class, missing)) in classes.into_iter().enumerate() {
        for sentence in missing {
            match runs.iter_mut().find(|(_, last, known)| *last + 1 == at && *known == sentence) {
                Some((range, last, _)) => {
                    *last = at;
                    range.reynolds[1] = class.reynolds[1];
                    range.speed_m_s[1] = class.speed_m_s[1];
                }
                None => runs.push((class, at, sentence)),
            }
        }
    }
    runs.into_iter().map(|(range, _, sentence)| sentence.replace(SPEEDS, &range.to_string())).collect()
}

fn few(head: &SurfaceGeometry<'_>, winds: &[CheckedWind]) -> Vec<String> {
    let n = head.surfaces.len();
    let unknowns =
        LEAST_COUNT * head.orders.len() + 2 * n - 1 + Mounting::drawn(head.form(), &head.surfaces).turns.ncols();
    if n * winds.len() >= unknowns {
        return Vec::new();
    }
    let (given, surfaces) = (count(winds.len(), "wind"), count(n, "surface"));
    let (readings, more) = (count(n * winds.len(), "reading"), count(unknowns.div_ceil(n) - winds.len(), "wind"));
    let few = format!("{given} of {surfaces}: {readings}, fewer than the {unknowns} unknowns");
    vec![format!("{few}; it takes at least {more} more")]
}

/// Winds in a plane are no loss to a head whose axes span more.
fn has_one_axis(head: &SurfaceGeometry<'_>) -> bool {
    head.form().is_sphere() && Mounting::drawn(head.form(), &head.surfaces).turns.ncols() < 3
}

fn speeds(moving: &[&CheckedWind]) -> Vec<String> {
    let groups = distinct(moving);
    let (first, last) = (moving[0], moving[moving.len() - 1]);
    if last.reynolds < LEAST_RANGE * first.reynolds * (1.0 - 1e-6) {
        let range = speeds_of(first, last, "to");
        return vec![format!("all winds have about one speed, {range}: winds of at least twice the least are missing")];
    }
    let edges = groups.iter().filter_map(|group| Some((group.first()?, group.last()?)));
    edges
        .clone()
        .zip(edges.skip(1))
        .filter(|((_, below), (above, _))| above.reynolds > WIDEST_STEP * below.reynolds)
        .map(|((_, below), (above, _))| {
            let count = (libm::log(above.reynolds / below.reynolds) / libm::log(WIDEST_STEP)).ceil();
            let ratio = libm::pow(above.speed_m_s / below.speed_m_s, 1.0 / count);
            let between: Vec<String> = (1..count as i32).map(|j| digits(below.speed_m_s * ratio.powi(j))).collect();
            let (range, between) = (speeds_of(below, above, "and"), between.join(", "));
            format!("no wind between {range}: winds at about {between} m/s are missing")
        })
        .collect()
}

/// Speeds of two winds, in words.
fn speeds_of(least: &CheckedWind, most: &CheckedWind, to: &str) -> String {
    let (least_m_s, most_m_s) = (digits(least.speed_m_s), digits(most.speed_m_s));
    format!("{least_m_s} {to} {most_m_s} m/s (Re {:.0} to {:.0})", least.reynolds, most.reynolds)
}

fn plane(moving: &[&CheckedWind]) -> Option<String> {
    let directions = || moving.iter().map(|wind| Vector3::from(wind.towards));
    let moments: Matrix3<f64> = directions().map(|w| w * w.transpose()).sum();
    let eigen = SymmetricEigen::new(moments);
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    let out = libm::asin(directions().map(|w| w.dot(&normal).abs()).fold(0.0, f64::max).min(1.0)).to_degrees();
    (out < LEAST_OUT_OF_PLANE).then(|| {
        format!(
            "all winds lie in one plane, within {out:.0}°: winds along its normal {}, or at least {LEAST_OUT_OF_PLANE:.0}° out of it, \
             are missing",
            vector(normal)
        )
    })
}

/// Angles between where the winds of a class come from and the axis of a surface, degrees.
fn angles(head: &SurfaceGeometry<'_>, moving: &[&CheckedWind], class: &ReynoldsRange, surface: usize) -> Vec<f64> {
    let axis = Vector3::from(head.surfaces[surface].axis().map(f64::from));
    let of_class = moving.iter().filter(|wind| class.holds(wind.reynolds));
    of_class.map(|wind| Vector3::from(wind.towards).angle(&-axis).to_degrees()).collect()
}

/// Within so many degrees two angles are one.
const SAME_ANGLE: f64 = 5.0;
/// Sine of the angle between normals that are across each other, or along: half of what dr-core has
/// for twice the angle.
const LEAST_SINE: f64 = 0.05;
/// So far, in degrees, a wind may lie beyond where its mirror image begins: a mounting is off by so
/// much.
const BEYOND: f64 = 5.0;
/// Between the angles of the winds to wires, degrees.
const LEAST_ANGLES: f64 = 30.0;

/// Angles of all winds to the surfaces, ascending, degrees; both sides of a wire are alike.
pub fn all_angles(head: &SurfaceGeometry<'_>, moving: &[&CheckedWind]) -> Vec<f64> {
    let of_surfaces = head.surfaces.iter().flat_map(|surface| {
        let axis = Vector3::from(surface.axis().map(f64::from));
        moving.iter().map(move |wind| Vector3::from(wind.towards).angle(&-axis).to_degrees())
    });
    let fold = |angle: f64| if head.form() == HeadForm::Wires { angle.min(180.0 - angle) } else { angle };
    let mut angles: Vec<f64> = of_surfaces.map(fold).collect();
    angles.sort_by(f64::total_cmp);
    angles
}

/// Number of angles of the winds to the surfaces, which bounds the orders that they determine; no
/// bound for a sphere.
pub fn angles_apart(head: &SurfaceGeometry<'_>, moving: &[&CheckedWind]) -> usize {
    if head.form().is_sphere() {
        return usize::MAX;
    }
    let (mut apart, mut last) = (0, f64::NEG_INFINITY);
    for angle in all_angles(head, moving) {
        if angle > last + SAME_ANGLE {
            (apart, last) = (apart + 1, angle);
        }
    }
    apart
}

fn wires(head: &SurfaceGeometry<'_>, moving: &[&CheckedWind]) -> Option<String> {
    let angles = all_angles(head, moving);
    let (least, most) = (angles.first()?, angles.last()?);
    (most - least < LEAST_ANGLES).then(|| {
        format!(
            "the winds' angles to the wires' normals are all between {least:.0}° and {most:.0}°, which tells no direction: winds \
             at angles at least {LEAST_ANGLES:.0}° apart are missing"
        )
    })
}

/// Labels of winds that come to wires from where they see the same as from in front: from behind,
/// and with wires across each other from outside the quadrant that their normals enclose.
pub fn mirrored(head: &SurfaceGeometry<'_>, moving: &[&CheckedWind]) -> Vec<String> {
    if head.form() != HeadForm::Wires {
        return Vec::new();
    }
    let axes: Vec<Vector3<f64>> = head.surfaces.iter().map(|of| Vector3::from(of.axis().map(f64::from))).collect();
    let facing: Vector3<f64> = axes.iter().sum();
    let corner = Vector3::from(head.surfaces[0].corner().map(f64::from));
    let sides = [axes[0], corner.cross(&axes[0])];
    // At twice its angle a normal is along the first one, or against it.
    let is_across = |axis: &Vector3<f64>| sides.iter().any(|side| axis.dot(side).abs() < LEAST_SINE);
    let fronts: Vec<Vector3<f64>> = match axes.iter().all(is_across) {
        true => sides.iter().map(|side| side * side.dot(&facing).signum()).collect(),
        false => vec![facing],
    };
    let beyond = -libm::sin(BEYOND.to_radians());
    let is_in_front = |from: Vector3<f64>| fronts.iter().all(|front| from.dot(front) >= beyond * front.norm());
    moving.iter().filter(|wind| !is_in_front(-Vector3::from(wind.towards))).map(|wind| wind.label.clone()).collect()
}

fn some_surface(head: &SurfaceGeometry<'_>, moving: &[&CheckedWind], class: &ReynoldsRange) -> Vec<String> {
    let mut all: Vec<f64> = (0..head.surfaces.len()).flat_map(|surface| angles(head, moving, class, surface)).collect();
    let (Some(least), Some(most)) = (all.iter().copied().reduce(f64::min), all.iter().copied().reduce(f64::max)) else {
        // An octave without winds is a gap of speeds, and reported there.
        return Vec::new();
    };
    let mut sentences = Vec::new();
    let such_as = vector(Vector3::from(head.surfaces[0].axis().map(f64::from)));
    for (side, way, nearest) in [("front", "come from", least), ("rear", "go to", 180.0 - most)] {
        // Two surfaces back to back: the one's front is the other's rear.
        let said = !sentences.is_empty() && has_one_axis(head);
        if nearest > SOME_SURFACE && !said {
            sentences.push(format!(
                "at {SPEEDS} no surface was nearer to the wind's {side} than {nearest:.0}°: winds that {way} the axis of a surface, such as {such_as}, \
                 are missing"
            ));
        }
    }
    all.sort_by(f64::total_cmp);
    for pair in all.windows(2).filter(|pair| pair[1] - pair[0] > WIDEST_ANGLE) {
        let (from, to, middle) = (pair[0], pair[1], 0.5 * (pair[0] + pair[1]));
        let empty = format!("at {SPEEDS} no surface was between {from:.0}° and {to:.0}° from the wind's front");
        sentences.push(format!("{empty}: winds at {middle:.0}° to the axis of a surface are missing"));
    }
    sentences
}

fn every_surface(head: &SurfaceGeometry<'_>, moving: &[&CheckedWind], class: &ReynoldsRange) -> Vec<String> {
    let mut sentences = Vec::new();
    for (surface, drawn) in head.drawn.surfaces.iter().enumerate() {
        let own = angles(head, moving, class, surface);
        if own.is_empty() {
            continue;
        }
        let axis = Vector3::from(head.surfaces[surface].axis().map(f64::from));
        for (side, way, reached) in [
            ("front", "come from", own.iter().any(|angle| *angle <= EVERY_SURFACE)),
            ("rear", "go to", own.iter().any(|angle| *angle >= 180.0 - EVERY_SURFACE)),
        ] {
            if !reached {
                let (name, axis) = (&drawn.name, vector(axis));
                let never = format!("{name} was never within {EVERY_SURFACE:.0}° of the wind's {side} at {SPEEDS}");
                sentences.push(format!("{never}: winds that {way} about {axis} are missing"));
            }
        }
    }
    sentences
}

fn vector(v: Vector3<f64>) -> String {
    format!("({:.2}, {:.2}, {:.2})", v.x, v.y, v.z)
}
