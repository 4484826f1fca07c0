//! Components of a wind that the axes of a head determine.
//!
//! Parts see the wind by the cosines to their axes and by its speed. Axes that span space determine
//! all of it. Axes in a plane leave open on which side of the plane the wind comes from, axes on
//! one line (two hemispheres) from where around that line. What lies across them is then known by
//! its size alone: speed² less what is known squared. So there is one unknown more than the axes
//! span, three at the most, and the vector that the head determines is the component of the wind
//! within that span.
//!
//! Cylinders and wires see the wind in the plane of their axes alone, which is two unknowns, and a
//! single element its speed, which is one.

use super::form::HeadForm;
use super::normal::Matrix;
use super::surface::NusseltSurface;
use crate::arithmetic::{cross, dot, length, plus, scaled};

/// Sine under which an axis counts as lying in the span of the others.
const LEAST_SINE: f32 = 0.1;

/// An orthonormal basis whose first vectors span the axes.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct HeadFrame {
    basis: [[f32; 3]; 3],
    determined: usize,
    unknowns: usize,
}

impl HeadFrame {
    /// The frame of surfaces that make a head of this form.
    pub fn of(form: HeadForm, surfaces: &[NusseltSurface]) -> Self {
        let axes = surfaces.iter().map(NusseltSurface::axis);
        let frame = match (form, surfaces) {
            (HeadForm::Cylinder | HeadForm::Wires, [first, ..]) => {
                let plane = [first.axis(), cross(first.corner(), first.axis()), first.corner()];
                let in_plane = Self::new(axes);
                Self { basis: plane, determined: in_plane.determined.min(2), ..in_plane }
            }
            (HeadForm::Single, _) => Self { determined: 0, ..Self::new(axes) },
            _ => Self::new(axes),
        };
        Self { unknowns: (frame.determined + 1).min(form.dimensions()), ..frame }
    }

    fn new(axes: impl Iterator<Item = [f32; 3]>) -> Self {
        let mut basis = [[0.0; 3]; 3];
        let mut determined = 0;
        for axis in axes {
            let rest = basis.iter().fold(axis, |rest, &b| plus(rest, -dot(rest, b), b));
            let size = length(rest);
            if determined < 3 && size > LEAST_SINE {
                basis[determined] = scaled(rest, 1.0 / size);
                determined += 1;
            }
        }
        match determined {
            3 => basis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            1 => {
                // Any direction across the only one; that of the smallest component is well across.
                let line = basis[0];
                let smallest = (0..3).fold(0, |s, k| if line[k] * line[k] < line[s] * line[s] { k } else { s });
                let mut other = [0.0; 3];
                other[smallest] = 1.0;
                let across = cross(line, other);
                basis[1] = scaled(across, 1.0 / length(across));
                basis[2] = cross(line, basis[1]);
            }
            _ => basis[2] = cross(basis[0], basis[1]),
        }
        Self { basis, determined, unknowns: (determined + 1).min(3) }
    }

    /// Number of components that are determined with their sign.
    pub const fn determined(&self) -> usize {
        self.determined
    }

    /// Number of unknowns: these, and the size of what is across.
    pub const fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Tells whether all unknowns are determined with their sign.
    pub const fn is_complete(&self) -> bool {
        self.determined == self.unknowns
    }

    /// Components of a vector in this frame.
    pub fn inward(&self, vector: [f32; 3]) -> [f32; 3] {
        self.basis.map(|b| dot(b, vector))
    }

    /// The vector of such components.
    pub fn outward(&self, components: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = self.basis;
        plus(plus(scaled(a, components[0]), components[1], b), components[2], c)
    }

    /// Part of a vector that is determined with its sign.
    pub fn determined_part(&self, vector: [f32; 3]) -> [f32; 3] {
        let mut components = self.inward(vector);
        components.iter_mut().skip(self.determined).for_each(|component| *component = 0.0);
        self.outward(components)
    }

    /// The symmetric matrix whose elements in this frame are given.
    pub fn outward_matrix(&self, components: &Matrix) -> Matrix {
        let half = components.map(|row| self.outward(row));
        // Columns stand as rows: it is symmetric.
        [0, 1, 2].map(|j| self.outward(half.map(|row| row[j])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_plane_and_space_are_distinguished() {
        let (s, c) = (0.6, 0.8);
        let line = HeadFrame::new([[s, 0.0, c], [-s, 0.0, -c]].into_iter());
        let plane = HeadFrame::new([[1.0, 0.0, 0.0], [-0.5, 0.866, 0.0], [-0.5, -0.866, 0.0]].into_iter());
        let space = HeadFrame::new([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, s, c]].into_iter());
        assert_eq!([line, plane, space].map(|f| (f.determined(), f.unknowns())), [(1, 2), (2, 3), (3, 3)]);
        for frame in [line, plane, space] {
            let there = frame.inward([1.0, -2.0, 3.0]);
            let back = frame.outward(there);
            assert!((0..3).all(|k| (back[k] - [1.0, -2.0, 3.0][k]).abs() < 1e-6), "{frame:?}");
        }
        assert!((line.inward([s, 0.0, c])[0] - 1.0).abs() < 1e-6);
    }
}
