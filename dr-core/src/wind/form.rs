//! Kind of body that the surfaces of a head belong to: which winds they tell apart, and how the
//! Nusselt number of each depends on where the wind comes from.
//!
//! | form | surfaces | Nu of a surface | determined |
//! |---|---|---|---|
//! | sphere | parts of it, axes outward | Σ a_n h_n P_n(n·w) | all, with axes in all directions |
//! | cube | the same of fourfold symmetry: six parts, as the faces of a cube | the same | all |
//! | cylinder | parts of its circumference, axes outward | Σ a_n h_n cos nφ | speed and angle about it |
//! | wires | wires or films in a plane, axes across them towards the wind | Σ a_n h_n cos 2nφ | speed, and the angle on the side where the axes are |
//! | single | one element | a_0 | speed |
//!
//! w is where the wind comes from, n the axis of the surface, φ the angle between the two about the
//! axis of the body. cos nφ is the Chebyshev polynomial T_n(cos φ): a cylinder is a sphere with
//! other polynomials, and a wire, whose two sides are alike, a cylinder of twice the angle.
//! The `corner` of a surface of a cylinder is along the axis of the body, that of a wire across the
//! plane of the wires.

use crate::room::room;
use core::ops::RangeInclusive;

/// Most surfaces of a head on a board.
pub const BOARD_SURFACES: usize = 8;
/// Most surfaces of a head.
pub const MOST_SURFACES: usize = room(BOARD_SURFACES, 32);

/// Kind of the body that the surfaces belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum HeadForm {
    /// Parts of a sphere.
    #[default]
    Sphere,
    /// Parts of the circumference of a cylinder.
    Cylinder,
    /// Wires or films in a plane.
    Wires,
    /// One element, whatever it is.
    Single,
    /// Parts of a sphere with fourfold symmetry.
    Cube,
}

impl HeadForm {
    /// Nusselt number in quiescent gas: exact of a sphere, else the limit of Kramers' law (Physica
    /// 12 (1946) 61) for gases.
    pub const fn nusselt_at_rest(self) -> f32 {
        match self {
            Self::Sphere | Self::Cube => 2.0,
            Self::Cylinder | Self::Wires | Self::Single => 0.39,
        }
    }

    /// Components of a wind that some head of this form determines, the size of what is across its
    /// axes included.
    pub const fn dimensions(self) -> usize {
        match self {
            Self::Sphere | Self::Cube => 3,
            Self::Cylinder | Self::Wires => 2,
            Self::Single => 1,
        }
    }

    /// Tells whether the surfaces are parts of a sphere.
    pub const fn is_sphere(self) -> bool {
        self.dimensions() == 3
    }

    /// Number of its surfaces.
    pub const fn surfaces(self) -> RangeInclusive<usize> {
        match self {
            Self::Single => 1..=1,
            Self::Sphere | Self::Cube | Self::Cylinder | Self::Wires => 2..=MOST_SURFACES,
        }
    }
}

crate::fields::fields!(enum HeadForm { 0 Sphere, 1 Cylinder, 2 Wires, 3 Single, 4 Cube });
