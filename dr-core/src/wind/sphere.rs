//! The parts of heads whose geometry is known: four tetrahedral sectors, and two hemispheres.
//!
//! A sector is all that is nearer to its axis than to the other three. The means are integrals over
//! it (a hemisphere's are ∫₀¹ P_n dx); the tests integrate them again.

use super::nusselt::ORDERS;
use super::surface::SurfaceConfig;
use core::f32::consts::PI;

/// Number of tetrahedral sectors of a sphere.
pub const SECTORS: usize = 4;

const SECTOR_MEANS: [f32; ORDERS - 1] = [0.744_857_3, 0.367_552_6, 0.045_537_736, -0.108_904_47, -0.100_742_32];
const SECTOR_THREEFOLD: [f32; 3] = [0.002_683_336_9, 0.001_283_451_5, 0.000_364_693_04];
const SECTOR_AXES: [[f32; 3]; SECTORS] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

const HEMISPHERE_MEANS: [f32; ORDERS - 1] = [0.5, 0.0, -0.125, 0.0, 0.0625];

/// Four sectors about the axes (1,1,1), (1,−1,−1), (−1,1,−1), (−1,−1,1).
pub fn tetrahedral_sectors(diameter_m: f32) -> [SurfaceConfig; SECTORS] {
    core::array::from_fn(|i| SurfaceConfig {
        axis: SECTOR_AXES[i],
        // A corner of a sector is opposite to the axis of another.
        corner: SECTOR_AXES[(i + 1) % SECTORS].map(|x| -x),
        area_m2: PI * diameter_m * diameter_m / SECTORS as f32,
        means: SECTOR_MEANS,
        threefold: SECTOR_THREEFOLD,
    })
}

/// Two hemispheres, about (1,0,0) and (−1,0,0).
pub fn hemispheres(diameter_m: f32) -> [SurfaceConfig; 2] {
    [1.0, -1.0].map(|x| SurfaceConfig {
        axis: [x, 0.0, 0.0],
        corner: [0.0, 0.0, 1.0],
        area_m2: PI * diameter_m * diameter_m / 2.0,
        means: HEMISPHERE_MEANS,
        threefold: [0.0; 3],
    })
}
