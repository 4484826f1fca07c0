//! Mounting of the head: the turn R from the tunnel's frame into the head's, and the small turns by
//! which it is improved.
//!
//! ```text
//! R ← exp([T δ]×) R     T: 3 × 3 identity; 3 × 2 across the axis of a head that has only one;
//!                       3 × 1 along the axis of a cylinder; 3 × 0 of a single element
//! ```
//!
//! A turn about the only axis of two hemispheres changes nothing that they measure; of all R with
//! the same axis the smallest is given.

use dr_core::wind::{HeadForm, NusseltSurface};
use nalgebra::{DMatrix, Rotation3, Unit, Vector3};

/// Sine below which axes lie on one line, as in dr-core's `frame`.
const LEAST_SINE: f64 = 0.1;

/// Turn of a head in the tunnel.
#[derive(Debug, Clone)]
pub struct Mounting {
    /// R, from the tunnel's frame into the head's.
    pub rotation: Rotation3<f64>,
    /// T
    pub turns: DMatrix<f64>,
    only_axis: Option<Vector3<f64>>,
}

impl Mounting {
    /// Mounting as drawn: both frames the same.
    pub fn drawn(form: HeadForm, surfaces: &[NusseltSurface]) -> Self {
        let rotation = Rotation3::identity();
        match form {
            HeadForm::Sphere | HeadForm::Cube => {}
            HeadForm::Cylinder | HeadForm::Wires => {
                let corner = surfaces[0].corner();
                let turns = DMatrix::from_fn(3, 1, |i, _| f64::from(corner[i]));
                return Self { rotation, turns, only_axis: None };
            }
            HeadForm::Single => return Self { rotation, turns: DMatrix::zeros(3, 0), only_axis: None },
        }
        let axes: Vec<Vector3<f64>> =
            surfaces.iter().map(|surface| Vector3::from(surface.axis().map(f64::from))).collect();
        let on_one_line = axes.iter().all(|axis| axis.cross(&axes[0]).norm() < LEAST_SINE);
        let only_axis = on_one_line.then(|| axes[0].normalize());
        let turns = match only_axis {
            Some(axis) => {
                // The unit vector that is most across.
                let across = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
                let columns = [across, axis.cross(&across)];
                DMatrix::from_fn(3, 2, |i, k| columns[k][i])
            }
            None => DMatrix::identity(3, 3),
        };
        Self { rotation, turns, only_axis }
    }

    /// The mounting after one more small turn, rad about the columns of T.
    pub fn turned(&self, small: &[f64]) -> Self {
        let turn: Vector3<f64> =
            (0..small.len()).fold(Vector3::zeros(), |sum, k| sum + self.turns.fixed_view::<3, 1>(0, k) * small[k]);
        Self { rotation: Rotation3::new(turn) * self.rotation, ..self.clone() }
    }

    /// Into the head's frame.
    pub fn inward(&self, tunnel: [f64; 3]) -> Vector3<f64> {
        self.rotation * Vector3::from(tunnel)
    }

    /// Into the tunnel's frame.
    pub fn outward(&self, head: [f32; 3]) -> [f64; 3] {
        (self.rotation.inverse() * Vector3::from(head.map(f64::from))).into()
    }

    /// Without a turn about the only axis.
    pub fn smallest(&self) -> Self {
        let Some(axis) = self.only_axis else { return self.clone() };
        let seen = self.rotation.inverse() * axis;
        let rotation = Rotation3::rotation_between(&seen, &axis).unwrap_or_else(|| {
            // Turned right round, about anything across.
            let across: Vector3<f64> = self.turns.fixed_view::<3, 1>(0, 0).into();
            Rotation3::from_axis_angle(&Unit::new_normalize(across), std::f64::consts::PI)
        });
        Self { rotation, ..self.clone() }
    }

    /// Axis times angle, rad.
    pub fn vector(&self) -> [f64; 3] {
        self.rotation.scaled_axis().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::wind::sphere::{hemispheres, tetrahedral_sectors};

    fn surfaces(configs: &[dr_core::wind::SurfaceConfig]) -> Vec<NusseltSurface> {
        configs.iter().map(|config| NusseltSurface::new(HeadForm::Sphere, config).unwrap()).collect()
    }

    #[test]
    fn a_head_with_one_axis_has_two_turns_and_no_twist() {
        let mounting = Mounting::drawn(HeadForm::Sphere, &surfaces(&hemispheres(0.01)));
        assert_eq!(mounting.turns.ncols(), 2);
        let turned = mounting.turned(&[0.2, 0.0]).turned(&[0.0, 0.3]).turned(&[-0.1, 0.1]);
        let smallest = turned.smallest();
        assert!(
            (Vector3::from(turned.outward([1.0, 0.0, 0.0])) - Vector3::from(smallest.outward([1.0, 0.0, 0.0]))).norm()
                < 1e-14
        );
        assert!(smallest.vector()[0].abs() < 1e-14 && turned.vector()[0].abs() > 1e-3);
    }

    #[test]
    fn turns_of_sectors_are_about_the_axes_of_the_head() {
        let mounting =
            Mounting::drawn(HeadForm::Sphere, &surfaces(&tetrahedral_sectors(0.01))).turned(&[0.0, 0.0, 0.1]);
        let inward = mounting.inward([1.0, 0.0, 0.0]);
        assert!((inward - Vector3::new(libm::cos(0.1), libm::sin(0.1), 0.0)).norm() < 1e-15);
    }
}
