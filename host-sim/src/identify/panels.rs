//! Rows of the regression in panels of four columns, and their products.
//!
//! ```text
//! AᵀA = Σ_n a_n a_nᵀ,     tile (p, q) = Σ_n (columns 4p … 4p+3 of row n)ᵀ (columns 4q … 4q+3),     p ≤ q
//! ```
//!
//! Four values of f64 are one register of an x86-64-v3 machine. Sums run from row to row in every lane by itself, with a rounding
//! after each product and each sum, so that every machine gives the same bits, whatever its vectors.

use pulp::{Simd, WithSimd};

/// Columns of a panel.
pub const LANES: usize = 4;

/// Rows of a panel: two or three panels, with which a sum is busy, fit in the fastest cache.
pub const BATCH: usize = 128;

pub type Lanes = [f64; LANES];
pub type Panel = [Lanes; BATCH];
pub type Tile = [Lanes; LANES];

/// Panels that `width` columns take.
pub fn panels(width: usize) -> usize {
    width.div_ceil(LANES)
}

/// The tiles of `count` panels, on and above the diagonal.
pub fn tiles(count: usize) -> usize {
    count * (count + 1) / 2
}

/// Adds the products of the first `rows` rows to the tiles, which stand in the order (0, 0), (0, 1) … (1, 1), (1, 2) ….
pub fn add_products(panels: &[Panel], rows: usize, tiles: &mut [Tile]) {
    pulp::Arch::new().dispatch(Products { panels, rows, tiles });
}

struct Products<'a> {
    panels: &'a [Panel],
    rows: usize,
    tiles: &'a mut [Tile],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut rest = self.tiles;
        for (p, left) in self.panels.iter().enumerate() {
            let (row, below) = rest.split_at_mut(self.panels.len() - p);
            rest = below;
            // Two tiles at a time: eight registers of sums hide the time that an addition takes.
            let (pairs, single) = self.panels[p..].as_chunks::<2>();
            let (pair_tiles, single_tile) = row.as_chunks_mut::<2>();
            for (right, tiles) in pairs.iter().zip(pair_tiles) {
                multiply(left, right, self.rows, tiles);
            }
            if let ([right], [tile]) = (single, single_tile) {
                multiply(left, std::array::from_ref(right), self.rows, std::array::from_mut(tile));
            }
        }
    }
}

/// Written out lane by lane: so it becomes vector instructions.
#[inline(always)]
fn multiply<const Q: usize>(left: &Panel, right: &[Panel; Q], rows: usize, tiles: &mut [Tile; Q]) {
    let mut sums = [[[0.0; LANES]; LANES]; Q];
    for n in 0..rows.min(BATCH) {
        let a = left[n];
        for q in 0..Q {
            let (b, s) = (right[q][n], sums[q]);
            sums[q] = [add(s[0], a[0], b), add(s[1], a[1], b), add(s[2], a[2], b), add(s[3], a[3], b)];
        }
    }
    for (tile, sum) in tiles.iter_mut().zip(sums) {
        for (total, part) in tile.as_flattened_mut().iter_mut().zip(sum.as_flattened()) {
            *total += part;
        }
    }
}

#[inline(always)]
fn add(sum: Lanes, a: f64, b: Lanes) -> Lanes {
    [sum[0] + a * b[0], sum[1] + a * b[1], sum[2] + a * b[2], sum[3] + a * b[3]]
}
